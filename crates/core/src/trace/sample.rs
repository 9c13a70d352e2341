//! State of a run at one instant, and events between instants.

use super::schema::{
    ActuatorState, BodyState, CableElementState, Channel, ContactSample, Counts, DistanceState, Energy, FingerState,
    Interpolation, JointState, MotorState, ShaftState, State, TendonState, ValueSource,
};
pub use crate::gripper::FingerContact;
use crate::mechanism::Powertrain;
use crate::numeric::array_from;
use crate::scene::{FINGER_JOINTS, Hand, HandContact, Object};

/// Places of q11, q21, q12, q22 and of the joint that closes the loop among [`FINGER_JOINTS`].
const FINGER_JOINT_PLACES: [usize; 5] = [0, 2, 1, 3, 4];

/// Largest overlap that counts as rounding error in the positions of two surfaces that just touch, m (limit: rad).
pub(super) const OVERLAP_ROUNDING: f64 = 1e-12;

impl ContactSample {
    /// Returns the unit tangent: the normal rotated counter-clockwise by 90°. On the face of a phalanx of a finger that
    /// closes counter-clockwise, it points along the phalanx to its end.
    pub fn tangent(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
    }

    /// Returns the force on the phalanx (palm, table), N.
    pub fn force_n(&self) -> [f64; 2] {
        let (normal, tangent) = (self.normal, self.tangent());
        [0, 1].map(|k| self.normal_n * normal[k] + self.tangential_n * tangent[k])
    }

    /// Returns the normal force (N; limit: N·m) and the penetration (m; limit: rad).
    pub fn force_and_penetration(&self) -> (f64, f64) {
        (self.normal_n, -self.gap_m)
    }

    /// Returns the closing speed of a touch-down at the start of the run, m/s (limit: rad/s). Surfaces that overlap by
    /// more than [`OVERLAP_ROUNDING`] touched before the start at an unknown speed: 0.
    pub(super) fn approach_at_start(&self) -> f64 {
        // Adding zero removes a negative zero.
        if self.gap_m < -OVERLAP_ROUNDING { 0.0 } else { (-self.gap_rate_m_s).max(0.0) + 0.0 }
    }

    /// Sets the values at a touch-down of another contact within a step: forces and rates are those before it. An
    /// active contact also keeps the gap that belongs to its force.
    #[cfg(feature = "engine")]
    pub(super) fn set_before_touch_down_elsewhere(&mut self, before: &Self) {
        if before.normal_n > 0.0 {
            self.gap_m = before.gap_m;
        }
        (self.normal_n, self.tangential_n) = (before.normal_n, before.tangential_n);
        (self.slip_m_s, self.gap_rate_m_s) = (before.slip_m_s, before.gap_rate_m_s);
    }

    /// Sets the values at a touch-down of this contact within a step: the gap is zero, and there is no force or impulse
    /// yet.
    #[cfg(feature = "engine")]
    pub(super) fn set_touch_down(&mut self, before: &Self, closing: f64) {
        (self.gap_m, self.gap_rate_m_s) = (0.0, -closing);
        (self.normal_n, self.tangential_n, self.impulse_n_s) = (0.0, 0.0, before.impulse_n_s);
    }
}

impl ContactSample {
    /// A contact that does not exist: all its numbers are 0, and its gap is infinite.
    pub const NONE: Self = Self {
        gap_m: f64::INFINITY,
        gap_rate_m_s: 0.0,
        slip_m_s: 0.0,
        normal_n: 0.0,
        tangential_n: 0.0,
        impulse_n_s: 0.0,
        point_m: [0.0; 2],
        normal: [0.0; 2],
    };
}

impl Energy {
    /// Returns these energies with work, dissipation and balance since the start of the run.
    pub(super) fn relative_to(self, start: &Energy, contact_work_j: f64, motor_work_j: f64) -> Self {
        let gained_j =
            (self.kinetic_j - start.kinetic_j) + (self.gravity_j - start.gravity_j) + (self.spring_j - start.spring_j);
        Energy {
            dissipated_j: start.elastic_j - self.elastic_j - contact_work_j,
            motor_work_j,
            balance_j: gained_j - contact_work_j - motor_work_j,
            ..self
        }
    }
}

