//! Formatting for reports, pictures and pages.
//!
//! This module adds the names of columns, criteria and conditions of studies to `phalanx_show::format`.

pub use crate::study::quantity::{self, ColumnFormat};
pub(crate) use crate::study::select::{condition_name, criterion_name};
pub use phalanx_show::format::{Report, ToReport, escape_markup, format_duration, is_unsafe_char, numbers, report};

/// Returns a count as a share of `total`, in percent with one decimal; a dash if `total` is 0.
pub(crate) fn percent_of(count: usize, total: usize) -> String {
    if total == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / total as f64) }
}
