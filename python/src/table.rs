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
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use super::{columns, conversion, errors};

/// Number of rows that `print` shows.
const PREVIEW_ROWS: usize = 5;
/// Width of the printed text, characters.
const PREVIEW_WIDTH: usize = 100;

/// The results of a sweep: one row for each run, columns as in the tables of `phalanx sweep`, values in SI.
#[pyclass(frozen, module = "phalanx")]
pub struct Table {
    batch: RecordBatch,
    /// Counts of runs, as a JSON document.
    summary: String,
}

impl Table {
    /// Converts the results of a sweep; `requested`: only these columns.
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

#[pymethods]
impl Table {
    /// Returns a column as a numpy array.
    ///
    /// Numbers are a read-only view, or a copy with NaN if values are missing. Flags are bools, or objects if values
    /// are missing; strings are objects. Missing objects are None.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self.batch.column_by_name(column).ok_or_else(|| {
            let similar = phalanx::scene::closest_match(column, &self.names());
            let suggestion =
                similar.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_else(|| ".".to_string());
            PyKeyError::new_err(format!(
                "{column} is not a column of this table{suggestion} table.columns lists all columns"
            ))
        })?;
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
