//! JSON Schema of scene files.

use std::sync::OnceLock;

use serde_json::{Map, Value, json};

use super::Side;
use super::keywords::SceneKind;
use super::sections::{FINGER_SECTIONS, section_schemas};
use super::table::input::schema as section_schema;
use super::table::law::ContactSettings;
use super::value_kinds::Keyword;

/// JSON Schema (draft 7, understood by the TOML language servers) of a scene file of any kind, as text.
pub fn schema() -> String {
    let [mut finger, mut bodies, mut gripper] = SceneKind::ALL.map(|kind| schema_for(kind).clone());
    let dialect = finger["$schema"].take();
    for kind in [&mut finger, &mut bodies, &mut gripper] {
        kind.as_object_mut().map(|map| map.remove("$schema"));
    }
    let is = |kind: SceneKind| json!({ "properties": { "kind": { "const": kind.keyword() } }, "required": ["kind"] });
    let combined = json!({
        "$schema": dialect,
        "title": "phalanx scene",
        "description": "A scene of phalanx. Its `kind` determines its keys; the default is \"finger\".",
        "type": "object",
        "properties": { "kind": finger["properties"]["kind"] },
        "if": is(SceneKind::Bodies),
        "then": bodies,
        "else": { "if": is(SceneKind::Gripper), "then": gripper, "else": finger },
    });
    format!("{combined:#}\n")
}

/// Returns the schema of one kind of scene. Built once, because a sweep reads thousands of scenes, and on first use,
/// because building all three takes longer than most runs.
pub fn schema_for(kind: SceneKind) -> &'static Value {
    static SCHEMAS: [OnceLock<Value>; SceneKind::ALL.len()] = [const { OnceLock::new() }; SceneKind::ALL.len()];
    SCHEMAS[kind as usize].get_or_init(|| build(kind))
}

/// Returns the keywords and schemas of all other kinds.
pub fn other_schemas(kind: SceneKind) -> Vec<(&'static str, &'static Value)> {
    let others = SceneKind::ALL.into_iter().filter(|other| *other != kind);
    others.map(|other| (other.keyword(), schema_for(other))).collect()
}

/// Builds a schema with all tables inline, without references.
fn build(kind: SceneKind) -> Value {
    let mut schema = section_schemas(kind);
    schema["$schema"] = "http://json-schema.org/draft-07/schema#".into();
    schema["title"] = match kind {
        SceneKind::Finger => "scene of a finger",
        SceneKind::Bodies => "scene of discs",
        SceneKind::Gripper => "scene of a gripper",
    }
    .into();
    if kind.fingers() > 1 {
        let properties = &schema["properties"];
        let mut finger_properties: Map<_, _> =
            FINGER_SECTIONS.iter().map(|key| (key.to_string(), properties[key].clone())).collect();
        // The contacts with palm and table are common to both fingers.
        finger_properties.insert("contact".to_string(), section_schema::<ContactSettings>(SceneKind::Finger));
        for side in Side::BOTH.map(Side::name) {
            schema["properties"][side] = json!({
                "description": format!("Settings of the {side} finger that differ from the common ones. The left finger is described by its mirror image."),
                "type": "object",
                "properties": finger_properties,
                "additionalProperties": false,
            });
        }
    }
    unwrap_lines(&mut schema);
    schema
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
