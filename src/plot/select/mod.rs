//! Pictures of a selection.
//!
//! | file | job |
//! |---|---|
//! | `strip` | a strip of cells, one for each design, for any number of designs |
//! | `criteria` | runs removed by each criterion, by design (thesis Fig. 4.6) |
//! | `classes` | the designs sorted by each variable, coloured by class (Figs. 4.4, A.16–A.19) |
//! | `forces` | final forces and palm force by design (Figs. 4.5, A.20–A.23) |
//! | `variables` | varied and dependent quantities by design (Figs. 4.1, 4.2) |

mod classes;
mod criteria;
mod forces;
mod strip;
mod variables;

pub use classes::{selection_classes, selection_static};
pub use criteria::selection_criteria;
pub use forces::selection_forces;
pub use variables::selection_variables;
