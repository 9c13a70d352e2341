//! Columns: as numpy sees them, and as a stream of Arrow. Neither is a copy.

use std::sync::Arc;

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{
    Array, ArrayRef, ArrowPrimitiveType, BooleanArray, PrimitiveArray, RecordBatch, RecordBatchIterator,
};
use arrow_schema::{DataType, Field, Schema};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};

/// Numbers that phalanx holds, for numpy to look at: `numpy.asarray(column)` is a view that cannot be written to.
#[pyclass(frozen, module = "phalanx._phalanx")]
pub struct Column {
    array: ArrayRef,
}

#[pymethods]
impl Column {
    /// How numpy finds the numbers: their address, kind and count.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        fn start<T: ArrowPrimitiveType>(array: &ArrayRef) -> Option<usize> {
            let array = array.as_any().downcast_ref::<PrimitiveArray<T>>()?;
            // A slice that is empty has an address too, only none that anybody would read.
            Some(array.values().as_ptr() as usize)
        }
        let (kind, address) = match self.array.data_type() {
            DataType::Int64 => ("<i8", start::<Int64Type>(&self.array)),
            _ => ("<f8", start::<Float64Type>(&self.array)),
        };
        let address = address.ok_or_else(|| PyRuntimeError::new_err("a column that is none of numbers"))?;
        let found = PyDict::new(py);
        found.set_item("version", 3)?;
        found.set_item("typestr", kind)?;
        found.set_item("shape", (self.array.len(),))?;
        // Nobody may write to what others look at.
        found.set_item("data", (address, true))?;
        Ok(found)
    }
}

/// A column of numbers as an array of numpy, which keeps the numbers alive.
pub fn numpy<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyAny>> {
    let column = Bound::new(py, Column { array: Arc::clone(array) })?;
    py.import("numpy")?.call_method1("asarray", (column,))
}

/// The columns of a batch, by name, as arrays of numpy: see [`cells`].
pub fn named<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    for (field, array) in batch.schema_ref().fields().iter().zip(batch.columns()) {
        found.set_item(field.name(), cells(py, array)?)?;
    }
    Ok(found)
}

/// A column as an array of numpy. Where something is missing numbers are NaN; flags and texts are objects, None where missing.
pub fn cells<'py>(py: Python<'py>, array: &ArrayRef) -> PyResult<Bound<'py, PyAny>> {
    let whole = array.null_count() == 0;
    match array.data_type() {
        DataType::Float64 | DataType::Int64 if whole => numpy(py, array),
        DataType::Float64 => {
            let values = array.as_any().downcast_ref::<PrimitiveArray<Float64Type>>();
            let values: Vec<f64> = values.into_iter().flatten().map(|value| value.unwrap_or(f64::NAN)).collect();
            numpy(py, &(Arc::new(PrimitiveArray::<Float64Type>::from(values)) as ArrayRef))
        }
        DataType::Int64 => {
            let values = array.as_any().downcast_ref::<PrimitiveArray<Int64Type>>();
            let values: Vec<f64> =
                values.into_iter().flatten().map(|value| value.map_or(f64::NAN, |value| value as f64)).collect();
            numpy(py, &(Arc::new(PrimitiveArray::<Float64Type>::from(values)) as ArrayRef))
        }
        DataType::Boolean => {
            let flags: Vec<Option<bool>> =
                array.as_any().downcast_ref::<BooleanArray>().into_iter().flatten().collect();
            listed(py, flags, if whole { "bool" } else { "object" })
        }
        _ => {
            let texts = array.as_any().downcast_ref::<arrow_array::StringArray>();
            let texts: Vec<Option<&str>> = texts.into_iter().flatten().collect();
            listed(py, texts, "object")
        }
    }
}

fn listed<'py, T: IntoPyObject<'py>>(py: Python<'py>, values: Vec<T>, kind: &str) -> PyResult<Bound<'py, PyAny>> {
    let options = PyDict::new(py);
    options.set_item("dtype", kind)?;
    py.import("numpy")?.call_method("array", (values,), Some(&options))
}

/// A batch of named columns of numbers.
pub fn batch(columns: Vec<(String, Vec<f64>)>) -> PyResult<RecordBatch> {
    let fields: Vec<Field> = columns.iter().map(|(name, _)| Field::new(name, DataType::Float64, false)).collect();
    let arrays =
        columns.into_iter().map(|(_, values)| Arc::new(PrimitiveArray::<Float64Type>::from(values)) as ArrayRef);
    made(fields, arrays.collect())
}

/// A batch of columns with their names and kinds.
pub fn made(fields: Vec<Field>, arrays: Vec<ArrayRef>) -> PyResult<RecordBatch> {
    RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays)
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

/// A batch as whoever speaks Arrow's C stream interface takes it.
pub fn stream<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyCapsule>> {
    let reader = RecordBatchIterator::new([Ok(batch.clone())], batch.schema());
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(reader)), c"arrow_array_stream")
}

/// A batch as a frame of pandas, over the same numbers.
pub fn pandas<'py>(py: Python<'py>, batch: &RecordBatch) -> PyResult<Bound<'py, PyAny>> {
    let options = PyDict::new(py);
    options.set_item("copy", false)?;
    py.import("pandas")?.call_method("DataFrame", (named(py, batch)?,), Some(&options))
}

/// A batch as a frame of Polars, over the same numbers.
pub fn polars<'py>(py: Python<'py>, owner: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    py.import("polars")?.call_method1("DataFrame", (owner,))
}
