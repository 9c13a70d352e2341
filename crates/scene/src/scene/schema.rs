//! JSON Schema of scene files, derived from the [settings](super::settings), and what follows from it: allowed values,
//! the settings in a log, the tables of the documentation.

use std::fmt::Write as _;
use std::sync::OnceLock;

use schemars::generate::SchemaSettings;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use toml::Table;

use super::keywords::SceneKind::{self, Bodies, Finger, Gripper};
use super::quantity::Keyword;
use super::settings::{Engine, Integrator, LogRates, SceneFile};
use super::value::{ValueType, from_json};
use crate::units::{format, number};

/// JSON Schema (draft 7, understood by the TOML language servers) of a scene file of any kind, as text.
pub fn schema() -> String {
    let [finger, bodies, gripper] = SceneKind::ALL.map(|kind| {
        let mut schema = schema_for(kind).clone();
        schema.as_object_mut().map(|map| map.remove("$schema"));
        schema
    });
    let is = |kind: SceneKind| json!({ "properties": { "kind": { "const": kind.keyword() } }, "required": ["kind"] });
    let combined = json!({
        "$schema": schema_for(Finger)["$schema"],
        "title": "phalanx scene",
        "description": "A scene of phalanx. Its `kind` determines its keys; the default is \"finger\".",
        "type": "object",
        "properties": { "kind": finger["properties"]["kind"] },
        "if": is(Bodies),
        "then": bodies,
        "else": { "if": is(Gripper), "then": gripper, "else": finger },
    });
    format!("{combined:#}\n")
}

/// Returns the schema of one kind of scene. Built once, because a sweep reads thousands of scenes, and on first use,
/// because building all three takes longer than most runs.
pub fn schema_for(kind: SceneKind) -> &'static Value {
    static SCHEMAS: [OnceLock<Value>; SceneKind::ALL.len()] = [const { OnceLock::new() }; SceneKind::ALL.len()];
    SCHEMAS[kind as usize].get_or_init(|| {
        let settings = SchemaSettings::draft07().for_serialize().with(|settings| settings.inline_subschemas = true);
        let mut schema = settings.into_generator().into_root_schema_for::<SceneFile>().to_value();
        adapt(&mut schema, kind, false);
        // After the keys of other kinds are removed.
        unwrap_lines(&mut schema);
        schema
    })
}

/// Returns the keywords and schemas of all other kinds.
pub fn other_schemas(kind: SceneKind) -> Vec<(&'static str, &'static Value)> {
    let others = SceneKind::ALL.into_iter().filter(|other| *other != kind);
    others.map(|other| (other.keyword(), schema_for(other))).collect()
}

