//! A scene file as written, read section by section.
//!
//! In a gripper, the sections of a finger apply to both fingers; `[right]` and `[left]` contain the same sections for
//! one finger, which override the common ones.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table, Value};

use super::Side;
use super::check::Checker;
use super::error::Problem;
use super::keys::{child_schema, pair_element};
use super::keywords::SceneKind;
use super::precedence::{KIND_KEYS, replaced_keys};
use super::schema::{describe_limits, effect, field, is_within, schema_for, value_properties};
use super::toml_value::TomlValue;
use super::value::{ValueType, problem_at};

/// Values of a section by key.
type Values = BTreeMap<String, Spanned<TomlValue>>;

/// A scene without unknown keys.
#[derive(Debug)]
pub(crate) struct SceneInput {
    pub kind: SceneKind,
    values: Values,
    /// Values of each finger of a gripper.
    fingers: Vec<Values>,
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
        let values = Values::deserialize(Deserializer::from(document))?;
        let fingers = if kind.fingers() > 1 { Side::BOTH.map(|side| finger(&values, side)).into() } else { Vec::new() };
        Ok(Self { kind, values, fingers, names })
    }

    /// Sides of the fingers; a single finger is the right one.
    pub fn sides(&self) -> &'static [Side] {
        &Side::BOTH[..self.kind.fingers()]
    }

    /// Returns the top level, with common values only.
    pub(crate) fn top_level<'a>(&'a self, checker: &'a Checker<'a>) -> SectionInput<'a> {
        let (path, schema, values) = (String::new(), schema_for(self.kind), Some(&self.values));
        SectionInput { kind: self.kind, checker, path, schema, span: None, values }
    }

    /// Returns the values of one finger, in the form of a scene with that finger only.
    pub fn finger<'a>(&'a self, side: Side, checker: &'a Checker<'a>) -> SectionInput<'a> {
        SectionInput { values: self.fingers.get(side as usize).or(Some(&self.values)), ..self.top_level(checker) }
    }

    /// Position of the name of a disc.
    pub(crate) fn name_span(&self, name: &str) -> Option<Range<usize>> {
        self.names.get(name).cloned()
    }
}

/// Merges the values of one finger over the common ones.
fn finger(values: &Values, side: Side) -> Values {
    let of_finger =
        |key: &str| schema_for(SceneKind::Gripper)["properties"][side.name()]["properties"].get(key).is_some();
    let common = values.iter().filter(|(key, _)| of_finger(key));
    let mut merged: Values = common.map(|(key, value)| (key.clone(), value.clone())).collect();
    if let Some(TomlValue::Table(overriding)) = values.get(side.name()).map(Spanned::get_ref) {
        merge(&mut merged, overriding);
    }
    merged
}

/// Merges one table over another by the rules of extended scenes.
fn merge(merged: &mut Values, overriding: &Values) {
    replaced_keys(|key| overriding.contains_key(key)).for_each(|key| _ = merged.remove(key));
    merged.retain(|key, _| pair_element(key).is_none_or(|(pair, _)| !overriding.contains_key(pair)));
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

/// An optional section of a scene, as written.
#[derive(Clone)]
pub struct SectionInput<'a> {
    pub kind: SceneKind,
    /// Collects the problems.
    pub checker: &'a Checker<'a>,
    path: String,
    schema: &'static Json,
    /// Position of its header; `None` for the top level and for an omitted section.
    pub span: Option<Range<usize>>,
    values: Option<&'a Values>,
}

impl<'a> SectionInput<'a> {
    pub fn is_present(&self) -> bool {
        self.span.is_some()
    }

