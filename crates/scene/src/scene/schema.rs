//! Schema of scene files, derived from the [sections](super::sections): JSON Schema for editors and studies, the settings in
//! a log, the tables of the documentation.

use std::fmt::Write as _;
use std::sync::OnceLock;

use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use toml::Table;

use super::keys::join;
use super::keywords::SceneKind::{self, Bodies, Finger, Gripper, Mechanism};
use super::quantity::Keyword;
use super::section::{Key, NO_SECTION, Section};
use super::sections::{Engine, Integrator, LogSettings, MechanismFile, SceneFile};
use super::value::ValueType;

/// Returns the JSON Schema (draft 7, which TOML language servers understand) of scene files of all kinds, as text.
pub fn schema() -> String {
    let is = |kind: SceneKind| json!({ "properties": { "kind": { "const": kind.keyword() } }, "required": ["kind"] });
    let of = |kind: SceneKind| json!({ "$ref": format!("#/definitions/{}", kind.keyword()) });
    let definitions = SceneKind::ALL.map(|kind| (kind.keyword().to_string(), file_schema(kind)));
    // A scene may inherit its kind.
    let extending = json!({ "required": ["extends"], "not": { "required": ["kind"] } });
    let inherited = json!({ "if": extending, "then": { "anyOf": SceneKind::ALL.map(of) }, "else": of(Finger) });
    let combined = json!({
        "$schema": schema_for(Finger)["$schema"],
        "title": "phalanx scene",
        "description": "A scene of phalanx. Its `kind` determines its keys; the default is \"finger\".",
        "type": "object",
        "properties": { "kind": schema_for(Finger)["properties"]["kind"] },
        "definitions": Map::from_iter(definitions),
        "if": is(Bodies),
        "then": of(Bodies),
        "else": {
            "if": is(Gripper),
            "then": of(Gripper),
            "else": { "if": is(Mechanism), "then": of(Mechanism), "else": inherited },
        },
    });
    format!("{combined:#}\n")
}

/// Returns the schema of files with scenes of one kind. It allows expressions in place of numbers, and keys of single
/// entries of lists.
pub fn file_schema(kind: SceneKind) -> Value {
    let mut schema = schema_for(kind).clone();
    schema.as_object_mut().map(|map| map.remove("$schema"));
    accept_expressions(&mut schema);
    schema
}

fn accept_expressions(schema: &mut Value) {
    let Value::Object(map) = schema else {
        schema.as_array_mut().into_iter().flatten().for_each(accept_expressions);
        return;
    };
    if map.contains_key("x-parameter") {
        map.insert("type".into(), json!(["number", "string"]));
    } else if let Some(number @ ("number" | "integer")) = map.get("type").and_then(Value::as_str) {
        // Limits hold for numbers, and the pattern for strings.
        let types = json!([number, "string"]);
        map.extend([("type".to_string(), types), ("pattern".to_string(), r"^\s*=".into())]);
    }
    let has_lists = map
        .get("properties")
        .and_then(Value::as_object)
        .is_some_and(|properties| properties.values().any(|property| property["type"] == "array"));
    if has_lists {
        map.insert("patternProperties".into(), json!({ r"\]$": {} }));
    }
    map.values_mut().for_each(accept_expressions);
}

/// Returns the schema of one kind of scene. It is built only once, because a sweep reads thousands of scenes, and on
/// first use, because most programs read only one kind.
pub fn schema_for(kind: SceneKind) -> &'static Value {
    static SCHEMAS: [OnceLock<Value>; SceneKind::ALL.len()] = [const { OnceLock::new() }; SceneKind::ALL.len()];
    SCHEMAS[kind as usize].get_or_init(|| {
        let adapter = Adapter::new(kind);
        adapter.adapt(adapter.root, false).into()
    })
}

/// Returns the top level of the schema of one kind of scene.
pub fn top_level(kind: SceneKind) -> &'static Section {
    static SECTIONS: [OnceLock<Section>; SceneKind::ALL.len()] = [const { OnceLock::new() }; SceneKind::ALL.len()];
    SECTIONS[kind as usize].get_or_init(|| Section::new(schema_for(kind)))
}

/// Returns the keywords and schemas of all other kinds.
pub fn other_schemas(kind: SceneKind) -> Vec<(&'static str, &'static Value)> {
    let others = SceneKind::ALL.into_iter().filter(|other| *other != kind);
    others.map(|other| (other.keyword(), schema_for(other))).collect()
}

