//! Kinematics and forces of the contacts, and the energies, in one state, without derivatives.

use super::components::{
    ContactModel, ContactPair, FingerComponent, ObjectComponent, ShaftTorque, SignedIndex, finger_indices,
    object_indices, object_time_indices, phalanx_indices, scatter,
};
use super::forces::{CONTACT_WORK, ContactWithLaws, DRIVE_WORK, LoadSums};
use super::frame::{Inertia, Inverse, inertial_force};
use super::model::{FingerTerms, Multibody};
use super::{FINGERS, GraspLayout, GraspMode, contact_kinematics, frame, normal_force_on_branch};
use crate::analytic::ContactState;
use crate::analytic::closed_form::{FingerKinematics, FingerModel, PassiveJoints};
use crate::analytic::contact::{
    ContactForces, ContactKinematics, ContactReading, Energies, Geometry, StateRef, WithDerivatives,
    contact_forces_with_derivatives, row_dot,
};
use crate::analytic::inertial_field::InertialField;
use crate::drive::BrakeTorque;
use crate::fivebar::dynamics::{AccelerationField, Terms, absolute_rates};
use crate::integrator::Linearised;
use crate::law::{FrictionRange, elastic_energy, friction_with_state};
use crate::numeric::plane::dot;
use crate::numeric::{Dual, Real, array_from, map_array, map_same_type};
use crate::shape::Support;

/// Pose of a finger with its passive rates, from its terms.
#[inline(always)]
pub(crate) fn kinematics_of(terms: &Terms<f64>) -> FingerKinematics {
    (terms.pose, terms.rates)
}

impl<const N: usize> Multibody<N> {
    /// Pose of a finger with its passive rates.
    #[inline(always)]
    pub(super) fn finger_kinematics(&self, finger: usize, q: &[f64; N]) -> FingerKinematics {
        self.fingers[finger].model.kinematics(Self::finger_coordinates(finger, q))
    }

    /// Kinematics of all fingers.
    #[inline(always)]
    pub(super) fn all_finger_kinematics(&self, q: &[f64; N]) -> [FingerKinematics; FINGERS] {
        [0, 1].map(|finger| self.finger_kinematics(finger, q))
    }

