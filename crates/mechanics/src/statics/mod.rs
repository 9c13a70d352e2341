//! The grasp at rest (thesis §1.2, §2.1.4, §3.4): contact forces, the force on the palm, form closure.
//!
//! Forces are evaluated at the final posture, where both phalanges are in contact with the object; form closure in any
//! posture.
//!
//! | file | job |
//! |---|---|
//! | `posture` | link directions and passive rates of a posture |
//! | `equilibrium` | loads, contact Jacobian and normal forces (2.31), (2.32); ejection |
//! | `palm` | the force of the object on the palm (3.2) |
//! | `birglen` | the same forces in Birglen's frame: J (1.8), T (1.10), f (1.11) |
//! | `hand` | the hand: fingers, their active contacts, and the palm |
//! | `grasp_configuration` | a gripper in one posture with its object, and the resulting hand |
//! | `unilateral` | unilateral constraints on a motion of the grasp, row by row: U (1.15)–(1.18) |
//! | `form_closure` | form closure, with a certificate of either result |
//! | `gripper_closure` | form closure of a whole gripper, with or without a differential |
//! | `force_closure` | wrenches that contacts with friction can balance |
//! | `loads` | generalised forces of every load on fingers and object, column by column |
//! | `balance` | largest acceleration of the palm that contact forces can balance, by direction, with a certificate |
//! | `balance_program` | its linear programme and the dual |
//! | `balance_exact` | exact solution from the approximate solution of the programme |
//! | `linear` | ranks, null vectors and projections of U |
//! | `program` | the linear programmes |
//! | `error` | errors of the static analysis |

mod balance;
mod balance_exact;
mod balance_program;
mod birglen;
mod equilibrium;
mod error;
mod force_closure;
mod form_closure;
mod grasp_configuration;
mod gripper_closure;
mod hand;
mod linear;
mod loads;
mod palm;
mod posture;
mod program;
mod unilateral;

pub use balance::{
    AccelerationLimit, Balance, BrakeLoad, ContactLoad, ContactMotion, HandMotion, Limit, balance_polar,
    balanced_acceleration,
};
pub use birglen::{Birglen, birglen};
pub use equilibrium::{Ejection, Equilibrium, contact_jacobian, drive_loads, equilibrium, equilibrium_with_mu};
pub use error::StaticsError;
pub use force_closure::{ForceClosure, FrictionContact, force_closure};
pub use form_closure::{
    BOUNDARY, Certificate, Decision, FormClosure, decide_by_linear_program, decide_form_closure, form_closure,
};
pub use grasp_configuration::{ContactPoint, GraspConfiguration, PerContact};
pub use gripper_closure::{Blocked, GripperRow, gripper_closure, gripper_unilateral};
pub use hand::{FingerGrip, Hand, PhalanxContact, Side};
pub use loads::{ContactLocation, Drive, HandAtRest};
pub use palm::{palm_force, palm_force_with_mu};
pub use posture::{StaticKinematics, static_kinematics};
pub use unilateral::{NecessaryCount, Row, RowKind, Unilateral, Unknown, unilateral};
