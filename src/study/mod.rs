//! Studies: what a choice of settings does to a result.

pub mod select;
pub mod stability;
pub mod step_size;
