//! JSON Schema of scene files.

use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::Side;
use super::kinds::Words;
use super::raw::RawScene;
use super::raw_bodies::RawBodiesScene;
use super::raw_gripper::{OF_FINGER, RawGripper};
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

/// The schema of one kind of scene, made once: a sweep reads thousands of scenes.
pub fn schema_of(kind: SceneKind) -> &'static Value {
    static FINGER: LazyLock<Value> = LazyLock::new(|| make(SceneKind::Finger));
    static BODIES: LazyLock<Value> = LazyLock::new(|| make(SceneKind::Bodies));
    static GRIPPER: LazyLock<Value> = LazyLock::new(|| make(SceneKind::Gripper));
    match kind {
        SceneKind::Finger => &FINGER,
        SceneKind::Bodies => &BODIES,
        SceneKind::Gripper => &GRIPPER,
    }
}

/// The schemas of all other kinds, each with its word.
pub fn schemas_but(kind: SceneKind) -> Vec<(&'static str, &'static Value)> {
    let others = SceneKind::ALL.into_iter().filter(|other| *other != kind);
    others.map(|other| (other.word(), schema_of(other))).collect()
}

/// Tables are nested in place: no references to follow.
fn make(kind: SceneKind) -> Value {
    fn generate<T: JsonSchema>() -> Value {
        let settings = SchemaSettings::draft07().for_deserialize().with(|s| s.inline_subschemas = true);
        settings.into_generator().into_root_schema_for::<T>().to_value()
    }
    let mut schema = match kind {
        SceneKind::Finger => generate::<RawScene>(),
        SceneKind::Bodies => generate::<RawBodiesScene>(),
        SceneKind::Gripper => with_fingers(generate::<RawGripper>()),
    };
    unwrap_lines(&mut schema);
    schema
}

/// The schema of a gripper with the keys of a finger, which are those of both fingers, and of either.
fn with_fingers(mut gripper: Value) -> Value {
    let finger = &schema_of(SceneKind::Finger)["properties"];
    let mut own = serde_json::Map::new();
    for key in OF_FINGER {
        gripper["properties"][key] = finger[key].clone();
        own.insert(key.to_string(), finger[key].clone());
    }
    let motor = &gripper["properties"]["motor"];
    own.extend([("motor".to_string(), motor.clone()), ("contact".to_string(), finger["contact"].clone())]);
    for side in Side::BOTH.map(Side::word) {
        gripper["properties"][side] = json!({
            "description": format!("What is different of the {side} finger. Everything of the left finger is that of its mirror image."),
            "type": "object",
            "properties": own,
            "additionalProperties": false,
        });
    }
    gripper
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
