//! The scene of a finger.

use super::super::kinds::Words;
use super::super::table::show as show_table;
use super::super::words::SceneKind;
use super::super::{Actuation, Bounds, Scene, SpringKind};
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
    let lengths = &scene.finger.lengths;
    out.section("lengths");
    for (key, value) in [
        ("l11", lengths.l11_m),
        ("l12", lengths.l12_m),
        ("l21", lengths.l21_m),
        ("l22", lengths.l22_m),
        ("t22", lengths.t22_m),
    ] {
        out.quantity(key, value, Dimension::Length);
    }
    out.quantity("phi22", lengths.phi22_rad, Dimension::Angle);
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
    out.section("motor");
    match &scene.actuation {
        Actuation::Constant { torque_n_m } => {
            out.text("profile", "constant");
            out.quantity("torque", *torque_n_m, Dimension::Torque);
        }
        Actuation::Ramp { torque_n_m, rise_s } => {
            out.text("profile", "ramp");
            out.quantity("torque", *torque_n_m, Dimension::Torque);
            out.quantity("rise", *rise_s, Dimension::Time);
        }
        Actuation::HalfSine { torque_n_m, length_s } => {
            out.text("profile", "half-sine");
            out.quantity("torque", *torque_n_m, Dimension::Torque);
            out.quantity("pulse", *length_s, Dimension::Time);
        }
        Actuation::Reversal { torque_n_m, at_s } => {
            out.text("profile", "reversal");
            out.quantity("torque", *torque_n_m, Dimension::Torque);
            out.quantity("reverse_at", *at_s, Dimension::Time);
        }
        Actuation::Table { points, interpolation } => {
            let (times, torques): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
            out.text("profile", "table");
            out.quantities("times", &times, Dimension::Time);
            out.quantities("torques", &torques, Dimension::Torque);
            out.text("interpolation", interpolation.word());
        }
    }
    out.section("spring");
    match scene.spring {
        None => out.text("type", "none"),
        Some(spring) => {
            match spring.kind {
                SpringKind::Constant { torque_n_m } => {
                    out.text("type", "constant");
                    out.quantity("torque", torque_n_m, Dimension::Torque);
                }
                SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                    out.text("type", "torsional");
                    out.quantity("stiffness", stiffness_n_m_per_rad, Dimension::AngularStiffness);
                    out.quantity("preload", preload_rad, Dimension::Angle);
                }
            }
            out.text("placement", spring.placement.word());
        }
    }
}

fn laws(out: &mut Out, scene: &Scene) {
    out.section("limit");
    out.raw("enabled", scene.limit.is_some());
    if let Some(law) = &scene.limit {
        out.float("stiffness_si", law.stiffness_n_per_m_e);
        out.float("exponent", law.exponent);
        out.quantity("damping", law.damping_max_n_s_per_m, Dimension::AngularDamping);
        out.quantity("transition", law.transition_m, Dimension::Angle);
    }
    contact(out, "contact.proximal", &scene.contact.proximal);
    contact(out, "contact.distal", &scene.contact.distal);
}

fn run(out: &mut Out, scene: &Scene) {
    let start = &scene.initial;
    out.section("initial");
    out.quantity("q11", start.q11_rad, Dimension::Angle);
    out.quantity("q21", start.q21_rad, Dimension::Angle);
    out.quantity("qd11", start.qd11_rad_s, Dimension::AngularRate);
    out.quantity("qd21", start.qd21_rad_s, Dimension::AngularRate);
    show_table(out, "integrator", &scene.integrator);
    show_table(out, "engine", &scene.engine);
    // A program may have shortened the run.
    let until_s = scene.bounds.until_s.min(scene.duration_s);
    show_table(out, "validate", &Bounds { until_s, ..scene.bounds });
    show_table(out, "log", &scene.log);
}
