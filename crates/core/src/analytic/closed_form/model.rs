//! The analytic model of one finger: accelerations, their exact Jacobian, and the state of every contact.
//!
//! Coordinates are q_a = (q11, q21). If friction has an internal state, the rates after theirs are the states of both
//! phalanges; nothing depends on the coordinates at these indices.

use super::finger::{FingerKinematics, FingerModel, PassiveJoints};
use crate::analytic::contact::{
    ContactMode, ContactReading, ContactState, Energies, Geometry, Mode, normal_force_on_branch,
};
use crate::fivebar::dynamics::{Terms, kinetic_energy, solve_mass};
use crate::fivebar::kinematics::{Directions, PassiveRates};
use crate::gripper::FingerContact;
use crate::integrator::{Fixed, FixedMatrix, Linearised, Rates, State, System};
use crate::law::{FrictionLaw, FrictionRange, elastic_energy, normal_over_gap};
use crate::numeric::plane::dot;
use crate::numeric::{Dual, Real, array_from, map_array};
use crate::scene;
use crate::scene::{Initial, Profile, Side};
use crate::shape::{PlacedShape, Support};

/// Number of quadratures: normal impulses of the three contacts, work of all contact forces, and work of the motor.
pub const QUADRATURES: usize = 5;

/// Number of event functions of the three contacts: those of the normal laws first, then of the friction laws, then of
/// the dampers.
pub const EVENT_FUNCTIONS: usize = 9;

/// Branches of the laws of all contacts, in the order of [`FingerContact::ALL`].
pub type FingerMode = Mode<[ContactMode; 3]>;

/// Sizes of the model with N coordinates.
pub type FingerLayout<const N: usize> = Fixed<N, QUADRATURES>;

/// Coordinates of a finger.
pub(super) const FINGER_COORDINATES: usize = 2;

/// Number of internal states of friction with stiction, on the proximal and the distal phalanx.
const STATES: usize = 2;

/// The analytic model of a scene, with all constant terms precomputed. It has N coordinates. Its Jacobian is taken with
/// respect to W = N + 2 variables: q11, q21, and all rates.
#[derive(Clone, Debug)]
pub struct FingerMotion<const N: usize, const W: usize> {
    pub(super) finger: FingerModel,
    pub(super) actuation: Profile,
    pub(super) object: Option<PlacedShape>,
    /// Index in [`FingerContact::ALL`] of each contact of a sample.
    sample_contacts: [usize; FingerContact::ALL.len()],
}

/// The model of a scene whose friction has no internal states.
pub type Model = FingerMotion<FINGER_COORDINATES, { 2 * FINGER_COORDINATES }>;