/// Adapts a part of the schema to a kind of scene: keys that the kind does not have are removed, keys lose the unit of
/// the name of their field, and defaults are also given in SI units. In a part that `overrides` another one, keys have no
/// defaults, and the contacts common to both fingers are left out.
fn adapt(schema: &mut Value, kind: SceneKind, overrides: bool) {
    let Some(map) = schema.as_object_mut() else { return };
    let overrides = overrides || map.contains_key("x-overrides");
    let description = map.get("description").cloned();
    let own = SceneKind::ALL.map(|kind| (kind, map.remove(&format!("x-{}", kind.keyword()))));
    for (_, own) in own.into_iter().filter(|(own_kind, _)| *own_kind == kind) {
        map.extend(own.as_ref().and_then(Value::as_object).cloned().unwrap_or_default());
    }
    // A missing key is not null.
    for key in ["type", "enum"] {
        if let Some(Value::Array(items)) = map.get_mut(key) {
            items.retain(|item| !item.is_null() && item != "null");
        }
    }
    if let Some(Value::Array(types)) = map.get("type") {
        let only = types[0].clone();
        map.insert("type".into(), only);
    }
    map.remove("format");
    if overrides {
        map.remove("default");
    }
    if let Some(Value::Object(mut fields)) = map.remove("properties") {
        let order = map.remove("required").and_then(|names| Vec::<String>::deserialize(names).ok()).unwrap_or_default();
        let mut properties = Map::new();
        let take = |property: &mut Value, key: &str| Some(property.as_object_mut()?.remove(key)?.as_str()?.to_string());
        for (index, field) in order.into_iter().enumerate() {
            let Some(mut property) = fields.remove(&field) else { continue };
            let kinds = take(&mut property, "x-kinds");
            if kinds.is_some_and(|kinds| kinds.split(' ').all(|name| name != kind.keyword())) {
                continue;
            }
            adapt(&mut property, kind, overrides);
            let key = take(&mut property, "x-key").unwrap_or_else(|| without_unit(&field, &property).to_string());
            property["x-order"] = index.into();
            property["x-field"] = field.into();
            properties.insert(key, property);
        }
        map.insert("properties".into(), properties.into());
        map.entry("additionalProperties").or_insert(false.into());
    }
    for key in ["additionalProperties", "items"] {
        map.get_mut(key).into_iter().for_each(|inner| adapt(inner, kind, overrides));
    }
    let default = schema.get("default").and_then(|default| from_json(default, &ValueType::from_schema(schema)));
    default.into_iter().for_each(|si| schema["x-si"] = json!(si));
    if overrides && schema["properties"].get("proximal").is_some() && kind == Gripper {
        let properties = schema["properties"].as_object_mut();
        properties
            .into_iter()
            .for_each(|properties| ["palm", "table"].iter().for_each(|key| _ = properties.remove(*key)));
        // That of a finger; the one of a gripper names palm and table.
        schema["description"] = description.unwrap_or_default();
    }
}

/// Name of a field without its unit.
fn without_unit<'a>(field: &'a str, property: &Value) -> &'a str {
    let suffix = ValueType::from_schema(property).suffix();
    suffix.and_then(|suffix| field.strip_suffix(suffix)?.strip_suffix('_')).unwrap_or(field)
}

/// Removes the line breaks of descriptions, which come from doc comments.
pub fn unwrap_lines(value: &mut Value) {
    match value {
        Value::Object(map) => {
            if let Some(Value::String(text)) = map.get_mut("description") {
                *text = text.replace('\n', " ");
            }
            map.values_mut().for_each(unwrap_lines);
        }
        Value::Array(items) => items.iter_mut().for_each(unwrap_lines),
        _ => {}
    }
}

/// Keys of a table in their order, with their schemas.
pub fn properties(schema: &Value) -> Vec<(&String, &Value)> {
    let mut all: Vec<_> = schema["properties"].as_object().into_iter().flatten().collect();
    all.sort_by_cached_key(|(_, property)| property["x-order"].as_u64());
    all
}

/// Keys of a table that are values, in their order.
pub(crate) fn value_properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    properties(schema).into_iter().filter(|(_, property)| !super::keys::is_table(property))
}

/// Name of the field of a key.
pub fn field(property: &Value) -> &str {
    property["x-field"].as_str().unwrap_or_default()
}

/// The key that decides whether a key has an effect, and the values with which it has one.
pub fn condition(property: &Value) -> Option<(&str, Vec<&str>)> {
    let (choice, values) = property["x-with"].as_str()?.split_once(" = ")?;
    Some((choice, values.split('|').collect()))
}

/// Whether a key has an effect in a section with these values; if not, with the choice that prevents it: key, value, and
/// the values with which it would have an effect.
pub fn effect<'a>(property: &'a Value, schema: &Value, values: &Table) -> Result<(), (&'a str, String, Vec<&'a str>)> {
    let Some((choice, allowed)) = condition(property) else { return Ok(()) };
    let chosen = values.get(choice).map(|value| value.to_string().replace('"', ""));
    let chosen = chosen.filter(|_| effect(&schema["properties"][choice], schema, values).is_ok()).unwrap_or_default();
    if allowed.contains(&chosen.as_str()) { Ok(()) } else { Err((choice, chosen, allowed)) }
}

