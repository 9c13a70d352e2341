//! Numbers that carry derivatives: one formula serves the value and its exact Jacobian.

mod dual;
pub mod plane;
mod real;

pub use dual::Dual;
pub use real::Real;
