//! Accelerations of a multibody system. Every finger and contact contributes in the few coordinates it depends on.

use super::components::{
    ContactLaws, ContactModel, ContactPair, DiscComponent, FingerComponent, SignedIndex, disc_indices,
    disc_pair_indices, disc_time_indices, finger_indices, phalanx_indices,
};
use super::contact_kinematics::{self, ContactKinematics};
use super::drive::{BrakeTorque, ShaftTorque};
use super::frame::{self, InertialField, disc_inertial_force};
use super::inertia::Inertia;
use super::model::Multibody;
use super::{FINGERS, mode, quadratures};
use crate::analytic::finger::FingerModel;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::gripper::FingerContact;
use crate::integrator::{Linearised, Rates, System};
use crate::numeric::Real;
use crate::scene::GripperContact;
use crate::shape::PlacedShape;

/// Sums of the loads on all coordinates and of the rates of all quadratures: plain numbers ([`Loads`]) or numbers with
/// derivatives. Both are filled by [`Multibody::add_loads`].
pub(super) trait LoadSums<const N: usize, const Z: usize> {
    /// Number that depends on the two angles of a finger.
    type Angles: Real;
    /// Number that depends on the P positions of a contact.
    type Positions<const P: usize>: Real;

    /// Whether the contacts of a grasp are written out, so that every index is a constant.
    const UNROLLED: bool;

    /// Index of the quadrature for the work of all contacts and brakes.
    const CONTACT_WORK: usize = Z - 2;
    /// Index of the quadrature for the work of motors, palm and driven discs.
    const DRIVE_WORK: usize = Z - 1;

    /// Position of a contact with this index; a constant for an index that is not below P.
    fn position<const P: usize>(value: f64, index: usize) -> Self::Positions<P>;

    /// Extends a number that depends on a finger's angles to all positions of a contact.
    fn widen<const P: usize>(number: Self::Angles) -> Self::Positions<P>;

    /// Adds the loads on the links of a finger, and returns its position-dependent terms.
    fn add_finger(&mut self, finger: usize, model: &FingerModel, state: ([f64; 2], [f64; 2])) -> Terms<Self::Angles>;

    /// Adds the inertial forces on a finger's links in a moving frame.
    fn add_finger_inertia(
        &mut self,
        finger: (usize, &FingerComponent),
        rates: [f64; 2],
        terms: &Terms<Self::Angles>,
        field: &InertialField,
    );

    /// Adds a contact with the coordinates `indices` at their rates; `bristle_state` is `None` without a bristle.
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        contact: ActiveContact<'_>,
        kinematics: &ContactKinematics<Self::Positions<P>, K>,
        state: (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    );

    /// Adds a torque that acts on the driven links of the first `fingers` fingers with these weights; `work` is the
    /// index of its quadrature.
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, driven: ([f64; FINGERS], usize), work: usize);

    /// Adds the rate of the bristle state of a brake, and the effect of that state on the brake's torque.
    fn add_brake_bristle(&mut self, brake: &BrakeTorque, driven: ([f64; FINGERS], usize), bristle: usize);

    /// Adds the work of the drive that prescribes a coordinate's motion against all loads on it: a driven disc
    /// (`is_disc`), or the table that moves with time.
    fn add_prescribed_work(&mut self, row: usize, rate: f64, is_disc: bool);

    /// Adds the decay of a bristle state.
    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64);

    /// Adds a constant force.
    fn add_force(&mut self, row: usize, force: f64);

    /// Adds the inertial forces on a disc in a moving frame.
    fn add_disc_inertia(&mut self, disc: &DiscComponent, pose: [f64; 3], rates: [f64; 3], field: &InertialField);
}

/// A contact with a force: its index, its data, and its laws.
pub(super) type ActiveContact<'a> = (usize, &'a ContactModel, ContactLaws<'a>);

/// Loads on all coordinates and rates of all quadratures.
struct Loads<const N: usize, const Z: usize> {
    load: [f64; N],
    g: [f64; Z],
}

impl<const N: usize, const Z: usize> LoadSums<N, Z> for Loads<N, Z> {
    type Angles = f64;
    type Positions<const P: usize> = f64;

    const UNROLLED: bool = true;

    #[inline(always)]
    fn position<const P: usize>(value: f64, _: usize) -> f64 {
        value
    }

    #[inline(always)]
    fn widen<const P: usize>(number: f64) -> f64 {
        number
    }

    #[inline(always)]
    fn add_finger(&mut self, finger: usize, model: &FingerModel, (q, v): ([f64; 2], [f64; 2])) -> Terms<f64> {
        let terms = model.terms(q);
        let load = model.load(0.0, &terms, v);
        (0..2).for_each(|i| self.load[2 * finger + i] += load[i]);
        terms
    }

