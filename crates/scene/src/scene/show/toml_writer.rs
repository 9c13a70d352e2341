//! A writer for scene files.

use std::fmt::Write;

use super::super::keywords::SceneKind;
use crate::units::{self, Dimension, number};

/// Writes the TOML text of a scene of some kind line by line.
pub struct TomlWriter {
    pub text: String,
    pub kind: SceneKind,
    /// Significant digits of quantities; `None` for all digits.
    digits: Option<usize>,
}

/// Smaller lengths and angles are rounding errors.
const ROUNDING_ERROR: f64 = 1e-12;

impl TomlWriter {
    pub fn new(kind: SceneKind) -> Self {
        TomlWriter { text: String::new(), kind, digits: None }
    }

    /// Creates a writer that rounds quantities and floats to a number of significant digits.
    pub fn rounded(kind: SceneKind, digits: usize) -> Self {
        TomlWriter { digits: Some(digits), ..TomlWriter::new(kind) }
    }

    fn round(&self, value: f64, dimension: Option<Dimension>) -> f64 {
        let Some(digits) = self.digits else { return value };
        let is_rounding_error =
            matches!(dimension, Some(Dimension::Length | Dimension::Angle)) && value.abs() < ROUNDING_ERROR;
        let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
        if is_rounding_error { 0.0 } else { rounded }
    }

    fn format_quantity(&self, value: f64, dimension: Dimension) -> String {
        let exact = units::format(self.round(value, Some(dimension)), dimension);
        if self.digits.is_none() {
            return exact;
        }
        // A value rounded in radians is not round in degrees.
        if dimension == Dimension::Angle && value.to_degrees().abs() >= 0.1 {
            return format!("{} deg", number(self.round(value.to_degrees(), None)));
        }
        let Some((size, unit)) = exact.split_once(' ') else { return exact };
        let size: f64 = size.parse().unwrap_or(value);
        let size = self.round(size, None);
        format!("{} {unit}", number(size))
    }

    pub fn comment(&mut self, text: &str) {
        let _ = writeln!(self.text, "# {text}");
    }

    pub fn section(&mut self, path: &str) {
        let _ = write!(self.text, "\n[{path}]\n");
    }

    pub fn raw(&mut self, key: &str, value: impl std::fmt::Display) {
        let _ = writeln!(self.text, "{key} = {value}");
    }

    pub fn text(&mut self, key: &str, value: &str) {
        self.raw(key, toml::Value::String(value.to_string()));
    }

    /// Writes a TOML float; a large number without decimal point would overflow TOML integers.
    pub fn float(&mut self, key: &str, value: f64) {
        let text = number(self.round(value, None));
        let suffix = if text.contains(['.', 'e']) { "" } else { ".0" };
        self.raw(key, format_args!("{text}{suffix}"));
    }

    pub fn quantity(&mut self, key: &str, value: f64, dimension: Dimension) {
        let text = self.format_quantity(value, dimension);
        self.raw(key, format_args!("\"{text}\""));
    }

    pub fn quantities(&mut self, key: &str, values: &[f64], dimension: Dimension) {
        let texts: Vec<String> =
            values.iter().map(|v| format!("\"{}\"", self.format_quantity(*v, dimension))).collect();
        self.raw(key, format_args!("[{}]", texts.join(", ")));
    }
}
