//! The glossary is sorted, its files exist, and each back-ticked term is defined in the file of its row.

use std::fs;
use std::path::Path;

const PAGE: &str = "src/docs/glossary.md";
const HEADER: &str = "| term | meaning | defined in |";
const MIN_TERMS: usize = 50;
/// Least number of terms that are Rust items.
const MIN_ITEMS: usize = 30;
const KEYWORDS: [&str; 8] = ["struct", "enum", "trait", "fn", "const", "type", "mod", "static"];

/// Returns the back-ticked parts of a text.
fn code_spans(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Returns the cells of a row of a Markdown table.
fn split_row(row: &str) -> Vec<&str> {
    row.trim().trim_start_matches('|').trim_end_matches('|').split('|').map(str::trim).collect()
}

/// Returns the rows of the glossary, each as its cells.
fn read_rows(page: &str) -> Vec<Vec<&str>> {
    let (_, table) = page.split_once(HEADER).unwrap_or_else(|| panic!("{PAGE} has no table `{HEADER}`"));
    // The first line after the header is the Markdown rule.
    table.lines().skip(2).take_while(|line| line.starts_with('|')).map(split_row).collect()
}

/// Whether a line declares `name` as an item.
fn declares_item(line: &str, name: &str) -> bool {
    let words: Vec<&str> = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).collect();
    words.windows(2).any(|pair| KEYWORDS.contains(&pair[0]) && pair[1] == name)
}

/// Whether a line in the body of a type declares `name` as a field or a variant.
fn declares_member(line: &str, name: &str) -> bool {
    let line = line.trim();
    let line = match line.strip_prefix("pub") {
        Some(rest) if rest.starts_with('(') => rest.split_once(')').map_or(rest, |(_, after)| after).trim_start(),
        Some(rest) if rest.starts_with(' ') => rest.trim_start(),
        _ => line,
    };
    line.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with([':', ',', '(', ' ', '=']))
}

/// Whether a source, formatted by rustfmt, defines `name` as an item, a field or a variant.
fn defines(source: &str, name: &str) -> bool {
    // Indentation of the struct or enum that contains the current line.
    let mut type_indent: Option<usize> = None;
    for line in source.lines().filter(|line| !line.trim_start().starts_with("//")) {
        if declares_item(line, name) {
            return true;
        }
        let indent = line.len() - line.trim_start().len();
        match type_indent {
            Some(start) if indent == start && line.trim_start().starts_with('}') => type_indent = None,
            Some(_) if declares_member(line, name) => return true,
            Some(_) => {}
            None => {
                let is_type = line.split_whitespace().any(|word| ["struct", "enum"].contains(&word));
                type_indent = (is_type && line.ends_with('{')).then_some(indent);
            }
        }
    }
    false
}

#[test]
fn glossary_terms_are_defined_in_their_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join(PAGE)).expect("the glossary can be read");
    let rows = read_rows(&page);
    assert!(rows.len() >= MIN_TERMS, "{PAGE} has {} terms; at least {MIN_TERMS} are required", rows.len());
    let mut items = 0;
    let mut errors = Vec::new();
    for row in &rows {
        let [term, meaning, files] = row[..] else { panic!("{PAGE}: {row:?} has {} cells instead of 3", row.len()) };
        if term.is_empty() || meaning.is_empty() {
            errors.push(format!("{term}: empty cell"));
        }
        let paths = code_spans(files);
        if paths.is_empty() {
            errors.push(format!("{term}: no file in back-ticks"));
        }
        let mut sources = Vec::new();
        for path in paths {
            match fs::read_to_string(root.join(path)) {
                Ok(source) => sources.push(source),
                Err(error) => errors.push(format!("{term}: {path}: {error}")),
            }
        }
        for name in code_spans(term) {
            items += 1;
            if !sources.iter().any(|source| defines(source, name)) {
                errors.push(format!("{term}: `{name}` is not defined in {files}"));
            }
        }
    }
    assert!(errors.is_empty(), "{PAGE}:\n{}", errors.join("\n"));
    assert!(items >= MIN_ITEMS, "{PAGE} has {items} Rust items; at least {MIN_ITEMS} are required");
}

#[test]
fn glossary_terms_are_sorted_and_unique() {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE)).expect("the glossary can be read");
    let keys: Vec<String> = read_rows(&page).iter().map(|row| row[0].replace('`', "").to_lowercase()).collect();
    for pair in keys.windows(2) {
        assert!(pair[0] < pair[1], "{PAGE}: `{}` must come after `{}`, and no term may appear twice", pair[0], pair[1]);
    }
}

#[test]
fn definitions_are_recognised() {
    let source = "/// struct Comment\npub struct Step<const N: usize> {\n    pub(super) size: f64,\n}\n\nenum End {\n    Event {\n        time: f64,\n    },\n    Other(f64),\n}\nfn size_of(free: f64) {\n    let local = 1;\n}\n";
    for name in ["Step", "size", "End", "Event", "time", "Other", "size_of"] {
        assert!(defines(source, name), "{name}");
    }
    for name in ["Comment", "siz", "free", "local", "f64"] {
        assert!(!defines(source, name), "{name}");
    }
    assert_eq!(split_row("| `a` (b) | c | `d` |"), ["`a` (b)", "c", "`d`"]);
    assert_eq!(code_spans("`a` and `b`"), ["a", "b"]);
}