/// The schema of one kind of scene in the making.
struct Adapter {
    kind: SceneKind,
    /// Schema of this kind and others, with all sections as definitions.
    root: &'static Value,
}

impl Adapter {
    fn new(kind: SceneKind) -> Self {
        static ROOTS: [OnceLock<Value>; 2] = [const { OnceLock::new() }; 2];
        // The sections are references: inlined, a finger and its contacts would be generated many times.
        let root = ROOTS[usize::from(kind == Mechanism)].get_or_init(|| {
            let settings = SchemaSettings::draft07().for_serialize().with(|settings| settings.transforms.clear());
            let generator = settings.into_generator();
            let root = match kind {
                Mechanism => generator.into_root_schema_for::<MechanismFile>(),
                Finger | Bodies | Gripper => generator.into_root_schema_for::<SceneFile>(),
            };
            let mut root = root.to_value();
            unwrap_lines(&mut root);
            root
        });
        Adapter { kind, root }
    }

    /// Adapts a part of the schema: keys that the kind does not have are left out, keys lose the unit of the name of
    /// their field, defaults are also given in SI units, and references are replaced by their sections. In a part that
    /// `overrides` another one, keys have no defaults, and the contacts common to both fingers are left out.
    fn adapt(&self, part: &'static Value, overrides: bool) -> Map<String, Value> {
        let overrides = overrides || part.get("x-overrides").is_some();
        let fields = part.get("properties");
        let is_contact = fields.is_some_and(|fields| fields.get("proximal").is_some());
        let overrides_contacts = overrides && self.kind == Gripper && is_contact;
        let of_kind = ["x-finger", "x-bodies", "x-gripper", "x-mechanism"][self.kind as usize];
        let of_kind = part.get(of_kind).and_then(Value::as_object).into_iter().flatten();
        // The description of the contacts of a gripper names palm and table.
        let of_kind = of_kind.filter(|(key, _)| !overrides_contacts || *key != "description");
        let section = part.get("$ref").and_then(|path| path.as_str()?.rsplit('/').next());
        let mut map = section.map(|name| self.adapt(&self.root["definitions"][name], overrides)).unwrap_or_default();
        for (key, value) in part.as_object().into_iter().flatten().chain(of_kind) {
            let adapted = match (key.as_str(), value) {
                ("$ref" | "definitions" | "properties" | "required" | "format", _) => continue,
                ("x-finger" | "x-bodies" | "x-gripper" | "x-mechanism" | "x-kinds" | "x-key", _) => continue,
                ("default", _) if overrides => continue,
                // A missing key is not null.
                ("type", Value::Array(types)) => types[0].clone(),
                ("enum", Value::Array(items)) => items.iter().filter(|item| !item.is_null()).cloned().collect(),
                ("additionalProperties" | "items", Value::Object(_)) => self.adapt(value, overrides).into(),
                _ => value.clone(),
            };
            map.insert(key.clone(), adapted);
        }
        let Some(fields) = fields else { return map };
        let mut properties = Map::new();
        let order = part.get("required").and_then(Value::as_array).into_iter().flatten();
        for (index, field) in order.filter_map(Value::as_str).enumerate() {
            let field_schema = &fields[field];
            let text = |key: &str| field_schema.get(key).and_then(Value::as_str);
            let is_of_kind = |kinds: &str| kinds.split(' ').any(|name| name == self.kind.keyword());
            if !text("x-kinds").is_none_or(is_of_kind) || overrides_contacts && ["palm", "table"].contains(&field) {
                continue;
            }
            let mut property = Value::from(self.adapt(field_schema, overrides));
            let value_type = ValueType::from_schema(&property);
            if let Some(si) = property.get("default").and_then(|default| value_type.json_to_si(default)) {
                property["x-si"] = json!(si);
            }
            property["x-order"] = index.into();
            property["x-field"] = field.into();
            properties.insert(text("x-key").unwrap_or_else(|| without_unit(field, &value_type)).to_string(), property);
        }
        map.insert("properties".into(), properties.into());
        map.entry("additionalProperties").or_insert(false.into());
        map
    }
}

/// Name of a field without its unit.
fn without_unit<'a>(field: &'a str, value_type: &ValueType) -> &'a str {
    value_type.suffix().and_then(|suffix| field.strip_suffix(suffix)?.strip_suffix('_')).unwrap_or(field)
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

/// A section whose settings are recorded in logs and reports. It is the same in all kinds of scene.
pub trait SettingsSection: Serialize + DeserializeOwned {
    /// Path of the section in a scene.
    const PATH: &'static str;

