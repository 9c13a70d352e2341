//! State of a run at one instant, and events between instants.

use serde::Serialize;

pub use crate::gripper::FingerContact;

/// A part of a sample as a list of numbers: columns, interpolation and checks are derived from it.
pub trait Channels<const K: usize>: Sized {
    /// Names of the numbers with their units.
    const NAMES: [&'static str; K];

    /// Returns all numbers, in the order of [`Channels::NAMES`].
    fn values(&self) -> [f64; K];

    fn from_values(values: [f64; K]) -> Self;
}

/// One contact: a phalanx against the object, a disc against another, or the joint limit. For a contact that does not
/// exist, every field is zero and `gap_m` is infinite.
///
/// The gap of the joint limit is an angle, δ = −φ22 − q22, and its force is a torque on q22: read rad for m and N·m for
/// N. It has no slip, friction, contact point or normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSample {
    /// Distance between the surfaces, negative in penetration (−δ).
    pub gap_m: f64,
    /// Rate of the gap (−δ̇).
    pub gap_rate_m_s: f64,
    /// Tangential velocity of the phalanx surface relative to the object (errata 5).
    pub slip_m_s: f64,
    /// Normal force on the phalanx (palm, table) along `normal`; never negative.
    pub normal_n: f64,
    /// Friction force on the phalanx along [`ContactSample::tangent`]; it opposes `slip_m_s`.
    pub tangential_n: f64,
    /// Normal impulse since the start of the run.
    pub impulse_n_s: f64,
    /// Contact point on the surface of the phalanx.
    pub point_m: [f64; 2],
    /// Unit normal, from the object to the phalanx (palm, table).
    pub normal: [f64; 2],
}

/// Largest overlap that counts as rounding error in the positions of two surfaces that just touch, m (limit: rad).
pub(super) const OVERLAP_ROUNDING: f64 = 1e-12;

