//! Source files have no import cycles. Items that two files share belong in a third one.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::independence::{code_without_comments, source_files};

/// Module path of a source file, from the root of its crate.
pub type Module = Vec<String>;

/// An imported path, and whether it is re-exported.
struct Import {
    path: Vec<String>,
    is_public: bool,
}

/// Modules under a root with their imports and their code without comments.
pub struct SourceTree {
    imports: BTreeMap<Module, Vec<Import>>,
    pub code: BTreeMap<Module, String>,
}

fn segments(path: &str) -> Vec<String> {
    path.split("::").map(str::trim).filter(|name| !name.is_empty()).map(String::from).collect()
}

/// Returns all paths of a use tree.
fn paths_of_tree(use_tree: &str) -> Vec<Vec<String>> {
    let mut tree = use_tree.to_string();
    // Expands the innermost braces first.
    while let Some((open, close)) = tree.find('}').and_then(|close| Some((tree[..close].rfind('{')?, close))) {
        let start = tree[..open].rfind(['{', ',']).map_or(0, |at| at + 1);
        let items = tree[open + 1..close].split(',').filter(|item| !item.trim().is_empty());
        let expanded: Vec<String> = items.map(|item| tree[start..open].to_string() + item.trim()).collect();
        tree.replace_range(start..=close, &expanded.join(","));
    }
    tree.split(',').map(|path| segments(path.split(" as ").next().unwrap_or(path))).collect()
}

/// Returns the imports of the `use` statements. Each statement must begin on a new line.
fn imports(text: &str) -> Vec<Import> {
    let mut collected = Vec::new();
    let mut statement: Option<(String, bool)> = None;
    for line in text.lines() {
        let trimmed = line.trim();
        let start_of_use =
            trimmed.split_once("use ").filter(|(before, _)| before.is_empty() || before.starts_with("pub"));
        if let (None, Some((before, rest))) = (&statement, start_of_use) {
            statement = Some((rest.to_string(), !before.is_empty()));
        } else if let Some((partial, _)) = &mut statement {
            partial.push_str(trimmed);
        }
        if let Some((complete, is_public)) = statement.take_if(|(complete, _)| complete.ends_with(';')) {
            let paths = paths_of_tree(complete.trim_end_matches(';')).into_iter();
            collected.extend(paths.map(|path| Import { path, is_public }));
        }
    }
    collected
}

/// Returns the paths that begin with `super` or `crate`.
fn qualified_paths(text: &str) -> Vec<Vec<String>> {
    let mut paths = Vec::new();
    for start in ["super::", "crate::"] {
        for (at, _) in text.match_indices(start).filter(|(at, _)| !text[..*at].ends_with("::")) {
            let end =
                text[at..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(text.len() - at);
            paths.push(segments(&text[at..at + end]));
        }
    }
    paths
}

impl SourceTree {
    /// Reads all files under a root, without their tests.
    pub fn read(root: &str) -> Self {
        let mut source_tree = SourceTree { imports: BTreeMap::new(), code: BTreeMap::new() };
        let (parent, last) = root.rsplit_once('/').unwrap_or(("", root));
        let base = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
        for path in source_files(parent, last).into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
            let relative = path.strip_prefix(&base).expect("under the root").with_extension("");
            let mut module: Module = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            module.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
            let text =
                code_without_comments(&path).split("\n#[cfg(test)]\nmod tests").next().unwrap_or_default().to_string();
            source_tree.imports.insert(module.clone(), imports(&text));
            source_tree.code.insert(module, text);
        }
        source_tree
    }

    /// Returns the path from the root of the crate; `None` if it leads to another crate.
    fn resolve(&self, module: &Module, path: &[String]) -> Option<Module> {
        let (first, rest) = path.split_first()?;
        let append = |base: &[String], rest: &[String]| Some([base, rest].concat());
        match first.as_str() {
            "crate" => append(&[], rest),
            "self" => append(module, rest),
            "super" => {
                let levels_up = path.iter().take_while(|name| *name == "super").count();
                append(&module[..module.len().checked_sub(levels_up)?], &path[levels_up..])
            }
            _ => Some([module.as_slice(), path].concat())
                .filter(|_| self.imports.contains_key(&[module.as_slice(), std::slice::from_ref(first)].concat())),
        }
    }

    /// Returns the file that defines the item of a path, through all re-exports.
    fn defining_module(&self, path: &[String], depth: usize) -> Option<Module> {
        let module =
            (0..=path.len()).rev().map(|k| path[..k].to_vec()).find(|module| self.imports.contains_key(module))?;
        let re_exported = path.get(module.len()).filter(|_| depth < 6).and_then(|name| {
            let export =
                self.imports[&module].iter().filter(|export| export.is_public && export.path.last() == Some(name));
            export.filter_map(|export| self.defining_module(&self.resolve(&module, &export.path)?, depth + 1)).next()
        });
        Some(re_exported.unwrap_or(module))
    }

    /// Returns the paths in a file, from `use` statements and code.
    fn paths(&self, module: &Module, with_re_exports: bool) -> Vec<Vec<String>> {
        let imports = self.imports[module].iter().filter(|used| with_re_exports || !used.is_public);
        let imported = imports.map(|used| used.path.clone());
        imported.chain(qualified_paths(&without_imports(&self.code[module]))).collect()
    }

    /// Returns the top-level modules of the crate that each file uses, each with the top-level module of the file.
    /// Modules re-exported from another crate count.
    pub fn used_layers(&self) -> Vec<(String, String)> {
        let used_by = |module: &Module| {
            let resolved = self.paths(module, true).into_iter().filter_map(|path| self.resolve(module, &path));
            let layer = module.first().cloned().unwrap_or_default();
            let used = resolved.filter_map(|path| {
                let defining_module = self.defining_module(&path, 0).filter(|module| !module.is_empty());
                defining_module.unwrap_or(path).first().cloned()
            });
            used.map(move |used| (layer.clone(), used)).collect::<Vec<_>>()
        };
        self.imports.keys().flat_map(used_by).filter(|(layer, used)| layer != used).collect()
    }

    /// Returns the files that each file uses.
    fn dependencies(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let dependencies_of = |module: &Module| {
            let used = self.paths(module, false).into_iter();
            let targets = used.filter_map(|path| self.defining_module(&self.resolve(module, &path)?, 0));
            (module.clone(), targets.filter(|defining_module| defining_module != module).collect())
        };
        self.imports.keys().map(dependencies_of).collect()
    }
}

