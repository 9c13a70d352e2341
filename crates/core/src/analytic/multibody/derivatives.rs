//! Accelerations with their exact Jacobian. Every finger and contact contributes derivatives in the few coordinates it
//! depends on.

use super::components::{DiscComponent, FingerComponent, SignedIndex, finger_indices, scatter};
use super::contact_kinematics::{ContactForces, ContactKinematics, WithDerivatives, contact_forces_with_derivatives};
use super::drive::{BrakeTorque, ShaftTorque};
use super::forces::{ActiveContact, LoadSums};
use super::frame::{InertialField, disc_inertial_force};
use super::inertia::Inertia;
use super::model::Multibody;
use super::{FINGERS, mode};
use crate::analytic::finger::FingerModel;
use crate::analytic::mode::StateRef;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::fivebar::inertial_forces::AccelerationField;
use crate::integrator::{Linearised, Rates};
use crate::numeric::{Dual, Real, array_from, map_array, map_same_type};

/// Loads on all coordinates and rates of all quadratures, with their derivatives.
struct DerivativeSums<const N: usize, const Z: usize> {
    load: [f64; N],
    load_q: [[f64; N]; N],
    load_v: [[f64; N]; N],
    load_t: [f64; N],
    g: [f64; Z],
    g_q: [[f64; N]; Z],
    g_v: [[f64; N]; Z],
    g_t: [f64; Z],
}

impl<const N: usize, const Z: usize> DerivativeSums<N, Z> {
    const ZERO: Self = Self {
        load: [0.0; N],
        load_q: [[0.0; N]; N],
        load_v: [[0.0; N]; N],
        load_t: [0.0; N],
        g: [0.0; Z],
        g_q: [[0.0; N]; Z],
        g_v: [[0.0; N]; Z],
        g_t: [0.0; Z],
    };

    /// Adds inertial forces on coordinates from `first` on, and their work, with their time derivatives and those by
    /// the same coordinates and their rates: `by_q[i][j]` is the derivative of force i by coordinate j.
    #[inline(always)]
    fn add_inertia<const K: usize>(
        &mut self,
        first: usize,
        rates: [f64; K],
        [force, by_time]: [[f64; K]; 2],
        [by_q, by_v]: [[[f64; K]; K]; 2],
    ) {
        let work = Self::DRIVE_WORK;
        for i in 0..K {
            let row = first + i;
            self.load[row] += force[i];
            self.load_t[row] += by_time[i];
            self.g[work] += force[i] * rates[i];
            self.g_t[work] += by_time[i] * rates[i];
            self.g_v[work][row] += force[i];
            for j in 0..K {
                self.load_q[row][first + j] += by_q[i][j];
                self.load_v[row][first + j] += by_v[i][j];
                self.g_q[work][first + j] += by_q[i][j] * rates[i];
                self.g_v[work][first + j] += by_v[i][j] * rates[i];
            }
        }
    }
}

impl<const N: usize, const Z: usize> LoadSums<N, Z> for DerivativeSums<N, Z> {
    type Angles = Dual<2>;
    type Positions<const P: usize> = Dual<P>;

    const UNROLLED: bool = false;

    #[inline(always)]
    fn position<const P: usize>(value: f64, index: usize) -> Dual<P> {
        if index < P { Dual::variable(value, index) } else { Dual::constant(value) }
    }

    #[inline(always)]
    fn widen<const P: usize>(number: Dual<2>) -> Dual<P> {
        number.widen()
    }

    #[inline(always)]
    fn add_finger(&mut self, finger: usize, model: &FingerModel, state: ([f64; 2], [f64; 2])) -> Terms<Dual<2>> {
        let (terms, load, by_rates) = finger_terms(model, state);
        for (i, (load, by_rates)) in load.iter().zip(by_rates).enumerate() {
            let row = 2 * finger + i;
            self.load[row] += load.value;
            scatter(&mut self.load_q[row], &finger_indices(finger), &load.grad);
            scatter(&mut self.load_v[row], &finger_indices(finger), &by_rates);
        }
        terms
    }

