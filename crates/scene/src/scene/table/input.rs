//! A section as written in a file: its values by key; and the JSON Schema of a section.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::{Map, Value, json};
use toml::Spanned;

use super::section::{DynSection, FieldInfo, SettingsSection, Subsections, default_value, fields_for};
use crate::scene::check::Endpoint;
use crate::scene::keywords::SceneKind;
use crate::scene::toml_value::TomlValue;
use crate::scene::value_kinds::InputKind;

/// Values of a section by key.
pub type SectionValues = BTreeMap<String, Spanned<TomlValue>>;

/// An optional section of a scene of some kind, as written.
#[derive(Clone, Debug)]
pub struct SectionInput<'a> {
    pub kind: SceneKind,
    /// Position of its header; `None` for the top level and for an omitted section.
    pub span: Option<Range<usize>>,
    values: Option<&'a SectionValues>,
}

impl<'a> SectionInput<'a> {
    /// Returns the top level of a scene.
    pub fn top_level(kind: SceneKind, values: &'a SectionValues) -> Self {
        SectionInput { kind, span: None, values: Some(values) }
    }

    pub fn is_present(&self) -> bool {
        self.span.is_some()
    }

    pub fn get(&self, key: &str) -> Option<&'a Spanned<TomlValue>> {
        self.values?.get(key)
    }

    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    /// Returns the value of a key, if it is given and valid.
    pub fn value<K: InputKind>(&self, key: &str) -> Option<K::Value> {
        K::read(key, self.get(key)?).ok()
    }

    /// Whether the value of a key is valid or omitted.
    pub fn is_valid<K: InputKind>(&self, key: &str) -> bool {
        !self.has(key) || self.value::<K>(key).is_some()
    }

    /// Returns the subsection with this key.
    pub fn subsection(&self, key: &str) -> Self {
        let absent = SectionInput { kind: self.kind, span: None, values: None };
        match self.get(key).map(|input_value| (input_value.span(), input_value.get_ref())) {
            Some((span, TomlValue::Table(values))) => SectionInput { span: Some(span), values: Some(values), ..absent },
            _ => absent,
        }
    }

    /// All subsections with their names.
    pub fn subsections(&self) -> impl Iterator<Item = (&'a str, Self)> + use<'a> {
        let parent = self.clone();
        self.values.into_iter().flatten().map(move |(name, _)| (name.as_str(), parent.subsection(name)))
    }

    /// Position of the value of a key.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).map(Spanned::span)
    }
}

/// Returns the JSON Schema of a section in a kind of scene.
pub fn schema<T: SettingsSection>(kind: SceneKind) -> Value {
    section_schema(&mut T::defaults_for(kind), (T::doc(kind), T::SUBSECTIONS), kind)
}

fn section_schema(defaults: &mut dyn DynSection, (doc, subsections): (&str, Subsections), kind: SceneKind) -> Value {
    let mut properties = Map::new();
    for field in fields_for(defaults, kind) {
        properties.insert(field.1.metadata().key.to_string(), property_schema(defaults, field));
    }
    for (key, _, schema) in subsections.iter().filter(|(_, kinds, _)| kinds.contains(&kind)) {
        properties.insert(key.to_string(), schema(kind));
    }
    json!({ "description": doc, "type": "object", "properties": properties, "additionalProperties": false })
}

fn property_schema(defaults: &mut dyn DynSection, (index, field): (usize, &dyn FieldInfo)) -> Value {
    let mut schema = field.value_schema();
    let doc = field.metadata().doc.trim_start();
    if !doc.is_empty() {
        schema["description"] = doc.into();
    }
    if let Some(default) = default_value(defaults, (index, field)) {
        schema["default"] = default;
    }
    let is_number = schema["type"] == "number";
    if is_number || schema.get("x-units").is_some() {
        add_bounds(&mut schema, field.metadata().allowed.endpoints(), is_number);
    }
    schema
}

/// Adds the endpoints of the allowed range: as keywords of JSON Schema for numbers, and as `x-` keywords in SI units
/// for quantities.
fn add_bounds(schema: &mut Value, endpoints: [Endpoint; 2], is_number: bool) {
    let prefix = if is_number { "" } else { "x-" };
    for (endpoint, [inclusive, exclusive]) in
        endpoints.into_iter().zip([["minimum", "exclusiveMinimum"], ["maximum", "exclusiveMaximum"]])
    {
        match endpoint {
            Endpoint::Unbounded => {}
            Endpoint::Inclusive(value) => schema[format!("{prefix}{inclusive}")] = value.into(),
            Endpoint::Exclusive(value) => schema[format!("{prefix}{exclusive}")] = value.into(),
        }
    }
}