impl BodyState {
    /// Returns the state after a time at constant accelerations (x, y, angle).
    #[cfg(feature = "engine")]
    pub(super) fn extrapolate(&self, time_s: f64, a: &[f64; 3]) -> Self {
        let translate = |axis: usize| {
            let rate = self.velocity_m_s[axis];
            [self.centre_m[axis] + time_s * (rate + 0.5 * time_s * a[axis]), rate + time_s * a[axis]]
        };
        let [[x, vx], [y, vy]] = [translate(0), translate(1)];
        BodyState {
            centre_m: [x, y],
            angle_rad: self.angle_rad + time_s * (self.spin_rad_s + 0.5 * time_s * a[2]),
            velocity_m_s: [vx, vy],
            spin_rad_s: self.spin_rad_s + time_s * a[2],
        }
    }
}

/// State of the powertrain of an actuator.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DriveState {
    pub shaft: ShaftState,
    pub motor: MotorState,
    pub distance: DistanceState,
}

/// State of a run at one instant: a time and one number per channel of the run's [`Schema`](super::Schema). The number
/// of subjects is constant during a run.
#[derive(Debug, Default, PartialEq)]
pub struct Sample {
    pub time_s: f64,
    counts: Counts,
    values: Vec<f64>,
}

/// Samples are reused so that steps do not allocate: unlike a derived one, this `clone_from` keeps the existing
/// allocation.
impl Clone for Sample {
    fn clone(&self) -> Self {
        Sample { time_s: self.time_s, counts: self.counts, values: self.values.clone() }
    }

    fn clone_from(&mut self, other: &Self) {
        (self.time_s, self.counts) = (other.time_s, other.counts);
        self.values.clone_from(&other.values);
    }
}

impl Sample {
    /// Returns a sample with all numbers zero.
    pub fn new(time_s: f64, counts: Counts) -> Self {
        Sample { time_s, counts, values: vec![0.0; counts.values()] }
    }

    /// Returns a sample of five-bar fingers with these states. The last contacts are the joint limits of the fingers.
    pub fn of(time_s: f64, fingers: &[FingerState], bodies: &[BodyState], contacts: &[ContactSample]) -> Self {
        let mut sample = Sample::new(time_s, Self::counts_of(fingers.len(), bodies.len(), contacts.len()));
        fingers.iter().enumerate().for_each(|(k, state)| sample.set_finger(k, state));
        bodies.iter().enumerate().for_each(|(k, state)| sample.set_body(k, state));
        contacts.iter().enumerate().for_each(|(k, state)| sample.set_contact(k, state));
        sample
    }

    /// Returns a sample of one finger and its contacts, with all values zero.
    pub fn with_one_finger() -> Self {
        Sample::new(0.0, Self::counts_of(1, 0, FingerContact::ALL.len()))
    }

    fn counts_of(fingers: usize, bodies: usize, contacts: usize) -> Counts {
        let (joints, limits) = (FINGER_JOINTS.len() * fingers, fingers.min(contacts));
        Counts { fingers, joints, actuators: fingers, bodies, contacts, limits, ..Counts::default() }
    }

    /// Prepares the sample for a time and these numbers of subjects; reuses its allocation. Numbers are not cleared.
    pub(super) fn prepare(&mut self, time_s: f64, counts: Counts) {
        (self.time_s, self.counts) = (time_s, counts);
        self.values.resize(counts.values(), 0.0);
    }

    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns all numbers, in the order of the schema.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Index of a number that is not finite, if there is one. Only the gap of a contact that does not exist is infinite.
    #[cfg(feature = "engine")]
    pub(super) fn find_not_finite(&self) -> Option<usize> {
        // Any such number makes the sum NaN.
        if self.values.iter().map(|value| 0.0 * value).sum::<f64>() == 0.0 {
            return None;
        }
        let contacts = self.counts.contact(0)..self.counts.energy();
        let is_absent = |index: usize, value: f64| {
            value == f64::INFINITY
                && contacts.contains(&index)
                && (index - contacts.start).is_multiple_of(ContactSample::QUANTITIES.len())
        };
        let invalid = |(index, value): &(usize, &f64)| !value.is_finite() && !is_absent(*index, **value);
        self.values.iter().enumerate().find(invalid).map(|(index, _)| index)
    }

