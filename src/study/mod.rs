//! Studies: what a choice of settings does to a result.

pub mod grasp;
pub mod stability;
pub mod step_size;
pub mod sweep;
