//! Tests of scene files: parsing, defaults, messages.
//!
//! They are one test program because most of its cost is linking.

#[path = "../support/mod.rs"]
mod support;

mod bodies;
mod broken;
mod common;
mod engine;
mod fuzz_corpus;
mod gripper;
mod resolve;
mod run;
mod settings;
mod shipped;
mod show;
mod unsupported;
