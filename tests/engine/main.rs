//! Tests of the engine model against the analytic one.
//!
//! All of them are one program, because linking takes most of the build time of a test program.

#[path = "../support/mod.rs"]
mod support;

mod contact;
mod convergence_order;
mod determinism;
mod disc_rows;
mod experiment_95;
mod finger_stiction;
mod gripper;
mod motors;
mod recorder;
mod scaling;
mod stability;
