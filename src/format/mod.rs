//! Formatting for reports, pictures and pages.
//!
//! This module adds the parts needed by studies to `phalanx_show::format`.
//!
//! | file | job |
//! |---|---|
//! | `quantity` | short names and common units of columns and keys |
//! | `selection` | names of criteria and conditions of a selection, shares of counts |

pub mod quantity;
mod selection;

pub use phalanx_show::format::{Report, ToReport, escape_markup, format_duration, is_unsafe_char, numbers, report};
pub use quantity::Quantity;
pub use selection::{condition_name, criterion_key, criterion_name, percent_of};
