//! The grasp at rest (thesis §1.2, §2.1.4, §3.4): contact forces, the force on the palm, form closure.
//!
//! Forces are evaluated at the final posture, where both phalanges touch the object; form closure in any. Nothing here moves.
//!
//! | file | job |
//! |---|---|
//! | `posture` | link directions and passive rates of a posture |
//! | `equilibrium` | loads, contact Jacobian and normal forces (2.31), (2.32); what ejects |
//! | `palm` | the force of the object on the palm (3.2) |
//! | `birglen` | the same forces in Birglen's frame: J (1.8), T (1.10), f (1.11) |
//! | `hand` | what holds the object: fingers, the phalanges that touch, and the palm |
//! | `stance` | the hand that a posture of a gripper makes |
//! | `unilateral` | what a motion of the grasp may not do, row by row: U (1.15)–(1.18) |
//! | `form_closure` | whether nothing is left that it may do, with a certificate either way |
//! | `gripper_closure` | the same of a whole gripper, with a differential or without |
//! | `force_closure` | which wrenches contacts with friction can balance, and how large ones |
//! | `loads` | what every force does on fingers and object at rest in the hand, column by column |
//! | `balance` | the largest acceleration of the palm that contact forces can balance, by direction, with what proves it |
//! | `balance_program` | its linear programme, and the dual |
//! | `balance_exact` | what that found to its tolerance, exactly |
//! | `linear` | ranks, null vectors and projections of U |
//! | `program` | the linear programmes |
//! | `error` | why there is no statics |

mod balance;
mod balance_exact;
mod balance_program;
mod birglen;
mod equilibrium;
mod error;
mod force_closure;
mod form_closure;
mod gripper_closure;
mod hand;
mod linear;
mod loads;
mod palm;
mod posture;
mod program;
mod stance;
mod unilateral;

pub use balance::{
    Balance, Balanced, BrakeHeld, HandMotion, Held, Limit, Yields, balance_polar, balanced_acceleration,
};
pub use birglen::{Birglen, birglen};
pub use equilibrium::{Ejection, Equilibrium, contact_jacobian, drive_loads, equilibrium, equilibrium_each};
pub use error::StaticsError;
pub use force_closure::{ForceClosure, Holding, force_closure};
pub use form_closure::{BOUNDARY, Certificate, Decision, FormClosure, decide, decide_by_program, form_closure};
pub use gripper_closure::{Blocked, GripperRow, gripper_closure, gripper_unilateral};
pub use hand::{Grip, Hand, Side, Touch};
pub use loads::{Drive, HandAtRest, Spot};
pub use palm::{palm_force, palm_force_each};
pub use posture::{AtRest, at_rest};
pub use stance::{MetAt, PerContact, Stance};
pub use unilateral::{Kind, NecessaryCount, Row, Unilateral, Unknown, unilateral};
