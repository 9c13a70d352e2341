//! Study files of optimisations.

use std::path::PathBuf;

use phalanx::scene::Keyword;
use phalanx::study::optimisation::{Optimisation, Variable as Varied, load, parse};
use phalanx::study::sweep::AxisValue;
use phalanx::trace::overrides::Overrides;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;

use super::scene::Scene;
use super::{conversion, errors};

/// A field that a search varies, with its range.
#[pyclass(frozen, module = "phalanx._phalanx")]
pub struct Variable(Varied);

#[pymethods]
impl Variable {
    /// Path of the field.
    #[getter]
    fn path(&self) -> &str {
        &self.0.field.path
    }

    /// Name of its column in the results: the path with the unit of the SI value.
    #[getter]
    fn column(&self) -> String {
        self.0.field.column()
    }

    /// Both ends of the range in SI, as in the study.
    #[getter]
    fn ends_si(&self) -> [f64; 2] {
        [0.0, 1.0].map(|end| self.0.si_at(end))
    }

    /// Whether equal ratios of values have equal distances in the search.
    #[getter]
    fn is_log(&self) -> bool {
        self.0.is_log()
    }

    /// Fraction of the range at which the start value lies.
    #[getter]
    fn start_fraction(&self) -> f64 {
        self.0.start_fraction
    }

    /// Returns the value at a fraction of the range, from 0 to 1, as written in a scene.
    fn value_at<'py>(&self, py: Python<'py>, fraction: f64) -> PyResult<Bound<'py, PyAny>> {
        written(py, &self.0.value_at(fraction))
    }

    /// Returns the SI value at a fraction of the range.
    fn si_at(&self, fraction: f64) -> f64 {
        self.0.si_at(fraction)
    }
}

/// Reads and checks a study file of an optimisation and its base scene.
///
/// text: content of the file; by default, the file is read. model: overrides the model of the study. preset: replaces
/// the integrator settings of the scene. Raises StudyError with file, line and field of the errors.
#[pyfunction]
#[pyo3(signature = (file, text = None, model = None, preset = None))]
pub fn _read_optimisation<'py>(
    py: Python<'py>,
    file: PathBuf,
    text: Option<&str>,
    model: Option<&str>,
    preset: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let read = text.map_or_else(|| load(&file), |text| parse(text, &file.display().to_string()));
    let study = read.map_err(|error| errors::study(py, &error))?;
    let model = model.map_or(Ok(study.model), |model| super::result::model(py, model))?;
    let preset = super::simulate::parse_preset(py, preset)?;
    let overrides = Overrides { preset, ..Overrides::default() };
    overrides.reject_unused(model).map_err(|error| errors::argument(py, error))?;
    let Optimisation { name, description, scene, files, variables, verdict, .. } = study;
    let dict = PyDict::new(py);
    dict.set_item("name", name)?;
    dict.set_item("description", description)?;
    dict.set_item("model", model.name())?;
    dict.set_item("preset", preset.map(|preset| preset.keyword()))?;
    dict.set_item("scene", Scene::from_layers(py, Ok(scene), Vec::new())?)?;
    dict.set_item("files", files)?;
    dict.set_item("variables", variables.into_iter().map(Variable).collect::<Vec<_>>())?;
    let condition = |fields: &Vec<(String, AxisValue)>| {
        let values = PyDict::new(py);
        fields.iter().try_for_each(|(path, value)| values.set_item(path, written(py, value)?))?;
        Ok(values)
    };
    dict.set_item("conditions", study.conditions.iter().map(condition).collect::<PyResult<Vec<_>>>()?)?;
    dict.set_item("objectives", to_python(py, &study.objectives)?)?;
    dict.set_item("constraints", to_python(py, &study.constraints)?)?;
    dict.set_item("method", to_python(py, &study.method)?)?;
    dict.set_item("verdict", verdict)?;
    dict.set_item("source", to_python(py, &study.keys)?)?;
    Ok(dict)
}

fn to_python<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    conversion::parse_json(py, &serde_json::to_string(value).unwrap_or_default())
}

fn written<'py>(py: Python<'py>, value: &AxisValue) -> PyResult<Bound<'py, PyAny>> {
    to_python(py, &value.toml())
}