impl ContactSample {
    /// Returns the unit tangent: the normal rotated counter-clockwise by 90°. On the face of a phalanx of a finger that
    /// closes counter-clockwise it points along the phalanx to its end.
    pub fn tangent(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
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

impl Channels<10> for ContactSample {
    const NAMES: [&'static str; 10] = [
        "gap_m",
        "gap_rate_m_s",
        "slip_m_s",
        "normal_n",
        "tangential_n",
        "impulse_n_s",
        "point_x_m",
        "point_y_m",
        "normal_x",
        "normal_y",
    ];

    fn values(&self) -> [f64; 10] {
        let Self { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal } = *self;
        let ([px, py], [nx, ny]) = (point_m, normal);
        [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, px, py, nx, ny]
    }

    fn from_values(values: [f64; 10]) -> Self {
        let [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, px, py, nx, ny] = values;
        let (point_m, normal) = ([px, py], [nx, ny]);
        Self { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal }
    }
}

impl ContactSample {
    /// A contact that does not exist.
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

/// Energies, and work since the start of the run, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    pub kinetic_j: f64,
    pub gravity_j: f64,
    pub spring_j: f64,
    /// Energy stored in the Hertz springs of contacts and joint limit.
    pub elastic_j: f64,
    /// Energy dissipated in dampers, in the clamp and in friction.
    pub dissipated_j: f64,
    /// Work of the motor.
    pub motor_work_j: f64,
    /// kinetic + gravity + spring + elastic + dissipated − motor work − (the same at the start): zero if energy is
    /// conserved.
    pub balance_j: f64,
}

impl Energy {
    /// Returns these stored energies with work, dissipation and balance since the start of the run.
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

impl Channels<7> for Energy {
    const NAMES: [&'static str; 7] =
        ["kinetic_j", "gravity_j", "spring_j", "elastic_j", "dissipated_j", "motor_work_j", "balance_j"];

    fn values(&self) -> [f64; 7] {
        let Self { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j } = *self;
        [kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j]
    }

    fn from_values(values: [f64; 7]) -> Self {
        let [kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j] = values;
        Self { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j }
    }
}

/// State of a finger at one instant. Its serialised form contains the angles, and the rates of the independent
/// coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FingerState {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
    /// q12 and q22 are passive angles, each relative to the preceding link; q13 is the absolute orientation of l22.
    pub q12_rad: f64,
    pub q13_rad: f64,
    #[serde(skip)]
    pub qd12_rad_s: f64,
    #[serde(skip)]
    pub qd22_rad_s: f64,
    #[serde(skip)]
    pub motor_torque_n_m: f64,
}

impl Channels<10> for FingerState {
    const NAMES: [&'static str; 10] = [
        "q11_rad",
        "q21_rad",
        "q12_rad",
        "q22_rad",
        "q13_rad",
        "qd11_rad_s",
        "qd21_rad_s",
        "qd12_rad_s",
        "qd22_rad_s",
        "motor_torque_n_m",
    ];

    fn values(&self) -> [f64; 10] {
        let Self { q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, .. } = *self;
        let Self { qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, motor_torque_n_m, .. } = *self;
        let [q, qd] = [[q11_rad, q21_rad, q12_rad, q22_rad], [qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s]];
        [q[0], q[1], q[2], q[3], q13_rad, qd[0], qd[1], qd[2], qd[3], motor_torque_n_m]
    }

    fn from_values(values: [f64; 10]) -> Self {
        let [q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, rates @ .., motor_torque_n_m] = values;
        let [qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s] = rates;
        let angles = Self { q11_rad, q21_rad, q12_rad, q22_rad, q13_rad, motor_torque_n_m, ..Self::default() };
        Self { qd11_rad_s, qd21_rad_s, qd12_rad_s, qd22_rad_s, ..angles }
    }
}

/// State of a rigid body, such as a disc, at one instant. The angle is counter-clockwise and not reduced by whole
/// turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub velocity_m_s: [f64; 2],
    pub spin_rad_s: f64,
}

impl Channels<6> for BodyState {
    const NAMES: [&'static str; 6] = ["x_m", "y_m", "angle_rad", "vx_m_s", "vy_m_s", "spin_rad_s"];

    fn values(&self) -> [f64; 6] {
        let Self { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = *self;
        [x, y, angle_rad, vx, vy, spin_rad_s]
    }

    fn from_values([x, y, angle_rad, vx, vy, spin_rad_s]: [f64; 6]) -> Self {
        Self { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
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

/// State of a run at one instant. The number of fingers, bodies and contacts is constant during a run; a
/// [`Layout`](super::Layout) names them.
#[derive(Debug, Default, PartialEq)]
pub struct Sample {
    pub time_s: f64,
    pub fingers: Vec<FingerState>,
    /// Bodies that are not part of a finger; in a scene of discs all discs, including fixed ones.
    pub bodies: Vec<BodyState>,
    /// Contacts of every finger in the order of [`FingerContact::ALL`], with the limit in rad, rad/s, N·m and N·m·s;
    /// then one contact for each pair of discs ([`System::pairs`](crate::scene::System::pairs)): forces on the first
    /// disc of the pair, normal from the other disc to it.
    pub contacts: Vec<ContactSample>,
    /// With driven discs, `motor_work_j` is the work of their drives; their kinetic energy is not included.
    pub energy: Energy,
}

/// Samples are reused so that steps do not allocate: unlike a derived one, this `clone_from` keeps existing
/// allocations.
impl Clone for Sample {
    fn clone(&self) -> Self {
        let Sample { time_s, fingers, bodies, contacts, energy } = self;
        Sample {
            time_s: *time_s,
            fingers: fingers.clone(),
            bodies: bodies.clone(),
            contacts: contacts.clone(),
            energy: *energy,
        }
    }

    fn clone_from(&mut self, other: &Self) {
        let Sample { time_s, fingers, bodies, contacts, energy } = other;
        self.fingers.clone_from(fingers);
        self.bodies.clone_from(bodies);
        self.contacts.clone_from(contacts);
        (self.time_s, self.energy) = (*time_s, *energy);
    }
}

impl Sample {
    /// Returns a sample of one finger and its contacts, with all values zero.
    pub fn with_one_finger() -> Self {
        Sample {
            fingers: vec![FingerState::default()],
            contacts: vec![ContactSample::default(); FingerContact::ALL.len()],
            ..Sample::default()
        }
    }

    /// Returns the first finger.
    ///
    /// # Panics
    /// Panics if there is no finger.
    pub fn finger(&self) -> &FingerState {
        &self.fingers[0]
    }

    /// Returns the first finger for modification.
    ///
    /// # Panics
    /// Panics if there is no finger.
    pub fn finger_mut(&mut self) -> &mut FingerState {
        &mut self.fingers[0]
    }

    /// Returns a contact of the first finger.
    ///
    /// # Panics
    /// Panics if there is no finger.
    pub fn contact(&self, site: FingerContact) -> &ContactSample {
        &self.contacts[site as usize]
    }

    /// Returns a contact of the first finger for modification.
    ///
    /// # Panics
    /// Panics if there is no finger.
    pub fn contact_mut(&mut self, site: FingerContact) -> &mut ContactSample {
        &mut self.contacts[site as usize]
    }

    /// Whether a contact is a joint limit, whose gap is an angle.
    pub fn is_stop(&self, contact: usize) -> bool {
        contact / FingerContact::ALL.len() < self.fingers.len()
            && contact % FingerContact::ALL.len() == FingerContact::Limit as usize
    }

    /// Contacts between surfaces, that is all except joint limits.
    pub fn surfaces(&self) -> impl Iterator<Item = &ContactSample> {
        self.contacts.iter().enumerate().filter(|(index, _)| !self.is_stop(*index)).map(|(_, contact)| contact)
    }

    /// Copies the rates of another sample of the same run.
    #[cfg(feature = "engine")]
    pub(super) fn copy_rates(&mut self, source: &Self) {
        for (finger, from) in self.fingers.iter_mut().zip(&source.fingers) {
            *finger = FingerState {
                qd11_rad_s: from.qd11_rad_s,
                qd21_rad_s: from.qd21_rad_s,
                qd12_rad_s: from.qd12_rad_s,
                qd22_rad_s: from.qd22_rad_s,
                ..*finger
            };
        }
        for (body, from) in self.bodies.iter_mut().zip(&source.bodies) {
            (body.velocity_m_s, body.spin_rad_s) = (from.velocity_m_s, from.spin_rad_s);
        }
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
    /// Closing speed (−gap rate) at a touch-down, m/s (limit: rad/s); 0 otherwise.
    pub approach_speed: f64,
    /// Normal impulse since the last touch-down of this contact at a lift-off, N·s (limit: N·m·s); 0 otherwise.
    pub impulse: f64,
}

impl Event {
    /// Returns the contact of a scene with one finger.
    ///
    /// # Panics
    /// Panics if the contact does not belong to the first finger.
    pub fn finger_contact(&self) -> FingerContact {
        FingerContact::ALL[self.contact]
    }
}
