//! Scene files as they grow.

use std::fmt::Write;

use crate::units::{Dimension, format, number};

/// TOML text that grows line by line.
#[derive(Default)]
pub struct Out {
    pub text: String,
}

impl Out {
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
        let text = number(value);
        let suffix = if text.contains(['.', 'e']) { "" } else { ".0" };
        self.raw(key, format_args!("{text}{suffix}"));
    }

    pub fn quantity(&mut self, key: &str, value: f64, dimension: Dimension) {
        self.raw(key, format_args!("\"{}\"", format(value, dimension)));
    }

    pub fn quantities(&mut self, key: &str, values: &[f64], dimension: Dimension) {
        let texts: Vec<String> = values.iter().map(|v| format!("\"{}\"", format(*v, dimension))).collect();
        self.raw(key, format_args!("[{}]", texts.join(", ")));
    }
}
