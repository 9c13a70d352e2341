//! A scene file as the texts of its values, by section: merged and completed without a change of notation.

use std::fmt::Write as _;

use serde_json::Value as Json;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::keys::{child_schema, join, pair_element};
use super::schema::properties;

/// The texts of all values as written, by section.
pub fn texts(table: &DeTable<'_>, source: &str) -> Table {
    let text = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
        DeValue::Table(inner) => Value::Table(texts(inner, source)),
        _ => inline(value, source).into(),
    };
    table.iter().map(|(key, value)| (key.get_ref().to_string(), text(value))).collect()
}

/// Returns a value as written, except that tables in a list, which may have headers of their own, become inline tables.
fn inline(value: &Spanned<DeValue<'_>>, source: &str) -> String {
    let list = |items: Vec<String>, [open, close]: [&str; 2]| format!("{open}{}{close}", items.join(", "));
    match value.get_ref() {
        DeValue::Table(table) => {
            let pairs =
                table.iter().map(|(key, value)| format!("{} = {}", key_text(key.get_ref()), inline(value, source)));
            list(pairs.collect(), ["{", "}"])
        }
        DeValue::Array(items) if items.iter().any(|item| matches!(item.get_ref(), DeValue::Table(_))) => {
            list(items.iter().map(|item| inline(item, source)).collect(), ["[", "]"])
        }
        _ => source[value.span()].to_string(),
    }
}

/// A key as written in a file: quoted if it has other characters than letters, digits, - and _.
fn key_text(key: &str) -> String {
    let is_bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
    if is_bare { key.to_string() } else { Value::from(key).to_string() }
}

/// Writes texts of values with the sections below, in the order of a schema.
pub(crate) fn write_texts(text: &mut String, schema: &Json, values: &Table, path: &str) {
    let order: Vec<&String> = properties(schema).into_iter().map(|(key, _)| key).collect();
    let position = |key: &str| {
        let key = pair_element(key).map_or(key, |(pair, _)| pair);
        order.iter().position(|known| *known == key).unwrap_or(order.len())
    };
    let mut entries: Vec<(&String, &Value)> = values.iter().collect();
    entries.sort_by_key(|(key, _)| position(key));
    // Writing to a string cannot fail.
    for (key, value) in &entries {
        value.as_str().into_iter().for_each(|value| _ = writeln!(text, "{} = {value}", key_text(key)));
    }
    for (key, value) in entries {
        let Value::Table(inner) = value else { continue };
        let section = join(path, &key_text(key));
        if inner.is_empty() || inner.values().any(Value::is_str) {
            let _ = write!(text, "\n[{section}]\n");
        }
        write_texts(text, child_schema(schema, key).unwrap_or(&Json::Null), inner, &section);
    }
}

/// Returns the text or the section at a path.
pub fn find<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((key, rest)) => find(table.get(key)?.as_table()?, rest),
    }
}

/// Removes a value, and its section if it is the last one; returns whether there was one.
pub fn remove(table: &mut Table, path: &str) -> bool {
    match path.split_once('.') {
        None => table.remove(path).is_some(),
        Some((key, rest)) => {
            let Some(Value::Table(inner)) = table.get_mut(key) else { return false };
            let was_there = remove(inner, rest);
            if was_there && inner.is_empty() {
                table.remove(key);
            }
            was_there
        }
    }
}
