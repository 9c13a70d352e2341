//! Accelerations of a hand. Every finger and contact contributes in the few coordinates it depends on.

use super::components::{
    ContactModel, ContactPair, FingerComponent, ObjectComponent, ShaftTorque, SignedIndex, finger_indices,
    object_indices, object_time_indices, phalanx_indices,
};
use super::frame::{Inertia, inertial_force};
use super::model::{FingerTerms, Multibody};
use super::{CONTACTS, FINGERS, GraspLayout, GraspMode, QUADRATURES, contact_kinematics, frame};
use crate::analytic::closed_form::FingerModel;
use crate::analytic::contact::{ContactKinematics, ContactLaws, StateRef, contact_forces};
use crate::analytic::inertial_field::InertialField;
use crate::drive::BrakeTorque;
use crate::fivebar::dynamics::{Terms, absolute_rates};
use crate::gripper::FingerContact;
use crate::integrator::{Fixed, Linearised, Rates, State, System};
use crate::numeric::Real;
use crate::scene::HandContact;
use crate::shape::PlacedShape;

/// Index of the quadrature for the work of all contacts and brakes.
pub(super) const CONTACT_WORK: usize = CONTACTS;
/// Index of the quadrature for the work of motors and palm.
pub(super) const DRIVE_WORK: usize = CONTACTS + 1;

/// Sums of all loads and quadrature rates, plain ([`Loads`]) or with derivatives, which [`Assembly`] fills.
pub(super) trait LoadSums<const N: usize> {
    /// Number that depends on the two angles of a finger.
    type Angles: Real;
    /// Number that depends on the P positions of a contact.
    type Positions<const P: usize>: Real;

    /// Whether the contacts of a grasp are written out, so that every index is a constant.
    const UNROLLED: bool;

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
        contact: ContactWithLaws<'_>,
        kinematics: &ContactKinematics<Self::Positions<P>, K>,
        state: (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    );

    /// Adds a torque on the driven links with these weights; `work` indexes its quadrature.
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, weights: [f64; FINGERS], work: usize);

    /// Adds the rate of the bristle state of a brake, and the effect of that state on the brake's torque.
    fn add_brake_bristle(&mut self, brake: (&ShaftTorque, &BrakeTorque), weights: [f64; FINGERS], bristle: usize);

    /// Adds the work of the palm's drive against the loads on the table, which moves with the coordinate `time`.
    fn add_table_work(&mut self, time: usize);

    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64);

    /// Loads without derivatives.
    fn loads(&mut self) -> &mut [f64; N];

    /// Adds the inertial forces on the object, with its first coordinate, in a moving frame.
    fn add_object_inertia(
        &mut self,
        object: (usize, &ObjectComponent),
        pose: [f64; 3],
        rates: [f64; 3],
        field: &InertialField,
    );
}

/// A contact with a force: its index, its data, and its laws.
pub(super) type ContactWithLaws<'a> = (usize, &'a ContactModel, ContactLaws<'a>);

/// Loads on all coordinates and rates of all quadratures.
struct Loads<'a, const N: usize> {
    load: [f64; N],
    g: [f64; QUADRATURES],
    /// Terms of the fingers, if they are already evaluated.
    terms: Option<&'a FingerTerms>,
}

impl<const N: usize> LoadSums<N> for Loads<'_, N> {
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
        let terms = self.terms.map_or_else(|| model.terms(q), |terms| terms[finger]);
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
        self.g[DRIVE_WORK] += inertial[0] * rates[0] + inertial[1] * rates[1];
    }

    #[inline(always)]
    fn add_contact<const P: usize, const K: usize>(
        &mut self,
        (index, contact, laws): ContactWithLaws<'_>,
        kinematics: &ContactKinematics<f64, K>,
        (rates, bristle_state): (&[f64; K], Option<f64>),
        indices: &[SignedIndex; K],
    ) {
        let forces = contact_forces(kinematics, rates, bristle_state, laws);
        for (load, (row, sign)) in forces.load.iter().zip(indices) {
            if *row < N {
                self.load[*row] += sign * load;
            }
        }
        self.g[index] += forces.normal;
        self.g[CONTACT_WORK] += forces.power;
        if let Some(bristle_index) = contact.bristle_index {
            self.load[bristle_index] += forces.bristle_rate;
        }
    }

    #[inline(always)]
    fn add_shaft_torque(&mut self, shaft: &ShaftTorque, weights: [f64; FINGERS], work: usize) {
        (0..FINGERS).for_each(|finger| self.load[2 * finger] += weights[finger] * shaft.torque);
        self.g[work] += shaft.torque * shaft.rate;
    }

    #[inline(always)]
    fn add_brake_bristle(&mut self, (shaft, brake): (&ShaftTorque, &BrakeTorque), _: [f64; FINGERS], bristle: usize) {
        self.load[bristle] += brake.gain * shaft.torque;
    }

    #[inline(always)]
    fn add_table_work(&mut self, time: usize) {
        self.g[DRIVE_WORK] -= self.load[time];
    }

    #[inline(always)]
    fn add_decay(&mut self, bristle: usize, decay_rate: f64, state: f64) {
        self.load[bristle] -= decay_rate * state;
    }

    #[inline(always)]
    fn loads(&mut self) -> &mut [f64; N] {
        &mut self.load
    }

    #[inline(always)]
    fn add_object_inertia(
        &mut self,
        (first, object): (usize, &ObjectComponent),
        pose: [f64; 3],
        rates: [f64; 3],
        field: &InertialField,
    ) {
        let inertial = inertial_force(object, &field.field, pose, rates);
        (0..3).for_each(|i| self.load[first + i] += inertial[i]);
        self.g[DRIVE_WORK] += (0..3).map(|i| inertial[i] * rates[i]).sum::<f64>();
    }
}

