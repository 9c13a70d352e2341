//! Tests of the command line, its reports, its pages and pictures.
//!
//! One program for the room: linking is most of what a test program costs.

#[path = "../support/mod.rs"]
mod support;

mod drawing;
mod first_minutes;
mod foreign_words;
mod gripper;
mod limits;
mod linkage;
mod manual;
mod messages;
mod own;
mod page;
mod replay;
mod report;
mod run;
mod select;
mod set;
mod size;
mod status;
#[cfg(unix)]
mod terminal;
mod version;
mod volume;
