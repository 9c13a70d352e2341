//! The scene of a finger.

use super::super::table::drive::{Motor, Springs};
use super::super::table::finger::{Object, Start};
use super::super::table::law::Limit;
use super::super::table::top::FingerKeys;
use super::super::table::{Table, show as show_table, show_keys};
use super::super::words::SceneKind;
use super::super::{Bounds, Contacts, Disc, Initial, Scene, Spring};
use super::out::Out;
use super::parts::{contact, heading};
use crate::gripper::{Body, BodyOverride, Finger};
use crate::law::NormalLaw;

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show(scene: &Scene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &Scene, mut out: Out) -> String {
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    let heading = heading(&mut out, SceneKind::Finger, heading_of);
    show_keys(&mut out, &FingerKeys { heading, palm: scene.palm, ..links(&scene.finger) }, |_| true);
    bodies(&mut out, "", &scene.finger);
    show_table(&mut out, "object", &object(scene.object));
    show_table(&mut out, "motor", &Motor::of(&scene.actuation));
    spring_and_limit(&mut out, "", scene.spring, scene.limit);
    laws(&mut out, "", &scene.contact);
    start(&mut out, "", scene.initial);
    run(&mut out, scene);
    out.text
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

fn object(disc: Option<Disc>) -> Object {
    // Without an object its size means nothing.
    let none = Object { present: false, radius_m: f64::NAN, centre_m: [f64::NAN; 2] };
    disc.map_or(none, |Disc { radius_m, centre_m }| Object { present: true, radius_m, centre_m })
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

fn run(out: &mut Out, scene: &Scene) {
    show_table(out, "integrator", &scene.integrator);
    show_table(out, "engine", &scene.engine);
    // A program may have shortened the run.
    let until_s = scene.bounds.until_s.min(scene.duration_s);
    show_table(out, "validate", &Bounds { until_s, ..scene.bounds });
    show_table(out, "log", &scene.log);
}