/// Positions that the geometry of a contact depends on: of a phalanx and the object (q11, q21, x, y), of the object and a
/// moving table (x, y, t), and of the object. The object is round, so that its angle, which comes last, does not matter.
const PHALANX_POSITIONS: usize = 4;
const OBJECT_TIME_POSITIONS: usize = 3;
const OBJECT_POSITIONS: usize = 2;

/// Adds the loads of a hand in one state to sums.
struct Assembly<'a, const N: usize, S: LoadSums<N>> {
    model: &'a Multibody<N>,
    q: &'a [f64; N],
    v: &'a [f64; N],
    mode: &'a GraspMode,
    field: InertialField,
    sums: &'a mut S,
}

impl<const N: usize, S: LoadSums<N>> Assembly<'_, N, S> {
    /// Adds all loads and powers, and returns the mass matrices of the fingers.
    #[inline(always)]
    fn add_all(&mut self, t: f64) -> [[S::Angles; 3]; FINGERS] {
        let Self { model, q, v, .. } = *self;
        let mut masses = [[S::Angles::zero(); 3]; FINGERS];
        if S::UNROLLED {
            masses[0] = self.add_finger(0, &model.fingers[0]);
            masses[1] = self.add_finger(1, &model.fingers[1]);
        } else {
            for (index, finger) in model.fingers.iter().enumerate() {
                masses[index] = self.add_finger(index, finger);
            }
        }
        let driven_rates = model.driven_rates(v);
        for (index, drive) in model.drives.iter().enumerate() {
            let (driven, bristle_index) = (drive.weights, model.brake_bristle(index));
            self.sums.add_shaft_torque(&drive.motor_torque(t, driven_rates), driven, DRIVE_WORK);
            let brake_torque = drive.brake_torque(t, driven_rates, bristle_index.map(|index| v[index]));
            let Some((shaft, brake)) = brake_torque else { continue };
            self.sums.add_shaft_torque(&shaft, driven, CONTACT_WORK);
            bristle_index.iter().for_each(|bristle| self.sums.add_brake_bristle((&shaft, &brake), driven, *bristle));
        }
        if S::UNROLLED {
            self.add_plane_contact(HandContact::Palm.index());
            self.add_plane_contact(HandContact::Table.index());
        } else {
            [HandContact::Palm, HandContact::Table].iter().for_each(|contact| self.add_plane_contact(contact.index()));
        }
        if let Some(time) = model.time_index.filter(|_| model.palm_moves()) {
            self.sums.add_table_work(time);
        }
        for &(index, bristle) in &model.bristles {
            self.sums.add_decay(index, bristle.rate(), v[index]);
        }
        if let Some((first, object)) = model.moving_object() {
            (0..2).for_each(|i| self.sums.loads()[first + i] += object.mass * model.gravity[i]);
            if model.palm_moves() {
                let (pose, rates) = (model.object_pose(q), model.object_rates(v));
                self.sums.add_object_inertia((first, object), pose, rates, &self.field);
            }
        }
        masses
    }

    /// Adds the loads on a finger and its contacts, and returns its mass matrix.
    #[inline(always)]
    fn add_finger(&mut self, finger: usize, component: &FingerComponent) -> [S::Angles; 3] {
        let [angles, rates] = [self.q, self.v].map(|all| Multibody::<N>::finger_coordinates(finger, all));
        let terms = self.sums.add_finger(finger, &component.model, (angles, rates));
        if self.model.palm_moves() {
            self.sums.add_finger_inertia((finger, component), rates, &terms, &self.field);
        }
        let first = FingerContact::ALL.len() * finger;
        if S::UNROLLED {
            self.add_finger_contact(first, (finger, component, &terms));
            self.add_finger_contact(first + 1, (finger, component, &terms));
            self.add_finger_contact(first + 2, (finger, component, &terms));
        } else {
            (first..first + 3).for_each(|index| self.add_finger_contact(index, (finger, component, &terms)));
        }
        terms.mass
    }

    #[inline(always)]
    fn add_finger_contact(&mut self, index: usize, data: (usize, &FingerComponent, &Terms<S::Angles>)) {
        const P: usize = PHALANX_POSITIONS;
        let (finger, component, terms) = data;
        let Self { model, q, v, mode, .. } = *self;
        let Some(contact) = &model.contacts[index] else { return };
        let Some(laws) = contact.laws(mode, index) else { return };
        let ([first, second], mirror) = (Multibody::<N>::finger_coordinates(finger, v), component.side.mirror());
        if let ContactPair::Phalanx { phalanx, .. } = model.contact_pair(finger, index, contact) {
            let [vx, vy, spin] = model.object_rates(v);
            let (pose, passive_rates) = (terms.pose.map(S::widen::<P>), terms.rates.map(S::widen::<P>));
            let object = placed_positions::<N, S, P>(&model.object_in_finger_frame(component.side, q), [2, 3, 4]);
            let geometry = component.model.phalanx_geometry(&pose, &passive_rates, phalanx, &object);
            let rates = [first, second, mirror * vx, vy, mirror * spin];
            self.sums.add_contact::<P, 5>(
                (index, contact, laws),
                &contact_kinematics::phalanx(&geometry),
                (&rates, model.bristle_state(contact, v)),
                &phalanx_indices(finger, model.object_coordinate(), mirror),
            );
        } else {
            let (pose, passive_rates) = (terms.pose.map(S::widen::<2>), terms.rates.map(S::widen::<2>));
            let kinematics = contact_kinematics::limit(&component.model.limit_geometry(&pose, &passive_rates));
            let (state, indices) = ((&[first, second], None), finger_indices(finger));
            self.sums.add_contact::<2, 2>((index, contact, laws), &kinematics, state, &indices);
        }
    }

    /// Adds a contact of the object with palm or table.
    #[inline(always)]
    fn add_plane_contact(&mut self, index: usize) {
        let Self { model, q, v, mode, .. } = *self;
        let Some(contact) = &model.contacts[index] else { return };
        let Some(laws) = contact.laws(mode, index) else { return };
        let (active_contact, bristle_state) = ((index, contact, laws), model.bristle_state(contact, v));
        let (first, [vx, vy, spin]) = (model.object_coordinate(), model.object_rates(v));
        match contact.pair {
            ContactPair::MovingPlane(plane) if model.palm_moves() => {
                const P: usize = OBJECT_TIME_POSITIONS;
                let time = model.time_index.unwrap_or(N);
                let placed = placed_positions::<N, S, P>(&model.placed_object(q), [0, 1, 3]);
                let kinematics = frame::table(&plane, &model.pose(q), S::position::<P>(0.0, 2), &placed);
                let (rates, indices) = ([vx, vy, v[time], spin], object_time_indices(first, time));
                self.sums.add_contact::<P, 4>(active_contact, &kinematics, (&rates, bristle_state), &indices);
            }
            ContactPair::Plane(plane) => {
                const P: usize = OBJECT_POSITIONS;
                let placed = placed_positions::<N, S, P>(&model.placed_object(q), [0, 1, 2]);
                let (kinematics, rates) = (contact_kinematics::plane(&plane, &placed), [vx, vy, spin]);
                let indices = object_indices(first);
                self.sums.add_contact::<P, 3>(active_contact, &kinematics, (&rates, bristle_state), &indices);
            }
            _ => {}
        }
    }
}

