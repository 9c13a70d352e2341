//! Numbers that carry derivatives: one formula serves the value and its exact Jacobian. And the elementary functions that all use.

mod dual;
mod each;
pub mod elementary;
pub mod plane;
mod real;

pub use dual::Dual;
pub use each::{changed, each, from_each};
pub use real::Real;
