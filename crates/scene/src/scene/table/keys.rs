//! A section as it is written: values by their keys, to be read by the lines of a table; and its JSON Schema.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::{Map, Value, json};
use toml::Spanned;

use super::section::{Inner, Said, Section, Table, default, lines_of};
use crate::scene::any::Any;
use crate::scene::check::End;
use crate::scene::kinds::Kind;
use crate::scene::words::SceneKind;

/// What stands in a section.
pub type Given = BTreeMap<String, Spanned<Any>>;

/// What a scene of some kind says in a section, which may be left out.
#[derive(Clone, Debug)]
pub struct Keys<'a> {
    pub kind: SceneKind,
    /// Place of its header; what stands before all sections has none.
    pub span: Option<Range<usize>>,
    given: Option<&'a Given>,
}

impl<'a> Keys<'a> {
    /// What stands before all sections, with these.
    pub fn whole(kind: SceneKind, given: &'a Given) -> Self {
        Keys { kind, span: None, given: Some(given) }
    }

    pub fn is_given(&self) -> bool {
        self.span.is_some()
    }

    pub fn get(&self, key: &str) -> Option<&'a Spanned<Any>> {
        self.given?.get(key)
    }

    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
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
    pub fn inner(&self, key: &str) -> Self {
        let none = Keys { kind: self.kind, span: None, given: None };
        match self.get(key).map(|given| (given.span(), given.get_ref())) {
            Some((span, Any::Table(given))) => Keys { span: Some(span), given: Some(given), ..none },
            _ => none,
        }
    }

    /// All sections in it, by their names.
    pub fn named(&self) -> impl Iterator<Item = (&'a str, Self)> + use<'a> {
        let whole = self.clone();
        self.given.into_iter().flatten().map(move |(name, _)| (name.as_str(), whole.inner(name)))
    }

    /// The place of a key's value.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).map(Spanned::span)
    }
}

/// JSON Schema of a section in scenes of a kind.
pub fn schema<T: Table>(kind: SceneKind) -> Value {
    schema_of(&mut T::usual_in(kind), (T::doc(kind), T::INNER), kind)
}

fn schema_of(usual: &mut dyn Section, (doc, inner): (&str, Inner), kind: SceneKind) -> Value {
    let mut properties = Map::new();
    for line in lines_of(usual, kind) {
        properties.insert(line.1.about().key.to_string(), property(usual, line));
    }
    for (key, _, schema) in inner.iter().filter(|(_, kinds, _)| kinds.contains(&kind)) {
        properties.insert(key.to_string(), schema(kind));
    }
    json!({ "description": doc, "type": "object", "properties": properties, "additionalProperties": false })
}

fn property(usual: &mut dyn Section, (line, said): (usize, &dyn Said)) -> Value {
    let mut schema = said.kind();
    let doc = said.about().doc.trim_start();
    if !doc.is_empty() {
        schema["description"] = doc.into();
    }
    if let Some(default) = default(usual, (line, said)) {
        schema["default"] = default;
    }
    let number = schema["type"] == "number";
    if number || schema.get("x-units").is_some() {
        bounds(&mut schema, said.about().allowed.ends(), number);
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
