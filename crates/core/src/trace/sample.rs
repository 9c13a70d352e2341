//! One instant of a run, and the events between instants.

use serde::Serialize;

pub use crate::gripper::Site;

/// One place of contact: a phalanx against the object, a disc against another, the joint limit. Where there is nothing to
/// touch every field is zero and `gap_m` infinite.
///
/// The joint limit is a contact whose gap is an angle, δ = −φ22 − q22, and whose force is a torque on q22: for it read rad for
/// m and N·m for N. It has no slip, no friction, no point and no normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactSample {
    /// Distance between the surfaces, negative in penetration (−δ).
    pub gap_m: f64,
    /// Rate of the gap (−δ̇).
    pub gap_rate_m_s: f64,
    /// Tangential velocity of the phalanx surface over the object (errata 5).
    pub slip_m_s: f64,
    /// Normal force on the phalanx (palm, table), along `normal`; never negative.
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

/// An overlap below this is rounding of the places of two surfaces that touch exactly, m (limit: rad).
pub(super) const OVERLAP_ROUNDING: f64 = 1e-12;

impl ContactSample {
    /// Unit tangent: the normal turned counter-clockwise by 90°. On the face of a phalanx of a finger that closes
    /// counter-clockwise it points along the phalanx to its end.
    pub fn tangent(&self) -> [f64; 2] {
        [-self.normal[1], self.normal[0]]
    }

    /// Force (N; limit: N·m) and penetration (m; rad).
    pub fn pressed(&self) -> (f64, f64) {
        (self.normal_n, -self.gap_m)
    }

    /// Closing speed of the touch-down of a contact that is there when the run starts, m/s (limit: rad/s). Where the surfaces overlap
    /// by more than [`OVERLAP_ROUNDING`] they met before the start, and that speed is unknown: 0.
    pub(super) fn approach_at_start(&self) -> f64 {
        // The sum has no negative zero.
        if self.gap_m < -OVERLAP_ROUNDING { 0.0 } else { (-self.gap_rate_m_s).max(0.0) + 0.0 }
    }

    /// At a touch elsewhere within a step: forces and rates are those before it, for the touch has changed nothing yet. With a
    /// force goes the gap that made it.
    #[cfg(feature = "engine")]
    pub(super) fn press_on(&mut self, before: &Self) {
        if before.normal_n > 0.0 {
            self.gap_m = before.gap_m;
        }
        (self.normal_n, self.tangential_n) = (before.normal_n, before.tangential_n);
        (self.slip_m_s, self.gap_rate_m_s) = (before.slip_m_s, before.gap_rate_m_s);
    }

    /// At its own touch within a step: the surfaces meet, and nothing has pressed so far, whatever does at the step's end.
    #[cfg(feature = "engine")]
    pub(super) fn not_yet_pressed(&mut self, before: &Self, closing: f64) {
        (self.gap_m, self.gap_rate_m_s) = (0.0, -closing);
        (self.normal_n, self.tangential_n, self.impulse_n_s) = (0.0, 0.0, before.impulse_n_s);
    }
}

impl ContactSample {
    /// Where there is nothing to touch.
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

/// Energies and works since the start, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    pub kinetic_j: f64,
    pub gravity_j: f64,
    pub spring_j: f64,
    /// Stored in the Hertz springs of contacts and limit.
    pub elastic_j: f64,
    /// Lost in dampers, in the clamp and in friction.
    pub dissipated_j: f64,
    /// Work of the motor.
    pub motor_work_j: f64,
    /// kinetic + gravity + spring + elastic + dissipated − motor work − (the same at the start): zero if nothing is lost.
    pub balance_j: f64,
}

impl Energy {
    /// These stored energies, with the works since the start of the run and what was lost on the way.
    pub(super) fn since(self, start: &Energy, contact_work_j: f64, motor_work_j: f64) -> Self {
        let gained_j =
            (self.kinetic_j - start.kinetic_j) + (self.gravity_j - start.gravity_j) + (self.spring_j - start.spring_j);
        Energy {
            dissipated_j: start.elastic_j - self.elastic_j - contact_work_j,
            motor_work_j,
            balance_j: gained_j - contact_work_j - motor_work_j,
            ..self
        }
    }

    /// All of them, in the order of the fields.
    pub fn values_j(&self) -> [f64; 7] {
        [
            self.kinetic_j,
            self.gravity_j,
            self.spring_j,
            self.elastic_j,
            self.dissipated_j,
            self.motor_work_j,
            self.balance_j,
        ]
    }
}

/// A finger at one instant. Its document has the angles, and the rates of those that move by themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FingerState {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
    /// q12 and q22 are passive angles, each relative to the link before it; q13 is the absolute orientation of l22.
    pub q12_rad: f64,
    pub q13_rad: f64,
    #[serde(skip)]
    pub qd12_rad_s: f64,
    #[serde(skip)]
    pub qd22_rad_s: f64,
    #[serde(skip)]
    pub motor_torque_n_m: f64,
}

/// A rigid body by itself, such as a disc, at one instant. The angle is counter-clockwise, and not brought back by whole turns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub velocity_m_s: [f64; 2],
    pub spin_rad_s: f64,
}

