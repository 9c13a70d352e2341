//! Loads of a finger's links and of each kind of contact, with derivatives. Nothing here depends on the size of the
//! system, so these functions are compiled once instead of once for each size and each contact of a finger.

use super::components::Plane;
use super::contact_kinematics::{self, ContactForces, WithDerivatives};
use super::frame;
use super::laws::ContactLaws;
use super::model::{angle_variables, placed_variables};
use crate::analytic::finger::FingerModel;
use crate::fivebar::dynamics::Terms;
use crate::gripper::FingerContact;
use crate::numeric::Dual;
use crate::scene::Pose;
use crate::shape::PlacedShape;

/// Position-dependent terms of a finger, and its load with derivatives with respect to its angles and its rates.
#[inline(never)]
pub fn finger_terms(
    model: &FingerModel,
    (q, v): ([f64; 2], [f64; 2]),
) -> (Terms<Dual<2>>, [Dual<2>; 2], [[f64; 2]; 2]) {
    let terms = model.terms(angle_variables(q));
    let (load, by_rates) = model.load_with_derivatives(&terms, v);
    (terms, load, by_rates)
}

/// Returns the contact forces of a phalanx on an object, on (q11, q21, x, y, θ) in the finger's frame. The contact
/// geometry depends on the first P of them.
#[inline(never)]
pub fn phalanx_on_object<const P: usize>(
    model: &FingerModel,
    (terms, phalanx, object): (&Terms<Dual<2>>, FingerContact, &PlacedShape),
    rates: &[f64; 5],
    bristle_state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, 5>, 5> {
    let (pose, passive_rates) = (terms.pose.widen(), terms.rates.widen());
    let kinematics = contact_kinematics::phalanx(&model.phalanx_geometry(
        &pose,
        &passive_rates,
        phalanx,
        &placed_variables::<P>(object, [2, 3, 4]),
    ));
    contact_kinematics::contact_forces_with_derivatives(&kinematics, rates, bristle_state, laws)
}

/// Returns the torque of the joint limit, on a finger's coordinates.
#[inline(never)]
pub fn limit(
    model: &FingerModel,
    terms: &Terms<Dual<2>>,
    rates: &[f64; 2],
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<2, 2>, 2> {
    let kinematics = contact_kinematics::limit(&model.limit_geometry(&terms.pose, &terms.rates));
    contact_kinematics::contact_forces_with_derivatives(&kinematics, rates, None, laws)
}

/// Two discs, on (x, y) of both, then their angles.
#[inline(never)]
pub fn discs<const P: usize>(
    [disc, other]: [&PlacedShape; 2],
    rates: &[f64; 6],
    bristle_state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, 6>, 6> {
    let kinematics =
        contact_kinematics::discs([&placed_variables::<P>(disc, [0, 1, 4]), &placed_variables(other, [2, 3, 5])]);
    contact_kinematics::contact_forces_with_derivatives(&kinematics, rates, bristle_state, laws)
}

/// Returns the contact forces of a disc on a table that moves relative to the frame, on (x, y, t, θ).
#[inline(never)]
pub fn table<const P: usize>(
    (plane, pose, placed): (&Plane, &Pose, &PlacedShape),
    rates: &[f64; 4],
    bristle_state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, 4>, 4> {
    let kinematics = frame::table(plane, pose, Dual::variable(0.0, 2), &placed_variables::<P>(placed, [0, 1, 3]));
    contact_kinematics::contact_forces_with_derivatives(&kinematics, rates, bristle_state, laws)
}

/// Returns the contact forces of a disc on a plane, on (x, y, θ); `on_plane`: whether the contact point is on the
/// plane's surface.
#[inline(never)]
pub fn plane<const P: usize>(
    (plane, placed, on_plane): (&Plane, &PlacedShape, bool),
    rates: &[f64; 3],
    bristle_state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, 3>, 3> {
    let kinematics = contact_kinematics::plane(plane, &placed_variables::<P>(placed, [0, 1, 2]), on_plane);
    contact_kinematics::contact_forces_with_derivatives(&kinematics, rates, bristle_state, laws)
}
