//! Numbers with derivatives, for which one formula gives the value and its exact Jacobian, and elementary functions.

mod arrays;
mod dual;
pub mod elementary;
pub mod plane;
mod real;

pub use arrays::{array_from, map_array, map_same_type};
pub use dual::Dual;
pub use real::Real;
