//! Values of a table, to and from the text of a cell.

use serde::Serialize;

/// What the values of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Integer,
    Number,
    Flag,
    Text,
}

impl Kind {
    /// What one value is, with its article, for messages.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Integer => "a whole number",
            Kind::Number => "a number",
            Kind::Flag => "true or false",
            Kind::Text => "a text",
        }
    }
}

/// One cell.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Value {
    Integer(i64),
    Number(f64),
    Flag(bool),
    Text(String),
    /// Nothing was found, or it means nothing here.
    Missing,
}

/// Numbers are equal if their bits are: a table that is read back is compared with the one that was written. NaN is NaN.
impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Value::Integer(a), Value::Integer(b)) => a == b,
            (Value::Number(a), Value::Number(b)) => a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
            (Value::Flag(a), Value::Flag(b)) => a == b,
            (Value::Text(a), Value::Text(b)) => a == b,
            (Value::Missing, Value::Missing) => true,
            _ => false,
        }
    }
}

impl Value {
    /// `None` if it is missing.
    pub fn kind(&self) -> Option<Kind> {
        match self {
            Value::Integer(_) => Some(Kind::Integer),
            Value::Number(_) => Some(Kind::Number),
            Value::Flag(_) => Some(Kind::Flag),
            Value::Text(_) => Some(Kind::Text),
            Value::Missing => None,
        }
    }

    /// What a CSV cell says. A number is told from an integer by its point, its exponent, or by not being finite.
    pub fn text(&self) -> String {
        match self {
            Value::Integer(value) => value.to_string(),
            Value::Number(value) => format!("{value:?}"),
            Value::Flag(value) => value.to_string(),
            Value::Text(text) => text.clone(),
            Value::Missing => String::new(),
        }
    }
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Number(value)
    }
}

impl From<i64> for Value {
    fn from(value: i64) -> Self {
        Value::Integer(value)
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Value::Flag(value)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Value::Text(text.to_string())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Value::Text(text)
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Value::Missing, Into::into)
    }
}

/// The value of a cell in a column of a known kind; `None` if it is not of that kind.
pub(super) fn read(cell: &str, kind: Kind) -> Option<Value> {
    let bare = cell.trim();
    if cell.is_empty() || (bare.is_empty() && kind != Kind::Text) {
        return Some(Value::Missing);
    }
    match kind {
        Kind::Integer => bare.parse().ok().map(Value::Integer),
        Kind::Number => number(bare).map(Value::Number),
        Kind::Flag => flag(bare).map(Value::Flag),
        Kind::Text => Some(Value::Text(super::formula::meant(cell).to_string())),
    }
}

/// The narrowest kind that has all these cells; `None` if all are empty.
pub(super) fn kind_of<'a>(cells: impl Iterator<Item = &'a str>) -> Option<Kind> {
    let mut found = None;
    for cell in cells.map(str::trim).filter(|cell| !cell.is_empty()) {
        let kind = if cell.parse::<i64>().is_ok() {
            Kind::Integer
        } else if number(cell).is_some() {
            Kind::Number
        } else if flag(cell).is_some() {
            Kind::Flag
        } else {
            Kind::Text
        };
        found = match (found, kind) {
            (None, kind) => Some(kind),
            (Some(before), kind) if before == kind => Some(kind),
            (Some(Kind::Integer | Kind::Number), Kind::Integer | Kind::Number) => Some(Kind::Number),
            _ => return Some(Kind::Text),
        };
    }
    found
}

/// Words that Rust takes for numbers are texts, except those that numbers are written as.
fn number(text: &str) -> Option<f64> {
    let value = text.parse().ok()?;
    (text.contains(|c: char| c.is_ascii_digit()) || matches!(text, "NaN" | "inf" | "-inf")).then_some(value)
}

/// As Rust and as Python write them.
fn flag(text: &str) -> Option<bool> {
    match text {
        "true" | "True" => Some(true),
        "false" | "False" => Some(false),
        _ => None,
    }
}