    #[inline(always)]
    fn add_finger_inertia(
        &mut self,
        (finger, component): (usize, &FingerComponent),
        rates: [f64; 2],
        terms: &Terms<f64>,
        field: &InertialField,
    ) {
        let field = field.field.mirrored(component.side.mirror());
        let link_rates = absolute_rates(&terms.rates, rates);
        let inertial = component.inertial_load.forces(&terms.pose, &terms.rates, link_rates, &field);
        (0..2).for_each(|i| self.load[2 * finger + i] += inertial[i]);
        self.g[Self::DRIVE_WORK] += inertial[0] * rates[0] + inertial[1] * rates[1];
    }

    #[inline(always)]
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        (index, contact, laws): ActiveContact<'_>,
        kinematics: &ContactKinematics<f64, K>,
        (rates, bristle_state): (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    ) {
        let forces = contact_kinematics::contact_forces(kinematics, rates, bristle_state, laws);
        for (load, (row, sign)) in forces.load.iter().zip(indices) {
            if *row < N {
                self.load[*row] += sign * load;
            }
        }
        self.g[index] += forces.normal;
        self.g[Self::CONTACT_WORK] += forces.power;
        if let Some(bristle_index) = contact.bristle_index {
            self.load[bristle_index] += forces.bristle_rate;
        }
    }