    fn add_finger_inertia(
        &mut self,
        (finger, component): (usize, &FingerComponent),
        rates: [f64; 2],
        terms: &Terms<Dual<2>>,
        field: &InertialField,
    ) {
        let [field, field_rate] = [field.field, field.rate].map(|field| field.mirrored(component.side.mirror()));
        let forces = |v: [f64; 2], field: &AccelerationField| {
            let rates = absolute_rates(&terms.rates, map_array(v, Dual::constant));
            component.inertial_load.forces(&terms.pose, &terms.rates, rates, field)
        };
        let (force, force_rate) = (forces(rates, &field), forces(rates, &field_rate));
        let coriolis_field = AccelerationField { coriolis: field.coriolis, ..AccelerationField::default() };
        let by_rates =
            map_array([[1.0, 0.0], [0.0, 1.0]], |unit| map_array(forces(unit, &coriolis_field), |force| force.value));
        let by_v = array_from(|i| array_from(|j| by_rates[j][i]));
        let values = [force, force_rate].map(|force| map_array(force, |force| force.value));
        self.add_inertia(2 * finger, rates, values, [map_array(force, |force| force.grad), by_v]);
    }

    /// Not inlined, so that the derivatives of a contact are compiled once for each kind of contact.
    #[inline(never)]
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        (index, contact, laws): ActiveContact<'_>,
        kinematics: &ContactKinematics<Dual<P>, K>,
        (rates, bristle_state): (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    ) {
        let forces: ContactForces<WithDerivatives<P, K>, K> =
            contact_forces_with_derivatives(kinematics, rates, bristle_state, laws);
        let (bristle_index, contact_work) = (contact.bristle_index, Self::CONTACT_WORK);
        for (load, (row, sign)) in forces.load.iter().zip(indices) {
            if *row < N {
                self.load[*row] += sign * load.value;
                scatter(&mut self.load_q[*row], indices, &map_same_type(load.by_q, |derivative| sign * derivative));
                scatter(&mut self.load_v[*row], indices, &map_same_type(load.by_v, |derivative| sign * derivative));
                bristle_index.into_iter().for_each(|bristle| self.load_v[*row][bristle] += sign * load.by_bristle);
            }
        }
        if let Some(bristle) = bristle_index {
            self.load[bristle] += forces.bristle_rate.value;
            scatter(&mut self.load_q[bristle], indices, &forces.bristle_rate.by_q);
            scatter(&mut self.load_v[bristle], indices, &forces.bristle_rate.by_v);
            self.load_v[bristle][bristle] += forces.bristle_rate.by_bristle;
            self.g_v[contact_work][bristle] += forces.power.by_bristle;
        }
        for (index, rate) in [(index, &forces.normal), (contact_work, &forces.power)] {
            self.g[index] += rate.value;
            scatter(&mut self.g_q[index], indices, &rate.by_q);
            scatter(&mut self.g_v[index], indices, &rate.by_v);
        }
    }

