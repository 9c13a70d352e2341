//! Kinds of values that a line may hold, and values as they are written.

use serde_json::{Value, json};

use crate::scene::kinds::{Choice, Count, Flag, Kind, List, Measured, Number, Pair, Sweeps, Text, Words};
use crate::scene::show::Out;
use crate::units::{self, Dimension};

/// A value of any kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Written {
    Quantity(f64, Dimension),
    Quantities(Vec<f64>, Dimension),
    Number(f64),
    Whole(u64),
    Flag(bool),
    Word(&'static str),
    Text(String),
}

/// A kind of value in the table.
pub trait Held: Kind {
    fn written(value: &Self::Value) -> Written;

    /// The value that was [recorded](Written::record) so.
    fn recall(text: &str) -> Option<Self::Value>;

    /// All values there are, if they are few.
    fn all() -> Vec<Self::Value> {
        Vec::new()
    }
}

impl Written {
    pub fn number(&self) -> Option<f64> {
        match self {
            Written::Quantity(number, _) | Written::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// Whether it is a value, and not a place for one.
    pub fn is_given(&self) -> bool {
        match self {
            Written::Quantities(values, _) => !values.is_empty() && values.iter().copied().all(f64::is_finite),
            Written::Text(text) => !text.is_empty(),
            other => other.number().is_none_or(f64::is_finite),
        }
    }

    /// The SI unit at the end of a name.
    pub fn suffix(&self) -> Option<&'static str> {
        match self {
            Written::Quantity(_, dimension) | Written::Quantities(_, dimension) => Some(dimension.suffix()),
            _ => None,
        }
    }

    /// As it would stand in a scene.
    pub fn json(self) -> Value {
        match self {
            Written::Quantity(value, dimension) => units::format(value, dimension).into(),
            Written::Quantities(values, dimension) => {
                values.into_iter().map(|value| units::format(value, dimension)).collect()
            }
            Written::Number(value) => json!(value),
            Written::Whole(count) => json!(count),
            Written::Flag(flag) => json!(flag),
            Written::Word(word) => json!(word),
            Written::Text(text) => json!(text),
        }
    }

    /// As a figure of a document: in SI.
    pub fn si(self) -> Value {
        match self {
            Written::Quantity(value, _) => json!(value),
            Written::Quantities(values, _) => json!(values),
            other => other.json(),
        }
    }

    /// Text that reads back to the same bits.
    pub fn record(self) -> String {
        match self {
            Written::Quantity(value, _) | Written::Number(value) => format!("{value:?}"),
            Written::Quantities(values, _) => {
                values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(" ")
            }
            Written::Whole(count) => count.to_string(),
            Written::Flag(flag) => flag.to_string(),
            Written::Word(word) => word.to_string(),
            Written::Text(text) => text,
        }
    }

    pub fn show(self, out: &mut Out, key: &str) {
        match self {
            Written::Quantity(value, dimension) => out.quantity(key, value, dimension),
            Written::Quantities(values, dimension) => out.quantities(key, &values, dimension),
            Written::Number(value) => out.float(key, value),
            Written::Whole(count) => out.raw(key, count),
            Written::Flag(flag) => out.raw(key, flag),
            Written::Word(word) => out.text(key, word),
            Written::Text(text) => out.text(key, &text),
        }
    }
}

impl<M: Measured> Held for M {
    fn written(value: &f64) -> Written {
        Written::Quantity(*value, M::DIMENSION)
    }

    fn recall(text: &str) -> Option<f64> {
        Number::recall(text).filter(|value| value.abs() <= M::DIMENSION.largest_si())
    }
}

impl<M: Measured> Held for List<M> {
    fn written(value: &Vec<f64>) -> Written {
        Written::Quantities(value.clone(), M::DIMENSION)
    }

    fn recall(text: &str) -> Option<Vec<f64>> {
        text.split(' ').map(M::recall).collect()
    }
}

impl<M: Measured> Held for Pair<M> {
    fn written(value: &[f64; 2]) -> Written {
        Written::Quantities(value.to_vec(), M::DIMENSION)
    }

    fn recall(text: &str) -> Option<[f64; 2]> {
        <List<M> as Held>::recall(text)?.try_into().ok()
    }
}

impl Held for Number {
    fn written(value: &f64) -> Written {
        Written::Number(*value)
    }

    fn recall(text: &str) -> Option<f64> {
        text.parse().ok().filter(|value: &f64| value.is_finite())
    }
}

impl Held for Count {
    fn written(value: &u64) -> Written {
        Written::Whole(*value)
    }

    fn recall(text: &str) -> Option<u64> {
        text.parse().ok().filter(|count| *count >= 1)
    }
}

impl Held for Sweeps {
    fn written(value: &u32) -> Written {
        Written::Whole((*value).into())
    }

    fn recall(text: &str) -> Option<u32> {
        text.parse().ok().filter(|count| (1..=Sweeps::MOST).contains(count))
    }
}

impl Held for Flag {
    fn written(value: &bool) -> Written {
        Written::Flag(*value)
    }

    fn recall(text: &str) -> Option<bool> {
        text.parse().ok()
    }
}

impl Held for Text {
    fn written(value: &String) -> Written {
        Written::Text(value.clone())
    }

    fn recall(text: &str) -> Option<String> {
        Some(text.to_string()).filter(|text| !text.trim().is_empty())
    }
}

impl<W: Words> Held for Choice<W> {
    fn written(value: &W) -> Written {
        Written::Word(value.word())
    }

    fn recall(text: &str) -> Option<W> {
        W::WORDS.iter().find(|(word, _)| *word == text).map(|(_, value)| value.clone())
    }

    fn all() -> Vec<W> {
        W::WORDS.iter().map(|(_, value)| value.clone()).collect()
    }
}
