//! Criteria of a run of a gripper.

use serde::Serialize;

use crate::numeric::elementary::hypot;
use crate::scene::GripperContact;
use crate::trace::BodyState;

/// The criteria of one run of a gripper (6-gripper §6.8). Poses are in the palm frame.
///
/// A contact is *active* while its normal force exceeds the force threshold of the scene. Losses shorter than the time
/// threshold are ignored ([`Thresholds`](crate::scene::Thresholds)).
///
/// The object *has contacts on both sides* while two phalanges have active contacts whose normals have x components
/// (along the palm) of opposite sign. Palm and table do not count. A single finger bent around the object can have
/// contacts on both sides. The object is *force-closed* if the active contacts of phalanges and palm balance any force
/// and moment by normal forces and friction. It is *held* while either condition is met.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspCriteria {
    /// Criteria of all contacts except joint limits (four phalanges, palm, table), in the order of
    /// [`GripperContact::ALL`].
    pub contacts: Vec<ContactCriteria>,
    /// Time to stability of the whole grasp: start of the interval up to the end of the run in which all contacts that
    /// are active at the end are active, including palm and table. It is the largest of their
    /// [`ContactCriteria::active_since_s`]. `None` if the object is not held at the end.
    pub tts_s: Option<f64>,
    /// Time at which the object was first held; `None` if it was never held for the required time.
    pub grasped_s: Option<f64>,
    /// Time since which the object is held at the end, even if shorter than required; `None` if the object is not held.
    pub held_since_s: Option<f64>,
    pub fate: Fate,
    /// State of the object at the start of the run.
    pub start: BodyState,
    /// State of the object at the end of the run.
    pub end: BodyState,
    /// Travel of the object since the start.
    pub travel: Travel,
    /// Slip in the hand: travel of the object since [`GraspCriteria::tts_s`].
    pub slip: Option<Travel>,
    /// Criteria of a cycle. For the criteria above, the end is the release, if there is one.
    pub cycle: CycleCriteria,
}

/// Criteria of a cycle: palm motion and release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleCriteria {
    /// Time at which the palm begins to move.
    pub motion_start_s: Option<f64>,
    /// Time at which the drives stop closing the fingers.
    pub release_s: Option<f64>,
    /// Travel of the object in the hand from `motion_start_s` to `release_s`, or to the end of the run.
    pub motion_travel: Option<Travel>,
    /// Time after the release since which no phalanx is in active contact; `None` if one still is at the end, or if
    /// there is no release.
    pub opened_s: Option<f64>,
    /// Largest rotation of the driven links, right and left, from the engagement of their brakes to the release, rad.
    pub brake_slip_rad: [Option<f64>; 2],
}

/// Returns the reason for a fate, as a sentence without a full stop.
pub fn fate_reason(criteria: &GraspCriteria, held_time_s: f64) -> String {
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    match (criteria.fate, criteria.held_since_s) {
        (Fate::Held, since_s) => format!("held from {} on", ms(since_s.unwrap_or_default())),
        (Fate::Dropped { since_s }, None) => format!("no longer held from {} on", ms(since_s)),
        (Fate::Dropped { since_s }, Some(again_s)) => {
            let (lost, again, required) = (ms(since_s), ms(again_s), ms(held_time_s));
            format!("no longer held from {lost} on; held again only from {again} on, less than {required}")
        }
        (Fate::Ejected { at_s }, _) => format!("out of the reach of both fingers at {}", ms(at_s)),
        (Fate::NotGrasped, None) => format!("never held for {}", ms(held_time_s)),
        (Fate::NotGrasped, Some(since_s)) => {
            format!("held only from {} on, less than {}", ms(since_s), ms(held_time_s))
        }
    }
}

/// Largest offset from the middle at which an object counts as centred, m: far below any positioning accuracy.
const CENTRED_TOLERANCE_M: f64 = 1e-9;

impl GraspCriteria {
    /// Returns |x| at the end over |x| at the start: below 1 the grasp centres its object. `None` if the object starts
    /// within 1e-9 m of the middle.
    pub fn offset_ratio(&self) -> Option<f64> {
        let [start, end] = [self.start, self.end].map(|body| body.centre_m[0].abs());
        (start > CENTRED_TOLERANCE_M).then(|| end / start)
    }

    /// Returns the speed of the object's centre at the end, m/s.
    pub fn end_speed_m_s(&self) -> f64 {
        let [x, y] = self.end.velocity_m_s;
        hypot(x, y)
    }
}

/// Criteria of one contact over a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactCriteria {
    #[serde(skip)]
    pub id: GripperContact,
    /// Time of the first contact; `None` if there was none.
    #[serde(rename = "first_touch_s")]
    pub first_contact_s: Option<f64>,
    /// Start of the last interval up to the end of the run in which it is active; `None` if it is not active at the
    /// end.
    #[serde(rename = "presses_since_s")]
    pub active_since_s: Option<f64>,
    /// Number of losses after the contact was first active.
    pub times_lost: u32,
    /// Total duration of all losses up to the end of the run, s.
    pub lost_s: f64,
}

/// Fate of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// The object is held at the end, or at the release, and has been held for at least the required time of the scene.
    Held,
    /// The object was held for the required time and is no longer held since `since_s`. An object that is lost, caught
    /// again and held at the end is not dropped. The travel does not matter.
    Dropped { since_s: f64 },
    /// At `at_s` the object left the region that the fingers can reach ([`Reach`](crate::trace::Reach)), after a
    /// contact. The run ends there.
    Ejected { at_s: f64 },
    /// The object was never held for the required time.
    NotGrasped,
}

impl Fate {
    /// Names of all fates, from best to worst.
    pub const NAMES: [&str; 4] = ["held", "dropped", "ejected", "not grasped"];

    /// Returns the name in results and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[match self {
            Fate::Held => 0,
            Fate::Dropped { .. } => 1,
            Fate::Ejected { .. } => 2,
            Fate::NotGrasped => 3,
        }]
    }

    /// Returns the time since which the object is no longer held, or at which it left the gripper; `None` for the other
    /// fates.
    pub fn lost_at_s(self) -> Option<f64> {
        match self {
            Fate::Dropped { since_s } => Some(since_s),
            Fate::Ejected { at_s } => Some(at_s),
            Fate::Held | Fate::NotGrasped => None,
        }
    }
}

/// Largest travel of the object from a pose, evaluated at samples and contact changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Travel {
    /// Largest displacement of its centre, m.
    pub displacement_m: f64,
    /// Largest rotation in either direction, rad.
    pub rotation_rad: f64,
}