    #[inline(always)]
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, (weights, fingers): ([f64; FINGERS], usize), work: usize) {
        self.g[work] += shaft.torque * shaft.rate;
        self.g_t[work] += shaft.by_time * shaft.rate;
        for (i, weight) in weights.into_iter().enumerate().take(fingers) {
            self.load[2 * i] += weight * shaft.torque;
            self.load_t[2 * i] += weight * shaft.by_time;
            self.g_v[work][2 * i] += weight * (shaft.torque + shaft.by_rate * shaft.rate);
            (0..fingers).for_each(|j| self.load_v[2 * i][2 * j] += weight * weights[j] * shaft.by_rate);
        }
    }

    fn add_brake_bristle(&mut self, brake: &BrakeTorque, (weights, fingers): ([f64; FINGERS], usize), bristle: usize) {
        self.load[bristle] += brake.bristle_rate;
        self.load_t[bristle] += brake.gain * brake.shaft.by_time;
        self.load_v[bristle][bristle] += brake.gain * brake.by_bristle;
        self.g_v[Self::CONTACT_WORK][bristle] += brake.by_bristle * brake.shaft.rate;
        for (i, weight) in weights.into_iter().enumerate().take(fingers) {
            self.load_v[2 * i][bristle] += weight * brake.by_bristle;
            self.load_v[bristle][2 * i] += weight * brake.gain * brake.shaft.by_rate;
        }
    }

    fn add_prescribed_work(&mut self, row: usize, rate: f64, is_disc: bool) {
        let work = Self::DRIVE_WORK;
        self.g[work] -= self.load[row] * rate;
        for j in 0..N {
            self.g_q[work][j] -= self.load_q[row][j] * rate;
            self.g_v[work][j] -= self.load_v[row][j] * rate;
        }
        if is_disc {
            self.g_v[work][row] -= self.load[row];
        }
    }

    #[inline(always)]
    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64) {
        self.load[bristle] -= decay_rate * state;
        self.load_v[bristle][bristle] -= decay_rate;
    }

    #[inline(always)]
    fn loads(&mut self) -> &mut [f64; N] {
        &mut self.load
    }

    /// The forces are linear in position and velocity; the moment depends on neither.
    fn add_disc_inertia(&mut self, disc: &DiscComponent, pose: [f64; 3], rates: [f64; 3], field: &InertialField) {
        let force = disc_inertial_force(disc, &field.field, pose, rates);
        let force_rate = disc_inertial_force(disc, &field.rate, pose, rates);
        let linear = AccelerationField { uniform: [0.0; 2], euler: field.field.euler, ..field.field };
        let unit = |j: usize| array_from(|k| if k == j { 1.0 } else { 0.0 });
        let (mut by_q, mut by_v) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for j in 0..2 {
            let by_position = disc_inertial_force(disc, &linear, unit(j), [0.0; 3]);
            let by_velocity = disc_inertial_force(disc, &linear, [0.0; 3], unit(j));
            (0..2).for_each(|i| (by_q[i][j], by_v[i][j]) = (by_position[i], by_velocity[i]));
        }
        self.add_inertia(disc.first_coordinate, rates, [force, force_rate], [by_q, by_v]);
    }
}

/// Position-dependent terms of a finger, and its load with derivatives with respect to its angles and its rates. Not
/// inlined, so that it is compiled once for all sizes of a system.
#[inline(never)]
fn finger_terms(model: &FingerModel, (q, v): ([f64; 2], [f64; 2])) -> (Terms<Dual<2>>, [Dual<2>; 2], [[f64; 2]; 2]) {
    let terms = model.terms([Dual::variable(q[0], 0), Dual::variable(q[1], 1)]);
    let (load, by_rates) = model.load_with_derivatives(&terms, v);
    (terms, load, by_rates)
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Accelerations, and their derivatives with respect to coordinates, rates and time.
    pub(super) fn rates_with_derivatives<const Z: usize>(
        &self,
        t: f64,
        state: StateRef<'_, N>,
        mode: &mode::Mode<C>,
    ) -> Linearised<N, Z> {
        let mut sums = DerivativeSums::<N, Z>::ZERO;
        let masses = self.add_loads(t, state, mode, &mut sums);
        let inverse = Inertia::new(self, map_array(masses, |mass| map_array(mass, |m| m.value))).inverse();
        let mut a = inverse.solve(&sums.load);
        // From M a = load with M(q): M ∂a = ∂load − ∂M a.
        for (finger, mass) in masses.iter().enumerate().take(self.fingers.len()) {
            let (first, second) = (2 * finger, 2 * finger + 1);
            for (k, j) in [first, second].into_iter().enumerate() {
                let [m, c, n] = [mass[0].grad[k], mass[1].grad[k], mass[2].grad[k]];
                sums.load_q[first][j] -= m * a[first] + c * a[second];
                sums.load_q[second][j] -= c * a[first] + n * a[second];
            }
        }
        self.prescribe_disc_accelerations(&mut a);
        Linearised {
            rates: Rates { a, g: sums.g },
            a_q: inverse.solve_columns(&sums.load_q),
            a_v: inverse.solve_columns(&sums.load_v),
            a_t: inverse.solve(&sums.load_t),
            g_q: sums.g_q,
            g_v: sums.g_v,
            g_t: sums.g_t,
        }
    }
}
