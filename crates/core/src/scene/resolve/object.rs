//! The object to be grasped.

use super::super::check::{Checker, POSITIVE};
use super::super::raw::RawScene;
use super::super::{Disc, defaults};

/// Radius r_c: of the object, and what a design is made for even where the object itself is left out.
pub fn radius(c: &mut Checker<'_>, raw: &RawScene) -> f64 {
    c.number_or("object.radius", &raw.object.radius, POSITIVE, defaults::OBJECT_RADIUS_M)
}

/// The disc: `Some(None)` where the scene has none, `None` where it is wrong.
pub fn object(c: &mut Checker<'_>, raw: &RawScene, radius_m: f64, base_m: Option<f64>) -> Option<Option<Disc>> {
    let object = &raw.object;
    let centre = c.get("object.centre", &object.centre);
    if !c.or("object.present", &object.present, true) {
        c.unused("object.centre", &object.centre, "with present = false");
        if !raw.design.is_given() {
            c.unused("object.radius", &object.radius, "with present = false and no [design]");
        }
        return Some(None);
    }
    if !object.centre.is_given() && raw.lengths.is_given() {
        c.missing(
            "object.centre",
            object,
            "a finger given by [lengths] has no base to place the object by: add [object] centre = [\"-15.5 mm\", \"20 \
             mm\"], or [object] present = false",
        );
        return None;
    }
    let centre_m = match object.centre.is_given() {
        true => centre?,
        false => [-base_m?, radius_m],
    };
    Some(Some(Disc { radius_m, centre_m }))
}
