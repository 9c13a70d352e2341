//! The fate of the object of a gripper in the JSON document.

use serde::Serialize;

use super::named::Named;
use crate::criteria::{
    ContactCriteria, CycleCriteria, Fate, GraspCriteria, Travel, fate_reason, is_form_closed, sample_force_closure,
};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::statics::ForceClosure;
use crate::trace::Sample;

/// The grasp of a gripper, see [`crate::criteria::GraspCriteria`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GraspReport {
    /// `held`, `dropped`, `ejected` or `not grasped`.
    pub fate: &'static str,
    /// Reason for the fate; null without the scene.
    pub fate_reason: Option<String>,
    /// Time at which the object was first in contact with both sides or force-closed; null if it was never held for
    /// long enough.
    pub grasped_s: Option<f64>,
    /// Time since which the object is held at the end.
    pub held_since_s: Option<f64>,
    /// Time since which all contacts that are active at the end have been active; null if the object is not held at the
    /// end.
    pub tts_s: Option<f64>,
    /// Time since which the object is no longer held, or at which it left the gripper.
    pub until_s: Option<f64>,
    /// Whether the contacts active at the end, with the blocked drives, form-close the object; null if the object is
    /// not held or if form closure cannot be decided.
    pub form_closed: Option<bool>,
    /// Force closure by the contacts in the hand active at the end; null if the object is not held, and without the
    /// scene.
    pub force_closure: Option<ForceClosureReport>,
    /// Position of the object along the palm from its middle, at the start.
    pub x_start_m: f64,
    /// Position of the object along the palm from its middle, at the end.
    pub x_end_m: f64,
    /// |end| / |start| of this position; null for an object that started centred.
    pub offset_ratio: Option<f64>,
    /// Speed of the object's centre at the end.
    pub speed_m_s: f64,
    /// Largest travel of the object since the start.
    pub travel: Travel,
    /// Largest slip in the hand since `tts_s`.
    pub slip: Option<Travel>,
    /// Criteria of a gripper that transports or releases its object.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<CycleReport>,
    /// Contacts by their names.
    pub contacts: Named<ContactCriteria>,
}

/// Criteria of a cycle, see [`CycleCriteria`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CycleReport {
    /// Time at which the palm begins to move.
    #[serde(rename = "carries_s")]
    pub motion_start_s: Option<f64>,
    /// Time at which the drives stop closing the fingers.
    #[serde(rename = "releases_s")]
    pub release_s: Option<f64>,
    /// Slip in the hand from `motion_start_s` to `release_s`.
    #[serde(rename = "carried")]
    pub motion_travel: Option<Travel>,
    /// Time after the release since which no phalanx is in contact.
    pub opened_s: Option<f64>,
    /// Time from `release_s` to `opened_s`.
    pub opening_s: Option<f64>,
    /// Largest rotation of the driven links against their brakes, right and left.
    pub brake_slip_rad: [Option<f64>; 2],
}

impl CycleReport {
    /// Returns `None` for a gripper that neither transports, releases nor brakes.
    fn new(found: &CycleCriteria) -> Option<Self> {
        let CycleCriteria { motion_start_s, release_s, motion_travel, opened_s, brake_slip_rad } = *found;
        let is_cycle = motion_start_s.is_some() || release_s.is_some() || brake_slip_rad.iter().any(Option::is_some);
        let opening_s = opened_s.zip(release_s).map(|(opened, released)| opened - released);
        is_cycle.then_some(CycleReport {
            motion_start_s,
            release_s,
            motion_travel,
            opened_s,
            opening_s,
            brake_slip_rad,
        })
    }
}

/// See [`ForceClosure`]. A wrench is a force and a moment divided by the object's radius, for normal forces that add up
/// to 1 (`q1_l1`) or are at most 1 each (`q1_linf`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceClosureReport {
    pub closed: bool,
    pub q1_l1: f64,
    pub q1_linf: f64,
    /// Direction of the smallest balanced wrench.
    pub weakest: [f64; 3],
}

impl From<ForceClosure> for ForceClosureReport {
    fn from(found: ForceClosure) -> Self {
        let ForceClosure { closed, q1_l1, q1_linf, weakest } = found;
        ForceClosureReport { closed, q1_l1, q1_linf, weakest }
    }
}

impl GraspReport {
    /// Builds the report of a run that ended with the sample `last`; without the scene there is no form closure.
    pub fn new(found: &GraspCriteria, scene: Option<&Scene>, last: &Sample) -> Self {
        let gripper = scene.filter(|scene| scene.kind() == SceneKind::Gripper);
        // Fingers that have released the object hold nothing.
        let holding_scene = gripper.filter(|_| found.fate == Fate::Held && found.cycle.release_s.is_none());
        let contacts = found.contacts.iter().map(|contact| (contact.id.name(), *contact));
        GraspReport {
            fate: found.fate.name(),
            fate_reason: gripper.map(|scene| fate_reason(found, scene.thresholds.held_time_s)),
            grasped_s: found.grasped_s,
            held_since_s: found.held_since_s,
            tts_s: found.tts_s,
            until_s: found.fate.lost_at_s(),
            form_closed: holding_scene.and_then(|scene| is_form_closed(scene, last)),
            force_closure: gripper
                .filter(|_| found.fate == Fate::Held && found.cycle.release_s.is_none())
                .map(|scene| sample_force_closure(scene, last).into()),
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
