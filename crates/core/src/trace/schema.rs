//! What a run records. Subjects (joints, actuators and their drives, tendons, bodies, contacts, and the system with its energies) have the
//! quantities of their kind; each quantity of a subject is a channel. A [`Sample`](super::Sample) is a time and one
//! number per channel in the order of the schema.
//!
//! Everything that stores or shows samples derives its columns from the schema. A new quantity is added here, to the
//! state of its subject, and where a model reads that state.

use serde::Serialize;

use crate::gripper::FingerContact;
use crate::mechanism::{Joint, Mechanism, Powertrain};
use crate::scene::{FINGER_JOINTS, HandContact, Object, Scene, Side};
use std::collections::HashSet;
use std::ops::Range;

/// Rule for values between two samples. `rate` is the index of the rate among the quantities of the same subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    /// Cubic Hermite interpolation.
    Cubic {
        rate: usize,
    },
    /// The quantity follows from other quantities of its subject ([`State::from_values`]); logs do not contain it.
    Derived,
}

/// A quantity of a kind of subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Key with its unit, such as `gap_rate_m_s`: name of the field in log messages, and end of the name of the column.
    pub key: &'static str,
    /// SI unit, such as `m/s`; empty for a pure number.
    pub unit: &'static str,
    pub interpolation: Interpolation,
}

const fn linear(key: &'static str, unit: &'static str) -> Quantity {
    Quantity { key, unit, interpolation: Interpolation::Linear }
}

const fn cubic(key: &'static str, unit: &'static str, rate: usize) -> Quantity {
    Quantity { key, unit, interpolation: Interpolation::Cubic { rate } }
}

/// Kind of a subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubjectKind {
    /// A revolute joint.
    Joint,
    /// A prismatic joint.
    Slider,
    Actuator,
    /// The actuator of a prismatic joint or a tendon, which exerts a force.
    LinearActuator,
    Tendon,
    /// A place on the path of a tendon: a pulley, or any place between the ends of a cable with friction.
    CableElement,
    /// The shaft of the motor of an actuator with a gear or an electric motor.
    Shaft,
    /// The electric motor of an actuator.
    Motor,
    /// The distance that an actuator controls.
    Distance,
    Body,
    Contact,
    /// A contact of a joint with its limit: its gap is an angle, its force a torque.
    Limit,
    Energy,
}

impl SubjectKind {
    /// Returns the quantities, each with its index among the numbers of the subject.
    fn quantities(self) -> impl Iterator<Item = (usize, &'static Quantity)> {
        let (all, indices): (&[Quantity], &[usize]) = match self {
            // The pin of a revolute joint has no moment.
            SubjectKind::Joint => (&JointState::QUANTITIES[..4], &[]),
            SubjectKind::Slider => (&SLIDER_QUANTITIES, &[]),
            SubjectKind::Actuator => (&ActuatorState::QUANTITIES, &[]),
            SubjectKind::LinearActuator => (&LINEAR_ACTUATOR_QUANTITIES, &[]),
            SubjectKind::Tendon => (&TendonState::QUANTITIES, &[]),
            SubjectKind::CableElement => (&CableElementState::QUANTITIES, &[]),
            SubjectKind::Shaft => (&ShaftState::QUANTITIES, &[]),
            SubjectKind::Motor => (&MotorState::QUANTITIES, &[]),
            SubjectKind::Distance => (&DistanceState::QUANTITIES, &[]),
            SubjectKind::Body => (&BodyState::QUANTITIES, &[]),
            SubjectKind::Contact => (&ContactSample::QUANTITIES, &[]),
            SubjectKind::Limit => (&LIMIT_QUANTITIES, &LIMIT_INDICES),
            SubjectKind::Energy => (&Energy::QUANTITIES, &[]),
        };
        all.iter().enumerate().map(|(k, quantity)| (indices.get(k).copied().unwrap_or(k), quantity))
    }

    /// Name in topics and events.
    pub fn name(self) -> &'static str {
        match self {
            SubjectKind::Joint | SubjectKind::Slider => "joint",
            SubjectKind::Actuator | SubjectKind::LinearActuator => "actuator",
            SubjectKind::Tendon => "tendon",
            SubjectKind::CableElement => "cable",
            SubjectKind::Shaft => "shaft",
            SubjectKind::Motor => "motor",
            SubjectKind::Distance => "distance",
            SubjectKind::Body => "body",
            SubjectKind::Contact => "contact",
            SubjectKind::Limit => "limit",
            SubjectKind::Energy => "energy",
        }
    }

    /// Whether gap and force of this kind of contact are an angle and a torque.
    pub fn is_angular(self) -> bool {
        self == SubjectKind::Limit
    }
}

