//! Report of a selection.
//!
//! | file | content |
//! |---|---|
//! | `text` | text tables |
//! | `document` | JSON document |
//! | `data` | the ranking as a typed table |

mod data;
mod document;
mod text;

pub use data::{is_ranking, ranking_table};
pub use document::SelectionReport;
