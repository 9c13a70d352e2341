//! Columns by name, of the kind that is wanted.

use super::value::read;
use super::{Kind, Table, TableError, Value};

impl Table {
    /// Index of a column.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn column(&self, name: &str) -> Result<usize, TableError> {
        self.find(name).ok_or_else(|| TableError::NoColumn {
            file: self.origin.file.clone(),
            name: name.to_string(),
            columns: self.columns.iter().map(|column| column.name.clone()).collect(),
        })
    }

    /// Index of a column that may not be there.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// A column of numbers, integers among them; `None` where one is missing.
    ///
    /// # Errors
    /// There is no such column, or a value is something else.
    pub fn numbers(&self, name: &str) -> Result<Vec<Option<f64>>, TableError> {
        self.all(name, Kind::Number, |value| match value {
            Value::Number(number) => Some(*number),
            Value::Integer(integer) => Some(*integer as f64),
            _ => None,
        })
    }

    /// A column of integers.
    ///
    /// # Errors
    /// There is no such column, or a value is something else.
    pub fn integers(&self, name: &str) -> Result<Vec<Option<i64>>, TableError> {
        self.all(name, Kind::Integer, |value| match value {
            Value::Integer(integer) => Some(*integer),
            _ => None,
        })
    }

    /// A column of flags.
    ///
    /// # Errors
    /// There is no such column, or a value is something else.
    pub fn flags(&self, name: &str) -> Result<Vec<Option<bool>>, TableError> {
        self.all(name, Kind::Flag, |value| match value {
            Value::Flag(flag) => Some(*flag),
            _ => None,
        })
    }

    /// A column of texts.
    ///
    /// # Errors
    /// There is no such column, or a value is something else.
    pub fn texts(&self, name: &str) -> Result<Vec<Option<&str>>, TableError> {
        self.all(name, Kind::Text, |value| match value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        })
    }

    /// Every value of a column by `get`, which knows values of one kind.
    fn all<'a, T>(
        &'a self,
        name: &str,
        wanted: Kind,
        get: impl Fn(&'a Value) -> Option<T>,
    ) -> Result<Vec<Option<T>>, TableError> {
        let at = self.column(name)?;
        let mut found = Vec::with_capacity(self.rows.len());
        for row in &self.rows {
            match row.get(at) {
                None | Some(Value::Missing) => found.push(None),
                Some(value) => match get(value) {
                    Some(value) => found.push(Some(value)),
                    None => return Err(self.odd(at, name, wanted)),
                },
            }
        }
        Ok(found)
    }

    /// The value that makes a column something else than is wanted. In a text file one slip makes texts of all its values:
    /// the first that cannot be read otherwise is to blame.
    fn odd(&self, at: usize, name: &str, wanted: Kind) -> TableError {
        let fits = |value: &Value| match value {
            Value::Missing => true,
            Value::Integer(_) => matches!(wanted, Kind::Integer | Kind::Number),
            Value::Text(text) => read(text, wanted).is_some(),
            value => value.kind() == Some(wanted),
        };
        let row = self.rows.iter().position(|row| row.get(at).is_some_and(|value| !fits(value))).unwrap_or(0);
        self.cell(row, name, &self.rows[row][at], wanted)
    }

    /// That a value is not what is wanted.
    pub(super) fn cell(&self, row: usize, name: &str, found: &Value, wanted: Kind) -> TableError {
        let lines = &self.origin.lines;
        // Lines mean nothing where rows have been taken out since.
        let place = match lines.get(row) {
            Some(line) if lines.len() == self.rows.len() => format!("{}:{line}", self.origin.file),
            _ if self.origin.file.is_empty() => format!("row {}", row + 1),
            _ => format!("{}, row {}", self.origin.file, row + 1),
        };
        TableError::Cell {
            place,
            number: self.find(name).map_or(0, |at| at + 1),
            column: name.to_string(),
            found: found.text(),
            wanted: wanted.name(),
        }
    }
}
