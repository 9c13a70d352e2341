//! Quantities as text: a number and its unit, to and from plain `f64` in SI.
//!
//! | file | job |
//! |---|---|
//! | `table` | the closed list of accepted units of every dimension, conversion factors as `uom` has them |
//! | `parse` | `"480 N*mm"` → 0.48 |
//! | `format` | 0.48 → `"480 N*mm"`, such that it parses back to the same bits |

mod format;
mod number;
mod parse;
mod table;

pub use format::format;
pub use number::number;
pub use parse::split;
pub use parse::{QuantityError, parse, positive};
pub use table::{Dimension, G_M_S2, LONGEST_S, Unit};
