//! Formatting for reports, pictures and pages.
//!
//! This module adds the parts needed by studies to `phalanx_show::format`.
//!
//! | file | job |
//! |---|---|
//! | `quantity` | short names and common units of columns and keys |

pub mod quantity;

pub use phalanx_show::format::{Report, ToReport, escape_markup, format_duration, is_unsafe_char, numbers, report};
pub use quantity::Quantity;

pub use crate::study::select::{condition_name, criterion_name};

/// Returns a count as a share of `total`, in percent with one decimal; a dash if `total` is 0.
pub fn percent_of(count: usize, total: usize) -> String {
    if total == 0 { "–".to_string() } else { format!("{:.1} %", 100.0 * count as f64 / total as f64) }
}
