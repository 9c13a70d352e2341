//! Accelerations of a multibody system. Every finger and contact contributes in the few coordinates it depends on.

use super::components::{ContactModel, ContactPair, FingerComponent};
use super::contact_kinematics::{self, ContactForces};
use super::coordinates::{
    SignedIndex, disc_indices, disc_pair_indices, disc_time_indices, finger_indices, phalanx_indices,
};
use super::frame::{self, disc_inertial_force};
use super::inertia::Inertia;
use super::model::Multibody;
use super::{FINGERS, mode, quadratures};
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::fivebar::inertial_forces::AccelerationField;
use crate::gripper::FingerContact;
use crate::integrator::{Linearised, Rates, System};
use crate::scene::GripperContact;

/// Loads on all coordinates and rates of all quadratures.
struct LoadSums<const N: usize, const Z: usize> {
    load: [f64; N],
    g: [f64; Z],
}

impl<const N: usize, const Z: usize> LoadSums<N, Z> {
    /// Adds the forces of a contact whose coordinates are `indices`.
    #[inline(always)]
    fn add_contact<const K: usize>(
        &mut self,
        (index, contact): (usize, &ContactModel),
        forces: &ContactForces<f64, K>,
        indices: &[SignedIndex; K],
    ) {
        for (load, (row, sign)) in forces.load.iter().zip(indices) {
            if *row < N {
                self.load[*row] += sign * load;
            }
        }
        self.g[index] += forces.normal;
        self.g[Z - 2] += forces.power;
        if let Some(bristle_index) = contact.bristle_index {
            self.load[bristle_index] += forces.bristle_rate;
        }
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Index of the quadrature for the work of all contacts and brakes.
    pub(super) const CONTACT_WORK: usize = C;
    /// Index of the quadrature for the work of motors, palm and driven discs.
    pub(super) const DRIVE_WORK: usize = C + 1;

    /// Adds the loads on a finger and returns its mass matrix.
    #[inline(always)]
    fn add_finger_load<const Z: usize>(
        &self,
        (finger, component): (usize, &FingerComponent),
        (q, v): (&[f64; N], &[f64; N]),
        (mode, field): (&mode::Mode<C>, &AccelerationField),
        sums: &mut LoadSums<N, Z>,
    ) -> [f64; 3] {
        let finger_rates = Self::finger_coordinates(finger, v);
        let terms = component.model.terms(Self::finger_coordinates(finger, q));
        let load = component.model.load(0.0, &terms, finger_rates);
        (0..2).for_each(|i| sums.load[2 * finger + i] += load[i]);
        if self.palm_moves() {
            let rates = absolute_rates(&terms.rates, finger_rates);
            let field = field.mirrored(component.side.mirror());
            let inertial = component.inertial_load.forces(&terms.pose, &terms.rates, rates, &field);
            (0..2).for_each(|i| sums.load[2 * finger + i] += inertial[i]);
            sums.g[Self::DRIVE_WORK] += inertial[0] * finger_rates[0] + inertial[1] * finger_rates[1];
        }
        if Self::GRASP {
            let first = FingerContact::ALL.len() * finger;
            self.add_finger_contact_load(first, (finger, component, &terms), (q, v), mode, sums);
            self.add_finger_contact_load(first + 1, (finger, component, &terms), (q, v), mode, sums);
            self.add_finger_contact_load(first + 2, (finger, component, &terms), (q, v), mode, sums);
        } else {
            for index in &component.contacts {
                self.add_finger_contact_load(*index, (finger, component, &terms), (q, v), mode, sums);
            }
        }
        terms.mass
    }

    /// Adds a contact of a finger.
    #[inline(always)]
    fn add_finger_contact_load<const Z: usize>(
        &self,
        index: usize,
        (finger, component, terms): (usize, &FingerComponent, &Terms<f64>),
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut LoadSums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        let ([first, second], mirror) = (Self::finger_coordinates(finger, v), component.side.mirror());
        match self.contact_pair(finger, index, contact) {
            ContactPair::Phalanx { phalanx, disc, .. } => {
                let [vx, vy, spin] = self.disc_rates(disc, v);
                let object = self.disc_in_finger_frame(component.side, disc, q);
                let geometry = component.model.phalanx_geometry(&terms.pose, &terms.rates, phalanx, &object);
                let rates = [first, second, mirror * vx, vy, mirror * spin];
                let kinematics = contact_kinematics::phalanx(&geometry);
                let forces =
                    contact_kinematics::contact_forces(&kinematics, &rates, self.bristle_state(contact, v), laws);
                sums.add_contact(
                    (index, contact),
                    &forces,
                    &phalanx_indices(finger, self.first_coordinate(disc), mirror),
                );
            }
            _ => {
                let kinematics = contact_kinematics::limit(&component.model.limit_geometry(&terms.pose, &terms.rates));
                sums.add_contact(
                    (index, contact),
                    &contact_kinematics::contact_forces(&kinematics, &[first, second], None, laws),
                    &finger_indices(finger),
                );
            }
        }
    }

    /// Adds a contact without a finger.
    #[inline(always)]
    fn add_disc_contact_load<const Z: usize>(
        &self,
        index: usize,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut LoadSums<N, Z>,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        let bristle_state = self.bristle_state(contact, v);
        let disc_state = |disc: usize| (self.placed_disc(disc, q), self.disc_rates(disc, v));
        match contact.pair {
            ContactPair::Discs { disc, other } if !Self::GRASP => {
                let ((body, [vx, vy, spin]), (other_body, [wx, wy, other_spin])) =
                    (disc_state(disc), disc_state(other));
                let kinematics = contact_kinematics::discs([&body, &other_body]);
                let forces = contact_kinematics::contact_forces(
                    &kinematics,
                    &[vx, vy, wx, wy, spin, other_spin],
                    bristle_state,
                    laws,
                );
                sums.add_contact(
                    (index, contact),
                    &forces,
                    &disc_pair_indices([self.first_coordinate(disc), self.first_coordinate(other)]),
                );
            }
            ContactPair::MovingPlane { disc, plane } if self.palm_moves() => {
                let ((body, [vx, vy, spin]), time) = (disc_state(disc), self.time_index.unwrap_or(N));
                let kinematics = frame::table(&plane, &self.pose(q), 0.0, &body);
                let forces =
                    contact_kinematics::contact_forces(&kinematics, &[vx, vy, v[time], spin], bristle_state, laws);
                sums.add_contact((index, contact), &forces, &disc_time_indices(self.first_coordinate(disc), time));
            }
            ContactPair::Plane { disc, plane } => {
                let (body, rates) = disc_state(disc);
                let kinematics = contact_kinematics::plane(&plane, &body, self.shares_contact_point());
                sums.add_contact(
                    (index, contact),
                    &contact_kinematics::contact_forces(&kinematics, &rates, bristle_state, laws),
                    &disc_indices(self.first_coordinate(disc)),
                );
            }
            _ => {}
        }
    }
}

impl<const N: usize, const C: usize, const Z: usize> System<N, Z> for Multibody<N, C> {
    type Mode = mode::Mode<C>;

