//! A TOML value of whatever kind.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

/// Any TOML value a key may hold.
#[derive(Clone, Debug)]
pub enum Any {
    Text(String),
    Integer(i64),
    Float(f64),
    Flag(bool),
    List(Vec<Spanned<Any>>),
    /// A table; of a date nothing is kept.
    Table(BTreeMap<String, Spanned<Any>>),
    /// In SI, and in no file: the element of a pair that is not set, where the other one is.
    Si(f64),
}

impl Any {
    /// What it is, with its article, for messages.
    pub fn name(&self) -> &'static str {
        match self {
            Any::Text(_) => "a text",
            Any::Integer(_) | Any::Float(_) => "a bare number",
            Any::Flag(_) => "a truth value",
            Any::List(_) => "a list",
            Any::Table(_) => "a table or date",
            Any::Si(_) => "a value in SI",
        }
    }
}

impl<'de> Deserialize<'de> for Any {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyVisitor)
    }
}

struct AnyVisitor;

impl<'de> Visitor<'de> for AnyVisitor {
    type Value = Any;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Any, E> {
        Ok(Any::Flag(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Any, E> {
        Ok(Any::Integer(value))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Any, E> {
        Ok(i64::try_from(value).map_or(Any::Float(value as f64), Any::Integer))
    }

    fn visit_i128<E>(self, value: i128) -> Result<Any, E> {
        Ok(i64::try_from(value).map_or(Any::Float(value as f64), Any::Integer))
    }

    fn visit_u128<E>(self, value: u128) -> Result<Any, E> {
        Ok(i64::try_from(value).map_or(Any::Float(value as f64), Any::Integer))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Any, E> {
        Ok(Any::Float(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Any, E> {
        Ok(Any::Text(value.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Any, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = seq.next_element()? {
            list.push(item);
        }
        Ok(Any::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Any, A::Error> {
        let mut table = BTreeMap::new();
        while let Some(key) = map.next_key::<String>()? {
            // A date comes as a table with a key that no file can have.
            if key.starts_with('$') {
                map.next_value::<IgnoredAny>()?;
            } else {
                table.insert(key, map.next_value()?);
            }
        }
        Ok(Any::Table(table))
    }
}