/// Whether a number is within the limits of a schema, which are in SI units.
pub fn is_within(number: f64, schema: &Value) -> bool {
    limits(schema).iter().all(|(keyword, limit)| match *keyword {
        "minimum" => number >= *limit,
        "exclusiveMinimum" => number > *limit,
        "maximum" => number <= *limit,
        _ => number < *limit,
    })
}

/// Limits of numbers: keywords of JSON Schema, which begin with `x-` for quantities, with their values.
fn limits(schema: &Value) -> Vec<(&'static str, f64)> {
    let limit = |keyword| {
        let value = schema.get(keyword).or_else(|| schema.get(format!("x-{keyword}")))?;
        Some((keyword, value.as_f64()?))
    };
    ["minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"].into_iter().filter_map(limit).collect()
}

/// Describes the allowed numbers: "above 0", "from 0 to 1".
pub(crate) fn describe_limits(schema: &Value) -> String {
    let text = |limit: f64| match ValueType::from_schema(schema) {
        ValueType::Quantity(dimension) if limit != 0.0 => format(limit, dimension),
        _ => number(limit),
    };
    match limits(schema)[..] {
        [] => "any finite number".to_string(),
        [("minimum", low)] => format!("at least {}", text(low)),
        [(_, low)] => format!("above {}", text(low)),
        [("minimum", low), (_, high)] => format!("from {} to {}", text(low), text(high)),
        [("exclusiveMinimum", low), ("maximum", high)] => format!("above {} and up to {}", text(low), text(high)),
        [(_, low), (_, high), ..] => format!("between {} and {}, both excluded", text(low), text(high)),
    }
}

/// Describes the allowed values of a key.
pub(crate) fn describe_allowed(schema: &Value) -> String {
    let described = describe_limits(schema);
    match ValueType::from_schema(schema) {
        ValueType::Choice(keywords) => {
            keywords.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
        }
        ValueType::Integer(min, i64::MAX) => format!("a whole number from {min}"),
        ValueType::Integer(min, max) => format!("a whole number from {min} to {max}"),
        ValueType::Flag => "true or false".to_string(),
        ValueType::Text => "a string".to_string(),
        ValueType::Quantity(dimension) if limits(schema).is_empty() => dimension.name().to_string(),
        ValueType::Quantity(dimension) => format!("{} {described}", dimension.name()),
        ValueType::Number | ValueType::Percent if limits(schema).is_empty() => described,
        ValueType::Number | ValueType::Percent => format!("a number {described}"),
        ValueType::List(item, _) => match *item {
            ValueType::Quantity(dimension) => dimension.name().to_string(),
            _ => "a list".to_string(),
        },
    }
}

/// A section whose settings logs and reports record.
pub trait SettingsSection: Serialize + DeserializeOwned {
    /// Path of the section in a scene.
    const PATH: &'static str;

    /// Schema of the section, which is the same in all kinds of scene.
    fn schema() -> &'static Value {
        &schema_for(Finger)["properties"][Self::PATH]
    }
}

impl SettingsSection for Integrator {
    const PATH: &'static str = "integrator";
}

impl SettingsSection for Engine {
    const PATH: &'static str = "engine";
}

impl SettingsSection for LogRates {
    const PATH: &'static str = "log";
}

/// Name of a value with its SI unit.
fn column(key: &str, property: &Value) -> String {
    let (field, suffix) = (field(property), ValueType::from_schema(property).suffix());
    match suffix {
        Some(suffix) if !field.ends_with(&format!("_{suffix}")) => format!("{field}_{suffix}"),
        Some(_) => field.to_string(),
        None => key.to_string(),
    }
}

/// Returns every key of a section with its unit in its name, and its value in SI units; `None` for a key without effect.
pub fn columns<T: SettingsSection>(section: &T) -> Vec<(String, Option<toml::Value>)> {
    let (schema, values) = (T::schema(), Table::try_from(section).unwrap_or_default());
    let column = |(key, property): (&String, &Value)| {
        let value = values.get(field(property)).filter(|_| effect(property, schema, &values).is_ok());
        (column(key, property), value.cloned())
    };
    value_properties(schema).map(column).collect()
}

