//! Forces of one contact between two surfaces, by the normal law and the friction law, with their derivatives.

use super::mode::{ContactLaws, ContactState, row_dot};
use crate::law::{NormalForce, NormalLaw, normal_force, normal_over_gap, unclamped_normal_force};
use crate::numeric::plane::Vector;
use crate::numeric::{Dual, Real, array_from};

/// Kinematics of one contact on K coordinates: the rows give gap rate and slip from their rates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactKinematics<T, const K: usize> {
    pub gap: T,
    pub normal_row: [T; K],
    pub tangent_row: [T; K],
    /// Normal from the second surface to the first: from the object to the phalanx, or from the plane to the object.
    pub normal: Vector<T>,
    pub point: Vector<T>,
}

/// Normal force on a branch of the law.
#[inline(always)]
pub(crate) fn normal_force_on_branch(law: &NormalLaw, state: ContactState, delta: f64, rate: f64) -> NormalForce {
    match state {
        ContactState::Free | ContactState::Released => NormalForce::default(),
        ContactState::Active => unclamped_normal_force(law, delta, rate),
        ContactState::Clamped => normal_force(law, delta, rate),
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactForces<T, const K: usize> {
    pub normal: T,
    /// Power of the normal force and the friction force on both surfaces.
    pub power: T,
    /// Generalised loads on the K coordinates.
    pub load: [T; K],
    /// Contribution of the friction force to the rate of the internal state of the law.
    pub state_rate: T,
}

/// A number with its derivatives by the P positions of the contact geometry, the K rates, and the internal state of friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WithDerivatives<const P: usize, const K: usize> {
    pub value: f64,
    pub by_q: [f64; P],
    pub by_v: [f64; K],
    pub by_state: f64,
}

impl<const P: usize, const K: usize> Default for WithDerivatives<P, K> {
    fn default() -> Self {
        Self { value: 0.0, by_q: [0.0; P], by_v: [0.0; K], by_state: 0.0 }
    }
}

/// Normal force, friction, and rate of its internal state due to them, at a gap, gap rate, slip and state.
#[inline(always)]
fn normal_and_friction<T: Real>([gap, gap_rate, slip]: [T; 3], state: Option<T>, laws: ContactLaws<'_>) -> [T; 3] {
    let normal =
        normal_over_gap(|depth, speed| normal_force_on_branch(laws.normal, laws.state, depth, speed), gap, gap_rate);
    let Some(friction) = laws.friction else { return [normal, T::zero(), T::zero()] };
    let tangential = friction.force(slip, state, normal, laws.range);
    [normal, tangential, friction.state_rate(tangential)]
}

/// Forces of a contact at the rates `v`; `state` is `None` if friction has no internal state.
#[inline(always)]
pub(crate) fn contact_forces<const K: usize>(
    kinematics: &ContactKinematics<f64, K>,
    v: &[f64; K],
    state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<f64, K> {
    let (gap_rate, slip) = (row_dot(&kinematics.normal_row, v), row_dot(&kinematics.tangent_row, v));
    let [normal, tangential, state_rate] = normal_and_friction([kinematics.gap, gap_rate, slip], state, laws);
    ContactForces {
        normal,
        power: normal * gap_rate + tangential * slip,
        load: array_from(|k| kinematics.normal_row[k] * normal + kinematics.tangent_row[k] * tangential),
        state_rate,
    }
}

/// Like [`contact_forces`], with derivatives: those of the laws, combined with the rows by the chain rule.
#[inline(always)]
pub(crate) fn contact_forces_with_derivatives<const P: usize, const K: usize>(
    kinematics: &ContactKinematics<Dual<P>, K>,
    v: &[f64; K],
    state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, K>, K> {
    match state {
        None => differentiate_forces::<P, K, 3>(kinematics, v, None, laws),
        Some(state) => differentiate_forces::<P, K, 4>(kinematics, v, Some(state), laws),
    }
}

/// Differentiates with respect to the D variables of the laws: gap, gap rate, slip, and the internal state if D is 4.
#[inline(always)]
fn differentiate_forces<const P: usize, const K: usize, const D: usize>(
    kinematics: &ContactKinematics<Dual<P>, K>,
    v: &[f64; K],
    state: Option<f64>,
    laws: ContactLaws<'_>,
) -> ContactForces<WithDerivatives<P, K>, K> {
    let values = |row: &[Dual<P>; K]| array_from(|k| row[k].value);
    let (normal_row, tangent_row): ([f64; K], [f64; K]) =
        (values(&kinematics.normal_row), values(&kinematics.tangent_row));
    let rate = |row: &[Dual<P>; K]| (1..K).fold(row[0] * v[0], |sum, k| sum + row[k] * v[k]);
    let arguments = [kinematics.gap, rate(&kinematics.normal_row), rate(&kinematics.tangent_row)];
    let [gap, gap_rate, slip] = array_from(|i| Dual::<D>::variable(arguments[i].value, i));
    let [normal, tangential, state_rate] =
        normal_and_friction([gap, gap_rate, slip], state.map(|state| Dual::variable(state, D - 1)), laws);
    let with_derivatives = |force: Dual<D>| WithDerivatives {
        value: force.value,
        by_q: array_from(|j| (0..3).map(|i| force.grad[i] * arguments[i].grad[j]).sum()),
        by_v: array_from(|k| force.grad[1] * normal_row[k] + force.grad[2] * tangent_row[k]),
        by_state: if D > 3 { force.grad[D - 1] } else { 0.0 },
    };
    let (normal_force, friction) = (with_derivatives(normal), with_derivatives(tangential));
    let load = |k: usize| {
        let (n, t) = (kinematics.normal_row[k], kinematics.tangent_row[k]);
        WithDerivatives {
            value: n.value * normal.value + t.value * tangential.value,
            by_q: array_from(|j| {
                n.value * normal_force.by_q[j]
                    + t.value * friction.by_q[j]
                    + (n.grad[j] * normal.value + t.grad[j] * tangential.value)
            }),
            by_v: array_from(|j| n.value * normal_force.by_v[j] + t.value * friction.by_v[j]),
            by_state: t.value * friction.by_state,
        }
    };
    ContactForces {
        normal: normal_force,
        power: with_derivatives(normal * gap_rate + tangential * slip),
        load: array_from(load),
        state_rate: with_derivatives(state_rate),
    }
}
