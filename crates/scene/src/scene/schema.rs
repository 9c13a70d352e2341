//! JSON Schema of scene files.

use std::sync::OnceLock;

use serde_json::{Map, Value, json};

use super::Side;
use super::kinds::Words;
use super::sections::{OF_FINGER, listed};
use super::table::keys::schema as keys_of;
use super::table::law::Contact;
use super::words::SceneKind;

/// JSON Schema (draft 7, understood by the TOML language servers) of a scene file of any kind, as text.
pub fn schema() -> String {
    let [mut finger, mut bodies, mut gripper] = SceneKind::ALL.map(|kind| schema_of(kind).clone());
    let dialect = finger["$schema"].take();
    for kind in [&mut finger, &mut bodies, &mut gripper] {
        kind.as_object_mut().map(|map| map.remove("$schema"));
    }
    let is = |kind: SceneKind| json!({ "properties": { "kind": { "const": kind.word() } }, "required": ["kind"] });
    let whole = json!({
        "$schema": dialect,
        "title": "phalanx scene",
        "description": "A scene of phalanx. Its kind says which keys it has: \"finger\" unless said otherwise.",
        "type": "object",
        "properties": { "kind": finger["properties"]["kind"] },
        "if": is(SceneKind::Bodies),
        "then": bodies,
        "else": { "if": is(SceneKind::Gripper), "then": gripper, "else": finger },
    });
    format!("{whole:#}\n")
}

/// The schema of one kind of scene, made once, for a sweep reads thousands of scenes, and when it is wanted: to make all three takes longer
/// than most runs.
pub fn schema_of(kind: SceneKind) -> &'static Value {
    static MADE: [OnceLock<Value>; SceneKind::ALL.len()] = [const { OnceLock::new() }; SceneKind::ALL.len()];
    MADE[kind as usize].get_or_init(|| make(kind))
}

/// The schemas of all other kinds, each with its word.
pub fn schemas_but(kind: SceneKind) -> Vec<(&'static str, &'static Value)> {
    let others = SceneKind::ALL.into_iter().filter(|other| *other != kind);
    others.map(|other| (other.word(), schema_of(other))).collect()
}

/// Tables are nested in place: no references to follow.
fn make(kind: SceneKind) -> Value {
    let mut schema = listed(kind);
    schema["$schema"] = "http://json-schema.org/draft-07/schema#".into();
    schema["title"] = match kind {
        SceneKind::Finger => "scene of a finger",
        SceneKind::Bodies => "scene of discs",
        SceneKind::Gripper => "scene of a gripper",
    }
    .into();
    if kind.fingers() > 1 {
        let properties = &schema["properties"];
        let mut own: Map<_, _> = OF_FINGER.iter().map(|key| (key.to_string(), properties[key].clone())).collect();
        // Palm and table are those of both.
        own.insert("contact".to_string(), keys_of::<Contact>(SceneKind::Finger));
        for side in Side::BOTH.map(Side::word) {
            schema["properties"][side] = json!({
                "description": format!("What is different of the {side} finger. Everything of the left finger is that of its mirror image."),
                "type": "object",
                "properties": own,
                "additionalProperties": false,
            });
        }
    }
    unwrap_lines(&mut schema);
    schema
}

/// Descriptions come from doc comments: their line breaks mean nothing.
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
