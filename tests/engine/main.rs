//! Tests of the engine model against the analytic one.
//!
//! One program for the room: linking is most of what a test program costs.

#[path = "../support/mod.rs"]
mod support;

mod anchor;
mod contact;
mod finger_held;
mod gripper;
mod motors;
mod order;
mod recorder;
mod repeats;
mod scales;
mod stability;
mod touching_rows;
