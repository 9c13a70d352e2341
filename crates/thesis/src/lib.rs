//! Reproduction of the master's thesis "Dynamic grasping of objects with a high-speed parallel robot".
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! | module | content |
//! |---|---|
//! | [`volume`] | grasp-state volumes: designs that hold the object |
//! | [`stability`] | stability and accuracy of the engine model over step, stiffness and damping |
//! | [`step_size`] | impact force as a function of step size |
//! | [`reproduce`] | all printed figures, recomputed and compared |
//!
//! The crate reads and writes no files. Sweeps and selections are computed by the crate `phalanx` and passed to
//! [`reproduce`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare rounded values"))]

pub mod reproduce;
pub mod stability;
pub mod step_size;
mod text;
pub mod volume;

use phalanx_core::{check, criteria, gripper, integrator, invariants, numeric, scene, sizing, statics, trace};
use phalanx_show::{format, plot};
