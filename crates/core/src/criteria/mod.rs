//! Dynamic criteria of a closing motion: time to stability and rebound (thesis §4.1.1).
//!
//! * **In position**: |q11 − q11,f| ≤ ε and |q21 − q21,f| ≤ ε, with ε = 0.2° and (q11,f, q21,f) the geometric final
//!   configuration, in which both phalanges touch the object.
//! * **t_geo**: the first time the finger is in position.
//! * **tts**, time to stability: start of the interval up to the end of the run in which the finger is in position and
//!   both normal forces are positive. None: the finger is not stable.
//! * **rebound** = 100 |(t_geo + T)/(tts + T) − 1| percent (4.1), with T the duration of the run; see
//!   [`rebound_percent`] for when it counts as 0.
//! * **class**: [`Class::classify`], which also depends on static stability ([`static_grasp`]); [`ClassReason`] gives
//!   the deciding figure.
//!
//! [`Tracker`] computes these criteria during a run and stores only the last sample.
//!
//! [`Rebounds`] computes restitution in a scene of discs.
//!
//! The criteria of a gripper are [`GraspCriteria`], computed by [`GraspTracker`]. [`is_form_closed`] decides form
//! closure in a sample by [`gripper_closure`](crate::statics::gripper_closure).

mod class;
mod configuration;
mod grasp;
mod grasp_tracker;
mod hermite;
mod link_overlap;
mod rebounds;
mod run_criteria;
mod segments;
mod tracker;

pub use class::{Class, ClassReason, Condition, EPSILON_RAD, FinalContact, Loss, RESOLUTION_S, rebound_percent};
pub use configuration::{
    DriveMode, FinalAngles, GraspState, StaticGrasp, grasp_configuration, is_form_closed, normal_forces,
    sample_force_closure, sampled_hand_at_rest, scene_static_grasp, static_grasp,
};
pub(crate) use configuration::{friction_coefficients, grasp_state, hand_at_rest};
pub use grasp::{ContactCriteria, CycleCriteria, Fate, GraspCriteria, Travel, fate_reason};
pub use grasp_tracker::GraspTracker;
pub use link_overlap::{Link, LinkOverlap, LinkOverlaps, Obstacle};
pub use rebounds::{Rebound, Rebounds};
pub use run_criteria::{RunCriteria, RunCriteriaTracker};
pub use tracker::Tracker;

use serde::Serialize;

/// The dynamic criteria of one run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Time to stability; `None` if the run does not end in a stable state.
    pub tts_s: Option<f64>,
    /// Rebound (4.1), percent; `None` if the finger is not stable.
    pub rebound_percent: Option<f64>,
    pub class: Class,
    /// Reason for the class; serialised as a sentence.
    pub class_reason: ClassReason,
    /// First time in position; `None` if the finger is never in position.
    pub t_geo_s: Option<f64>,
    /// Time lost to rebounds after t_geo: out of position, or with a phalanx lifted off the object, s.
    pub lost_s: f64,
    /// Whether the static grasp is force-positive. Otherwise the class is unstable, regardless of the run.
    pub statically_stable: bool,
}

impl Criteria {
    /// Returns the class and its reason as a sentence.
    pub fn verdict(&self) -> String {
        format!("{}: {}", self.class.name(), self.class_reason)
    }
}
