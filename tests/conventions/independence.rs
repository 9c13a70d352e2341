//! Dependencies between modules and between crates point in one direction, and the two models are independent of each
//! other.

use std::fs;
use std::path::{Path, PathBuf};

fn core_source_files(directory: &str) -> Vec<PathBuf> {
    source_files("crates/core/src", directory)
}

/// Returns all source files of a module, which is a directory or a single file.
pub fn source_files(root: &str, module: &str) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
    let file = root.join(format!("{module}.rs"));
    if file.is_file() {
        return vec![file];
    }
    let mut sources = Vec::new();
    let mut pending = vec![root.join(module)];
    while let Some(directory) = pending.pop() {
        for entry in fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display())) {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => pending.push(path),
                false => sources.push(path),
            }
        }
    }
    assert!(!sources.is_empty(), "{} has no {module}", root.display());
    sources
}

/// Returns the code of a file without comments, because documentation may mention the other model.
pub fn code_without_comments(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Returns the top-level modules of this crate that a source uses after `crate::`, also in use trees, or through
/// `super`. `depth` is the depth of the source file in its top-level module.
fn used_modules(text: &str, depth: usize) -> Vec<String> {
    let mut modules = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let list = match rest.strip_prefix('{') {
            Some(inside) => inside.split('}').next().unwrap_or_default().to_string(),
            None => rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default().to_string(),
        };
        let names = list.split(',').map(|name| name.trim().split("::").next().unwrap_or_default().to_string());
        modules.extend(names.filter(|name| !name.is_empty()));
    }
    // Paths through the root: `super::super::engine` at depth 1, one more `super` per level.
    let up = "super::".repeat(depth.max(1) + 1);
    for (at, _) in text.match_indices(&up) {
        let rest = &text[at + up.len()..];
        modules.push(rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default().to_string());
    }
    modules
}

/// Returns the depth of a source file in its top-level module: two for `discs/modes.rs`, one for `discs/mod.rs`.
fn depth(path: &Path, directory: &str) -> usize {
    depth_in(path, "crates/core/src", directory)
}

fn depth_in(path: &Path, root: &str, directory: &str) -> usize {
    let Ok(below) = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join(root).join(directory)) else {
        return 0;
    };
    below.components().count() - usize::from(below.ends_with("mod.rs"))
}

fn check(directory: &str, allowed: &[&str], forbidden_words: &[&str]) {
    check_in(CORE.root, directory, allowed, forbidden_words);
}

fn check_in(root: &str, directory: &str, allowed: &[&str], forbidden_words: &[&str]) {
    for path in source_files(root, directory) {
        let text = code_without_comments(&path);
        for module in used_modules(&text, depth_in(&path, root, directory)) {
            assert!(
                allowed.contains(&module.as_str()),
                "{} uses `{module}`: {directory} may use only {allowed:?}",
                path.display()
            );
        }
        for word in forbidden_words {
            assert!(!text.contains(word), "{} contains `{word}`", path.display());
        }
    }
}

/// Top-level modules of a crate in the order of `ARCHITECTURE.md`; each may use those before it.
struct CrateLayers {
    root: &'static str,
    layers: &'static [&'static str],
    /// Crates of this workspace that it may use.
    dependencies: &'static [&'static str],
}

