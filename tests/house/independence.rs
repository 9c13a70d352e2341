//! Rooms use each other in one direction, and the two models not at all: read from their sources.

use std::fs;
use std::path::{Path, PathBuf};

fn sources(directory: &str) -> Vec<PathBuf> {
    sources_of("crates/core/src", directory)
}

/// All sources of a room, which is a directory or a single file.
pub fn sources_of(root: &str, room: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
    let single = root.join(format!("{room}.rs"));
    if single.is_file() {
        return vec![single];
    }
    let mut found = Vec::new();
    let mut open = vec![root.join(room)];
    while let Some(directory) = open.pop() {
        for entry in fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display())) {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => open.push(path),
                false => found.push(path),
            }
        }
    }
    assert!(!found.is_empty(), "{} has no {room}", root.display());
    found
}

/// Code without comments, so that documentation may speak of the other model.
pub fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Every module of this crate that a source names, as the first word after `crate::` or `phalanx::`, within braces too; `depth`: how
/// many modules deep the source is in its directory.
fn modules(text: &str, depth: usize) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let list = match rest.strip_prefix('{') {
            Some(inside) => inside.split('}').next().unwrap_or_default().to_string(),
            None => rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default().to_string(),
        };
        let names = list.split(',').map(|name| name.trim().split("::").next().unwrap_or_default().to_string());
        found.extend(names.filter(|name| !name.is_empty()));
    }
    // A path up and over: `super::super::engine` from a file of the directory, one more from a directory in it.
    let up = "super::".repeat(depth.max(1) + 1);
    for (at, _) in text.match_indices(&up) {
        let rest = &text[at + up.len()..];
        found.push(rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default().to_string());
    }
    found
}

/// How many modules deep a source is in its directory: `discs/modes.rs` two, `discs/mod.rs` one.
fn depth(path: &Path, directory: &str) -> usize {
    depth_in(path, "crates/core/src", directory)
}

fn depth_in(path: &Path, root: &str, directory: &str) -> usize {
    let Ok(below) = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join(root).join(directory)) else {
        return 0;
    };
    below.components().count() - usize::from(below.ends_with("mod.rs"))
}

fn check(directory: &str, allowed: &[&str], foreign: &[&str]) {
    check_in(CORE.root, directory, allowed, foreign);
}

fn check_in(root: &str, directory: &str, allowed: &[&str], foreign: &[&str]) {
    for path in sources_of(root, directory) {
        let text = code(&path);
        for module in modules(&text, depth_in(&path, root, directory)) {
            assert!(
                allowed.contains(&module.as_str()),
                "{} uses `{module}`: {directory} may share with the other model only {allowed:?}",
                path.display()
            );
        }
        for word in foreign {
            assert!(!text.contains(word), "{} names `{word}`", path.display());
        }
    }
}

/// Rooms of a crate: each may use those before it. What `ARCHITECTURE.md` says, in its order.
struct House {
    root: &'static str,
    rooms: &'static [&'static str],
    /// Crates that it may use, of those here.
    stands_on: &'static [&'static str],
}

const MECHANICS: House = House {
    root: "crates/mechanics/src",
    rooms: &["numeric", "law", "shape", "gripper", "fivebar", "sizing", "statics"],
    stands_on: &[],
};
const SCENE: House =
    House { root: "crates/scene/src", rooms: &["limits", "units", "scene"], stands_on: &["phalanx_mechanics"] };
const INTEGRATOR: House = House {
    root: "crates/integrator/src",
    rooms: &[
        "chatter", "clock", "counters", "linear", "state", "tableau", "control", "dense", "observer", "pace", "system",
        "landing", "method", "radau5", "rodas5p", "strain", "chosen", "driver",
    ],
    stands_on: &["phalanx_mechanics"],
};
const CORE: House = House {
    root: "crates/core/src",
    rooms: &["analytic", "engine", "trace", "drawing", "criteria", "invariants", "check", "grasp"],
    stands_on: &["phalanx_integrator", "phalanx_scene"],
};
/// What says and shows; it may use all of the core.
const SHOW: House = House {
    root: "crates/show/src",
    rooms: &["wording", "plot", "film", "report", "explorer"],
    stands_on: &["phalanx_core"],
};
/// The shell, which may use all.
const SHELL: House = House {
    root: "src",
    rooms: &["files", "scene", "table", "validate", "study", "live", "wording", "plot", "page", "report", "cli"],
    stands_on: &["phalanx_core", "phalanx_log", "phalanx_show"],
};
const HOUSES: [House; 6] = [MECHANICS, INTEGRATOR, SCENE, CORE, SHOW, SHELL];

/// All rooms from which those that show may take: the core's, and what it hands on.
fn of_the_core(room: &str) -> bool {
    room == "integrator" || [MECHANICS, SCENE, CORE].iter().any(|house| house.rooms.contains(&room))
}

/// Rooms that a room may not use, but does.
fn wrong_arrows(root: &str, order: &[&str]) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (place, room) in order.iter().enumerate() {
        for path in sources_of(root, room) {
            for used in modules(&code(&path), depth_in(&path, root, room)) {
                let later = order.iter().position(|other| *other == used).is_some_and(|other| other > place);
                let arrow = (room.to_string(), used.clone());
                if later && !found.contains(&arrow) {
                    found.push(arrow);
                }
            }
        }
    }
    found
}

#[test]
fn every_arrow_between_rooms_goes_one_way() {
    for House { root, rooms, .. } in HOUSES {
        assert_eq!(wrong_arrows(root, rooms), [], "{root}");
    }
}

