//! Values of a file as written, before their types are known.

use toml::de::DeValue;
use toml::{Spanned, Value};

use super::error::Problem;

/// Name of the type of a value, with its article, for messages.
pub fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a bare number",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Array(_) => "a list",
        DeValue::Datetime(_) | DeValue::Table(_) => "a table or date",
    }
}

/// Returns the value of a number. A whole number that is too large becomes a float. `None` if the value is not a
/// number.
pub fn number(value: &DeValue<'_>) -> Option<Value> {
    let DeValue::Integer(integer) = value else {
        return Some(Value::Float(value.as_float()?.as_str().parse().ok()?));
    };
    let (digits, radix) = (integer.as_str(), integer.radix());
    match i64::from_str_radix(digits, radix) {
        Ok(integer) => Some(Value::Integer(integer)),
        Err(_) if radix == 10 => Some(Value::Float(digits.parse().ok()?)),
        Err(_) => Some(Value::Float(u128::from_str_radix(digits, radix).ok()? as f64)),
    }
}

/// Returns a problem of a value.
pub fn problem_at(value: &Spanned<DeValue<'_>>, message: String, label: impl Into<String>, help: String) -> Problem {
    Problem { span: Some(value.span()), message, label: label.into(), help }
}
