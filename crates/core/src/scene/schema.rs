//! JSON Schema of scene files.

use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::kinds::Words;
use super::raw::RawScene;
use super::raw_bodies::RawBodiesScene;
use super::words::SceneKind;

/// JSON Schema (draft 7, understood by the TOML language servers) of a scene file of either kind, as text.
pub fn schema() -> String {
    let [mut finger, mut bodies] = [SceneKind::Finger, SceneKind::Bodies].map(|kind| schema_of(kind).clone());
    let dialect = finger["$schema"].take();
    for kind in [&mut finger, &mut bodies] {
        kind.as_object_mut().map(|map| map.remove("$schema"));
    }
    let whole = json!({
        "$schema": dialect,
        "title": "phalanx scene",
        "description": "A scene of phalanx. Its kind says which keys it has: \"finger\" unless said otherwise.",
        "type": "object",
        "properties": { "kind": finger["properties"]["kind"] },
        "if": { "properties": { "kind": { "const": SceneKind::Bodies.word() } }, "required": ["kind"] },
        "then": bodies,
        "else": finger,
    });
    format!("{whole:#}\n")
}

/// The schema of one kind of scene, made once: a sweep reads thousands of scenes.
pub fn schema_of(kind: SceneKind) -> &'static Value {
    static FINGER: LazyLock<Value> = LazyLock::new(|| make(SceneKind::Finger));
    static BODIES: LazyLock<Value> = LazyLock::new(|| make(SceneKind::Bodies));
    match kind {
        SceneKind::Finger => &FINGER,
        SceneKind::Bodies => &BODIES,
    }
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
    };
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
