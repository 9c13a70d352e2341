//! Errors of the library as the exceptions of `phalanx.errors`, with the messages of the command line.

use std::fmt::Display;

use phalanx::scene::{Located, SceneError, located};
use phalanx::study::sweep::StudyError;
use phalanx::table::TableError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};

/// An exception of this name with these attributes.
fn raised(py: Python<'_>, name: &str, message: &str, attributes: &Bound<'_, PyDict>) -> PyErr {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let made = || -> PyResult<Bound<'_, PyAny>> {
        let module = MODULE.get_or_try_init(py, || py.import("phalanx.errors").map(Bound::unbind))?;
        let class = module.bind(py).getattr(name)?.cast_into::<PyType>()?;
        class.call((message,), Some(attributes))
    };
    made().map_or_else(|error| error, PyErr::from_value)
}

/// What is wrong with a scene, or with what it was asked for.
pub fn scene(py: Python<'_>, error: &SceneError) -> PyErr {
    placed(py, "SceneError", &error.to_string(), &located(error))
}

/// What is wrong with an argument.
pub fn argument(py: Python<'_>, message: impl Display) -> PyErr {
    placed(py, "SceneError", &format!("error: {message}"), &[])
}

/// What is wrong with a study.
pub fn study(py: Python<'_>, error: &StudyError) -> PyErr {
    match error {
        StudyError::Read { .. } => placed(py, "StudyError", &error.to_string(), &[]),
        StudyError::Invalid(inner) => placed(py, "StudyError", &error.to_string(), &located(inner)),
    }
}

/// What is wrong with the fields, the rows or the files of a study.
pub fn sweep(py: Python<'_>, message: impl Display) -> PyErr {
    placed(py, "StudyError", &message.to_string(), &[])
}

/// A table that cannot be read or written.
pub fn table(py: Python<'_>, error: &TableError) -> PyErr {
    sweep(py, format!("error: {error}"))
}

/// A run that was not completed, or a log that cannot be read or written; `result` is what there is of the run.
pub fn run(py: Python<'_>, message: impl Display, result: Option<Py<PyAny>>) -> PyErr {
    let attributes = PyDict::new(py);
    match attributes.set_item("result", result) {
        Ok(()) => raised(py, "RunError", &format!("error: {message}"), &attributes),
        Err(error) => error,
    }
}

fn placed(py: Python<'_>, name: &str, message: &str, problems: &[Located]) -> PyErr {
    let attributes = || -> PyResult<Bound<'_, PyDict>> {
        let of = |problem: &Located| -> PyResult<Py<PyDict>> {
            let place = PyDict::new(py);
            place.set_item("file", &problem.file)?;
            place.set_item("line", problem.line)?;
            place.set_item("column", problem.column)?;
            place.set_item("field", &problem.field)?;
            place.set_item("message", &problem.message)?;
            place.set_item("help", &problem.help)?;
            Ok(place.unbind())
        };
        let attributes = PyDict::new(py);
        attributes.set_item("problems", problems.iter().map(of).collect::<PyResult<Vec<_>>>()?)?;
        Ok(attributes)
    };
    match attributes() {
        Ok(attributes) => raised(py, name, message, &attributes),
        Err(error) => error,
    }
}
