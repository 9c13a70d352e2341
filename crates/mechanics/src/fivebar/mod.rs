//! The five-bar in closed form: kinematics, dynamics and springs of the finger without contact (thesis §2.1).
//!
//! The analytic model integrates it; sizing and statics evaluate it along a path and at rest. The engine model does not
//! use it.
//!
//! | file | job |
//! |---|---|
//! | `kinematics` | loop closure, first and second order, singularities |
//! | `dynamics` | mass matrix, centrifugal, Coriolis and gravity terms; inverse dynamics |
//! | `inertial_forces` | inertial forces on the links in a moving frame |
//! | `capsule` | closest points, normal and gap of a phalanx and a shape |
//! | `widen` | extension of derivatives to more coordinates |
//! | `spring` | placement of a spring, its extension, torque and energy |

pub mod capsule;
pub mod dynamics;
pub mod inertial_forces;
pub mod kinematics;
pub mod spring;
mod widen;
