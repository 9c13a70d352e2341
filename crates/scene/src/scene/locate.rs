//! Positions of problems in machine-readable form: file, line, column and field.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::SceneError;
use super::error::{line_column, shortened};

/// A problem with its position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LocatedProblem {
    pub file: String,
    /// Line number, from 1; `None` if something is missing.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// The field concerned, such as `contact.friction.mu_static`; `None` outside fields, or if the text is not TOML.
    pub field: Option<String>,
    /// The problem.
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
            let to_located = |problem: &super::Problem| {
                let start = problem.span.as_ref().map(|span| span.start);
                let (line, column) = start.map(|start| line_column(text, start)).unzip();
                let entry = document.as_ref().zip(start).and_then(|(document, at)| entry_at(document.get_ref(), at));
                let field = entry.map(|(path, ..)| path.join("."));
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

/// Returns path, key and value of the innermost field whose key or value contains a byte offset of the text.
pub(crate) fn entry_at(table: &DeTable<'_>, offset: usize) -> Option<(Vec<String>, Range<usize>, Range<usize>)> {
    table.iter().find_map(|(key, value)| {
        let inner = match value.get_ref() {
            DeValue::Table(inner) => entry_at(inner, offset),
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

/// Returns the positions of the key and the value at a path.
pub fn entry(table: &DeTable<'_>, path: &[String]) -> Option<(Range<usize>, Range<usize>)> {
    let (first, rest) = path.split_first()?;
    let (key, value) = table.get_key_value(first.as_str())?;
    match (rest, value.get_ref()) {
        ([], _) => Some((key.span(), value.span())),
        (_, DeValue::Table(inner)) => entry(inner, rest),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Layer, parse_any, parse_layers};

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
        let error = parse_layers(&files, &settings, parse_any).expect_err("negative");
        let found = locate_problems(&error).remove(0);
        assert_eq!((found.file.as_str(), found.line, found.column), ("set", Some(1), Some(30)));
        assert_eq!(found.field.as_deref(), Some("contact.friction.mu_static"));
        // A table in place of a value of the file.
        let settings = [Layer { file: "set".into(), text: "duration = {}".into() }];
        let found = locate_problems(&parse_layers(&files, &settings, parse_any).expect_err("a table")).remove(0);
        assert_eq!((found.file.as_str(), found.line, found.column), ("set", Some(1), Some(1)));
    }
}
