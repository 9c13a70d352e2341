//! Code shared by the test programs. Each program includes the whole module and uses part of it.
#![allow(dead_code)]

pub mod checked_run;
pub mod cli;
pub mod designs;
pub mod faults;
pub mod interior_point;
pub mod laws;
pub mod mechanism_cases;
pub mod reference_cases;
pub mod replay;
pub mod runs;
#[path = "../../tools/campaign/scenes/mod.rs"]
pub mod scenes;
pub mod statics;
pub mod studies;
pub mod sweep_results;
pub mod synthetic;
#[cfg(unix)]
pub mod terminal;

pub use scenes::random;
