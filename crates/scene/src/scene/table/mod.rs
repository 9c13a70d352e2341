//! The settings of a scene: every key with its kind of value, default, range and description.
//!
//! A section of a scene is a struct, and each of its keys a [`FieldSpec`] that gives access to its value in the struct.
//! The JSON Schema, the defaults, the checks with their messages, `scene show`, the settings in a log, the flags of the
//! command line and the tables of the documentation are derived from these. A new setting is a field, its default and a
//! line of `settings!` in one file.
//!
//! | file | contents |
//! |---|---|
//! | `section` | a section as a list of settings; their metadata |
//! | `field` | one setting |
//! | `value` | values of settings: as shown, as recorded, and parsed back |
//! | `input` | a section as written in a file, and its JSON Schema |
//! | `markdown` | all settings as Markdown |
//! | all others | one or more sections of a scene each |
//!
//! A section may have different keys in different kinds of scene: `only_in` restricts a key to some kinds.

pub mod bounds;
pub mod criteria;
pub mod differential;
pub mod disc;
pub mod drive;
pub mod engine;
mod field;
pub mod finger;
pub mod input;
pub mod integrator;
pub mod law;
pub mod log;
mod markdown;
pub mod motion;
pub mod object;
pub mod plane;
pub mod scene;
mod section;
pub mod shape;
pub mod value;

use std::borrow::Cow;

use serde_json::Value;
use toml::Spanned;

pub use field::FieldSpec;
pub use markdown::markdown;
pub use section::{DynSection, Field, FieldInfo, FieldMetadata, SettingsSection, Subsections};

use super::check::{ANY, Checker};
use super::error::Problem;
use super::show::TomlWriter;
use super::toml_value::TomlValue;
use super::value_kinds::problem_at;
use input::SectionInput;
use section::{all_fields, fields_for, value_in_variant};
use value::FieldValue;

/// Implements [`SettingsSection`] for a struct. Arguments: description and defaults of the section, its subsections,
/// then its settings: description, key, kind of value, access to the value in the struct, and further metadata. `where`
/// lists overrides for some kinds of scene.
macro_rules! settings {
    (
        $(#[doc = $doc:literal])+
        $section:ident = $defaults:expr, $s:ident
            $(, $subsection:literal in $kinds:ident: $table:ty)* $(, where { $($overrides:tt)* })?;
        $($(#[doc = $field_doc:literal])* $key:literal: $kind:ty = $access:expr $(, $builder:ident($($argument:expr),*))*;)*
    ) => {
        impl $crate::scene::table::SettingsSection for $section {
            const DOC: &'static str = concat!($($doc),+);
            const SUBSECTIONS: $crate::scene::table::Subsections =
                &[$(($subsection, $kinds, $crate::scene::table::input::schema::<$table>)),*];
            const FIELDS: &'static [&'static dyn $crate::scene::table::Field<Self>] = &[$(
                &$crate::scene::table::FieldSpec::<Self, $kind>::new($key, concat!("" $(, $field_doc)*), |$s| $access)
                    $(.$builder($($argument),*))*
            ),*];

            fn defaults() -> Self {
                $defaults
            }

            $($($overrides)*)?
        }
    };
}

/// Access to a field of one variant of an enum.
macro_rules! variant_field {
    ($value:expr, $enum:ident::$variant:ident, $field:ident) => {
        match &mut $value {
            $enum::$variant { $field, .. } => Some($field),
            _ => None,
        }
    };
}

use {settings, variant_field};

/// Reads the values of a scene file over those of `base` and reports all problems; `path` is the path of the section,
/// such as `engine`, or empty for the top level.
pub fn read<T: SettingsSection>(checker: &mut Checker<'_>, path: &str, input: &SectionInput<'_>, mut base: T) -> T {
    read_fields(checker, path, input, &mut base);
    base
}

fn read_fields(checker: &mut Checker<'_>, path: &str, input: &SectionInput<'_>, section: &mut dyn DynSection) {
    let mut invalid: Vec<&str> = Vec::new();
    for (index, field) in fields_for(section, input.kind) {
        let FieldMetadata { key, depends_on, required, allowed, derived, .. } = *field.metadata();
        // If a choice is invalid, it is unknown whether the keys that depend on it have an effect.
        if depends_on.is_some_and(|(choice, _)| invalid.contains(&choice)) {
            continue;
        }
        let key_path = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        let default = section.get(index);
        match (input.get(key), &default) {
            (None, Some(default)) if !default.is_set() => {
                required.into_iter().for_each(|help| checker.report_missing_at(&key_path, input.span.clone(), help));
            }
            (None, _) => {}
            (Some(input_value), None) if depends_on.is_some() => {
                depends_on
                    .into_iter()
                    .for_each(|(_, reason)| checker.report_unused_at(&key_path, Some(input_value.span()), reason));
            }
            (Some(input_value), _) => match complete_pair(&key_path, input_value, default.as_ref(), derived)
                .and_then(|input_value| section.read(index, &key_path, &input_value))
            {
                Ok(true) => {}
                Ok(false) => checker.report_out_of_range(&key_path, Some(input_value.span()), allowed),
                Err(problems) => {
                    checker.extend(problems);
                    invalid.push(key);
                }
            },
        }
    }
}

/// Completes a pair with one set element: the other element is the default, or NaN if the default is `derived`.
fn complete_pair<'a>(
    key: &str,
    input_value: &'a Spanned<TomlValue>,
    default: Option<&FieldValue>,
    derived: bool,
) -> Result<Cow<'a, Spanned<TomlValue>>, Vec<Problem>> {
    let TomlValue::List(items) = input_value.get_ref() else { return Ok(Cow::Borrowed(input_value)) };
    let mut items = items.clone();
    for (index, item) in items.iter_mut().enumerate().filter(|(_, item)| matches!(item.get_ref(), TomlValue::Si(_))) {
        match default {
            Some(FieldValue::Quantities(values, _)) if derived || values[index].is_finite() => {
                *item.get_mut() = TomlValue::Si(values[index]);
            }
            _ => {
                let message = format!("only one element of `{key}` is set, and the other one has no default");
                let help = format!("give the whole pair: {key} = [.., ..]");
                return Err(vec![problem_at(input_value, message, "one of two", help)]);
            }
        }
    }
    Ok(Cow::Owned(Spanned::new(input_value.span(), TomlValue::List(items))))
}

