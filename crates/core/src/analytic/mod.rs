//! The analytic model: closed-form Lagrange equations of the finger (thesis §2.1) under the contact laws, and in [`discs`]
//! Newton's equations of discs.
//!
//! Independent of the engine model, which it checks: both share lengths, masses and scalar laws, nothing else.

pub mod contact;
pub mod discs;
mod mode;
mod model;
mod modes;

pub use mode::SiteState;
pub use model::{Energies, GUARDS, Mode, Model, Passive, QUADRATURES, SiteReading, Snapshot};
