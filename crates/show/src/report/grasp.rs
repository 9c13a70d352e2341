//! The fate of the object of a gripper in the JSON document.

use serde::{Serialize, Serializer};

use super::named::{Named, Object};
use crate::criteria::{CycleCriteria, Fate, GraspCriteria, fate_reason, is_form_closed, sample_force_closure};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::statics::ForceClosure;
use crate::trace::Sample;

/// The grasp of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspReport {
    pub criteria: GraspCriteria,
    /// Reason for the fate; null without the scene.
    pub fate_reason: Option<String>,
    /// Whether the contacts active at the end, with the blocked drives, form-close the object; null if the object is
    /// not held or if form closure cannot be decided.
    pub form_closed: Option<bool>,
    /// Force closure by the contacts in the hand active at the end; null if the object is not held, and without the
    /// scene.
    pub force_closure: Option<ForceClosure>,
}

impl GraspReport {
    /// Builds the report of a run that ended with the sample `last`; without the scene there is no form closure.
    pub fn new(found: &GraspCriteria, scene: Option<&Scene>, last: &Sample) -> Self {
        let gripper = scene.filter(|scene| scene.kind() == SceneKind::Gripper);
        // Fingers that have released the object hold nothing.
        let holding = gripper.filter(|_| found.fate == Fate::Held && found.cycle.release_s.is_none());
        GraspReport {
            criteria: found.clone(),
            fate_reason: gripper.map(|scene| fate_reason(found, scene.thresholds.held_time_s)),
            form_closed: holding.and_then(|scene| is_form_closed(scene, last)),
            force_closure: holding.map(|scene| sample_force_closure(scene, last)),
        }
    }

    /// When the object left the gripper, if it did.
    pub(super) fn ejected_s(&self) -> Option<f64> {
        self.criteria.fate.lost_at_s().filter(|_| matches!(self.criteria.fate, Fate::Ejected { .. }))
    }

    /// Criteria of a gripper that transports, releases or brakes its object.
    pub(super) fn cycle(&self) -> Option<&CycleCriteria> {
        let cycle = &self.criteria.cycle;
        let has_brakes = cycle.brake_slip_rad.iter().any(Option::is_some);
        (cycle.motion_start_s.is_some() || cycle.release_s.is_some() || has_brakes).then_some(cycle)
    }
}

/// Time from the release until no phalanx is in contact.
pub(super) fn opening_s(cycle: &CycleCriteria) -> Option<f64> {
    cycle.opened_s.zip(cycle.release_s).map(|(opened_s, released_s)| opened_s - released_s)
}

impl Serialize for GraspReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = &self.criteria;
        let contacts: Named<_> = found.contacts.iter().map(|contact| (contact.id.name(), contact)).collect();
        let cycle = self.cycle().map(|cycle| {
            Object::default()
                .with("carries_s", cycle.motion_start_s)
                .with("releases_s", cycle.release_s)
                .with("carried", cycle.motion_travel)
                .with("opened_s", cycle.opened_s)
                .with("opening_s", opening_s(cycle))
                .with("brake_slip_rad", cycle.brake_slip_rad)
        });
        Object::default()
            // `held`, `dropped`, `ejected` or `not grasped`.
            .with("fate", found.fate.name())
            .with("fate_reason", &self.fate_reason)
            .with("grasped_s", found.grasped_s)
            .with("held_since_s", found.held_since_s)
            .with("tts_s", found.tts_s)
            // Time since which the object is no longer held, or at which it left the gripper.
            .with("until_s", found.fate.lost_at_s())
            .with("form_closed", self.form_closed)
            .with("force_closure", self.force_closure.as_ref().map(force_closure))
            // Position of the object along the palm from its middle; the ratio is null if it started centred.
            .with("x_start_m", found.start.centre_m[0])
            .with("x_end_m", found.end.centre_m[0])
            .with("offset_ratio", found.offset_ratio())
            .with("speed_m_s", found.end_speed_m_s())
            .with("travel", found.travel)
            .with("slip", found.slip)
            .with_some("cycle", cycle)
            .with("contacts", contacts)
            .serialize(serializer)
    }
}

/// JSON object of a force closure. A wrench is a force and a moment divided by the object's radius, for normal forces
/// that add up to 1 (`q1_l1`) or are at most 1 each (`q1_linf`).
pub(super) fn force_closure(found: &ForceClosure) -> Object<'static> {
    Object::default()
        .with("closed", found.closed)
        .with("q1_l1", found.q1_l1)
        .with("q1_linf", found.q1_linf)
        .with("weakest", found.weakest)
}
