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
//! A controller in the loop:
//!
//! ```
//! use phalanx::prelude::*;
//!
//! let scene = scene::load("scenes/experiment-95.toml")?;
//! let mut simulation = Simulation::new(&scene, Model::Analytic)?;
//! while simulation.time_s() < 20e-3 {
//!     let is_fast = simulation.get("qd11_rad_s")? > 60.0;
//!     simulation.set_torque("motor", if is_fast { 0.3 } else { 0.48 })?;
//!     simulation.advance(1e-4)?;
//! }
//! assert!(simulation.get("q11_rad")? > 0.0 && !simulation.events().is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Sink`](prelude::Sink) in place of `()` receives every sample and event: a [`Recording`](prelude::Recording) stores them
//! as arrays, an [`ObjectTracker`](prelude::ObjectTracker) judges the grasp. [`run_to`](prelude::log::run_to) runs a scene
//! and writes its log. `examples/` contains short programs.

// Users of the library need the prelude. The other modules are public for the program, the Python package and the tests of
// this repository; they may change with any version, and the documentation does not show them.
pub mod docs;
pub mod prelude;

#[doc(hidden)]
pub mod cli;
mod files;
#[doc(hidden)]
pub mod format;
#[doc(hidden)]
pub mod limits;
#[doc(hidden)]
pub mod mjcf;
#[doc(hidden)]
pub mod page;
#[doc(hidden)]
pub mod plot;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod scene;
#[doc(hidden)]
pub mod shipped;
#[doc(hidden)]
pub mod study;
#[doc(hidden)]
pub mod table;
#[doc(hidden)]
pub mod validate;

#[doc(hidden)]
pub use phalanx_core::{
    analytic, check, criteria, drawing, drive, engine, fivebar, gradient, grasp, gripper, integrator, invariants, law,
    mechanism, numeric, shape, sizing, statics, trace, units,
};
#[doc(hidden)]
pub use phalanx_log as log;
#[doc(hidden)]
pub use phalanx_parallel as parallel;
#[doc(hidden)]
pub use phalanx_thesis as thesis;

/// Runs the code of the file as documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
