//! Scene files as they grow.

use std::fmt::Write;

use super::super::words::SceneKind;
use crate::units::{self, Dimension, number};

/// TOML text of a scene of some kind that grows line by line.
pub struct Out {
    pub text: String,
    pub kind: SceneKind,
    /// Significant digits of quantities; all of them if `None`.
    digits: Option<usize>,
}

/// Lengths and angles that are less than this come from rounding and nothing else.
const NOTHING: f64 = 1e-12;

impl Out {
    pub fn new(kind: SceneKind) -> Self {
        Out { text: String::new(), kind, digits: None }
    }

    /// Quantities and floats in so many digits.
    pub fn rounded(kind: SceneKind, digits: usize) -> Self {
        Out { digits: Some(digits), ..Out::new(kind) }
    }

    fn written(&self, value: f64, dimension: Option<Dimension>) -> f64 {
        let Some(digits) = self.digits else { return value };
        let small = matches!(dimension, Some(Dimension::Length | Dimension::Angle)) && value.abs() < NOTHING;
        let rounded = format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value);
        if small { 0.0 } else { rounded }
    }

    fn quoted(&self, value: f64, dimension: Dimension) -> String {
        let exact = units::format(self.written(value, Some(dimension)), dimension);
        if self.digits.is_none() {
            return exact;
        }
        // Rounded radians are no round degrees.
        if dimension == Dimension::Angle && value.to_degrees().abs() >= 0.1 {
            return format!("{} deg", number(self.written(value.to_degrees(), None)));
        }
        let Some((size, unit)) = exact.split_once(' ') else { return exact };
        let size: f64 = size.parse().unwrap_or(value);
        let size = self.written(size, None);
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

    /// A TOML float: an integer would overflow where it is large.
    pub fn float(&mut self, key: &str, value: f64) {
        let text = number(self.written(value, None));
        let suffix = if text.contains(['.', 'e']) { "" } else { ".0" };
        self.raw(key, format_args!("{text}{suffix}"));
    }

    pub fn quantity(&mut self, key: &str, value: f64, dimension: Dimension) {
        let text = self.quoted(value, dimension);
        self.raw(key, format_args!("\"{text}\""));
    }

    pub fn quantities(&mut self, key: &str, values: &[f64], dimension: Dimension) {
        let texts: Vec<String> = values.iter().map(|v| format!("\"{}\"", self.quoted(*v, dimension))).collect();
        self.raw(key, format_args!("[{}]", texts.join(", ")));
    }
}
