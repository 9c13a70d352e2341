//! What phalanx computes, without files, threads and clocks: mechanism, laws, both models, grasp criteria, and scenes read from text.
//!
//! Modules depend on each other in one direction only:
//! `units ← gripper, law ← fivebar ← sizing, statics ← scene ← analytic, engine ← trace, drawing ← criteria, invariants, check ← grasp`;
//! `numeric` and `integrator` know nothing of grippers. The crate `phalanx` has it all, with files, logs, studies and the command line.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests hold what is computed to other libraries"))]

pub mod analytic;
pub mod check;
pub mod criteria;
pub mod drawing;
#[cfg(feature = "engine")]
pub mod engine;
pub mod fivebar;
pub mod grasp;
pub mod gripper;
pub mod integrator;
pub mod invariants;
pub mod law;
pub mod limits;
pub mod numeric;
pub mod scene;
pub mod sizing;
pub mod statics;
pub mod trace;
pub mod units;
