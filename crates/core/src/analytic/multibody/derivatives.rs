//! Accelerations with their exact Jacobian. Every finger and contact contributes derivatives in the few coordinates it
//! depends on.

use super::active_contacts;
use super::components::{ContactModel, ContactPair, FingerComponent};
use super::contact_kinematics::{ContactForces, WithDerivatives};
use super::coordinates::{
    SignedIndex, disc_indices, disc_pair_indices, disc_time_indices, finger_indices, phalanx_indices, scatter,
};
use super::drive::ShaftTorque;
use super::frame::{InertialField, disc_inertial_force};
use super::inertia::Inertia;
use super::laws::ContactLaws;
use super::model::Multibody;
use super::{FINGERS, mode};
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

    /// Adds a contact whose coordinates are `indices`; its geometry depends on the first P of them.
    #[inline(always)]
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        (index, contact): (usize, &ContactModel),
        forces: &ContactForces<WithDerivatives<P, K>, K>,
        indices: &[SignedIndex; K],
    ) {
        let (bristle_index, contact_work) = (contact.bristle_index, Z - 2);
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

    /// Adds a torque that acts on the driven links of the first `fingers` fingers with these weights; `work` is the
    /// index of its quadrature.
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

    /// Adds the work of the drive that prescribes a coordinate's motion against all loads on it: a driven disc, or the
    /// table that moves with time.
    fn add_prescribed_work(&mut self, row: usize, rate: f64) {
        let work = Z - 1;
        self.g[work] -= self.load[row] * rate;
        for j in 0..N {
            self.g_q[work][j] -= self.load_q[row][j] * rate;
            self.g_v[work][j] -= self.load_v[row][j] * rate;
        }
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Accelerations, and their derivatives with respect to coordinates, rates and time.
    pub(super) fn rates_with_derivatives<const Z: usize>(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
    ) -> Linearised<N, Z> {
        let mut sums = DerivativeSums::<N, Z>::ZERO;
        let inertial_field = self.inertial_field(t);
        let mut masses = [[Dual::zero(); 3]; FINGERS];
        for (index, finger) in self.fingers.iter().enumerate().filter(|_| !Self::DISCS) {
            masses[index] = self.add_finger_derivatives((index, finger), (q, v), (mode, &inertial_field), &mut sums);
        }
        self.add_drive_derivatives(t, v, &mut sums);
        for index in &self.disc_contacts {
            self.add_disc_contact_derivatives(*index, (q, v), mode, &mut sums);
        }
        if let Some(time) = self.time_index.filter(|_| self.palm_moves()) {
            sums.add_prescribed_work(time, 1.0);
        }
        for &(index, bristle) in &self.bristles {
            sums.load[index] -= bristle.rate() * v[index];
            sums.load_v[index][index] -= bristle.rate();
        }
        for index in (0..self.disc_count()).filter(|index| self.first_coordinate(*index) < N) {
            let (disc, first) = (&self.discs[index], self.first_coordinate(index));
            if disc.prescribed_acceleration.is_some() {
                for (i, rate) in self.disc_rates(index, v).into_iter().enumerate() {
                    sums.add_prescribed_work(first + i, rate);
                    sums.g_v[Self::DRIVE_WORK][first + i] -= sums.load[first + i];
                }
                continue;
            }
            (0..2).for_each(|i| sums.load[first + i] += disc.mass * self.gravity[i]);
            if self.palm_moves() {
                self.add_disc_inertial_derivatives(index, (q, v), &inertial_field, &mut sums);
            }
        }
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

    /// Adds the loads on a finger and returns its mass matrix, with derivatives.
    #[inline(never)]
    fn add_finger_derivatives<const Z: usize>(
        &self,
        (index, component): (usize, &FingerComponent),
        (q, v): (&[f64; N], &[f64; N]),
        (mode, inertial_field): (&mode::Mode<C>, &InertialField),
        sums: &mut DerivativeSums<N, Z>,
    ) -> [Dual<2>; 3] {
        let finger_rates = Self::finger_coordinates(index, v);
        let (terms, load, by_rates) =
            active_contacts::finger_terms(&component.model, (Self::finger_coordinates(index, q), finger_rates));
        for (i, (load, by_rates)) in load.iter().zip(by_rates).enumerate() {
            let row = 2 * index + i;
            sums.load[row] += load.value;
            scatter(&mut sums.load_q[row], &finger_indices(index), &load.grad);
            scatter(&mut sums.load_v[row], &finger_indices(index), &by_rates);
        }
        if self.palm_moves() {
            self.add_finger_inertial_derivatives((index, component), finger_rates, &terms, inertial_field, sums);
        }
        for contact in &component.contacts {
            self.add_finger_contact_derivatives(*contact, (index, component, &terms), (q, v), mode, sums);
        }
        terms.mass
    }

    /// Adds a contact of a finger. It depends on the finger's two angles and the centre of a disc, and on the disc's
    /// angle unless the disc is round.
    #[inline(always)]
    fn add_finger_contact_derivatives<const Z: usize>(
        &self,
        index: usize,
        finger: (usize, &FingerComponent, &Terms<Dual<2>>),
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.depends_on_disc_angle(self.contact_pair(finger.0, index, contact)) {
            false => self.add_finger_contact_terms::<Z, 4>((index, contact, laws), finger, state, sums),
            true => self.add_finger_contact_terms::<Z, 5>((index, contact, laws), finger, state, sums),
        }
    }

    #[inline(never)]
    fn add_finger_contact_terms<const Z: usize, const P: usize>(
        &self,
        (index, contact, laws): (usize, &ContactModel, ContactLaws<'_>),
        (finger, component, terms): (usize, &FingerComponent, &Terms<Dual<2>>),
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let (finger_rates, mirror) = (Self::finger_coordinates(finger, v), component.side.mirror());
        match self.contact_pair(finger, index, contact) {
            ContactPair::Phalanx { phalanx, disc, .. } => {
                let [vx, vy, spin] = self.disc_rates(disc, v);
                let object = self.disc_in_finger_frame(component.side, disc, q);
                let rates = [finger_rates[0], finger_rates[1], mirror * vx, vy, mirror * spin];
                let contact_state = (terms, phalanx, &object);
                let forces = active_contacts::phalanx_on_object::<P>(
                    &component.model,
                    contact_state,
                    &rates,
                    self.bristle_state(contact, v),
                    laws,
                );
                sums.add_contact(
                    (index, contact),
                    &forces,
                    &phalanx_indices(finger, self.first_coordinate(disc), mirror),
                );
            }
            _ => {
                let forces = active_contacts::limit(&component.model, terms, &finger_rates, laws);
                sums.add_contact((index, contact), &forces, &finger_indices(finger));
            }
        }
    }

    /// Adds a contact without a finger.
    #[inline(always)]
    fn add_disc_contact_derivatives<const Z: usize>(
        &self,
        index: usize,
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.depends_on_disc_angle(contact.pair) {
            false => self.add_disc_contact_terms::<Z, 4, 3, 2>((index, contact, laws), state, sums),
            true => self.add_disc_contact_terms::<Z, 6, 4, 3>((index, contact, laws), state, sums),
        }
    }

    /// The const parameters are the numbers of positions that two discs, a disc and time, and a disc depend on.
    #[inline(never)]
    fn add_disc_contact_terms<
        const Z: usize,
        const DISC_PAIR_POSITIONS: usize,
        const DISC_TIME_POSITIONS: usize,
        const DISC_POSITIONS: usize,
    >(
        &self,
        (index, contact, laws): (usize, &ContactModel, ContactLaws<'_>),
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let bristle_state = self.bristle_state(contact, v);
        let disc_state = |disc: usize| (self.placed_disc(disc, q), self.disc_rates(disc, v));
        match contact.pair {
            ContactPair::Discs { disc, other } if !Self::GRASP => {
                let ((body, [vx, vy, spin]), (other_body, [wx, wy, other_spin])) =
                    (disc_state(disc), disc_state(other));
                let rates = [vx, vy, wx, wy, spin, other_spin];
                let forces =
                    active_contacts::discs::<DISC_PAIR_POSITIONS>([&body, &other_body], &rates, bristle_state, laws);
                sums.add_contact(
                    (index, contact),
                    &forces,
                    &disc_pair_indices([self.first_coordinate(disc), self.first_coordinate(other)]),
                );
            }
            ContactPair::MovingPlane { disc, plane } if self.palm_moves() => {
                let ((body, [vx, vy, spin]), time) = (disc_state(disc), self.time_index.unwrap_or(N));
                let (rates, pose) = ([vx, vy, v[time], spin], self.pose(q));
                let forces =
                    active_contacts::table::<DISC_TIME_POSITIONS>((&plane, &pose, &body), &rates, bristle_state, laws);
                sums.add_contact((index, contact), &forces, &disc_time_indices(self.first_coordinate(disc), time));
            }
            ContactPair::Plane { disc, plane } => {
                let (body, rates) = disc_state(disc);
                let on_plane = self.shares_contact_point();
                let forces =
                    active_contacts::plane::<DISC_POSITIONS>((&plane, &body, on_plane), &rates, bristle_state, laws);
                sums.add_contact((index, contact), &forces, &disc_indices(self.first_coordinate(disc)));
            }
            _ => {}
        }
    }

    /// Adds the inertial forces on a finger's links in a moving frame.
    fn add_finger_inertial_derivatives<const Z: usize>(
        &self,
        (finger, component): (usize, &FingerComponent),
        finger_rates: [f64; 2],
        terms: &Terms<Dual<2>>,
        inertial_field: &InertialField,
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let (inertial_load, first) = (&component.inertial_load, 2 * finger);
        let [field, rate] =
            [inertial_field.field, inertial_field.rate].map(|field| field.mirrored(component.side.mirror()));
        let forces = |v: [f64; 2], field: &AccelerationField| {
            let rates = absolute_rates(&terms.rates, map_array(v, Dual::constant));
            inertial_load.forces(&terms.pose, &terms.rates, rates, field)
        };
        let (force, force_rate) = (forces(finger_rates, &field), forces(finger_rates, &rate));
        let coriolis_field = AccelerationField { coriolis: field.coriolis, ..AccelerationField::default() };
        let by_rates =
            map_array([[1.0, 0.0], [0.0, 1.0]], |unit| map_array(forces(unit, &coriolis_field), |force| force.value));
        for i in 0..2 {
            let row = first + i;
            sums.load[row] += force[i].value;
            sums.load_t[row] += force_rate[i].value;
            sums.g[Self::DRIVE_WORK] += force[i].value * finger_rates[i];
            sums.g_t[Self::DRIVE_WORK] += force_rate[i].value * finger_rates[i];
            sums.g_v[Self::DRIVE_WORK][row] += force[i].value;
            for (j, by_rate) in by_rates.iter().enumerate() {
                sums.load_q[row][first + j] += force[i].grad[j];
                sums.load_v[row][first + j] += by_rate[i];
                sums.g_q[Self::DRIVE_WORK][first + j] += force[i].grad[j] * finger_rates[i];
                sums.g_v[Self::DRIVE_WORK][first + j] += by_rate[i] * finger_rates[i];
            }
        }
    }

    /// Adds the inertial forces on a disc in a moving frame, which are linear in its position and velocity.
    fn add_disc_inertial_derivatives<const Z: usize>(
        &self,
        index: usize,
        (q, v): (&[f64; N], &[f64; N]),
        inertial_field: &InertialField,
        sums: &mut DerivativeSums<N, Z>,
    ) {
        let (disc, pose, rates) = (&self.discs[index], self.disc_pose(index, q), self.disc_rates(index, v));
        let first = self.first_coordinate(index);
        let force = disc_inertial_force(disc, &inertial_field.field, pose, rates);
        let force_rate = disc_inertial_force(disc, &inertial_field.rate, pose, rates);
        let linear = AccelerationField { uniform: [0.0; 2], euler: inertial_field.field.euler, ..inertial_field.field };
        let unit = |j: usize| array_from(|k| if k == j { 1.0 } else { 0.0 });
        let (mut by_q, mut by_v) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for j in 0..2 {
            by_q[j] = disc_inertial_force(disc, &linear, unit(j), [0.0; 3]);
            by_v[j] = disc_inertial_force(disc, &linear, [0.0; 3], unit(j));
            // The moment depends on neither.
            (by_q[j][2], by_v[j][2]) = (0.0, 0.0);
        }
        for i in 0..3 {
            let row = first + i;
            sums.load[row] += force[i];
            sums.load_t[row] += force_rate[i];
            sums.g[Self::DRIVE_WORK] += force[i] * rates[i];
            sums.g_t[Self::DRIVE_WORK] += force_rate[i] * rates[i];
            sums.g_v[Self::DRIVE_WORK][row] += force[i];
            for j in 0..3 {
                sums.load_q[row][first + j] += by_q[j][i];
                sums.load_v[row][first + j] += by_v[j][i];
                sums.g_q[Self::DRIVE_WORK][first + j] += by_q[j][i] * rates[i];
                sums.g_v[Self::DRIVE_WORK][first + j] += by_v[j][i] * rates[i];
            }
        }
    }

    /// Adds the torques of motors and brakes.
    #[inline(always)]
    fn add_drive_derivatives<const Z: usize>(&self, t: f64, v: &[f64; N], sums: &mut DerivativeSums<N, Z>) {
        let (driven_rates, fingers) = (self.driven_rates(v), self.finger_count());
        for (index, drive) in self.drives.iter().enumerate().filter(|_| !Self::DISCS) {
            let bristle_index = self.brake_bristle(index);
            sums.add_shaft_torque(&drive.motor_torque(t, driven_rates), (drive.weights, fingers), Self::DRIVE_WORK);
            let Some(brake) = drive.brake_torque(t, driven_rates, bristle_index.map(|index| v[index])) else {
                continue;
            };
            sums.add_shaft_torque(&brake.shaft, (drive.weights, fingers), Self::CONTACT_WORK);
            let Some(bristle) = bristle_index else { continue };
            sums.load[bristle] += brake.bristle_rate;
            sums.load_t[bristle] += brake.gain * brake.shaft.by_time;
            sums.load_v[bristle][bristle] += brake.gain * brake.by_bristle;
            sums.g_v[Self::CONTACT_WORK][bristle] += brake.by_bristle * brake.shaft.rate;
            for (i, weight) in drive.weights.into_iter().enumerate().take(fingers) {
                sums.load_v[2 * i][bristle] += weight * brake.by_bristle;
                sums.load_v[bristle][2 * i] += weight * brake.gain * brake.shaft.by_rate;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analytic::multibody::model::angle_variables;
    use crate::analytic::multibody::quadratures;
    use crate::analytic::{ContactState, Mode};
    use crate::numeric::plane::{Vector, add, perp, scale};
    use crate::scene::{Scene, parse_any};

    const CONTACTS: usize = 10;
    type Model = Multibody<12, CONTACTS>;
    type AllSums = DerivativeSums<12, { quadratures(CONTACTS) }>;

    const SCENES: [&str; 2] = [
        include_str!("../../../../../scenes/gripper/lift.toml"),
        include_str!("../../../../../scenes/laws/two-free.toml"),
    ];

    fn scene(text: &str) -> Scene {
        parse_any(text, "scene.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    /// Contact forces and derivatives of round discs are the same with and without the disc's angle as a variable.
    #[test]
    fn contacts_of_round_shapes_do_not_depend_on_their_angle() {
        let mut compared = 0;
        for scene in SCENES.map(scene) {
            let model = Model::new(&scene.system);
            let start = model.start::<{ quadratures(CONTACTS) }>(&scene.system);
            let mode = Mode::from([ContactState::Active; CONTACTS]);
            for (index, contact) in model.contacts.iter().enumerate() {
                let Some(contact) = contact else { continue };
                let (mut q, mut v) = (start.q, start.v);
                (0..8).for_each(|i| v[i] += 0.1 * (i as f64 - 3.3));
                // The disc is moved into contact and turned.
                let Some((disc, position)) = placed_in_contact(&model, contact, &q) else { continue };
                let first = model.first_coordinate(disc);
                (q[first], q[first + 1], q[first + 2]) = (position[0], position[1], 0.3);
                let laws = contact.laws(mode[index]).expect("an active contact");
                let (mut without, mut with) = (AllSums::ZERO, AllSums::ZERO);
                let contact = (index, contact, laws);
                if let ContactPair::Phalanx { finger, .. } = contact.1.pair {
                    let terms =
                        model.fingers[finger].model.terms(angle_variables(Model::finger_coordinates(finger, &q)));
                    let finger_terms = (finger, &model.fingers[finger], &terms);
                    model.add_finger_contact_terms::<_, 4>(contact, finger_terms, (&q, &v), &mut without);
                    model.add_finger_contact_terms::<_, 5>(contact, finger_terms, (&q, &v), &mut with);
                } else {
                    model.add_disc_contact_terms::<_, 4, 3, 2>(contact, (&q, &v), &mut without);
                    model.add_disc_contact_terms::<_, 6, 4, 3>(contact, (&q, &v), &mut with);
                }
                assert!(without.g[index] != 0.0, "{:?} has no force", contact.1.pair);
                assert_eq!((without.load, without.g), (with.load, with.g));
                assert_eq!((without.load_q, without.load_v), (with.load_q, with.load_v));
                assert_eq!((without.g_q, without.g_v), (with.g_q, with.g_v));
                compared += 1;
            }
        }
        assert_eq!(compared, 7);
    }

    /// Returns a disc that moves, and the centre at which it overlaps the other surface by 1 µm.
    fn placed_in_contact(model: &Model, contact: &ContactModel, q: &[f64; 12]) -> Option<(usize, Vector<f64>)> {
        let radius = |disc: usize| crate::shape::max_radius(&model.discs[disc].shape) - 1e-6;
        match contact.pair {
            ContactPair::Stop { .. } => None,
            ContactPair::Phalanx { finger, phalanx, disc } => {
                let component = &model.fingers[finger];
                let object = model.disc_in_finger_frame(component.side, disc, q);
                let (pose, rates) = component.model.kinematics(Model::finger_coordinates(finger, q));
                let found = component.model.phalanx_geometry(&pose, &rates, phalanx, &object);
                let away = scale(found.normal, found.gap + 1e-6);
                Some((disc, model.point_in_palm_frame(component.side, add(object.centre_m, away))))
            }
            ContactPair::Discs { disc, other } => {
                let [x, y, _] = model.disc_pose(other, q);
                Some((disc, [x + radius(disc) + radius(other) + 1e-6, y]))
            }
            ContactPair::Plane { disc, plane } | ContactPair::MovingPlane { disc, plane } => {
                let level = scale(plane.normal, radius(disc) - plane.offset);
                Some((disc, add(level, scale(perp(plane.normal), 0.01))))
            }
        }
    }
}
