//! The initial configuration of a finger and its checks.

use std::ops::Range;

use super::super::Initial;
use super::super::check::Checker;
use super::super::table::finger::InitialSettings;
use super::super::table::input::SectionInput;
use super::super::table::{SettingsSection, read};
use super::finger::{FingerLengths, geometry};
use super::object::{self, rest_on_palm};
use super::target::Target;
use crate::fivebar::capsule::{Capsule, closest_points};
use crate::gripper::{self, Assembly, Finger, Joints, Lengths, Posture};
use crate::law::NormalLaw;
use crate::shape::PlacedShape;
use crate::units::{Dimension, format};

/// Largest allowed initial penetration of a phalanx into the object.
const MAX_PENETRATION_M: f64 = 1e-3;
/// Largest allowed initial angle beyond the joint limit: a torque of about 0.01 N·m with the default law.
const LIMIT_SLACK_RAD: f64 = 1e-6;

/// Reads the angle before the proximal contact and the joint angles; NaN for values that are not given.
pub fn start(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> (f64, Initial) {
    let InitialSettings { offset_rad, joints } =
        read(checker, "initial", &input.subsection("initial"), InitialSettings::defaults());
    (offset_rad.unwrap_or(f64::NAN), joints)
}

/// Resolves and checks the initial angles and rates. `finger_and_target` is the finger with its target, `None` if they
/// are invalid. A start before the contact is before it at both ends of the positioning error.
pub fn initial(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    finger_and_target: Option<(&Finger, &Target)>,
    limit: Option<NormalLaw>,
) -> Option<Initial> {
    let (offset, Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s }) = start(checker, input);
    let [q11, q21] = [q11_rad, q21_rad].map(|angle| Some(angle).filter(|angle| !angle.is_nan()));
    let start = input.subsection("initial");

    let (Finger { lengths, .. }, target) = finger_and_target?;
    let object = target.object;
    let (q11_rad, q21_rad) = match (start.has("q11"), start.has("q21")) {
        (true, false) => {
            let help = "add the angle of the proximal phalanx: q21 = \"40 deg\"; or remove both for a straight start";
            checker.report_missing_at("initial.q21", input.subsection("initial").span, help);
            return None;
        }
        (true, true) => {
            checker.report_unused_at("initial.offset", start.span("offset"), "with q11 and q21");
            (q11?, q21?)
        }
        (false, given) => {
            let q21_rad = match given {
                true => {
                    checker.report_unused_at("initial.offset", start.span("offset"), "with q21");
                    q21?
                }
                false => angle_before_contact(checker, input, finger_lengths, target, offset)?,
            };
            (straight(checker, input, finger_lengths, lengths, q21_rad)?, q21_rad)
        }
    };

    let start_span = start_span(input);
    let posture = match gripper::close_loop(lengths, finger_lengths.settings.assembly, q11_rad, q21_rad) {
        Ok(posture) => posture,
        Err(e) => {
            geometry(checker, start_span, "cannot be assembled here", &e.to_string());
            return None;
        }
    };
    if limit.is_some() {
        check_limit(checker, start_span.clone(), &posture, lengths);
    }
    if let Some(object) = object {
        check_penetration(checker, start_span, &posture, lengths, &object);
    }
    Some(Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s })
}

/// Position of the start for messages.
fn start_span(input: &SectionInput<'_>) -> Option<Range<usize>> {
    let given = ["q11", "q21", "offset"].into_iter().find_map(|key| input.subsection("initial").span(key));
    given
        .or(input.subsection("initial").span)
        .or(input.subsection("object").span("centre"))
        .or(input.subsection("design").span("base"))
}

/// q21 = q_c21 − q_0 (2-design §2.1), for the object or, without object, for the one of the design.
fn angle_before_contact(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    target: &Target,
    offset: f64,
) -> Option<f64> {
    let lengths = finger_lengths.lengths?;
    let placed = match (target.object, finger_lengths.base_m) {
        (Some(object), _) => object,
        (None, Some(base_m)) => rest_on_palm(object::shape(checker, input).at([-base_m, 0.0])),
        (None, None) => {
            let help = "without object and base there is no default: add [initial] q21 = \"40 deg\", or [lengths] base";
            checker.report_missing_at("initial.q21", input.subsection("initial").span, help);
            return None;
        }
    };
    let mut all = std::iter::once(&placed).chain(&target.ends);
    let first = all.try_fold(f64::INFINITY, |first, placed| {
        gripper::contact_angle_proximal(lengths.half_width_m, *placed).map(|contact| first.min(contact))
    });
    match first {
        Ok(contact) => Some(contact - offset),
        Err(e) => {
            let start_span = input.subsection("object").span("centre").or(start_span(input));
            geometry(checker, start_span, "no initial configuration", &e.to_string());
            None
        }
    }
}

/// q11 of the straight configuration.
fn straight(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    finger_lengths: &FingerLengths,
    lengths: &Lengths,
    q21_rad: f64,
) -> Option<f64> {
    if finger_lengths.settings.assembly == Assembly::Other {
        checker.push(
            input.span("assembly"),
            "the other assembly mode has no straight configuration",
            "no default start",
            "give both angles: [initial] q11 = \"...\" and q21 = \"...\"",
        );
        return None;
    }
    match gripper::straight_posture(lengths, q21_rad) {
        Ok(posture) => Some(posture.q11_rad),
        Err(e) => {
            geometry(checker, start_span(input), "cannot be straight", &e.to_string());
            None
        }
    }
}

fn check_limit(checker: &mut Checker<'_>, start_span: Option<Range<usize>>, posture: &Posture, lengths: &Lengths) {
    let excess_rad = -lengths.phi22_rad - posture.q22_rad;
    if excess_rad <= LIMIT_SLACK_RAD {
        return;
    }
    let message = format!(
        "the finger starts {:.4} deg beyond its joint limit: q22 is {:.4} deg, but must be at least -phi22 = {:.4} deg",
        excess_rad.to_degrees(),
        posture.q22_rad.to_degrees(),
        -lengths.phi22_rad.to_degrees()
    );
    checker.push(
        start_span,
        message,
        "bends the distal phalanx backwards",
        "raise q11, give only q21 for a straight start, or disable the limit: [limit] enabled = false",
    );
}

fn check_penetration(
    checker: &mut Checker<'_>,
    start_span: Option<Range<usize>>,
    posture: &Posture,
    lengths: &Lengths,
    object: &PlacedShape,
) {
    let Joints { a22_m, tip_m, .. } = gripper::joint_positions(lengths, posture);
    for (name, from, to) in [("proximal", [0.0, 0.0], a22_m), ("distal", a22_m, tip_m)] {
        let depth = -closest_points(&Capsule::between(from, to, lengths.half_width_m), object).gap;
        if depth <= MAX_PENETRATION_M {
            continue;
        }
        let message = format!(
            "the {name} phalanx starts {:.3} mm inside the object, but at most {} is allowed",
            depth * 1e3,
            format(MAX_PENETRATION_M, Dimension::Length)
        );
        let help = "open the finger further (lower q21, raise offset), or move the object away";
        checker.push(start_span.clone(), message, "starts inside the object", help);
    }
}
