//! Problems of scene files: their messages and their positions in machine-readable form.

use std::fmt::Write;
use std::ops::Range;

use toml::de::{DeTable, DeValue};

use crate::limits::{MAX_PROBLEMS, MAX_SHOWN_PROBLEMS};

/// A problem of a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Position in the file, in bytes; `None` for something that is missing.
    pub span: Option<Range<usize>>,
    /// Description of the problem.
    pub message: String,
    /// Short remark under the marked text; may be empty.
    pub label: String,
    /// What is allowed, or how to fix the problem.
    pub help: String,
}

impl Problem {
    pub fn new(
        span: Option<Range<usize>>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Problem { span, message: message.into(), label: label.into(), help: help.into() }
    }
}

/// Error while reading a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("error: cannot read scene `{}`: {reason}", one_line(file))]
    Read { file: String, reason: String },
    /// The file is a log of a run.
    #[error(
        "error: {0} is the log of a run (MCAP), not a scene\n  = help: `phalanx replay {0}` shows its contents; a scene \
         is a TOML file",
        one_line(file)
    )]
    Log { file: String },
    /// The file is not text.
    #[error(
        "error: scene is not UTF-8 text\n --> {}:{line}:{column}\n  = help: save the file as UTF-8; a scene is a TOML file",
        one_line(file)
    )]
    NotUtf8 { file: String, line: usize, column: usize },
    /// The text is not a valid scene. Problems are in the order of the file.
    #[error("{}", render_all(file, text, problems))]
    Invalid { file: String, text: String, problems: Vec<Problem> },
    /// Several texts of a merged scene have problems.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n\n"))]
    Layers(Vec<SceneError>),
}

impl SceneError {
    /// Returns the problems of a single text; empty if the text cannot be read, or if the error concerns several texts.
    pub fn problems(&self) -> &[Problem] {
        match self {
            SceneError::Invalid { problems, .. } => problems,
            _ => &[],
        }
    }
}

/// Formats the problems of a text, and their number if there are several.
fn render_all(file: &str, text: &str, problems: &[Problem]) -> String {
    let shown = problems.iter().take(MAX_SHOWN_PROBLEMS).map(|problem| shortened(&render(file, text, problem)));
    let shown = shown.collect::<Vec<_>>().join("\n\n");
    let file = one_line(file);
    let or_more = if problems.len() < MAX_PROBLEMS { "" } else { " or more" };
    match problems.len() {
        0 | 1 => shown,
        count if count > MAX_SHOWN_PROBLEMS => {
            format!("{shown}\n\n{file}: {count} problems{or_more}; the first {MAX_SHOWN_PROBLEMS} are shown")
        }
        count => format!("{shown}\n\n{file}: {count} problems"),
    }
}

/// Shortens long words and lines of a message, because a file may contain keys and values of a million characters.
pub fn shortened(text: &str) -> String {
    let shorten = |part: &str, max_length: usize| match part.char_indices().nth(max_length) {
        None => part.to_string(),
        Some(_) => {
            let (head, tail) =
                (floor_boundary(part, max_length / 2), floor_boundary(part, part.len() - max_length / 4));
            format!("{} … {}", &part[..head], &part[tail..])
        }
    };
    let line =
        |line: &str| shorten(&line.split(' ').map(|word| shorten(word, 200)).collect::<Vec<_>>().join(" "), 2000);
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// Escapes the line breaks and tabs of a text, so that a name in a report or message cannot begin a new line. Terminals
/// and pages escape other characters that they would interpret.
pub fn one_line(text: &str) -> String {
    text.replace('\n', "\\n").replace('\t', "\\t")
}

/// Maximum number of characters of a source line that are shown.
const WIDTH: usize = 120;

/// Formats a problem like rustc: message, position, source line with carets, help; without a final newline.
fn render(file: &str, text: &str, problem: &Problem) -> String {
    let [file, message, label, help] = [file, &problem.message, &problem.label, &problem.help].map(one_line);
    let mut out = format!("error: {message}");
    let Some(span) = &problem.span else {
        let _ = write!(out, "\n --> {file}");
        if !help.is_empty() {
            let _ = write!(out, "\n  = help: {help}");
        }
        return out;
    };

    let start = floor_boundary(text, span.start);
    let end = floor_boundary(text, span.end.max(start));
    let (line, column) = line_column(text, start);
    let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
    let source: Vec<char> = text[line_start..line_end].trim_end_matches('\r').chars().collect();
    let marked = text[start..end.min(line_end)].trim_end().chars().count().max(1);

    // A long line is cut such that the marked text remains visible.
    let from = (column - 1 + marked.min(WIDTH / 2)).saturating_sub(WIDTH);
    let shown: String = source.iter().skip(from).take(WIDTH).map(|c| printable(*c)).collect();
    let carets = marked.min(WIDTH.saturating_sub(column - 1 - from)).max(1);

    let number = line.to_string();
    let gutter = " ".repeat(number.len());
    let _ = write!(out, "\n{gutter}--> {file}:{line}:{column}\n{gutter} |\n{number} | {shown}");
    let _ = write!(out, "\n{gutter} | {}{}", " ".repeat(column - 1 - from), "^".repeat(carets));
    if !label.is_empty() {
        let _ = write!(out, " {label}");
    }
    if !help.is_empty() {
        let _ = write!(out, "\n{gutter} = help: {help}");
    }
    out
}

/// Returns the line and the column of a byte offset. Both are counted from 1, the column in characters.
pub fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..floor_boundary(text, offset)];
    let line = before.matches('\n').count() + 1;
    let column = before[before.rfind('\n').map_or(0, |i| i + 1)..].chars().count() + 1;
    (line, column)
}

