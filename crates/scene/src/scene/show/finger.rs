//! One finger, and what every finger is shown by.

use super::super::table::drive::{Motor, Springs};
use super::super::table::finger::{Object, Start};
use super::super::table::law::Limit;
use super::super::table::top::{FingerKeys, Heading};
use super::super::table::{Table, show as show_table, show_keys};
use super::super::{Contacts, Disc, DrivenFinger, Initial, Side, Spring, System};
use super::out::Out;
use super::parts::contact;
use crate::gripper::{Body, BodyOverride, Finger};
use crate::law::NormalLaw;

pub fn system(out: &mut Out, heading: Heading, system: &System) {
    let DrivenFinger { linkage, motor, spring, limit, contact, initial } = system.finger(Side::Right);
    show_keys(out, &FingerKeys { heading, palm: system.palm.is_some(), ..links(linkage) }, |_| true);
    bodies(out, "", linkage);
    show_table(out, "object", &object(system.object()));
    show_table(out, "motor", &Motor::of(&motor.actuation));
    spring_and_limit(out, "", *spring, *limit);
    laws(out, "", contact);
    start(out, "", *initial);
}

/// What stands before the sections of a finger, as far as the finger says it.
fn links(finger: &Finger) -> FingerKeys {
    let half_width_m = finger.lengths.half_width_m;
    // What a sizing came to is shown in its place.
    FingerKeys { half_width_m, assembly: finger.assembly, closing_s: f64::NAN, ..FingerKeys::usual() }
}

/// The same alone.
pub(super) fn show_links(out: &mut Out, finger: &Finger) {
    show_keys(out, &links(finger), |key| ["half_width", "assembly"].contains(&key));
}

/// Lengths and bodies, in sections whose names begin with `path`.
pub(super) fn bodies(out: &mut Out, path: &str, finger: &Finger) {
    show_table(out, &format!("{path}lengths"), &finger.lengths);
    let bodies = &finger.bodies;
    for (key, body) in [("l11", &bodies.l11), ("l12", &bodies.l12), ("l21", &bodies.l21), ("l22", &bodies.l22)] {
        let Body { mass_kg, com_m, inertia_kg_m2 } = *body;
        let whole = BodyOverride { mass_kg: Some(mass_kg), com_m: Some(com_m), inertia_kg_m2: Some(inertia_kg_m2) };
        show_table(out, &format!("{path}bodies.{key}"), &whole);
    }
}

fn object(disc: Option<&Disc>) -> Object {
    // Without an object its size means nothing.
    let none = Object { present: false, radius_m: f64::NAN, centre_m: [f64::NAN; 2] };
    disc.map_or(none, |disc| Object { present: true, radius_m: disc.radius_m, centre_m: disc.centre_m })
}

pub(super) fn spring_and_limit(out: &mut Out, path: &str, spring: Option<Spring>, limit: Option<NormalLaw>) {
    show_table(out, &format!("{path}spring"), &Springs::of(spring));
    let limit = limit.map_or(Limit::OFF, |law| Limit { enabled: true, law });
    show_table(out, &format!("{path}limit"), &limit);
}

pub(super) fn laws(out: &mut Out, path: &str, laws: &Contacts) {
    contact(out, &format!("{path}contact.proximal"), &laws.proximal);
    contact(out, &format!("{path}contact.distal"), &laws.distal);
}

pub(super) fn start(out: &mut Out, path: &str, joints: Initial) {
    show_table(out, &format!("{path}initial"), &Start { offset_rad: None, joints });
}
