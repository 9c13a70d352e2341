//! A selection as tables, as JSON, and as a table of data.
//!
//! | file | job |
//! |---|---|
//! | `text` | tables for people |
//! | `document` | the JSON document |
//! | `data` | the ranking as a typed table |

mod data;
mod document;
mod text;

pub use data::{is_ranking, ranking_table};
pub use document::SelectionReport;
