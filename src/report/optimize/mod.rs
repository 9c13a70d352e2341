//! Report of an optimisation.
//!
//! | file | content |
//! |---|---|
//! | `document` | JSON document |
//! | `text` | text tables |
//! | `paper` | HTML report: plot, tables and the scenes of the Pareto front |

mod document;
mod paper;
mod text;

pub use document::{OptimisationReport, is_design_table, scene_file};
pub use text::optimisation_list;
