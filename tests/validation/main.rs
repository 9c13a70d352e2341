//! Tests of checks, criteria and comparisons of runs, with random and hard scenes.
//!
//! They are one test program because most of its cost is linking.

#[path = "../support/mod.rs"]
mod support;

mod budget;
mod campaign;
mod check;
mod criteria;
mod exchange;
mod fates;
mod grasp_anchors;
mod grasp_random;
mod grasp_real;
mod hard_grippers;
mod hard_scenes;
mod random_scenes;
mod servos;
mod turns;
mod validate_command;
mod validate_criteria;
mod validate_measures;