/// State of a subject as a list of its quantities.
pub trait State<const K: usize>: Sized {
    const QUANTITIES: [Quantity; K];

    /// Returns all numbers, in the order of [`State::QUANTITIES`].
    fn values(&self) -> [f64; K];

    fn from_values(values: [f64; K]) -> Self;
}

/// State of a joint: its coordinate and rate, and the force that it exerts on its second body at its point. The force
/// is in the frame of a moving palm, or of the world. For a joint of a right finger, the second body is the link named
/// after the joint; for a left finger, it is the preceding link. For a prismatic joint, read m for rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointState {
    pub angle_rad: f64,
    pub rate_rad_s: f64,
    pub force_n: [f64; 2],
    /// Moment in the guide of a prismatic joint; 0 for a revolute joint.
    pub moment_n_m: f64,
}

impl State<5> for JointState {
    const QUANTITIES: [Quantity; 5] = [
        cubic("angle_rad", "rad", 1),
        linear("rate_rad_s", "rad/s"),
        linear("force_x_n", "N"),
        linear("force_y_n", "N"),
        linear("moment_n_m", "N·m"),
    ];

    fn values(&self) -> [f64; 5] {
        [self.angle_rad, self.rate_rad_s, self.force_n[0], self.force_n[1], self.moment_n_m]
    }

    fn from_values([angle_rad, rate_rad_s, force_x, force_y, moment_n_m]: [f64; 5]) -> Self {
        Self { angle_rad, rate_rad_s, force_n: [force_x, force_y], moment_n_m }
    }
}

/// Quantities of a prismatic joint, in the order of a [`JointState`].
const SLIDER_QUANTITIES: [Quantity; 5] = [
    cubic("position_m", "m", 1),
    linear("rate_m_s", "m/s"),
    linear("force_x_n", "N"),
    linear("force_y_n", "N"),
    linear("moment_n_m", "N·m"),
];

/// Number of quantities of a joint before its force.
const JOINT_MOTION: usize = 2;

/// State of the actuator of a joint. For a prismatic joint, read N for N·m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActuatorState {
    pub torque_n_m: f64,
}

impl State<1> for ActuatorState {
    const QUANTITIES: [Quantity; 1] = [linear("torque_n_m", "N·m")];

    fn values(&self) -> [f64; 1] {
        [self.torque_n_m]
    }

    fn from_values([torque_n_m]: [f64; 1]) -> Self {
        Self { torque_n_m }
    }
}

const LINEAR_ACTUATOR_QUANTITIES: [Quantity; 1] = [linear("force_n", "N")];

/// State of a tendon: its length including the terms of joints, the rate of this length, and the tension.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TendonState {
    pub length_m: f64,
    pub rate_m_s: f64,
    pub tension_n: f64,
}

impl State<3> for TendonState {
    const QUANTITIES: [Quantity; 3] = [cubic("length_m", "m", 1), linear("rate_m_s", "m/s"), linear("tension_n", "N")];

    fn values(&self) -> [f64; 3] {
        [self.length_m, self.rate_m_s, self.tension_n]
    }

    fn from_values([length_m, rate_m_s, tension_n]: [f64; 3]) -> Self {
        Self { length_m, rate_m_s, tension_n }
    }
}

/// State of the shaft of a motor: its torque, and the work that the gear has lost since the start of the run, which is
/// part of the dissipated energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftState {
    pub motor_torque_n_m: f64,
    pub loss_j: f64,
}

impl State<2> for ShaftState {
    const QUANTITIES: [Quantity; 2] = [linear("motor_torque_n_m", "N·m"), linear("loss_j", "J")];

    fn values(&self) -> [f64; 2] {
        [self.motor_torque_n_m, self.loss_j]
    }

    fn from_values([motor_torque_n_m, loss_j]: [f64; 2]) -> Self {
        Self { motor_torque_n_m, loss_j }
    }
}

/// State of an electric motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorState {
    pub voltage_v: f64,
    pub current_a: f64,
}

impl State<2> for MotorState {
    const QUANTITIES: [Quantity; 2] = [linear("voltage_v", "V"), linear("current_a", "A")];

    fn values(&self) -> [f64; 2] {
        [self.voltage_v, self.current_a]
    }

    fn from_values([voltage_v, current_a]: [f64; 2]) -> Self {
        Self { voltage_v, current_a }
    }
}

