//! Formatting for reports, pictures and pages.
//!
//! This module adds the names of columns of studies to `phalanx_show::format`.

use std::borrow::Cow;

pub use crate::study::quantity::{self, ColumnFormat};
pub use phalanx_show::format::{Report, ToReport, escape_markup, format_duration, is_unsafe_char, numbers, report};

/// Returns a count as a share of `total`, in percent with one decimal; a dash if `total` is 0.
pub(crate) fn percent_of(count: usize, total: usize) -> String {
    if total == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / total as f64) }
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
