//! A scene file as written, to be read section by section.
//!
//! In a gripper, the sections of a finger apply to both fingers; `[right]` and `[left]` contain the same sections for
//! one finger, which override the common ones.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::Side;
use super::keys::pair_element;
use super::keywords::SceneKind;
use super::precedence::{KIND_KEYS, replaced_keys};
use super::sections::FINGER_SECTIONS;
use super::table::input::{SectionInput, SectionValues};
use super::toml_value::TomlValue;

/// A scene without unknown keys.
#[derive(Debug)]
pub struct SceneInput {
    pub kind: SceneKind,
    values: SectionValues,
    /// Values of each finger of a gripper.
    fingers: Vec<SectionValues>,
    /// Positions of the names of discs.
    names: BTreeMap<String, Range<usize>>,
}

impl SceneInput {
    /// # Errors
    /// Returns an error if the deserialisation fails.
    pub fn parse(kind: SceneKind, document: Spanned<DeTable<'_>>) -> Result<Self, toml::de::Error> {
        let names = match document.get_ref().get("discs").map(Spanned::get_ref) {
            Some(DeValue::Table(discs)) => discs.keys().map(|name| (name.get_ref().to_string(), name.span())).collect(),
            _ => BTreeMap::new(),
        };
        let mut values = SectionValues::deserialize(Deserializer::from(document))?;
        merge_elements(&mut values);
        let mut input = Self { kind, values, fingers: Vec::new(), names };
        if input.sides().len() > 1 {
            input.fingers = Side::BOTH.map(|side| finger(&input.values, side)).into();
        }
        Ok(input)
    }

    /// Sides of the fingers; a single finger is the right one.
    pub fn sides(&self) -> &'static [Side] {
        &Side::BOTH[..self.kind.fingers()]
    }

    /// Returns the top level, with common values only.
    pub fn top_level(&self) -> SectionInput<'_> {
        SectionInput::top_level(self.kind, &self.values)
    }

    /// Returns the values of one finger, in the form of a scene with that finger only.
    pub fn finger(&self, side: Side) -> SectionInput<'_> {
        SectionInput::top_level(self.kind, self.fingers.get(side as usize).unwrap_or(&self.values))
    }

    /// Position of the name of a disc.
    pub fn name_span(&self, name: &str) -> Option<Range<usize>> {
        self.names.get(name).cloned()
    }
}

/// Merges single elements, such as `centre[0]`, into their pairs; the other element is NaN if the pair is not values.
fn merge_elements(values: &mut SectionValues) {
    let is_element = |(key, value): &(&String, &Spanned<TomlValue>)| {
        pair_element(key).is_some() && !matches!(value.get_ref(), TomlValue::Table(_))
    };
    let elements: Vec<String> = values.iter().filter(is_element).map(|(key, _)| key.clone()).collect();
    for key in elements {
        let (Some((pair, index)), Some(value)) = (pair_element(&key), values.remove(&key)) else { continue };
        let other = Spanned::new(value.span(), TomlValue::Si(f64::NAN));
        let new_pair = || Spanned::new(value.span(), TomlValue::List(vec![other; 2]));
        if let TomlValue::List(items) = values.entry(pair.to_string()).or_insert_with(new_pair).get_mut() {
            items.get_mut(index as usize).into_iter().for_each(|item| item.clone_from(&value));
        }
    }
    for value in values.values_mut() {
        if let TomlValue::Table(inner) = value.get_mut() {
            merge_elements(inner);
        }
    }
}

fn finger(values: &SectionValues, side: Side) -> SectionValues {
    let common = FINGER_SECTIONS.into_iter().filter_map(|key| values.get_key_value(key));
    let mut merged: SectionValues = common.map(|(key, value)| (key.clone(), value.clone())).collect();
    if let Some(TomlValue::Table(overriding)) = values.get(side.name()).map(Spanned::get_ref) {
        merge(&mut merged, overriding);
    }
    merged
}

/// Merges one table over another by the rules of extended scenes.
fn merge(merged: &mut SectionValues, overriding: &SectionValues) {
    replaced_keys(|key| overriding.contains_key(key)).for_each(|key| _ = merged.remove(key));
    for (key, value) in overriding {
        let (mut value, inherited) = (value.clone(), merged.remove(key).map(Spanned::into_inner));
        if let (TomlValue::Table(more), Some(TomlValue::Table(mut inner))) = (value.get_mut(), inherited)
            && !KIND_KEYS.iter().any(|kind| more.contains_key(*kind))
        {
            merge(&mut inner, more);
            *more = inner;
        }
        merged.insert(key.clone(), value);
    }
}
