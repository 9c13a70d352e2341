//! What a key may hold: quantities of one dimension, numbers, words of a closed list, pairs and lists.

use std::marker::PhantomData;
use std::mem::discriminant;

use schemars::{Schema, json_schema};
use toml::Spanned;

use super::any::Any;
use super::error::Problem;
use super::suggest::{absent, nearest};
use crate::units::{self, Dimension};

/// How the value of a key is read.
pub trait Kind {
    type Value;
    const NAME: &'static str;

    /// Reads the value of `key` (its full path, for messages).
    fn read(key: &str, value: &Spanned<Any>) -> Result<Self::Value, Vec<Problem>>;

    fn schema() -> Schema;
}

/// A kind that is a quantity of one dimension.
pub trait Measured {
    const DIMENSION: Dimension;
}

macro_rules! measured {
    ($($name:ident)*) => {$(
        #[derive(Debug)]
        pub struct $name;

        impl Measured for $name {
            const DIMENSION: Dimension = Dimension::$name;
        }
    )*};
}

measured!(Length Angle Time Mass Force Torque Speed AngularRate Acceleration Density Inertia Frequency Pressure);
measured!(AngularStiffness LinearDamping AngularDamping);

impl<M: Measured> Kind for M {
    type Value = f64;
    const NAME: &'static str = "Quantity";

