//! No file uses one that uses it, on whatever way: what two files share stands in a third.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::independence::{code, sources_of};

/// A file as a module, by the names on its way from the root.
type Module = Vec<String>;

/// One imported path, and whether it is handed on.
struct Use {
    path: Vec<String>,
    public: bool,
}

/// Modules under a root, with what each imports.
struct House {
    uses: BTreeMap<Module, Vec<Use>>,
    code: BTreeMap<Module, String>,
}

fn names(path: &str) -> Vec<String> {
    path.split("::").map(str::trim).filter(|name| !name.is_empty()).map(String::from).collect()
}

/// All paths of the tree of one `use`.
fn expand(tree: &str, before: &[String], public: bool, found: &mut Vec<Use>) {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap_or(tree);
        found.push(Use { path: [before, &names(path)].concat(), public });
        return;
    };
    let before = [before, &names(&tree[..open])].concat();
    let inner = &tree[open + 1..tree.rfind('}').unwrap_or(tree.len())];
    let (mut depth, mut from) = (0, 0);
    for (at, letter) in inner.char_indices().chain([(inner.len(), ',')]) {
        match letter {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inner[from..at].trim().is_empty() {
                    expand(&inner[from..at], &before, public, found);
                }
                from = (at + 1).min(inner.len());
            }
            _ => {}
        }
    }
}

/// Statements `use …;`, each on lines of its own.
fn uses(text: &str) -> Vec<Use> {
    let mut found = Vec::new();
    let mut statement: Option<(String, bool)> = None;
    for line in text.lines() {
        let trimmed = line.trim();
        let begun = trimmed.split_once("use ").filter(|(before, _)| before.is_empty() || before.starts_with("pub"));
        if let (None, Some((before, rest))) = (&statement, begun) {
            statement = Some((rest.to_string(), !before.is_empty()));
        } else if let Some((so_far, _)) = &mut statement {
            so_far.push_str(trimmed);
        }
        if let Some((whole, public)) = statement.take_if(|(whole, _)| whole.ends_with(';')) {
            expand(whole.trim_end_matches(';'), &[], public, &mut found);
        }
    }
    found
}

/// Paths that begin at `super` or `crate`, in code beside the statements `use`.
fn mentioned(text: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for start in ["super::", "crate::"] {
        for (at, _) in text.match_indices(start).filter(|(at, _)| !text[..*at].ends_with("::")) {
            let end =
                text[at..].find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(text.len() - at);
            found.push(names(&text[at..at + end]));
        }
    }
    found
}

impl House {
    /// All files under a root; their tests do not count.
    fn read(root: &str) -> Self {
        let mut house = House { uses: BTreeMap::new(), code: BTreeMap::new() };
        let (above, last) = root.rsplit_once('/').unwrap_or(("", root));
        let base = Path::new(env!("CARGO_MANIFEST_DIR")).join(root);
        for path in sources_of(above, last).into_iter().filter(|path| path.extension().is_some_and(|e| e == "rs")) {
            let relative = path.strip_prefix(&base).expect("under the root").with_extension("");
            let mut module: Module = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            module.pop_if(|last| ["mod", "lib", "main"].contains(&last.as_str()));
            let text = code(&path).split("\n#[cfg(test)]\nmod tests").next().unwrap_or_default().to_string();
            house.uses.insert(module.clone(), uses(&text));
            house.code.insert(module, text);
        }
        house
    }

    /// The whole way of a path that is written in a module; `None` where it leads into another crate.
    fn whole_way(&self, module: &Module, path: &[String]) -> Option<Module> {
        let (first, rest) = path.split_first()?;
        let below = |base: &[String], rest: &[String]| Some([base, rest].concat());
        match first.as_str() {
            "crate" => below(&[], rest),
            "self" => below(module, rest),
            "super" => {
                let up = path.iter().take_while(|name| *name == "super").count();
                below(&module[..module.len().checked_sub(up)?], &path[up..])
            }
            _ => Some([module.as_slice(), path].concat())
                .filter(|_| self.uses.contains_key(&[module.as_slice(), std::slice::from_ref(first)].concat())),
        }
    }

