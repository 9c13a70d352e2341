//! Contacts of the analytic model, of whatever bodies: forces on a pair of surfaces with their derivatives, branches of the
//! laws with their events, and the first step of an impact.

mod forces;
mod impact;
mod mode;
mod reading;

pub(crate) use forces::{
    ContactForces, ContactKinematics, WithDerivatives, contact_forces, contact_forces_with_derivatives,
    normal_force_on_branch,
};
pub(crate) use impact::first_impact_step;
pub(crate) use mode::{ContactLaws, ContactVariables, EventTolerances, Row, StateRef, row_dot};
pub use mode::{ContactMode, ContactState, Mode};
pub use reading::{ContactReading, Energies, Geometry};