/// Returns the record of a section for a log: keys with their units, and values that parse back to the same bits.
pub fn record<T: SettingsSection>(section: &T) -> Vec<(String, String)> {
    let text = |value: toml::Value| match value {
        toml::Value::Float(number) => format!("{number:?}"),
        toml::Value::String(text) => text,
        other => other.to_string(),
    };
    let columns = columns(section).into_iter();
    columns.filter_map(|(name, value)| Some((format!("{}_{name}", T::PATH), text(value?)))).collect()
}

/// Restores a section from the record in a log; `entry` returns the text recorded under a name.
///
/// # Errors
/// Returns the error of `entry`, or the one that `refuse` builds from the name, the invalid value and the allowed
/// values.
pub fn restore<T: SettingsSection, E>(
    mut entry: impl FnMut(&str) -> Result<String, E>,
    refuse: impl Fn(String, String, String) -> E,
) -> Result<T, E> {
    let (schema, path, mut values) = (T::schema(), T::PATH, Table::new());
    for (key, property) in value_properties(schema) {
        if effect(property, schema, &values).is_err() {
            continue;
        }
        let name = format!("{path}_{}", column(key, property));
        let text = entry(&name)?;
        let value = ValueType::from_schema(property).restore(&text);
        let value = value.filter(|value| value.as_float().is_none_or(|number| is_within(number, property)));
        match value {
            Some(value) => _ = values.insert(field(property).to_string(), value),
            None => return Err(refuse(name, text, describe_allowed(property))),
        }
    }
    let invalid = |error: toml::de::Error| refuse(path.to_string(), error.to_string(), "complete".to_string());
    T::deserialize(toml::Value::Table(values)).map_err(invalid)
}

/// Returns a Markdown table for every section, with a row for each of its keys. Sections of discs and grippers are listed
/// if they differ from those of a finger.
pub fn markdown() -> String {
    let mut sections: Vec<(String, String)> = Vec::new();
    for (kind, top, of) in [
        (Finger, "scene of a finger", ""),
        (Bodies, "scene of discs", " of a scene of discs"),
        (Gripper, "scene of a gripper", " of a gripper"),
    ] {
        let top = (format!("Top level of a {top}"), schema_for(kind));
        let mut found = vec![top];
        collect_sections(schema_for(kind), "", &mut found);
        for (title, schema) in found {
            let text = markdown_section(schema);
            if !sections.iter().any(|(_, known)| *known == text) {
                let title = if title.starts_with("Top") { title } else { title + of };
                sections.push((title, text));
            }
        }
    }
    sections.iter().map(|(title, text)| format!("{title}: {text}")).collect::<Vec<_>>().join("\n")
}

/// Collects all sections with keys below a table.
fn collect_sections(schema: &'static Value, path: &str, found: &mut Vec<(String, &'static Value)>) {
    let named = schema.get("additionalProperties").filter(|each| each.is_object());
    let named = named.map(|each| ("NAME".to_string(), each));
    for (key, section) in properties(schema).into_iter().map(|(key, section)| (key.clone(), section)).chain(named) {
        let path = super::keys::join(path, &key);
        // A section that overrides another one has the same keys.
        if section.get("x-overrides").is_none() && super::keys::is_table(section) {
            if value_properties(section).next().is_some() {
                found.push((format!("`[{path}]`"), section));
            }
            collect_sections(section, &path, found);
        }
    }
}

/// Description of a section and the table of its keys.
fn markdown_section(schema: &Value) -> String {
    // Names of sections in brackets are not links.
    let description = |schema: &Value| schema["description"].as_str().unwrap_or_default().replace('[', "\\[");
    let mut text = format!("{}\n\n| key | default | allowed | description |\n|---|---|---|---|\n", description(schema));
    for (key, property) in value_properties(schema) {
        let default = match property.get("default") {
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
            None => property.get("x-required").map_or("", |_| "required").to_string(),
        };
        let _ = writeln!(text, "| `{key}` | {default} | {} | {} |", describe_allowed(property), description(property));
    }
    text
}