    /// Like [`Multibody::contact_kinematics`], but compiled only once, for callers that need it rarely.
    #[inline(never)]
    pub(super) fn contact_kinematics_noinline(
        &self,
        q: &[f64; N],
        finger_kinematics: &dyn Fn(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactKinematics<f64, N> {
        self.contact_kinematics(q, finger_kinematics, contact)
    }

    /// Kinematics of a contact, with rows over all coordinates.
    #[inline(always)]
    pub(super) fn contact_kinematics(
        &self,
        q: &[f64; N],
        finger_kinematics: impl FnOnce(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactKinematics<f64, N> {
        self.use_contact_kinematics(q, finger_kinematics, contact, Spread)
    }

    /// Like [`Multibody::contact_motion`], but compiled only once.
    #[inline(never)]
    pub(super) fn contact_motion_noinline(
        &self,
        state: StateRef<'_, GraspLayout<N>>,
        finger_kinematics: &dyn Fn(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactMotion {
        self.contact_motion(state, finger_kinematics, contact)
    }

    /// Gap and rates of a contact, without rows over all coordinates.
    #[inline(always)]
    pub(super) fn contact_motion(
        &self,
        (q, v): StateRef<'_, GraspLayout<N>>,
        finger_kinematics: impl FnOnce(usize) -> FingerKinematics,
        contact: &ContactModel,
    ) -> ContactMotion {
        self.use_contact_kinematics(q, finger_kinematics, contact, MotionAt(v))
    }

    #[inline(always)]
    fn use_contact_kinematics<U: KinematicsUser<N>>(
        &self,
        q: &[f64; N],
        finger_kinematics: impl FnOnce(usize) -> FingerKinematics,
        contact: &ContactModel,
        user: U,
    ) -> U::Output {
        match contact.pair {
            ContactPair::Phalanx { finger, phalanx } => {
                let component = &self.fingers[finger];
                let ((pose, rates), mirror) = (finger_kinematics(finger), component.side.mirror());
                let object = self.object_in_finger_frame(component.side, q);
                let geometry = component.model.phalanx_geometry(&pose, &rates, phalanx, &object);
                user.take(
                    &contact_kinematics::phalanx(&geometry),
                    &phalanx_indices(finger, self.object_coordinate(), mirror),
                )
            }
            ContactPair::Stop { finger } => {
                let (pose, rates) = finger_kinematics(finger);
                user.take(
                    &contact_kinematics::limit(&self.fingers[finger].model.limit_geometry(&pose, &rates)),
                    &finger_indices(finger),
                )
            }
            ContactPair::Plane(plane) => user.take(
                &contact_kinematics::plane(&plane, &self.placed_object(q)),
                &object_indices(self.object_coordinate()),
            ),
            ContactPair::MovingPlane(plane) => {
                let kinematics = frame::table(&plane, &self.pose(q), 0.0, &self.placed_object(q));
                user.take(&kinematics, &object_time_indices(self.object_coordinate(), self.time_index.unwrap_or(N)))
            }
        }
    }

    /// Position-dependent terms of all fingers, which the readings of one state share.
    pub(crate) fn terms(&self, q: &[f64; N]) -> FingerTerms {
        [0, 1].map(|finger| self.fingers[finger].model.terms(Self::finger_coordinates(finger, q)))
    }

    fn inertia(&self, terms: &FingerTerms) -> Inertia<'_, N> {
        Inertia::new(self, map_array(*terms, |terms| terms.mass))
    }

    /// Inverse of the mass matrix at these coordinates.
    pub(super) fn inverse(&self, q: &[f64; N]) -> Inverse<'_, N> {
        self.inertia(&self.terms(q)).inverse()
    }

    /// Evaluates one contact, with point and normal in the palm's frame; `None` where the scene has no such contact.
    ///
    /// Normals point out of the object. Slip and friction are positive along the normal turned counter-clockwise, also
    /// for a left phalanx; the signs of mirrored contacts differ.
    pub fn contact_reading(
        &self,
        q: &[f64; N],
        v: &[f64; N],
        index: usize,
        state: ContactState,
    ) -> Option<ContactReading> {
        self.reading_in_pose(&|finger| self.finger_kinematics(finger, q), (q, v), index, state)
    }

    /// [`Multibody::contact_reading`] with the kinematics of the fingers.
    pub(crate) fn reading_in_pose(
        &self,
        finger_kinematics: &dyn Fn(usize) -> FingerKinematics,
        (q, v): StateRef<'_, GraspLayout<N>>,
        index: usize,
        state: ContactState,
    ) -> Option<ContactReading> {
        let contact = self.contacts.get(index)?.as_ref()?;
        let kinematics = self.contact_motion_noinline((q, v), finger_kinematics, contact);
        let (delta, delta_rate, slip) = (-kinematics.gap, -kinematics.gap_rate, kinematics.slip);
        let normal = normal_force_on_branch(&contact.normal, state, delta, delta_rate).force.max(0.0);
        let friction = |law| friction_with_state(law, slip, self.bristle_state(contact, v), normal, FrictionRange::Any);
        let tangential = contact.friction.as_ref().map_or(0.0, friction);
        let none = [0.0; 2];
        let (mut sign, [x, y]) = (1.0, kinematics.normal);
        let (point, direction) = match contact.pair {
            ContactPair::Phalanx { finger, .. } => {
                let side = self.fingers[finger].side;
                sign = side.mirror();
                (self.point_in_palm_frame(side, kinematics.point), [sign * x, y])
            }
            ContactPair::Stop { finger } => {
                sign = self.fingers[finger].side.mirror();
                (none, [sign * x, y])
            }
            ContactPair::Plane(_) | ContactPair::MovingPlane(_) => {
                (kinematics.point, map_same_type(kinematics.normal, |component| -component))
            }
        };
        let geometry = Geometry {
            gap: kinematics.gap,
            normal_row: none,
            tangent_row: none,
            normal: direction,
            point,
            support: Support::none(),
        };
        Some(ContactReading { geometry, delta, delta_rate, slip: sign * slip, normal, tangential: sign * tangential })
    }

    /// Angles and rates of a finger's passive joints.
    pub(crate) fn passive_joints(
        &self,
        finger: usize,
        kinematics: &FingerKinematics,
        (q, v): StateRef<'_, GraspLayout<N>>,
    ) -> PassiveJoints {
        let [q, v] = [q, v].map(|all| Self::finger_coordinates(finger, all));
        self.fingers[finger].model.passive_joints(kinematics, q, v)
    }

    pub fn energies(&self, q: &[f64; N], v: &[f64; N]) -> Energies {
        let terms = self.terms(q);
        let gap = |index: usize| match &self.contacts[index] {
            Some(contact) => self.contact_motion_noinline((q, v), &|finger| kinematics_of(&terms[finger]), contact).gap,
            None => f64::INFINITY,
        };
        self.energies_in_pose(&terms, (q, v), gap)
    }

    /// [`Multibody::energies`] with the terms of the fingers and the gaps of the contacts.
    pub(crate) fn energies_in_pose(
        &self,
        terms: &FingerTerms,
        (q, v): StateRef<'_, GraspLayout<N>>,
        gap: impl Fn(usize) -> f64,
    ) -> Energies {
        let kinetic = self.inertia(terms).kinetic(v);
        let mut energies = Energies { elastic: self.bristle_energy(v), kinetic, ..Energies::default() };
        for (component, terms) in self.fingers.iter().zip(terms) {
            let [gravity, spring] = component.model.potential_energies(&terms.pose);
            energies.gravity += gravity;
            energies.spring += spring;
        }
        if let Some((_, object)) = self.moving_object() {
            let [x, y, _] = self.object_pose(q);
            energies.gravity -= object.mass * dot(self.gravity, [x, y]);
        }
        let contacts = self.contacts.iter().enumerate();
        for (index, contact) in contacts.filter_map(|(index, contact)| Some((index, contact.as_ref()?))) {
            energies.elastic += elastic_energy(&contact.normal, -gap(index));
        }
        energies
    }
}

/// Gap of a contact, its rate, slip, normal and point, as in [`ContactKinematics`].
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactMotion {
    pub gap: f64,
    pub gap_rate: f64,
    pub slip: f64,
    pub normal: [f64; 2],
    pub point: [f64; 2],
}

/// A use of the kinematics of a contact, whose number of coordinates depends on its pair.
trait KinematicsUser<const N: usize> {
    type Output;

    /// Takes the kinematics, with rows over the coordinates `indices`.
    fn take<const K: usize>(self, kinematics: &ContactKinematics<f64, K>, indices: &[SignedIndex; K]) -> Self::Output;
}

/// Expands rows to all coordinates.
struct Spread;

impl<const N: usize> KinematicsUser<N> for Spread {
    type Output = ContactKinematics<f64, N>;

    #[inline(always)]
    fn take<const K: usize>(
        self,
        kinematics: &ContactKinematics<f64, K>,
        indices: &[SignedIndex; K],
    ) -> ContactKinematics<f64, N> {
        let expand = |values: &[f64; K]| {
            let mut row = [0.0; N];
            scatter(&mut row, indices, values);
            row
        };
        let (normal_row, tangent_row) = (expand(&kinematics.normal_row), expand(&kinematics.tangent_row));
        let ContactKinematics { gap, normal, point, .. } = *kinematics;
        ContactKinematics { gap, normal_row, tangent_row, normal, point }
    }
}

/// Applies rows to rates.
struct MotionAt<'a, const N: usize>(&'a [f64; N]);

impl<const N: usize> KinematicsUser<N> for MotionAt<'_, N> {
    type Output = ContactMotion;

    #[inline(always)]
    fn take<const K: usize>(self, kinematics: &ContactKinematics<f64, K>, indices: &[SignedIndex; K]) -> ContactMotion {
        let rates = map_array(*indices, |(index, sign)| if index < N { sign * self.0[index] } else { 0.0 });
        let ContactKinematics { gap, normal, point, .. } = *kinematics;
        let (gap_rate, slip) = (row_dot(&kinematics.normal_row, &rates), row_dot(&kinematics.tangent_row, &rates));
        ContactMotion { gap, gap_rate, slip, normal, point }
    }
}

/// Loads on all coordinates, in place of accelerations, and rates of all quadratures, with their derivatives.
struct DerivativeSums<'a, const N: usize>(&'a mut Linearised<GraspLayout<N>>);

impl<const N: usize> DerivativeSums<'_, N> {
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
        let work = DRIVE_WORK;
        for i in 0..K {
            let row = first + i;
            self.0.rates.a[row] += force[i];
            self.0.a_t[row] += by_time[i];
            self.0.rates.g[work] += force[i] * rates[i];
            self.0.g_t[work] += by_time[i] * rates[i];
            self.0.g_v[work][row] += force[i];
            for j in 0..K {
                self.0.a_q[row][first + j] += by_q[i][j];
                self.0.a_v[row][first + j] += by_v[i][j];
                self.0.g_q[work][first + j] += by_q[i][j] * rates[i];
                self.0.g_v[work][first + j] += by_v[i][j] * rates[i];
            }
        }
    }
}

