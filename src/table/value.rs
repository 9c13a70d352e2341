//! Values of a table and their conversion from and to the text of a cell.

use std::borrow::Cow;

use serde::Serialize;

/// Kind of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Integer,
    Number,
    Flag,
    Text,
}

impl Kind {
    /// Description of one value with its article, for messages.
    pub fn description(self) -> &'static str {
        match self {
            Kind::Integer => "a whole number",
            Kind::Number => "a number",
            Kind::Flag => "true or false",
            Kind::Text => "a string",
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
    /// Not available or not applicable.
    Missing,
}

/// Numbers are compared by their bits, to compare a table that was read back with the written one; all NaN are equal.
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
    /// Whether the value may be in a column of this kind. It must be of this kind, or missing.
    pub fn fits(&self, kind: Kind) -> bool {
        match self {
            Value::Integer(_) => kind == Kind::Integer,
            Value::Number(_) => kind == Kind::Number,
            Value::Flag(_) => kind == Kind::Flag,
            Value::Text(_) => kind == Kind::Text,
            Value::Missing => true,
        }
    }

    pub fn as_integer(&self) -> Option<i64> {
        if let Value::Integer(integer) = self { Some(*integer) } else { None }
    }

    /// Returns the number; an integer is converted. `None` for other values.
    pub fn as_number(&self) -> Option<f64> {
        if let Value::Number(number) = self { Some(*number) } else { self.as_integer().map(|integer| integer as f64) }
    }

    pub fn as_flag(&self) -> Option<bool> {
        if let Value::Flag(flag) = self { Some(*flag) } else { None }
    }

    pub fn as_text(&self) -> Option<&str> {
        if let Value::Text(text) = self { Some(text) } else { None }
    }

    /// Text of the value in a CSV cell. The text of a number can be told from that of an integer: it contains a decimal
    /// point or an exponent, or is not finite.
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

/// Parses a cell in a column of a known kind; `None` if it is not of that kind.
pub(super) fn parse_cell(cell: &str, kind: Kind) -> Option<Value> {
    let trimmed = cell.trim();
    if cell.is_empty() || (trimmed.is_empty() && kind != Kind::Text) {
        return Some(Value::Missing);
    }
    match kind {
        Kind::Integer => trimmed.parse().ok().map(Value::Integer),
        Kind::Number => parse_number(trimmed).map(Value::Number),
        Kind::Flag => parse_flag(trimmed).map(Value::Flag),
        Kind::Text => Some(Value::Text(unescape(cell).to_string())),
    }
}

/// First characters of cells that spreadsheets evaluate.
const FORMULA_PREFIXES: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// Escapes a text that spreadsheets would evaluate.
pub(super) fn escape(text: &str) -> Cow<'_, str> {
    match text.starts_with(FORMULA_PREFIXES) || is_escaped(text) {
        true => Cow::Owned(format!("'{text}")),
        false => Cow::Borrowed(text),
    }
}

/// Returns the original text of a cell.
pub(super) fn unescape(cell: &str) -> &str {
    if is_escaped(cell) { &cell[1..] } else { cell }
}

/// Whether a cell begins with an escaping apostrophe.
fn is_escaped(cell: &str) -> bool {
    cell.strip_prefix('\'').is_some_and(|rest| rest.starts_with(FORMULA_PREFIXES) || rest.starts_with('\''))
}

/// Returns the narrowest kind that contains all cells; `None` if all are empty.
pub(super) fn infer_kind<'a>(cells: impl Iterator<Item = &'a str>) -> Option<Kind> {
    let mut found = None;
    for cell in cells.map(str::trim).filter(|cell| !cell.is_empty()) {
        let kind = if cell.parse::<i64>().is_ok() {
            Kind::Integer
        } else if parse_number(cell).is_some() {
            Kind::Number
        } else if parse_flag(cell).is_some() {
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

/// Parses a number. Words that Rust parses as numbers are strings, except `NaN`, `inf` and `-inf`.
fn parse_number(text: &str) -> Option<f64> {
    let value = text.parse().ok()?;
    (text.contains(|c: char| c.is_ascii_digit()) || matches!(text, "NaN" | "inf" | "-inf")).then_some(value)
}

/// Parses a flag as written by Rust or Python.
fn parse_flag(text: &str) -> Option<bool> {
    match text {
        "true" | "True" => Some(true),
        "false" | "False" => Some(false),
        _ => None,
    }
}
