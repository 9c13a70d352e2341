//! JSON Schema of scene files.

use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::raw::RawScene;

/// JSON Schema (draft 7, understood by the TOML language servers) of a scene file, as text.
pub fn schema() -> String {
    format!("{:#}\n", schema_value())
}

/// The same as a value. Tables are nested in place: no references to follow.
pub(super) fn schema_value() -> Value {
    let settings = SchemaSettings::draft07().for_deserialize().with(|s| s.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<RawScene>().to_value();
    unwrap_lines(&mut schema);
    schema
}

/// Descriptions come from doc comments: their line breaks mean nothing.
fn unwrap_lines(value: &mut Value) {
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