/// A distance that an actuator controls, and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DistanceState {
    pub distance_m: f64,
    pub distance_rate_m_s: f64,
}

impl State<2> for DistanceState {
    const QUANTITIES: [Quantity; 2] = [cubic("distance_m", "m", 1), linear("distance_rate_m_s", "m/s")];

    fn values(&self) -> [f64; 2] {
        [self.distance_m, self.distance_rate_m_s]
    }

    fn from_values([distance_m, distance_rate_m_s]: [f64; 2]) -> Self {
        Self { distance_m, distance_rate_m_s }
    }
}

/// State of a cable at a place of its path. The speed is that of the cable over the place, towards the end where it is pulled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CableElementState {
    /// 1 if the cable is on the pulley or eyelet, 0 if it has lifted off.
    pub on: f64,
    /// Wrap of the cable; 0 if it is off.
    pub wrap_rad: f64,
    /// Distance of the cable from the pulley; 0 if it is on.
    pub gap_m: f64,
    /// Speed of the cable; 0 if it is off or has no friction.
    pub slip_m_s: f64,
    /// Tension of the cable behind the place.
    pub tension_n: f64,
}

impl State<5> for CableElementState {
    const QUANTITIES: [Quantity; 5] = [
        linear("on", ""),
        linear("wrap_rad", "rad"),
        linear("gap_m", "m"),
        linear("slip_m_s", "m/s"),
        linear("tension_n", "N"),
    ];

    fn values(&self) -> [f64; 5] {
        [self.on, self.wrap_rad, self.gap_m, self.slip_m_s, self.tension_n]
    }

    fn from_values([on, wrap_rad, gap_m, slip_m_s, tension_n]: [f64; 5]) -> Self {
        Self { on, wrap_rad, gap_m, slip_m_s, tension_n }
    }
}

/// State of a rigid body, such as a disc, at one instant. The angle is counter-clockwise; whole turns are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyState {
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub velocity_m_s: [f64; 2],
    pub spin_rad_s: f64,
}

impl State<6> for BodyState {
    const QUANTITIES: [Quantity; 6] = [
        cubic("x_m", "m", 3),
        cubic("y_m", "m", 4),
        cubic("angle_rad", "rad", 5),
        linear("vx_m_s", "m/s"),
        linear("vy_m_s", "m/s"),
        linear("spin_rad_s", "rad/s"),
    ];

    fn values(&self) -> [f64; 6] {
        let Self { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s } = *self;
        [x, y, angle_rad, vx, vy, spin_rad_s]
    }

    fn from_values([x, y, angle_rad, vx, vy, spin_rad_s]: [f64; 6]) -> Self {
        Self { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }
    }
}

/// State of one contact: a phalanx against the object, a disc against another, or a joint limit. For a contact that
/// does not exist, every field is zero and `gap_m` is infinite.
///
/// The gap of the joint limit is an angle, δ = −φ22 − q22, and its force is a torque on q22: read rad for m, and N·m
/// for N. It has no slip, friction, contact point or normal.
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

impl ContactSample {
    /// Indices of slip and normal force among the quantities.
    pub(super) const SLIP: usize = 2;
    pub(super) const NORMAL: usize = 3;
}

impl State<11> for ContactSample {
    const QUANTITIES: [Quantity; 11] = [
        linear("gap_m", "m"),
        linear("gap_rate_m_s", "m/s"),
        linear("slip_m_s", "m/s"),
        linear("normal_n", "N"),
        linear("tangential_n", "N"),
        linear("impulse_n_s", "N·s"),
        linear("point_x_m", "m"),
        linear("point_y_m", "m"),
        linear("normal_x", ""),
        linear("normal_y", ""),
        Quantity { key: "sliding_power_w", unit: "W", interpolation: Interpolation::Derived },
    ];

    fn values(&self) -> [f64; 11] {
        let Self { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal } = *self;
        let ([px, py], [nx, ny]) = (point_m, normal);
        // The difference from zero has no negative zero.
        let sliding_power_w = 0.0 - tangential_n * slip_m_s;
        [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, px, py, nx, ny, sliding_power_w]
    }

    fn from_values(values: [f64; 11]) -> Self {
        let [gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, px, py, nx, ny, _] = values;
        let (point_m, normal) = ([px, py], [nx, ny]);
        Self { gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal }
    }
}

