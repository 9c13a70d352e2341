//! What phalanx says and shows of a run or a grasp, without files, threads and clocks: for the command line, the pages, and the browser.
//!
//! Modules depend on each other in one direction only: `wording ← plot, film ← report ← explorer`. The crate `phalanx` has it all.

pub mod explorer;
pub mod film;
pub mod plot;
pub mod report;
pub mod wording;

pub(crate) use phalanx_core::{
    check, criteria, drawing, grasp, gripper, invariants, numeric, scene, shape, statics, trace, units,
};
