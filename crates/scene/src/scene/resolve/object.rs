//! The object to be grasped.

use super::super::check::Checker;
use super::super::kinds::{Length, Pair};
use super::super::table::keys::Keys;
use super::super::table::object::{GraspedMotion, Object};
use super::super::table::{Table, read};
use super::super::{Disc, defaults};
use crate::shape::{self, Placed, Shape};
use crate::units::{Dimension, format};

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
    // A wrong one is noted already.
    object.is_known::<Pair<Length>>("centre").then_some(())?;
    let ([x, y], lengths) = (centre_m, raw.inner("lengths"));
    if x.is_finite() {
        c.unused_at("lengths.base", lengths.span("base"), "beside object.centre");
        return Some(vec![Disc::object(shape.at(centre_m))]);
    }
    if base_m.is_none() && lengths.is_given() && !lengths.has("base") {
        let [base, height] = [example_base_m(raw, &shape), y].map(|metres| format(metres, Dimension::Length));
        let help = format!(
            "add the distance along the palm to its centre, such as [lengths] base = \"{base}\", or [object] centre = \
             [\"-{base}\", \"{height}\"], or [object] present = false"
        );
        c.lacks("lengths.base", lengths.span, &help);
    }
    Some(vec![Disc::object(shape.at([-base_m?, y]))])
}

/// A base for an example, in three digits: so far beyond the nearest one of a design (D > R, see `gripper::proximal_range`) as that of
/// the thesis' example.
pub fn example_base_m(raw: &Keys<'_>, shape: &Shape) -> f64 {
    let half_width_m = raw.value::<Length>("half_width").unwrap_or(defaults::HALF_WIDTH_M);
    let reach_m = shape::reach(shape);
    let base_m = (half_width_m * (2.0 * reach_m + half_width_m)).sqrt() + 0.25 * reach_m;
    format!("{base_m:.2e}").parse().unwrap_or(base_m)
}