    /// The file in which what a path names is defined, through all that hand it on.
    fn home(&self, path: &[String], depth: usize) -> Option<Module> {
        let module =
            (0..=path.len()).rev().map(|k| path[..k].to_vec()).find(|module| self.uses.contains_key(module))?;
        let handed = path.get(module.len()).filter(|_| depth < 6).and_then(|name| {
            let on = self.uses[&module].iter().filter(|on| on.public && on.path.last() == Some(name));
            on.filter_map(|on| self.home(&self.whole_way(&module, &on.path)?, depth + 1)).next()
        });
        Some(handed.unwrap_or(module))
    }

    /// Which files each file uses.
    fn arrows(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let of = |(module, uses): (&Module, &Vec<Use>)| {
            let imported = uses.iter().filter(|used| !used.public).map(|used| used.path.clone());
            let used = imported.chain(mentioned(&without_uses(&self.code[module])));
            let homes = used.filter_map(|path| self.home(&self.whole_way(module, &path)?, 0));
            (module.clone(), homes.filter(|home| home != module).collect())
        };
        self.uses.iter().map(of).collect()
    }
}

/// The code without its statements `use`.
fn without_uses(text: &str) -> String {
    let mut within = false;
    let keep = |line: &&str| {
        let trimmed = line.trim();
        within |= trimmed.starts_with("use ") || trimmed.starts_with("pub") && trimmed.contains("use ");
        let kept = !within;
        within &= !trimmed.ends_with(';');
        kept
    };
    text.lines().filter(keep).collect::<Vec<_>>().join("\n")
}

/// A way from a file back to itself.
fn circle(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> Option<Vec<Module>> {
    fn walk(
        at: &Module,
        arrows: &BTreeMap<Module, BTreeSet<Module>>,
        way: &mut Vec<Module>,
        done: &mut BTreeSet<Module>,
    ) -> Option<Vec<Module>> {
        if let Some(first) = way.iter().position(|module| module == at) {
            return Some(way[first..].to_vec());
        }
        if !done.insert(at.clone()) {
            return None;
        }
        way.push(at.clone());
        let found = arrows.get(at).into_iter().flatten().find_map(|next| walk(next, arrows, way, done));
        way.pop();
        found
    }
    let mut done = BTreeSet::new();
    arrows.keys().find_map(|module| walk(module, arrows, &mut Vec::new(), &mut done))
}

#[test]
fn no_file_uses_one_that_uses_it() {
    for (root, least) in [
        ("crates/mechanics/src", 40),
        ("crates/integrator/src", 30),
        ("crates/scene/src", 150),
        ("crates/core/src", 200),
        ("crates/show/src", 60),
        ("crates/log/src", 50),
        ("src", 250),
    ] {
        let arrows = House::read(root).arrows();
        assert!(arrows.values().map(BTreeSet::len).sum::<usize>() > least, "{root}: arrows are found");
        let found = circle(&arrows).map(|way| way.iter().map(|module| module.join("/")).collect::<Vec<_>>());
        assert!(
            found.is_none(),
            "{root}: {}, and back: let what they share stand in a file of its own",
            found.unwrap_or_default().join(" → ")
        );
    }
}

/// The check itself: through braces, what is handed on, and paths in code.
#[test]
fn a_circle_is_found() {
    let house = |sources: &[(&str, &str)]| {
        let module = |name: &str| names(&name.replace('/', "::"));
        House {
            uses: sources.iter().map(|(name, text)| (module(name), uses(text))).collect(),
            code: sources.iter().map(|(name, text)| (module(name), text.to_string())).collect(),
        }
    };
    let root = ("", "mod room;");
    let face = ("room", "mod a;\nmod b;\npub use a::{Law, Other};\npub use b::Thing;");
    let a = ("room/a", "use super::{Thing,\n    b::More};\npub struct Law;");
    let to_a = house(&[root, face, a, ("room/b", "use crate::room::Law;\npub struct Thing;")]);
    assert_eq!(circle(&to_a.arrows()).expect("a circle").len(), 2);
    let in_code = house(&[root, face, a, ("room/b", "pub struct Thing;\nfn x() { super::a::y() }")]);
    assert_eq!(circle(&in_code.arrows()).expect("a circle").len(), 2);
    let one_way = house(&[root, face, a, ("room/b", "use std::fmt;\npub struct Thing;")]);
    assert_eq!(circle(&one_way.arrows()), None);
}
