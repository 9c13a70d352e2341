//! The index of equations matches the citations in the docstrings. `PHALANX_BLESS=1 cargo test --test conventions equations`
//! rewrites it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::independence::source_files;

const PAGE: &str = "src/docs/equations.md";
const BEGIN: &str = "<!-- equations:begin -->\n";
const END: &str = "<!-- equations:end -->";

/// An equation number: chapter (5 for appendix B) and number.
type Number = (u32, u32);

/// Returns the equation numbers in a comment, such as `(2.8)`, or `(B.3)–(B.7)` for a range.
fn cited_equations(comment: &str) -> Vec<Number> {
    let mut numbers: Vec<Number> = Vec::new();
    let (mut range, mut before) = (false, "");
    for (at, piece) in comment.split('(').enumerate() {
        // An argument of a function is not an equation number.
        let is_argument = std::mem::replace(&mut before, piece).ends_with(|c: char| c.is_alphanumeric());
        let Some((inside, after)) = piece.split_once(')').filter(|_| at > 0 && !is_argument) else { continue };
        let number = inside.split_once('.').and_then(|(chapter, number)| {
            let chapter = if chapter == "B" { 5 } else { chapter.parse().ok().filter(|c| (1..=4).contains(c))? };
            Some((chapter, number.parse().ok().filter(|n| (1..100).contains(n))?))
        });
        if let Some((chapter, number)) = number {
            let from = match numbers.last() {
                Some((before, last)) if range && *before == chapter => last + 1,
                _ => number,
            };
            numbers.extend((from..=number).map(|number| (chapter, number)));
        }
        range = number.is_some() && after.starts_with('–');
    }
    numbers
}

/// Returns the name of the item that a line declares.
fn declared_name(line: &str) -> Option<String> {
    let words: Vec<&str> = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty()).collect();
    let function_keyword = words.iter().position(|word| *word == "fn");
    let item_keyword = || words.iter().position(|word| ["struct", "enum", "const", "trait", "type"].contains(word));
    let at = function_keyword.or_else(item_keyword)?;
    words.get(at + 1).map(ToString::to_string)
}

/// Returns every equation with the items and files whose docstrings cite it.
fn equation_index() -> BTreeMap<Number, Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let crates = ["mechanics", "integrator", "scene", "core", "show", "log", "thesis"];
    let roots = crates.map(|name| format!("crates/{name}")).into_iter().chain([String::new()]);
    let files = roots.flat_map(|root| {
        let mut files = source_files(&root, "src");
        files.retain(|path| path.extension().is_some_and(|kind| kind == "rs"));
        files.sort();
        files
    });
    let mut citations: BTreeMap<Number, Vec<String>> = BTreeMap::new();
    for path in files {
        let text = fs::read_to_string(&path).expect("a source");
        let relative_path = path.strip_prefix(root).expect("within the project").display().to_string();
        let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
        for (at, line) in lines.iter().enumerate() {
            let location = if line.starts_with("//!") {
                format!("`{relative_path}`")
            } else if line.starts_with("///") {
                let item = lines[at..].iter().find(|line| !line.starts_with("//") && !line.starts_with("#["));
                match item.and_then(|line| declared_name(line)) {
                    Some(name) => format!("`{name}` in `{relative_path}`"),
                    None => format!("`{relative_path}`"),
                }
            } else {
                continue;
            };
            for number in cited_equations(line) {
                let locations = citations.entry(number).or_default();
                if !locations.contains(&location) {
                    locations.push(location.clone());
                }
            }
        }
    }
    citations
}

fn index_table() -> String {
    let mut index_table = String::from("| equation | where |\n|---|---|\n");
    for ((chapter, number), locations) in equation_index() {
        let chapter = if chapter == 5 { "B".to_string() } else { chapter.to_string() };
        index_table.push_str(&format!("| ({chapter}.{number}) | {} |\n", locations.join(", ")));
    }
    index_table
}

#[test]
fn the_index_matches_the_docstrings() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let text = fs::read_to_string(&page).expect("the page");
    let (head, rest) = text.split_once(BEGIN).expect("the first marker");
    let (written, tail) = rest.split_once(END).expect("the second marker");
    let index_table = index_table();
    if std::env::var_os("PHALANX_BLESS").is_some() {
        fs::write(&page, format!("{head}{BEGIN}{index_table}{END}{tail}")).expect("the page can be written");
        return;
    }
    assert_eq!(written, index_table, "{PAGE} does not match the docstrings: PHALANX_BLESS=1 rewrites it");
}

/// The main equations of the mechanism are cited.
#[test]
fn every_equation_of_the_mechanism_is_cited() {
    let equation_index = equation_index();
    let chapter_2 = [1, 2, 8, 16, 23, 24, 30, 31, 32, 35, 38, 39].map(|number| (2, number));
    for number in chapter_2.into_iter().chain([(3, 2), (4, 1), (4, 2), (5, 7)]) {
        assert!(equation_index.contains_key(&number), "{number:?}");
    }
}

#[test]
fn equation_numbers_and_ranges_are_parsed() {
    assert_eq!(cited_equations("loads (2.31), (2.32); ejection"), [(2, 31), (2, 32)]);
    assert_eq!(cited_equations("U of a hand (1.15)–(1.18)"), [(1, 15), (1, 16), (1, 17), (1, 18)]);
    assert_eq!(cited_equations("(thesis (B.3) and (B.4))"), [(5, 3), (5, 4)]);
    assert_eq!(cited_equations("sin(0.5), powf(2.2), at (1.0)"), []);
    assert_eq!(declared_name("pub const fn radius(&self) -> f64 {"), Some("radius".to_string()));
}
