//! Tests of the integrator on systems of their own. They stand here because what they integrate is compiled with them, and is to be fast.
//!
//! One program: linking is most of what a test program costs.

#![allow(clippy::disallowed_methods, reason = "tests hold what is computed to other libraries")]

mod events;
mod impact;
mod order;
mod stepping;
mod stiff;
mod wall;