/// Quantities of a joint limit, and their indices among those of a contact.
const LIMIT_QUANTITIES: [Quantity; 4] = [
    linear("gap_rad", "rad"),
    linear("gap_rate_rad_s", "rad/s"),
    linear("torque_n_m", "N·m"),
    linear("impulse_n_m_s", "N·m·s"),
];
const LIMIT_INDICES: [usize; 4] = [0, 1, 3, 5];

/// Energies, and work since the start of the run, in joules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    pub kinetic_j: f64,
    pub gravity_j: f64,
    pub spring_j: f64,
    /// Energy stored in the Hertz springs of contacts and joint limit, and in cables.
    pub elastic_j: f64,
    /// Energy dissipated in dampers, in friction, and by the clamp of the normal force.
    pub dissipated_j: f64,
    /// Work of the motor.
    pub motor_work_j: f64,
    /// kinetic + gravity + spring + elastic + dissipated − motor work, minus the same sum at the start. It is zero if
    /// energy is conserved.
    pub balance_j: f64,
    /// Part of `dissipated_j` of the friction of cables. Only samples with places of cables have this channel.
    #[serde(skip_serializing_if = "is_zero")]
    pub cable_friction_j: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Number of energies of all samples.
const COMMON_ENERGIES: usize = 7;

impl State<8> for Energy {
    const QUANTITIES: [Quantity; 8] = [
        linear("kinetic_j", "J"),
        linear("gravity_j", "J"),
        linear("spring_j", "J"),
        linear("elastic_j", "J"),
        linear("dissipated_j", "J"),
        linear("motor_work_j", "J"),
        linear("balance_j", "J"),
        linear("cable_friction_j", "J"),
    ];

    fn values(&self) -> [f64; 8] {
        let Self { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j, cable_friction_j } =
            *self;
        [kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j, cable_friction_j]
    }

    fn from_values(values: [f64; 8]) -> Self {
        let [kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j, cable_friction_j] =
            values;
        Self { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j, cable_friction_j }
    }
}

/// State of a finger, as a view of its joints. Its serialised form contains the angles, and only the rates of the
/// independent coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FingerState {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
    pub q12_rad: f64,
    /// Orientation of l22: q21 + q22.
    pub q13_rad: f64,
    #[serde(skip)]
    pub qd12_rad_s: f64,
    #[serde(skip)]
    pub qd22_rad_s: f64,
}

/// A subject, such as a joint, a body or a contact, to which channels belong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subject {
    pub kind: SubjectKind,
    /// Name, such as `q11`, `right_distal` or `hammer-anvil`; `energy` for the energies.
    pub name: String,
    /// Index of the first number of the subject in a sample.
    pub first: usize,
    /// Beginning of the names of its columns: its name, unless an earlier subject has a column of such a name.
    column: String,
    /// See [`Schema::has_joint_forces`].
    has_joint_forces: bool,
    /// Whether samples have places of cables.
    has_cables: bool,
}

impl Subject {
    /// Returns the quantities, each with its index in a sample.
    pub fn quantities(&self) -> impl Iterator<Item = (usize, &'static Quantity)> + '_ {
        let count = match self.kind {
            SubjectKind::Joint | SubjectKind::Slider if !self.has_joint_forces => JOINT_MOTION,
            SubjectKind::Energy if !self.has_cables => COMMON_ENERGIES,
            _ => usize::MAX,
        };
        self.kind.quantities().take(count).map(|(k, quantity)| (self.first + k, quantity))
    }

    /// Returns the quantities that are not derived from others, each with its index in a sample.
    pub fn independent(&self) -> impl Iterator<Item = (usize, &'static Quantity)> + '_ {
        self.quantities().filter(|(_, quantity)| quantity.interpolation != Interpolation::Derived)
    }

    /// Returns the quantities of the subject, each with its channel.
    pub fn channels(&self) -> impl Iterator<Item = (&'static Quantity, Channel)> + '_ {
        let Self { kind, column, first, .. } = self;
        self.quantities().map(move |(index, quantity)| {
            let source = match kind {
                SubjectKind::Contact | SubjectKind::Limit => ValueSource::Contact(index, *first),
                _ => ValueSource::Value(index),
            };
            (quantity, Channel { name: column_name(*kind, column, quantity.key), unit: quantity.unit, source })
        })
    }
}

/// One number of a sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name with unit, such as `distal_normal_n`.
    pub name: String,
    /// SI unit, such as `m/s`.
    pub unit: &'static str,
    pub(super) source: ValueSource,
}

impl Channel {
    /// Index of its number in the numbers of a sample; `None` for the time.
    pub(crate) fn index(&self) -> Option<usize> {
        match self.source {
            ValueSource::Time => None,
            ValueSource::Value(index) | ValueSource::Contact(index, _) => Some(index),
        }
    }
}

/// Where the number of a channel is in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueSource {
    Time,
    Value(usize),
    /// A number of a contact, and the index of its gap.
    Contact(usize, usize),
}

/// Names of the subjects in the samples of a scene, in their order. They determine the channels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schema {
    /// Names of the fingers; the name of a single finger is empty. Joints and motors of the fingers are contained in
    /// `joints` and `actuators`.
    pub fingers: Vec<String>,
    pub joints: Vec<JointName>,
    pub actuators: Vec<JointName>,
    pub tendons: Vec<String>,
    /// Places of cables: `flexor[2]` is the third on the path of the tendon `flexor`.
    pub elements: Vec<String>,
    /// Actuators with a gear or an electric motor.
    pub shafts: Vec<String>,
    /// Actuators with an electric motor.
    pub motors: Vec<String>,
    /// Actuators that control a distance.
    pub distances: Vec<String>,
    pub bodies: Vec<String>,
    pub contacts: Vec<ContactName>,
    /// Number of joint limits; they are the last contacts.
    pub limits: usize,
    /// Whether the forces of joints are among the channels. Samples always contain these numbers; without channels they
    /// are 0.
    pub has_joint_forces: bool,
}

