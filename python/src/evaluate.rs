//! Simulates many designs of a scene, with field values from arrays.

use std::collections::BTreeMap;

use phalanx::study::sweep::{AxisValue, Field, FieldType, Filter, MAX_RUNS, columns, in_memory_study};
use phalanx::table::Value;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyInt, PyIterator, PyList, PyMapping, PyString, PyTuple};

use super::scene::{Scene, SceneLike};
use super::table::Table;
use super::{conversion, errors, quantities, study};

/// Simulates many designs of a scene on native threads. Returns a table with one row per design, in order.
///
/// fields: values by field path, such as `{"design.base": [0.018, 0.020, 0.022], "contact.friction.mu_static": 0.6}`.
/// All arrays and lists must have the same length; a single value applies to every design. Values are numbers in SI, or
/// strings with units. preset: replaces the integrator settings of all designs ("draft" for searches). threads: number
/// of threads; 0 for one per core. columns: columns to return; by default all. check: check every run, with three more
/// runs each. filter: static criteria of a finger, such as `{"form_closed": True}`; other designs are not simulated and
/// have the status "filtered".
///
/// A design with an invalid scene or an incomplete run gives a row with `status` and `reason`, never an exception. A
/// design that cannot grasp its object has a `reason` and no `class`. `class_reason` explains the class. Raises
/// StudyError for an unknown field or for arrays of different lengths, and SceneError for an invalid scene.
#[pyfunction]
#[pyo3(signature = (scene, fields, *, model = "analytic", preset = None, threads = 0, columns = None, check = false, filter = None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments")]
pub fn evaluate(
    py: Python<'_>,
    scene: SceneLike,
    fields: &Bound<'_, PyMapping>,
    model: &str,
    preset: Option<&str>,
    threads: i128,
    columns: Option<Vec<String>>,
    check: bool,
    filter: Option<BTreeMap<String, bool>>,
) -> PyResult<Table> {
    let threads = conversion::threads(py, threads)?;
    let scene = scene.get(py)?;
    let paths = fields.keys()?.extract::<Vec<String>>()?;
    let names: Vec<&str> = paths.iter().map(String::as_str).collect();
    let model = super::result::model(py, model)?;
    let mut study = in_memory_study(&scene.layers, &scene.settings, &names, model).map_err(|error| match error {
        phalanx::study::sweep::StudyError::Invalid(error) => errors::scene(py, &error),
        error => errors::sweep(py, error),
    })?;
    super::study::set_preset(py, &mut study, preset)?;
    study.checked = check;
    study.filter = read_filter(py, study.fingers(), filter.unwrap_or_default())?;
    require_known_columns(py, &study, columns.as_deref())?;
    let values: Vec<FieldValues> = fields
        .values()?
        .iter()
        .zip(study.row_fields())
        .map(|(value, field)| FieldValues::from_python(&value, field, &scene))
        .collect::<PyResult<_>>()?;
    let count = design_count(py, &paths, &values)?;
    let rows = (0..count).map(|row| values.iter().map(|value| value.of_row(row)).collect()).collect();
    let study = study.with_rows(rows);
    let mut results = study::run_rows(py, &study, threads, u64::MAX)?;
    translate_reasons(py, &mut results)?;
    Table::new(py, results, columns.as_deref())
}

/// Replaces the flags of the command line in the texts of a table.
fn translate_reasons(py: Python<'_>, results: &mut phalanx::table::Table) -> PyResult<()> {
    for cell in results.rows.iter_mut().flatten() {
        if let Value::Text(text) = cell {
            *text = errors::in_python(py, std::mem::take(text))?;
        }
    }
    Ok(())
}

/// Reads the static criteria of the designs to simulate.
fn read_filter(py: Python<'_>, fingers: usize, criteria: BTreeMap<String, bool>) -> PyResult<Filter> {
    let mut filter = Filter::default();
    for (name, required) in criteria {
        match name.as_str() {
            _ if fingers != 1 => {
                let message = "error: a filter concerns the statics of one finger, but the scene is of another kind\n  = help: remove it";
                return Err(errors::sweep(py, message));
            }
            "force_positive" => filter.force_positive = Some(required),
            "palm_force_positive" => filter.palm_force_positive = Some(required),
            "form_closed" => filter.form_closed = Some(required),
            _ => {
                let help = "the criteria are force_positive, palm_force_positive and form_closed";
                return Err(errors::sweep(
                    py,
                    format!("error: `{name}` is not a criterion of a filter\n  = help: {help}"),
                ));
            }
        }
    }
    Ok(filter)
}