    /// Returns all numbers for modification.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    fn state<const K: usize, T: State<K>>(&self, first: usize) -> T {
        T::from_values(array_from(|k| self.values[first..first + K][k]))
    }

    fn set_state<const K: usize, T: State<K>>(&mut self, first: usize, state: &T) {
        self.values[first..first + K].copy_from_slice(&state.values());
    }

    /// Returns a finger.
    ///
    /// # Panics
    /// Panics if there is no such finger.
    pub fn finger(&self, index: usize) -> FingerState {
        assert!(index < self.counts.fingers, "a sample of {} fingers has no finger {index}", self.counts.fingers);
        let [q11, q21, q12, q22, _] =
            FINGER_JOINT_PLACES.map(|place| self.joint_state(FINGER_JOINTS.len() * index + place));
        FingerState {
            q11_rad: q11.angle_rad,
            q21_rad: q21.angle_rad,
            q22_rad: q22.angle_rad,
            qd11_rad_s: q11.rate_rad_s,
            qd21_rad_s: q21.rate_rad_s,
            q12_rad: q12.angle_rad,
            q13_rad: q21.angle_rad + q22.angle_rad,
            qd12_rad_s: q12.rate_rad_s,
            qd22_rad_s: q22.rate_rad_s,
        }
    }

    /// Returns the state of a joint. The joints of a five-bar finger are [`FINGER_JOINTS`].
    pub fn joint_state(&self, index: usize) -> JointState {
        self.state(self.counts.joint(index))
    }

    pub fn set_joint(&mut self, index: usize, joint: &JointState) {
        self.set_state(self.counts.joint(index), joint);
    }

    /// Returns the torque of an actuator, N·m (prismatic joint: its force, N).
    pub fn actuator(&self, index: usize) -> f64 {
        self.state::<1, ActuatorState>(self.counts.actuator(index)).torque_n_m
    }

    /// Sets the torque of an actuator, N·m (prismatic joint: its force, N).
    pub fn set_actuator(&mut self, index: usize, torque_n_m: f64) {
        self.set_state(self.counts.actuator(index), &ActuatorState { torque_n_m });
    }

    /// Returns a tendon.
    pub fn tendon(&self, index: usize) -> TendonState {
        self.state(self.counts.tendon(index))
    }

    pub fn set_tendon(&mut self, index: usize, tendon: &TendonState) {
        self.set_state(self.counts.tendon(index), tendon);
    }

    /// Returns the shaft of an actuator, by its index among the shafts.
    pub fn shaft(&self, index: usize) -> ShaftState {
        self.state(self.counts.shaft(index))
    }

    /// Returns the electric motor of an actuator, by its index among the motors.
    pub fn motor(&self, index: usize) -> MotorState {
        self.state(self.counts.motor(index))
    }

    /// Returns a distance that an actuator controls, by its index among the distances.
    pub fn distance(&self, index: usize) -> DistanceState {
        self.state(self.counts.distance(index))
    }

    /// Sets the shaft, motor and distance of actuators with a powertrain, in the order of the actuators.
    pub(super) fn set_drives<'a>(&mut self, drives: impl IntoIterator<Item = (&'a Powertrain, DriveState)>) {
        let [mut shaft, mut motor, mut distance] = [0; 3];
        for (powertrain, state) in drives {
            if powertrain.has_shaft() {
                self.set_state(self.counts.shaft(shaft), &state.shaft);
                shaft += 1;
            }
            if powertrain.motor.is_some() {
                self.set_state(self.counts.motor(motor), &state.motor);
                motor += 1;
            }
            if powertrain.feedback.is_some() {
                self.set_state(self.counts.distance(distance), &state.distance);
                distance += 1;
            }
        }
    }

    /// Returns a place of a cable.
    pub fn cable_element(&self, index: usize) -> CableElementState {
        self.state(self.counts.element(index))
    }

    pub fn set_cable_element(&mut self, index: usize, element: &CableElementState) {
        self.set_state(self.counts.element(index), element);
    }

    /// Sets angles and rates of a finger; the forces of its joints are not changed.
    pub fn set_finger(&mut self, index: usize, finger: &FingerState) {
        let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, .. } =
            *finger;
        let joints = [
            (q11_rad, qd11_rad_s),
            (q21_rad, qd21_rad_s),
            (q12_rad, qd12_rad_s),
            (q22_rad, qd22_rad_s),
            (q21_rad + q22_rad - (q11_rad + q12_rad), qd21_rad_s + qd22_rad_s - (qd11_rad_s + qd12_rad_s)),
        ];
        for (place, (angle_rad, rate_rad_s)) in FINGER_JOINT_PLACES.into_iter().zip(joints) {
            let first = self.counts.joint(FINGER_JOINTS.len() * index + place);
            self.values[first..first + 2].copy_from_slice(&[angle_rad, rate_rad_s]);
        }
    }

    /// Sets the forces in q11, q21, q12, q22 and the joint that closes the loop of a finger.
    pub(super) fn set_joint_forces(&mut self, finger: usize, forces_n: &[[f64; 2]; 5]) {
        for (place, force_n) in FINGER_JOINT_PLACES.into_iter().zip(forces_n) {
            let first = self.counts.joint(FINGER_JOINTS.len() * finger + place) + 2;
            self.values[first..first + 2].copy_from_slice(force_n);
        }
    }

    pub fn fingers(&self) -> impl ExactSizeIterator<Item = FingerState> + DoubleEndedIterator + '_ {
        (0..self.counts.fingers).map(|index| self.finger(index))
    }

    /// Returns a body that is not part of a finger. In a mechanism, every body counts.
    pub fn body(&self, index: usize) -> BodyState {
        self.state(self.counts.body(index))
    }

    pub fn set_body(&mut self, index: usize, body: &BodyState) {
        self.set_state(self.counts.body(index), body);
    }

    /// Returns the object of a gripper: its body, or a state at rest for a fixed object.
    ///
    /// # Panics
    /// Panics if the hand has no object.
    pub fn object(&self, hand: &Hand) -> BodyState {
        let Object { centre_m, angle_rad, .. } = *hand.grasped();
        match hand.moving_object() {
            Some(_) => self.body(0),
            None => BodyState { centre_m, angle_rad, ..BodyState::default() },
        }
    }

    /// Returns a contact of a hand; [`ContactSample::NONE`] if one of its surfaces does not exist.
    pub fn hand_contact(&self, hand: &Hand, contact: HandContact) -> ContactSample {
        hand.contact_index(contact).map_or(ContactSample::NONE, |index| self.contact(index))
    }

    pub fn bodies(&self) -> impl ExactSizeIterator<Item = BodyState> + DoubleEndedIterator + '_ {
        (0..self.counts.bodies).map(|index| self.body(index))
    }

    /// Returns a contact; the order is that of [`Schema::contacts`](super::Schema::contacts). For the limit of a
    /// revolute joint, units are rad, rad/s, N·m and N·m·s.
    pub fn contact(&self, index: usize) -> ContactSample {
        self.state(self.counts.contact(index))
    }

    /// Returns the normal force of a contact. Reading single numbers is faster than [`Sample::contact`].
    pub(crate) fn normal_n(&self, contact: usize) -> f64 {
        self.values[self.counts.contact(contact) + ContactSample::NORMAL]
    }

    /// Returns the normal force and the penetration of a contact, as [`ContactSample::force_and_penetration`].
    pub(super) fn force_and_penetration(&self, contact: usize) -> (f64, f64) {
        let first = self.counts.contact(contact);
        (self.values[first + ContactSample::NORMAL], -self.values[first])
    }

    /// Returns gap and gap rate of a contact.
    pub(crate) fn gap(&self, contact: usize) -> [f64; 2] {
        let first = self.counts.contact(contact);
        [self.values[first], self.values[first + 1]]
    }

    /// Returns the sliding speed of a contact.
    pub(crate) fn slip_m_s(&self, contact: usize) -> f64 {
        self.values[self.counts.contact(contact) + ContactSample::SLIP]
    }

    pub fn set_contact(&mut self, index: usize, contact: &ContactSample) {
        self.set_state(self.counts.contact(index), contact);
    }

    pub fn contacts(&self) -> impl ExactSizeIterator<Item = ContactSample> + DoubleEndedIterator + '_ {
        (0..self.counts.contacts).map(|index| self.contact(index))
    }

    /// Returns a contact of a single finger; [`ContactSample::NONE`] if its scene has no such contact.
    ///
    /// # Panics
    /// Panics if the number of fingers is not one.
    pub fn finger_contact(&self, contact: FingerContact) -> ContactSample {
        self.counts.finger_contact(contact).map_or(ContactSample::NONE, |index| self.contact(index))
    }

    /// Returns the energies; all are zero in a sample without subjects. With driven discs, `motor_work_j` is the work
    /// of their drives, and the kinetic energy of the driven discs is not included.
    pub fn energy(&self) -> Energy {
        if self.values.is_empty() { Energy::default() } else { self.state(self.counts.energy()) }
    }

    pub fn set_energy(&mut self, energy: &Energy) {
        self.prepare(self.time_s, self.counts);
        self.set_state(self.counts.energy(), energy);
    }

    /// Whether a contact is a joint limit.
    pub fn is_stop(&self, contact: usize) -> bool {
        (self.counts.contacts - self.counts.limits..self.counts.contacts).contains(&contact)
    }

    /// Computes the quantities that follow from other quantities ([`Interpolation::Derived`]).
    pub fn derive(&mut self) {
        (0..self.counts.contacts).for_each(|index| self.set_contact(index, &self.contact(index)));
    }

    /// Contacts between surfaces: all contacts except joint limits.
    pub fn surfaces(&self) -> impl Iterator<Item = ContactSample> + '_ {
        self.contacts().enumerate().filter(|(index, _)| !self.is_stop(*index)).map(|(_, contact)| contact)
    }

    /// Returns a sample with all joints, actuators and tendons, and with the bodies and contacts of these indices.
    #[must_use]
    pub fn select(&self, bodies: &[usize], contacts: &[usize]) -> Sample {
        let limits = contacts.iter().filter(|index| self.is_stop(**index)).count();
        let counts = Counts { bodies: bodies.len(), contacts: contacts.len(), limits, ..self.counts };
        let mut selected = Sample::new(self.time_s, counts);
        let of_joints = ..self.counts.body(0);
        selected.values[of_joints].copy_from_slice(&self.values[of_joints]);
        bodies.iter().enumerate().for_each(|(k, &index)| selected.set_body(k, &self.body(index)));
        contacts.iter().enumerate().for_each(|(k, &index)| selected.set_contact(k, &self.contact(index)));
        selected.set_energy(&self.energy());
        selected
    }

    /// Copies the rates of another sample of the same run.
    #[cfg(feature = "engine")]
    pub(super) fn copy_rates(&mut self, source: &Self) {
        for index in 0..self.counts.joints {
            let rate = self.counts.joint(index) + 1;
            self.values[rate] = source.values[rate];
        }
        for index in 0..self.counts.bodies {
            let from = source.body(index);
            let body = self.body(index);
            self.set_body(index, &BodyState { velocity_m_s: from.velocity_m_s, spin_rad_s: from.spin_rad_s, ..body });
        }
    }

    /// Sets this sample to the one at time `t` between `a` and `b`, reusing its allocation.
    pub(super) fn interpolate_from(&mut self, a: &Sample, b: &Sample, t: f64) {
        let h = b.time_s - a.time_s;
        if h <= 0.0 {
            self.clone_from(b);
            return;
        }
        let (instant, counts) = (Instant { h, x: ((t - a.time_s) / h).clamp(0.0, 1.0) }, a.counts);
        self.prepare(t, counts);
        let mut subjects = Subjects { instant, a: &a.values, b: &b.values, out: &mut self.values };
        subjects.interpolate::<5, JointState>(counts.joint(0), counts.actuator(0));
        subjects.interpolate::<1, ActuatorState>(counts.actuator(0), counts.tendon(0));
        subjects.interpolate::<3, TendonState>(counts.tendon(0), counts.element(0));
        subjects.interpolate::<5, CableElementState>(counts.element(0), counts.shaft(0));
        subjects.interpolate::<2, ShaftState>(counts.shaft(0), counts.motor(0));
        subjects.interpolate::<2, MotorState>(counts.motor(0), counts.distance(0));
        subjects.interpolate::<2, DistanceState>(counts.distance(0), counts.body(0));
        subjects.interpolate::<6, BodyState>(counts.body(0), counts.contact(0));
        subjects.interpolate::<11, ContactSample>(counts.contact(0), counts.energy());
        subjects.interpolate::<8, Energy>(counts.energy(), counts.values());
    }
}

