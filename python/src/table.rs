//! The class `Table`: results of a sweep.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, BooleanArray, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field};
use phalanx::format::numbers::format_number;
use phalanx::format::report;
use phalanx::study::sweep::summary;
use phalanx::table::{self, Column, Kind, Value};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyCapsule, PyType};

use super::conversion::Reduced;
use super::{columns, conversion, errors};

/// Number of rows that `print` shows.
const PREVIEW_ROWS: usize = 5;
/// Width of the printed text, characters.
const PREVIEW_WIDTH: usize = 100;

/// The results of a sweep: one row for each run. Columns are those of the tables of `phalanx sweep`; values are in SI.
#[pyclass(frozen, module = "phalanx")]
pub struct Table {
    batch: RecordBatch,
    /// Counts of runs, as a JSON document.
    summary: String,
}

impl Table {
    /// Converts the results of a sweep. If `requested` is given, only these columns are kept.
    pub fn new(py: Python<'_>, results: table::Table, requested: Option<&[String]>) -> PyResult<Self> {
        let counts = summary(&results).map_err(|error| errors::table(py, &error))?;
        let mut document = serde_json::to_value(&counts).unwrap_or_default();
        for (key, counts) in [("by_status", &counts.by_status), ("by_class", &counts.by_class)] {
            document[key] =
                counts.iter().map(|(name, count)| (name.clone(), serde_json::Value::from(*count))).collect();
        }
        let table::Table { columns, rows, .. } = results;
        let is_requested = |column: &Column| requested.is_none_or(|names| names.contains(&column.name));
        let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) = columns
            .iter()
            .enumerate()
            .filter(|(_, column)| is_requested(column))
            .map(|(index, column)| arrow_column(column, index, &rows))
            .unzip();
        Ok(Table { batch: columns::build_batch(fields, arrays)?, summary: document.to_string() })
    }

    fn names(&self) -> Vec<&str> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().as_str()).collect()
    }
}

/// Converts one column of the rows to Arrow.
fn arrow_column(column: &Column, index: usize, rows: &[Vec<Value>]) -> (Field, ArrayRef) {
    let cells = rows.iter().map(|row| row.get(index).unwrap_or(&Value::Missing));
    let (data_type, array): (DataType, ArrayRef) = match column.kind {
        Kind::Integer => {
            (DataType::Int64, Arc::new(cells.map(Value::as_integer).collect::<PrimitiveArray<Int64Type>>()))
        }
        Kind::Number => {
            (DataType::Float64, Arc::new(cells.map(Value::as_number).collect::<PrimitiveArray<Float64Type>>()))
        }
        Kind::Flag => (DataType::Boolean, Arc::new(cells.map(Value::as_flag).collect::<BooleanArray>())),
        Kind::Text => (DataType::Utf8, Arc::new(cells.map(Value::as_text).collect::<StringArray>())),
    };
    (Field::new(&column.name, data_type, true), array)
}

/// Converts a batch to a table of the library, for writing and printing.
fn to_library_table(batch: &RecordBatch) -> table::Table {
    fn values<A: Array + 'static, V>(array: &ArrayRef, get: impl Fn(&A, usize) -> V) -> Vec<Value>
    where
        Value: From<V>,
    {
        let Some(array) = array.as_any().downcast_ref::<A>() else { return Vec::new() };
        (0..array.len()).map(|row| if array.is_null(row) { Value::Missing } else { get(array, row).into() }).collect()
    }
    let column = |(field, array): (&Arc<Field>, &ArrayRef)| {
        let (kind, cells) = match field.data_type() {
            DataType::Int64 => {
                (Kind::Integer, values(array, |cells: &PrimitiveArray<Int64Type>, row| cells.value(row)))
            }
            DataType::Float64 => {
                (Kind::Number, values(array, |cells: &PrimitiveArray<Float64Type>, row| cells.value(row)))
            }
            DataType::Boolean => (Kind::Flag, values(array, |cells: &BooleanArray, row| cells.value(row))),
            _ => (Kind::Text, values(array, |cells: &StringArray, row| cells.value(row).to_string())),
        };
        (Column::new(field.name(), kind), cells.into_iter())
    };
    let (columns, mut cells): (Vec<Column>, Vec<_>) =
        batch.schema_ref().fields().iter().zip(batch.columns()).map(column).unzip();
    let row = |_| cells.iter_mut().map(|column| column.next().unwrap_or(Value::Missing)).collect();
    let rows = (0..batch.num_rows()).map(row).collect();
    table::Table::new(columns, rows)
}

/// A column for pickling: name, type, and values.
type SavedColumn<'py> = (String, String, Bound<'py, PyAny>);

/// Converts a column for pickling. Numbers are bytes, and flags tell which are present; other values are lists.
fn save_column<'py>(py: Python<'py>, name: &str, array: &ArrayRef) -> PyResult<SavedColumn<'py>> {
    fn present<A: 'static>(array: &ArrayRef) -> PyResult<&A> {
        array.as_any().downcast_ref().ok_or_else(|| PyValueError::new_err("the column has another type"))
    }
    let (kind, values) = match array.data_type() {
        DataType::Float64 => {
            let numbers: &PrimitiveArray<Float64Type> = present(array)?;
            let is_present: Vec<bool> = (0..numbers.len()).map(|row| numbers.is_valid(row)).collect();
            let bytes = PyBytes::new(py, &conversion::to_bytes(numbers.values()));
            ("number", (bytes, is_present).into_pyobject(py)?.into_any())
        }
        DataType::Int64 => {
            let integers: &PrimitiveArray<Int64Type> = present(array)?;
            ("integer", integers.iter().collect::<Vec<_>>().into_pyobject(py)?)
        }
        DataType::Boolean => {
            let flags: &BooleanArray = present(array)?;
            ("flag", flags.iter().collect::<Vec<_>>().into_pyobject(py)?)
        }
        _ => {
            let texts: &StringArray = present(array)?;
            ("text", texts.iter().collect::<Vec<_>>().into_pyobject(py)?)
        }
    };
    Ok((name.to_string(), kind.to_string(), values))
}

