//! A scene of discs.

use super::super::kinds::Words;
use super::super::table::show as show_table;
use super::super::words::{Motion, SceneKind};
use super::super::{BodiesBounds, BodiesScene, DiscMotion, NamedDisc};
use super::out::Out;
use super::parts::{contact, heading};
use crate::units::Dimension;

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show_bodies(scene: &BodiesScene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &BodiesScene, mut out: Out) -> String {
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    heading(&mut out, SceneKind::Bodies, heading_of);
    for named in &scene.discs {
        disc(&mut out, named);
    }
    if let Some(plane) = scene.half_plane {
        show_table(&mut out, "half_plane", &plane);
    }
    contact(&mut out, "contact", &scene.contact);
    show_table(&mut out, "integrator", &scene.integrator);
    show_table(&mut out, "engine", &scene.engine);
    // A program may have shortened the run.
    let until_s = scene.bounds.until_s.min(scene.duration_s);
    show_table(&mut out, "validate", &BodiesBounds { until_s, ..scene.bounds });
    show_table(&mut out, "log", &scene.log);
    out.text
}

fn disc(out: &mut Out, NamedDisc { name, radius_m, centre_m, motion }: &NamedDisc) {
    out.section(&format!("discs.{name}"));
    out.quantity("radius", *radius_m, Dimension::Length);
    out.quantities("centre", centre_m, Dimension::Length);
    match motion {
        DiscMotion::Fixed => out.text("motion", Motion::Fixed.word()),
        DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
            out.text("motion", Motion::Driven.word());
            out.quantities("velocity", velocity_m_s, Dimension::Speed);
            out.quantities("acceleration", acceleration_m_s2, Dimension::Acceleration);
            out.quantity("spin", *spin_rad_s, Dimension::AngularRate);
        }
        DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
            out.text("motion", Motion::Free.word());
            out.quantities("velocity", velocity_m_s, Dimension::Speed);
            out.quantity("mass", *mass_kg, Dimension::Mass);
            out.raw("rotates", inertia_kg_m2.is_some());
            if let Some(inertia_kg_m2) = inertia_kg_m2 {
                out.quantity("inertia", *inertia_kg_m2, Dimension::Inertia);
                out.quantity("spin", *spin_rad_s, Dimension::AngularRate);
            }
        }
    }
}
