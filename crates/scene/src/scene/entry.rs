//! Values as they stand in the file: read leniently with their place, judged later, so that every mistake is reported.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::ops::{Deref, Range};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserialize, Deserializer};
use toml::Spanned;

use super::any::Any;
use super::kinds::Kind;

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

    /// What stands before all sections has no header.
    pub fn whole(body: T) -> Self {
        Section { span: None, body }
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
