//! Contacts of the analytic model, of whatever bodies: forces on a pair of surfaces with their derivatives, branches of the
//! laws with their events, the first step of an impact, and contacts that chatter.

mod chatter;
mod forces;
mod impact;
mod mode;
mod reading;

pub(in crate::analytic) use chatter::{DIFFERENCE_STEP_S, Settling, max_chatter_rate, may_chatter, settling};
pub(crate) use forces::{
    ContactForces, ContactKinematics, WithDerivatives, contact_forces, contact_forces_with_derivatives,
    normal_force_on_branch,
};
pub(crate) use impact::first_impact_step;
pub(crate) use mode::{ContactLaws, ContactVariables, EventTolerances, Row, StateRef, row_dot};
pub use mode::{ContactMode, ContactState, Mode};
pub use reading::{ContactReading, Energies, Geometry};