/// Sets one value of a section from text, together with the choice that it depends on. Texts are read as in a scene,
/// but need no quotes. Returns `false`, and leaves the section unchanged, if the value is out of range.
///
/// # Errors
/// Returns a message if the key is unknown or the value is of the wrong kind.
pub fn set<T: SettingsSection>(section: &mut T, path: &str, key: &str, text: &str) -> Result<bool, String> {
    set_field(section, path, key, text)
}

fn set_field(section: &mut dyn DynSection, path: &str, key: &str, text: &str) -> Result<bool, String> {
    let fields = all_fields(section);
    let find = |key: &str| fields.iter().find(|(_, field)| field.metadata().key == key).copied();
    let (index, field) = find(key).ok_or_else(|| format!("[{path}] has no `{key}`"))?;
    let FieldMetadata { depends_on, .. } = *field.metadata();
    if let (None, Some((choice, _))) = (section.get(index), depends_on.and_then(|(choice, _)| find(choice))) {
        let chosen = section.variants(choice).into_iter().find_map(|mut variant| {
            variant.get(index)?;
            variant.get(choice)
        });
        chosen.into_iter().for_each(|keyword| _ = section.restore(choice, &keyword.into_record()));
    }
    let value = match (field.value_schema()["type"].as_str(), text.parse(), text.parse()) {
        (Some("integer" | "number"), Ok(integer), _) => TomlValue::Integer(integer),
        (Some("number"), _, Ok(number)) => TomlValue::Float(number),
        (Some("boolean"), ..) => text.parse().map_or_else(|_| TomlValue::Text(text.to_string()), TomlValue::Flag),
        _ => TomlValue::Text(text.to_string()),
    };
    let is_allowed = section.read(index, &format!("{path}.{key}"), &Spanned::new(0..text.len(), value));
    is_allowed.map_err(|problems| problems.into_iter().map(|problem| problem.message).collect::<Vec<_>>().join("; "))
}

