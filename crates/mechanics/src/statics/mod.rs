//! The grasp at rest (thesis §1.2, §2.1.4, §3.4): contact forces, the force on the palm, form closure.
//!
//! Forces are evaluated at the final posture, where both phalanges are in contact with the object; form closure in any
//! posture.

mod balance;
mod balance_program;
mod birglen;
mod equilibrium;
mod error;
mod force_closure;
mod form_closure;
mod hand;
mod linear;
mod loads;
mod posture;
mod unilateral;

pub use balance::{
    AccelerationLimit, Balance, BrakeLoad, ContactLoad, ContactMotion, HandMotion, Limit, balance_polar,
    balanced_acceleration,
};
pub use birglen::{Birglen, birglen};
pub use equilibrium::{
    Ejection, Equilibrium, contact_jacobian, drive_loads, equilibrium, equilibrium_with_mu, palm_force,
    palm_force_with_mu,
};
pub use error::StaticsError;
pub use force_closure::{ForceClosure, FrictionContact, force_closure};
pub use form_closure::{
    BOUNDARY, Certificate, Decision, FormClosure, decide_by_linear_program, decide_form_closure, form_closure,
    gripper_closure,
};
pub use hand::{ContactPoint, FingerGrip, GraspConfiguration, Hand, PerContact, PhalanxContact, Side};
pub use loads::{ContactLocation, Drive, HandAtRest};
pub use posture::{StaticKinematics, static_kinematics};
pub use unilateral::{Blocked, NecessaryCount, Row, RowKind, Unilateral, Unknown, gripper_unilateral, unilateral};
