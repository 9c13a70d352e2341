//! Dynamic criteria of a closing: how soon the finger is at rest on the object, and whether it rebounds (thesis §4.1.1).
//!
//! * **In position**: |q11 − q11,f| ≤ ε and |q21 − q21,f| ≤ ε, with ε = 0.2° and (q11,f, q21,f) the geometric final
//!   configuration (both phalanges touch the object).
//! * **t_geo**: the first time the finger is in position.
//! * **tts**, time to stability: start of the last interval, lasting to the end of the run, in which the finger is in
//!   position and both normal forces are positive. None: the finger is not stable.
//! * **rebound** = 100 |(t_geo + T)/(tts + T) − 1| percent (4.1), T the length of the run; see [`rebound_percent`] for
//!   when it counts as 0.
//! * **class**: [`Class::of`], which takes in whether the grasp is statically stable ([`at_rest`]); [`ClassReason`] says what decides it.
//!
//! [`Rebounds`] finds restitution in a scene of discs.
//!
//! [`Tracker`] finds these figures while a run streams by, keeping nothing but the last sample.
//!
//! A gripper has other criteria: [`GraspCriteria`], which [`GraspTracker`] finds. Whether its grasp is form-closed is a question to
//! [`gripper_closure`](crate::statics::gripper_closure) about its [`stance`] in the last sample.

mod at_rest;
mod balance;
mod formula;
mod grasp;
mod grasp_tracker;
mod hermite;
mod history;
mod judge;
mod overlap;
mod pieces;
mod pressing;
mod reason;
mod rebounds;
mod stance;
mod tracker;

pub use at_rest::{AtRest, at_rest, grasp_at_rest};
pub use balance::{Driven, Pressed, hand_at_rest, held_at_rest, pressed};
pub use formula::{Class, EPSILON_RAD, RESOLUTION_S, rebound_percent};
pub use grasp::{ContactCriteria, CycleCriteria, Fate, GraspCriteria, Travel, fate_reason};
pub use grasp_tracker::GraspTracker;
pub use judge::{Judge, Judged};
pub use overlap::{Link, LinkOverlap, LinkOverlaps, Obstacle};
pub use reason::{AtEnd, ClassReason, Condition, Loss};
pub use rebounds::{Rebound, Rebounds};
pub use stance::{force_closure_of, friction, is_form_closed, normal_forces, stance};
pub use tracker::{FinalAngles, Tracker};

use serde::Serialize;

/// The dynamic criteria of one run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Criteria {
    /// Time to stability; `None` if the run does not end in a stable state.
    pub tts_s: Option<f64>,
    /// (4.1); `None` if the finger is not stable.
    pub rebound_percent: Option<f64>,
    pub class: Class,
    /// What decides the class; in documents its sentence.
    pub class_reason: ClassReason,
    /// First time in position; `None` if the finger never gets there.
    pub t_geo_s: Option<f64>,
    /// Time after t_geo that went to rebounds: out of position, or with a phalanx off the object it had touched.
    pub lost_s: f64,
    /// Force positiveness of the grasp at rest: without it the class is unstable, whatever the run shows.
    pub statically_stable: bool,
}

impl Criteria {
    /// The class and what decides it, in a sentence.
    pub fn verdict(&self) -> String {
        format!("{}: {}", self.class.name(), self.class_reason)
    }
}
