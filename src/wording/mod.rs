//! How figures and words are put before people, whatever shows them: reports, pictures, pages.
//!
//! What a run needs of it is in the crate that shows one; here is what studies need besides.
//!
//! | file | job |
//! |---|---|
//! | `quantity` | columns and keys with a short name and a unit of everyday size |
//! | `selection` | criteria, conditions and counts of a selection |

pub mod quantity;
mod selection;

pub use phalanx_show::wording::{Report, Reported, acts, duration, escaped, figures, report};
pub use quantity::Quantity;
pub use selection::{condition_name, criterion_key, criterion_name, percent_of};
