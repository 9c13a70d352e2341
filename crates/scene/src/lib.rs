//! Scenes: descriptions of simulations, as text and in SI units. The crate `phalanx-core` simulates them.
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! Modules depend on each other in one direction only: `limits, units ← scene`; `scene` uses the crate
//! `phalanx-mechanics`.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare results with other libraries"))]

pub mod limits;
pub mod scene;
pub mod units;

pub use phalanx_mechanics::{drive, fivebar, gripper, law, mechanism, numeric, palm_motion, shape, sizing, statics};
