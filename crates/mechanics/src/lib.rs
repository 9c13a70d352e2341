//! The mechanics shared by both models of phalanx, without time integration: mechanisms, kinematics and dynamics of the
//! five-bar, contact laws, sizing, statics.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! Modules depend on each other in one direction only: `numeric ← law, shape ← drive, palm_motion ← mechanism, gripper ← fivebar ← sizing, statics`.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare results with other libraries"))]

pub mod drive;
pub mod fivebar;
pub mod gripper;
pub mod law;
pub mod mechanism;
pub mod numeric;
pub mod palm_motion;
pub mod shape;
pub mod sizing;
pub mod statics;
