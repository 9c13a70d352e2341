//! The fate of the object of a gripper: JSON document and text.

use serde::{Serialize, Serializer};

use super::named::{Named, Object};
use super::tables::{DEGREES, milliseconds, resolved};
use crate::criteria::{CycleCriteria, Fate, GraspCriteria, fate_reason, is_form_closed, sample_force_closure};
use crate::format::numbers::{format_number, or_dash};
use crate::format::report::{Report, table_of};
use crate::scene::Scene;
use crate::statics::ForceClosure;
use crate::trace::Sample;
use crate::units::Dimension;

/// The grasp of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct GraspReport {
    pub criteria: GraspCriteria,
    /// Reason for the fate; null without the scene.
    pub(crate) fate_reason: Option<String>,
    /// Whether the contacts active at the end, with the blocked drives, form-close the object; null if the object is
    /// not held or if form closure cannot be decided.
    form_closed: Option<bool>,
    /// Force closure by the contacts in the hand active at the end; null if the object is not held, and without the
    /// scene.
    force_closure: Option<ForceClosure>,
}

impl GraspReport {
    /// Builds the report of a run that ended with the sample `last`; without the scene there is no form closure.
    pub fn new(found: &GraspCriteria, scene: Option<&Scene>, last: &Sample) -> Self {
        let gripper = scene.filter(|scene| scene.finger_count() == 2);
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
    fn cycle(&self) -> Option<&CycleCriteria> {
        let cycle = &self.criteria.cycle;
        let has_brakes = cycle.brake_slip_rad.iter().any(Option::is_some);
        (cycle.motion_start_s.is_some() || cycle.release_s.is_some() || has_brakes).then_some(cycle)
    }

    /// Fate and criteria of the object.
    pub fn text(&self) -> Report {
        let found = &self.criteria;
        let angle = |angle_rad: f64| resolved(angle_rad, Dimension::Angle, DEGREES, 4);
        let length = |length_m: f64, factor: f64| resolved(length_m, Dimension::Length, factor, 4);
        let lost: u32 = found.contacts.iter().map(|contact| contact.times_lost).sum();
        let mut text = table_of(
            [found],
            &[
                ("grasp", &|found| found.fate.name().to_string()),
                ("first held, ms", &|found| milliseconds(found.grasped_s)),
                ("tts, ms", &|found| milliseconds(found.tts_s)),
                ("form-closed", &|_| or_dash(self.form_closed, |closed| if closed { "yes" } else { "no" }.to_string())),
                ("contacts lost", &|_| lost.to_string()),
                ("slip after tts, mm", &|found| or_dash(found.slip, |slip| length(slip.displacement_m, 1e3))),
                ("rotation, deg", &|found| or_dash(found.slip, |slip| angle(slip.rotation_rad))),
            ],
        );
        if let Some(ratio) = found.offset_ratio() {
            let effect = if ratio < 1.0 { "centres" } else { "does not centre" };
            let [start, end] = [found.start, found.end].map(|state| format_number(state.centre_m[0] * 1e3, 4));
            text.push(format!(
                "The grasp {effect} the object: its offset from the middle changes from {start} mm to {end} mm.\n"
            ));
        }
        if let Some(reason) = self.fate_reason.as_ref().filter(|_| found.fate != Fate::Held) {
            let (first, rest) = found.fate.name().split_at(1);
            text.push(format!("{}{rest}: {reason}.\n", first.to_uppercase()));
        }
        text.push(self.force_closure.map(|ForceClosure { closed, q1_l1, q1_linf, .. }| match closed {
            true => format!(
                "Force-closed with friction: Q1 = {} (sum of normal forces 1) or {} (each at most 1).\n",
                format_number(q1_l1, 3),
                format_number(q1_linf, 3)
            ),
            false => "Not force-closed, even with friction.\n".to_string(),
        }));
        let Some(cycle) = self.cycle() else { return text };
        let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
        if let Some((from_s, slip)) = cycle.motion_start_s.zip(cycle.motion_travel) {
            text.push(format!(
                "Transport from {} {}: the object slips {} µm and rotates {} deg.\n",
                ms(from_s),
                cycle.release_s.map_or("to the end".to_string(), |until_s| format!("to {}", ms(until_s))),
                length(slip.displacement_m, 1e6),
                angle(slip.rotation_rad)
            ));
        }
        let brake_slip = cycle.brake_slip_rad.into_iter().flatten().reduce(f64::max);
        text.push(brake_slip.map(|rad| format!("Blocked driven links rotate by up to {} deg.\n", angle(rad))));
        text.with(cycle.release_s.map(|released_s| match cycle.opened_s.zip(opening_s(cycle)) {
            Some((opened_s, opening_s)) => format!(
                "Released; the fingers are clear of the object {} later; cycle time {}.\n",
                ms(opening_s),
                ms(opened_s)
            ),
            None => format!("Released at {}; the fingers are not clear of the object at the end.\n", ms(released_s)),
        }))
    }
}

/// Time from the release until no phalanx is in contact.
fn opening_s(cycle: &CycleCriteria) -> Option<f64> {
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
