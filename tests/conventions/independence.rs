//! Dependencies between modules and between crates point in one direction, and the two models are independent of each
//! other.

use std::fs;
use std::path::{Path, PathBuf};

use super::import_cycles::SourceTree;

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

/// Checks that a module uses only allowed ones, and contains none of the forbidden words.
fn check(root: &str, directory: &str, allowed: &[&str], forbidden_words: &[&str]) {
    let tree = SourceTree::read(root);
    for (layer, used) in tree.used_layers() {
        let is_allowed = layer != directory || allowed.contains(&used.as_str());
        assert!(is_allowed, "{root}/{directory} uses `{used}`; it may use only {allowed:?}");
    }
    for (module, text) in tree.code.iter().filter(|(module, _)| module.first().is_some_and(|first| first == directory))
    {
        for word in forbidden_words {
            assert!(!text.contains(word), "{} contains `{word}`", module.join("/"));
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
        "clock",
        "linear",
        "state",
        "control",
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
    layers: &[
        "files", "scene", "table", "validate", "study", "live", "format", "plot", "page", "report", "cli", "prelude",
    ],
    dependencies: &["phalanx_core", "phalanx_log", "phalanx_show", "phalanx_thesis"],
};
const CRATE_LAYERS: [CrateLayers; 7] = [MECHANICS, INTEGRATOR, SCENE, CORE, SHOW, THESIS, SHELL];

/// Whether `crates/show` may use a module: modules of the core and those that it re-exports.
fn is_available_to_show(layer: &str) -> bool {
    layer == "integrator" || [MECHANICS, SCENE, CORE].iter().any(|crate_layers| crate_layers.layers.contains(&layer))
}

#[test]
fn modules_depend_only_on_lower_modules() {
    for CrateLayers { root, layers, .. } in CRATE_LAYERS {
        let position = |name: &str| layers.iter().position(|layer| *layer == name);
        for (layer, used) in SourceTree::read(root).used_layers() {
            let is_above = position(&layer).zip(position(&used)).is_some_and(|(own, other)| other > own);
            assert!(!is_above, "{root}: {layer} uses {used}, which is later in the order");
        }
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
    let CrateLayers { root, layers, .. } = SHOW;
    let used_layers = SourceTree::read(root).used_layers();
    let others = used_layers.iter().filter(|(layer, used)| !layer.is_empty() && !layers.contains(&used.as_str()));
    let unavailable: Vec<_> = others.clone().filter(|(_, used)| !is_available_to_show(used)).collect();
    assert!(unavailable.is_empty(), "{unavailable:?}");
    assert!(others.count() > 20, "too few dependencies on the core are found");
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
    let allowed = ["scene", "gripper", "law", "numeric", "shape", "integrator"];
    check(CORE.root, "engine", &allowed, &["analytic", "Rodas", "Radau"]);
    for (module, text) in &SourceTree::read(CORE.root).code {
        for line in
            text.lines().filter(|line| module.first().is_some_and(|m| m == "engine") && line.contains("integrator"))
        {
            assert_eq!(line.trim(), "use crate::integrator::Clock;", "{}", module.join("/"));
        }
    }
}

/// The five-bar belongs to the analytic model, although sizing and statics use it too.
#[test]
fn the_analytic_model_does_not_depend_on_the_engine() {
    let other_model = ["rapier", "parry", "engine"];
    let allowed = ["scene", "gripper", "fivebar", "law", "numeric", "shape", "integrator"];
    check(CORE.root, "analytic", &allowed, &other_model);
    check(MECHANICS.root, "fivebar", &["gripper", "numeric", "shape"], &other_model);
    check(
        MECHANICS.root,
        "sizing",
        &["gripper", "fivebar", "numeric", "shape"],
        &["rapier", "parry", "engine", "scene"],
    );
    for layer in INTEGRATOR.layers {
        let allowed = [&["numeric"], INTEGRATOR.layers].concat();
        check(INTEGRATOR.root, layer, &allowed, &["rapier", "parry", "engine", "gripper", "scene"]);
    }
}

#[test]
fn crates_in_paths_are_found() {
    let text = "use phalanx_core::units;\nuse phalanx::scene;\nlet x = phalanx_show_n::y();\n";
    assert_eq!(used_crates(text), ["phalanx_core", "phalanx"]);
}
