//! Keys a scene does not know, found by walking the document along the JSON Schema, so that all are reported at once.

use std::ops::Range;

use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use super::error::Problem;
use super::suggest::{absent, nearest};
use crate::limits::MOST_PROBLEMS;

/// What a scene may say, and what one of another kind may.
pub struct Allowed<'a> {
    pub kind: &'a str,
    pub schema: &'a Value,
    /// The other kinds, with their schemas: made only for a key that this kind has not, for each takes as long as a whole scene.
    pub others: &'a dyn Fn() -> Vec<Foreign<'a>>,
}

/// The same table in a scene of another kind.
pub type Foreign<'a> = (&'a str, &'a Value);

/// Takes out every unknown key, and every table where a value is wanted or the other way round, and says so of each.
pub fn weed(document: &mut DeTable<'_>, allowed: &Allowed) -> Vec<Problem> {
    let mut problems = Vec::new();
    walk(document, allowed.schema, allowed.others, allowed, "", &mut problems);
    problems
}

/// One table; `foreign` is the same table of every other kind of scene that has one.
fn walk<'a>(
    table: &mut DeTable<'_>,
    schema: &Value,
    foreign: &dyn Fn() -> Vec<Foreign<'a>>,
    allowed: &Allowed<'a>,
    path: &str,
    problems: &mut Vec<Problem>,
) {
    for (key, mut value) in std::mem::take(table) {
        // Nobody mends a thousand at once, and each is searched for in all that may be there.
        if problems.len() >= MOST_PROBLEMS {
            return;
        }
        let name = key.get_ref().as_ref();
        let here = join(path, name);
        let foreign = || -> Vec<Foreign<'a>> {
            foreign().into_iter().filter_map(|(kind, table)| Some((kind, child(table, name)?))).collect()
        };
        let Some(property) = child(schema, name) else {
            problems.push(match foreign().first() {
                Some((other, _)) => of_other_kind(name, path, key.span(), allowed.kind, other),
                None => unknown(name, path, key.span(), schema, allowed.schema),
            });
            continue;
        };
        let wants_table = is_table(property);
        let span = value.span();
        match (value.get_mut(), wants_table) {
            (DeValue::Table(inner), true) => walk(inner, property, &foreign, allowed, &here, problems),
            (DeValue::Array(items), false) => {
                if let Some(each) = property.get("items").filter(|each| is_table(each)) {
                    for item in items.iter_mut() {
                        if let DeValue::Table(inner) = item.get_mut() {
                            walk(inner, each, &Vec::new, allowed, &here, problems);
                        }
                    }
                }
            }
            (DeValue::Table(_), false) if property.get("items").is_some_and(is_table) => {
                problems.push(Problem {
                    span: Some(key.span()),
                    message: format!("`{here}` is one table, but there may be several of it"),
                    label: "a list of tables is wanted".into(),
                    help: format!("write its header with two pairs of brackets: [[{here}]]"),
                });
                continue;
            }
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

/// A key that would be good in a scene of another kind.
fn of_other_kind(name: &str, path: &str, span: Range<usize>, kind: &str, other_kind: &str) -> Problem {
    Problem {
        span: Some(span),
        message: format!(
            "`{}` belongs to scenes of kind \"{other_kind}\", but this one is of kind \"{kind}\"",
            join(path, name)
        ),
        label: "of another kind".into(),
        help: format!("remove it, or say kind = \"{other_kind}\" at the top of the file"),
    }
}

/// A key that its table does not have, with what was probably meant.
pub fn unknown(name: &str, path: &str, span: Range<usize>, schema: &Value, root: &Value) -> Problem {
    let message = format!("unknown key `{}` {}", name.escape_debug(), place(path));
    if let Some((why, instead)) = absent(path, name) {
        let (message, label) = (format!("{message}: {why}"), "phalanx does not have this".to_string());
        return Problem { span: Some(span), message, label, help: instead.to_string() };
    }
    let names: Vec<&str> = properties(schema).into_iter().flat_map(Map::keys).map(String::as_str).collect();
    let mut elsewhere = Vec::new();
    find(name, root, "", &mut elsewhere);
    elsewhere.sort_by_key(|path| path.matches('.').count());
    let label = match (nearest(name, &names), elsewhere.first()) {
        (_, Some(other)) => format!("this key belongs {}", place(other)),
        (Some(near), None) => format!("did you mean `{near}`?"),
        (None, None) => "not a key of a scene".to_string(),
    };
    Problem { span: Some(span), message, label, help: format!("keys {}: {}", place(path), names.join(", ")) }
}

/// Paths of all tables that have a key `name`.
fn find(name: &str, schema: &Value, path: &str, found: &mut Vec<String>) {
    if let Some(each) = named(schema) {
        find(name, each, &join(path, "NAME"), found);
    }
    let Some(properties) = properties(schema) else { return };
    if properties.contains_key(name) {
        found.push(path.to_string());
    }
    for (key, property) in properties {
        find(name, property, &join(path, key), found);
    }
}

/// What a table holds under a key, or under one element of a pair: `centre[0]`.
pub fn child<'a>(schema: &'a Value, name: &str) -> Option<&'a Value> {
    let property = |name: &str| properties(schema)?.get(name);
    let of_pair = || {
        let (pair, index) = element(name)?;
        let pair = property(pair)?;
        pair.get("items").filter(|_| pair["maxItems"].as_u64().is_some_and(|count| index < count))
    };
    property(name).or_else(of_pair).or(named(schema))
}

/// The pair and the index that `centre[0]` names.
pub fn element(key: &str) -> Option<(&str, u64)> {
    let (pair, index) = key.strip_suffix(']')?.rsplit_once('[')?;
    Some((pair, index.parse().ok()?))
}

pub fn is_table(schema: &Value) -> bool {
    properties(schema).is_some() || named(schema).is_some()
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema.get("properties")?.as_object()
}

/// What every key of a table holds whose keys are names of the user's.
fn named(schema: &Value) -> Option<&Value> {
    schema.get("additionalProperties").filter(|each| each.is_object())
}

fn place(path: &str) -> String {
    match path {
        "" => "at the top level".to_string(),
        path => format!("in [{path}]"),
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}
