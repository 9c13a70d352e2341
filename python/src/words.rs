//! Values of Python as those of a scene, and documents of JSON as Python.

use phalanx::scene::Words;
use phalanx::units::{self, Dimension};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

/// A value as it is written in a scene. A text stands as `--set` takes it: what is no value of TOML is a text without its quotes.
pub fn toml(value: &Bound<'_, PyAny>) -> PyResult<String> {
    match value.cast::<PyString>() {
        Ok(text) => Ok(text.to_str()?.to_string()),
        Err(_) => Ok(match tree(value)? {
            toml::Value::Float(value) => number(value),
            value => value.to_string(),
        }),
    }
}

/// A number as TOML.
pub fn number(value: f64) -> String {
    match value {
        _ if value.is_nan() => "nan".to_string(),
        _ if value.is_infinite() => if value > 0.0 { "inf" } else { "-inf" }.to_string(),
        _ => format!("{value:?}"),
    }
}

/// A document of JSON as dictionaries and lists.
pub fn json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// A dictionary as a text of TOML.
pub fn document(scene: &Bound<'_, PyDict>) -> PyResult<String> {
    toml::to_string(&table(scene)?).map_err(|error| PyValueError::new_err(format!("no scene: {error}")))
}

fn table(of: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
    of.iter().map(|(key, value)| Ok((key.extract()?, tree(&value)?))).collect()
}

/// A value with all that is in it, to the bit.
fn tree(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if let Ok(inner) = value.cast::<PyDict>() {
        return Ok(toml::Value::Table(table(inner)?));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(toml::Value::from(text.to_str()?));
    }
    // True is a number of Python too.
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
        return value.try_iter()?.map(|part| tree(&part?)).collect::<PyResult<_>>().map(toml::Value::Array);
    }
    // Scalars and arrays of numpy.
    if value.hasattr("tolist")? {
        return tree(&value.call_method0("tolist")?);
    }
    Err(unknown(value))
}

fn unknown(value: &Bound<'_, PyAny>) -> PyErr {
    let kind = value.get_type().name().map_or_else(|_| "that".to_string(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "a field of a scene is a text such as \"20 mm\", a number, True or False, or a list of these, and not of type {kind}"
    ))
}

/// One of a list of words, as a scene writes them.
pub fn word<W: Words>(what: &str, given: &str) -> Result<W, String> {
    let words: Vec<String> = W::WORDS.iter().map(|(word, _)| format!("\"{word}\"")).collect();
    let found = W::WORDS.iter().find(|(word, _)| *word == given);
    found.map(|(_, value)| value.clone()).ok_or(format!("{what} is \"{given}\", but must be {}", words.join(" or ")))
}

/// A quantity that is more than 0, in SI: a text with its unit, or a number in SI.
pub fn positive(what: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<Result<f64, String>> {
    let otherwise = format!("{what} must be more than 0; expected a text with a unit, or a number in SI");
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(units::positive(text.to_str()?, dimension, &otherwise).map_err(|error| format!("{what}: {error}")));
    }
    let number: f64 = value.extract()?;
    Ok(if number.is_finite() && number > 0.0 { Ok(number) } else { Err(otherwise) })
}

/// A quantity in SI: a text with its unit, or a number in SI.
pub fn quantity(what: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<Result<f64, String>> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(units::parse(text.to_str()?, dimension).map_err(|error| format!("{what}: {error}")));
    }
    let number: f64 = value.extract()?;
    Ok(if number.is_finite() { Ok(number) } else { Err(format!("{what} is {number}, but must be finite")) })
}
