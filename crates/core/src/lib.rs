//! The computations of phalanx without files, threads and clocks: both models of a scene, their runs, and the
//! evaluation of grasps.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! Modules depend on each other in one direction only: `analytic, engine ← trace, drawing ← criteria ← gradient,
//! invariants, check ← grasp`. All of them use the crates `phalanx-integrator` and `phalanx-scene`. The crate `phalanx` adds files, logs,
//! studies and the command line.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare results with other libraries"))]

pub mod analytic;
pub mod check;
pub mod criteria;
pub mod drawing;
#[cfg(feature = "engine")]
pub mod engine;
pub mod gradient;
pub mod grasp;
pub mod invariants;
pub mod trace;

pub use phalanx_integrator as integrator;
pub use phalanx_scene::{
    drive, fivebar, gripper, law, limits, mechanism, numeric, palm_motion, scene, shape, sizing, statics, units,
};
