//! The scene of a finger.

use super::super::kinds::Words;
use super::super::table::drive::{Motor, Springs};
use super::super::table::finger::Start;
use super::super::table::law::Limit;
use super::super::table::show as show_table;
use super::super::words::SceneKind;
use super::super::{Bounds, Scene};
use super::out::Out;
use super::parts::{contact, heading};
use crate::gripper::Body;
use crate::units::Dimension;

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show(scene: &Scene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &Scene, mut out: Out) -> String {
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    heading(&mut out, SceneKind::Finger, heading_of);
    out.quantity("half_width", scene.finger.lengths.half_width_m, Dimension::Length);
    out.text("assembly", scene.finger.assembly.word());
    out.raw("palm", scene.palm);
    finger(&mut out, scene);
    object(&mut out, scene);
    drive(&mut out, scene);
    laws(&mut out, scene);
    run(&mut out, scene);
    out.text
}

fn finger(out: &mut Out, scene: &Scene) {
    show_table(out, "lengths", &scene.finger.lengths);
    let bodies = &scene.finger.bodies;
    for (key, body) in [
        ("bodies.l11", &bodies.l11),
        ("bodies.l12", &bodies.l12),
        ("bodies.l21", &bodies.l21),
        ("bodies.l22", &bodies.l22),
    ] {
        let Body { mass_kg, com_m, inertia_kg_m2 } = body;
        out.section(key);
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

fn drive(out: &mut Out, scene: &Scene) {
    show_table(out, "motor", &Motor::of(&scene.actuation));
    show_table(out, "spring", &Springs::of(scene.spring));
}

fn laws(out: &mut Out, scene: &Scene) {
    let limit = scene.limit.map_or(Limit::OFF, |law| Limit { enabled: true, law });
    show_table(out, "limit", &limit);
    contact(out, "contact.proximal", &scene.contact.proximal);
    contact(out, "contact.distal", &scene.contact.distal);
}

fn run(out: &mut Out, scene: &Scene) {
    show_table(out, "initial", &Start { offset_rad: None, joints: scene.initial });
    show_table(out, "integrator", &scene.integrator);
    show_table(out, "engine", &scene.engine);
    // A program may have shortened the run.
    let until_s = scene.bounds.until_s.min(scene.duration_s);
    show_table(out, "validate", &Bounds { until_s, ..scene.bounds });
    show_table(out, "log", &scene.log);
}
