//! Formatting for reports, pictures and pages.
//!
//! This module adds the names of columns of studies to `phalanx_show::format`.

use std::borrow::Cow;

use crate::scene::Axis;

pub use crate::study::quantity::{self, ColumnFormat};
pub use phalanx_show::format::{Report, ToReport, escape_markup, format_duration, is_unsafe_char, numbers, report};

/// Returns a count as a share of `total`, in percent with one decimal; a dash if `total` is 0.
pub(crate) fn percent_of(count: usize, total: usize) -> String {
    if total == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / total as f64) }
}

/// A coordinate of a pose in mm or degrees.
pub(crate) fn in_axis_unit(axis: Axis, value: f64) -> f64 {
    if axis == Axis::Angle { value.to_degrees() } else { value * 1e3 }
}

/// The unit of [`in_axis_unit`].
pub(crate) fn axis_unit(axis: Axis) -> &'static str {
    if axis == Axis::Angle { "deg" } else { "mm" }
}

/// Writes characters as the escapes of JSON, so that a JSON document with escaped characters remains valid.
pub(crate) fn escape_chars(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match is_escaped(c) {
            true => escaped.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => escaped.push(c),
        }
    }
    Cow::Owned(escaped)
}
