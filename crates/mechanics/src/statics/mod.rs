//! The grasp at rest (thesis §1.2, §2.1.4, §3.4): contact forces, the force on the palm, form closure.
//!
//! Forces are evaluated at the final posture, where both phalanges are in contact with the object; form closure in any
//! posture.
//!
//! All functions fail with a [`StaticsError`] if a loop does not close in the posture, for a singular posture (see
//! [`static_kinematics`]) and for numbers out of range; closures also if the grasp is so close to the boundary that no
//! certificate exists, and balances if the forces and the motion of the linear programme give different limits.

mod balance;
mod balance_program;
mod equilibrium;
mod force_closure;
mod form_closure;
mod hand;
mod hull;
mod mechanism;
mod roles;
mod simplex;

pub use balance::{BrakeLoad, ContactMotion};
pub use equilibrium::{
    Birglen, Ejection, Equilibrium, StaticKinematics, StaticsError, birglen, contact_jacobian, drive_loads,
    equilibrium, equilibrium_with_mu, palm_force, palm_force_with_mu, static_kinematics,
};
pub use force_closure::{ForceClosure, FrictionContact, Wrench, force_closure};
pub use form_closure::{
    BOUNDARY, Certificate, Decision, FormClosure, decide_by_linear_program, decide_form_closure, form_closure,
    gripper_closure,
};
pub use hand::{
    Blocked, ContactPoint, FingerGrip, GraspConfiguration, Hand, NecessaryCount, PerContact, PhalanxContact, Row,
    RowKind, Side, Unilateral, Unknown, gripper_unilateral, unilateral,
};
pub use hull::{GRIP_TOLERANCE, WrenchHull, hull_distance};
pub use mechanism::{
    BalanceAtRest, BodyMotion, ContactAtRest, DriveState, LoadsAtRest, MAX_REMAINDER, MechanismAtRest,
    MechanismBalance, MechanismClosure, MechanismLimit, balance_at_rest, balance_at_rest_towards, efforts,
    mechanism_balance, mechanism_balance_towards, mechanism_closure,
};
pub use roles::{
    GraspKeys, GraspPair, GraspRoles, NoGrasp, Roles, carriers, carries, default_base, default_object, grasp_roles,
    move_ground, radius_m, roles,
};

/// Result of the functions of this module.
pub type Result<T> = std::result::Result<T, StaticsError>;
