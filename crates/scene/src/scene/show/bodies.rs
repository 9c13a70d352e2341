//! A scene of discs.

use super::super::table::disc::DiscKeys;
use super::super::table::top::BodiesKeys;
use super::super::table::{show as show_table, show_keys};
use super::super::words::SceneKind;
use super::super::{BodiesBounds, BodiesScene};
use super::out::Out;
use super::parts::{contact, heading};

/// The scene with everything filled in, as a scene file that parses back to the same scene, bit for bit (its `source`
/// excepted).
pub fn show_bodies(scene: &BodiesScene) -> String {
    shown(scene, Out::default())
}

pub(super) fn shown(scene: &BodiesScene, mut out: Out) -> String {
    let heading_of = (scene.name.as_str(), scene.description.as_str(), scene.duration_s, scene.gravity_m_s2);
    let keys = BodiesKeys { heading: heading(&mut out, SceneKind::Bodies, heading_of) };
    show_keys(&mut out, &keys, |_| true);
    for named in &scene.discs {
        show_table(&mut out, &format!("discs.{}", named.name), &DiscKeys::of(named));
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
