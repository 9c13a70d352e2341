//! Pictures of a selection.
//!
//! | file | job |
//! |---|---|
//! | `strip` | a strip of cells, one for each design, for any number of designs |
//! | `criteria` | runs removed by each criterion, by design (thesis Fig. 4.6) |
//! | `classes` | the designs sorted by each variable, coloured by class (Figs. 4.4, A.16–A.19) |
//! | `panels` | forces, variables and dependent quantities by design (Figs. 4.1, 4.2, 4.5, A.20–A.23) |

mod classes;
mod criteria;
mod panels;
mod strip;

pub use classes::{selection_classes, selection_static};
pub use criteria::selection_criteria;
pub use panels::{selection_forces, selection_variables};

use crate::study::select::Selection;

/// Sorted numbers of the designs.
fn design_numbers(selection: &Selection) -> Vec<i64> {
    let mut numbers: Vec<i64> = selection.runs.iter().map(|run| run.design).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}
