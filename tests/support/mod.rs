//! What several test programs need. Every program takes in all of it and uses a part.
#![allow(dead_code)]

pub mod cli;
pub mod collect;
pub mod faults;
pub mod gripper;
pub mod grippers;
pub mod held;
pub mod laws;
pub mod random;
pub mod replay;
pub mod runs;
pub mod scenes;
pub mod select;
pub mod statics;
pub mod studies;
pub mod synthetic;
#[cfg(unix)]
pub mod terminal;