impl Channel {
    /// Returns the number of this channel in a sample. It is NaN for contacts that do not exist; their gap is infinite.
    pub fn value(&self, sample: &Sample) -> f64 {
        match self.source {
            ValueSource::Time => sample.time_s,
            ValueSource::Value(index) => sample.values()[index],
            ValueSource::Contact(_, gap) if !sample.values()[gap].is_finite() => f64::NAN,
            ValueSource::Contact(index, _) => sample.values()[index],
        }
    }
}

/// Returns the sample at time `t` between `a` and `b`; see [`Interpolation`].
pub fn interpolate(a: &Sample, b: &Sample, t: f64) -> Sample {
    let mut sample = Sample::default();
    sample.interpolate_from(a, b, t);
    sample
}

/// Numbers of two samples, and those between them.
struct Subjects<'a> {
    instant: Instant,
    a: &'a [f64],
    b: &'a [f64],
    out: &'a mut [f64],
}

impl Subjects<'_> {
    /// Interpolates the subjects of one kind, whose numbers are `first..end`.
    fn interpolate<const K: usize, T: State<K>>(&mut self, first: usize, end: usize) {
        let Self { instant, a, b, out } = self;
        for start in (first..end).step_by(K) {
            let (a, b) = (&a[start..start + K], &b[start..start + K]);
            let values = array_from(|k| match T::QUANTITIES[k].interpolation {
                Interpolation::Linear => instant.linear(a[k], b[k]),
                Interpolation::Cubic { rate } => instant.cubic(a[k], a[rate], b[k], b[rate]),
                Interpolation::Derived => 0.0,
            });
            out[start..start + K].copy_from_slice(&T::from_values(values).values());
        }
    }
}

