//! A section as it is written: values by their keys, to be read by the lines of its table.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::ops::Range;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde_json::Value;
use toml::Spanned;

use super::{Field, Table, default};
use crate::scene::entry::Any;

/// What a scene says in the section of `T`.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
pub struct Keys<T> {
    given: BTreeMap<String, Spanned<Any>>,
    #[serde(skip)]
    table: PhantomData<T>,
}

impl<T> Keys<T> {
    pub fn get(&self, key: &str) -> Option<&Spanned<Any>> {
        self.given.get(key)
    }

    /// The place of a key's value.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).map(Spanned::span)
    }
}

impl<T> Default for Keys<T> {
    fn default() -> Self {
        Keys { given: BTreeMap::new(), table: PhantomData }
    }
}

impl<T: Table> JsonSchema for Keys<T> {
    fn schema_name() -> Cow<'static, str> {
        std::any::type_name::<T>().into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let property = |line: &&dyn Field<T>| (line.about().key.to_string(), property(*line));
        let properties: serde_json::Map<_, _> = T::LINES.iter().map(property).collect();
        let doc = T::DOC.trim_start();
        json_schema!({ "description": doc, "type": "object", "properties": properties, "additionalProperties": false })
    }

    fn inline_schema() -> bool {
        true
    }
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
    schema
}
