//! The scene of a finger.

use super::super::kinds::Words;
use super::super::table::drive::{Motor, Springs};
use super::super::table::finger::Start;
use super::super::table::law::Limit;
use super::super::table::show as show_table;
use super::super::words::SceneKind;
use super::super::{Bounds, Contacts, Initial, Scene, Spring};
use super::out::Out;
use super::parts::{contact, heading};
use crate::gripper::{Body, Finger};
use crate::law::NormalLaw;
use crate::units::Dimension;

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show(scene: &Scene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &Scene, mut out: Out) -> String {
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    heading(&mut out, SceneKind::Finger, heading_of);
    links(&mut out, &scene.finger);
    out.raw("palm", scene.palm);
    bodies(&mut out, "", &scene.finger);
    object(&mut out, scene);
    show_table(&mut out, "motor", &Motor::of(&scene.actuation));
    spring_and_limit(&mut out, "", scene.spring, scene.limit);
    laws(&mut out, "", &scene.contact);
    start(&mut out, "", scene.initial);
    run(&mut out, scene);
    out.text
}

/// What stands before the sections of a finger.
pub(super) fn links(out: &mut Out, finger: &Finger) {
    out.quantity("half_width", finger.lengths.half_width_m, Dimension::Length);
    out.text("assembly", finger.assembly.word());
}

/// Lengths and bodies, in sections whose names begin with `path`.
pub(super) fn bodies(out: &mut Out, path: &str, finger: &Finger) {
    show_table(out, &format!("{path}lengths"), &finger.lengths);
    let bodies = &finger.bodies;
    for (key, body) in [("l11", &bodies.l11), ("l12", &bodies.l12), ("l21", &bodies.l21), ("l22", &bodies.l22)] {
        let Body { mass_kg, com_m, inertia_kg_m2 } = body;
        out.section(&format!("{path}bodies.{key}"));
        out.quantity("mass", *mass_kg, Dimension::Mass);
        out.quantities("com", com_m, Dimension::Length);
        out.quantity("inertia", *inertia_kg_m2, Dimension::Inertia);
    }
}

fn object(out: &mut Out, scene: &Scene) {
    out.section("object");
    out.raw("present", scene.object.is_some());
    if let Some(disc) = scene.object {
        out.quantity("radius", disc.radius_m, Dimension::Length);
        out.quantities("centre", &disc.centre_m, Dimension::Length);
    }
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
