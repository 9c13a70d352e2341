//! Converts Python values to TOML and to quantities, and JSON documents to Python.

use phalanx::scene::Keyword;
use phalanx::units::{self, Dimension};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

/// Returns a value as the text of a field setting. A text stays unchanged, as with `--set`: it needs no quotes unless
/// it is valid TOML.
pub fn setting_text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    match value.cast::<PyString>() {
        Ok(text) => Ok(text.to_str()?.to_string()),
        Err(_) => Ok(match toml_value(value)? {
            toml::Value::Float(value) => format_toml_number(value),
            value => value.to_string(),
        }),
    }
}

/// Formats a number as TOML.
pub fn format_toml_number(value: f64) -> String {
    match value {
        _ if value.is_nan() => "nan".to_string(),
        _ if value.is_infinite() => if value > 0.0 { "inf" } else { "-inf" }.to_string(),
        _ => format!("{value:?}"),
    }
}

/// Parses a JSON document into dictionaries and lists.
pub fn parse_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// Converts the dictionary of a scene into TOML text.
pub fn scene_text(scene: &Bound<'_, PyDict>) -> PyResult<String> {
    let text = toml::to_string(&toml_table(scene)?);
    text.map_err(|error| PyValueError::new_err(format!("the dictionary cannot be written as TOML: {error}")))
}

fn toml_table(dict: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
    dict.iter().map(|(key, value)| Ok((key.extract()?, toml_value(&value)?))).collect()
}

/// Converts a value recursively, with numbers exact to the last bit.
fn toml_value(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(toml::Value::Table(toml_table(dict)?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(toml::Value::from(text.to_str()?));
    }
    // Before the integers, because bool is a subclass of int in Python.
    if value.is_instance_of::<PyBool>() {
        return Ok(toml::Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(toml::Value::Integer(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        return value.try_iter()?.map(|item| toml_value(&item?)).collect::<PyResult<_>>().map(toml::Value::Array);
    }
    // Scalars and arrays of numpy.
    if value.hasattr("tolist")? {
        return toml_value(&value.call_method0("tolist")?);
    }
    Err(unsupported_type(value))
}

fn unsupported_type(value: &Bound<'_, PyAny>) -> PyErr {
    let type_name = value.get_type().name().map_or_else(|_| "unknown".to_string(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "a field of a scene must be a string such as \"20 mm\", a number, True or False, or a list of these, not of type {type_name}"
    ))
}

/// Parses one of the keywords of a scene field.
pub fn parse_keyword<W: Keyword>(name: &str, text: &str) -> Result<W, String> {
    let allowed: Vec<String> = W::KEYWORDS.iter().map(|(keyword, _)| format!("\"{keyword}\"")).collect();
    let entry = W::KEYWORDS.iter().find(|(keyword, _)| *keyword == text);
    entry.map(|(_, value)| value.clone()).ok_or(format!("{name} is \"{text}\", but must be {}", allowed.join(" or ")))
}

/// Parses a quantity greater than 0, from a string with a unit or a number in SI, and returns it in SI.
pub fn parse_positive(name: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<Result<f64, String>> {
    let range_error = format!("{name} must be greater than 0; expected a text with a unit, or a number in SI");
    if let Ok(text) = value.cast::<PyString>() {
        let quantity = units::parse_positive(text.to_str()?, dimension, &range_error);
        return Ok(quantity.map_err(|error| format!("{name}: {error}")));
    }
    let number: f64 = value.extract()?;
    Ok(if number.is_finite() && number > 0.0 { Ok(number) } else { Err(range_error) })
}

/// Parses a quantity from a string with a unit or a number in SI, and returns it in SI.
pub fn parse_quantity(name: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<Result<f64, String>> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(units::parse(text.to_str()?, dimension).map_err(|error| format!("{name}: {error}")));
    }
    let number: f64 = value.extract()?;
    Ok(if number.is_finite() { Ok(number) } else { Err(format!("{name} is {number}, but must be finite")) })
}