/// An instant between two samples.
#[derive(Clone, Copy, Debug)]
struct Instant {
    /// Time between the samples, s.
    h: f64,
    /// Elapsed fraction of the interval.
    x: f64,
}

impl Instant {
    /// Linear interpolation from `p` to `q`.
    fn linear(&self, p: f64, q: f64) -> f64 {
        if p.is_finite() && q.is_finite() { p + self.x * (q - p) } else { q }
    }

    /// Cubic Hermite interpolation from `p` to `q` with the rates `v` and `w`.
    fn cubic(&self, p: f64, v: f64, q: f64, w: f64) -> f64 {
        let Self { h, x } = *self;
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    }
}

/// Kind of a contact event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The gap closes.
    TouchDown,
    /// The contact force ends, although the surfaces may still overlap by less than a micrometre.
    LiftOff,
    /// The contact force returns before the surfaces have separated.
    Reload,
    /// Bristle friction reaches the edge of its cone and begins to slip.
    Slips,
    /// Bristle friction is within its cone again.
    Sticks,
}

impl EventKind {
    pub const ALL: [Self; 5] =
        [EventKind::TouchDown, EventKind::LiftOff, EventKind::Reload, EventKind::Slips, EventKind::Sticks];

    /// Key of the event in logs.
    pub fn key(self) -> &'static str {
        match self {
            EventKind::TouchDown => "touch_down",
            EventKind::LiftOff => "lift_off",
            EventKind::Reload => "reload",
            EventKind::Slips => "slips",
            EventKind::Sticks => "sticks",
        }
    }

    /// Name in tables and on pages.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::TouchDown => "touch-down",
            EventKind::LiftOff => "lift-off",
            EventKind::Reload => "pressed again",
            EventKind::Slips => "begins to slip",
            EventKind::Sticks => "sticks again",
        }
    }

    /// Whether the event is a friction event, which leaves the contact active.
    pub fn is_friction_event(self) -> bool {
        matches!(self, EventKind::Slips | EventKind::Sticks)
    }
}

/// A change of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    pub time_s: f64,
    /// Index among the contacts of a sample.
    pub contact: usize,
    pub kind: EventKind,
    /// Closing speed (−gap rate), m/s (limit: rad/s), at a touch-down; 0 for other events.
    pub approach_speed: f64,
    /// Normal impulse since the last touch-down of this contact, N·s (limit: N·m·s), at a lift-off; 0 for other events.
    pub impulse: f64,
}
