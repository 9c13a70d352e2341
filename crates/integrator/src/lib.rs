//! Stiff integration of small hybrid second-order systems q̇ = v, v̇ = a(t, q, v).
//!
//! Internal to phalanx: its interface may change with any version. Programs use the crate `phalanx`.
//!
//! A [`Layout`] gives the number of coordinates and of quadratures (ż = g(t, q, v), integrated but never fed back): constants
//! of its type, or numbers at run time. Within a step there is no allocation and no dynamic dispatch.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests compare results with other libraries"))]
// Kernels index several arrays of the same size in parallel; iterators would obscure that.
#![allow(clippy::needless_range_loop)]

mod clock;
mod control;
mod dop853;
mod driver;
mod error_weight;
mod event_location;
mod gap_search;
mod inside_step;
mod interior;
mod layout;
mod linear;
mod method;
mod radau5;
mod rodas5p;
mod stall;
mod state;
mod step_attempts;
mod switched;
mod system;

use phalanx_mechanics::numeric;

pub use clock::Clock;
pub use control::Tolerances;
pub use dop853::Dop853;
pub use driver::{End, Failure, Integration, Options, Reason, integrate, integrate_by};
pub use layout::{Dynamic, DynamicMatrix, Entry, Fixed, FixedMatrix, Layout, Matrix, Vector, VectorOf};
pub use method::{Attempt, Method, Refinement, StepStart};
pub use radau5::{Radau5, radau5_tableau};
pub use rodas5p::Rodas5p;
pub use state::{CoordinateBounds, Counters, Dense, Observer, State, Step, StepTools};
pub use switched::SwitchedMethod;
pub use system::{
    ErrorWeight, EventFunction, EventSet, GapBound, GapBounds, Hybrid, Linearised, QuasiStaticState, Rates, RootSearch,
    System, WeightedQuantity,
};
