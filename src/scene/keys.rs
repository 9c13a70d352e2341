//! Keys a scene does not know, found by walking the document along the JSON Schema, so that all are reported at once.

use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use super::error::Problem;
use super::suggest::nearest;

/// Takes out every unknown key, and every table where a value is wanted or the other way round, and says so of each.
pub fn weed(document: &mut DeTable<'_>, schema: &Value) -> Vec<Problem> {
    let mut problems = Vec::new();
    walk(document, schema, schema, "", &mut problems);
    problems
}

fn walk(table: &mut DeTable<'_>, schema: &Value, root: &Value, path: &str, problems: &mut Vec<Problem>) {
    let Some(properties) = properties(schema) else { return };
    for (key, mut value) in std::mem::take(table) {
        let name = key.get_ref().as_ref();
        let here = join(path, name);
        let Some(property) = properties.get(name) else {
            problems.push(unknown(name, path, key.span(), properties, root));
            continue;
        };
        let wants_table = self::properties(property).is_some();
        let span = value.span();
        match (value.get_mut(), wants_table) {
            (DeValue::Table(inner), true) => walk(inner, property, root, &here, problems),
            (DeValue::Table(_), false) => {
                problems.push(Problem {
                    span: Some(key.span()),
                    message: format!("`{here}` is a table, but must be a single value"),
                    label: "a single value is wanted".into(),
                    help: format!("write {name} = ..."),
                });
                continue;
            }
            (_, true) => {
                problems.push(Problem {
                    span: Some(span),
                    message: format!("`{here}` is a single value, but must be a table"),
                    label: "a table is wanted".into(),
                    help: format!("begin a section with [{here}] and put its keys below"),
                });
                continue;
            }
            _ => {}
        }
        table.insert(key, value);
    }
}

fn unknown(
    name: &str,
    path: &str,
    span: std::ops::Range<usize>,
    allowed: &Map<String, Value>,
    root: &Value,
) -> Problem {
    let place = |path: &str| match path {
        "" => "at the top level".to_string(),
        path => format!("in [{path}]"),
    };
    let names: Vec<&str> = allowed.keys().map(String::as_str).collect();
    let mut elsewhere = Vec::new();
    find(name, root, "", &mut elsewhere);
    elsewhere.sort_by_key(|path| path.matches('.').count());
    let label = match (nearest(name, &names), elsewhere.first()) {
        (_, Some(other)) => format!("this key belongs {}", place(other)),
        (Some(near), None) => format!("did you mean `{near}`?"),
        (None, None) => "not a key of a scene".to_string(),
    };
    Problem {
        span: Some(span),
        message: format!("unknown key `{}` {}", name.escape_debug(), place(path)),
        label,
        help: format!("keys {}: {}", place(path), names.join(", ")),
    }
}

/// Paths of all tables that have a key `name`.
fn find(name: &str, schema: &Value, path: &str, found: &mut Vec<String>) {
    let Some(properties) = properties(schema) else { return };
    if properties.contains_key(name) {
        found.push(path.to_string());
    }
    for (key, property) in properties {
        find(name, property, &join(path, key), found);
    }
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema.get("properties")?.as_object()
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}
