//! The two models check each other only as long as neither uses the other: read from their sources.

use std::fs;
use std::path::{Path, PathBuf};

fn sources(directory: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/core/src").join(directory)];
    while let Some(directory) = open.pop() {
        for entry in fs::read_dir(&directory).unwrap_or_else(|error| panic!("{}: {error}", directory.display())) {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => open.push(path),
                false => found.push(path),
            }
        }
    }
    assert!(!found.is_empty(), "crates/core/src/{directory} has no sources");
    found
}

/// Code without comments, so that documentation may speak of the other model.
fn code(path: &Path) -> String {
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
    let below = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/core/src").join(directory));
    let below = below.expect("a source of the directory");
    below.components().count() - usize::from(below.ends_with("mod.rs"))
}

fn check(directory: &str, allowed: &[&str], foreign: &[&str]) {
    for path in sources(directory) {
        let text = code(&path);
        for module in modules(&text, depth(&path, directory)) {
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

/// Shared: the scene, lengths and masses, the scalar laws, and plain numerics. The integrator belongs to the analytic model;
/// of it, the engine takes the clock alone.
#[test]
fn the_engine_uses_nothing_of_the_analytic_model() {
    check("engine", &["scene", "gripper", "law", "numeric", "integrator"], &["analytic", "Rodas", "Radau"]);
    for path in sources("engine") {
        for line in code(&path).lines().filter(|line| line.contains("integrator")) {
            assert_eq!(line.trim(), "use crate::integrator::Clock;", "{}", path.display());
        }
    }
}

/// The five-bar belongs to the analytic model, for all that sizing and statics stand on it too.
#[test]
fn the_analytic_model_uses_nothing_of_the_engine() {
    check("analytic", &["scene", "gripper", "fivebar", "law", "numeric", "integrator"], &["rapier", "parry", "engine"]);
    check("fivebar", &["gripper", "numeric"], &["rapier", "parry", "engine"]);
    check("sizing", &["gripper", "fivebar", "numeric", "sizing"], &["rapier", "parry", "engine", "scene"]);
    check("integrator", &["numeric"], &["rapier", "parry", "engine", "gripper", "scene"]);
}

/// The check itself: it must see through braces, paths and comments.
#[test]
fn the_reader_finds_what_it_looks_for() {
    let text = "use crate::{law, analytic::Model};\nlet x = crate::engine::build();\n";
    assert_eq!(modules(text, 1), ["law", "analytic", "engine"]);
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
