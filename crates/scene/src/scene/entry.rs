//! Values as written in the file with their positions: accepted in any form here and checked later, so that all
//! problems are reported.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, Range};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer};
use toml::Spanned;

use super::toml_value::TomlValue;
use super::value_kinds::InputKind;

/// Position of one item of a list, or of the whole value if there is no such item.
pub fn item_span(value: &Spanned<TomlValue>, index: usize) -> Range<usize> {
    match value.get_ref() {
        TomlValue::List(items) => items.get(index).map_or(value.span(), Spanned::span),
        _ => value.span(),
    }
}

/// An optional key; its value is read as `K` later.
pub struct Entry<K> {
    pub value: Option<Spanned<TomlValue>>,
    kind: PhantomData<K>,
}

impl<K> Entry<K> {
    pub fn is_present(&self) -> bool {
        self.value.is_some()
    }

    pub fn span(&self) -> Option<Range<usize>> {
        self.value.as_ref().map(Spanned::span)
    }

    /// Position of one item of a list, or of the whole value if there is no such item.
    pub fn item_span(&self, index: usize) -> Option<Range<usize>> {
        self.value.as_ref().map(|value| item_span(value, index))
    }
}

impl<K> Default for Entry<K> {
    fn default() -> Self {
        Entry { value: None, kind: PhantomData }
    }
}

impl<K> fmt::Debug for Entry<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)
    }
}

impl<'de, K> Deserialize<'de> for Entry<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Entry { value: Some(Spanned::deserialize(deserializer)?), kind: PhantomData })
    }
}

impl<K: InputKind> JsonSchema for Entry<K> {
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

/// An optional table with the position of its header.
#[derive(Debug, Default)]
pub struct Section<T> {
    pub span: Option<Range<usize>>,
    body: T,
}

impl<T> Section<T> {
    pub fn new(span: Range<usize>, body: T) -> Self {
        Section { span: Some(span), body }
    }

    /// Returns the top level, which has no header.
    pub fn top_level(body: T) -> Self {
        Section { span: None, body }
    }

    pub fn is_present(&self) -> bool {
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