/// Name of a joint or actuator of a sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JointName {
    pub name: String,
    /// Whether the joint is prismatic.
    pub is_linear: bool,
}

/// Name of a contact of a sample.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ContactName {
    pub name: String,
    /// Whether the gap is an angle, as for the limit of a revolute joint. Then read rad for m, and N·m for N.
    pub is_angular: bool,
}

impl ContactName {
    /// Kind of the subject.
    pub fn kind(&self) -> SubjectKind {
        if self.is_angular { SubjectKind::Limit } else { SubjectKind::Contact }
    }
}

/// Name of the column of times.
const TIME: &str = "time_s";

impl Schema {
    /// Returns the schema of a scene. Contacts are in the order of [`Mechanism::point_contacts`], then of
    /// [`Mechanism::limits`].
    pub fn from_scene(scene: &Scene) -> Self {
        Self { fingers: finger_names(scene.finger_count()), ..Self::from_mechanism(&scene.drawn_mechanism()) }
    }

    fn from_mechanism(mechanism: &Mechanism) -> Self {
        let is_linear = |joint: &Joint| !joint.kind.is_angle();
        let joint_name = |name: &str, joint| JointName { name: name.to_string(), is_linear: is_linear(joint) };
        let contact = |name, is_angular| ContactName { name, is_angular };
        let surfaces = mechanism.point_contacts().into_iter().map(|point| contact(point.name, false));
        let pulls = mechanism.tendons.iter().filter_map(|tendon| tendon.actuator.as_ref());
        let limits = mechanism.limits();
        let limit_names = limits.iter().map(|limit| {
            // The limit of a prismatic joint has the units of a contact between surfaces.
            contact(mechanism.limit_name(limit), mechanism.is_angular(limit))
        });
        Self {
            fingers: Vec::new(),
            joints: mechanism.joints.iter().map(|joint| joint_name(&joint.name, joint)).collect(),
            actuators: mechanism
                .actuators
                .iter()
                .map(|actuator| joint_name(&actuator.name, &mechanism.joints[actuator.on.terms[0].0]))
                .chain(pulls.map(|actuator| JointName { name: actuator.name.clone(), is_linear: true }))
                .collect(),
            tendons: mechanism.tendons.iter().map(|tendon| tendon.name.clone()).collect(),
            elements: mechanism
                .reported_elements()
                .map(|[tendon, element]| mechanism.element_name(tendon, element))
                .collect(),
            shafts: actuators_with(mechanism, Powertrain::has_shaft),
            motors: actuators_with(mechanism, |powertrain| powertrain.motor.is_some()),
            distances: actuators_with(mechanism, |powertrain| powertrain.feedback.is_some()),
            bodies: mechanism.reported_bodies().map(|body| mechanism.bodies[body].name.clone()).collect(),
            contacts: surfaces.chain(limit_names).collect(),
            limits: limits.len(),
            has_joint_forces: true,
        }
    }

    /// Whether the subjects are those of a mechanism; otherwise they are those of five-bar fingers.
    pub fn is_mechanism(&self) -> bool {
        self.fingers.is_empty()
    }

