//! Converts Python values to TOML and to quantities, and JSON documents to Python.

use std::ops::RangeInclusive;

use phalanx::limits::{MAX_SCENE_BYTES, MAX_THREADS};
use phalanx::scene::Keyword;
use phalanx::units::{self, Dimension};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyByteArray, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use super::{errors, quantities};

/// Returns a value as the text of a field setting. A text is unchanged, as with `--set`: it needs quotes only if it is
/// valid TOML without them.
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

/// Parses a JSON document of results into dictionaries and lists. Its messages then name arguments instead of flags.
pub fn parse_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let document = parse_unchanged_json(py, text)?;
    if text.contains("--") { errors::document_in_python(&document) } else { Ok(document) }
}

/// Parses a JSON document into dictionaries and lists.
pub fn parse_unchanged_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// Converts the dictionary of a scene into TOML text; `name` is the file name in messages.
pub fn scene_text(scene: &Bound<'_, PyDict>, name: &str) -> PyResult<String> {
    let mut table = Converter::default().table(scene)?;
    quantities::add_units(&mut table, name);
    let text = toml::to_string(&table);
    text.map_err(|error| PyValueError::new_err(format!("the dictionary cannot be written as TOML: {error}")))
}

/// Converts a value; numbers are exact to the last bit.
pub fn toml_value(value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    Converter::default().value(value)
}

/// Deepest nesting of dictionaries and lists: far more than that of a scene.
const MAX_DEPTH: usize = 32;
/// Maximum number of values: each has at least one byte, and a scene has at most a megabyte.
const MAX_VALUES: usize = MAX_SCENE_BYTES as usize;

/// Converter of Python values to TOML. Depth and number of values are limited, because a dictionary can contain itself, or the
/// same list many times.
#[derive(Default)]
struct Converter {
    depth: usize,
    count: usize,
}

impl Converter {
    fn table(&mut self, dict: &Bound<'_, PyDict>) -> PyResult<toml::Table> {
        let mut table = toml::Table::new();
        for (key, value) in dict {
            let Ok(name) = key.cast::<PyString>() else {
                let message = format!("the key {key} of a scene is of type {}; keys are strings", type_name(&key));
                return Err(PyTypeError::new_err(message));
            };
            table.insert(name.to_str()?.to_string(), self.value(&value)?);
        }
        Ok(table)
    }

    fn value(&mut self, value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
        self.count += 1;
        let error = |message: String| Err(PyValueError::new_err(message));
        if self.depth > MAX_DEPTH {
            return error(format!(
                "dictionaries and lists are nested in more than {MAX_DEPTH} levels, or contain themselves; a scene has a few levels"
            ));
        }
        if self.count > MAX_VALUES {
            return error(format!("there are more than {MAX_VALUES} values; a scene has at most {MAX_VALUES} bytes"));
        }
        self.depth += 1;
        let converted = self.convert(value);
        self.depth -= 1;
        converted
    }

    fn convert(&mut self, value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
        if let Ok(dict) = value.cast::<PyDict>() {
            return Ok(toml::Value::Table(self.table(dict)?));
        }
        if let Ok(text) = value.cast::<PyString>() {
            return Ok(toml::Value::from(text.to_str()?));
        }
        // Before the integers, because bool is a subclass of int in Python.
        if value.is_instance_of::<PyBool>() {
            return Ok(toml::Value::Boolean(value.extract()?));
        }
        if value.is_instance_of::<PyInt>() {
            let too_large = |_| PyValueError::new_err("an integer has more than 64 bits; write it as a float");
            return Ok(toml::Value::Integer(value.extract().map_err(too_large)?));
        }
        if value.is_instance_of::<PyFloat>() {
            return Ok(toml::Value::Float(value.extract()?));
        }
        if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
            return value.try_iter()?.map(|item| self.value(&item?)).collect::<PyResult<_>>().map(toml::Value::Array);
        }
        // Scalars and arrays of numpy.
        if value.hasattr("tolist")? {
            return self.value(&value.call_method0("tolist")?);
        }
        Err(PyTypeError::new_err(format!(
            "a field of a scene must be a string such as \"20 mm\", a number, True or False, or a list of these, not of type {}",
            type_name(value)
        )))
    }
}

fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "unknown".to_string(), |name| name.to_string())
}

/// Checks the whole number that was given for an argument.
pub fn count(py: Python<'_>, name: &str, value: i128, allowed: RangeInclusive<u64>) -> PyResult<u64> {
    u64::try_from(value).ok().filter(|value| allowed.contains(value)).ok_or_else(|| {
        let (least, most) = (allowed.start(), allowed.end());
        errors::argument(py, format!("{name} is {value}; expected a whole number from {least} to {most}"))
    })
}

/// Checks the number of threads; 0 means one per core.
pub fn threads(py: Python<'_>, value: i128) -> PyResult<usize> {
    Ok(count(py, "threads", value, 0..=MAX_THREADS as u64)? as usize)
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

/// Reads an argument: a string with a unit or a number in SI, returned in SI.
pub fn quantity(py: Python<'_>, name: &str, value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<f64> {
    // Most calls have a number.
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(number.value());
    }
    parse_quantity(name, value, dimension)?.map_err(|error| errors::argument(py, error))
}

/// Reads an argument as the text of a quantity. A number gets the SI unit.
pub fn quantity_text(value: &Bound<'_, PyAny>, dimension: Dimension) -> PyResult<String> {
    match value.cast::<PyString>() {
        Ok(text) => Ok(text.to_str()?.to_string()),
        Err(_) => Ok(format!("{:?} {}", value.extract::<f64>()?, dimension.units()[0].name)),
    }
}

/// Returns numbers as a writable numpy array.
pub fn vector<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    py.import("numpy")?.call_method1("frombuffer", (PyByteArray::new(py, &bytes), "float64"))
}

/// A pickled object: the function that restores it, and its arguments.
pub type Reduced<'py, T> = (Bound<'py, PyAny>, T);

/// Converts numbers to bytes, for pickling.
pub fn to_bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Converts the bytes of [`to_bytes`] to numbers.
pub fn from_bytes(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks().0.iter().map(|number| f64::from_le_bytes(*number)).collect()
}
