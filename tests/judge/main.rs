//! Tests of what is said of runs: checks, criteria, comparisons, random and hard scenes.
//!
//! One program for the room: linking is most of what a test program costs.

#[path = "../support/mod.rs"]
mod support;

mod budget;
mod campaign;
mod check;
mod check_verdicts;
mod criteria_anchor;
mod criteria_reason;
mod criteria_tracker;
mod dice;
mod fates;
mod grippers;
mod hard_grippers;
mod hard_scenes;
mod random_scenes;
mod validate_command;
mod validate_criteria;
mod validate_measures;
mod validate_scenes;
