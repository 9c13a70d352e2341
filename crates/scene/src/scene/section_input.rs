//! A scene file as written, read section by section.
//!
//! In a gripper, the sections of a finger apply to both fingers; `[right]` and `[left]` contain the same sections for
//! one finger, which override the common ones.

use std::ops::Range;

use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table, Value};

use super::Side;
use super::check::Checker;
use super::error::Problem;
use super::keywords::SceneKind;
use super::precedence::merge;
use super::section::{Key, NO_SECTION, Section};
use super::value::{ValueType, dimension_of};
use super::written::{problem_at, type_name};
use crate::units::{Dimension, is_expression};

/// A scene without unknown keys.
#[derive(Debug)]
pub(crate) struct SceneInput<'t> {
    pub kind: SceneKind,
    schema: &'static Section,
    values: DeTable<'t>,
    /// Values of each finger of a gripper.
    fingers: Vec<DeTable<'t>>,
}

impl<'t> SceneInput<'t> {
    /// Creates the input from a document without unknown keys.
    ///
    /// # Errors
    /// Returns an error if a number has too many digits.
    pub fn parse(
        kind: SceneKind,
        schema: &'static Section,
        document: Spanned<DeTable<'t>>,
    ) -> Result<Self, toml::de::Error> {
        // The parser leaves numbers as texts.
        IgnoredAny::deserialize(Deserializer::from(document.clone()))?;
        let values = document.into_inner();
        let fingers =
            if kind.fingers() > 1 { Side::BOTH.map(|side| finger(&values, schema, side)).into() } else { Vec::new() };
        Ok(Self { kind, schema, values, fingers })
    }

    /// Sides on which there are fingers; a single finger is on the right.
    pub fn sides(&self) -> &'static [Side] {
        &Side::BOTH[..self.kind.fingers()]
    }

    /// Returns the top level, with common values only.
    pub(crate) fn top_level<'a>(&'a self, checker: &'a Checker<'a>) -> SectionInput<'a> {
        let (path, schema, values) = (String::new(), self.schema, Some(&self.values));
        SectionInput { kind: self.kind, checker, path, schema, name_span: None, span: None, values }
    }

    /// Returns the values of one finger, in the form of a scene with that finger only.
    pub fn finger<'a>(&'a self, side: Side, checker: &'a Checker<'a>) -> SectionInput<'a> {
        SectionInput { values: self.fingers.get(side as usize).or(Some(&self.values)), ..self.top_level(checker) }
    }
}

/// Merges the values of one finger over the common ones.
fn finger<'t>(values: &DeTable<'t>, schema: &Section, side: Side) -> DeTable<'t> {
    fn as_table<'v, 't>(value: &'v mut Spanned<DeValue<'t>>) -> Option<&'v mut DeTable<'t>> {
        if let DeValue::Table(table) = value.get_mut() { Some(table) } else { None }
    }
    let of_finger = schema.subsection(side.name()).unwrap_or(&NO_SECTION);
    let is_of_finger = |key: &str| of_finger.key(key).is_some() || of_finger.subsection(key).is_some();
    let common = values.iter().filter(|(key, _)| is_of_finger(key.get_ref()));
    let mut merged: DeTable<'t> = common.map(|(key, value)| (key.clone(), value.clone())).collect();
    if let Some(overriding) = values.get(side.name()).and_then(|value| value.get_ref().as_table()) {
        merge(&mut merged, overriding.clone(), true, as_table);
    }
    merged
}

/// A section within another section, as a field of the settings of the outer section. It is read separately.
pub type Subsection = Option<IgnoredAny>;

/// An optional section of a scene, as written.
#[derive(Clone)]
pub struct SectionInput<'a> {
    pub kind: SceneKind,
    /// Collector of the problems.
    pub checker: &'a Checker<'a>,
    path: String,
    schema: &'static Section,
    /// Position of the name of the section; `None` for the top level, for an omitted section, and in lists.
    pub name_span: Option<Range<usize>>,
    /// Position of the header of the section; `None` for the top level and for an omitted section.
    pub span: Option<Range<usize>>,
    values: Option<&'a DeTable<'a>>,
}