impl<const N: usize> LoadSums<N> for DerivativeSums<'_, N> {
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
            self.0.rates.a[row] += load.value;
            scatter(&mut self.0.a_q.0[row], &finger_indices(finger), &load.grad);
            scatter(&mut self.0.a_v.0[row], &finger_indices(finger), &by_rates);
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
        let mut by_rates = [[0.0; 2]; 2];
        if field.coriolis != 0.0 {
            for (unit, by_rate) in [[1.0, 0.0], [0.0, 1.0]].into_iter().zip(&mut by_rates) {
                *by_rate = map_array(forces(unit, &coriolis_field), |force| force.value);
            }
        }
        let by_v = array_from(|i| array_from(|j| by_rates[j][i]));
        let values = [force, force_rate].map(|force| map_array(force, |force| force.value));
        self.add_inertia(2 * finger, rates, values, [map_array(force, |force| force.grad), by_v]);
    }

    /// Not inlined, so that the derivatives of a contact are compiled once for each kind of contact.
    #[inline(never)]
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        (index, contact, laws): ContactWithLaws<'_>,
        kinematics: &ContactKinematics<Dual<P>, K>,
        (rates, bristle_state): (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    ) {
        let forces: ContactForces<WithDerivatives<P, K>, K> =
            contact_forces_with_derivatives(kinematics, rates, bristle_state, laws);
        let (bristle_index, contact_work) = (contact.bristle_index, CONTACT_WORK);
        for (load, (row, sign)) in forces.load.iter().zip(indices) {
            if *row < N {
                self.0.rates.a[*row] += sign * load.value;
                scatter(&mut self.0.a_q.0[*row], indices, &map_same_type(load.by_q, |derivative| sign * derivative));
                scatter(&mut self.0.a_v.0[*row], indices, &map_same_type(load.by_v, |derivative| sign * derivative));
                bristle_index.into_iter().for_each(|bristle| self.0.a_v[*row][bristle] += sign * load.by_bristle);
            }
        }
        if let Some(bristle) = bristle_index {
            self.0.rates.a[bristle] += forces.bristle_rate.value;
            scatter(&mut self.0.a_q.0[bristle], indices, &forces.bristle_rate.by_q);
            scatter(&mut self.0.a_v.0[bristle], indices, &forces.bristle_rate.by_v);
            self.0.a_v[bristle][bristle] += forces.bristle_rate.by_bristle;
            self.0.g_v[contact_work][bristle] += forces.power.by_bristle;
        }
        for (index, rate) in [(index, &forces.normal), (contact_work, &forces.power)] {
            self.0.rates.g[index] += rate.value;
            scatter(&mut self.0.g_q.0[index], indices, &rate.by_q);
            scatter(&mut self.0.g_v.0[index], indices, &rate.by_v);
        }
    }

    #[inline(always)]
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, weights: [f64; FINGERS], work: usize) {
        self.0.rates.g[work] += shaft.torque * shaft.rate;
        self.0.g_t[work] += shaft.by_time * shaft.rate;
        for (i, weight) in weights.into_iter().enumerate() {
            self.0.rates.a[2 * i] += weight * shaft.torque;
            self.0.a_t[2 * i] += weight * shaft.by_time;
            self.0.g_v[work][2 * i] += weight * (shaft.torque + shaft.by_rate * shaft.rate);
            (0..FINGERS).for_each(|j| self.0.a_v[2 * i][2 * j] += weight * weights[j] * shaft.by_rate);
        }
    }

    fn add_brake_bristle(
        &mut self,
        (shaft, brake): (&ShaftTorque, &BrakeTorque),
        weights: [f64; FINGERS],
        bristle: usize,
    ) {
        self.0.rates.a[bristle] += brake.gain * shaft.torque;
        self.0.a_t[bristle] += brake.gain * shaft.by_time;
        self.0.a_v[bristle][bristle] += brake.gain * brake.by_bristle;
        self.0.g_v[CONTACT_WORK][bristle] += brake.by_bristle * shaft.rate;
        for (i, weight) in weights.into_iter().enumerate() {
            self.0.a_v[2 * i][bristle] += weight * brake.by_bristle;
            self.0.a_v[bristle][2 * i] += weight * brake.gain * shaft.by_rate;
        }
    }

    fn add_table_work(&mut self, time: usize) {
        let work = DRIVE_WORK;
        self.0.rates.g[work] -= self.0.rates.a[time];
        for j in 0..N {
            self.0.g_q[work][j] -= self.0.a_q[time][j];
            self.0.g_v[work][j] -= self.0.a_v[time][j];
        }
    }

    #[inline(always)]
    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64) {
        self.0.rates.a[bristle] -= decay_rate * state;
        self.0.a_v[bristle][bristle] -= decay_rate;
    }

    #[inline(always)]
    fn loads(&mut self) -> &mut [f64; N] {
        &mut self.0.rates.a
    }

    /// The forces are linear in position and velocity; the moment depends on neither.
    fn add_object_inertia(
        &mut self,
        (first, object): (usize, &ObjectComponent),
        pose: [f64; 3],
        rates: [f64; 3],
        field: &InertialField,
    ) {
        let force = inertial_force(object, &field.field, pose, rates);
        let force_rate = inertial_force(object, &field.rate, pose, rates);
        let linear = AccelerationField { uniform: [0.0; 2], euler: field.field.euler, ..field.field };
        let unit = |j: usize| array_from(|k| if k == j { 1.0 } else { 0.0 });
        let (mut by_q, mut by_v) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for j in 0..2 {
            let by_position = inertial_force(object, &linear, unit(j), [0.0; 3]);
            let by_velocity = inertial_force(object, &linear, [0.0; 3], unit(j));
            (0..2).for_each(|i| (by_q[i][j], by_v[i][j]) = (by_position[i], by_velocity[i]));
        }
        self.add_inertia(first, rates, [force, force_rate], [by_q, by_v]);
    }
}

