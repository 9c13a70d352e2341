//! What a run of a gripper came to, as figures.

use serde::Serialize;

use crate::numeric::elementary::hypot;
use crate::scene::Place;
use crate::trace::BodyState;

/// The criteria of one run of a gripper (6-gripper §6.8). Poses are in the palm's frame.
///
/// A contact is *active* while its normal force exceeds the force threshold of the scene, and through losses shorter than its time threshold
/// ([`Thresholds`](crate::scene::Thresholds)).
///
/// The object *is pressed from both sides* while two active contacts are with phalanges and have normals whose components along the palm
/// (x) have opposite signs. Palm and table push neither way. A single finger that has bent around the object presses from both sides too.
/// It is *force-closed* if the active contacts with phalanges and palm balance any force and moment by normal forces and friction. It *is
/// held* while either is so.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspCriteria {
    /// Of every contact that is no joint limit (four phalanges, palm, table), in the order of [`Place::ALL`].
    pub contacts: Vec<ContactCriteria>,
    /// Time to stability of the whole grasp: start of the last interval up to the end of the run in which every contact is active that is
    /// active at the end, palm and table included. It is the last of their [`ContactCriteria::presses_since_s`]. `None` where the object is
    /// not held at the end.
    pub tts_s: Option<f64>,
    /// When the object was first pressed from both sides, or held by force closure; `None` if it was never held for long enough.
    pub grasped_s: Option<f64>,
    /// Since when it is held at the end, if it is, however short that is.
    pub held_since_s: Option<f64>,
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

/// Why a fate is what it is, as a sentence without its full stop.
pub fn fate_reason(found: &GraspCriteria, held_time_s: f64) -> String {
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    match (found.fate, found.held_since_s) {
        (Fate::Held, since_s) => format!("held from {} on", ms(since_s.unwrap_or_default())),
        (Fate::Dropped { since_s }, None) => format!("no longer held from {} on", ms(since_s)),
        (Fate::Dropped { since_s }, Some(again_s)) => {
            let (lost, again, least) = (ms(since_s), ms(again_s), ms(held_time_s));
            format!("no longer held from {lost} on; held again only from {again} on, less than {least}")
        }
        (Fate::Ejected { at_s }, _) => format!("out of the reach of both fingers at {}", ms(at_s)),
        (Fate::NotGrasped, None) => format!("never held for {}", ms(held_time_s)),
        (Fate::NotGrasped, Some(since_s)) => {
            format!("held only from {} on, less than {}", ms(since_s), ms(held_time_s))
        }
    }
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
    /// Start of the last interval up to the end of the run in which it is active; `None` if it is not active at the end.
    pub presses_since_s: Option<f64>,
    /// How often it was lost once it had pressed…
    pub times_lost: u32,
    /// …and for how long, all losses together and up to the end of the run.
    pub lost_s: f64,
}

/// What became of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It is held at the end, or when the fingers let go, and has been for at least the time that the scene states.
    Held,
    /// It was held for that time and is not any more, since this instant. An object that is released and caught again, and is held at the
    /// end, is not dropped. How far it moved does not matter.
    Dropped { since_s: f64 },
    /// At this time it left the region that the fingers can reach ([`Reach`](crate::trace::Reach)), after something had touched it. The
    /// run ends there.
    Ejected { at_s: f64 },
    /// It was never held for that time.
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
