//! The grasp at rest (thesis §1.2, §2.1.4, §3.4): contact forces, the force on the palm, form closure.
//!
//! Everything is evaluated at the final posture, where both phalanges touch the object, and nothing here moves.
//!
//! | file | job |
//! |---|---|
//! | `posture` | link directions and passive rates at the final posture |
//! | `equilibrium` | loads, contact Jacobian and normal forces (2.31), (2.32); what ejects |
//! | `palm` | the force of the object on the palm (3.2) |
//! | `birglen` | the same forces in Birglen's frame: J (1.8), T (1.10), f (1.11) |
//! | `unilateral` | what a motion of the grasp may not do, row by row: U (1.15)–(1.18) |
//! | `form_closure` | whether nothing is left that it may do, with a certificate either way |
//! | `linear` | ranks, null vectors and projections of U |
//! | `program` | the linear programmes |
//! | `error` | why there is no statics |

mod birglen;
mod equilibrium;
mod error;
mod form_closure;
mod linear;
mod palm;
mod posture;
mod program;
mod unilateral;

pub use birglen::{Birglen, birglen};
pub use equilibrium::{Ejection, Equilibrium, contact_jacobian, drive_loads, equilibrium, equilibrium_each};
pub use error::StaticsError;
pub use form_closure::{BOUNDARY, Certificate, Decision, FormClosure, decide, decide_by_program, form_closure};
pub use palm::{palm_force, palm_force_each};
pub use posture::{AtRest, at_rest};
pub use unilateral::{Grip, Hand, NecessaryCount, Row, Side, Unilateral, Unknown, unilateral};
