//! What a finger's links and each kind of contact do, with slopes: nothing here depends on how many coordinates the whole has, so that
//! it is compiled once and called, not once more for every size of a system and every contact of a finger.

use super::frame;
use super::laws::Laws;
use super::model::{angles, variables};
use super::parts::Plane;
use super::touch::{self, Press, Slope};
use crate::analytic::finger::FingerModel;
use crate::fivebar::dynamics::Terms;
use crate::gripper::Site;
use crate::numeric::Dual;
use crate::scene::Pose;
use crate::shape::Placed;

/// Position-dependent terms of a finger, and its load by its own angles and by its own rates.
#[inline(never)]
pub fn turning(model: &FingerModel, (q, v): ([f64; 2], [f64; 2])) -> (Terms<Dual<2>>, [Dual<2>; 2], [[f64; 2]; 2]) {
    let terms = model.terms(angles(q));
    let (load, by_rates) = model.load_with_slopes(&terms, v);
    (terms, load, by_rates)
}

/// A phalanx against an object, on (q11, q21, x, y, θ) as the finger's frame has them, of which the first P say where the contact is.
#[inline(never)]
pub fn phalanx_on_object<const P: usize>(
    model: &FingerModel,
    (terms, site, object): (&Terms<Dual<2>>, Site, &Placed),
    rates: &[f64; 5],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, 5>, 5> {
    let (pose, turn) = (terms.pose.widen(), terms.rates.widen());
    let touch = touch::phalanx(&model.phalanx(&pose, &turn, site, &variables::<P>(object, [2, 3, 4])));
    touch::press_with_slopes(&touch, rates, memory, laws)
}

/// The joint limit, on a finger's angles.
#[inline(never)]
pub fn limit(model: &FingerModel, terms: &Terms<Dual<2>>, rates: &[f64; 2], laws: Laws<'_>) -> Press<Slope<2, 2>, 2> {
    let touch = touch::limit(&model.limit_geometry(&terms.pose, &terms.rates));
    touch::press_with_slopes(&touch, rates, None, laws)
}

/// Two discs, on (x, y) of both and then their angles.
#[inline(never)]
pub fn discs<const P: usize>(
    [one, two]: [&Placed; 2],
    rates: &[f64; 6],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, 6>, 6> {
    let touch = touch::discs([&variables::<P>(one, [0, 1, 4]), &variables(two, [2, 3, 5])]);
    touch::press_with_slopes(&touch, rates, memory, laws)
}

/// A disc on a table that the frame passes, on (x, y, t, θ).
#[inline(never)]
pub fn table<const P: usize>(
    (plane, pose, placed): (&Plane, &Pose, &Placed),
    rates: &[f64; 4],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, 4>, 4> {
    let touch = frame::table(plane, pose, Dual::variable(0.0, 2), &variables::<P>(placed, [0, 1, 3]));
    touch::press_with_slopes(&touch, rates, memory, laws)
}

/// A disc on a plane, on (x, y, θ); `on_plane` is whether the plane's surface is where they meet.
#[inline(never)]
pub fn plane<const P: usize>(
    (plane, placed, on_plane): (&Plane, &Placed, bool),
    rates: &[f64; 3],
    memory: Option<f64>,
    laws: Laws<'_>,
) -> Press<Slope<P, 3>, 3> {
    let touch = touch::plane(plane, &variables::<P>(placed, [0, 1, 2]), on_plane);
    touch::press_with_slopes(&touch, rates, memory, laws)
}
