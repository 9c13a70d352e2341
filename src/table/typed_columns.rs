//! Access to columns by name and kind.

use super::value::parse_cell;
use super::{Kind, Table, TableError, Value};

impl Table {
    /// Index of a column.
    ///
    /// # Errors
    /// Returns an error if the table has no column of that name.
    pub fn column(&self, name: &str) -> Result<usize, TableError> {
        self.find(name).ok_or_else(|| TableError::NoColumn {
            file: self.origin.file.clone(),
            name: name.to_string(),
            columns: self.columns.iter().map(|column| column.name.clone()).collect(),
        })
    }

    /// Index of an optional column.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// Values of a column of numbers or integers; `None` for missing values.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or a value is of another kind.
    pub fn numbers(&self, name: &str) -> Result<Vec<Option<f64>>, TableError> {
        self.values_of_kind(name, Kind::Number, |value| match value {
            Value::Number(number) => Some(*number),
            Value::Integer(integer) => Some(*integer as f64),
            _ => None,
        })
    }

    /// Values of a column of integers.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or a value is of another kind.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, TableError> {
        self.values_of_kind(name, Kind::Integer, |value| match value {
            Value::Integer(integer) => Some(*integer),
            _ => None,
        })
    }

    /// Values of a column of flags.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or a value is of another kind.
    pub fn flags(&self, name: &str) -> Result<Vec<Option<bool>>, TableError> {
        self.values_of_kind(name, Kind::Flag, |value| match value {
            Value::Flag(flag) => Some(*flag),
            _ => None,
        })
    }

    /// Values of a column of texts.
    ///
    /// # Errors
    /// Returns an error if there is no such column, or a value is of another kind.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<&str>>, TableError> {
        self.values_of_kind(name, Kind::Text, |value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Values of a column, converted by `get`, which returns `None` for values of other kinds.
    fn values_of_kind<'a, T>(
        &'a self,
        name: &str,
        expected_kind: Kind,
        get: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Vec<Option<T>>, TableError> {
        let index = self.column(name)?;
        let mut found = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            match row.get(index) {
                None | Some(Value::Missing) => found.push(None),
                Some(value) => match get(value) {
                    Some(value) => found.push(Some(value)),
                    None => return Err(self.type_error(index, name, expected_kind)),
                },
            }
        }
        Ok(found)
    }

    /// Returns an error for the first value that is not of the expected kind. In a CSV file one invalid cell makes the
    /// whole column text, so cells are parsed again.
    fn type_error(&self, index: usize, name: &str, expected_kind: Kind) -> TableError {
        let fits = |value: &Value| match value {
            Value::Missing => true,
            Value::Integer(_) => matches!(expected_kind, Kind::Integer | Kind::Number),
            Value::Text(text) => parse_cell(text, expected_kind).is_some(),
            value => value.kind() == Some(expected_kind),
        };
        let row = self.rows.iter().position(|row| row.get(index).is_some_and(|value| !fits(value))).unwrap_or(0);
        self.cell_error(row, name, &self.rows[row][index], expected_kind)
    }

    /// Returns an error for a value of the wrong kind.
    pub(super) fn cell_error(&self, row: usize, name: &str, found: &Value, expected_kind: Kind) -> TableError {
        let lines = &self.origin.lines;
        // Line numbers are invalid if rows have been removed.
        let location = match lines.get(row) {
            Some(line) if lines.len() == self.rows.len() => format!("{}:{line}", self.origin.file),
            _ if self.origin.file.is_empty() => format!("row {}", row + 1),
            _ => format!("{}, row {}", self.origin.file, row + 1),
        };
        TableError::Cell {
            location,
            number: self.find(name).map_or(0, |index| index + 1),
            column: name.to_string(),
            found: found.text(),
            expected_kind: expected_kind.description(),
        }
    }
}
