//! A phalanx is a capsule, the object a disc: how far apart they are, and along which normal (thesis (B.1)–(B.2)).

use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, cross, dot, perp, scale, scale_by, sub};

/// A phalanx in the world: segment from `base` along unit `axis`, and the disc it may touch.
#[derive(Clone, Copy, Debug)]
pub struct Capsule<T> {
    pub base: Vector<T>,
    pub axis: Vector<T>,
    pub length: f64,
    pub radius: f64,
}

/// Point of the segment nearest to the disc's centre, unit normal there (object → phalanx), and the gap.
///
/// On the face the normal is ± the axis turned by 90°; past an end it turns about that end (the slip to the tip of (2.29)).
#[inline(always)]
pub fn nearest<T: Real>(capsule: &Capsule<T>, centre: Vector<T>, disc_radius: f64) -> (Vector<T>, Vector<T>, T) {
    let to_centre = sub(centre, capsule.base);
    let along = dot(to_centre, capsule.axis);
    let reach = capsule.radius + disc_radius;
    let s = along.value();
    if s > 0.0 && s < capsule.length {
        let offset = cross(capsule.axis, to_centre);
        let side = if offset.value() >= 0.0 { -1.0 } else { 1.0 };
        let normal = scale_by(perp(capsule.axis), side);
        (add(capsule.base, scale(capsule.axis, along)), normal, offset * -side - reach)
    } else {
        let point = if s <= 0.0 { capsule.base } else { add(capsule.base, scale_by(capsule.axis, capsule.length)) };
        let away = sub(point, centre);
        let distance = dot(away, away).sqrt();
        (point, scale(away, distance.recip()), distance - reach)
    }
}
