//! The index of equations is what the docstrings cite. `PHALANX_BLESS=1 cargo test --test house equations` writes it anew.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = "src/docs/equations.md";
const BEGIN: &str = "<!-- equations:begin -->\n";
const END: &str = "<!-- equations:end -->";

fn sources(directory: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(directory).expect("a directory").map(|entry| entry.expect("an entry").path()).collect();
    entries.sort();
    for path in entries {
        match path.is_dir() {
            true => sources(&path, found),
            false if path.extension().is_some_and(|kind| kind == "rs") => found.push(path),
            false => {}
        }
    }
}

/// An equation number: chapter (5 for appendix B) and number.
type Number = (u32, u32);

/// The numbers that a comment cites, as `(2.8)` or `(B.3)–(B.7)`, which cites all between.
fn cited(comment: &str) -> Vec<Number> {
    let mut found: Vec<Number> = Vec::new();
    let (mut range, mut before) = (false, "");
    for (at, piece) in comment.split('(').enumerate() {
        // What stands in the brackets of a function is no equation's number.
        let called = std::mem::replace(&mut before, piece).ends_with(|c: char| c.is_alphanumeric());
        let Some((inside, after)) = piece.split_once(')').filter(|_| at > 0 && !called) else { continue };
        let number = inside.split_once('.').and_then(|(chapter, number)| {
            let chapter = if chapter == "B" { 5 } else { chapter.parse().ok().filter(|c| (1..=4).contains(c))? };
            Some((chapter, number.parse().ok().filter(|n| (1..100).contains(n))?))
        });
        if let Some((chapter, number)) = number {
            let from = match found.last() {
                Some((before, last)) if range && *before == chapter => last + 1,
                _ => number,
            };
            found.extend((from..=number).map(|number| (chapter, number)));
        }
        range = number.is_some() && after.starts_with('–');
    }
    found
}

/// The name of what a line declares.
fn declared(line: &str) -> Option<String> {
    let words: Vec<&str> = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
    let function = words.iter().position(|word| *word == "fn");
    let other = || words.iter().position(|word| ["struct", "enum", "const", "trait", "type"].contains(word));
    let at = function.or_else(other)?;
    words.get(at + 1).map(ToString::to_string)
}

/// Every equation with the items whose docstrings cite it: the file where it is the file's own, else the item.
fn index() -> BTreeMap<Number, Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for part in [
        "crates/mechanics/src",
        "crates/integrator/src",
        "crates/scene/src",
        "crates/core/src",
        "crates/show/src",
        "crates/log/src",
        "src",
    ] {
        sources(&root.join(part), &mut files);
    }
    let mut found: BTreeMap<Number, Vec<String>> = BTreeMap::new();
    for path in files {
        let text = fs::read_to_string(&path).expect("a source");
        let short = path.strip_prefix(root).expect("of this project").display().to_string();
        let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        for (at, line) in lines.iter().enumerate() {
            let place = if line.starts_with("//!") {
                format!("`{short}`")
            } else if line.starts_with("///") {
                let item = lines[at..].iter().find(|line| !line.starts_with("//") && !line.starts_with("#["));
                match item.and_then(|line| declared(line)) {
                    Some(name) => format!("`{name}` in `{short}`"),
                    None => format!("`{short}`"),
                }
            } else {
                continue;
            };
            for number in cited(line) {
                let places = found.entry(number).or_default();
                if !places.contains(&place) {
                    places.push(place.clone());
                }
            }
        }
    }
    found
}

fn table() -> String {
    let mut table = String::from("| equation | where |\n|---|---|\n");
    for ((chapter, number), places) in index() {
        let chapter = if chapter == 5 { "B".to_string() } else { chapter.to_string() };
        table.push_str(&format!("| ({chapter}.{number}) | {} |\n", places.join(", ")));
    }
    table
}

#[test]
fn the_index_is_what_the_docstrings_cite() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let text = fs::read_to_string(&page).expect("the page");
    let (head, rest) = text.split_once(BEGIN).expect("the first marker");
    let (written, tail) = rest.split_once(END).expect("the second marker");
    let table = table();
    if std::env::var_os("PHALANX_BLESS").is_some() {
        fs::write(&page, format!("{head}{BEGIN}{table}{END}{tail}")).expect("the page can be written");
        return;
    }
    assert_eq!(written, table, "{PAGE} is not what the docstrings cite: PHALANX_BLESS=1 writes it anew");
}

/// The equations that the mechanism stands on are somewhere.
#[test]
fn no_equation_of_the_mechanism_is_missing() {
    let index = index();
    for number in [
        (2, 1),
        (2, 2),
        (2, 8),
        (2, 16),
        (2, 23),
        (2, 24),
        (2, 30),
        (2, 31),
        (2, 32),
        (2, 35),
        (2, 38),
        (2, 39),
        (3, 2),
        (4, 1),
        (4, 2),
        (5, 7),
    ] {
        assert!(index.contains_key(&number), "{number:?}");
    }
}

#[test]
fn numbers_are_read_with_their_ranges() {
    assert_eq!(cited("loads (2.31), (2.32); what ejects"), [(2, 31), (2, 32)]);
    assert_eq!(cited("U of a hand (1.15)–(1.18)"), [(1, 15), (1, 16), (1, 17), (1, 18)]);
    assert_eq!(cited("(thesis (B.3) and (B.4))"), [(5, 3), (5, 4)]);
    assert_eq!(cited("sin(0.5), powf(2.2), at (1.0)"), []);
    assert_eq!(declared("pub const fn place(&self) -> f64 {"), Some("place".to_string()));
}