impl<'a> SectionInput<'a> {
    pub fn is_present(&self) -> bool {
        self.span.is_some()
    }

    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.values?.get(key)
    }

    /// The text under a key; `None` if it is omitted or another value.
    pub(crate) fn text(&self, key: &str) -> Option<&'a str> {
        self.get(key)?.get_ref().as_str()
    }

    /// The items of a list.
    fn items(&self, key: &str) -> Option<&'a [Spanned<DeValue<'a>>]> {
        self.get(key)?.get_ref().as_array().map(|items| &**items)
    }

    /// Single elements of a pair: `centre[0]`.
    fn elements(&self, key: &str) -> impl Iterator<Item = (usize, &'a Spanned<DeValue<'a>>)> {
        let elements =
            [0, 1].map(|index| self.values.and_then(|values| Some((index, values.get(&*format!("{key}[{index}]"))?))));
        elements.into_iter().flatten()
    }

    /// Position of the value of a key.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        self.get(key).or_else(|| self.elements(key).next().map(|(_, value)| value)).map(Spanned::span)
    }

    /// Position of one item of a list, or of the whole value if there is no such item.
    pub(crate) fn item_span(&self, key: &str, index: usize) -> Option<Range<usize>> {
        self.items(key).and_then(|items| items.get(index)).map(Spanned::span).or(self.span(key))
    }

    pub fn has(&self, key: &str) -> bool {
        self.span(key).is_some()
    }

    /// Whether the value of a key is valid, or the key is omitted.
    pub fn is_valid(&self, key: &str) -> bool {
        let Some((value, key)) = self.get(key).zip(self.schema.key(key)) else { return true };
        key.value_type.read(key.name, value, &self.checker.parameters).is_ok_and(|value| key.allows(&value))
    }

    /// Returns the same values with the schema of a top level.
    pub(crate) fn with_schema(&self, kind: SceneKind, schema: &'static Section) -> Self {
        SectionInput { kind, schema, ..self.clone() }
    }

    /// Returns the subsection with this key.
    pub(crate) fn subsection(&self, key: &str) -> Self {
        let schema = self.schema.subsection(key).unwrap_or(&NO_SECTION);
        let section = self.values.and_then(|values| {
            let (name, value) = values.get_key_value(key)?;
            Some((name.span(), value.span(), value.get_ref().as_table()?))
        });
        let (name_span, span, values) = match section {
            Some((name, header, values)) => (Some(name), Some(header), Some(values)),
            None => (None, None, None),
        };
        SectionInput { path: self.path(key), schema, name_span, span, values, ..*self }
    }

    /// All subsections with their names.
    pub(crate) fn subsections(&self) -> Vec<(&'a str, Self)> {
        let names = self.values.into_iter().flatten().map(|(name, _)| name.get_ref().as_ref());
        names.map(|name| (name, self.subsection(name))).collect()
    }

    /// Tables of a list, such as [[contacts]]; reports another value.
    pub(crate) fn list(&self, key: &str) -> Vec<Self> {
        let schema = self.schema.subsection(key).unwrap_or(&NO_SECTION);
        let Some(value) = self.get(key) else { return Vec::new() };
        let items = self.items(key).unwrap_or(std::slice::from_ref(value));
        let mut tables = Vec::new();
        for (index, item) in items.iter().enumerate() {
            let DeValue::Table(values) = item.get_ref() else {
                let found = type_name(item.get_ref());
                let message = format!("`{}` is {found}, but must be a list of tables", self.path(key));
                let help = format!("begin each table with [[{}]]", self.path(key));
                self.checker.push(Problem::new(Some(item.span()), message, "expected a table", help));
                continue;
            };
            let (path, span) = (format!("{}[{index}]", self.path(key)), Some(item.span()));
            tables.push(SectionInput { path, schema, name_span: None, span, values: Some(values), ..*self });
        }
        tables
    }

    /// All keys that the section may have.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.schema.keys().iter().map(|key| key.name)
    }

    /// Dimensions that the values of a key may have.
    pub(crate) fn alternatives(&self, key: &str) -> Vec<Dimension> {
        let dimensions = |value_type: &ValueType| match value_type {
            ValueType::Quantity(dimension) => vec![*dimension],
            ValueType::OneOf(dimensions) => dimensions.clone(),
            _ => Vec::new(),
        };
        match self.schema.key(key).map(|key| &key.value_type) {
            Some(ValueType::List(item, _)) => dimensions(item),
            value_type => value_type.map(dimensions).unwrap_or_default(),
        }
    }

    /// Dimensions of the values of a key as written.
    pub(crate) fn dimensions(&self, key: &str) -> Vec<Dimension> {
        let among = self.alternatives(key);
        let values = self.items(key).or(self.get(key).map(std::slice::from_ref)).unwrap_or_default();
        values
            .iter()
            .filter_map(|value| dimension_of(value.get_ref().as_str()?, &among, &self.checker.parameters))
            .collect()
    }

    /// Returns a result whose problems are reported elsewhere.
    pub(crate) fn quietly<T>(&self, read: impl FnOnce(&Self) -> T) -> T {
        let count = self.checker.count();
        let result = read(self);
        self.checker.take_after(count);
        result
    }

    /// Returns a single value, or its default; `None` without either, and if it is invalid, which [`SectionInput::read`]
    /// reports.
    pub(crate) fn value<T: DeserializeOwned>(&self, key: &str) -> Option<T> {
        let key = self.schema.key(key)?;
        let value = match self.has(key.name) {
            true => self.read_value(key, key.default.as_ref()).ok().filter(|value| key.allows(value)),
            false => None,
        };
        T::deserialize(value.or_else(|| key.default.clone())?).ok()
    }

    /// Full path of a key.
    pub fn path(&self, key: &str) -> String {
        [&self.path, key].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".")
    }

    /// Reads the section and reports all its problems. Omitted keys have their defaults.
    pub fn read<T: DeserializeOwned>(&self) -> T {
        self.read_over(&Table::new())
    }

    /// Reads the section over these values.
    ///
    /// # Panics
    /// Panics if a required value of the type has no default: its field must be an option.
    pub(crate) fn read_over<T: DeserializeOwned>(&self, base: &impl Serialize) -> T {
        let defaults = self.schema.keys().iter().filter_map(|key| Some((key.field.to_string(), key.default.clone()?)));
        let mut values: Table = defaults.collect();
        values.extend(Table::try_from(base).unwrap_or_default());
        self.read_values(&mut values);
        T::deserialize(Value::Table(values)).expect("keys without default are options")
    }

    fn read_values(&self, values: &mut Table) {
        let mut invalid: Vec<&str> = Vec::new();
        for key in self.schema.keys() {
            let span = self.span(key.name);
            match (self.schema.effect(key, values), &span) {
                // If a choice is invalid, it is unknown whether the keys that depend on it have an effect.
                _ if key.condition.as_ref().is_some_and(|(choice, _)| invalid.contains(choice)) => {}
                (Err(_), None) => {}
                (Err((choice, chosen, allowed)), Some(_)) => {
                    let quoted = |value: &str| {
                        if ["true", "false"].contains(&value) { value.to_string() } else { format!("\"{value}\"") }
                    };
                    let allowed: Vec<String> =
                        allowed.iter().map(|value| format!("{choice} = {}", quoted(value))).collect();
                    let help = format!("remove it, or write {}", allowed.join(" or "));
                    let reason = format!("with {choice} = {}", quoted(&chosen));
                    self.checker.report_no_effect(&self.path(key.name), span, &reason, &help);
                }
                (Ok(()), None) => {
                    let text = |keyword: &str| key.schema.get(keyword)?.as_str();
                    let help = text("x-required").filter(|_| !values.contains_key(key.field));
                    let has_alternative =
                        || text("x-alternative").is_some_and(|others| others.split('|').any(|other| self.has(other)));
                    help.into_iter()
                        .filter(|_| !has_alternative())
                        .for_each(|help| self.report_missing(key.name, help));
                }
                (Ok(()), Some(_)) => match self.read_value(key, values.get(key.field)) {
                    Ok(value) if key.allows(&value) => _ = values.insert(key.field.to_string(), value),
                    Ok(_) => self.report_out_of_range(key.name, &key.limits()),
                    Err(problems) => {
                        self.checker.extend(problems);
                        invalid.push(key.name);
                    }
                },
            }
        }
    }

    /// Reads a value or the single elements of a pair, in SI units.
    fn read_value(&self, key: &Key, default: Option<&Value>) -> Result<Value, Vec<Problem>> {
        let (path, parameters) = (self.path(key.name), &self.checker.parameters);
        let mut value = self.get(key.name).map(|value| key.value_type.read(&path, value, parameters)).transpose()?;
        for (index, element) in self.elements(key.name) {
            let ValueType::List(item, _) = &key.value_type else { continue };
            let si = item.read(&path, element, parameters)?;
            let pair = value.get_or_insert_with(|| match default {
                Some(pair) => pair.clone(),
                None => Value::Array(vec![Value::Float(f64::NAN); 2]),
            });
            pair.as_array_mut().into_iter().for_each(|pair| pair[index].clone_from(&si));
        }
        let lacks_element = value.as_ref().and_then(Value::as_array).is_some_and(|items| {
            items.iter().any(|item| item.as_float().is_some_and(f64::is_nan)) && key.schema.get("x-derived").is_none()
        });
        match (value, self.elements(key.name).next()) {
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

    /// Reports a problem of a value that is required: there is no result.
    pub(crate) fn refuse<T>(
        &self,
        key: &str,
        message: impl Into<String>,
        label: &str,
        help: impl Into<String>,
    ) -> Option<T> {
        self.report(key, message, label, help);
        None
    }

    /// Reports a number out of range.
    pub(crate) fn report_out_of_range(&self, key: &str, allowed: &str) {
        let span = self.span(key);
        let text = self.checker.quoted(span.clone());
        let value =
            self.text(key).filter(|text| is_expression(text)).and_then(|text| self.checker.parameters.value(text));
        let text = value.map_or(text.to_string(), |value| format!("{text} = {value}"));
        let message = format!("`{}` is {text}, but must be {allowed}", self.path(key));
        self.checker.push(Problem::new(span, message, "not allowed", format!("allowed values: {allowed}")));
    }

    /// Reports a missing key.
    pub(crate) fn report_missing(&self, key: &str, help: &str) {
        self.checker.report_missing_at(&self.path(key), self.span.clone(), help);
    }

    /// Reports a missing key: there is no result.
    pub(crate) fn refuse_missing<T>(&self, key: &str, help: &str) -> Option<T> {
        self.report_missing(key, help);
        None
    }

    /// Reports that keys have no effect, if they are given.
    pub(crate) fn report_unused<'k>(&self, keys: impl IntoIterator<Item = &'k str>, reason: &str) {
        for key in keys {
            self.checker.report_unused_at(&self.path(key), self.span(key), reason);
        }
    }
}
