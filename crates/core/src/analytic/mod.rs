//! The analytic model: closed-form Lagrange equations of the finger (thesis §2.1) under the contact laws, and in
//! [`multibody`] the equations of two fingers with their object. [`mechanism`] has any planar mechanism.
//!
//! One finger that closes on a fixed object has its own kernel, [`FingerMotion`], which studies run by the thousand.
//!
//! The model is independent of the engine model, which it checks: both share lengths, masses and scalar laws, nothing
//! else.

mod finger;
mod finger_events;
mod inertial_field;
pub mod mechanism;
mod mode;
mod model;
mod motion_bound;
pub mod multibody;

pub use finger::{DistalShape, Geometry, PassiveJoints, distal, proximal};
pub use mode::{ContactState, Mode};
pub use model::{
    BristleModel, ContactReading, EVENT_FUNCTIONS, Energies, FingerMode, FingerMotion, Model, QUADRATURES,
};
