//! Tests of the integrator on its own test systems. They belong to this crate because the test systems are compiled
//! with it, optimised.
//!
//! A single test program, because linking dominates its build time.

#![allow(clippy::disallowed_methods, reason = "tests compare results with other libraries")]

mod events;
mod methods;
mod wall;
