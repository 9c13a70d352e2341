//! The analytic model: closed-form Lagrange equations of the finger (thesis §2.1) under the contact laws, in [`discs`]
//! Newton's equations of discs, and in [`gripper`] two fingers with what they grasp.
//!
//! Independent of the engine model, which it checks: both share lengths, masses and scalar laws, nothing else.

pub mod contact;
pub mod discs;
mod finger;
pub mod gripper;
mod mode;
mod model;
mod modes;

pub use finger::Passive;
pub use mode::SiteState;
pub use model::{Energies, FingerMotion, GUARDS, HoldingModel, Mode, Model, QUADRATURES, SiteReading, Snapshot};
