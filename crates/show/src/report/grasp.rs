//! What became of the object of a gripper, under the keys of the JSON document and in words.

use serde::Serialize;

use super::named::Named;
use crate::criteria::{
    ContactCriteria, CycleCriteria, Fate, GraspCriteria, Travel, fate_reason, force_closure_of, is_form_closed,
};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::statics::ForceClosure;
use crate::trace::Sample;

/// The grasp of a gripper, see [`crate::criteria::GraspCriteria`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraspReport {
    /// `held`, `dropped`, `ejected` or `not grasped`.
    pub fate: &'static str,
    /// What decided the fate; null without the scene.
    pub fate_reason: Option<String>,
    /// When it was first pressed from both sides or force-closed; null if it was never held for long enough.
    pub grasped_s: Option<f64>,
    /// Since when it is held at the end.
    pub held_since_s: Option<f64>,
    /// Since when all contacts that are active at the end are active; null if the object is not held then.
    pub tts_s: Option<f64>,
    /// Since when it is no longer held, or when it left the gripper.
    pub until_s: Option<f64>,
    /// Whether the contacts that press at the end, with what is blocked of the drives, hold it fast; null where it is not held, or where
    /// that cannot be decided.
    pub form_closed: Option<bool>,
    /// How the contacts in the hand that press at the end hold it with friction; null where it is not held, and without its scene.
    pub force_closure: Option<ForceClosureReport>,
    /// Of the object, along the palm from its middle, at the start and at the end; and |end| / |start|, null for one that started
    /// centred.
    pub x_start_m: f64,
    pub x_end_m: f64,
    pub offset_ratio: Option<f64>,
    /// Of its centre at the end.
    pub speed_m_s: f64,
    /// Largest of the object since the start, and in the hand since `tts_s`.
    pub travel: Travel,
    pub slip: Option<Travel>,
    /// Of a gripper that carries or lets go.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<CycleReport>,
    /// By their names.
    pub contacts: Named<ContactCriteria>,
}

/// What became of a cycle, see [`CycleCriteria`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CycleReport {
    /// When the palm begins to move, and when nothing closes the fingers any more.
    pub carries_s: Option<f64>,
    pub releases_s: Option<f64>,
    /// Slip in the hand between.
    pub carried: Option<Travel>,
    /// Since when no phalanx presses after that; and how long that took, the opening time.
    pub opened_s: Option<f64>,
    pub opening_s: Option<f64>,
    /// Largest turn of the driven links under their brakes, right and left.
    pub brake_slip_rad: [Option<f64>; 2],
}

impl CycleReport {
    /// `None` of a gripper that neither carries nor lets go nor is blocked.
    fn new(found: &CycleCriteria) -> Option<Self> {
        let CycleCriteria { carries_s, releases_s, carried, opened_s, brake_slip_rad } = *found;
        let is_one = carries_s.is_some() || releases_s.is_some() || brake_slip_rad.iter().any(Option::is_some);
        let opening_s = opened_s.zip(releases_s).map(|(opened, released)| opened - released);
        is_one.then_some(CycleReport { carries_s, releases_s, carried, opened_s, opening_s, brake_slip_rad })
    }
}

/// See [`ForceClosure`]: wrenches are a force and a moment over the object's radius, for normal forces that add up to 1, or of at most 1
/// each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceClosureReport {
    pub closed: bool,
    pub q1_l1: f64,
    pub q1_linf: f64,
    /// The direction in which least can be balanced.
    pub weakest: [f64; 3],
}

impl From<ForceClosure> for ForceClosureReport {
    fn from(found: ForceClosure) -> Self {
        let ForceClosure { closed, q1_l1, q1_linf, weakest } = found;
        ForceClosureReport { closed, q1_l1, q1_linf, weakest }
    }
}

impl GraspReport {
    /// Of a run that ended with this sample; without its scene nothing is said of form closure.
    pub fn new(found: &GraspCriteria, scene: Option<&Scene>, last: &Sample) -> Self {
        let gripper = scene.filter(|scene| scene.kind() == SceneKind::Gripper);
        // Fingers that have let go hold nothing.
        let holding = gripper.filter(|_| found.fate == Fate::Held && found.cycle.releases_s.is_none());
        let contacts = found.contacts.iter().map(|contact| (contact.place.name(), *contact));
        GraspReport {
            fate: found.fate.name(),
            fate_reason: gripper.map(|scene| fate_reason(found, scene.thresholds.held_time_s)),
            grasped_s: found.grasped_s,
            held_since_s: found.held_since_s,
            tts_s: found.tts_s,
            until_s: found.fate.until_s(),
            form_closed: holding.and_then(|scene| is_form_closed(scene, last)),
            force_closure: gripper
                .filter(|_| found.fate == Fate::Held && found.cycle.releases_s.is_none())
                .map(|scene| force_closure_of(scene, last).into()),
            x_start_m: found.start.centre_m[0],
            x_end_m: found.end.centre_m[0],
            offset_ratio: found.offset_ratio(),
            speed_m_s: found.end_speed_m_s(),
            travel: found.travel,
            slip: found.slip,
            cycle: CycleReport::new(&found.cycle),
            contacts: contacts.collect(),
        }
    }

    /// When the object left the gripper, if it did.
    pub(super) fn ejected_s(&self) -> Option<f64> {
        self.until_s.filter(|_| self.fate == Fate::NAMES[2])
    }
}
