//! Tests of the engine model against the analytic one.
//!
//! All of them are one program, because linking takes most of the build time of a test program.

#[path = "../support/mod.rs"]
mod support;

mod contact;
mod disc_rows;
mod finger;
mod gripper;
mod instances;
mod limits;
mod mechanism;
mod recorder;
mod sizes;
