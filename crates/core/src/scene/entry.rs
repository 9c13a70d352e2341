//! Values as they stand in the file: read leniently with their place, judged later, so that every mistake is reported.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, Range};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

use super::kinds::Kind;

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

/// Place of one item of a list; of the whole value where there is no such item.
pub fn item_span(value: &Spanned<Any>, index: usize) -> Range<usize> {
    match value.get_ref() {
        Any::List(items) => items.get(index).map_or(value.span(), Spanned::span),
        _ => value.span(),
    }
}

/// A key that may be left out; its value will be read as `K`.
pub struct Entry<K> {
    pub given: Option<Spanned<Any>>,
    kind: PhantomData<K>,
}

impl<K> Entry<K> {
    pub fn is_given(&self) -> bool {
        self.given.is_some()
    }

    pub fn span(&self) -> Option<Range<usize>> {
        self.given.as_ref().map(Spanned::span)
    }

    /// Place of one item of a list; of the whole value where there is no such item.
    pub fn item_span(&self, index: usize) -> Option<Range<usize>> {
        self.given.as_ref().map(|given| item_span(given, index))
    }
}

impl<K> Default for Entry<K> {
    fn default() -> Self {
        Entry { given: None, kind: PhantomData }
    }
}

impl<K> fmt::Debug for Entry<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.given.fmt(f)
    }
}

impl<'de, K> Deserialize<'de> for Entry<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Entry { given: Some(Spanned::deserialize(deserializer)?), kind: PhantomData })
    }
}

impl<K: Kind> JsonSchema for Entry<K> {
    fn schema_name() -> Cow<'static, str> {
        K::NAME.into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        K::schema()
    }

    fn inline_schema() -> bool {
        true
    }
}

/// A table that may be left out, with the place of its header.
#[derive(Debug, Default)]
pub struct Section<T> {
    pub span: Option<Range<usize>>,
    body: T,
}

impl<T> Section<T> {
    pub fn of(span: Range<usize>, body: T) -> Self {
        Section { span: Some(span), body }
    }

    pub fn is_given(&self) -> bool {
        self.span.is_some()
    }
}

impl<T> Deref for Section<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.body
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Section<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let table = Spanned::<T>::deserialize(deserializer)?;
        Ok(Section { span: Some(table.span()), body: table.into_inner() })
    }
}

impl<T: JsonSchema> JsonSchema for Section<T> {
    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        T::json_schema(generator)
    }

    fn inline_schema() -> bool {
        true
    }
}
