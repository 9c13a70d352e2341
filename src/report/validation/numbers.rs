//! Formats the numbers of a comparison.

use crate::format::numbers::format_number;

/// Formats a number, or a dash for `None`.
pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("–".to_string(), |value| format_number(value, digits))
}

/// Formats a ratio in percent.
pub(super) fn percent(value: Option<f64>) -> String {
    number(value.map(|value| 100.0 * value), 2)
}
