//! Scenes: what phalanx simulates as a text, and what it stands for. Nothing here knows of time; what moves is the crate `phalanx-core`.
//!
//! Modules depend on each other in one direction only: `limits, units ← scene`; `scene` uses what the crate `phalanx-mechanics` has.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests hold what is computed to other libraries"))]

pub mod limits;
pub mod scene;
pub mod units;

pub use phalanx_mechanics::{fivebar, gripper, law, numeric, shape, sizing, statics};
