//! The object to be grasped.

use super::super::check::Checker;
use super::super::raw::RawScene;
use super::super::table::finger::Object;
use crate::gripper::Circle;

/// The disc: `Some(None)` where the scene has none, `None` where it is wrong.
pub fn object(c: &mut Checker<'_>, raw: &RawScene, said: Object, base_m: Option<f64>) -> Option<Option<Circle>> {
    let Object { present, radius_m, centre_m } = said;
    let object = &raw.object;
    if !present {
        if !raw.design.is_given() {
            c.unused_at("object.radius", object.span("radius"), "with present = false and no [design]");
        }
        return Some(None);
    }
    if !object.has("centre") && raw.lengths.is_given() {
        c.missing(
            "object.centre",
            object,
            "a finger given by [lengths] has no base to place the object by: add [object] centre = [\"-15.5 mm\", \"20 \
             mm\"], or [object] present = false",
        );
        return None;
    }
    let centre_m = if object.has("centre") { centre_m } else { [-base_m?, radius_m] };
    // A wrong one is noted already.
    centre_m[0].is_finite().then_some(Some(Circle { radius_m, centre_m }))
}
