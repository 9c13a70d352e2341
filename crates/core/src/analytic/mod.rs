//! The analytic model: Lagrange equations under the contact laws. [`mechanism`] has those of any planar mechanism; the
//! closed form of one finger (thesis §2.1) checks them.
//!
//! The model is independent of the engine model, which it checks: both share lengths, masses and scalar laws, nothing
//! else.

mod closed_form;
mod contact;
pub mod mechanism;
mod motion_bound;

pub use closed_form::{
    DistalShape, EVENT_FUNCTIONS, FingerMode, FingerMotion, Model, PassiveJoints, QUADRATURES, StictionModel, distal,
    proximal,
};
pub use contact::{ContactMode, ContactReading, ContactState, Energies, Geometry, Mode};