/// Position-dependent terms of a finger, and its load with derivatives with respect to its angles and its rates. Not
/// inlined, so that it is compiled once for all sizes of a hand.
#[inline(never)]
fn finger_terms(model: &FingerModel, (q, v): ([f64; 2], [f64; 2])) -> (Terms<Dual<2>>, [Dual<2>; 2], [[f64; 2]; 2]) {
    let terms = model.terms([Dual::variable(q[0], 0), Dual::variable(q[1], 1)]);
    let (load, by_rates) = model.load_with_derivatives(&terms, v);
    (terms, load, by_rates)
}

impl<const N: usize> Multibody<N> {
    /// Accelerations, and their derivatives with respect to coordinates, rates and time.
    pub(super) fn jacobian(
        &self,
        t: f64,
        state: StateRef<'_, GraspLayout<N>>,
        mode: &GraspMode,
        linearised: &mut Linearised<GraspLayout<N>>,
    ) {
        linearised.clear();
        let mut sums = DerivativeSums(linearised);
        let masses = self.add_loads(t, state, mode, &mut sums);
        let inverse = Inertia::new(self, map_array(masses, |mass| map_array(mass, |m| m.value))).inverse();
        let Linearised { rates, a_q, a_v, a_t, .. } = linearised;
        rates.a = inverse.solve(&rates.a);
        // From M a = load with M(q): M ∂a = ∂load − ∂M a.
        for (finger, mass) in masses.iter().enumerate() {
            let (first, second) = (2 * finger, 2 * finger + 1);
            for (k, j) in [first, second].into_iter().enumerate() {
                let [m, c, n] = [mass[0].grad[k], mass[1].grad[k], mass[2].grad[k]];
                a_q[first][j] -= m * rates.a[first] + c * rates.a[second];
                a_q[second][j] -= c * rates.a[first] + n * rates.a[second];
            }
        }
        inverse.solve_columns(&mut a_q.0);
        inverse.solve_columns(&mut a_v.0);
        *a_t = inverse.solve(a_t);
    }
}
