//! Tables of sweeps.

use std::path::PathBuf;
use std::sync::Arc;

use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, BooleanArray, PrimitiveArray, RecordBatch, StringArray};
use arrow_schema::{DataType, Field};
use phalanx::study::sweep::summary;
use phalanx::table::{self, Column, Kind, Value};
use phalanx::wording::figures::figure;
use phalanx::wording::report;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use super::{columns, errors, words};

/// Rows that `print` shows, and how wide they may be.
const SHOWN: usize = 5;
const WIDTH: usize = 100;

/// What a sweep found: a row for each run, columns as in the tables of `phalanx sweep`, figures in SI.
#[pyclass(frozen, module = "phalanx")]
pub struct Table {
    batch: RecordBatch,
    /// Counts, as a document.
    counts: String,
}

impl Table {
    /// Of the results of a sweep; `wanted`: of these columns alone.
    pub fn new(py: Python<'_>, found: table::Table, wanted: Option<&[String]>) -> PyResult<Self> {
        let counts = summary(&found).map_err(|error| errors::table(py, &error))?;
        let mut document = serde_json::to_value(&counts).unwrap_or_default();
        for (key, of) in [("by_status", &counts.by_status), ("by_class", &counts.by_class)] {
            document[key] = of.iter().map(|(name, count)| (name.clone(), serde_json::Value::from(*count))).collect();
        }
        let table::Table { columns, rows, .. } = found;
        let taken = |column: &Column| wanted.is_none_or(|wanted| wanted.contains(&column.name));
        let (fields, arrays): (Vec<Field>, Vec<ArrayRef>) = columns
            .iter()
            .enumerate()
            .filter(|(_, column)| taken(column))
            .map(|(at, column)| of_kind(column, at, &rows))
            .unzip();
        Ok(Table { batch: columns::made(fields, arrays)?, counts: document.to_string() })
    }

    fn names(&self) -> Vec<&str> {
        self.batch.schema_ref().fields().iter().map(|field| field.name().as_str()).collect()
    }
}

/// One column of rows.
fn of_kind(column: &Column, at: usize, rows: &[Vec<Value>]) -> (Field, ArrayRef) {
    let cells = rows.iter().map(|row| row.get(at).unwrap_or(&Value::Missing));
    let (kind, array): (DataType, ArrayRef) = match column.kind {
        Kind::Integer => {
            let of = |cell: &Value| if let Value::Integer(whole) = cell { Some(*whole) } else { None };
            (DataType::Int64, Arc::new(cells.map(of).collect::<PrimitiveArray<Int64Type>>()))
        }
        Kind::Number => {
            let of = |cell: &Value| if let Value::Number(number) = cell { Some(*number) } else { None };
            (DataType::Float64, Arc::new(cells.map(of).collect::<PrimitiveArray<Float64Type>>()))
        }
        Kind::Flag => {
            let of = |cell: &Value| if let Value::Flag(flag) = cell { Some(*flag) } else { None };
            (DataType::Boolean, Arc::new(cells.map(of).collect::<BooleanArray>()))
        }
        Kind::Text => (DataType::Utf8, Arc::new(cells.map(text).collect::<StringArray>())),
    };
    (Field::new(&column.name, kind, true), array)
}

fn text(cell: &Value) -> Option<&str> {
    if let Value::Text(text) = cell { Some(text) } else { None }
}

/// The same as a table of phalanx, to be written.
fn rows(batch: &RecordBatch) -> table::Table {
    fn of<A: Array + 'static, V>(array: &ArrayRef, get: impl Fn(&A, usize) -> V) -> Vec<Value>
    where
        Value: From<V>,
    {
        let Some(array) = array.as_any().downcast_ref::<A>() else { return Vec::new() };
        (0..array.len()).map(|row| if array.is_null(row) { Value::Missing } else { get(array, row).into() }).collect()
    }
    let column = |(field, array): (&Arc<Field>, &ArrayRef)| {
        let (kind, cells) = match field.data_type() {
            DataType::Int64 => (Kind::Integer, of(array, |of: &PrimitiveArray<Int64Type>, row| of.value(row))),
            DataType::Float64 => (Kind::Number, of(array, |of: &PrimitiveArray<Float64Type>, row| of.value(row))),
            DataType::Boolean => (Kind::Flag, of(array, |of: &BooleanArray, row| of.value(row))),
            _ => (Kind::Text, of(array, |of: &StringArray, row| of.value(row).to_string())),
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
    /// A column as an array of numpy. Numbers are a view that cannot be written to, or where some are missing a copy with NaN there;
    /// flags are bools and texts objects, None where missing.
    fn __getitem__<'py>(&self, py: Python<'py>, column: &str) -> PyResult<Bound<'py, PyAny>> {
        let array = self.batch.column_by_name(column).ok_or_else(|| {
            let near = phalanx::scene::nearest(column, &self.names());
            let meant = near.map(|name| format!("; did you mean \"{name}\"?")).unwrap_or_default();
            PyKeyError::new_err(format!("{column}: no column of this table{meant} table.columns names all"))
        })?;
        columns::cells(py, array)
    }

    /// Names of all columns, with their units.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.names()
    }

    /// How many runs ended how: `runs`, `by_status`, `by_class`, and `reasons` of those that were not completed or
    /// have no class, because the finger cannot grasp its object (`no_class` of them).
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        words::json(py, &self.counts)
    }

    /// All columns as a pandas DataFrame.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        columns::pandas(py, &self.batch)
    }

    /// All columns as a Polars DataFrame.
    fn to_polars<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        columns::polars(slf.py(), slf.as_any())
    }

    /// All columns as a stream of Arrow, for pyarrow, Polars, DuckDB and others.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // A wish that nobody has to grant.
        let _ = requested_schema;
        columns::stream(py, &self.batch)
    }

    /// Writes the table as CSV or Parquet, by the name.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        table::write(&path, &rows(&self.batch)).map_err(|error| errors::table(py, &error))
    }

    fn __len__(&self) -> usize {
        self.batch.num_rows()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let statuses = self.summary(py)?.get_item("by_status")?;
        let (runs, columns) = (self.batch.num_rows(), self.batch.num_columns());
        Ok(format!("<phalanx.Table of {runs} runs and {columns} columns, {statuses}>"))
    }

    /// The first rows, columns in groups as wide as a terminal, and how many rows there are.
    fn __str__(&self, py: Python<'_>) -> PyResult<String> {
        let first = rows(&self.batch.slice(0, self.batch.num_rows().min(SHOWN)));
        let head = first.columns.iter().map(|column| column.name.clone()).collect();
        let shown = |value: &Value| match value {
            Value::Number(number) => figure(*number, 5),
            Value::Missing => "–".to_string(),
            Value::Text(text) if text.chars().count() > 20 => text.chars().take(19).chain(['…']).collect(),
            other => other.text(),
        };
        let cells = first.rows.iter().map(|row| row.iter().map(shown).collect());
        let text = report::table(&std::iter::once(head).chain(cells).collect::<Vec<Vec<String>>>()).fitted(WIDTH);
        let more = self.batch.num_rows() - first.rows.len();
        let more = if more > 0 { format!("and {more} more rows\n") } else { String::new() };
        Ok(format!("{text}{more}{}", self.__repr__(py)?))
    }
}
