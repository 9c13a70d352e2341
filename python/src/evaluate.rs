//! Many designs of a scene at once, whose fields are given as arrays.

use phalanx::study::sweep::{Field, Holds, MOST_RUNS, Point, columns, given};
use phalanx::table::Value;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyIterator, PyList, PyString, PyTuple};

use super::scene::SceneLike;
use super::table::Table;
use super::{errors, study, words};

/// Simulates many designs of a scene, on Rust's threads, and makes of them the table of a sweep: a row each, in order.
///
/// fields: values by the path of their field, such as `{"design.base": [0.018, 0.020, 0.022], "contact.friction.mu_static": 0.6}`.
/// Arrays and lists are all of one length; a single value is that of every design. A number is in SI, a text has its unit.
/// threads: 0 for one on each core. columns: only these of the table. check: check every run (three more runs for each).
///
/// A design whose scene is not valid, or whose run does not end, is a row with `status` and `reason`, never an exception; one that
/// cannot grasp its object has a `reason` and no `class`. `class_reason` says what decides the class. Raises
/// StudyError for a path that is no field, or arrays of different lengths; SceneError for a scene that is none.
#[pyfunction]
#[pyo3(signature = (scene, fields, *, model = "analytic", threads = 0, columns = None, check = false))]
pub fn evaluate(
    py: Python<'_>,
    scene: SceneLike,
    fields: &Bound<'_, PyDict>,
    model: &str,
    threads: usize,
    columns: Option<Vec<String>>,
    check: bool,
) -> PyResult<Table> {
    let scene = scene.get(py)?;
    let paths = fields.keys().extract::<Vec<String>>()?;
    let names: Vec<&str> = paths.iter().map(String::as_str).collect();
    let model = super::result::model(py, model)?;
    let mut study = given(&scene.layers, &scene.settings, &names, model).map_err(|error| match error {
        phalanx::study::sweep::GivenError::Scene(error) => errors::scene(py, &error),
        error => errors::sweep(py, error),
    })?;
    study.checked = check;
    refuse_unknown(py, &study, columns.as_deref())?;
    let values: Vec<Given> = fields
        .values()
        .iter()
        .zip(study.row_fields())
        .map(|(value, field)| Given::read(&value, field))
        .collect::<PyResult<_>>()?;
    let count = length(py, &paths, &values)?;
    let rows = (0..count).map(|row| values.iter().map(|value| value.at(row)).collect()).collect();
    let study = study.with_rows(rows);
    let found = study::rows(py, &study, threads, u64::MAX)?;
    Table::new(py, found, columns.as_deref())
}

fn refuse_unknown(py: Python<'_>, study: &phalanx::study::sweep::Study, wanted: Option<&[String]>) -> PyResult<()> {
    let there: Vec<String> = columns(study).into_iter().map(|column| column.name).collect();
    let there: Vec<&str> = there.iter().map(String::as_str).collect();
    match wanted.into_iter().flatten().find(|name| !there.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => Err(errors::sweep(
            py,
            format!("error: `{name}` is no column of these results\n  = help: there are {}", there.join(", ")),
        )),
    }
}

/// What is given of a field.
enum Given {
    /// One value for all designs.
    One(Point),
    Each(Vec<Point>),
}

impl Given {
    fn read(value: &Bound<'_, PyAny>, field: &Field) -> PyResult<Self> {
        let value = match value.hasattr("tolist")? {
            true => &value.call_method0("tolist")?,
            false => value,
        };
        let several = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
        let lists = matches!(field.holds, Holds::List(_));
        let of_lists = || {
            value.get_item(0).is_ok_and(|first| first.is_instance_of::<PyList>() || first.is_instance_of::<PyTuple>())
        };
        // A series of pandas or Polars, a generator: whatever can be gone through.
        let each_design =
            if several { !lists || value.len()? == 0 || of_lists() } else { !value.is_instance_of::<PyString>() };
        if each_design && let Ok(items) = value.try_iter() {
            return each(items, field);
        }
        Ok(Given::One(point(value, field)?))
    }

    fn at(&self, row: usize) -> Point {
        match self {
            Given::One(point) => point.clone(),
            Given::Each(points) => points[row].clone(),
        }
    }
}

/// A value for each design, no more than are taken; Ctrl-C is heard meanwhile.
fn each(items: Bound<'_, PyIterator>, field: &Field) -> PyResult<Given> {
    let py = items.py();
    let mut points = Vec::new();
    for item in items {
        if points.len() as u64 == MOST_RUNS {
            let message =
                format!("error: there are more than {MOST_RUNS} designs, all held in memory; give them in parts");
            return Err(errors::sweep(py, message));
        }
        py.check_signals()?;
        points.push(point(&item?, field)?);
    }
    Ok(Given::Each(points))
}

/// How many designs there are.
fn length(py: Python<'_>, paths: &[String], values: &[Given]) -> PyResult<usize> {
    let mut found: Option<(usize, &String)> = None;
    for (path, value) in paths.iter().zip(values) {
        let Given::Each(points) = value else { continue };
        match found {
            Some((count, first)) if count != points.len() => {
                let message = format!(
                    "error: `{first}` has {count} values and `{path}` {}\n  = help: give arrays of one length, or one value for all designs",
                    points.len()
                );
                return Err(errors::sweep(py, message));
            }
            _ => found = Some((points.len(), path)),
        }
    }
    Ok(found.map_or(1, |(count, _)| count))
}

/// One value. What the field does not take stands in the scene as it was given, and is refused there: a row says why.
fn point(value: &Bound<'_, PyAny>, field: &Field) -> PyResult<Point> {
    if let Ok(number) = value.cast::<PyFloat>() {
        return Ok(numbered(number.extract()?, field));
    }
    if value.is_instance_of::<PyInt>() && !value.is_instance_of::<PyBool>() {
        return Ok(numbered(value.extract()?, field));
    }
    let text = match value.cast::<PyString>() {
        Ok(text) => toml::Value::from(text.to_str()?).to_string(),
        Err(_) => words::toml(value)?,
    };
    Ok(field.parsed(&text).unwrap_or(Point { text, value: Value::Missing }))
}

fn numbered(si: f64, field: &Field) -> Point {
    field.at(si).unwrap_or_else(|| {
        let text = match &field.holds {
            Holds::Quantity(dimension) => format!("\"{si:?} {}\"", dimension.units()[0].name),
            _ => words::number(si),
        };
        Point { text, value: Value::Missing }
    })
}
