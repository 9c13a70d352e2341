//! Tests of scene files: reading, defaults, messages.
//!
//! One program for the room: linking is most of what a test program costs.

#[path = "../support/mod.rs"]
mod support;

mod bodies;
mod broken;
mod engine;
mod fuzz_corpus;
mod gripper;
mod resolve;
mod run;
mod settings;
mod ship;
mod show;
mod sound;
