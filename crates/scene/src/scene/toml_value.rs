//! A TOML value of any type.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

/// The TOML value of a key.
#[derive(Clone, Debug)]
pub enum TomlValue {
    Text(String),
    Integer(i64),
    Float(f64),
    Flag(bool),
    List(Vec<Spanned<TomlValue>>),
    /// A table, or a date, which becomes an empty table.
    Table(BTreeMap<String, Spanned<TomlValue>>),
}

impl TomlValue {
    /// Name of the type with article, for messages.
    pub fn name(&self) -> &'static str {
        match self {
            TomlValue::Text(_) => "a string",
            TomlValue::Integer(_) | TomlValue::Float(_) => "a bare number",
            TomlValue::Flag(_) => "a boolean",
            TomlValue::List(_) => "a list",
            TomlValue::Table(_) => "a table or date",
        }
    }
}

impl<'de> Deserialize<'de> for TomlValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TomlValueVisitor)
    }
}

struct TomlValueVisitor;

impl<'de> Visitor<'de> for TomlValueVisitor {
    type Value = TomlValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<TomlValue, E> {
        Ok(TomlValue::Flag(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<TomlValue, E> {
        Ok(TomlValue::Integer(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<TomlValue, E> {
        Ok(i64::try_from(value).map_or(TomlValue::Float(value as f64), TomlValue::Integer))
    }

    fn visit_i128<E>(self, value: i128) -> Result<TomlValue, E> {
        Ok(i64::try_from(value).map_or(TomlValue::Float(value as f64), TomlValue::Integer))
    }

    fn visit_u128<E>(self, value: u128) -> Result<TomlValue, E> {
        Ok(i64::try_from(value).map_or(TomlValue::Float(value as f64), TomlValue::Integer))
    }

    fn visit_f64<E>(self, value: f64) -> Result<TomlValue, E> {
        Ok(TomlValue::Float(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<TomlValue, E> {
        Ok(TomlValue::Text(value.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<TomlValue, A::Error> {
        Vec::deserialize(SeqAccessDeserializer::new(seq)).map(TomlValue::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TomlValue, A::Error> {
        let mut table = BTreeMap::new();
        while let Some(key) = map.next_key::<String>()? {
            // The parser represents a date as a table with a reserved key.
            if key.starts_with('$') {
                map.next_value::<IgnoredAny>()?;
            } else {
                table.insert(key, map.next_value()?);
            }
        }
        Ok(TomlValue::Table(table))
    }
}