const CRATES: [&str; 7] = [
    "phalanx_mechanics",
    "phalanx_integrator",
    "phalanx_scene",
    "phalanx_core",
    "phalanx_log",
    "phalanx_show",
    "phalanx",
];

/// Crates that a source names, of those here.
fn crates(text: &str) -> Vec<&'static str> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let named = |name: &&str| {
        text.match_indices(*name).any(|(at, _)| {
            let alone = !text[..at].ends_with(part) && !text[at + name.len()..].starts_with(part);
            // In texts the program has the name of its crate.
            alone && text[at + name.len()..].starts_with("::")
        })
    };
    CRATES.into_iter().filter(named).collect()
}

/// The shell stands on what shows and logs, these on the core, that on scenes and the integrator, and those on mechanics; not even a test
/// leads back.
#[test]
fn every_arrow_between_crates_goes_one_way() {
    let sources_in = |House { root, rooms, stands_on }: House| {
        let paths = rooms.iter().chain(&["lib"]).flat_map(|room| sources_of(root, room)).collect::<Vec<_>>();
        (paths, stands_on)
    };
    let logs = (sources_of("crates/log", "src"), &["phalanx_core"][..]);
    let mut found = 0;
    for (paths, stands_on) in HOUSES.into_iter().map(sources_in).chain([logs]) {
        for path in paths {
            let named = crates(&code(&path));
            found += named.len();
            assert!(named.iter().all(|name| stands_on.contains(name)), "{} uses {named:?}", path.display());
        }
    }
    assert!(found > 25, "{found} arrows");
}

/// What shows a run names rooms of its own and of the core, no others.
#[test]
fn what_shows_uses_the_core_and_itself() {
    let mut of_core = Vec::new();
    let House { root, rooms, .. } = SHOW;
    for room in rooms {
        for path in sources_of(root, room) {
            for used in modules(&code(&path), depth_in(&path, root, room)) {
                let core = of_the_core(&used);
                assert!(core || rooms.contains(&used.as_str()), "{} uses `{used}`", path.display());
                of_core.extend(core.then_some(used));
            }
        }
    }
    assert!(of_core.len() > 20, "{} arrows into the core", of_core.len());
}

/// The lists above are all rooms there are.
#[test]
fn every_room_is_in_the_order() {
    let outside = ["lib", "main", "docs", "limits"];
    for House { root, rooms: order, .. } in HOUSES {
        let mut rooms: Vec<String> = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(root))
            .expect("a directory of sources")
            .map(|entry| entry.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned())
            .filter(|room| if root == "src" { !outside.contains(&room.as_str()) } else { room != "lib" })
            .collect();
        rooms.sort();
        let mut listed = order.to_vec();
        listed.sort_unstable();
        assert_eq!(rooms, listed, "{root}");
    }
}

/// Shared: the scene, lengths and masses, the scalar laws, what a shape is, and plain numerics. The integrator belongs to the analytic model;
/// of it, the engine takes the clock alone.
#[test]
fn the_engine_uses_nothing_of_the_analytic_model() {
    check("engine", &["scene", "gripper", "law", "numeric", "shape", "integrator"], &["analytic", "Rodas", "Radau"]);
    for path in sources("engine") {
        for line in code(&path).lines().filter(|line| line.contains("integrator")) {
            assert_eq!(line.trim(), "use crate::integrator::Clock;", "{}", path.display());
        }
    }
}

/// The five-bar belongs to the analytic model, for all that sizing and statics stand on it too.
#[test]
fn the_analytic_model_uses_nothing_of_the_engine() {
    check(
        "analytic",
        &["analytic", "scene", "gripper", "fivebar", "law", "numeric", "shape", "integrator"],
        &["rapier", "parry", "engine"],
    );
    check_in(MECHANICS.root, "fivebar", &["gripper", "numeric", "shape"], &["rapier", "parry", "engine"]);
    check_in(
        MECHANICS.root,
        "sizing",
        &["gripper", "fivebar", "numeric", "shape", "sizing"],
        &["rapier", "parry", "engine", "scene"],
    );
    for room in INTEGRATOR.rooms {
        let allowed = [&["numeric"], INTEGRATOR.rooms].concat();
        check_in(INTEGRATOR.root, room, &allowed, &["rapier", "parry", "engine", "gripper", "scene"]);
    }
}

/// The check itself: it must see through braces, paths and comments.
#[test]
fn the_reader_finds_what_it_looks_for() {
    let text = "use crate::{law, analytic::Model};\nlet x = crate::engine::build();\n";
    assert_eq!(modules(text, 1), ["law", "analytic", "engine"]);
    assert_eq!(
        crates("use phalanx_core::units;\nuse phalanx::scene;\nlet x = phalanx_show_n::y();\n"),
        ["phalanx_core", "phalanx"]
    );
    let over = "use super::super::mode;\nuse super::super::super::engine;\n";
    assert_eq!(modules(over, 2), ["engine"]);
    assert_eq!(modules("use super::super::engine;\n", 1), ["engine"]);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/core/src/analytic");
    for (file, deep) in [("mod.rs", 0), ("model.rs", 1), ("discs/mod.rs", 1), ("discs/modes.rs", 2)] {
        assert_eq!(depth(&root.join(file), "analytic"), deep, "{file}");
    }
    let path = std::env::temp_dir().join(format!("phalanx-independence-{}.rs", std::process::id()));
    fs::write(&path, "// crate::analytic\nuse crate::scene;\n").unwrap();
    let read = code(&path);
    fs::remove_file(&path).unwrap();
    assert_eq!(modules(&read, 1), ["scene"]);
}
