//! Two messages field by field, by the descriptor that a log embeds.

use prost_reflect::{DescriptorPool, DynamicMessage, MapKey, MessageDescriptor, ReflectMessage, Value};

/// What a field holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Leaf {
    Number(f64),
    Whole(i128),
    Flag(bool),
    Text(String),
    Bytes(Vec<u8>),
    /// Not there at all.
    Absent,
}

impl Leaf {
    /// As a number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Leaf::Number(value) => Some(*value),
            Leaf::Whole(value) => Some(*value as f64),
            _ => None,
        }
    }

    /// Whether it is the same to the last bit.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Leaf::Number(a), Leaf::Number(b)) => a.to_bits() == b.to_bits(),
            _ => self == other,
        }
    }
}

/// A field in which two messages differ; nested ones are named as in `transforms[2].rotation.z`.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldDifference {
    pub field: String,
    pub ours: Leaf,
    pub theirs: Leaf,
}

/// The descriptor of a message by its schema; `None` if the data is no set of descriptors that has it.
pub fn descriptor(name: &str, data: &[u8]) -> Option<MessageDescriptor> {
    DescriptorPool::decode(data).ok()?.get_message_by_name(name)
}

/// The fields in which two messages differ, in the order of the first descriptor; `None` if one of them cannot be decoded.
pub fn differences(
    ours: (&MessageDescriptor, &[u8]),
    theirs: (&MessageDescriptor, &[u8]),
) -> Option<Vec<FieldDifference>> {
    let (ours, theirs) = (leaves(ours)?, leaves(theirs)?);
    let mut found = Vec::new();
    let same_shape = ours.len() == theirs.len() && ours.iter().zip(&theirs).all(|(a, b)| a.0 == b.0);
    if same_shape {
        for ((field, ours), (_, theirs)) in ours.into_iter().zip(theirs) {
            if !ours.is_same(&theirs) {
                found.push(FieldDifference { field, ours, theirs });
            }
        }
        return Some(found);
    }
    let mut rest: std::collections::HashMap<String, Leaf> = theirs.iter().cloned().collect();
    for (field, ours) in ours {
        let theirs = rest.remove(&field).unwrap_or(Leaf::Absent);
        if !ours.is_same(&theirs) {
            found.push(FieldDifference { field, ours, theirs });
        }
    }
    for (field, theirs) in theirs {
        if rest.remove(&field).is_some() {
            found.push(FieldDifference { field, ours: Leaf::Absent, theirs });
        }
    }
    Some(found)
}

/// Time of a message in its own words: its field `timestamp`, if that is a double.
pub fn timestamp_s(descriptor: &MessageDescriptor, data: &[u8]) -> Option<f64> {
    let message = DynamicMessage::decode(descriptor.clone(), data).ok()?;
    message.get_field_by_name("timestamp")?.as_f64().filter(|time_s| time_s.is_finite())
}

fn leaves((descriptor, data): (&MessageDescriptor, &[u8])) -> Option<Vec<(String, Leaf)>> {
    let message = DynamicMessage::decode(descriptor.clone(), data).ok()?;
    let mut found = Vec::new();
    of_message(&message, "", &mut found);
    Some(found)
}

fn of_message(message: &DynamicMessage, path: &str, found: &mut Vec<(String, Leaf)>) {
    let descriptor = message.descriptor();
    let mut fields: Vec<_> = descriptor.fields().collect();
    fields.sort_by_key(|field| field.number());
    for field in fields {
        let name = match path {
            "" => field.name().to_string(),
            path => format!("{path}.{}", field.name()),
        };
        match field.supports_presence() && !message.has_field(&field) {
            true => found.push((name, Leaf::Absent)),
            false => of_value(message.get_field(&field).as_ref(), name, found),
        }
    }
}

fn of_value(value: &Value, name: String, found: &mut Vec<(String, Leaf)>) {
    let leaf = match value {
        Value::F64(value) => Leaf::Number(*value),
        Value::F32(value) => Leaf::Number(f64::from(*value)),
        Value::I32(value) | Value::EnumNumber(value) => Leaf::Whole(i128::from(*value)),
        Value::I64(value) => Leaf::Whole(i128::from(*value)),
        Value::U32(value) => Leaf::Whole(i128::from(*value)),
        Value::U64(value) => Leaf::Whole(i128::from(*value)),
        Value::Bool(value) => Leaf::Flag(*value),
        Value::String(text) => Leaf::Text(text.clone()),
        Value::Bytes(bytes) => Leaf::Bytes(bytes.to_vec()),
        Value::Message(message) => return of_message(message, &name, found),
        Value::List(values) => {
            for (index, value) in values.iter().enumerate() {
                of_value(value, format!("{name}[{index}]"), found);
            }
            return;
        }
        Value::Map(values) => {
            let mut entries: Vec<(String, &Value)> = values.iter().map(|(k, v)| (key(k), v)).collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            for (key, value) in entries {
                of_value(value, format!("{name}[{key}]"), found);
            }
            return;
        }
    };
    found.push((name, leaf));
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