fn floor_boundary(text: &str, offset: usize) -> usize {
    let mut boundary = offset.min(text.len());
    while !text.is_char_boundary(boundary) {
        boundary -= 1;
    }
    boundary
}

/// Replaces characters that do not take one column, so that carets are below the marked text.
fn printable(c: char) -> char {
    match c {
        '\t' => ' ',
        c if c.is_control() => '\u{fffd}',
        c => c,
    }
}

/// A problem with its position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LocatedProblem {
    pub file: String,
    /// Line number, from 1; `None` for something that is missing.
    pub line: Option<usize>,
    /// Column in characters, from 1; `None` for something that is missing.
    pub column: Option<usize>,
    /// Field that has the problem, such as `contact.friction.mu_static`; `None` outside fields, or if the text is not
    /// TOML.
    pub field: Option<String>,
    /// Description of the problem.
    pub message: String,
    /// What is allowed, or how to fix the problem.
    pub help: String,
}

impl LocatedProblem {
    fn without_position(file: &str, message: String) -> Self {
        LocatedProblem { file: file.to_string(), line: None, column: None, field: None, message, help: String::new() }
    }
}

/// Returns all problems of a scene with their positions, in the order of its texts.
pub fn locate_problems(error: &SceneError) -> Vec<LocatedProblem> {
    match error {
        SceneError::Invalid { file, text, problems } => {
            let document = DeTable::parse(text).ok();
            let to_located = |problem: &Problem| {
                let start = problem.span.as_ref().map(|span| span.start);
                let (line, column) = start.map(|start| line_column(text, start)).unzip();
                let field = document.as_ref().zip(start).and_then(|(document, at)| field_at(document.get_ref(), at));
                let (message, help) = (shortened(&problem.message), problem.help.clone());
                LocatedProblem { file: file.clone(), line, column, field, message, help }
            };
            problems.iter().map(to_located).collect()
        }
        SceneError::Layers(parts) => parts.iter().flat_map(locate_problems).collect(),
        SceneError::NotUtf8 { file, line, column } => {
            let to_located = LocatedProblem::without_position(file, error.to_string());
            vec![LocatedProblem { line: Some(*line), column: Some(*column), ..to_located }]
        }
        SceneError::Read { file, .. } | SceneError::Log { file } => {
            vec![LocatedProblem::without_position(file, error.to_string())]
        }
    }
}

/// Returns the innermost field whose key or value contains a byte offset of the text, such as `objectives[1].column`.
fn field_at(table: &DeTable<'_>, offset: usize) -> Option<String> {
    let is_in = |span: Range<usize>| span.contains(&offset) || span.start == offset;
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        let inner = match value.get_ref() {
            DeValue::Table(inner) => field_at(inner, offset).map(|field| format!("{name}.{field}")),
            DeValue::Array(items) => items.iter().enumerate().find_map(|(index, item)| {
                let field = field_at(item.get_ref().as_table()?, offset).map(|field| format!(".{field}"));
                let field = field.or_else(|| is_in(item.span()).then(String::new))?;
                Some(format!("{name}[{index}]{field}"))
            }),
            _ => None,
        };
        inner.or_else(|| (is_in(key.span()) || is_in(value.span())).then(|| name.to_string()))
    })
}