    #[inline(always)]
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, (weights, fingers): ([f64; FINGERS], usize), work: usize) {
        (0..fingers).for_each(|finger| self.load[2 * finger] += weights[finger] * shaft.torque);
        self.g[work] += shaft.torque * shaft.rate;
    }

    #[inline(always)]
    fn add_brake_bristle(&mut self, brake: &BrakeTorque, _: ([f64; FINGERS], usize), bristle: usize) {
        self.load[bristle] += brake.bristle_rate;
    }

    #[inline(always)]
    fn add_prescribed_work(&mut self, row: usize, rate: f64, _: bool) {
        self.g[Self::DRIVE_WORK] -= self.load[row] * rate;
    }

    #[inline(always)]
    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64) {
        self.load[bristle] -= decay_rate * state;
    }

    #[inline(always)]
    fn add_force(&mut self, row: usize, force: f64) {
        self.load[row] += force;
    }

    #[inline(always)]
    fn add_disc_inertia(&mut self, disc: &DiscComponent, pose: [f64; 3], rates: [f64; 3], field: &InertialField) {
        let inertial = disc_inertial_force(disc, &field.field, pose, rates);
        (0..3).for_each(|i| self.load[disc.first_coordinate + i] += inertial[i]);
        self.g[Self::DRIVE_WORK] += (0..3).map(|i| inertial[i] * rates[i]).sum::<f64>();
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    /// Adds all loads and powers, and returns the mass matrices of the fingers. Both assemblies share it, so that the
    /// accelerations are the same with and without derivatives.
    #[inline(always)]
    pub(super) fn add_loads<const Z: usize, S: LoadSums<N, Z>>(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut S,
    ) -> [[S::Angles; 3]; FINGERS] {
        const { assert!(Z == quadratures(C)) };
        let field = self.inertial_field(t);
        let mut masses = [[S::Angles::zero(); 3]; FINGERS];
        if S::UNROLLED {
            if let Some(right) = self.fingers.first().filter(|_| !Self::DISCS) {
                masses[0] = self.add_finger_load((0, right), (q, v), (mode, &field), sums);
            }
            if let Some(left) = self.fingers.get(1).filter(|_| !Self::DISCS) {
                masses[1] = self.add_finger_load((1, left), (q, v), (mode, &field), sums);
            }
        } else {
            for (index, finger) in self.fingers.iter().enumerate().filter(|_| !Self::DISCS) {
                masses[index] = self.add_finger_load((index, finger), (q, v), (mode, &field), sums);
            }
        }
        let (driven_rates, fingers) = (self.driven_rates(v), self.finger_count());
        for (index, drive) in self.drives.iter().enumerate().filter(|_| !Self::DISCS) {
            let (driven, bristle_index) = ((drive.weights, fingers), self.brake_bristle(index));
            sums.add_shaft_torque(&drive.motor_torque(t, driven_rates), driven, S::DRIVE_WORK);
            let brake_torque = drive.brake_torque(t, driven_rates, bristle_index.map(|index| v[index]));
            let Some(brake) = brake_torque else { continue };
            sums.add_shaft_torque(&brake.shaft, driven, S::CONTACT_WORK);
            bristle_index.iter().for_each(|bristle| sums.add_brake_bristle(&brake, driven, *bristle));
        }
        if Self::GRASP && S::UNROLLED {
            self.add_disc_contact(GripperContact::Palm.index(), (q, v), mode, sums);
            self.add_disc_contact(GripperContact::Table.index(), (q, v), mode, sums);
        } else {
            for index in &self.disc_contacts {
                self.add_disc_contact(*index, (q, v), mode, sums);
            }
        }
        if let Some(time) = self.time_index.filter(|_| self.palm_moves()) {
            sums.add_prescribed_work(time, 1.0, false);
        }
        for &(index, bristle) in &self.bristles {
            sums.add_decay(index, bristle.rate(), v[index]);
        }
        for index in (0..self.disc_count()).filter(|index| self.first_coordinate(*index) < N) {
            let (disc, first, rates) = (&self.discs[index], self.first_coordinate(index), self.disc_rates(index, v));
            if disc.prescribed_acceleration.is_some() {
                (0..3).for_each(|i| sums.add_prescribed_work(first + i, rates[i], true));
                continue;
            }
            (0..2).for_each(|i| sums.add_force(first + i, disc.mass * self.gravity[i]));
            if self.palm_moves() {
                let disc = DiscComponent { first_coordinate: first, ..*disc };
                sums.add_disc_inertia(&disc, self.disc_pose(index, q), rates, &field);
            }
        }
        masses
    }

    /// Adds the loads on a finger and its contacts, and returns its mass matrix.
    #[inline(always)]
    fn add_finger_load<const Z: usize, S: LoadSums<N, Z>>(
        &self,
        (finger, component): (usize, &FingerComponent),
        (q, v): (&[f64; N], &[f64; N]),
        (mode, field): (&mode::Mode<C>, &InertialField),
        sums: &mut S,
    ) -> [S::Angles; 3] {
        let rates = Self::finger_coordinates(finger, v);
        let terms = sums.add_finger(finger, &component.model, (Self::finger_coordinates(finger, q), rates));
        if self.palm_moves() {
            sums.add_finger_inertia((finger, component), rates, &terms, field);
        }
        if Self::GRASP && S::UNROLLED {
            let first = FingerContact::ALL.len() * finger;
            self.add_finger_contact(first, (finger, component, &terms), (q, v), mode, sums);
            self.add_finger_contact(first + 1, (finger, component, &terms), (q, v), mode, sums);
            self.add_finger_contact(first + 2, (finger, component, &terms), (q, v), mode, sums);
        } else {
            for index in &component.contacts {
                self.add_finger_contact(*index, (finger, component, &terms), (q, v), mode, sums);
            }
        }
        terms.mass
    }

    /// Adds a contact of a finger. It depends on the finger's two angles and the centre of a disc, and on the disc's
    /// angle unless the disc is round.
    #[inline(always)]
    fn add_finger_contact<const Z: usize, S: LoadSums<N, Z>>(
        &self,
        index: usize,
        finger: (usize, &FingerComponent, &Terms<S::Angles>),
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut S,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.depends_on_disc_angle(self.contact_pair(finger.0, index, contact)) {
            false => self.add_active_finger_contact::<Z, S, 4>((index, contact, laws), finger, state, sums),
            true => self.add_active_finger_contact::<Z, S, 5>((index, contact, laws), finger, state, sums),
        }
    }

    #[inline(always)]
    pub(super) fn add_active_finger_contact<const Z: usize, S: LoadSums<N, Z>, const P: usize>(
        &self,
        active_contact: ActiveContact<'_>,
        (finger, component, terms): (usize, &FingerComponent, &Terms<S::Angles>),
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut S,
    ) {
        let (index, contact, _) = active_contact;
        let ([first, second], mirror) = (Self::finger_coordinates(finger, v), component.side.mirror());
        match self.contact_pair(finger, index, contact) {
            ContactPair::Phalanx { phalanx, disc, .. } => {
                let [vx, vy, spin] = self.disc_rates(disc, v);
                let object = self.disc_in_finger_frame(component.side, disc, q);
                let (pose, passive_rates) = (terms.pose.map(S::widen::<P>), terms.rates.map(S::widen::<P>));
                let placed = placed_positions::<N, Z, S, P>(&object, [2, 3, 4]);
                let geometry = component.model.phalanx_geometry(&pose, &passive_rates, phalanx, &placed);
                let rates = [first, second, mirror * vx, vy, mirror * spin];
                sums.add_contact::<P, 5>(
                    active_contact,
                    &contact_kinematics::phalanx(&geometry),
                    (&rates, self.bristle_state(contact, v)),
                    &phalanx_indices(finger, self.first_coordinate(disc), mirror),
                );
            }
            _ => {
                let (pose, passive_rates) = (terms.pose.map(S::widen::<2>), terms.rates.map(S::widen::<2>));
                let kinematics = contact_kinematics::limit(&component.model.limit_geometry(&pose, &passive_rates));
                sums.add_contact::<2, 2>(
                    active_contact,
                    &kinematics,
                    (&[first, second], None),
                    &finger_indices(finger),
                );
            }
        }
    }

    /// Adds a contact without a finger.
    #[inline(always)]
    fn add_disc_contact<const Z: usize, S: LoadSums<N, Z>>(
        &self,
        index: usize,
        state: (&[f64; N], &[f64; N]),
        mode: &mode::Mode<C>,
        sums: &mut S,
    ) {
        let Some(contact) = &self.contacts[index] else { return };
        let Some(laws) = contact.laws(mode[index]) else { return };
        match self.depends_on_disc_angle(contact.pair) {
            false => self.add_active_disc_contact::<Z, S, 4, 3, 2>((index, contact, laws), state, sums),
            true => self.add_active_disc_contact::<Z, S, 6, 4, 3>((index, contact, laws), state, sums),
        }
    }

    /// The const parameters are the numbers of positions that two discs, a disc and time, and a disc depend on.
    #[inline(always)]
    pub(super) fn add_active_disc_contact<
        const Z: usize,
        S: LoadSums<N, Z>,
        const DISC_PAIR: usize,
        const DISC_TIME: usize,
        const DISC: usize,
    >(
        &self,
        active_contact: ActiveContact<'_>,
        (q, v): (&[f64; N], &[f64; N]),
        sums: &mut S,
    ) {
        let (_, contact, _) = active_contact;
        let bristle_state = self.bristle_state(contact, v);
        let first_coordinate = |disc| self.first_coordinate(disc);
        match contact.pair {
            ContactPair::Discs { disc, other } if !Self::GRASP => {
                let ([vx, vy, spin], [wx, wy, other_spin]) = (self.disc_rates(disc, v), self.disc_rates(other, v));
                let kinematics = contact_kinematics::discs([
                    &placed_positions::<N, Z, S, DISC_PAIR>(&self.placed_disc(disc, q), [0, 1, 4]),
                    &placed_positions::<N, Z, S, DISC_PAIR>(&self.placed_disc(other, q), [2, 3, 5]),
                ]);
                let rates = [vx, vy, wx, wy, spin, other_spin];
                let indices = disc_pair_indices([disc, other].map(first_coordinate));
                sums.add_contact::<DISC_PAIR, 6>(active_contact, &kinematics, (&rates, bristle_state), &indices);
            }
            ContactPair::MovingPlane { disc, plane } if self.palm_moves() => {
                let ([vx, vy, spin], time) = (self.disc_rates(disc, v), self.time_index.unwrap_or(N));
                let placed = placed_positions::<N, Z, S, DISC_TIME>(&self.placed_disc(disc, q), [0, 1, 3]);
                let kinematics = frame::table(&plane, &self.pose(q), S::position::<DISC_TIME>(0.0, 2), &placed);
                let rates = [vx, vy, v[time], spin];
                let indices = disc_time_indices(first_coordinate(disc), time);
                sums.add_contact::<DISC_TIME, 4>(active_contact, &kinematics, (&rates, bristle_state), &indices);
            }
            ContactPair::Plane { disc, plane } => {
                let placed = placed_positions::<N, Z, S, DISC>(&self.placed_disc(disc, q), [0, 1, 2]);
                let kinematics = contact_kinematics::plane(&plane, &placed, self.shares_contact_point());
                let (rates, indices) = (self.disc_rates(disc, v), disc_indices(first_coordinate(disc)));
                sums.add_contact::<DISC, 3>(active_contact, &kinematics, (&rates, bristle_state), &indices);
            }
            _ => {}
        }
    }

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
    fn rates_inline<const Z: usize>(&self, t: f64, state: (&[f64; N], &[f64; N]), mode: &mode::Mode<C>) -> Rates<N, Z> {
        let mut sums = Loads { load: [0.0; N], g: [0.0; Z] };
        let masses = self.add_loads(t, state, mode, &mut sums);
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

/// Makes centre and angle of a disc positions of a contact with these indices.
#[inline(always)]
fn placed_positions<const N: usize, const Z: usize, S: LoadSums<N, Z>, const P: usize>(
    placed: &PlacedShape,
    [x, y, angle]: [usize; 3],
) -> PlacedShape<S::Positions<P>> {
    let PlacedShape { shape, centre_m, angle_rad } = *placed;
    let centre_m = [S::position(centre_m[0], x), S::position(centre_m[1], y)];
    PlacedShape { shape, centre_m, angle_rad: S::position(angle_rad, angle) }
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
