//! The analytic model: closed-form Lagrange equations of the finger (thesis §2.1) under the contact laws, and in [`multibody`] those of any
//! list of fingers and discs.
//!
//! One finger that closes on what does not move has a kernel of its own, [`FingerMotion`]: that is what studies run by the thousand.
//!
//! Independent of the engine model, which it checks: both share lengths, masses and scalar laws, nothing else.

pub mod contact;
mod finger;
mod mode;
mod model;
mod modes;
pub mod multibody;

pub use finger::Passive;
pub use mode::{Mode, SiteState};
pub use model::{Energies, FingerMode, FingerMotion, GUARDS, HoldingModel, Model, QUADRATURES, SiteReading, Snapshot};