impl<const N: usize> Multibody<N> {
    /// Adds all loads and powers, and returns the mass matrices of the fingers. Both assemblies share it, so that the
    /// accelerations are the same with and without derivatives.
    #[inline(always)]
    pub(super) fn add_loads<S: LoadSums<N>>(
        &self,
        t: f64,
        (q, v): StateRef<'_, GraspLayout<N>>,
        mode: &GraspMode,
        sums: &mut S,
    ) -> [[S::Angles; 3]; FINGERS] {
        Assembly { model: self, q, v, mode, field: self.inertial_field(t), sums }.add_all(t)
    }

    /// Accelerations as one function, which is not inlined into every integrator. Only grasps, which studies simulate
    /// by the thousand, are worth the compile time of inlining.
    #[inline(never)]
    fn rates_noinline(
        &self,
        t: f64,
        state: StateRef<'_, GraspLayout<N>>,
        mode: &GraspMode,
        terms: Option<&FingerTerms>,
    ) -> Rates<GraspLayout<N>> {
        self.rates_inline(t, state, mode, terms)
    }

    #[inline(always)]
    fn rates_inline(
        &self,
        t: f64,
        state: StateRef<'_, GraspLayout<N>>,
        mode: &GraspMode,
        terms: Option<&FingerTerms>,
    ) -> Rates<GraspLayout<N>> {
        let mut sums = Loads { load: [0.0; N], g: [0.0; QUADRATURES], terms };
        let masses = self.add_loads(t, state, mode, &mut sums);
        Rates { a: Inertia::new(self, masses).inverse().solve(&sums.load), g: sums.g }
    }

