//! Every field of a scene: what it is, what it may be, and what it holds.

use serde_json::{Map, Value, json};

use crate::scene::schema::schema_of;
use crate::scene::{Scene, Words, show_written};
use crate::units::{Dimension, parse, split};

/// Sections of design variables, in the order in which a designer turns to them.
const DESIGN: [&str; 5] = ["design", "motor", "spring", "object", "contact.friction"];

/// Sections that the page has no use for: its runs are the analytic model's, and it writes no log.
const UNUSED: [&str; 3] = ["engine", "validate", "log"];

/// All fields: those that hold something, and those that could.
pub fn fields(scene: &Scene) -> Value {
    let text = show_written(scene);
    let shown: toml::Table = text.parse().unwrap_or_default();
    let written: toml::Table = scene.source.parse().unwrap_or_default();
    let order = order(&text);
    let mut found = Vec::new();
    collect(schema_of(scene.kind()), "", Some(&shown), Some(&written), &mut found);
    let place = |field: &Value| order.iter().position(|path| field["path"] == **path).unwrap_or(order.len());
    found.sort_by_cached_key(place);
    let design: Vec<&Value> = DESIGN
        .iter()
        .flat_map(|section| found.iter().filter(move |field| field["section"] == *section && is_dial(field)))
        .map(|field| &field["path"])
        .collect();
    json!({
        "kind": scene.kind().word(),
        "name": &scene.name,
        "description": &scene.description,
        "design": design,
        "fields": found,
    })
}

/// Paths of fields in the order of a text that names each on a line of its own.
fn order(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut section = String::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = format!("{name}.");
        } else if let Some((key, _)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) {
            found.push(format!("{section}{key}"));
        }
    }
    found
}

/// Whether it is something to turn.
fn is_dial(field: &Value) -> bool {
    matches!(field["kind"].as_str(), Some("quantity" | "number" | "integer")) && !field["value"].is_null()
}

/// The fields below a part of the schema, beside what the scene and its text hold there.
fn collect(
    schema: &Value,
    path: &str,
    shown: Option<&toml::Table>,
    written: Option<&toml::Table>,
    found: &mut Vec<Value>,
) {
    let join = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    let inner = |table: Option<&toml::Table>, key: &str| table.and_then(|table| table.get(key).cloned());
    let mut names = keys(schema);
    // Tables named by the user, such as discs: whatever the scene has.
    let free = schema.get("additionalProperties").filter(|of| of.is_object());
    if let (Some(of), Some(shown)) = (free, shown) {
        names.extend(shown.keys().map(|key| (key.clone(), of.clone())));
    }
    for (key, part) in &names {
        let (holds, says) = (inner(shown, key), inner(written, key));
        if path.is_empty() && UNUSED.contains(&key.as_str()) {
            continue;
        }
        if is_table(part) {
            let (holds, says) =
                (holds.as_ref().and_then(toml::Value::as_table), says.as_ref().and_then(toml::Value::as_table));
            collect(part, &join(key), holds, says, found);
        } else if !(path.is_empty() && ["name", "description", "kind", "extends"].contains(&key.as_str())) {
            found.push(field(path, key, &join(key), part, holds.as_ref(), says.is_some()));
        }
    }
}

fn keys(schema: &Value) -> Vec<(String, Value)> {
    let keys: Option<&Map<String, Value>> = schema.get("properties").and_then(Value::as_object);
    keys.into_iter().flatten().map(|(key, part)| (key.clone(), part.clone())).collect()
}

fn is_table(part: &Value) -> bool {
    part.get("properties").is_some() || part.get("additionalProperties").is_some_and(Value::is_object)
}

fn field(section: &str, key: &str, path: &str, part: &Value, holds: Option<&toml::Value>, given: bool) -> Value {
    let (value, unit) = held(holds);
    let [first, last] = ends(part, &unit);
    let units = part.get("x-units").cloned().unwrap_or(Value::Null);
    json!({
        "path": path,
        "section": section,
        "key": key,
        "kind": kind(part),
        "value": value,
        "unit": unit,
        "units": units,
        "text": holds.map(text_of).unwrap_or_default(),
        "words": part.get("enum").cloned().unwrap_or(Value::Null),
        "low": first,
        "high": last,
        "about": part.get("description").cloned().unwrap_or(Value::Null),
        "given": given,
    })
}

/// Where what is allowed begins and ends, in a unit; a number that is an end itself and not allowed is as good for a slider.
fn ends(part: &Value, unit: &str) -> [Option<f64>; 2] {
    let bound = |name: &str| part.get(name).and_then(Value::as_f64);
    let first = part.pointer("/x-units/0").and_then(Value::as_str);
    let dimension = Dimension::ALL.into_iter().find(|of| Some(of.units()[0].name) == first);
    let unit_si = dimension.and_then(|of| parse(&format!("1 {unit}"), of).ok());
    [["minimum", "exclusiveMinimum"], ["maximum", "exclusiveMaximum"]].map(|[at, before]| {
        let plain = bound(at).or(bound(before));
        // In SI.
        let own = bound(&format!("x-{at}")).or(bound(&format!("x-{before}")));
        plain.or(own.zip(unit_si).map(|(end, unit_si)| end / unit_si))
    })
}

/// A number and its unit, as they are written.
fn held(value: Option<&toml::Value>) -> (Option<f64>, String) {
    match value {
        Some(toml::Value::String(text)) => {
            let (number, unit) = split(text);
            match number.parse::<f64>() {
                Ok(number) => (Some(number), unit.to_string()),
                Err(_) => (None, String::new()),
            }
        }
        Some(toml::Value::Integer(number)) => (Some(*number as f64), String::new()),
        Some(toml::Value::Float(number)) => (Some(*number), String::new()),
        _ => (None, String::new()),
    }
}

/// As it is set: a text without its quotes.
fn text_of(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn kind(part: &Value) -> &'static str {
    if part.get("x-units").is_some() {
        return "quantity";
    }
    if part.get("enum").is_some() {
        return "word";
    }
    match part.get("type").and_then(Value::as_str) {
        Some("array") => "list",
        Some("number") => "number",
        Some("integer") => "integer",
        Some("boolean") => "flag",
        _ => "text",
    }
}