/// The model of a scene with stiction: the friction of the proximal and the distal phalanx has internal states.
pub type StictionModel = FingerMotion<{ FINGER_COORDINATES + STATES }, { 2 * FINGER_COORDINATES + STATES }>;

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// Whether friction has internal states.
    const HAS_STATES: bool = N > FINGER_COORDINATES;

    /// Builds the model of a scene.
    ///
    /// # Panics
    ///
    /// Panics if N does not match the friction laws of the scene, with or without stiction.
    pub fn new(hand: &scene::Hand) -> Self {
        assert!(
            Self::HAS_STATES == hand.has_stiction() && W == FINGER_COORDINATES + N,
            "N and W must match the finger's coordinates and internal states"
        );
        let finger = hand.finger(Side::Right);
        let mut sample_contacts = [0; FingerContact::ALL.len()];
        for (index, contact) in sample_contacts.iter_mut().zip(hand.contacts()) {
            *index = contact.index();
        }
        Self {
            finger: FingerModel::new(finger, hand.gravity_m_s2),
            actuation: finger.motor.actuation.clone(),
            object: hand.object.as_ref().map(|object| object.placed()),
            sample_contacts,
        }
    }

    /// Index in [`FingerContact::ALL`] of the contact `contact` of a sample.
    pub fn contact_of_sample(&self, contact: usize) -> usize {
        self.sample_contacts[contact]
    }

    /// Returns the coordinates and rates at the start.
    pub fn start(hand: &scene::Hand) -> State<FingerLayout<N>> {
        let Initial { q11_rad, q21_rad, qd11_rad_s, qd21_rad_s } = hand.finger(Side::Right).initial;
        State { q: pad([q11_rad, q21_rad]), v: pad([qd11_rad_s, qd21_rad_s]), z: [0.0; QUADRATURES] }
    }

    /// Index of the internal state of a contact's friction among the rates; the joint limit has none.
    #[inline(always)]
    pub(super) fn state_index(contact: FingerContact) -> Option<usize> {
        if Self::HAS_STATES && contact != FingerContact::Limit {
            Some(FINGER_COORDINATES + contact as usize)
        } else {
            None
        }
    }

    /// Whether the friction of a contact has an internal state.
    pub(crate) fn has_stiction(&self, contact: FingerContact) -> bool {
        self.finger.friction_law(contact).is_some_and(FrictionLaw::has_state)
    }

    /// Friction laws with internal states, with the indices of these among the rates.
    #[inline(always)]
    fn states(&self) -> impl Iterator<Item = (usize, &FrictionLaw)> {
        let indexed = |contact| Self::state_index(contact).zip(self.finger.friction_law(contact));
        FingerContact::ALL.into_iter().filter_map(indexed).filter(|(_, law)| law.has_state())
    }

    /// Friction of a contact at these rates.
    #[inline(always)]
    fn friction<T: Real>(
        law: &FrictionLaw,
        (contact, range): (FingerContact, FrictionRange),
        slip: T,
        v: &[T; N],
        normal: T,
    ) -> T {
        law.force(slip, Self::state_index(contact).map(|state| v[state]), normal, range)
    }

    /// Geometry of one contact; `None` where the scene has no such contact.
    #[inline(always)]
    pub(super) fn geometry<T: Real>(
        &self,
        pose: &Directions<T>,
        rates: &PassiveRates<T>,
        contact: FingerContact,
    ) -> Option<Geometry<T>> {
        if contact == FingerContact::Limit {
            return self.finger.limit.map(|_| self.finger.limit_geometry(pose, rates));
        }
        let PlacedShape { shape, centre_m, angle_rad } = self.object?;
        let centre_m = [T::constant(centre_m[0]), T::constant(centre_m[1])];
        let object = PlacedShape { shape, centre_m, angle_rad: T::constant(angle_rad) };
        Some(self.finger.phalanx_geometry(pose, rates, contact, &object))
    }

    /// q̈_a (2.24) and the rates of internal states and quadratures, from terms and geometry of the active contacts.
    #[inline(always)]
    fn accelerations<T: Real>(
        &self,
        motor_torque: T,
        terms: &Terms<T>,
        geometry: impl Fn(FingerContact) -> Option<Geometry<T>>,
        mode: &FingerMode,
        v: [T; N],
    ) -> ([T; N], [T; QUADRATURES]) {
        let finger_rates = finger_coordinates(&v);
        let mut state_rates = [T::zero(); STATES];
        if Self::HAS_STATES {
            self.states().for_each(|(index, law)| {
                state_rates[index - FINGER_COORDINATES] = law.kind.relaxation(v[index]);
            });
        }
        let mut load = self.finger.load(motor_torque, terms, finger_rates);
        let mut quadratures = [T::zero(); QUADRATURES];
        let mut contact_power = T::zero();
        for contact in FingerContact::ALL {
            let index = contact as usize;
            if !mode[index].has_force() {
                continue;
            }
            let (Some(geometry), Some(law)) = (geometry(contact), self.finger.normal_law(contact)) else { continue };
            let gap_rate = dot(geometry.normal_row, finger_rates);
            let normal =
                normal_over_gap(|d, rate| normal_force_on_branch(law, mode[index], d, rate), geometry.gap, gap_rate);
            load[0] += geometry.normal_row[0] * normal;
            load[1] += geometry.normal_row[1] * normal;
            contact_power += normal * gap_rate;
            quadratures[index] = normal;
            if let Some(friction) = self.finger.friction_law(contact) {
                let slip = dot(geometry.tangent_row, finger_rates);
                let range = mode.friction_range(index);
                let tangential = Self::friction(friction, (contact, range), slip, &v, normal);
                load[0] += geometry.tangent_row[0] * tangential;
                load[1] += geometry.tangent_row[1] * tangential;
                contact_power += tangential * slip;
                if let Some(state) = Self::state_index(contact) {
                    state_rates[state - FINGER_COORDINATES] += friction.state_rate(tangential);
                }
            }
        }
        quadratures[3] = contact_power;
        quadratures[4] = motor_torque * finger_rates[0];
        let finger_accelerations = solve_mass(&terms.mass, load);
        let mut all = [T::zero(); N];
        all[..FINGER_COORDINATES].copy_from_slice(&finger_accelerations);
        all[FINGER_COORDINATES..].copy_from_slice(&state_rates[..N - FINGER_COORDINATES]);
        (all, quadratures)
    }

    /// Evaluates one contact in one state; `None` if the scene does not have this contact.
    pub fn contact_reading(
        &self,
        q: [f64; N],
        v: [f64; N],
        contact: FingerContact,
        state: ContactState,
    ) -> Option<ContactReading> {
        self.reading_in_pose(&self.finger.kinematics(finger_coordinates(&q)), &v, contact, state)
    }

    fn reading_in_pose(
        &self,
        (pose, rates): &FingerKinematics,
        v: &[f64; N],
        contact: FingerContact,
        state: ContactState,
    ) -> Option<ContactReading> {
        let geometry = self.geometry(pose, rates, contact)?;
        let law = self.finger.normal_law(contact)?;
        let (delta, delta_rate) = (-geometry.gap, -dot(geometry.normal_row, finger_coordinates(v)));
        let slip = dot(geometry.tangent_row, finger_coordinates(v));
        let normal = normal_force_on_branch(law, state, delta, delta_rate).force.max(0.0);
        let friction = |law| Self::friction(law, (contact, FrictionRange::Any), slip, v, normal);
        let tangential = self.finger.friction_law(contact).map_or(0.0, friction);
        Some(ContactReading { geometry, delta, delta_rate, slip, normal, tangential })
    }

    /// Evaluates all contacts in one state, in the order of [`FingerContact::ALL`].
    pub(crate) fn contact_readings(
        &self,
        kinematics: &FingerKinematics,
        v: &[f64; N],
        mode: &FingerMode,
    ) -> [Option<ContactReading>; 3] {
        let mut readings = [None; 3];
        for (contact, reading) in FingerContact::ALL.into_iter().zip(&mut readings) {
            *reading = self.reading_in_pose(kinematics, v, contact, mode[contact as usize]);
        }
        readings
    }

    /// Angles and rates of the passive joints.
    pub(crate) fn passive_joints(&self, kinematics: &FingerKinematics, q: &[f64; N], v: &[f64; N]) -> PassiveJoints {
        self.finger.passive_joints(kinematics, finger_coordinates(q), finger_coordinates(v))
    }

    /// Position-dependent terms of the equations of motion.
    pub(crate) fn terms(&self, q: &[f64; N]) -> Terms<f64> {
        self.finger.terms(finger_coordinates(q))
    }

    /// The part of [`FingerMotion::terms`] that contacts and passive joints need.
    pub(crate) fn kinematics(&self, q: &[f64; N]) -> FingerKinematics {
        self.finger.kinematics(finger_coordinates(q))
    }

    /// Energies of a state with evaluated terms and contacts.
    pub(crate) fn energies(
        &self,
        v: &[f64; N],
        terms: &Terms<f64>,
        contacts: &[Option<ContactReading>; 3],
    ) -> Energies {
        let springs =
            FingerContact::ALL.map(|contact| match (self.finger.normal_law(contact), &contacts[contact as usize]) {
                (Some(law), Some(reading)) => elastic_energy(law, reading.delta),
                _ => 0.0,
            });
        let mut elastic = springs.iter().sum();
        if Self::HAS_STATES {
            elastic += self.states().map(|(index, law)| law.kind.energy(v[index])).sum::<f64>();
        }
        let [gravity, spring] = self.finger.potential_energies(&terms.pose);
        let kinetic = kinetic_energy(&terms.mass, finger_coordinates(v));
        Energies { kinetic, gravity, spring, elastic }
    }

    /// Forces in the joints of a state with evaluated terms and contacts, in the order of
    /// [`joint_forces`](crate::fivebar::joint_forces::joint_forces).
    pub(crate) fn joint_forces(
        &self,
        t: f64,
        v: &[f64; N],
        mode: &FingerMode,
        terms: &Terms<f64>,
        contacts: &[Option<ContactReading>; 3],
    ) -> [[f64; 2]; 5] {
        let geometry = |contact| contacts[contact as usize].as_ref().map(|reading| reading.geometry);
        let (a, _) = self.accelerations(self.motor_torque(t), terms, geometry, mode, *v);
        let forces = FingerContact::ALL.into_iter().zip(contacts).filter_map(|(contact, reading)| {
            let reading = reading.as_ref()?;
            Some(match contact {
                FingerContact::Limit => (contact, [[reading.normal, 0.0]; 2]),
                _ => (contact, [reading.force(), reading.geometry.point]),
            })
        });
        let motion = [finger_coordinates(v), finger_coordinates(&a)];
        self.finger.joint_forces((&terms.pose, &terms.rates), motion, forces)
    }

    /// Motor torque at time `t`, in N·m.
    pub fn motor_torque(&self, t: f64) -> f64 {
        self.actuation.at(t).0
    }

    /// Replaces the torque of the motor over time.
    pub fn set_actuation(&mut self, actuation: Profile) {
        self.actuation = actuation;
    }
}

