//! What a run of a gripper came to, as figures.

use serde::Serialize;

use crate::numeric::elementary::hypot;
use crate::scene::Place;
use crate::trace::BodyState;

/// The criteria of one run of a gripper (6-gripper §6.8). Poses are in the palm's frame.
///
/// "At least two contacts on opposite sides" are two phalanges that press with normals whose components along the palm (x) have opposite
/// signs: the fingers come from there, and nothing else keeps the object from leaving that way. Palm and table push neither way: an
/// object that lies on the palm under the table, or is pushed along them by one finger, is not grasped. A single finger that has bent
/// around the object holds it from both sides too. No force is compared with a threshold: a contact presses, or does not.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspCriteria {
    /// Of every contact that is no joint limit (four phalanges, palm, table), in the order of [`Place::ALL`].
    pub contacts: Vec<ContactCriteria>,
    /// Time to stability of the whole grasp: start of the last interval up to the end of the run in which every contact that presses at
    /// the end does, palm and table included: it is the last of their [`ContactCriteria::presses_since_s`]. `None` where the object is
    /// not held from both sides at the end.
    pub tts_s: Option<f64>,
    /// When the object was first held from both sides; `None` if it never was.
    pub grasped_s: Option<f64>,
    pub fate: Fate,
    /// The object at the start and at the end of the run.
    pub start: BodyState,
    pub end: BodyState,
    /// Of the object since the start.
    pub travel: Travel,
    /// Slip in the hand: of the object since [`GraspCriteria::tts_s`].
    pub slip: Option<Travel>,
    /// What a cycle adds: of all else above, its end is when the fingers let go.
    pub cycle: CycleCriteria,
}

/// What became of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleCriteria {
    /// When the palm begins to move, and when nothing closes the fingers any more.
    pub carries_s: Option<f64>,
    pub releases_s: Option<f64>,
    /// How far the object got in the hand from the one to the other, or to the end of the run.
    pub carried: Option<Travel>,
    /// Since when no phalanx presses once the fingers let go; `None` while one does, and where they do not.
    pub opened_s: Option<f64>,
    /// How far the driven links, right and left, turned at most once their brakes had gripped, rad, until they let go.
    pub brake_slip_rad: [Option<f64>; 2],
}

/// Nearer to the middle than this, m, an object starts centred: far below anything that can be positioned.
const CENTRED_M: f64 = 1e-9;

impl GraspCriteria {
    /// |x| at the end over |x| at the start: below 1 the grasp centres its object. `None` where it was centred from the start, within
    /// 1e-9 m.
    pub fn offset_ratio(&self) -> Option<f64> {
        let [start, end] = [self.start, self.end].map(|body| body.centre_m[0].abs());
        (start > CENTRED_M).then(|| end / start)
    }

    /// Speed of the object's centre at the end, m/s: whether it is at rest.
    pub fn end_speed_m_s(&self) -> f64 {
        let [x, y] = self.end.velocity_m_s;
        hypot(x, y)
    }
}

/// One contact through a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactCriteria {
    #[serde(skip)]
    pub place: Place,
    /// When the surfaces first met; `None` if they never did.
    pub first_touch_s: Option<f64>,
    /// Start of the last interval up to the end of the run in which it presses; `None` if it does not press at the end.
    pub presses_since_s: Option<f64>,
    /// How often its normal force went to zero once it had pressed…
    pub times_lost: u32,
    /// …and how long it was without one, all times together and up to the end of the run.
    pub lost_s: f64,
}

/// What became of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// At the end, or when the fingers let go, it is held from both sides, and its centre is within its radius of where it was at
    /// [`GraspCriteria::grasped_s`].
    Held,
    /// It was held once, and is no longer: since this time one of the two has been missing. What is let go and caught again in between
    /// has not been dropped.
    Dropped { since_s: f64 },
    /// At this time its centre was further than three radii from the palm's middle, whatever came later.
    Ejected { at_s: f64 },
    /// It never was held from both sides.
    NotGrasped,
}

impl Fate {
    /// Names of all fates, from good to bad.
    pub const NAMES: [&str; 4] = ["held", "dropped", "ejected", "not grasped"];

    /// In results and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[match self {
            Fate::Held => 0,
            Fate::Dropped { .. } => 1,
            Fate::Ejected { .. } => 2,
            Fate::NotGrasped => 3,
        }]
    }

    /// Since when the object is no longer held, or when it left the gripper; `None` for the other fates.
    pub fn until_s(self) -> Option<f64> {
        match self {
            Fate::Dropped { since_s } => Some(since_s),
            Fate::Ejected { at_s } => Some(at_s),
            Fate::Held | Fate::NotGrasped => None,
        }
    }
}

/// How far the object got from a pose, at most: at the samples and changes of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Travel {
    /// Of its centre, m.
    pub displacement_m: f64,
    /// Of its angle, either way, rad.
    pub rotation_rad: f64,
}
