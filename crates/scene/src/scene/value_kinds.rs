//! Kinds of values of keys: quantities, numbers, keywords, pairs and lists.

use std::marker::PhantomData;
use std::mem::discriminant;

use schemars::{Schema, json_schema};
use toml::Spanned;

use super::error::Problem;
use super::suggest::{closest_match, find_unsupported};
use super::toml_value::TomlValue;
use crate::units::{self, Dimension};

/// A kind of value: how it is read from a file, and its schema.
pub trait InputKind {
    type Value;
    const NAME: &'static str;

    /// Reads the value of `key`, given with its full path for messages.
    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<Self::Value, Vec<Problem>>;

    fn schema() -> Schema;
}

/// A quantity of one dimension.
pub trait Quantifiable {
    const DIMENSION: Dimension;
}

macro_rules! quantities {
    ($($name:ident)*) => {$(
        #[derive(Debug)]
        pub struct $name;

        impl Quantifiable for $name {
            const DIMENSION: Dimension = Dimension::$name;
        }
    )*};
}

quantities!(Length Angle Time Mass Force Torque Speed AngularRate Acceleration Density Inertia Frequency Pressure);
quantities!(AngularStiffness LinearDamping AngularDamping);

impl<M: Quantifiable> InputKind for M {
    type Value = f64;
    const NAME: &'static str = "Quantity";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<f64, Vec<Problem>> {
        read_quantity(key, value, M::DIMENSION)
    }

    fn schema() -> Schema {
        json_schema!({
            "type": "string",
            "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*\S.*$",
            "examples": [M::DIMENSION.example()],
            "x-units": M::DIMENSION.units().iter().map(|u| u.name).collect::<Vec<_>>(),
        })
    }
}

/// Reads a quantity of one dimension.
pub fn read_quantity(key: &str, value: &Spanned<TomlValue>, expected: Dimension) -> Result<f64, Vec<Problem>> {
    let help = || format!("write a number and its unit, as in \"{}\"", expected.example());
    if let TomlValue::Si(si) = value.get_ref() {
        return Ok(*si);
    }
    let TomlValue::Text(text) = value.get_ref() else {
        let message = format!(
            "`{key}` is {}; expected {} as a string with its unit: {}",
            value.get_ref().name(),
            expected.name(),
            expected.unit_list()
        );
        return Err(vec![problem_at(value, message, expected.name(), help())]);
    };
    units::parse(text, expected).map_err(|e| vec![problem_at(value, format!("`{key}`: {e}"), expected.name(), help())])
}

/// Two quantities, such as the coordinates of a point.
#[derive(Debug)]
pub struct Pair<M>(PhantomData<M>);

impl<M: Quantifiable> InputKind for Pair<M> {
    type Value = [f64; 2];
    const NAME: &'static str = "Pair";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<[f64; 2], Vec<Problem>> {
        // The example takes a single value as y, which is the usual case for gravity and most other vectors.
        let example = match value.get_ref() {
            TomlValue::Integer(y) => format!("{y} {}", M::DIMENSION.units()[0].name),
            TomlValue::Float(y) => format!("{y} {}", M::DIMENSION.units()[0].name),
            TomlValue::Text(y) if units::parse(y, M::DIMENSION).is_ok() => y.trim().to_string(),
            _ => M::DIMENSION.example().to_string(),
        };
        let pair = format!("write x and y: [\"0 {}\", \"{example}\"]", M::DIMENSION.units()[0].name);
        let TomlValue::List(_) = value.get_ref() else {
            let message = format!("`{key}` is {}, but must be a list of two values", value.get_ref().name());
            return Err(vec![problem_at(value, message, "two values in brackets", pair)]);
        };
        let list = <List<M>>::read(key, value)?;
        <[f64; 2]>::try_from(list).map_err(|list| {
            let message = format!("`{key}` has {} values, but must have two, x and y", list.len());
            vec![problem_at(value, message, "two values", pair)]
        })
    }

    fn schema() -> Schema {
        json_schema!({ "type": "array", "items": M::schema(), "minItems": 2, "maxItems": 2 })
    }
}

/// Any number of quantities.
#[derive(Debug)]
pub struct List<M>(PhantomData<M>);

impl<M: Quantifiable> InputKind for List<M> {
    type Value = Vec<f64>;
    const NAME: &'static str = "List";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<Vec<f64>, Vec<Problem>> {
        let example = M::DIMENSION.example();
        let TomlValue::List(items) = value.get_ref() else {
            let message = format!("`{key}` is {}, but must be a list", value.get_ref().name());
            let help = format!("write [\"{example}\", \"{example}\"]");
            return Err(vec![problem_at(value, message, "a list in brackets", help)]);
        };
        let (mut values, mut problems) = (Vec::with_capacity(items.len()), Vec::new());
        for item in items {
            match M::read(key, item) {
                Ok(value) => values.push(value),
                Err(more) => problems.extend(more),
            }
        }
        if problems.is_empty() { Ok(values) } else { Err(problems) }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "array", "items": M::schema() })
    }
}

/// A plain number: a ratio, or a value in SI units if its unit has a fractional power.
#[derive(Debug)]
pub struct Number;

impl InputKind for Number {
    type Value = f64;
    const NAME: &'static str = "Number";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<f64, Vec<Problem>> {
        let type_error = |message, help: &str| Err(vec![problem_at(value, message, "a number", help.to_string())]);
        match value.get_ref() {
            TomlValue::Integer(i) => Ok(*i as f64),
            TomlValue::Float(x) if x.is_finite() => Ok(*x),
            TomlValue::Float(x) => type_error(format!("`{key}` is {x}, but must be finite"), "write a finite number"),
            TomlValue::Text(_) => type_error(
                format!("`{key}` is a string, but must be a plain number"),
                "write it without quotes and unit, in SI units: 0.8 or 1e8",
            ),
            other => type_error(
                format!("`{key}` is {}, but must be a plain number", other.name()),
                "write a number such as 0.8 or 1e8",
            ),
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "number" })
    }
}