const MECHANICS: CrateLayers = CrateLayers {
    root: "crates/mechanics/src",
    layers: &["numeric", "law", "shape", "gripper", "fivebar", "sizing", "statics"],
    dependencies: &[],
};
const SCENE: CrateLayers = CrateLayers {
    root: "crates/scene/src",
    layers: &["limits", "units", "scene"],
    dependencies: &["phalanx_mechanics"],
};
const INTEGRATOR: CrateLayers = CrateLayers {
    root: "crates/integrator/src",
    layers: &[
        "chatter",
        "clock",
        "counters",
        "linear",
        "state",
        "tableau",
        "control",
        "dense",
        "observer",
        "stall",
        "system",
        "event_location",
        "method",
        "radau5",
        "rodas5p",
        "error_weight",
        "radau_or_rodas",
        "driver",
    ],
    dependencies: &["phalanx_mechanics"],
};
const CORE: CrateLayers = CrateLayers {
    root: "crates/core/src",
    layers: &["analytic", "engine", "trace", "drawing", "criteria", "invariants", "check", "grasp"],
    dependencies: &["phalanx_integrator", "phalanx_scene"],
};
/// Reports and pictures; may use all of the core.
const SHOW: CrateLayers = CrateLayers {
    root: "crates/show/src",
    layers: &["format", "plot", "playback", "report", "explorer"],
    dependencies: &["phalanx_core"],
};
/// What reproduces the thesis; may use the core and its reports.
const THESIS: CrateLayers = CrateLayers {
    root: "crates/thesis/src",
    layers: &["monitor", "text", "volume", "stability", "step_size", "reproduce"],
    dependencies: &["phalanx_core", "phalanx_show"],
};
/// The command line and its studies; may use all crates.
const SHELL: CrateLayers = CrateLayers {
    root: "src",
    layers: &["files", "scene", "table", "validate", "study", "live", "format", "plot", "page", "report", "cli"],
    dependencies: &["phalanx_core", "phalanx_log", "phalanx_show", "phalanx_thesis"],
};
const CRATE_LAYERS: [CrateLayers; 7] = [MECHANICS, INTEGRATOR, SCENE, CORE, SHOW, THESIS, SHELL];

/// Whether `crates/show` may use a module: modules of the core and those that it re-exports.
fn is_available_to_show(layer: &str) -> bool {
    layer == "integrator" || [MECHANICS, SCENE, CORE].iter().any(|crate_layers| crate_layers.layers.contains(&layer))
}

/// Returns the dependencies on modules later in the order.
fn upward_dependencies(root: &str, order: &[&str]) -> Vec<(String, String)> {
    let mut dependencies = Vec::new();
    for (index, layer) in order.iter().enumerate() {
        for path in source_files(root, layer) {
            for used in used_modules(&code_without_comments(&path), depth_in(&path, root, layer)) {
                let is_above = order.iter().position(|other| *other == used).is_some_and(|other| other > index);
                let dependency = (layer.to_string(), used.clone());
                if is_above && !dependencies.contains(&dependency) {
                    dependencies.push(dependency);
                }
            }
        }
    }
    dependencies
}

#[test]
fn modules_depend_only_on_lower_modules() {
    for CrateLayers { root, layers, .. } in CRATE_LAYERS {
        assert_eq!(upward_dependencies(root, layers), [], "{root}");
    }
}

const CRATES: [&str; 8] = [
    "phalanx_mechanics",
    "phalanx_integrator",
    "phalanx_scene",
    "phalanx_core",
    "phalanx_log",
    "phalanx_show",
    "phalanx_thesis",
    "phalanx",
];

/// Returns the crates of this workspace that a source uses.
fn used_crates(text: &str) -> Vec<&'static str> {
    let is_identifier_character = |c: char| c.is_alphanumeric() || c == '_';
    let is_named = |name: &&str| {
        text.match_indices(*name).any(|(at, _)| {
            let is_whole_word = !text[..at].ends_with(is_identifier_character)
                && !text[at + name.len()..].starts_with(is_identifier_character);
            // String literals contain the name of the program, which is that of its crate.
            is_whole_word && text[at + name.len()..].starts_with("::")
        })
    };
    CRATES.into_iter().filter(is_named).collect()
}

/// The shell depends on `thesis`, `show` and `log`, these on the core, the core on scenes and the integrator, and those on
/// mechanics. This includes the unit tests.
#[test]
fn crates_depend_only_on_lower_crates() {
    let sources_in = |CrateLayers { root, layers, dependencies }: CrateLayers| {
        let paths = layers.iter().chain(&["lib"]).flat_map(|layer| source_files(root, layer)).collect::<Vec<_>>();
        (paths, dependencies)
    };
    let logs = (source_files("crates/log", "src"), &["phalanx_core"][..]);
    let mut dependency_count = 0;
    for (paths, dependencies) in CRATE_LAYERS.into_iter().map(sources_in).chain([logs]) {
        for path in paths {
            let used = used_crates(&code_without_comments(&path));
            dependency_count += used.len();
            assert!(used.iter().all(|name| dependencies.contains(name)), "{} uses {used:?}", path.display());
        }
    }
    assert!(dependency_count > 25, "{dependency_count} dependencies");
}