/// Converts a column back from [`save_column`].
fn restore_column((name, kind, values): SavedColumn<'_>) -> PyResult<(Field, ArrayRef)> {
    let (data_type, array): (DataType, ArrayRef) = match kind.as_str() {
        "number" => {
            let (bytes, is_present): (Bound<'_, PyBytes>, Vec<bool>) = values.extract()?;
            let numbers = conversion::from_bytes(bytes.as_bytes());
            let array = PrimitiveArray::<Float64Type>::new(numbers.into(), Some(is_present.into()));
            (DataType::Float64, Arc::new(array))
        }
        "integer" => {
            let integers: Vec<Option<i64>> = values.extract()?;
            (DataType::Int64, Arc::new(PrimitiveArray::<Int64Type>::from(integers)))
        }
        "flag" => (DataType::Boolean, Arc::new(BooleanArray::from(values.extract::<Vec<Option<bool>>>()?))),
        _ => (DataType::Utf8, Arc::new(StringArray::from(values.extract::<Vec<Option<String>>>()?))),
    };
    Ok((Field::new(name, data_type, true), array))
}

#[pymethods]
impl Table {
    /// Returns a column as a numpy array.
    ///
    /// Numbers are a read-only view, or a copy with NaN if values are missing. Flags are bools, or objects if values
    /// are missing; strings are objects. Missing objects are None.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self
            .batch
            .column_by_name(column)
            .ok_or_else(|| columns::unknown_column(column, &self.names(), "this table", "table.columns"))?;
        columns::column_array(py, array)
    }

    /// Names of all columns, with their units.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.names()
    }

    /// Counts of runs: `runs`, `by_status`, `by_class`, and `reasons` of runs that were not completed or have no class.
    ///
    /// `no_class` is the number of completed runs without a class, because the finger cannot grasp its object.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        conversion::parse_json(py, &self.summary)
    }

    /// Returns all columns as a pandas DataFrame.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::to_pandas(py, &self.batch)
    }

    /// Returns all columns as a Polars DataFrame.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        columns::to_polars(slf.py(), slf.as_any())
    }

    /// Returns all columns as an Arrow stream, for pyarrow, Polars, DuckDB and others.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // The protocol allows a producer to ignore the requested schema.
        let _ = requested_schema;
        columns::arrow_stream(py, &self.batch)
    }

    /// Supports the dataframe interchange protocol through pyarrow, for libraries without Arrow's C stream interface.
    ///
    /// Raises ImportError without pyarrow.
    #[pyo3(signature = (nan_as_null = false, allow_copy = true))]
    fn __dataframe__<'py>(slf: &Bound<'py, Self>, nan_as_null: bool, allow_copy: bool) -> PyResult<Bound<'py, PyAny>> {
        columns::interchange(slf.as_any(), nan_as_null, allow_copy)
    }

    /// Supports pickling, such as for other processes.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py, (Vec<SavedColumn<'py>>, String)>> {
        let (py, table) = (slf.py(), slf.get());
        let fields = table.batch.schema_ref().fields().iter().zip(table.batch.columns());
        let saved = fields.map(|(field, array)| save_column(py, field.name(), array)).collect::<PyResult<Vec<_>>>()?;
        Ok((py.get_type::<Self>().getattr("_restore")?, (saved, table.summary.clone())))
    }

    #[classmethod]
    fn _restore(_class: &Bound<'_, PyType>, columns: Vec<SavedColumn<'_>>, summary: String) -> PyResult<Self> {
        let restored = columns.into_iter().map(restore_column).collect::<PyResult<Vec<_>>>()?;
        let (fields, arrays) = restored.into_iter().unzip();
        Ok(Table { batch: columns::build_batch(fields, arrays)?, summary })
    }

    /// Writes the table as CSV or Parquet, by the suffix of the path. It replaces only a table of phalanx, or one with the same
    /// columns; for another file it raises StudyError.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        table::write_over_own(&path, &to_library_table(&self.batch)).map_err(|error| errors::table(py, &error))
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let statuses = self.summary(py)?.get_item("by_status")?;
        let (runs, columns) = (self.batch.num_rows(), self.batch.num_columns());
        Ok(format!("<phalanx.Table of {runs} runs and {columns} columns, {statuses}>"))
    }

    /// Returns the first rows as text, wrapped by columns, and the number of all rows.
    fn __str__(&self, py: Python<'_>) -> PyResult<String> {
        let first = to_library_table(&self.batch.slice(0, self.batch.num_rows().min(PREVIEW_ROWS)));
        let header = first.columns.iter().map(|column| column.name.clone()).collect();
        let cell_text = |value: &Value| match value {
            Value::Number(number) => format_number(*number, 5),
            Value::Missing => "–".to_string(),
            Value::Text(text) if text.chars().count() > 20 => text.chars().take(19).chain(['…']).collect(),
            other => other.text(),
        };
        let cells = first.rows.iter().map(|row| row.iter().map(cell_text).collect());
        let lines = std::iter::once(header).chain(cells).collect::<Vec<Vec<String>>>();
        let text = report::table(&lines).to_wrapped_text(PREVIEW_WIDTH);
        let hidden = self.batch.num_rows() - first.rows.len();
        let hidden = if hidden > 0 { format!("and {hidden} more rows\n") } else { String::new() };
        Ok(format!("{text}{hidden}{}", self.__repr__(py)?))
    }
}
