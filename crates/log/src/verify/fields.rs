//! Compares two messages by field, using the descriptor embedded in the log.

use prost_reflect::{DescriptorPool, DynamicMessage, MapKey, MessageDescriptor, ReflectMessage, Value};

/// Value of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    Number(f64),
    Integer(i128),
    Bool(bool),
    Text(String),
    Bytes(Vec<u8>),
    Missing,
}

impl FieldValue {
    /// Returns the value as a number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            FieldValue::Number(value) => Some(*value),
            FieldValue::Integer(value) => Some(*value as f64),
            _ => None,
        }
    }

    /// Whether two values are identical, bit for bit.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (FieldValue::Number(a), FieldValue::Number(b)) => a.to_bits() == b.to_bits(),
            _ => self == other,
        }
    }
}

/// A field that differs between two messages; nested fields have names such as `transforms[2].rotation.z`.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDifference {
    pub field: String,
    pub log_value: FieldValue,
    pub rerun_value: FieldValue,
}

/// Returns the descriptor of a message from its schema; `None` if the descriptor set is invalid or does not contain it.
pub fn descriptor(name: &str, data: &[u8]) -> Option<MessageDescriptor> {
    DescriptorPool::decode(data).ok()?.get_message_by_name(name)
}

/// Returns the differing fields of two messages in the order of the first descriptor; `None` if a message cannot be
/// decoded.
pub fn differences(
    log_message: (&MessageDescriptor, &[u8]),
    rerun_message: (&MessageDescriptor, &[u8]),
) -> Option<Vec<FieldDifference>> {
    let (log_fields, rerun_fields) = (flatten(log_message)?, flatten(rerun_message)?);
    let mut found = Vec::new();
    let have_same_fields =
        log_fields.len() == rerun_fields.len() && log_fields.iter().zip(&rerun_fields).all(|(a, b)| a.0 == b.0);
    if have_same_fields {
        for ((field, log_value), (_, rerun_value)) in log_fields.into_iter().zip(rerun_fields) {
            if !log_value.is_same(&rerun_value) {
                found.push(FieldDifference { field, log_value, rerun_value });
            }
        }
        return Some(found);
    }
    let mut unmatched_fields: std::collections::HashMap<String, FieldValue> = rerun_fields.iter().cloned().collect();
    for (field, log_value) in log_fields {
        let rerun_value = unmatched_fields.remove(&field).unwrap_or(FieldValue::Missing);
        if !log_value.is_same(&rerun_value) {
            found.push(FieldDifference { field, log_value, rerun_value });
        }
    }
    for (field, rerun_value) in rerun_fields {
        if unmatched_fields.remove(&field).is_some() {
            found.push(FieldDifference { field, log_value: FieldValue::Missing, rerun_value });
        }
    }
    Some(found)
}

/// Returns the field `timestamp` of a message, if it is a double.
pub fn timestamp_s(descriptor: &MessageDescriptor, data: &[u8]) -> Option<f64> {
    let message = DynamicMessage::decode(descriptor.clone(), data).ok()?;
    message.get_field_by_name("timestamp")?.as_f64().filter(|time_s| time_s.is_finite())
}

fn flatten((descriptor, data): (&MessageDescriptor, &[u8])) -> Option<Vec<(String, FieldValue)>> {
    let message = DynamicMessage::decode(descriptor.clone(), data).ok()?;
    let mut found = Vec::new();
    flatten_message(&message, "", &mut found);
    Some(found)
}

fn flatten_message(message: &DynamicMessage, path: &str, found: &mut Vec<(String, FieldValue)>) {
    let descriptor = message.descriptor();
    let mut fields: Vec<_> = descriptor.fields().collect();
    fields.sort_by_key(|field| field.number());
    for field in fields {
        let name = match path {
            "" => field.name().to_string(),
            path => format!("{path}.{}", field.name()),
        };
        match field.supports_presence() && !message.has_field(&field) {
            true => found.push((name, FieldValue::Missing)),
            false => flatten_value(message.get_field(&field).as_ref(), name, found),
        }
    }
}

fn flatten_value(value: &Value, name: String, found: &mut Vec<(String, FieldValue)>) {
    let field_value = match value {
        Value::F64(value) => FieldValue::Number(*value),
        Value::F32(value) => FieldValue::Number(f64::from(*value)),
        Value::I32(value) | Value::EnumNumber(value) => FieldValue::Integer(i128::from(*value)),
        Value::I64(value) => FieldValue::Integer(i128::from(*value)),
        Value::U32(value) => FieldValue::Integer(i128::from(*value)),
        Value::U64(value) => FieldValue::Integer(i128::from(*value)),
        Value::Bool(value) => FieldValue::Bool(*value),
        Value::String(text) => FieldValue::Text(text.clone()),
        Value::Bytes(bytes) => FieldValue::Bytes(bytes.to_vec()),
        Value::Message(message) => return flatten_message(message, &name, found),
        Value::List(values) => {
            for (index, value) in values.iter().enumerate() {
                flatten_value(value, format!("{name}[{index}]"), found);
            }
            return;
        }
        Value::Map(values) => {
            let mut entries: Vec<(String, &Value)> = values.iter().map(|(k, v)| (key(k), v)).collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            for (key, value) in entries {
                flatten_value(value, format!("{name}[{key}]"), found);
            }
            return;
        }
    };
    found.push((name, field_value));
}

fn key(key: &MapKey) -> String {
    match key {
        MapKey::Bool(key) => key.to_string(),
        MapKey::I32(key) => key.to_string(),
        MapKey::I64(key) => key.to_string(),
        MapKey::U32(key) => key.to_string(),
        MapKey::U64(key) => key.to_string(),
        MapKey::String(key) => key.clone(),
    }
}
