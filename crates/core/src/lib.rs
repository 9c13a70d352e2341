//! What phalanx computes, without files, threads and clocks: both models of what a scene describes, runs of them, and what grasps come to.
//!
//! Modules depend on each other in one direction only:
//! `analytic, engine ← trace, drawing ← criteria, invariants, check ← grasp`; all of them use what the crates `phalanx-integrator` and
//! `phalanx-scene` have. The crate `phalanx` has it all, with files, logs, studies and the command line.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests hold what is computed to other libraries"))]

pub mod analytic;
pub mod check;
pub mod criteria;
pub mod drawing;
#[cfg(feature = "engine")]
pub mod engine;
pub mod grasp;
pub mod invariants;
pub mod trace;

pub use phalanx_integrator as integrator;
pub use phalanx_scene::{fivebar, gripper, law, limits, numeric, scene, shape, sizing, statics, units};
