//! Studies: what a choice of settings does to a result, and what a choice of designs does.

pub mod reproduce;
pub mod select;
pub mod stability;
pub mod step_size;
pub mod sweep;
