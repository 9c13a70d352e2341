//! A reproduction as a paper, as JSON, and as a short table.
//!
//! | file | job |
//! |---|---|
//! | `comparison` | the thesis's figures beside ours, and whether ours are as expected |
//! | `paper` | the paper: its sections in order |
//! | `parts` | tables that several sections share |
//! | `sizing`, `statics`, `volumes`, `sweep`, `selection`, `chosen`, `errata` | a section each |
//! | `document` | JSON |
//! | `text` | a table for the terminal |

mod chosen;
mod comparison;
mod document;
mod errata;
mod paper;
mod parts;
mod selection;
mod sizing;
mod statics;
mod sweep;
mod text;
mod volumes;

pub use comparison::{Comparison, Verdict, comparisons};
pub use document::ReproductionReport;
