//! The five-bar in closed form: kinematics, dynamics and springs of the finger without contact (thesis §2.1).
//!
//! The analytic model integrates it; sizing and statics evaluate it along a path and at rest. The engine model never names it.
//!
//! | file | job |
//! |---|---|
//! | `kinematics` | loop closure, first and second order, singularities |
//! | `dynamics` | mass matrix, centrifugal, Coriolis and gravity terms; inverse dynamics |
//! | `carried` | what its links feel in a frame that moves |
//! | `capsule` | a phalanx against a disc: nearest point, normal and gap |
//! | `wide` | derivatives among those of more coordinates |
//! | `spring` | where a spring acts, its extension, torque and energy |

pub mod capsule;
pub mod carried;
pub mod dynamics;
pub mod kinematics;
pub mod spring;
mod wide;
