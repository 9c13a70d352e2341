//! The initial configuration of a finger and its checks.

use schemars::JsonSchema;
use serde::Deserialize;

use super::bodies::{self, Target, rest_on_palm};
use super::finger::{FingerLengths, geometry};
use crate::fivebar::kinematics::{Capsule, closest_points};
use crate::gripper::{self, Assembly, Finger, Joints, Lengths, Posture};
use crate::law::NormalLaw;
use crate::limits::MAX_START_OVERLAP_M;
use crate::mechanism::Measure;
use crate::scene::Initial;
use crate::scene::quantity::{Angle, AngularRate, Quantity};
use crate::scene::section_input::SectionInput;
use crate::shape::PlacedShape;

/// Initial configuration. Default: straight and at rest, 25° before the contact of the proximal phalanx with the
/// object.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct InitialSettings {
    /// Start angle of a straight finger, measured back from the contact of the proximal phalanx with the object.
    #[schemars(extend("default" = "25 deg"))]
    pub offset: Option<Quantity<Angle>>,
    /// Angle of the driven link from the palm; requires q21. Default: that of the straight configuration.
    pub q11: Option<Quantity<Angle>>,
    /// Angle of the proximal phalanx from the palm.
    pub q21: Option<Quantity<Angle>>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd11: Quantity<AngularRate>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd21: Quantity<AngularRate>,
}

/// Largest allowed initial angle beyond the joint limit: a torque of about 0.01 N·m with the default law.
const LIMIT_SLACK_RAD: f64 = 1e-6;

/// Resolves and checks the initial angles and rates. `finger_and_target` is `None` if the finger or its target is
/// invalid. A start before the contact is before it at both ends of the positioning error.
pub fn initial(
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    finger_and_target: Option<(&Finger, &Target)>,
    limit: Option<NormalLaw>,
) -> Option<Initial> {
    let start = input.subsection("initial");
    let InitialSettings { offset, q11, q21, qd11, qd21 } = start.read();
    let (Finger { lengths, .. }, target) = finger_and_target?;
    let (q11_rad, q21_rad) = match (start.has("q11"), start.has("q21")) {
        (true, false) => {
            let help = "add the angle of the proximal phalanx: q21 = \"40 deg\"; or remove both for a straight start";
            return start.refuse_missing("q21", help);
        }
        (true, true) => {
            start.report_unused(["offset"], "with q11 and q21");
            (*q11?, *q21?)
        }
        (false, true) => {
            start.report_unused(["offset"], "with q21");
            (straight(input, finger_lengths, lengths, *q21?)?, *q21?)
        }
        (false, false) => {
            let q21_rad = angle_before_contact(input, finger_lengths, target, *offset?)?;
            (straight(input, finger_lengths, lengths, q21_rad)?, q21_rad)
        }
    };
    let (section, key) = start_place(input);
    let posture = gripper::close_loop(lengths, finger_lengths.assembly, q11_rad, q21_rad);
    let posture = geometry(&section, key, "cannot be assembled here", posture)?;
    if limit.is_some() {
        check_limit(&section, key, &posture, lengths);
    }
    if let Some(object) = target.object {
        check_penetration(&section, key, &posture, lengths, &object);
    }
    Some(Initial { q11_rad, q21_rad, qd11_rad_s: *qd11, qd21_rad_s: *qd21 })
}

/// Section and key of the start for messages.
fn start_place<'a>(input: &SectionInput<'a>) -> (SectionInput<'a>, &'static str) {
    let start = input.subsection("initial");
    match ["q11", "q21", "offset"].into_iter().find(|key| start.has(key)) {
        Some(key) => (start, key),
        None if start.is_present() => (start, ""),
        None if input.subsection("object").has("centre") => (input.subsection("object"), "centre"),
        None => (input.subsection("design"), "base"),
    }
}

/// q21 = q_c21 − q_0, for the object or, without object, for the one of the design.
fn angle_before_contact(
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    target: &Target,
    offset: f64,
) -> Option<f64> {
    let lengths = finger_lengths.lengths?;
    let placed = match (target.object, finger_lengths.base_m) {
        (Some(object), _) => object,
        (None, Some(base_m)) => rest_on_palm(bodies::shape(input).at([-base_m, 0.0])),
        (None, None) => {
            let help = "without object and base there is no default: add [initial] q21 = \"40 deg\", or [lengths] base";
            return input.subsection("initial").refuse_missing("q21", help);
        }
    };
    let mut all = std::iter::once(&placed).chain(&target.ends);
    let first = all.try_fold(f64::INFINITY, |first, placed| {
        gripper::contact_angle_proximal(lengths.half_width_m, *placed).map(|contact| first.min(contact))
    });
    let object = input.subsection("object");
    let (section, key) = if object.has("centre") { (object, "centre") } else { start_place(input) };
    Some(geometry(&section, key, "no initial configuration", first)? - offset)
}

/// q11 of the straight configuration.
fn straight(input: &SectionInput<'_>, finger_lengths: &FingerLengths, lengths: &Lengths, q21_rad: f64) -> Option<f64> {
    if finger_lengths.assembly == Assembly::Other {
        let message = "the other assembly mode has no straight configuration";
        let help = "give both angles: [initial] q11 = \"...\" and q21 = \"...\"";
        return input.refuse("assembly", message, "no default start", help);
    }
    let (section, key) = start_place(input);
    let posture = geometry(&section, key, "cannot be straight", gripper::straight_posture(lengths, q21_rad))?;
    Some(posture.q11_rad)
}

fn check_limit(input: &SectionInput<'_>, key: &str, posture: &Posture, lengths: &Lengths) {
    let excess_rad = -lengths.phi22_rad - posture.q22_rad;
    if excess_rad > LIMIT_SLACK_RAD {
        let [q22, limit] = Measure::distinct([posture.q22_rad, -lengths.phi22_rad].map(Measure::Angle));
        let message = format!(
            "the finger starts {} beyond its joint limit: q22 is {q22}, but must be at least -phi22 = {limit}",
            Measure::Angle(excess_rad)
        );
        let help = "raise q11, give only q21 for a straight start, or disable the limit: [limit] enabled = false";
        input.report(key, message, "bends the distal phalanx backwards", help);
    }
}

fn check_penetration(input: &SectionInput<'_>, key: &str, posture: &Posture, lengths: &Lengths, object: &PlacedShape) {
    let Joints { a22_m, tip_m, .. } = gripper::joint_positions(lengths, posture);
    for (name, from, to) in [("proximal", [0.0, 0.0], a22_m), ("distal", a22_m, tip_m)] {
        let depth = -closest_points(&Capsule::between(from, to, lengths.half_width_m), object).gap;
        if depth > MAX_START_OVERLAP_M {
            let [depth, limit] = Measure::distinct([depth, MAX_START_OVERLAP_M].map(Measure::Length));
            let message =
                format!("the {name} phalanx starts {depth} inside the object, but at most {limit} is allowed");
            let help = "open the finger further (lower q21, raise offset), or move the object away";
            input.report(key, message, "starts inside the object", help);
        }
    }
}