/// Writes a section with all its values.
pub fn show<T: SettingsSection>(out: &mut TomlWriter, path: &str, section: &T) {
    out.section(path);
    show_keys(out, section, |_| true);
}

/// Writes the selected keys of a section that have a value.
pub fn show_keys<T: SettingsSection>(out: &mut TomlWriter, section: &T, is_selected: impl Fn(&str) -> bool) {
    for (metadata, value) in values(&mut section.clone()) {
        if metadata.scene_kinds.contains(&out.kind) && is_selected(metadata.key) && value.is_set() {
            value.write(out, metadata.key);
        }
    }
}

/// Returns the record of a section for a log: keys with their units, and values that parse back to the same bits.
pub fn record<T: SettingsSection>(path: &str, section: &T) -> Vec<(String, String)> {
    let values = values(&mut section.clone()).into_iter();
    values.map(|(metadata, value)| (record_name(path, metadata, &value), value.into_record())).collect()
}

/// Restores a section from the record in a log; `entry` returns the text recorded under a name.
///
/// # Errors
/// Returns the error of `entry`, or the one that `refuse` builds from the name, the invalid value and the allowed
/// values.
pub fn restore<T: SettingsSection, E>(
    path: &str,
    mut entry: impl FnMut(&str) -> Result<String, E>,
    refuse: impl Fn(String, String, String) -> E,
) -> Result<T, E> {
    let mut section = T::defaults();
    for (index, field) in all_fields(&section) {
        let Some(default) = DynSection::get(&mut section, index) else { continue };
        let name = record_name(path, field.metadata(), &default);
        let value = entry(&name)?;
        if !DynSection::restore(&mut section, index, &value) {
            return Err(refuse(name, value, describe_range(field)));
        }
    }
    Ok(section)
}

/// All values of a section.
fn values(section: &mut dyn DynSection) -> Vec<(&'static FieldMetadata, FieldValue)> {
    let fields = all_fields(section).into_iter();
    fields.filter_map(|(index, field)| Some((field.metadata(), section.get(index)?))).collect()
}

/// Returns the column name of every key of a section, with the value; `None` for a key that does not apply.
pub fn columns<T: SettingsSection>(section: &T) -> Vec<(String, Option<FieldValue>)> {
    named_values(&mut section.clone())
}

fn named_values(section: &mut dyn DynSection) -> Vec<(String, Option<FieldValue>)> {
    let fields = all_fields(section);
    let column = |(index, field): (usize, &'static dyn FieldInfo)| {
        let value = section.get(index);
        // If the section does not have the value, its unit is taken from a variant that has it.
        let with_unit = value.clone().or_else(|| value_in_variant(section, index))?;
        Some((column_name(field.metadata(), &with_unit), value))
    };
    fields.into_iter().filter_map(column).collect()
}

/// Name of a value in records of several sections.
fn record_name(path: &str, metadata: &FieldMetadata, value: &FieldValue) -> String {
    format!("{path}_{}", column_name(metadata, value))
}

/// Name of a value with its SI unit.
fn column_name(metadata: &FieldMetadata, value: &FieldValue) -> String {
    match (metadata.column, value.unit_suffix()) {
        (Some(name), _) => name.to_string(),
        (None, Some(unit)) => format!("{}_{unit}", metadata.key),
        (None, None) => metadata.key.to_string(),
    }
}

/// Describes the allowed values of a field.
fn describe_range(field: &dyn FieldInfo) -> String {
    let schema = field.value_schema();
    match (schema["enum"].as_array(), schema["type"].as_str(), &schema["maximum"]) {
        (Some(keywords), ..) => keywords.iter().map(Value::to_string).collect::<Vec<_>>().join(" or "),
        (_, Some("integer"), Value::Null) => "a whole number from 1".to_string(),
        (_, Some("integer"), max) => format!("a whole number from 1 to {max}"),
        (_, Some("boolean"), _) => "true or false".to_string(),
        _ if schema.get("minLength").is_some() => "a string".to_string(),
        _ if field.metadata().allowed.text == ANY.text => ANY.text.to_string(),
        _ => format!("a number {}", field.metadata().allowed.text),
    }
}
