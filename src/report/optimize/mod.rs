//! What an optimisation found.
//!
//! | file | job |
//! |---|---|
//! | `document` | one document of plain figures |
//! | `text` | tables for people |
//! | `paper` | a paper: the picture, the tables, and the scenes of the front |

mod document;
mod paper;
mod text;

pub use document::{OptimisationReport, is_designs, scene_file};
pub use text::optimisation_list;
