//! Values of settings: conversion to TOML, JSON and records, and back from records.

use serde_json::{Value, json};

use crate::scene::show::TomlWriter;
use crate::scene::value_kinds::{
    Choice, Count, Flag, InputKind, Keyword, List, Number, Pair, Quantifiable, SweepCount, Text,
};
use crate::units::{self, Dimension};

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValue {
    Quantity(f64, Dimension),
    Quantities(Vec<f64>, Dimension),
    Number(f64),
    Integer(u64),
    Flag(bool),
    Keyword(&'static str),
    Text(String),
}

/// A kind of value that a setting can have.
pub trait ValueKind: InputKind {
    fn to_field_value(value: &Self::Value) -> FieldValue;

    /// Parses a value [recorded](FieldValue::into_record) as text.
    fn restore(text: &str) -> Option<Self::Value>;

    /// All values of a choice; empty for other kinds.
    fn choices() -> Vec<Self::Value> {
        Vec::new()
    }
}

impl FieldValue {
    pub fn as_number(&self) -> Option<f64> {
        match self {
            FieldValue::Quantity(number, _) | FieldValue::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// Whether the value is present: a NaN, an empty text and an empty list are not.
    pub fn is_set(&self) -> bool {
        match self {
            FieldValue::Quantities(values, _) => !values.is_empty() && values.iter().copied().all(f64::is_finite),
            FieldValue::Text(text) => !text.is_empty(),
            other => other.as_number().is_none_or(f64::is_finite),
        }
    }

    /// Suffix of names for the SI unit.
    pub fn unit_suffix(&self) -> Option<&'static str> {
        match self {
            FieldValue::Quantity(_, dimension) | FieldValue::Quantities(_, dimension) => Some(dimension.suffix()),
            _ => None,
        }
    }

    /// Returns the value as written in a scene file.
    pub fn into_json(self) -> Value {
        match self {
            FieldValue::Quantity(value, dimension) => units::format(value, dimension).into(),
            FieldValue::Quantities(values, dimension) => {
                values.into_iter().map(|value| units::format(value, dimension)).collect()
            }
            FieldValue::Number(value) => json!(value),
            FieldValue::Integer(count) => json!(count),
            FieldValue::Flag(flag) => json!(flag),
            FieldValue::Keyword(keyword) => json!(keyword),
            FieldValue::Text(text) => json!(text),
        }
    }

    /// Returns the value with quantities as plain numbers in SI units.
    pub fn into_si_json(self) -> Value {
        match self {
            FieldValue::Quantity(value, _) => json!(value),
            FieldValue::Quantities(values, _) => json!(values),
            other => other.into_json(),
        }
    }

    /// Returns the value in SI units as a text that parses back to the same bits.
    pub fn into_record(self) -> String {
        match self {
            FieldValue::Quantity(value, _) | FieldValue::Number(value) => format!("{value:?}"),
            FieldValue::Quantities(values, _) => {
                values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(" ")
            }
            FieldValue::Integer(count) => count.to_string(),
            FieldValue::Flag(flag) => flag.to_string(),
            FieldValue::Keyword(keyword) => keyword.to_string(),
            FieldValue::Text(text) => text,
        }
    }

    pub fn write(self, out: &mut TomlWriter, key: &str) {
        match self {
            FieldValue::Quantity(value, dimension) => out.quantity(key, value, dimension),
            FieldValue::Quantities(values, dimension) => out.quantities(key, &values, dimension),
            FieldValue::Number(value) => out.float(key, value),
            FieldValue::Integer(count) => out.raw(key, count),
            FieldValue::Flag(flag) => out.raw(key, flag),
            FieldValue::Keyword(keyword) => out.text(key, keyword),
            FieldValue::Text(text) => out.text(key, &text),
        }
    }
}

impl<Q: Quantifiable> ValueKind for Q {
    fn to_field_value(value: &f64) -> FieldValue {
        FieldValue::Quantity(*value, Q::DIMENSION)
    }

    fn restore(text: &str) -> Option<f64> {
        Number::restore(text).filter(|value| value.abs() <= Q::DIMENSION.max_si())
    }
}

impl<Q: Quantifiable> ValueKind for List<Q> {
    fn to_field_value(value: &Vec<f64>) -> FieldValue {
        FieldValue::Quantities(value.clone(), Q::DIMENSION)
    }

    fn restore(text: &str) -> Option<Vec<f64>> {
        text.split(' ').map(Q::restore).collect()
    }
}

impl<Q: Quantifiable> ValueKind for Pair<Q> {
    fn to_field_value(value: &[f64; 2]) -> FieldValue {
        FieldValue::Quantities(value.to_vec(), Q::DIMENSION)
    }

    fn restore(text: &str) -> Option<[f64; 2]> {
        <List<Q> as ValueKind>::restore(text)?.try_into().ok()
    }
}

impl ValueKind for Number {
    fn to_field_value(value: &f64) -> FieldValue {
        FieldValue::Number(*value)
    }

    fn restore(text: &str) -> Option<f64> {
        text.parse().ok().filter(|value: &f64| value.is_finite())
    }
}

impl ValueKind for Count {
    fn to_field_value(value: &u64) -> FieldValue {
        FieldValue::Integer(*value)
    }

    fn restore(text: &str) -> Option<u64> {
        text.parse().ok().filter(|count| *count >= 1)
    }
}

impl ValueKind for SweepCount {
    fn to_field_value(value: &u32) -> FieldValue {
        FieldValue::Integer((*value).into())
    }

    fn restore(text: &str) -> Option<u32> {
        text.parse().ok().filter(|count| (1..=SweepCount::MAX).contains(count))
    }
}

impl ValueKind for Flag {
    fn to_field_value(value: &bool) -> FieldValue {
        FieldValue::Flag(*value)
    }

    fn restore(text: &str) -> Option<bool> {
        text.parse().ok()
    }
}

impl ValueKind for Text {
    fn to_field_value(value: &String) -> FieldValue {
        FieldValue::Text(value.clone())
    }

    fn restore(text: &str) -> Option<String> {
        Some(text.to_string()).filter(|text| !text.trim().is_empty())
    }
}

impl<W: Keyword> ValueKind for Choice<W> {
    fn to_field_value(value: &W) -> FieldValue {
        FieldValue::Keyword(value.keyword())
    }

    fn restore(text: &str) -> Option<W> {
        W::KEYWORDS.iter().find(|(keyword, _)| *keyword == text).map(|(_, value)| value.clone())
    }

    fn choices() -> Vec<W> {
        W::KEYWORDS.iter().map(|(_, value)| value.clone()).collect()
    }
}
