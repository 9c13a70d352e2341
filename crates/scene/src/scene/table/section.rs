//! A section of a scene as a list of settings, and the metadata of each.

use serde_json::Value;
use toml::Spanned;

use super::value::FieldValue;
use crate::scene::check::Bound;
use crate::scene::error::Problem;
use crate::scene::keywords::SceneKind;
use crate::scene::toml_value::TomlValue;

/// Metadata of a key.
#[derive(Clone, Copy, Debug)]
pub struct FieldMetadata {
    pub key: &'static str,
    pub doc: &'static str,
    /// Range of allowed numbers.
    pub allowed: Bound,
    /// The key whose choice decides whether this key has an effect, and the reason why it has none.
    pub depends_on: Option<(&'static str, &'static str)>,
    /// Help text for a missing key; `None` if the key is optional.
    pub required: Option<&'static str>,
    /// Whether the default depends on other settings.
    pub derived: bool,
    /// The default in its usual notation, if that is not the shortest text.
    pub default_text: Option<&'static str>,
    /// Name in records, if that is not the key with its unit.
    pub column: Option<&'static str>,
    /// Kinds of scene that have the key.
    pub scene_kinds: &'static [SceneKind],
}

/// Properties of a field that do not depend on the type of its section.
pub trait FieldInfo: Sync {
    fn metadata(&self) -> &FieldMetadata;

    /// JSON Schema of the value.
    fn value_schema(&self) -> Value;
}

/// A setting of the section `T` with a value of any kind.
pub trait Field<T>: FieldInfo {
    /// Returns the value, if the section has it.
    fn get(&self, section: &mut T) -> Option<FieldValue>;

    /// One section for each value of a choice; empty for other kinds of value.
    fn variants(&self) -> Vec<Box<dyn DynSection>>;

    /// Reads a value of a scene file into a section. Returns `false`, and leaves the section unchanged, if the value is
    /// out of range.
    ///
    /// # Errors
    /// Returns the problems of a value of the wrong kind; `key` is for messages.
    fn read(&self, key: &str, input_value: &Spanned<TomlValue>, section: &mut T) -> Result<bool, Vec<Problem>>;

    /// Reads a recorded value into a section; returns whether it is valid.
    fn restore(&self, text: &str, section: &mut T) -> bool;
}

/// A section whose keys are fields of a struct.
pub trait SettingsSection: Clone + 'static {
    /// Description of the section.
    const DOC: &'static str;
    /// Descriptions for kinds of scene in which the section has another purpose.
    const DOC_OVERRIDES: &'static [(SceneKind, &'static str)] = &[];
    /// Its keys in the order in which they are read and shown: a choice precedes the keys that depend on it.
    const FIELDS: &'static [&'static dyn Field<Self>];
    /// Nested sections with their schemas.
    const SUBSECTIONS: Subsections = &[];

    /// Returns the section with all defaults; NaN for numbers without a default.
    fn defaults() -> Self;

    /// Returns the section with the defaults of a kind of scene.
    fn defaults_for(_: SceneKind) -> Self {
        Self::defaults()
    }

    /// Description of the section in a kind of scene.
    fn doc(kind: SceneKind) -> &'static str {
        let doc_override = Self::DOC_OVERRIDES.iter().find(|(scene_kind, _)| *scene_kind == kind);
        doc_override.map_or(Self::DOC, |(_, doc)| doc).trim_start()
    }
}

/// A type-erased section, with its fields by index: code that uses it is compiled once, not once per section.
pub trait DynSection {
    fn field(&self, index: usize) -> Option<&'static dyn FieldInfo>;

    /// See [`Field::get`].
    fn get(&mut self, index: usize) -> Option<FieldValue>;

    /// See [`Field::variants`].
    fn variants(&self, index: usize) -> Vec<Box<dyn DynSection>>;

    /// See [`Field::read`].
    ///
    /// # Errors
    /// See [`Field::read`].
    fn read(&mut self, index: usize, key: &str, input_value: &Spanned<TomlValue>) -> Result<bool, Vec<Problem>>;

    /// See [`Field::restore`].
    fn restore(&mut self, index: usize, text: &str) -> bool;
}

impl<T: SettingsSection> DynSection for T {
    fn field(&self, index: usize) -> Option<&'static dyn FieldInfo> {
        T::FIELDS.get(index).map(|field| *field as &'static dyn FieldInfo)
    }

    fn get(&mut self, index: usize) -> Option<FieldValue> {
        T::FIELDS[index].get(self)
    }

    fn variants(&self, index: usize) -> Vec<Box<dyn DynSection>> {
        T::FIELDS[index].variants()
    }

    fn read(&mut self, index: usize, key: &str, input_value: &Spanned<TomlValue>) -> Result<bool, Vec<Problem>> {
        T::FIELDS[index].read(key, input_value, self)
    }

    fn restore(&mut self, index: usize, text: &str) -> bool {
        T::FIELDS[index].restore(text, self)
    }
}

/// All fields of a section with their indices.
pub fn all_fields(section: &dyn DynSection) -> Vec<(usize, &'static dyn FieldInfo)> {
    (0..).map_while(|index| Some((index, section.field(index)?))).collect()
}

/// Returns the fields of a section in a kind of scene.
pub fn fields_for(section: &dyn DynSection, kind: SceneKind) -> Vec<(usize, &'static dyn FieldInfo)> {
    all_fields(section).into_iter().filter(|(_, field)| field.metadata().scene_kinds.contains(&kind)).collect()
}

/// Returns the value of a field in the first variant of the section that has this field.
pub fn value_in_variant(section: &dyn DynSection, index: usize) -> Option<FieldValue> {
    let mut variants = all_fields(section).into_iter().flat_map(|(choice, _)| section.variants(choice));
    variants.find_map(|mut variant| variant.get(index))
}

/// Returns the default of a field as written in a scene file; `None` if the key is required or its default depends on
/// other settings.
pub fn default_value(defaults: &mut dyn DynSection, (index, field): (usize, &dyn FieldInfo)) -> Option<Value> {
    let FieldMetadata { derived, default_text, .. } = *field.metadata();
    if derived || default_text.is_some() {
        return default_text.map(Value::from);
    }
    let value = defaults.get(index).or_else(|| value_in_variant(defaults, index))?;
    value.is_set().then(|| value.into_json())
}

/// Nested sections: key, kinds of scene that have it, and schema.
pub type Subsections = &'static [(&'static str, &'static [SceneKind], fn(SceneKind) -> Value)];
