//! Quantities as text, a number with its unit, to and from plain `f64` in SI units.
//!
//! | file | contents |
//! |---|---|
//! | `table` | accepted units of every dimension, with the conversion factors of `uom` |
//! | `parse` | `"480 N*mm"` → 0.48 |
//! | `format` | 0.48 → `"480 N*mm"`, such that it parses back to the same bits |

mod format;
mod parse;
mod table;

pub use format::{format, number};
pub use parse::{QuantityError, parse, parse_positive, split_quantity};
pub use table::{Dimension, G_M_S2, MAX_TIME_S, Unit};