    /// Returns the schema of `count` fingers with motors, a free object, a palm, a table and joint limits. A single
    /// finger has a fixed object and neither palm nor table.
    pub fn for_fingers(count: usize) -> Self {
        let fingers = finger_names(count);
        let of_finger = |finger: &str, part: &str| JointName {
            name: if finger.is_empty() { part.to_string() } else { format!("{finger}_{part}") },
            is_linear: false,
        };
        let is_possible = |contact: &HandContact| match contact {
            HandContact::Finger(side, _) => (*side as usize) < count,
            HandContact::Palm | HandContact::Table => count == 2,
        };
        let possible = HandContact::ALL.into_iter().filter(is_possible);
        let (limits, surfaces): (Vec<_>, Vec<_>) = possible.partition(|contact| contact.is_stop());
        let contact =
            |contact: &HandContact| ContactName { name: contact.name_for(count), is_angular: contact.is_stop() };
        Schema {
            joints: fingers.iter().flat_map(|finger| FINGER_JOINTS.map(|joint| of_finger(finger, joint))).collect(),
            actuators: fingers.iter().map(|finger| of_finger(finger, "motor")).collect(),
            fingers,
            tendons: Vec::new(),
            elements: Vec::new(),
            shafts: Vec::new(),
            motors: Vec::new(),
            distances: Vec::new(),
            bodies: if count == 2 { vec![Object::NAME.to_string()] } else { Vec::new() },
            contacts: surfaces.iter().chain(&limits).map(contact).collect(),
            limits: limits.len(),
            has_joint_forces: true,
        }
    }

    /// Adds a subject after the others of its kind, unless there is one with its name. `is_limit` states whether it is
    /// the contact of a joint with its limit. Every schema already contains the energies.
    pub fn add_subject(&mut self, kind: SubjectKind, is_limit: bool, name: &str) {
        let has_name = |names: &[JointName]| names.iter().any(|known| known.name == name);
        let named = |is_linear| JointName { name: name.to_string(), is_linear };
        match kind {
            SubjectKind::Joint | SubjectKind::Slider if !has_name(&self.joints) => {
                self.joints.push(named(kind == SubjectKind::Slider));
            }
            SubjectKind::Actuator | SubjectKind::LinearActuator if !has_name(&self.actuators) => {
                self.actuators.push(named(kind == SubjectKind::LinearActuator));
            }
            SubjectKind::Tendon if !self.tendons.iter().any(|known| known == name) => {
                self.tendons.push(name.to_string())
            }
            SubjectKind::CableElement if !self.elements.iter().any(|known| known == name) => {
                self.elements.push(name.to_string());
            }
            SubjectKind::Shaft | SubjectKind::Motor | SubjectKind::Distance => {
                let names = match kind {
                    SubjectKind::Shaft => &mut self.shafts,
                    SubjectKind::Motor => &mut self.motors,
                    _ => &mut self.distances,
                };
                if !names.iter().any(|known| known == name) {
                    names.push(name.to_string());
                }
            }
            SubjectKind::Body if !self.bodies.iter().any(|known| known == name) => self.bodies.push(name.to_string()),
            SubjectKind::Contact | SubjectKind::Limit if !self.contacts.iter().any(|known| known.name == name) => {
                let index = if is_limit { self.contacts.len() } else { self.surfaces().end };
                self.limits += usize::from(is_limit);
                self.contacts.insert(index, ContactName { name: name.to_string(), is_angular: kind.is_angular() });
            }
            _ => {}
        }
    }

    /// Whether samples of a scene have exactly the subjects of this schema.
    pub fn has_subjects_of(&self, scene: &Scene) -> bool {
        Schema { has_joint_forces: self.has_joint_forces, ..Schema::from_scene(scene) } == *self
    }

    /// Indices of the contacts between surfaces: all contacts except joint limits.
    pub fn surfaces(&self) -> Range<usize> {
        0..self.contacts.len() - self.limits
    }

    /// Returns the number of subjects of each kind.
    pub fn counts(&self) -> Counts {
        Counts {
            fingers: self.fingers.len(),
            joints: self.joints.len(),
            actuators: self.actuators.len(),
            tendons: self.tendons.len(),
            elements: self.elements.len(),
            shafts: self.shafts.len(),
            motors: self.motors.len(),
            distances: self.distances.len(),
            bodies: self.bodies.len(),
            contacts: self.contacts.len(),
            limits: self.limits,
        }
    }