    fn read(key: &str, value: &Spanned<Any>) -> Result<f64, Vec<Problem>> {
        quantity(key, value, M::DIMENSION)
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
pub fn quantity(key: &str, value: &Spanned<Any>, wanted: Dimension) -> Result<f64, Vec<Problem>> {
    let help = || format!("write a number and its unit, as in \"{}\"", wanted.example());
    if let Any::Si(si) = value.get_ref() {
        return Ok(*si);
    }
    let Any::Text(text) = value.get_ref() else {
        let message = format!(
            "`{key}` is {}; {} is wanted, as text with its unit: {}",
            value.get_ref().name(),
            wanted.name(),
            wanted.unit_list()
        );
        return Err(vec![at(value, message, wanted.name(), help())]);
    };
    units::parse(text, wanted).map_err(|e| vec![at(value, format!("`{key}`: {e}"), wanted.name(), help())])
}

/// Two quantities, such as the coordinates of a point.
#[derive(Debug)]
pub struct Pair<M>(PhantomData<M>);

impl<M: Measured> Kind for Pair<M> {
    type Value = [f64; 2];
    const NAME: &'static str = "Pair";

    fn read(key: &str, value: &Spanned<Any>) -> Result<[f64; 2], Vec<Problem>> {
        // A single value is taken as y, as in gravity and most other vectors.
        let example = match value.get_ref() {
            Any::Integer(y) => format!("{y} {}", M::DIMENSION.units()[0].name),
            Any::Float(y) => format!("{y} {}", M::DIMENSION.units()[0].name),
            Any::Text(y) if units::parse(y, M::DIMENSION).is_ok() => y.trim().to_string(),
            _ => M::DIMENSION.example().to_string(),
        };
        let pair = format!("write x and y: [\"0 {}\", \"{example}\"]", M::DIMENSION.units()[0].name);
        let Any::List(_) = value.get_ref() else {
            let message = format!("`{key}` is {}, but must be a list of two values", value.get_ref().name());
            return Err(vec![at(value, message, "two values in brackets", pair)]);
        };
        let list = <List<M>>::read(key, value)?;
        <[f64; 2]>::try_from(list).map_err(|list| {
            let message = format!("`{key}` has {} values, but must have two, x and y", list.len());
            vec![at(value, message, "two values", pair)]
        })
    }

    fn schema() -> Schema {
        json_schema!({ "type": "array", "items": M::schema(), "minItems": 2, "maxItems": 2 })
    }
}

/// Any number of quantities.
#[derive(Debug)]
pub struct List<M>(PhantomData<M>);

impl<M: Measured> Kind for List<M> {
    type Value = Vec<f64>;
    const NAME: &'static str = "List";

    fn read(key: &str, value: &Spanned<Any>) -> Result<Vec<f64>, Vec<Problem>> {
        let example = M::DIMENSION.example();
        let Any::List(items) = value.get_ref() else {
            let message = format!("`{key}` is {}, but must be a list", value.get_ref().name());
            let help = format!("write [\"{example}\", \"{example}\"]");
            return Err(vec![at(value, message, "a list in brackets", help)]);
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

/// A plain number: a pure ratio, or SI where the unit has a fractional power.
#[derive(Debug)]
pub struct Number;

impl Kind for Number {
    type Value = f64;
    const NAME: &'static str = "Number";

    fn read(key: &str, value: &Spanned<Any>) -> Result<f64, Vec<Problem>> {
        let wrong = |message, help: &str| Err(vec![at(value, message, "a number", help.to_string())]);
        match value.get_ref() {
            Any::Integer(i) => Ok(*i as f64),
            Any::Float(x) if x.is_finite() => Ok(*x),
            Any::Float(x) => wrong(format!("`{key}` is {x}, but must be finite"), "write a finite number"),
            Any::Text(_) => wrong(
                format!("`{key}` is a text, but must be a plain number"),
                "write it without quotes and without a unit, in SI where it has one: 0.8 or 1e8",
            ),
            other => wrong(
                format!("`{key}` is {}, but must be a plain number", other.name()),
                "write a number such as 0.8 or 1e8",
            ),
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "number" })
    }
}

/// A whole number from 1.
#[derive(Debug)]
pub struct Count;

impl Count {
    /// What a scene can say: TOML has no larger numbers.
    pub const MOST: u64 = i64::MAX as u64;
}

impl Kind for Count {
    type Value = u64;
    const NAME: &'static str = "Count";

    fn read(key: &str, value: &Spanned<Any>) -> Result<u64, Vec<Problem>> {
        match value.get_ref() {
            Any::Integer(i) if *i >= 1 => Ok(*i as u64),
            other => {
                let found = match other {
                    Any::Integer(i) => i.to_string(),
                    other => other.name().to_string(),
                };
                let message = format!("`{key}` is {found}, but must be a whole number from 1");
                let help = "write a number without point, exponent or quotes: 1_000_000".to_string();
                Err(vec![at(value, message, "a whole number", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "integer", "minimum": 1 })
    }
}

/// How often a solver sweeps over its constraints in one step: a whole number within reason, because no budget of steps
/// ends a run whose every step takes for ever.
#[derive(Debug)]
pub struct Sweeps;

impl Sweeps {
    pub const MOST: u32 = 10_000;
}

impl Kind for Sweeps {
    type Value = u32;
    const NAME: &'static str = "Sweeps";

    fn read(key: &str, value: &Spanned<Any>) -> Result<u32, Vec<Problem>> {
        let found = match value.get_ref() {
            Any::Integer(i) => match u32::try_from(*i) {
                Ok(count @ 1..=Self::MOST) => return Ok(count),
                _ => i.to_string(),
            },
            other => other.name().to_string(),
        };
        let range = format!("from 1 to {}", Self::MOST);
        let message = format!("`{key}` is {found}, but must be a whole number {range}");
        let help = format!("write a number {range} without point, exponent or quotes: 20");
        Err(vec![at(value, message, range, help)])
    }

    fn schema() -> Schema {
        json_schema!({ "type": "integer", "minimum": 1, "maximum": Self::MOST })
    }
}

/// `true` or `false`.
#[derive(Debug)]
pub struct Flag;

impl Kind for Flag {
    type Value = bool;
    const NAME: &'static str = "Flag";

    fn read(key: &str, value: &Spanned<Any>) -> Result<bool, Vec<Problem>> {
        match value.get_ref() {
            Any::Flag(flag) => Ok(*flag),
            other => {
                let message = format!("`{key}` is {}, but must be true or false", other.name());
                let help = "write true or false, without quotes".to_string();
                Err(vec![at(value, message, "true or false", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "boolean" })
    }
}

/// Free text, not empty.
#[derive(Debug)]
pub struct Text;

impl Kind for Text {
    type Value = String;
    const NAME: &'static str = "Text";

    fn read(key: &str, value: &Spanned<Any>) -> Result<String, Vec<Problem>> {
        match value.get_ref() {
            Any::Text(text) if !text.trim().is_empty() => Ok(text.clone()),
            other => {
                let found = if matches!(other, Any::Text(_)) { "empty" } else { other.name() };
                let message = format!("`{key}` is {found}, but must be a text");
                let help = "write a text in quotes, or leave the key out".to_string();
                Err(vec![at(value, message, "a text", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "string", "minLength": 1 })
    }
}

/// A type written as one word of a closed list.
pub trait Words: Clone + 'static {
    const WORDS: &'static [(&'static str, Self)];

    /// The word of a value, whatever else the value holds; every value has one.
    fn word(&self) -> &'static str {
        Self::WORDS.iter().find(|(_, v)| discriminant(v) == discriminant(self)).map_or("", |(w, _)| w)
    }
}

/// One word of a closed list.
#[derive(Debug)]
pub struct Choice<W>(PhantomData<W>);

impl<W: Words> Kind for Choice<W> {
    type Value = W;
    const NAME: &'static str = "Choice";

    fn read(key: &str, value: &Spanned<Any>) -> Result<W, Vec<Problem>> {
        let words: Vec<&str> = W::WORDS.iter().map(|(word, _)| *word).collect();
        word(key, value, &words).map(|index| W::WORDS[index].1.clone())
    }

    fn schema() -> Schema {
        let words: Vec<&str> = W::WORDS.iter().map(|(word, _)| *word).collect();
        json_schema!({ "type": "string", "enum": words })
    }
}

/// Reads one word of a closed list; its index.
pub fn word(key: &str, value: &Spanned<Any>, words: &[&str]) -> Result<usize, Vec<Problem>> {
    let help = format!("allowed: \"{}\"", words.join("\", \""));
    let Any::Text(text) = value.get_ref() else {
        let message = format!("`{key}` is {}, but must be one of its words", value.get_ref().name());
        return Err(vec![at(value, message, "a word in quotes", help)]);
    };
    if let Some(index) = words.iter().position(|word| word == text) {
        return Ok(index);
    }
    if let Some((why, instead)) = absent(key, text) {
        let help = format!("{instead}; {help}");
        return Err(vec![at(value, format!("`{key}` has no \"{text}\": {why}"), "phalanx does not have this", help)]);
    }
    let label = nearest(text, words).map_or("not one of its words".into(), |w| format!("did you mean \"{w}\"?"));
    let message = format!("`{key}` does not know \"{}\"", text.escape_debug());
    Err(vec![at(value, message, label, help)])
}

pub fn at(value: &Spanned<Any>, message: String, label: impl Into<String>, help: String) -> Problem {
    Problem { span: Some(value.span()), message, label: label.into(), help }
}