    /// Forces in the joints of both fingers, in the order of [`joint_forces`](crate::fivebar::joint_forces::joint_forces)
    /// and in the frame of the palm. `terms` are those of this state, and `contact_force` returns force and point of a
    /// contact in it; for a joint limit, the first number is its torque.
    pub(crate) fn joint_forces(
        &self,
        t: f64,
        state: &State<GraspLayout<N>>,
        mode: &GraspMode,
        terms: &FingerTerms,
        contact_force: impl Fn(usize) -> [[f64; 2]; 2],
    ) -> [[[f64; 2]; 5]; FINGERS] {
        let Rates { a, .. } = self.rates_noinline(t, (&state.q, &state.v), mode, Some(terms));
        let field = self.inertial_field(t).field;
        let mut forces_n = [[[0.0; 2]; 5]; FINGERS];
        for (index, component) in self.fingers.iter().enumerate() {
            let (mirror, half_palm_width) = (component.side.mirror(), self.half_palm_width());
            let mirrored = |[[fx, fy], [x, y]]: [[f64; 2]; 2]| [[mirror * fx, fy], [mirror * x, y]];
            let first = FingerContact::ALL.len() * index;
            let of_finger = (first..first + 3).filter_map(|contact| match self.contacts[contact]?.pair {
                ContactPair::Phalanx { phalanx, .. } => Some((phalanx, mirrored(contact_force(contact)))),
                ContactPair::Stop { .. } => Some((FingerContact::Limit, contact_force(contact))),
                _ => None,
            });
            let motion = [&state.v, &a].map(|all| Multibody::<N>::finger_coordinates(index, all));
            let frame = ([half_palm_width, 0.0], field.mirrored(mirror));
            let Terms { pose, rates, .. } = &terms[index];
            let forces = component.model.joint_forces((pose, rates), motion, frame, of_finger);
            forces_n[index] = forces.map(|[x, y]| [mirror * x, y]);
        }
        forces_n
    }
}

/// Makes centre and angle of the object positions of a contact with these indices.
#[inline(always)]
fn placed_positions<const N: usize, S: LoadSums<N>, const P: usize>(
    placed: &PlacedShape,
    [x, y, angle]: [usize; 3],
) -> PlacedShape<S::Positions<P>> {
    let PlacedShape { shape, centre_m, angle_rad } = *placed;
    let centre_m = [S::position(centre_m[0], x), S::position(centre_m[1], y)];
    PlacedShape { shape, centre_m, angle_rad: S::position(angle_rad, angle) }
}

impl<const N: usize> System for Multibody<N> {
    type Layout = GraspLayout<N>;
    type Mode = GraspMode;

    #[inline(always)]
    fn layout(&self) -> GraspLayout<N> {
        Fixed
    }

    #[inline(always)]
    fn second_order_count(&self) -> usize {
        Self::POSITIONS
    }

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &GraspMode, rates: &mut Rates<GraspLayout<N>>) {
        *rates = match Self::GRASP {
            true => self.rates_inline(t, (q, v), mode, None),
            false => self.rates_noinline(t, (q, v), mode, None),
        };
    }

    fn linearise(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        mode: &GraspMode,
        linearised: &mut Linearised<GraspLayout<N>>,
    ) {
        self.jacobian(t, (q, v), mode, linearised);
    }
}