fn require_known_columns(
    py: Python<'_>,
    study: &phalanx::study::sweep::Study,
    requested: Option<&[String]>,
) -> PyResult<()> {
    let known: Vec<String> = columns(study).into_iter().map(|column| column.name).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    match requested.into_iter().flatten().find(|name| !known.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => Err(errors::sweep(
            py,
            format!("error: `{name}` is not a column of the results\n  = help: the columns are {}", known.join(", ")),
        )),
    }
}

/// The values of a field.
enum FieldValues {
    /// One value for all designs.
    Constant(AxisValue),
    PerDesign(Vec<AxisValue>),
}

impl FieldValues {
    fn from_python(value: &Bound<'_, PyAny>, field: &Field, scene: &Scene) -> PyResult<Self> {
        let value = match value.hasattr("tolist")? {
            true => &value.call_method0("tolist")?,
            false => value,
        };
        let is_sequence = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
        let is_list_field = matches!(field.field_type, FieldType::List(..));
        let contains_lists = || {
            value.get_item(0).is_ok_and(|first| first.is_instance_of::<PyList>() || first.is_instance_of::<PyTuple>())
        };
        // Any other iterable is accepted too, such as a generator or a series of pandas or Polars.
        let is_per_design = if is_sequence {
            !is_list_field || value.len()? == 0 || contains_lists()
        } else {
            !value.is_instance_of::<PyString>()
        };
        if is_per_design && let Ok(items) = value.try_iter() {
            return collect_values(items, field, scene);
        }
        Ok(FieldValues::Constant(convert_value(value, field, scene)?))
    }

    fn of_row(&self, row: usize) -> AxisValue {
        match self {
            FieldValues::Constant(value) => value.clone(),
            FieldValues::PerDesign(values) => values[row].clone(),
        }
    }
}

/// Collects one value per design, at most `MAX_RUNS`. Checks for Ctrl-C between values.
fn collect_values(items: Bound<'_, PyIterator>, field: &Field, scene: &Scene) -> PyResult<FieldValues> {
    let py = items.py();
    let mut values = Vec::new();
    for item in items {
        if values.len() as u64 == MAX_RUNS {
            let message = format!(
                "error: there are more than {MAX_RUNS} designs, and all results are stored in memory; evaluate fewer at a time"
            );
            return Err(errors::sweep(py, message));
        }
        py.check_signals()?;
        values.push(convert_value(&item?, field, scene)?);
    }
    Ok(FieldValues::PerDesign(values))
}

/// Returns the number of designs.
fn design_count(py: Python<'_>, paths: &[String], values: &[FieldValues]) -> PyResult<usize> {
    let mut previous: Option<(usize, &String)> = None;
    for (path, field_values) in paths.iter().zip(values) {
        let FieldValues::PerDesign(values) = field_values else { continue };
        match previous {
            Some((count, first)) if count != values.len() => {
                let message = format!(
                    "error: `{first}` has {count} values, but `{path}` has {}\n  = help: give arrays of equal length, or one value for all designs",
                    values.len()
                );
                return Err(errors::sweep(py, message));
            }
            _ => previous = Some((values.len(), path)),
        }
    }
    Ok(previous.map_or(1, |(count, _)| count))
}

/// Converts one value. An invalid value is not an error here: it enters the scene as text, and the row of its run gives
/// the error of the scene as the reason.
fn convert_value(value: &Bound<'_, PyAny>, field: &Field, scene: &Scene) -> PyResult<AxisValue> {
    // The unit depends on the scene.
    if matches!(field.field_type, FieldType::OneOf(_) | FieldType::List(..)) && !value.is_instance_of::<PyString>() {
        let text = quantities::setting_text(scene, &field.path, value)?;
        return Ok(field.parse_toml(&text).unwrap_or(AxisValue { text, value: Value::Missing }));
    }
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(convert_number(number.extract()?, field));
    }
    if value.is_instance_of::<PyInt>() && !value.is_instance_of::<PyBool>() {
        return Ok(convert_number(value.extract()?, field));
    }
    let text = match value.cast::<PyString>() {
        Ok(text) => toml::Value::from(text.to_str()?).to_string(),
        Err(_) => conversion::setting_text(value)?,
    };
    Ok(field.parse_toml(&text).unwrap_or(AxisValue { text, value: Value::Missing }))
}

fn convert_number(si: f64, field: &Field) -> AxisValue {
    field.value_of_si(si).unwrap_or_else(|| {
        let text = match &field.field_type {
            FieldType::Quantity(dimension) => format!("\"{si:?} {}\"", dimension.units()[0].name),
            _ => conversion::format_toml_number(si),
        };
        AxisValue { text, value: Value::Missing }
    })
}