/// Returns the first two coordinates or rates, which belong to the finger.
#[inline(always)]
pub(super) fn finger_coordinates<T: Copy, const N: usize>(all: &[T; N]) -> [T; FINGER_COORDINATES] {
    [all[0], all[1]]
}

/// Appends zeros to the finger's own coordinates or rates.
#[inline(always)]
pub(super) fn pad<const N: usize>(finger_coordinates: [f64; FINGER_COORDINATES]) -> [f64; N] {
    let mut all = [0.0; N];
    all[..FINGER_COORDINATES].copy_from_slice(&finger_coordinates);
    all
}

impl<const N: usize, const W: usize> System for FingerMotion<N, W> {
    type Layout = FingerLayout<N>;
    type Mode = FingerMode;

    #[inline(always)]
    fn layout(&self) -> FingerLayout<N> {
        Fixed
    }

    #[inline(always)]
    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &FingerMode, rates: &mut Rates<FingerLayout<N>>) {
        let terms = self.finger.terms(finger_coordinates(q));
        let torque = self.actuation.at(t).0;
        let geometry = |contact| self.geometry(&terms.pose, &terms.rates, contact);
        (rates.a, rates.g) = self.accelerations(torque, &terms, geometry, mode, *v);
    }

    #[inline(always)]
    fn linearise(
        &self,
        t: f64,
        q: &[f64; N],
        v: &[f64; N],
        mode: &FingerMode,
        linearised: &mut Linearised<FingerLayout<N>>,
    ) {
        // Terms that depend on positions only are derived by the two positions, then extended to all variables.
        let finger_terms = self.finger.terms([Dual::<FINGER_COORDINATES>::variable(q[0], 0), Dual::variable(q[1], 1)]);
        let widened_terms = finger_terms.map(Dual::widen);
        let rate = array_from(|i| Dual::<W>::variable(v[i], FINGER_COORDINATES + i));
        let (torque, slope) = self.actuation.at(t);
        let geometry = |contact| self.geometry(&finger_terms.pose, &finger_terms.rates, contact).map(Geometry::widen);
        let (a, g) = self.accelerations(Dual::constant(torque), &widened_terms, geometry, mode, rate);
        let mass = map_array(finger_terms.mass, |m| m.value);
        *linearised = Linearised {
            rates: Rates { a: map_array(a, |x| x.value), g: map_array(g, |x| x.value) },
            a_q: position_derivatives(&a),
            a_v: rate_derivatives(&a),
            a_t: pad(solve_mass(&mass, [slope, 0.0])),
            g_q: position_derivatives(&g),
            g_v: rate_derivatives(&g),
            g_t: [0.0, 0.0, 0.0, 0.0, slope * v[0]],
        };
    }
}

