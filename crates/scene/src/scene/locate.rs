//! Where in its text a problem is, for those who do not read messages: file, line, column and field.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::SceneError;
use super::error::{line_column, shortened};

/// A problem with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Located {
    pub file: String,
    /// From 1; `None` where something is missing altogether.
    pub line: Option<usize>,
    /// Characters, from 1.
    pub column: Option<usize>,
    /// The field it is about, such as `contact.friction.mu_static`; `None` where there is none, or the text is no TOML.
    pub field: Option<String>,
    /// What was found, and why it is wrong.
    pub message: String,
    /// What is allowed, or what to do about it.
    pub help: String,
}

impl Located {
    fn of_file(file: &str, message: String) -> Self {
        Located { file: file.to_string(), line: None, column: None, field: None, message, help: String::new() }
    }
}

/// All problems of a scene with their places, in the order of its texts.
pub fn located(error: &SceneError) -> Vec<Located> {
    match error {
        SceneError::Invalid { file, text, problems } => {
            let document = DeTable::parse(text).ok();
            let place = |span: &Range<usize>| {
                let (line, column) = line_column(text, span.start);
                let field = document.as_ref().and_then(|document| field_at(document.get_ref(), span.start, ""));
                (line, column, field)
            };
            let of = |problem: &super::Problem| {
                let place = problem.span.as_ref().map(place);
                Located {
                    file: file.clone(),
                    line: place.as_ref().map(|(line, _, _)| *line),
                    column: place.as_ref().map(|(_, column, _)| *column),
                    field: place.and_then(|(_, _, field)| field),
                    message: shortened(&problem.message),
                    help: problem.help.clone(),
                }
            };
            problems.iter().map(of).collect()
        }
        SceneError::Layers(parts) => parts.iter().flat_map(located).collect(),
        SceneError::NotUtf8 { file, line, column } => {
            let of = Located::of_file(file, error.to_string());
            vec![Located { line: Some(*line), column: Some(*column), ..of }]
        }
        SceneError::Read { file, .. } | SceneError::Log { file } => vec![Located::of_file(file, error.to_string())],
    }
}

/// The innermost field whose key or value is at a byte of the text.
fn field_at(table: &DeTable<'_>, at: usize, parent: &str) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        let path = if parent.is_empty() { name.to_string() } else { format!("{parent}.{name}") };
        let inner = match value.get_ref() {
            DeValue::Table(inner) => field_at(inner, at, &path),
            _ => None,
        };
        let within = |span: Range<usize>| span.contains(&at) || span.start == at;
        inner.or_else(|| (within(key.span()) || within(value.span())).then_some(path))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Layer, parse_any, parse_layers};

    const FINGER: &str = include_str!("../../../../scenes/experiment-95.toml");

    fn place(text: &str) -> (Option<usize>, Option<usize>, Option<String>) {
        let found = located(&parse_any(text, "own.toml").expect_err("wrong")).remove(0);
        assert_eq!(found.file, "own.toml");
        assert!(!found.message.is_empty() && !found.help.is_empty());
        (found.line, found.column, found.field)
    }

    #[test]
    fn a_problem_has_its_line_column_and_field() {
        // What lacks nothing by its place alone: the first problem is that of the first line.
        let wrong = "[design]\nbase = \"12 s\"\nbsae = 1\n";
        assert_eq!(place(wrong), (Some(2), Some(8), Some("design.base".to_string())));
        assert_eq!(place("[design]\nbsae = \"12 mm\"\n"), (Some(2), Some(1), Some("design.bsae".to_string())));
        // Dotted keys, and what is not TOML at all.
        assert_eq!(
            place("design.base = \"12 s\"\ndesign.bsae = 1\n"),
            (Some(1), Some(15), Some("design.base".to_string()))
        );
        let (line, _, field) = place("a = \n");
        assert_eq!((line, field), (Some(1), None));
    }

    #[test]
    fn what_is_set_besides_has_its_own_place() {
        let files = [Layer { file: "own.toml".into(), text: FINGER.into() }];
        let settings = [Layer { file: "set".into(), text: "contact.friction.mu_static = -1".into() }];
        let error = parse_layers(&files, &settings, parse_any).expect_err("negative");
        let found = located(&error).remove(0);
        assert_eq!((found.file.as_str(), found.line, found.column), ("set", Some(1), Some(30)));
        assert_eq!(found.field.as_deref(), Some("contact.friction.mu_static"));
    }
}