    /// Its part of the schema.
    fn section() -> &'static Section {
        top_level(Finger).subsection(Self::PATH).unwrap_or(&NO_SECTION)
    }
}

impl SettingsSection for Integrator {
    const PATH: &'static str = "integrator";
}

impl SettingsSection for Engine {
    const PATH: &'static str = "engine";
}

impl SettingsSection for LogSettings {
    const PATH: &'static str = "log";
}

/// Returns every key of a section, with the unit in its name, and its value in SI units; `None` for a key that has no
/// effect.
pub fn columns<T: SettingsSection>(settings: &T) -> Vec<(String, Option<toml::Value>)> {
    let (section, values) = (T::section(), Table::try_from(settings).unwrap_or_default());
    let value = |key: &Key| values.get(key.field).filter(|_| section.effect(key, &values).is_ok()).cloned();
    section.keys().iter().map(|key| (key.column(), value(key))).collect()
}

/// Returns the record of a section for a log: keys with their units, and values that parse back to the same bits.
pub fn record<T: SettingsSection>(settings: &T) -> Vec<(String, String)> {
    let text = |value: toml::Value| match value {
        toml::Value::Float(number) => format!("{number:?}"),
        toml::Value::String(text) => text,
        other => other.to_string(),
    };
    let columns = columns(settings).into_iter();
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
    let (section, mut values) = (T::section(), Table::new());
    for key in section.keys() {
        if section.effect(key, &values).is_err() {
            continue;
        }
        let name = format!("{}_{}", T::PATH, key.column());
        let text = entry(&name)?;
        match key.value_type.restore(&text).filter(|value| key.allows(value)) {
            Some(value) => _ = values.insert(key.field.to_string(), value),
            None => return Err(refuse(name, text, key.allowed())),
        }
    }
    let invalid = |error: toml::de::Error| refuse(T::PATH.to_string(), error.to_string(), "complete".to_string());
    T::deserialize(toml::Value::Table(values)).map_err(invalid)
}

/// Returns a Markdown table for every section, with one row per key. A section of discs, grippers or mechanisms is
/// listed only if it differs from that of a finger.
pub fn markdown() -> String {
    let mut sections: Vec<(String, String)> = Vec::new();
    for (kind, top, of) in [
        (Finger, "scene of a finger", ""),
        (Bodies, "scene of discs", " of a scene of discs"),
        (Gripper, "scene of a gripper", " of a gripper"),
        (Mechanism, "scene of a mechanism", " of a mechanism"),
    ] {
        let mut found = vec![(format!("Top level of a {top}"), top_level(kind))];
        collect_sections(top_level(kind), "", of, &mut found);
        for (title, section) in found {
            let text = markdown_section(section);
            if !sections.iter().any(|(_, known)| *known == text) {
                sections.push((title, text));
            }
        }
    }
    sections.iter().map(|(title, text)| format!("{title}: {text}")).collect::<Vec<_>>().join("\n")
}

/// Collects all sections with keys below a section of a kind of scene.
fn collect_sections(section: &'static Section, path: &str, of: &str, found: &mut Vec<(String, &'static Section)>) {
    let named = section.named().map(|each| ("NAME", each));
    let subsections = section.subsections().iter().chain(section.lists()).map(|(name, section)| (*name, section));
    for (name, section) in subsections.chain(named) {
        let path = join(path, name);
        // A section that overrides another one has the same keys.
        if section.schema.get("x-overrides").is_none() {
            if !section.keys().is_empty() {
                found.push((format!("`[{path}]`{of}"), section));
            }
            collect_sections(section, &path, of, found);
        }
    }
}

/// Description of a section and the table of its keys.
fn markdown_section(section: &Section) -> String {
    // Names of sections in brackets are not links.
    let description = |schema: &Value| schema["description"].as_str().unwrap_or_default().replace('[', "\\[");
    let head = "| key | default | allowed | description |\n|---|---|---|---|\n";
    let mut text = format!("{}\n\n{head}", description(section.schema));
    for key in section.keys() {
        let default = match key.schema.get("default") {
            Some(Value::String(text)) => text.clone(),
            Some(value) => value.to_string(),
            None => key.schema.get("x-required").map_or("", |_| "required").to_string(),
        };
        let _ = writeln!(text, "| `{}` | {default} | {} | {} |", key.name, key.allowed(), description(key.schema));
    }
    text
}
