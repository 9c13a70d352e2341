//! phalanx: a planar simulator of high-speed underactuated grippers.
//!
//! Modules depend on each other in one direction only:
//! `units ← gripper, law ← scene ← analytic ← trace ← log, criteria ← report ← cli`; `numeric` and `integrator` know nothing
//! of grippers.

pub mod analytic;
pub mod cli;
pub mod criteria;
pub mod docs;
pub mod gripper;
pub mod integrator;
pub mod law;
pub mod log;
pub mod numeric;
pub mod report;
pub mod scene;
pub mod trace;
pub mod units;
