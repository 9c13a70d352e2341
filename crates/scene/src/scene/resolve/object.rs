//! The object to be grasped.

use super::super::check::Checker;
use super::super::table::keys::Keys;
use super::super::table::object::{GraspedMotion, Object};
use super::super::table::{Table, read};
use super::super::{Disc, defaults};
use crate::shape::{self, Placed, Shape};

/// Its shape.
pub fn shape(c: &mut Checker<'_>, raw: &Keys<'_>) -> Shape {
    read(c, "object", &raw.inner("object"), Shape::usual())
}

/// The same resting on the palm, so far along it as it is.
pub fn on_the_palm(placed: Placed) -> Placed {
    let [x, _] = placed.centre_m;
    let [_, below] = placed.at([x, 0.0]).lowest_m();
    placed.at([x, -below])
}

/// The object as it is said, with what follows from its shape.
pub fn said(c: &mut Checker<'_>, raw: &Keys<'_>) -> Object {
    let shape = shape(c, raw);
    let mut object = Object { shape, ..read(c, "object", &raw.inner("object"), Object::usual_in(raw.kind)) };
    if object.centre_m[1].is_nan() {
        object.centre_m = on_the_palm(object.placed()).centre_m;
    }
    if let GraspedMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut object.motion {
        if mass_kg.is_nan() {
            *mass_kg = shape::mass(&shape, defaults::DENSITY_KG_M3, defaults::DEPTH_M);
        }
        if inertia_kg_m2.is_nan() {
            *inertia_kg_m2 = shape::inertia(&shape, *mass_kg);
        }
    }
    object
}

/// What one finger closes on: no disc where the scene has none, `None` where it is wrong.
pub fn beside(c: &mut Checker<'_>, raw: &Keys<'_>, said: Object, base_m: Option<f64>) -> Option<Vec<Disc>> {
    let Object { present, shape, centre_m, .. } = said;
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
    let placed = if object.has("centre") { shape.at(centre_m) } else { on_the_palm(shape.at([-base_m?, 0.0])) };
    // A wrong one is noted already.
    placed.centre_m[0].is_finite().then(|| vec![Disc::object(placed)])
}