    /// Returns the subjects in their order in a sample: joints, actuators, tendons, places of cables, shafts, motors, distances,
    /// bodies, contacts, energies.
    pub fn subjects(&self) -> Vec<Subject> {
        let counts = self.counts();
        let has_joint_forces = self.has_joint_forces;
        let present = |kind, name: &str, first| {
            let [name, column] = [(); 2].map(|()| name.to_string());
            Subject { kind, name, first, column, has_joint_forces, has_cables: !self.elements.is_empty() }
        };
        let joints = self.joints.iter().enumerate().map(|(k, JointName { name, is_linear })| {
            present(if *is_linear { SubjectKind::Slider } else { SubjectKind::Joint }, name, counts.joint(k))
        });
        let actuators = self.actuators.iter().enumerate().map(|(k, JointName { name, is_linear })| {
            let kind = if *is_linear { SubjectKind::LinearActuator } else { SubjectKind::Actuator };
            present(kind, name, counts.actuator(k))
        });
        let tendons = self.tendons.iter().enumerate();
        let tendons = tendons.map(|(k, name)| present(SubjectKind::Tendon, name, counts.tendon(k)));
        let mut subjects: Vec<Subject> = joints.chain(actuators).chain(tendons).collect();
        let elements = self.elements.iter().enumerate();
        subjects.extend(elements.map(|(k, name)| present(SubjectKind::CableElement, name, counts.element(k))));
        let shafts = self.shafts.iter().enumerate();
        subjects.extend(shafts.map(|(k, name)| present(SubjectKind::Shaft, name, counts.shaft(k))));
        let motors = self.motors.iter().enumerate();
        subjects.extend(motors.map(|(k, name)| present(SubjectKind::Motor, name, counts.motor(k))));
        let distances = self.distances.iter().enumerate();
        subjects.extend(distances.map(|(k, name)| present(SubjectKind::Distance, name, counts.distance(k))));
        let bodies = self.bodies.iter().enumerate();
        subjects.extend(bodies.map(|(k, name)| present(SubjectKind::Body, name, counts.body(k))));
        let contacts = self.contacts.iter().enumerate();
        subjects.extend(contacts.map(|(k, contact)| present(contact.kind(), &contact.name, counts.contact(k))));
        subjects.push(present(SubjectKind::Energy, "energy", counts.energy()));
        make_columns_unique(&mut subjects);
        subjects
    }

    /// Returns the channel of a quantity of a subject, such as `gap_m` of the contact `distal`.
    ///
    /// # Panics
    /// Panics if there is no such channel.
    pub fn channel(&self, kind: SubjectKind, subject: &str, key: &str) -> Channel {
        let found = self.subjects().into_iter().find(|found| found.kind == kind && found.name == subject);
        let channel = found.and_then(|subject| subject.channels().find(|(quantity, _)| quantity.key == key));
        channel.unwrap_or_else(|| panic!("no quantity `{key}` of the {} `{subject}`", kind.name())).1
    }

    /// Returns all channels, the time first and the energies last.
    pub fn channels(&self) -> Vec<Channel> {
        let mut channels = vec![Channel { name: TIME.to_string(), unit: "s", source: ValueSource::Time }];
        for subject in self.subjects() {
            channels.extend(subject.channels().map(|(_, channel)| channel));
        }
        channels
    }
}

/// Names of the actuators with such a powertrain.
fn actuators_with(mechanism: &Mechanism, has: impl Fn(&Powertrain) -> bool) -> Vec<String> {
    let chosen = mechanism.actuators.iter().filter(|actuator| has(&actuator.powertrain));
    chosen.map(|actuator| actuator.name.clone()).collect()
}

/// Names of fingers; that of a single finger is empty.
fn finger_names(count: usize) -> Vec<String> {
    let sides = Side::BOTH.iter().take(count);
    sides.map(|side| if count == 1 { String::new() } else { side.name().to_string() }).collect()
}

/// Gives the columns of all subjects different names. A subject whose columns would have the name of a column of an
/// earlier subject has its kind before its name: the body `arm` beside a joint `arm_angle` has the column
/// `body_arm_angle_rad`. Forces of joints count even if they are left out, so that names do not depend on them.
fn make_columns_unique(subjects: &mut [Subject]) {
    let names = |subject: &Subject, column: &str| -> Vec<String> {
        subject.kind.quantities().map(|(_, quantity)| column_name(subject.kind, column, quantity.key)).collect()
    };
    let energies = Energy::QUANTITIES.iter().map(|quantity| quantity.key);
    let mut taken: HashSet<String> = energies.chain([TIME]).map(str::to_string).collect();
    for subject in subjects.iter_mut().filter(|subject| subject.kind != SubjectKind::Energy) {
        let (kind, name) = (subject.kind.name(), &subject.name);
        let numbered = (2..).map(|number| format!("{kind}{number}_{name}"));
        let mut candidates = [name.clone(), format!("{kind}_{name}")].into_iter().chain(numbered);
        let is_free = |column: &String| names(subject, column).iter().all(|name| !taken.contains(name));
        subject.column = candidates.find(is_free).expect("numbers do not end");
        taken.extend(names(subject, &subject.column));
    }
}

