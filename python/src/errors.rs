//! Converts errors of the library into the exceptions of `phalanx.errors`, with the messages of the command line.

use std::fmt::Display;

use phalanx::scene::{LocatedProblem, SceneError, locate_problems};
use phalanx::study::sweep::StudyError;
use phalanx::table::TableError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyDict, PyType};

fn module(py: Python<'_>) -> PyResult<&Bound<'_, PyModule>> {
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    Ok(MODULE.get_or_try_init(py, || py.import("phalanx.errors").map(Bound::unbind))?.bind(py))
}

/// Returns a message in which the flags of the command line are replaced by the arguments of functions.
pub fn in_python(py: Python<'_>, message: String) -> PyResult<String> {
    match message.contains("--") {
        true => module(py)?.call_method1("_in_python", (message,))?.extract(),
        false => Ok(message),
    }
}

/// Returns a JSON document in whose texts the flags are replaced by the arguments of functions.
pub fn document_in_python<'py>(document: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    module(document.py())?.call_method1("_document_in_python", (document,))
}

/// Creates the exception with this class name and these attributes.
fn create_exception(py: Python<'_>, name: &str, message: &str, attributes: &Bound<'_, PyDict>) -> PyErr {
    let create = || -> PyResult<Bound<'_, PyAny>> {
        let class = module(py)?.getattr(name)?.cast_into::<PyType>()?;
        class.call((message,), Some(attributes))
    };
    create().map_or_else(|error| error, PyErr::from_value)
}

/// Returns the `SceneError` for an invalid scene.
pub fn scene(py: Python<'_>, error: &SceneError) -> PyErr {
    located(py, "SceneError", &error.to_string(), &locate_problems(error))
}

/// Returns the `SceneError` for an invalid argument.
pub fn argument(py: Python<'_>, message: impl Display) -> PyErr {
    located(py, "SceneError", &format!("error: {message}"), &[])
}

/// Returns the `StudyError` for an invalid study file.
pub fn study(py: Python<'_>, error: &StudyError) -> PyErr {
    match error {
        StudyError::Read { .. } | StudyError::Field { .. } => located(py, "StudyError", &error.to_string(), &[]),
        StudyError::Invalid(inner) => located(py, "StudyError", &error.to_string(), &locate_problems(inner)),
    }
}

/// Returns the `StudyError` for invalid fields, rows or result files of a study.
pub fn sweep(py: Python<'_>, message: impl Display) -> PyErr {
    located(py, "StudyError", &message.to_string(), &[])
}

/// Returns the `StudyError` for a table that cannot be read or written.
pub fn table(py: Python<'_>, error: &TableError) -> PyErr {
    sweep(py, format!("error: {error}"))
}

/// Returns the `RunError` for a run that was not completed, or for a log that cannot be read or written. `result`
/// contains the run up to the error.
pub fn run(py: Python<'_>, message: impl Display, result: Option<Py<PyAny>>) -> PyErr {
    run_error(py, message, ("result", result))
}

/// Returns the `RunError` for a simulation that cannot advance beyond `time_s`.
pub fn failure(py: Python<'_>, message: impl Display, time_s: f64) -> PyErr {
    run_error(py, message, ("time_s", time_s))
}

fn run_error<'py>(py: Python<'py>, message: impl Display, (name, value): (&str, impl IntoPyObject<'py>)) -> PyErr {
    let attributes = PyDict::new(py);
    match attributes.set_item(name, value) {
        Ok(()) => create_exception(py, "RunError", &format!("error: {message}"), &attributes),
        Err(error) => error,
    }
}

/// Creates an exception whose `problems` have positions in a file.
fn located(py: Python<'_>, name: &str, message: &str, problems: &[LocatedProblem]) -> PyErr {
    let attributes = || -> PyResult<Bound<'_, PyDict>> {
        let to_dict = |problem: &LocatedProblem| -> PyResult<Py<PyDict>> {
            let dict = PyDict::new(py);
            dict.set_item("file", &problem.file)?;
            dict.set_item("line", problem.line)?;
            dict.set_item("column", problem.column)?;
            dict.set_item("field", &problem.field)?;
            dict.set_item("message", &problem.message)?;
            dict.set_item("help", &problem.help)?;
            Ok(dict.unbind())
        };
        let attributes = PyDict::new(py);
        attributes.set_item("problems", problems.iter().map(to_dict).collect::<PyResult<Vec<_>>>()?)?;
        Ok(attributes)
    };
    match attributes() {
        Ok(attributes) => create_exception(py, name, message, &attributes),
        Err(error) => error,
    }
}