/// `crates/show` uses only its own modules and those of the core.
#[test]
fn show_depends_only_on_the_core_and_itself() {
    let mut core_modules = Vec::new();
    let CrateLayers { root, layers, .. } = SHOW;
    for layer in layers {
        for path in source_files(root, layer) {
            for used in used_modules(&code_without_comments(&path), depth_in(&path, root, layer)) {
                let is_available = is_available_to_show(&used);
                assert!(is_available || layers.contains(&used.as_str()), "{} uses `{used}`", path.display());
                core_modules.extend(is_available.then_some(used));
            }
        }
    }
    assert!(core_modules.len() > 20, "{} dependencies on the core", core_modules.len());
}

/// The lists above contain all modules.
#[test]
fn every_module_is_listed() {
    let unordered = ["lib", "main", "docs", "limits"];
    for CrateLayers { root, layers: order, .. } in CRATE_LAYERS {
        let mut layers: Vec<String> = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(root))
            .expect("a directory of sources")
            .map(|entry| entry.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned())
            .filter(|layer| if root == "src" { !unordered.contains(&layer.as_str()) } else { layer != "lib" })
            .collect();
        layers.sort();
        let mut sorted_order = order.to_vec();
        sorted_order.sort_unstable();
        assert_eq!(layers, sorted_order, "{root}");
    }
}

/// The models share the scene, lengths and masses, the scalar laws, shapes, and numerics. The integrator belongs to the
/// analytic model; the engine uses only its clock.
#[test]
fn the_engine_does_not_depend_on_the_analytic_model() {
    check("engine", &["scene", "gripper", "law", "numeric", "shape", "integrator"], &["analytic", "Rodas", "Radau"]);
    for path in core_source_files("engine") {
        for line in code_without_comments(&path).lines().filter(|line| line.contains("integrator")) {
            assert_eq!(line.trim(), "use crate::integrator::Clock;", "{}", path.display());
        }
    }
}

/// The five-bar belongs to the analytic model, although sizing and statics use it too.
#[test]
fn the_analytic_model_does_not_depend_on_the_engine() {
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
    for layer in INTEGRATOR.layers {
        let allowed = [&["numeric"], INTEGRATOR.layers].concat();
        check_in(INTEGRATOR.root, layer, &allowed, &["rapier", "parry", "engine", "gripper", "scene"]);
    }
}

/// The parsers handle use trees, paths and comments.
#[test]
fn source_parsers_find_modules_and_crates() {
    let text = "use crate::{law, analytic::Model};\nlet x = crate::engine::build_world();\n";
    assert_eq!(used_modules(text, 1), ["law", "analytic", "engine"]);
    assert_eq!(
        used_crates("use phalanx_core::units;\nuse phalanx::scene;\nlet x = phalanx_show_n::y();\n"),
        ["phalanx_core", "phalanx"]
    );
    let path_text = "use super::super::mode;\nuse super::super::super::engine;\n";
    assert_eq!(used_modules(path_text, 2), ["engine"]);
    assert_eq!(used_modules("use super::super::engine;\n", 1), ["engine"]);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/core/src/analytic");
    for (file, expected_depth) in [("mod.rs", 0), ("model.rs", 1), ("discs/mod.rs", 1), ("discs/modes.rs", 2)] {
        assert_eq!(depth(&root.join(file), "analytic"), expected_depth, "{file}");
    }
    let path = std::env::temp_dir().join(format!("phalanx-independence-{}.rs", std::process::id()));
    fs::write(&path, "// crate::analytic\nuse crate::scene;\n").unwrap();
    let read = code_without_comments(&path);
    fs::remove_file(&path).unwrap();
    assert_eq!(used_modules(&read, 1), ["scene"]);
}