/// Name of the column of a quantity. Those of a joint are its coordinate: `q11_rad`, `qd11_rad_s`.
fn column_name(kind: SubjectKind, subject: &str, key: &str) -> String {
    match (kind, key) {
        (SubjectKind::Energy, _) => key.to_string(),
        (SubjectKind::Joint, "angle_rad") => format!("{subject}_rad"),
        (SubjectKind::Joint, "rate_rad_s") => match subject.rsplit_once('q') {
            Some((finger, index)) if index.chars().all(|digit| digit.is_ascii_digit()) => {
                format!("{finger}qd{index}_rad_s")
            }
            _ => format!("{subject}_rate_rad_s"),
        },
        _ => format!("{subject}_{key}"),
    }
}

/// Whether these are the names of the channels of a run. Such names begin with the time and end with the energies.
pub fn are_sample_columns(columns: &[&str]) -> bool {
    let energies = Energy::QUANTITIES.map(|quantity| quantity.key);
    let ends_with_energies = columns.ends_with(&energies) || columns.ends_with(&energies[..COMMON_ENERGIES]);
    columns.len() > COMMON_ENERGIES && columns[0] == TIME && ends_with_energies
}

/// Number of subjects of each kind in a sample. They determine the places of the numbers of a subject.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub fingers: usize,
    /// Joints, including those of fingers.
    pub joints: usize,
    /// Actuators, including those of fingers.
    pub actuators: usize,
    pub tendons: usize,
    /// Places of cables.
    pub elements: usize,
    pub shafts: usize,
    pub motors: usize,
    pub distances: usize,
    pub bodies: usize,
    pub contacts: usize,
    /// Number of joint limits; they are the last contacts.
    pub limits: usize,
}

impl Counts {
    /// Returns the index of a contact of a single finger; `None` if its scene has no such contact.
    ///
    /// # Panics
    /// Panics if the number of fingers is not one.
    pub fn finger_contact(self, contact: FingerContact) -> Option<usize> {
        assert_eq!(self.fingers, 1, "a sample without a single finger has no contact of a finger");
        let surfaces = self.contacts - self.limits;
        match contact {
            FingerContact::Limit => (self.limits > 0).then_some(surfaces),
            FingerContact::Proximal | FingerContact::Distal => Some(contact as usize).filter(|index| *index < surfaces),
        }
    }

    pub(super) fn joint(self, index: usize) -> usize {
        JointState::QUANTITIES.len() * index
    }

    pub(super) fn actuator(self, index: usize) -> usize {
        self.joint(self.joints) + ActuatorState::QUANTITIES.len() * index
    }

    pub(super) fn tendon(self, index: usize) -> usize {
        self.actuator(self.actuators) + TendonState::QUANTITIES.len() * index
    }

    pub(super) fn element(self, index: usize) -> usize {
        self.tendon(self.tendons) + CableElementState::QUANTITIES.len() * index
    }

    pub(super) fn shaft(self, index: usize) -> usize {
        self.element(self.elements) + ShaftState::QUANTITIES.len() * index
    }

    pub(super) fn motor(self, index: usize) -> usize {
        self.shaft(self.shafts) + MotorState::QUANTITIES.len() * index
    }

    pub(super) fn distance(self, index: usize) -> usize {
        self.motor(self.motors) + DistanceState::QUANTITIES.len() * index
    }

    pub(super) fn body(self, index: usize) -> usize {
        self.distance(self.distances) + BodyState::QUANTITIES.len() * index
    }

    pub(super) fn contact(self, index: usize) -> usize {
        self.body(self.bodies) + ContactSample::QUANTITIES.len() * index
    }

    pub(super) fn energy(self) -> usize {
        self.contact(self.contacts)
    }

    /// Returns the number of numbers in a sample.
    pub(crate) fn values(self) -> usize {
        self.energy() + Energy::QUANTITIES.len()
    }
}