/// A positive integer.
#[derive(Debug)]
pub struct Count;

impl Count {
    /// Largest integer of TOML.
    pub const MAX: u64 = i64::MAX as u64;
}

impl InputKind for Count {
    type Value = u64;
    const NAME: &'static str = "Count";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<u64, Vec<Problem>> {
        match value.get_ref() {
            TomlValue::Integer(i) if *i >= 1 => Ok(*i as u64),
            other => {
                let found = match other {
                    TomlValue::Integer(i) => i.to_string(),
                    other => other.name().to_string(),
                };
                let message = format!("`{key}` is {found}, but must be a whole number from 1");
                let help = "write a number without point, exponent or quotes: 1_000_000".to_string();
                Err(vec![problem_at(value, message, "a whole number", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "integer", "minimum": 1 })
    }
}

/// Sweeps of a solver over its constraints in one step. Bounded, because the step budget cannot end a run if a single
/// step takes too long.
#[derive(Debug)]
pub struct SweepCount;

impl SweepCount {
    pub const MAX: u32 = 10_000;
}

impl InputKind for SweepCount {
    type Value = u32;
    const NAME: &'static str = "Sweeps";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<u32, Vec<Problem>> {
        let found = match value.get_ref() {
            TomlValue::Integer(i) => match u32::try_from(*i) {
                Ok(count @ 1..=Self::MAX) => return Ok(count),
                _ => i.to_string(),
            },
            other => other.name().to_string(),
        };
        let range = format!("from 1 to {}", Self::MAX);
        let message = format!("`{key}` is {found}, but must be a whole number {range}");
        let help = format!("write a number {range} without point, exponent or quotes: 20");
        Err(vec![problem_at(value, message, range, help)])
    }

    fn schema() -> Schema {
        json_schema!({ "type": "integer", "minimum": 1, "maximum": Self::MAX })
    }
}

/// `true` or `false`.
#[derive(Debug)]
pub struct Flag;

impl InputKind for Flag {
    type Value = bool;
    const NAME: &'static str = "Flag";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<bool, Vec<Problem>> {
        match value.get_ref() {
            TomlValue::Flag(flag) => Ok(*flag),
            other => {
                let message = format!("`{key}` is {}, but must be true or false", other.name());
                let help = "write true or false, without quotes".to_string();
                Err(vec![problem_at(value, message, "true or false", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "boolean" })
    }
}

/// Non-empty text.
#[derive(Debug)]
pub struct Text;

impl InputKind for Text {
    type Value = String;
    const NAME: &'static str = "Text";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<String, Vec<Problem>> {
        match value.get_ref() {
            TomlValue::Text(text) if !text.trim().is_empty() => Ok(text.clone()),
            other => {
                let found = if matches!(other, TomlValue::Text(_)) { "empty" } else { other.name() };
                let message = format!("`{key}` is {found}, but must be a string");
                let help = "write a string in quotes, or remove the key".to_string();
                Err(vec![problem_at(value, message, "a string", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "string", "minLength": 1 })
    }
}

/// A type whose values are written as keywords.
pub trait Keyword: Clone + 'static {
    const KEYWORDS: &'static [(&'static str, Self)];

    /// Returns the keyword of a value, which depends on its variant only.
    fn keyword(&self) -> &'static str {
        Self::KEYWORDS.iter().find(|(_, v)| discriminant(v) == discriminant(self)).map_or("", |(w, _)| w)
    }
}

/// One keyword of a closed list.
#[derive(Debug)]
pub struct Choice<W>(PhantomData<W>);

impl<W: Keyword> InputKind for Choice<W> {
    type Value = W;
    const NAME: &'static str = "Choice";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<W, Vec<Problem>> {
        let keywords: Vec<&str> = W::KEYWORDS.iter().map(|(keyword, _)| *keyword).collect();
        read_keyword(key, value, &keywords).map(|index| W::KEYWORDS[index].1.clone())
    }

    fn schema() -> Schema {
        let keywords: Vec<&str> = W::KEYWORDS.iter().map(|(keyword, _)| *keyword).collect();
        json_schema!({ "type": "string", "enum": keywords })
    }
}

/// Reads a keyword of a closed list and returns its index.
pub fn read_keyword(key: &str, value: &Spanned<TomlValue>, keywords: &[&str]) -> Result<usize, Vec<Problem>> {
    let help = format!("allowed: \"{}\"", keywords.join("\", \""));
    let TomlValue::Text(text) = value.get_ref() else {
        let message = format!("`{key}` is {}, but must be a keyword", value.get_ref().name());
        return Err(vec![problem_at(value, message, "a keyword in quotes", help)]);
    };
    if let Some(index) = keywords.iter().position(|keyword| keyword == text) {
        return Ok(index);
    }
    if let Some((reason, instead)) = find_unsupported(key, text) {
        let help = format!("{instead}; {help}");
        return Err(vec![problem_at(
            value,
            format!("`{key}` has no \"{text}\": {reason}"),
            "not supported by phalanx",
            help,
        )]);
    }
    let label = closest_match(text, keywords).map_or("unknown value".into(), |w| format!("did you mean \"{w}\"?"));
    let message = format!("\"{}\" is not a valid value of `{key}`", text.escape_debug());
    Err(vec![problem_at(value, message, label, help)])
}

pub fn problem_at(value: &Spanned<TomlValue>, message: String, label: impl Into<String>, help: String) -> Problem {
    Problem { span: Some(value.span()), message, label: label.into(), help }
}