    fn get(&self, key: &str) -> Option<&'a Spanned<TomlValue>> {
        self.values?.get(key)
    }

    /// Single elements of a pair: `centre[0]`.
    fn elements(&self, key: &str) -> impl Iterator<Item = (usize, &'a Spanned<TomlValue>)> {
        [0, 1].into_iter().filter_map(move |index| Some((index, self.get(&format!("{key}[{index}]"))?)))
    }

    /// Position of the value of a key.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).or_else(|| self.elements(key).next().map(|(_, value)| value)).map(Spanned::span)
    }

    /// Position of one item of a list, or of the whole value if there is no such item.
    pub(crate) fn item_span(&self, key: &str, index: usize) -> Option<Range<usize>> {
        match self.get(key)?.get_ref() {
            TomlValue::List(items) => items.get(index).map(Spanned::span).or(self.span(key)),
            _ => self.span(key),
        }
    }

    pub fn has(&self, key: &str) -> bool {
        self.span(key).is_some()
    }

    /// Whether the value of a key is valid, or omitted.
    pub fn is_valid(&self, key: &str) -> bool {
        let Some((value, property)) = self.get(key).zip(child_schema(self.schema, key)) else { return true };
        let value = ValueType::from_schema(property).read(key, value);
        value.is_ok_and(|value| value.as_float().is_none_or(|number| is_within(number, property)))
    }

    /// Returns the subsection with this key.
    pub(crate) fn subsection(&self, key: &str) -> Self {
        let schema = child_schema(self.schema, key).unwrap_or(&Json::Null);
        let (span, values) = match self.get(key).map(|value| (value.span(), value.get_ref())) {
            Some((span, TomlValue::Table(values))) => (Some(span), Some(values)),
            _ => (None, None),
        };
        SectionInput { path: self.path(key), schema, span, values, ..*self }
    }

    /// All subsections with their names.
    pub(crate) fn subsections(&self) -> Vec<(&'a str, Self)> {
        self.values.into_iter().flatten().map(|(name, _)| (name.as_str(), self.subsection(name))).collect()
    }

    /// The same section with another collector of problems.
    pub(crate) fn with_checker<'b>(&self, checker: &'b Checker<'b>) -> SectionInput<'b>
    where
        'a: 'b,
    {
        SectionInput { checker, path: self.path.clone(), span: self.span.clone(), ..*self }
    }

    /// Full path of a key.
    pub fn path(&self, key: &str) -> String {
        [&self.path, key].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".")
    }

    /// Reads the section over its defaults and reports all its problems.
    pub fn read<T: DeserializeOwned>(&self) -> T {
        self.read_over(&Table::new())
    }

    /// Reads the section over these values.
    ///
    /// # Panics
    /// Panics if a required value of the type has no default: its field must be an option.
    pub(crate) fn read_over<T: DeserializeOwned>(&self, base: &impl Serialize) -> T {
        let mut values = Table::new();
        for (_, property) in value_properties(self.schema) {
            let default = property.get("x-si").and_then(|si| Value::try_from(si).ok());
            default.into_iter().for_each(|si| _ = values.insert(field(property).to_string(), si));
        }
        values.extend(Table::try_from(base).unwrap_or_default());
        self.read_values(&mut values);
        T::deserialize(Value::Table(values)).expect("keys without default are options")
    }

    fn read_values(&self, values: &mut Table) {
        let mut invalid: Vec<&str> = Vec::new();
        for (key, property) in value_properties(self.schema) {
            let effect = effect(property, self.schema, values);
            let (field, span) = (field(property), self.span(key));
            match (effect, &span) {
                // If a choice is invalid, it is unknown whether the keys that depend on it have an effect.
                _ if !invalid.is_empty()
                    && super::schema::condition(property).is_some_and(|(choice, _)| invalid.contains(&choice)) => {}
                (Err(_), None) => {}
                (Err((choice, chosen, allowed)), Some(_)) => {
                    let quoted = |value: &str| {
                        if ["true", "false"].contains(&value) { value.to_string() } else { format!("\"{value}\"") }
                    };
                    let allowed: Vec<String> =
                        allowed.into_iter().map(|value| format!("{choice} = {}", quoted(value))).collect();
                    let help = format!("remove it, or write {}", allowed.join(" or "));
                    self.checker.report_no_effect(
                        &self.path(key),
                        span,
                        &format!("with {choice} = {}", quoted(&chosen)),
                        &help,
                    );
                }
                (Ok(()), None) => {
                    let help = property["x-required"].as_str().filter(|_| !values.contains_key(field));
                    let has_alternative = property["x-alternative"].as_str().is_some_and(|other| self.has(other));
                    help.into_iter().filter(|_| !has_alternative).for_each(|help| self.report_missing(key, help));
                }
                (Ok(()), Some(_)) => match self.read_value(key, property, values.get(field)) {
                    Ok(value) if value.as_float().is_none_or(|number| is_within(number, property)) => {
                        values.insert(field.to_string(), value);
                    }
                    Ok(_) => self.report_out_of_range(key, &describe_limits(property)),
                    Err(problems) => {
                        self.checker.extend(problems);
                        invalid.push(key);
                    }
                },
            }
        }
    }

    /// Reads a value or the single elements of a pair, in SI units.
    fn read_value(&self, key: &str, property: &Json, default: Option<&Value>) -> Result<Value, Vec<Problem>> {
        let (path, value_type) = (self.path(key), ValueType::from_schema(property));
        let mut value = self.get(key).map(|value| value_type.read(&path, value)).transpose()?;
        for (index, element) in self.elements(key) {
            let ValueType::List(item, _) = &value_type else { continue };
            let si = item.read(&path, element)?;
            let pair = value.get_or_insert_with(|| match default {
                Some(pair) => pair.clone(),
                None => Value::Array(vec![Value::Float(f64::NAN); 2]),
            });
            pair.as_array_mut().into_iter().for_each(|pair| pair[index].clone_from(&si));
        }
        let lacks_element = value.as_ref().and_then(Value::as_array).is_some_and(|items| {
            items.iter().any(|item| item.as_float().is_some_and(f64::is_nan)) && property.get("x-derived").is_none()
        });
        match (value, self.elements(key).next()) {
            (Some(_), Some((_, element))) if lacks_element => {
                let message = format!("only one element of `{path}` is set, and the other one has no default");
                let help = format!("give the whole pair: {path} = [.., ..]");
                Err(vec![problem_at(element, message, "one of two", help)])
            }
            (value, _) => value.ok_or_else(Vec::new),
        }
    }

    /// Reports a problem of a key, or of the section if the key is omitted.
    pub fn report(&self, key: &str, message: impl Into<String>, label: &str, help: impl Into<String>) {
        self.checker.push(Problem::new(self.span(key).or(self.span.clone()), message, label, help));
    }

    /// Reports a number out of range.
    pub(crate) fn report_out_of_range(&self, key: &str, allowed: &str) {
        let span = self.span(key);
        let message = format!("`{}` is {}, but must be {allowed}", self.path(key), self.checker.quoted(span.clone()));
        self.checker.push(Problem::new(span, message, "not allowed", format!("allowed values: {allowed}")));
    }

    /// Reports a missing key.
    pub(crate) fn report_missing(&self, key: &str, help: &str) {
        self.checker.report_missing_at(&self.path(key), self.span.clone(), help);
    }

    /// Reports that a key has no effect, if it is given.
    pub(crate) fn report_unused(&self, key: &str, reason: &str) {
        self.checker.report_unused_at(&self.path(key), self.span(key), reason);
    }
}
