//! A section as it is written: values by their keys, to be read by the lines of its table.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::ops::Range;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde_json::Value;
use toml::Spanned;

use super::section::{Field, Table, default};
use crate::scene::any::Any;
use crate::scene::check::End;
use crate::scene::entry::Section;
use crate::scene::kinds::Kind;

/// What a scene says in the section of `T`.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
pub struct Keys<T> {
    given: BTreeMap<String, Spanned<Any>>,
    #[serde(skip)]
    table: PhantomData<T>,
}

impl<T> Keys<T> {
    pub fn of(given: BTreeMap<String, Spanned<Any>>) -> Self {
        Keys { given, table: PhantomData }
    }

    pub fn get(&self, key: &str) -> Option<&Spanned<Any>> {
        self.given.get(key)
    }

    pub fn has(&self, key: &str) -> bool {
        self.given.contains_key(key)
    }

    /// The value of a key, if it is there and of that kind.
    pub fn value<K: Kind>(&self, key: &str) -> Option<K::Value> {
        K::read(key, self.get(key)?).ok()
    }

    /// Whether the value of a key is of that kind, if it is there at all.
    pub fn is_known<K: Kind>(&self, key: &str) -> bool {
        !self.has(key) || self.value::<K>(key).is_some()
    }

    /// The section under a key.
    pub fn inner<U>(&self, key: &str) -> Section<Keys<U>> {
        match self.get(key).map(|given| (given.span(), given.get_ref())) {
            Some((span, Any::Table(given))) => Section::of(span, Keys::of(given.clone())),
            _ => Section::default(),
        }
    }

    /// The place of a key's value.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).map(Spanned::span)
    }
}

impl<T> Section<Keys<T>> {
    /// The same section with some of its keys as those of another table.
    pub fn recast<U>(&self) -> Section<Keys<U>> {
        match &self.span {
            Some(span) => Section::of(span.clone(), Keys::of(self.given.clone())),
            None => Section::default(),
        }
    }
}

impl<T> Default for Keys<T> {
    fn default() -> Self {
        Keys::of(BTreeMap::new())
    }
}

impl<T: Table> JsonSchema for Keys<T> {
    fn schema_name() -> Cow<'static, str> {
        std::any::type_name::<T>().into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        schema::<T>()
    }

    fn inline_schema() -> bool {
        true
    }
}

/// JSON Schema of a section.
pub fn schema<T: Table>() -> Schema {
    let lines = T::LINES.iter().map(|line| (line.about().key.to_string(), property(*line)));
    let inner = T::INNER.iter().map(|(key, schema)| (key.to_string(), schema().to_value()));
    let properties: serde_json::Map<_, _> = lines.chain(inner).collect();
    let doc = T::DOC.trim_start();
    json_schema!({ "description": doc, "type": "object", "properties": properties, "additionalProperties": false })
}

fn property<T: Table>(line: &dyn Field<T>) -> Value {
    let mut schema = line.kind();
    let doc = line.about().doc.trim_start();
    if !doc.is_empty() {
        schema["description"] = doc.into();
    }
    if let Some(default) = default(line) {
        schema["default"] = default;
    }
    let number = schema["type"] == "number";
    if number || schema.get("x-units").is_some() {
        bounds(&mut schema, line.about().allowed.ends(), number);
    }
    schema
}

/// Ends of what is allowed: as JSON Schema has them for numbers, and under keys of our own for quantities, in SI.
fn bounds(schema: &mut Value, ends: [End; 2], number: bool) {
    let own = if number { "" } else { "x-" };
    for (end, [at, before]) in ends.into_iter().zip([["minimum", "exclusiveMinimum"], ["maximum", "exclusiveMaximum"]])
    {
        match end {
            End::Open => {}
            End::At(end) => schema[format!("{own}{at}")] = end.into(),
            End::Before(end) => schema[format!("{own}{before}")] = end.into(),
        }
    }
}