impl BodyState {
    /// Where it is after a time under these accelerations (x, y, angle).
    #[cfg(feature = "engine")]
    pub(super) fn flown(&self, time_s: f64, a: &[f64; 3]) -> Self {
        let free = |axis: usize| {
            let rate = self.velocity_m_s[axis];
            [self.centre_m[axis] + time_s * (rate + 0.5 * time_s * a[axis]), rate + time_s * a[axis]]
        };
        let [[x, vx], [y, vy]] = [free(0), free(1)];
        BodyState {
            centre_m: [x, y],
            angle_rad: self.angle_rad + time_s * (self.spin_rad_s + 0.5 * time_s * a[2]),
            velocity_m_s: [vx, vy],
            spin_rad_s: self.spin_rad_s + time_s * a[2],
        }
    }
}

/// The state of a run at one instant. What there is of each kind stays the same through a run: a [`Layout`](super::Layout)
/// names it.
#[derive(Debug, Default, PartialEq)]
pub struct Sample {
    pub time_s: f64,
    pub fingers: Vec<FingerState>,
    /// Bodies that are no part of a finger; of a scene of discs all of its discs, fixed ones too.
    pub bodies: Vec<BodyState>,
    /// Of every finger in the order of [`Site::ALL`], the limit in rad, rad/s, N·m and N·m·s; behind them, of discs, one for
    /// each of [`System::pairs`](crate::scene::System::pairs): forces on the pair's disc, normal from its partner to
    /// it.
    pub contacts: Vec<ContactSample>,
    /// Where discs are driven, `motor_work_j` is the work of whatever drives them; these have no kinetic energy here.
    pub energy: Energy,
}

/// Samples are reused, so that a run allocates nothing from step to step: `clone_from` keeps what is there, which a derived one
/// would not.
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
    /// One finger and its contacts, all figures zero.
    pub fn of_finger() -> Self {
        Sample {
            fingers: vec![FingerState::default()],
            contacts: vec![ContactSample::default(); Site::ALL.len()],
            ..Sample::default()
        }
    }

    /// The finger of a scene that has one, or its first.
    ///
    /// # Panics
    /// If there is none.
    pub fn finger(&self) -> &FingerState {
        &self.fingers[0]
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// If there is none.
    pub fn finger_mut(&mut self) -> &mut FingerState {
        &mut self.fingers[0]
    }

    /// A contact of the first finger.
    ///
    /// # Panics
    /// If there is no finger.
    pub fn contact(&self, site: Site) -> &ContactSample {
        &self.contacts[site as usize]
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// If there is no finger.
    pub fn contact_mut(&mut self, site: Site) -> &mut ContactSample {
        &mut self.contacts[site as usize]
    }

    /// Whether a contact is the stop of a joint, whose gap is an angle.
    pub fn is_stop(&self, contact: usize) -> bool {
        contact / Site::ALL.len() < self.fingers.len() && contact % Site::ALL.len() == Site::Limit as usize
    }

    /// The contacts between surfaces: all but the stops of joints.
    pub fn surfaces(&self) -> impl Iterator<Item = &ContactSample> {
        self.contacts.iter().enumerate().filter(|(index, _)| !self.is_stop(*index)).map(|(_, contact)| contact)
    }

    /// Takes over the rates of another sample of the same run.
    #[cfg(feature = "engine")]
    pub(super) fn take_rates(&mut self, from: &Self) {
        for (finger, from) in self.fingers.iter_mut().zip(&from.fingers) {
            *finger = FingerState {
                qd11_rad_s: from.qd11_rad_s,
                qd21_rad_s: from.qd21_rad_s,
                qd12_rad_s: from.qd12_rad_s,
                qd22_rad_s: from.qd22_rad_s,
                ..*finger
            };
        }
        for (body, from) in self.bodies.iter_mut().zip(&from.bodies) {
            (body.velocity_m_s, body.spin_rad_s) = (from.velocity_m_s, from.spin_rad_s);
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// Surfaces meet: the gap closes.
    TouchDown,
    /// The force ends: the contact lets go, though the surfaces may still overlap by less than a micrometre.
    LiftOff,
    /// The force returns before the surfaces have parted.
    Reload,
    /// Friction that holds has come to the end of its cone: the slider of its bristle begins to slip.
    Slips,
    /// It is within its cone again.
    Sticks,
}

impl EventKind {
    /// In tables and on pages.
    pub fn name(self) -> &'static str {
        match self {
            EventKind::TouchDown => "touch-down",
            EventKind::LiftOff => "lift-off",
            EventKind::Reload => "pressed again",
            EventKind::Slips => "begins to slip",
            EventKind::Sticks => "sticks again",
        }
    }

    /// Whether it is one of friction: such contacts press on as before.
    pub fn is_of_friction(self) -> bool {
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
    /// Closing speed −gap rate at a touch-down (m/s; limit: rad/s); 0 otherwise.
    pub approach_speed: f64,
    /// Normal impulse since the last touch-down of this contact, at a lift-off (N·s; limit: N·m·s); 0 otherwise.
    pub impulse: f64,
}

impl Event {
    /// Where the finger of a scene that has one touches.
    ///
    /// # Panics
    /// If it is not the contact of one finger.
    pub fn site(&self) -> Site {
        Site::ALL[self.contact]
    }
}
