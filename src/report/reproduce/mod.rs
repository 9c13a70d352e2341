//! Report of the reproduction of the thesis: paper, JSON and text.
//!
//! | file | content |
//! |---|---|
//! | `comparison` | comparison of computed values with the thesis and with expected values |
//! | `paper` | the paper: its sections in order |
//! | `comparison_table` | tables that several sections share |
//! | `sizing`, `statics`, `volumes`, `sweep`, `selection`, `chosen_design`, `errata` | one section each |
//! | `document` | JSON document |
//! | `text` | text tables |

mod chosen_design;
mod comparison;
mod comparison_table;
mod document;
mod errata;
mod paper;
mod selection;
mod sizing;
mod statics;
mod sweep;
mod text;
mod volumes;

pub use comparison::{Comparison, Verdict, comparisons};
pub use document::ReproductionReport;