    #[inline(always)]
    fn coordinate_count(&self) -> usize {
        self.coordinate_count()
    }

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Rates<N, Z> {
        if Self::GRASP { self.rates_inline(t, (q, v), mode) } else { self.rates_noinline(t, (q, v), mode) }
    }

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &mode::Mode<C>) -> Linearised<N, Z> {
        self.rates_with_derivatives(t, (q, v), mode)
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Accelerations as one function, which is not inlined into every integrator. Only grasps, which studies simulate
    /// by the thousand, are worth the compile time of inlining.
    #[inline(never)]
    fn rates_noinline<const Z: usize>(
        &self,
        t: f64,
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
    ) -> Rates<N, Z> {
        self.rates_inline(t, state, mode)
    }

    #[inline(always)]
    fn rates_inline<const Z: usize>(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
    ) -> Rates<N, Z> {
        const { assert!(Z == quadratures(C)) };
        let mut sums = LoadSums { load: [0.0; N], g: [0.0; Z] };
        let field = self.inertial_field(t).field;
        let mut masses = [[0.0; 3]; FINGERS];
        // Both fingers are written out, so that every index is a constant.
        if let Some(right) = self.fingers.first().filter(|_| !Self::DISCS) {
            masses[0] = self.add_finger_load((0, right), (q, v), (mode, &field), &mut sums);
        }
        if let Some(left) = self.fingers.get(1).filter(|_| !Self::DISCS) {
            masses[1] = self.add_finger_load((1, left), (q, v), (mode, &field), &mut sums);
        }
        let driven_rates = self.driven_rates(v);
        for (index, drive) in self.drives.iter().enumerate().filter(|_| !Self::DISCS) {
            let (motor, bristle_index) = (drive.motor_torque(t, driven_rates), self.brake_bristle(index));
            (0..self.finger_count()).for_each(|finger| sums.load[2 * finger] += drive.weights[finger] * motor.torque);
            sums.g[Self::DRIVE_WORK] += motor.torque * motor.rate;
            let Some(brake) = drive.brake_torque(t, driven_rates, bristle_index.map(|index| v[index])) else {
                continue;
            };
            let brake_torque = brake.shaft.torque;
            (0..self.finger_count()).for_each(|finger| sums.load[2 * finger] += drive.weights[finger] * brake_torque);
            sums.g[Self::CONTACT_WORK] += brake.shaft.torque * brake.shaft.rate;
            bristle_index.iter().for_each(|index| sums.load[*index] += brake.bristle_rate);
        }
        if Self::GRASP {
            self.add_disc_contact_load(GripperContact::Palm.index(), (q, v), mode, &mut sums);
            self.add_disc_contact_load(GripperContact::Table.index(), (q, v), mode, &mut sums);
        } else {
            for index in &self.disc_contacts {
                self.add_disc_contact_load(*index, (q, v), mode, &mut sums);
            }
        }
        if let Some(time) = self.time_index.filter(|_| self.palm_moves()) {
            // The table, which moves in the palm's frame, does work on the system.
            sums.g[Self::DRIVE_WORK] -= sums.load[time];
        }
        for &(index, bristle) in &self.bristles {
            sums.load[index] -= bristle.rate() * v[index];
        }
        for index in (0..self.disc_count()).filter(|index| self.first_coordinate(*index) < N) {
            let (disc, first, rates) = (&self.discs[index], self.first_coordinate(index), self.disc_rates(index, v));
            if disc.prescribed_acceleration.is_some() {
                // The drive of the disc works against all contact forces; no other load acts on it.
                (0..3).for_each(|i| sums.g[Self::DRIVE_WORK] -= sums.load[first + i] * rates[i]);
                continue;
            }
            (0..2).for_each(|i| sums.load[first + i] += disc.mass * self.gravity[i]);
            if self.palm_moves() {
                let inertial = disc_inertial_force(disc, &field, self.disc_pose(index, q), rates);
                (0..3).for_each(|i| sums.load[first + i] += inertial[i]);
                sums.g[Self::DRIVE_WORK] += (0..3).map(|i| inertial[i] * rates[i]).sum::<f64>();
            }
        }
        let mut a = Inertia::new(self, masses).inverse().solve(&sums.load);
        self.prescribe_disc_accelerations(&mut a);
        Rates { a, g: sums.g }
    }

    /// Sets the accelerations of driven discs.
    #[inline(always)]
    pub(super) fn prescribe_disc_accelerations(&self, a: &mut [f64; N]) {
        for (first, acceleration) in
            self.discs.iter().filter_map(|disc| Some((disc.first_coordinate, disc.prescribed_acceleration?)))
        {
            a[first..first + 2].copy_from_slice(&acceleration);
        }
    }
}
