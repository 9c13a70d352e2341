//! Columns as numpy arrays, Arrow streams and data frames, without copies unless values are missing.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, BooleanArray, PrimitiveArray, RecordBatch, RecordBatchIterator,
};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::{PyKeyError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

/// Numbers in memory of phalanx: `numpy.asarray(column)` returns a read-only view.
#[pyclass(frozen, module = "phalanx._phalanx")]
pub struct Column {
    array: ArrayRef,
}

#[pymethods]
impl Column {
    /// Address, type and number of the values, for numpy.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        fn address_of_values<T: ArrowPrimitiveType>(array: &ArrayRef) -> Option<usize> {
            let array = array.as_any().downcast_ref::<PrimitiveArray<T>>()?;
            // The dangling pointer of an empty slice is allowed, because numpy does not dereference it.
            Some(array.values().as_ptr() as usize)
        }
        let (type_string, address) = match self.array.data_type() {
            DataType::Int64 => ("<i8", address_of_values::<Int64Type>(&self.array)),
            _ => ("<f8", address_of_values::<Float64Type>(&self.array)),
        };
        let address = address.ok_or_else(|| PyRuntimeError::new_err("the column does not contain numbers"))?;
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", type_string)?;
        interface.set_item("shape", (self.array.len(),))?;
        // Read-only, because several arrays may share the memory.
        interface.set_item("data", (address, true))?;
        Ok(interface)
    }
}

/// Returns a column of numbers as a numpy array, which keeps the numbers alive.
pub fn number_array<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyAny>> {
    let column = Bound::new(py, Column { array: Arc::clone(array) })?;
    py.import("numpy")?.call_method1("asarray", (column,))
}

/// Returns the columns of a batch by name, each as [`column_array`].
fn column_arrays<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    for (field, array) in batch.schema_ref().fields().iter().zip(batch.columns()) {
        arrays.set_item(field.name(), column_array(py, array)?)?;
    }
    Ok(arrays)
}

/// Returns a column as a numpy array. Missing numbers are NaN. Columns of strings, and columns of flags in which values
/// are missing, are objects with None for missing values.
pub fn column_array<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyAny>> {
    let is_complete = array.null_count() == 0;
    match array.data_type() {
        DataType::Float64 | DataType::Int64 if is_complete => number_array(py, array),
        DataType::Float64 => {
            let values = array.as_any().downcast_ref::<PrimitiveArray<Float64Type>>();
            let values: Vec<f64> = values.into_iter().flatten().map(|value| value.unwrap_or(f64::NAN)).collect();
            number_array(py, &array_of_numbers(values))
        }
        DataType::Int64 => {
            let values = array.as_any().downcast_ref::<PrimitiveArray<Int64Type>>();
            let values: Vec<f64> =
                values.into_iter().flatten().map(|value| value.map_or(f64::NAN, |value| value as f64)).collect();
            number_array(py, &array_of_numbers(values))
        }
        DataType::Boolean => {
            let flags: Vec<Option<bool>> =
                array.as_any().downcast_ref::<BooleanArray>().into_iter().flatten().collect();
            array_from_list(py, flags, if is_complete { "bool" } else { "object" })
        }
        _ => {
            let texts = array.as_any().downcast_ref::<arrow_array::StringArray>();
            let texts: Vec<Option<&str>> = texts.into_iter().flatten().collect();
            array_from_list(py, texts, "object")
        }
    }
}

/// Returns a numpy array with copies of the values.
fn array_from_list<'py, T: IntoPyObject<'py>>(
    py: Python<'py>,
    values: Vec<T>,
    dtype: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let options = PyDict::new(py);
    options.set_item("dtype", dtype)?;
    py.import("numpy")?.call_method("array", (values,), Some(&options))
}

/// Returns numbers as an array over the same memory.
pub fn array_of_numbers(values: Vec<f64>) -> ArrayRef {
    Arc::new(PrimitiveArray::<Float64Type>::from(values))
}

/// Name and unit of a column.
pub type Heading = (String, String);

/// Builds a batch from columns of numbers. The metadata of each field has the unit.
pub fn number_batch(headings: &[Heading], arrays: &[ArrayRef]) -> PyResult<RecordBatch> {
    let field = |(name, unit): &Heading| {
        let unit = HashMap::from([("unit".to_string(), unit.clone())]);
        Field::new(name, DataType::Float64, false).with_metadata(unit)
    };
    build_batch(headings.iter().map(field).collect(), arrays.to_vec())
}

/// Returns the KeyError for a column that does not exist; `of` is "this run" or "this table".
pub fn unknown_column(column: &str, names: &[&str], of: &str, all: &str) -> PyErr {
    let similar = phalanx::scene::closest_match(column, names);
    let suggestion = similar.map_or(".".to_string(), |name| format!("; did you mean \"{name}\"?"));
    PyKeyError::new_err(format!("{column} is not a column of {of}{suggestion} {all} lists all columns"))
}

/// Converts an object with `__arrow_c_stream__` for the dataframe interchange protocol, through pyarrow.
pub fn interchange<'py>(
    source: &Bound<'py, PyAny>,
    nan_as_null: bool,
    allow_copy: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let table = source.py().import("pyarrow")?.call_method1("table", (source,))?;
    table.call_method1("__dataframe__", (nan_as_null, allow_copy))
}

/// Builds a batch from columns with their names and types.
pub fn build_batch(fields: Vec<Field>, arrays: Vec<ArrayRef>) -> PyResult<RecordBatch> {
    RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// Returns a batch through the Arrow C stream interface.
pub fn arrow_stream<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyCapsule>> {
    let reader = RecordBatchIterator::new([Ok(batch.clone())], batch.schema());
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), c"arrow_array_stream")
}

/// Returns a batch as a pandas DataFrame over the same memory.
pub fn to_pandas<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyAny>> {
    let options = PyDict::new(py);
    options.set_item("copy", false)?;
    py.import("pandas")?.call_method("DataFrame", (column_arrays(py, batch)?,), Some(&options))
}

/// Returns an object with `__arrow_c_stream__` as a Polars DataFrame over the same memory.
pub fn to_polars<'py>(py: Python<'py>, source: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    py.import("polars")?.call_method1("DataFrame", (source,))
}
