//! phalanx: a planar simulator of high-speed underactuated grippers.
//!
//! ARCHITECTURE.md lists the modules and their dependencies.
//!
//! Simulation of a closing finger from a scene file:
//!
//! ```
//! use phalanx::prelude::*;
//!
//! let scene = scene::load("scenes/experiment-95.toml")?;
//! let outcome = run(Model::Analytic, &scene, &mut ())?;
//! let distal = outcome.finger_contact(FingerContact::Distal);
//! assert_eq!(distal.touchdowns, 1);
//! assert!((distal.first_s.unwrap() - 6.883746e-3).abs() < 1e-8);
//! assert!((outcome.last.finger_contact(FingerContact::Proximal).normal_n - 23.609).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A scene of discs, to study a contact law alone:
//!
//! ```
//! use phalanx::prelude::*;
//!
//! let scene = scene::load_any("scenes/laws/spring.toml")?;
//! let outcome = run(Model::Analytic, &scene, &mut ())?;
//! // k δ^e at 2 cm.
//! assert!((outcome.contacts[0].peak_normal_n / (1e8 * 0.02f64.powf(2.2)) - 1.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`trace::Sink`] in place of `()` receives every sample and event: [`trace::Recording`] stores them as arrays,
//! [`criteria::Tracker`] evaluates the dynamic criteria. [`log::run_to`] runs a scene and writes its log. `examples/`
//! contains short programs.

pub mod cli;
pub mod docs;
mod files;
pub mod format;
pub mod limits;
pub mod mjcf;
pub mod page;
pub mod plot;
pub mod prelude;
pub mod report;
pub mod scene;
pub mod shipped;
pub mod study;
pub mod table;
pub mod validate;

pub use phalanx_core::{
    analytic, check, criteria, drawing, drive, engine, fivebar, gradient, grasp, gripper, integrator, invariants, law,
    mechanism, numeric, shape, sizing, statics, trace, units,
};
pub use phalanx_log as log;
pub use phalanx_parallel as parallel;
pub use phalanx_thesis as thesis;

/// Runs the code of the file as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