/// Returns the code without `use` statements.
fn without_imports(text: &str) -> String {
    let mut in_import = false;
    let is_kept = |line: &&str| {
        let trimmed = line.trim();
        in_import |= trimmed.starts_with("use ") || trimmed.starts_with("pub") && trimmed.contains("use ");
        let is_code = !in_import;
        in_import &= !trimmed.ends_with(';');
        is_code
    };
    text.lines().filter(is_kept).collect::<Vec<_>>().join("\n")
}

/// Returns the modules of all cycles of the dependency graph: those that use another one of them and are used by one.
fn modules_in_cycles(mut dependencies: BTreeMap<Module, BTreeSet<Module>>) -> Vec<Module> {
    loop {
        let count = dependencies.len();
        let used: BTreeSet<Module> = dependencies.values().flatten().cloned().collect();
        let known: BTreeSet<Module> = dependencies.keys().cloned().collect();
        dependencies.retain(|module, uses| used.contains(module) && !uses.is_disjoint(&known));
        if dependencies.len() == count {
            return dependencies.into_keys().collect();
        }
    }
}

#[test]
fn source_files_have_no_import_cycles() {
    for (root, min_dependencies) in [
        ("crates/mechanics/src", 40),
        ("crates/integrator/src", 30),
        ("crates/scene/src", 120),
        ("crates/core/src", 200),
        ("crates/show/src", 60),
        ("crates/log/src", 30),
        ("crates/thesis/src", 40),
        ("src", 150),
    ] {
        let dependencies = SourceTree::read(root).dependencies();
        assert!(
            dependencies.values().map(BTreeSet::len).sum::<usize>() > min_dependencies,
            "{root}: too few dependencies are found"
        );
        let modules: Vec<_> = modules_in_cycles(dependencies).iter().map(|module| module.join("/")).collect();
        assert!(modules.is_empty(), "{root}: cycles of {modules:?}; move the shared items to another file");
    }
}

/// Cycles are found through use trees, re-exports and paths in code.
#[test]
fn detects_import_cycles() {
    let source_tree = |sources: &[(&str, &str)]| {
        let module = |name: &str| segments(&name.replace('/', "::"));
        SourceTree {
            imports: sources.iter().map(|(name, text)| (module(name), imports(text))).collect(),
            code: sources.iter().map(|(name, text)| (module(name), text.to_string())).collect(),
        }
    };
    let root = ("", "mod area;");
    let module_file = ("area", "mod a;\nmod b;\npub use a::{Law, Other};\npub use b::Thing;");
    let a = ("area/a", "use super::{Thing,\n    b::More};\npub struct Law;");
    let with_import = source_tree(&[root, module_file, a, ("area/b", "use crate::area::Law;\npub struct Thing;")]);
    assert_eq!(modules_in_cycles(with_import.dependencies()).len(), 2);
    let with_path = source_tree(&[root, module_file, a, ("area/b", "pub struct Thing;\nfn x() { super::a::y() }")]);
    assert_eq!(modules_in_cycles(with_path.dependencies()).len(), 2);
    let one_way = source_tree(&[root, module_file, a, ("area/b", "use std::fmt;\npub struct Thing;")]);
    assert_eq!(modules_in_cycles(one_way.dependencies()), [[""; 0]; 0]);
}
