//! Reports, playbacks and pictures of runs and grasps, without files, threads and clocks. Used by the command line, the
//! pages and the browser.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! Modules depend on each other in one direction only: `format ← plot, playback ← report ← explorer`. The crate
//! `phalanx` re-exports them.

pub mod explorer;
pub mod format;
pub mod playback;
pub mod plot;
pub mod report;

pub(crate) use phalanx_core::{
    check, criteria, drawing, grasp, gripper, invariants, mechanism, numeric, scene, shape, sizing, statics, trace,
    units,
};
