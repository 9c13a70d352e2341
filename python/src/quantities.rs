//! Numbers in SI as quantities: adds units where the fields of a scene need them.

use phalanx::scene::keys::{child_schema, has_tables, is_table};
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::schema::schema_for;
use phalanx::scene::value::ValueType;
use phalanx::scene::{self, Keyword, Layer, PARAMETERS, parse_field, parse_layers, show_written};
use phalanx::study::parameter::parameters;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyString};
use serde_json::Value as Json;
use toml::{Table, Value};

use super::conversion;
use super::scene::Scene;

/// Adds units to the numbers in the dictionary of a scene, which has the keys of a scene file.
pub fn add_units(scene: &mut Table, name: &str) {
    let (kind, base) = kind_and_base(scene, name);
    let complete = merged(base, scene);
    let context = Context { scene: &complete, parent: "", is_linear: None };
    context.add_units(scene, schema_for(kind), Some(&complete));
}

/// Kind of a scene, and the contents of the scene that it extends.
fn kind_and_base(scene: &Table, name: &str) -> (SceneKind, Table) {
    let mut base = Table::new();
    let mut kind = SceneKind::Finger;
    if let Some(extends) = scene.get(scene::EXTENDS) {
        let text = Table::from_iter([(scene::EXTENDS.to_string(), extends.clone())]).to_string();
        let layers = scene::load_extended(Layer { file: name.to_string(), text });
        // An invalid base is reported when the scene is read.
        if let Ok(extended) = layers.and_then(|layers| parse_layers(&layers, &[])) {
            kind = extended.kind;
            base = scene::parse::values(&show_written(&extended)).unwrap_or_default();
        }
    }
    let named = scene.get("kind").and_then(Value::as_str);
    let found = SceneKind::KEYWORDS.iter().find(|(keyword, _)| Some(*keyword) == named);
    (found.map_or(kind, |(_, kind)| *kind), base)
}

fn merged(mut base: Table, own: &Table) -> Table {
    for (key, value) in own {
        match (base.get_mut(key), value) {
            (Some(Value::Table(inner)), Value::Table(more)) => *inner = merged(std::mem::take(inner), more),
            _ => _ = base.insert(key.clone(), value.clone()),
        }
    }
    base
}

/// Returns a setting of a scene as text. Each number that needs a unit gets it.
pub fn setting_text(scene: &Scene, field: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let text = conversion::setting_text(value)?;
    if value.is_instance_of::<PyString>() || value.is_instance_of::<PyBool>() {
        return Ok(text);
    }
    // An invalid field is reported when the scene is read.
    let Ok(parts) = parse_field(field) else { return Ok(text) };
    if parts[0].key() == PARAMETERS {
        return Ok(match unit_of_parameter(scene, field) {
            Some(unit) if !unit.is_empty() => format!("{text} {unit}"),
            _ => text,
        });
    }
    let nested = |inner: Value, part: &scene::Part| Value::Table(Table::from_iter([(part.key(), inner)]));
    let mut setting = parts.iter().rev().fold(conversion::toml_value(value)?, nested);
    let complete = match scene.scene.kind {
        // Units depend on joints in mechanisms only.
        SceneKind::Mechanism => scene::parse::values(&show_written(&scene.scene)).unwrap_or_default(),
        _ => Table::new(),
    };
    let context = Context { scene: &complete, parent: "", is_linear: None };
    let schema = schema_for(scene.scene.kind);
    setting.as_table_mut().into_iter().for_each(|table| context.add_units(table, schema, Some(&complete)));
    let own = parts.iter().try_fold(&setting, |table, part| table.get(part.key()));
    Ok(match own {
        Some(Value::Float(number)) => conversion::format_toml_number(*number),
        Some(value) => value.to_string(),
        None => text,
    })
}

/// SI unit of a parameter of a scene; empty for a plain number.
fn unit_of_parameter(scene: &Scene, field: &str) -> Option<&'static str> {
    let texts = (&scene.layers[..], &scene.settings[..]);
    Some(parameters(texts, &[field.to_string()], &|_| ()).ok()?.first()?.unit)
}

/// Where a table is.
#[derive(Clone, Copy)]
struct Context<'a> {
    /// The complete scene, for the joints to which tables refer.
    scene: &'a Table,
    /// Key of the table around.
    parent: &'a str,
    /// Whether the joint of the table slides; `None` without a joint.
    is_linear: Option<bool>,
}

impl<'a> Context<'a> {
    /// Adds units in a table with this schema; `complete` is the table with all its keys.
    fn add_units(self, table: &mut Table, schema: &Json, complete: Option<&'a Table>) {
        let is_linear = complete.and_then(|complete| self.slides(complete)).or(self.is_linear);
        for (key, value) in table.iter_mut() {
            let Some(schema) = child_schema(schema, key) else { continue };
            let complete = complete.and_then(|complete| complete.get_key_value(key));
            let parent = complete.map_or("", |(key, _)| key.as_str());
            let inner = Context { parent, is_linear, ..self };
            match value {
                Value::Table(table) if is_table(schema) => {
                    inner.add_units(table, schema, complete.and_then(|(_, value)| value.as_table()));
                }
                Value::Array(tables) if has_tables(schema) => {
                    let complete = complete.and_then(|(_, value)| value.as_array());
                    for (index, table) in tables.iter_mut().enumerate() {
                        let complete = complete.and_then(|tables| tables.get(index)?.as_table());
                        let table = table.as_table_mut().into_iter();
                        table.for_each(|table| inner.add_units(table, &schema["items"], complete));
                    }
                }
                value => add_unit(value, &ValueType::from_schema(schema), is_linear),
            }
        }
    }

    /// Whether the joint of a table slides.
    fn slides(self, table: &Table) -> Option<bool> {
        let kind = |table: &Table| table.get("type").and_then(Value::as_str).map(str::to_string);
        match kind(table).as_deref() {
            Some("prismatic" | "linear") => return Some(true),
            _ if self.parent == "joints" => return Some(false),
            _ => {}
        }
        let first = || table.get("joints")?.as_array()?.first();
        let name = table.get("joint").or_else(first)?.as_str()?;
        let joint = self.scene.get("joints")?.get(name)?.as_table()?;
        Some(kind(joint).as_deref() == Some("prismatic"))
    }
}

/// Adds the unit to a number, or to the numbers of a list.
fn add_unit(value: &mut Value, value_type: &ValueType, is_linear: Option<bool>) {
    let value_type = is_linear.map_or_else(|| value_type.clone(), |is_linear| value_type.of_joint(is_linear));
    let number = match value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) if number.is_finite() => Some(*number),
        _ => None,
    };
    match (value_type, number) {
        (ValueType::Quantity(dimension), Some(number)) => {
            *value = Value::String(format!("{number:?} {}", dimension.units()[0].name));
        }
        (ValueType::List(item, _), _) => {
            value.as_array_mut().into_iter().flatten().for_each(|value| add_unit(value, &item, is_linear));
        }
        _ => {}
    }
}
