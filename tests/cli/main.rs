//! Tests of the command line, its reports, its pages and pictures.
//!
//! A single test program, because linking is most of its cost.

#[path = "../support/mod.rs"]
mod support;

mod drawing;
mod first_minutes;
mod grasp;
mod gripper;
mod limits;
mod manual;
mod mechanism;
mod messages;
mod mujoco;
mod ownership;
mod page;
mod replay;
mod report;
mod run;
mod set;
mod studies;
#[cfg(unix)]
mod terminal;
mod untrusted_names;
