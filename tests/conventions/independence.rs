//! Dependencies between modules and between crates point in one direction, and the two models are independent of each
//! other. Results are identical on every platform, so modules with compared numbers must not call the mathematical
//! functions of the C library. In the core, clippy checks this.

use std::collections::BTreeSet;
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
    layers: &[
        "numeric",
        "law",
        "shape",
        "drive",
        "palm_motion",
        "mechanism",
        "gripper",
        "fivebar",
        "sizing",
        "statics",
    ],
    dependencies: &[],
};
const SCENE: CrateLayers = CrateLayers {
    root: "crates/scene/src",
    layers: &["limits", "units", "scene"],
    dependencies: &["phalanx-mechanics"],
};
const INTEGRATOR: CrateLayers = CrateLayers {
    root: "crates/integrator/src",
    layers: &[
        "layout",
        "clock",
        "linear",
        "state",
        "control",
        "stall",
        "system",
        "method",
        "interior",
        "inside_step",
        "gap_search",
        "event_location",
        "radau5",
        "rodas5p",
        "dop853",
        "error_weight",
        "step_attempts",
        "switched",
        "driver",
    ],
    dependencies: &["phalanx-mechanics"],
};
const CORE: CrateLayers = CrateLayers {
    root: "crates/core/src",
    layers: &["analytic", "engine", "trace", "drawing", "criteria", "gradient", "invariants", "check", "grasp"],
    dependencies: &["phalanx-integrator", "phalanx-scene"],
};
/// Reports and pictures; may use all of the core.
const SHOW: CrateLayers = CrateLayers {
    root: "crates/show/src",
    layers: &["format", "plot", "playback", "report", "explorer"],
    dependencies: &["phalanx-core"],
};
/// What reproduces the thesis; may use the core and its reports.
const THESIS: CrateLayers = CrateLayers {
    root: "crates/thesis/src",
    layers: &["text", "volume", "stability", "step_size", "reproduce"],
    dependencies: &["phalanx-core", "phalanx-parallel", "phalanx-show"],
};
/// The command line and its studies; may use all crates.
const SHELL: CrateLayers = CrateLayers {
    root: "src",
    layers: &[
        "files", "mjcf", "scene", "shipped", "table", "validate", "study", "format", "plot", "page", "report", "cli",
        "prelude",
    ],
    dependencies: &["phalanx-core", "phalanx-log", "phalanx-parallel", "phalanx-show", "phalanx-thesis"],
};
const CRATE_LAYERS: [CrateLayers; 7] = [MECHANICS, INTEGRATOR, SCENE, CORE, SHOW, THESIS, SHELL];

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

/// The shell depends on `thesis`, `show` and `log`, these on the core, the core on scenes and the integrator, and those on
/// mechanics. This includes the dependencies of tests.
#[test]
fn crates_depend_only_on_lower_crates() {
    let crates = CRATE_LAYERS.map(|CrateLayers { root, dependencies, .. }| (root, dependencies));
    for (root, dependencies) in crates.into_iter().chain([("crates/log/src", &["phalanx-core"][..])]) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(root).with_file_name("Cargo.toml");
        let manifest: toml::Table = fs::read_to_string(&path).expect("a manifest").parse().expect("TOML");
        let sections = ["dependencies", "dev-dependencies", "build-dependencies"];
        let tables = sections.iter().filter_map(|name| manifest.get(*name)?.as_table());
        let used: BTreeSet<&str> = tables.flatten().map(|(name, _)| name.as_str()).collect();
        let used = used.into_iter().filter(|name| name.starts_with("phalanx"));
        assert!(used.eq(dependencies.iter().copied()), "{}", path.display());
    }
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
    let allowed = ["scene", "gripper", "mechanism", "drive", "law", "numeric", "shape", "integrator"];
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
    let allowed = ["scene", "gripper", "fivebar", "drive", "law", "mechanism", "numeric", "shape", "integrator"];
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

/// Methods of `f64` that call the C library or have no specified precision.
const LIBM_METHODS: [&str; 22] = [
    "sin", "cos", "sin_cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "exp2", "ln",
    "log2", "log10", "powf", "powi", "hypot", "cbrt", "ln_1p", "exp_m1",
];

/// Returns the methods of this list that a source calls outside its tests.
fn libm_calls(text: &str) -> Vec<&'static str> {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let is_called = |name: &&str| text.contains(&format!(".{name}(")) || text.contains(&format!("f64::{name}"));
    LIBM_METHODS.into_iter().filter(is_called).collect()
}

#[test]
fn logs_and_studies_use_portable_elementary_functions() {
    for path in source_files("crates/log", "src").into_iter().chain(source_files("src", "study")) {
        let calls = libm_calls(&code_without_comments(&path));
        assert!(calls.is_empty(), "{}: {calls:?}; use phalanx::numeric::elementary instead", path.display());
    }
}

#[test]
fn detects_calls_of_libm() {
    assert_eq!(libm_calls("let a = x.sin();\nlet b = f64::ln(x);\n"), ["sin", "ln"]);
    assert_eq!(libm_calls("sin(x) + scene.log().rate\n#[cfg(test)]\nx.cos()"), [""; 0]);
}
