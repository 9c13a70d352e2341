//! Where the finger starts, and whether it can be there.

use std::ops::Range;

use super::super::Initial;
use super::super::check::Checker;
use super::super::table::finger::Start;
use super::super::table::keys::Keys;
use super::super::table::{Table, read};
use super::finger::{Plan, geometry};
use super::object::{self, on_the_palm};
use super::seen::Seen;
use crate::fivebar::capsule::{Capsule, nearest};
use crate::gripper::{self, Assembly, Finger, Joints, Lengths, Posture};
use crate::law::NormalLaw;
use crate::shape::Placed;
use crate::units::{Dimension, format};

/// Deepest overlap of a phalanx and the object a scene may start with.
const MAX_PENETRATION_M: f64 = 1e-3;
/// How far beyond the joint limit a start may be: a torque of about 0.01 N·m with the default law.
const LIMIT_SLACK_RAD: f64 = 1e-6;

/// How far before the contact a start is unless angles are given, and these: not a number where they are not.
pub fn start(c: &mut Checker<'_>, raw: &Keys<'_>) -> (f64, Initial) {
    let Start { offset_rad, joints } = read(c, "initial", &raw.inner("initial"), Start::usual());
    (offset_rad.unwrap_or(f64::NAN), joints)
}

/// Initial angles and rates; checked as far as the rest of the scene is `sound`. A start that is before the object is so wherever it
/// may be.
pub fn initial(
    c: &mut Checker<'_>,
    raw: &Keys<'_>,
    plan: &Plan,
    sound: Option<(&Finger, &Seen)>,
    limit: Option<NormalLaw>,
) -> Option<Initial> {
    let (offset, Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s }) = start(c, raw);
    let [q11, q21] = [q11_rad, q21_rad].map(|angle| Some(angle).filter(|angle| !angle.is_nan()));
    let start = raw.inner("initial");

    let (Finger { lengths, .. }, seen) = sound?;
    let object = seen.object;
    let (q11_rad, q21_rad) = match (start.has("q11"), start.has("q21")) {
        (true, false) => {
            let help = "add the proximal phalanx: q21 = \"40 deg\"; or leave both out for a straight start";
            c.lacks("initial.q21", raw.inner("initial").span, help);
            return None;
        }
        (true, true) => {
            c.unused_at("initial.offset", start.span("offset"), "beside q11 and q21");
            (q11?, q21?)
        }
        (false, given) => {
            let q21_rad = match given {
                true => {
                    c.unused_at("initial.offset", start.span("offset"), "beside q21");
                    q21?
                }
                false => before_contact(c, raw, plan, seen, offset)?,
            };
            (straight(c, raw, plan, lengths, q21_rad)?, q21_rad)
        }
    };

    let place = place(raw);
    let posture = match gripper::close(lengths, plan.said.assembly, q11_rad, q21_rad) {
        Ok(posture) => posture,
        Err(e) => {
            geometry(c, place, "cannot be assembled here", &e.to_string());
            return None;
        }
    };
    if limit.is_some() {
        judge_limit(c, place.clone(), &posture, lengths);
    }
    if let Some(object) = object {
        judge_overlap(c, place, &posture, lengths, &object);
    }
    Some(Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s })
}

/// What stands for the start in messages.
fn place(raw: &Keys<'_>) -> Option<Range<usize>> {
    let given = ["q11", "q21", "offset"].into_iter().find_map(|key| raw.inner("initial").span(key));
    given.or(raw.inner("initial").span).or(raw.inner("object").span("centre")).or(raw.inner("design").span("base"))
}

/// q21 = q_c21 − q_0 (2-design §2.1), for the object or else for the one the design is made for.
fn before_contact(c: &mut Checker<'_>, raw: &Keys<'_>, plan: &Plan, seen: &Seen, offset: f64) -> Option<f64> {
    let lengths = plan.lengths?;
    let placed = match (seen.object, plan.base_m) {
        (Some(object), _) => object,
        (None, Some(base_m)) => on_the_palm(object::shape(c, raw).at([-base_m, 0.0])),
        (None, None) => {
            let help = "without object and base nothing says where to start: add [initial] q21 = \"40 deg\", or [lengths] base";
            c.lacks("initial.q21", raw.inner("initial").span, help);
            return None;
        }
    };
    let mut all = std::iter::once(&placed).chain(&seen.ends);
    let first = all.try_fold(f64::INFINITY, |first, placed| {
        gripper::contact_angle_proximal(lengths.half_width_m, *placed).map(|contact| first.min(contact))
    });
    match first {
        Ok(contact) => Some(contact - offset),
        Err(e) => {
            let place = raw.inner("object").span("centre").or(place(raw));
            geometry(c, place, "leaves no place to start from", &e.to_string());
            None
        }
    }
}

/// q11 of the straight finger.
fn straight(c: &mut Checker<'_>, raw: &Keys<'_>, plan: &Plan, lengths: &Lengths, q21_rad: f64) -> Option<f64> {
    if plan.said.assembly == Assembly::Other {
        c.push(
            raw.span("assembly"),
            "the other assembly mode has no straight configuration to start from",
            "needs a start",
            "give both angles: [initial] q11 = \"...\" and q21 = \"...\"",
        );
        return None;
    }
    match gripper::straight(lengths, q21_rad) {
        Ok(posture) => Some(posture.q11_rad),
        Err(e) => {
            geometry(c, place(raw), "cannot be straight", &e.to_string());
            None
        }
    }
}

fn judge_limit(c: &mut Checker<'_>, place: Option<Range<usize>>, posture: &Posture, lengths: &Lengths) {
    let beyond = -lengths.phi22_rad - posture.q22_rad;
    if beyond <= LIMIT_SLACK_RAD {
        return;
    }
    let message = format!(
        "the finger starts {:.4} deg beyond its joint limit: q22 is {:.4} deg, but must be at least -phi22 = {:.4} deg",
        beyond.to_degrees(),
        posture.q22_rad.to_degrees(),
        -lengths.phi22_rad.to_degrees()
    );
    c.push(
        place,
        message,
        "bends the distal phalanx backwards",
        "turn l11 further closing (raise q11), give q21 alone for a straight start, or switch the limit off: [limit] \
         enabled = false",
    );
}

fn judge_overlap(
    c: &mut Checker<'_>,
    place: Option<Range<usize>>,
    posture: &Posture,
    lengths: &Lengths,
    object: &Placed,
) {
    let Joints { a22_m, tip_m, .. } = gripper::joints(lengths, posture);
    for (name, from, to) in [("proximal", [0.0, 0.0], a22_m), ("distal", a22_m, tip_m)] {
        let depth = -nearest(&Capsule::between(from, to, lengths.half_width_m), object).gap;
        if depth <= MAX_PENETRATION_M {
            continue;
        }
        let message = format!(
            "the {name} phalanx starts {:.3} mm inside the object, but at most {} is allowed",
            depth * 1e3,
            format(MAX_PENETRATION_M, Dimension::Length)
        );
        let help = "open the finger further (lower q21, raise offset), or move the object away";
        c.push(place.clone(), message, "starts inside the object", help);
    }
}
