//! Stiff integration of small hybrid second-order systems q̇ = v, v̇ = a(t, q, v).
//!
//! Sizes are constants, nothing is allocated and nothing dispatched dynamically within a step. `N` is the number of
//! coordinates, `Z` that of quadratures (ż = g(t, q, v), carried along but never fed back), `S` that of sites whose
//! branch may change.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests hold what is computed to other libraries"))]
// Kernels index several arrays of one constant size side by side; iterators would hide that.
#![allow(clippy::needless_range_loop)]

mod chatter;
mod chosen;
mod clock;
mod control;
mod counters;
mod dense;
mod driver;
mod landing;
mod linear;
mod method;
mod observer;
mod pace;
mod radau5;
mod rodas5p;
mod state;
mod strain;
mod system;
mod tableau;

use phalanx_mechanics::numeric;

pub use chosen::RadauOrRodas;
pub use clock::Clock;
pub use control::Tolerances;
pub use counters::Counters;
pub use dense::Dense;
pub use driver::{End, Failure, Options, Reason, integrate, integrate_by};
pub use method::{Attempt, Method, Origin};
pub use observer::{Observer, Step, StepTools};
pub use radau5::Radau5;
pub use rodas5p::Rodas5p;
pub use state::State;
pub use system::{Guard, Hybrid, Linearised, Look, Rates, Settled, Strain, System, Watch};