/// Returns path, key and value of the innermost field whose key or value contains a byte offset of the text.
pub(crate) fn entry_at(table: &DeTable<'_>, offset: usize) -> Option<(Vec<String>, Range<usize>, Range<usize>)> {
    table.iter().find_map(|(key, value)| {
        let inner = match value.get_ref() {
            DeValue::Table(inner) => entry_at(inner, offset),
            // A place within a list of tables is that of the list.
            DeValue::Array(items) => {
                let mut tables = items.iter().filter_map(|item| item.get_ref().as_table());
                tables.find_map(|table| entry_at(table, offset)).map(|_| (Vec::new(), key.span(), value.span()))
            }
            _ => None,
        };
        let contains_offset = |span: Range<usize>| span.contains(&offset) || span.start == offset;
        let own = || {
            let contains = contains_offset(key.span()) || contains_offset(value.span());
            contains.then(|| (Vec::new(), key.span(), value.span()))
        };
        let (mut path, key_span, value_span) = inner.or_else(own)?;
        path.insert(0, key.get_ref().to_string());
        Some((path, key_span, value_span))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Layer, parse_any, parse_layers};

    fn problem(span: Option<Range<usize>>) -> Problem {
        Problem { span, message: "wrong".into(), label: "here".into(), help: "fix it".into() }
    }

    #[test]
    fn carets_are_below_the_marked_characters() {
        let text = "a = 1\n\tµ = \"2 mm\"\r\n";
        let at = text.find('"').unwrap_or(0);
        assert_eq!(
            render("f.toml", text, &problem(Some(at..at + 6))),
            "error: wrong\n --> f.toml:2:6\n  |\n2 |  µ = \"2 mm\"\n  |      ^^^^^^ here\n  = help: fix it"
        );
        assert_eq!(render("f.toml", text, &problem(None)), "error: wrong\n --> f.toml\n  = help: fix it");
    }

    #[test]
    fn renders_any_span_of_any_text() {
        let long = format!("x = \"{}\"\n", "é".repeat(500));
        for text in ["", "\n", "é", "a\nb", &long] {
            for start in 0..text.len().min(40) + 2 {
                for end in [start, start + 1, start + 700, usize::MAX] {
                    assert!(render("f", text, &problem(Some(start..end))).contains('^'));
                }
            }
        }
        let shown = render("f", &long, &problem(Some(900..902)));
        assert!(shown.lines().all(|l| l.chars().count() < WIDTH + 20), "{shown}");
    }

    const FINGER: &str = include_str!("../../../../scenes/experiment-95.toml");

    fn position(text: &str) -> (Option<usize>, Option<usize>, Option<String>) {
        let found = locate_problems(&parse_any(text, "own.toml").expect_err("wrong")).remove(0);
        assert_eq!(found.file, "own.toml");
        assert!(!found.message.is_empty() && !found.help.is_empty());
        (found.line, found.column, found.field)
    }

    #[test]
    fn problems_have_line_column_and_field() {
        // Problems are sorted by position: the first one is on the first line.
        let wrong = "[design]\nbase = \"12 s\"\nbsae = 1\n";
        assert_eq!(position(wrong), (Some(2), Some(8), Some("design.base".to_string())));
        assert_eq!(position("[design]\nbsae = \"12 mm\"\n"), (Some(2), Some(1), Some("design.bsae".to_string())));
        // Dotted keys, and a text that is not TOML.
        assert_eq!(
            position("design.base = \"12 s\"\ndesign.bsae = 1\n"),
            (Some(1), Some(15), Some("design.base".to_string()))
        );
        let (line, _, field) = position("a = \n");
        assert_eq!((line, field), (Some(1), None));
    }

    #[test]
    fn problems_of_settings_are_located_in_the_setting() {
        let files = [Layer { file: "own.toml".into(), text: FINGER.into() }];
        let settings = [Layer { file: "set".into(), text: "contact.friction.mu_static = -1".into() }];
        let error = parse_layers(&files, &settings).expect_err("negative");
        let found = locate_problems(&error).remove(0);
        assert_eq!((found.file.as_str(), found.line, found.column), ("set", Some(1), Some(30)));
        assert_eq!(found.field.as_deref(), Some("contact.friction.mu_static"));
        // A table in place of a value of the file.
        let settings = [Layer { file: "set".into(), text: "duration = {}".into() }];
        let found = locate_problems(&parse_layers(&files, &settings).expect_err("a table")).remove(0);
        assert_eq!((found.file.as_str(), found.line, found.column), ("set", Some(1), Some(1)));
    }
}
