//! The object to be grasped.

use super::super::check::Checker;
use super::super::table::keys::Keys;
use super::super::table::object::{GraspedMotion, Object};
use super::super::table::{Table, read};
use super::super::{Disc, defaults};
use crate::gripper::Circle;

/// The object as it is said, with what follows from its radius.
pub fn said(c: &mut Checker<'_>, raw: &Keys<'_>) -> Object {
    let mut object = read(c, "object", &raw.inner("object"), Object::usual_in(raw.kind));
    let radius_m = object.radius_m;
    if object.centre_m[1].is_nan() {
        object.centre_m[1] = radius_m;
    }
    if let GraspedMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut object.motion {
        if mass_kg.is_nan() {
            *mass_kg = defaults::DENSITY_KG_M3 * std::f64::consts::PI * radius_m * radius_m * defaults::DEPTH_M;
        }
        if inertia_kg_m2.is_nan() {
            *inertia_kg_m2 = *mass_kg * radius_m * radius_m / 2.0;
        }
    }
    object
}

/// What one finger closes on: no disc where the scene has none, `None` where it is wrong.
pub fn beside(c: &mut Checker<'_>, raw: &Keys<'_>, said: Object, base_m: Option<f64>) -> Option<Vec<Disc>> {
    let Object { present, radius_m, centre_m, .. } = said;
    let object = raw.inner("object");
    if !present {
        if !raw.inner("design").is_given() {
            c.unused_at("object.radius", object.span("radius"), "with present = false and no [design]");
        }
        return Some(Vec::new());
    }
    if !object.has("centre") && raw.inner("lengths").is_given() {
        c.lacks(
            "object.centre",
            object.span,
            "a finger given by [lengths] has no base to place the object by: add [object] centre = [\"-15.5 mm\", \"20 \
             mm\"], or [object] present = false",
        );
        return None;
    }
    let centre_m = if object.has("centre") { centre_m } else { [-base_m?, radius_m] };
    // A wrong one is noted already.
    centre_m[0].is_finite().then(|| vec![Disc::object(Circle { radius_m, centre_m })])
}
