//! The five-bar in closed form: kinematics, dynamics and springs of the finger without contact (thesis §2.1).
//!
//! The analytic model integrates it; sizing and statics evaluate it along a path and at rest. The engine model does not
//! use it.

pub mod dynamics;
pub mod joint_forces;
pub mod kinematics;