/// Derivatives of R numbers with respect to N positions; zero except for the finger's own positions.
#[inline(always)]
fn position_derivatives<const N: usize, const W: usize, const R: usize>(
    values: &[Dual<W>; R],
) -> FixedMatrix<f64, R, N> {
    let mut rows = [[0.0; N]; R];
    for (row, x) in rows.iter_mut().zip(values) {
        row[..FINGER_COORDINATES].copy_from_slice(&x.grad[..FINGER_COORDINATES]);
    }
    FixedMatrix(rows)
}

/// Derivatives of R numbers with respect to N rates.
#[inline(always)]
fn rate_derivatives<const N: usize, const W: usize, const R: usize>(values: &[Dual<W>; R]) -> FixedMatrix<f64, R, N> {
    let mut rows = [[0.0; N]; R];
    for (row, x) in rows.iter_mut().zip(values) {
        row.copy_from_slice(&x.grad[FINGER_COORDINATES..]);
    }
    FixedMatrix(rows)
}

impl Geometry<Dual<2>> {
    #[inline(always)]
    fn widen<const W: usize>(self) -> Geometry<Dual<W>> {
        Geometry {
            gap: self.gap.widen(),
            normal_row: map_array(self.normal_row, Dual::widen),
            tangent_row: map_array(self.tangent_row, Dual::widen),
            normal: map_array(self.normal, Dual::widen),
            point: map_array(self.point, Dual::widen),
            support: Support { distance: self.support.distance.widen(), slope: self.support.slope.widen() },
        }
    }
}
