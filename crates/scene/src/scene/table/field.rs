//! One setting: a key of a section, its metadata and how its value is accessed.

use serde_json::Value;
use toml::Spanned;

use super::section::{DynSection, Field, FieldInfo, FieldMetadata, SettingsSection};
use super::value::{FieldValue, ValueKind};
use crate::scene::check::{ANY, Bound};
use crate::scene::error::Problem;
use crate::scene::keywords::{self, SceneKind};
use crate::scene::toml_value::TomlValue;

/// Builder methods for optional texts of the metadata.
macro_rules! optional_texts {
    ($($name:ident)*) => {$(
        pub const fn $name(mut self, text: &'static str) -> Self {
            self.metadata.$name = Some(text);
            self
        }
    )*};
}

/// A key of the section `T` with a value of kind `K`.
pub struct FieldSpec<T, K: ValueKind> {
    metadata: FieldMetadata,
    /// Access to the value in the section; `None` in a variant of the section that does not have it.
    access: fn(&mut T) -> Option<&mut K::Value>,
    /// Setter for a value on which other fields depend.
    setter: Option<fn(&mut T, K::Value)>,
}

impl<T, K: ValueKind> FieldSpec<T, K> {
    /// Creates an optional key with its description and access to its value.
    pub const fn new(key: &'static str, doc: &'static str, access: fn(&mut T) -> Option<&mut K::Value>) -> Self {
        let metadata = FieldMetadata {
            key,
            doc,
            allowed: ANY,
            depends_on: None,
            required: None,
            derived: false,
            default_text: None,
            column: None,
            scene_kinds: keywords::ANY,
        };
        FieldSpec { metadata, access, setter: None }
    }

    pub const fn set_with(mut self, setter: fn(&mut T, K::Value)) -> Self {
        self.setter = Some(setter);
        self
    }

    pub const fn allowed(mut self, bound: Bound) -> Self {
        self.metadata.allowed = bound;
        self
    }

    /// Restricts the key to some kinds of scene.
    pub const fn only_in(mut self, kinds: &'static [SceneKind]) -> Self {
        self.metadata.scene_kinds = kinds;
        self
    }

    pub const fn derived(mut self) -> Self {
        self.metadata.derived = true;
        self
    }

    pub const fn depends_on(mut self, choice: &'static str, reason: &'static str) -> Self {
        self.metadata.depends_on = Some((choice, reason));
        self
    }

    optional_texts!(required default_text column);

    fn set(&self, section: &mut T, value: K::Value) {
        match (self.setter, (self.access)(section)) {
            (Some(set), _) => set(section, value),
            (None, Some(field)) => *field = value,
            (None, None) => {}
        }
    }

    fn is_allowed(&self, value: &K::Value) -> bool {
        is_within(&K::to_field_value(value), self.metadata.allowed)
    }
}

fn is_within(value: &FieldValue, bound: Bound) -> bool {
    value.as_number().is_none_or(bound.allowed)
}

impl<T: SettingsSection, K: ValueKind> FieldInfo for FieldSpec<T, K> {
    fn metadata(&self) -> &FieldMetadata {
        &self.metadata
    }

    fn value_schema(&self) -> Value {
        K::schema().to_value()
    }
}

impl<T: SettingsSection, K: ValueKind> Field<T> for FieldSpec<T, K> {
    fn get(&self, section: &mut T) -> Option<FieldValue> {
        (self.access)(section).map(|value| K::to_field_value(value))
    }

    fn variants(&self) -> Vec<Box<dyn DynSection>> {
        let mut variants: Vec<Box<dyn DynSection>> = Vec::new();
        for value in K::choices() {
            let mut section = T::defaults();
            self.set(&mut section, value);
            variants.push(Box::new(section));
        }
        variants
    }

    fn read(&self, key: &str, input_value: &Spanned<TomlValue>, section: &mut T) -> Result<bool, Vec<Problem>> {
        let value = K::read(key, input_value)?;
        let is_allowed = self.is_allowed(&value);
        if is_allowed {
            self.set(section, value);
        }
        Ok(is_allowed)
    }

    fn restore(&self, text: &str, section: &mut T) -> bool {
        let value = K::restore(text).filter(|value| self.is_allowed(value));
        let is_valid = value.is_some();
        value.into_iter().for_each(|value| self.set(section, value));
        is_valid
    }
}
