//! Constant data of fingers, discs and contacts, and the coordinates that they depend on.

use crate::analytic::ContactState;
use crate::analytic::finger::FingerModel;
use crate::analytic::mode::Mode;
use crate::fivebar::dynamics::InertialForces;
use crate::gripper::FingerContact;
use crate::law::{Bristle, FrictionLaw, FrictionRange, NormalLaw};
use crate::scene::{Brake, Disc, DiscMotion, Hand, Motor, Profile, Side};
use crate::shape::Shape;

/// Constant data of a finger, and indices of its contacts.
#[derive(Clone, Debug)]
pub(crate) struct FingerComponent {
    pub side: Side,
    pub model: FingerModel,
    pub inertial_load: InertialForces,
    /// Indices of the finger's contacts among all contacts.
    pub contacts: Vec<usize>,
}

/// A disc. Both inverses are 0 if it is fixed or driven; the inverse inertia is also 0 if it cannot turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DiscComponent {
    /// Index of the first of the component's three coordinates; beyond the last coordinate if the component is fixed.
    pub first_coordinate: usize,
    pub shape: Shape,
    /// Mass in kinetic and gravity energy; 0 if the disc does not move freely.
    pub mass: f64,
    pub inertia: f64,
    pub inverse_mass: f64,
    pub inverse_inertia: f64,
    /// Pose (x, y, θ) at the start; a fixed disc keeps it.
    pub pose: [f64; 3],
    /// Acceleration of a driven disc, m/s².
    pub prescribed_acceleration: Option<[f64; 2]>,
}

/// A half plane that only discs can touch. `normal` points towards them; the surface is at −`offset` along it.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: [f64; 2],
    pub offset: f64,
}

/// The two surfaces of a contact; fingers and discs are given by their indices.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ContactPair {
    Phalanx {
        finger: usize,
        phalanx: FingerContact,
        disc: usize,
    },
    Stop {
        finger: usize,
    },
    Discs {
        disc: usize,
        other: usize,
    },
    Plane {
        disc: usize,
        plane: Plane,
    },
    /// A table at rest in the world, seen from a moving frame.
    MovingPlane {
        disc: usize,
        plane: Plane,
    },
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactModel {
    pub pair: ContactPair,
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Index of the contact's bristle state among the rates, if the contact has a bristle.
    pub bristle_index: Option<usize>,
}

/// Laws of one contact, the active branch, and the range of the friction law.
#[derive(Clone, Copy)]
pub(crate) struct ContactLaws<'a> {
    pub normal: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub state: ContactState,
    pub range: FrictionRange,
}

impl DiscComponent {
    pub fn new(disc: &Disc, first_coordinate: usize) -> Self {
        let ([x, y], angle) = (disc.centre_m, disc.angle_rad);
        let fixed = Self {
            first_coordinate,
            shape: disc.shape,
            mass: 0.0,
            inertia: 0.0,
            inverse_mass: 0.0,
            inverse_inertia: 0.0,
            pose: [x, y, angle],
            prescribed_acceleration: None,
        };
        match disc.motion {
            DiscMotion::Fixed => fixed,
            DiscMotion::Driven { acceleration_m_s2, .. } => {
                Self { prescribed_acceleration: Some(acceleration_m_s2), ..fixed }
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2, .. } => Self {
                mass: mass_kg,
                inertia: inertia_kg_m2.unwrap_or(0.0),
                inverse_mass: mass_kg.recip(),
                inverse_inertia: inertia_kg_m2.map_or(0.0, f64::recip),
                ..fixed
            },
        }
    }
}

impl Plane {
    /// Creates a horizontal half plane with its surface at y = `level_m`, solid below (`up` = 1) or above (`up` = −1).
    pub(crate) fn at_level(level_m: f64, up: f64) -> Self {
        Self { normal: [0.0, up], offset: -up * level_m }
    }
}

impl ContactModel {
    pub fn new(pair: ContactPair, law: (NormalLaw, Option<FrictionLaw>)) -> Self {
        Self { pair, normal: law.0, friction: law.1, bristle_index: None }
    }

    /// Returns the laws if the contact, with this index, has a force in this mode.
    #[inline(always)]
    pub fn laws<const C: usize>(&self, mode: &Mode<C>, index: usize) -> Option<ContactLaws<'_>> {
        let (state, range) = (mode[index], mode.friction_ranges[index]);
        state.has_force().then_some(ContactLaws {
            normal: &self.normal,
            friction: self.friction.as_ref(),
            state,
            range,
        })
    }

    /// Returns the bristle of the friction law.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}

/// Index of a coordinate, and the sign of its contribution. An index beyond the last belongs to a fixed disc.
pub(crate) type SignedIndex = (usize, f64);

#[inline(always)]
pub(crate) fn finger_indices(finger: usize) -> [SignedIndex; 2] {
    [(2 * finger, 1.0), (2 * finger + 1, 1.0)]
}

#[inline(always)]
pub(crate) fn disc_indices(first: usize) -> [SignedIndex; 3] {
    [(first, 1.0), (first + 1, 1.0), (first + 2, 1.0)]
}

/// Indices of x and y of a disc, time, and the angle of the disc, in this order.
#[inline(always)]
pub(crate) fn disc_time_indices(first: usize, time: usize) -> [SignedIndex; 4] {
    [(first, 1.0), (first + 1, 1.0), (time, 1.0), (first + 2, 1.0)]
}

/// Indices of x and y of two discs, then of both angles.
#[inline(always)]
pub(crate) fn disc_pair_indices([a, b]: [usize; 2]) -> [SignedIndex; 6] {
    [(a, 1.0), (a + 1, 1.0), (b, 1.0), (b + 1, 1.0), (a + 2, 1.0), (b + 2, 1.0)]
}

/// Indices of the coordinates of a phalanx's contact, with the disc's coordinates in the finger's frame.
#[inline(always)]
pub(crate) fn phalanx_indices(finger: usize, first: usize, mirror: f64) -> [SignedIndex; 5] {
    let [a, b] = finger_indices(finger);
    [a, b, (first, mirror), (first + 1, 1.0), (first + 2, mirror)]
}

/// Adds derivatives with respect to the coordinates `indices` to a row of derivatives with respect to all coordinates.
#[inline(always)]
pub fn scatter<const N: usize>(row: &mut [f64; N], indices: &[SignedIndex], derivatives: &[f64]) {
    for ((index, sign), derivative) in indices.iter().zip(derivatives) {
        if *index < N {
            row[*index] += sign * derivative;
        }
    }
}

/// A motor with its brake. `weights` are the parts of its torque that act on the driven links (right, left).
#[derive(Clone, Debug)]
pub struct Drive {
    actuation: Profile,
    pub weights: [f64; 2],
    no_load_speed: Option<f64>,
    brake: Option<Brake>,
}

/// A torque on a drive's shaft at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShaftTorque {
    /// Rate of the shaft, rad/s.
    pub rate: f64,
    /// Torque, N·m.
    pub torque: f64,
    /// Derivative of the torque with respect to the rate.
    pub by_rate: f64,
    /// Derivative of the torque with respect to time.
    pub by_time: f64,
}

/// The torque of a brake at one instant, and its effect on the state of its bristle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrakeTorque {
    pub shaft: ShaftTorque,
    /// Derivative of the torque with respect to the bristle state.
    pub by_bristle: f64,
    /// Contribution to the rate of the bristle state: `gain` times the torque.
    pub bristle_rate: f64,
    pub gain: f64,
}

impl Drive {
    pub fn new(motor: &Motor, weights: [f64; 2]) -> Self {
        let Motor { actuation, no_load_speed_rad_s, brake, .. } = motor;
        Self { actuation: actuation.clone(), weights, no_load_speed: *no_load_speed_rad_s, brake: *brake }
    }

    #[inline(always)]
    fn rate(&self, driven_rates: [f64; 2]) -> f64 {
        self.weights[0] * driven_rates[0] + self.weights[1] * driven_rates[1]
    }

    /// Torque of the brake, if the drive has one.
    #[inline(always)]
    pub fn brake_torque(&self, t: f64, driven_rates: [f64; 2], bristle_state: Option<f64>) -> Option<BrakeTorque> {
        let (brake, rate) = (self.brake.as_ref()?, self.rate(driven_rates));
        let Some((bristle, bristle_state)) = brake.bristle.as_ref().zip(bristle_state) else {
            let [torque, by_rate, by_time] = brake.torque(t, rate);
            let shaft = ShaftTorque { rate, torque, by_rate, by_time };
            return Some(BrakeTorque { shaft, by_bristle: 0.0, bristle_rate: 0.0, gain: 0.0 });
        };
        let [torque, by_rate, by_time] = brake.bristle_torque(t, rate + bristle_state, bristle);
        // The torque acts on the bristle state in the opposite direction.
        let gain = -bristle.stretch_gain();
        Some(BrakeTorque {
            shaft: ShaftTorque { rate, torque, by_rate, by_time },
            by_bristle: by_rate,
            bristle_rate: gain * torque,
            gain,
        })
    }

    /// Motor torque τ − |τ| q̇/q̇0, for both directions of rotation.
    #[inline(always)]
    pub fn motor_torque(&self, t: f64, driven_rates: [f64; 2]) -> ShaftTorque {
        let rate = self.rate(driven_rates);
        let (full, slope) = self.actuation.at(t);
        let Some(speed) = self.no_load_speed else {
            return ShaftTorque { rate, torque: full, by_rate: 0.0, by_time: slope };
        };
        let by_rate = -full.abs() / speed;
        let by_time = slope - slope * full.signum() * rate / speed;
        ShaftTorque { rate, torque: full + by_rate * rate, by_rate, by_time }
    }

    pub fn bristle(&self) -> Option<Bristle> {
        self.brake.and_then(|brake| brake.bristle)
    }

    pub fn set_actuation(&mut self, actuation: Profile) {
        self.actuation = actuation;
    }

    /// Next time at which the torque of the motor, or a property of the brake, is discontinuous.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let brake = self.brake.as_ref().map_or(f64::INFINITY, |brake| brake.next_discontinuity(t));
        self.actuation.next_discontinuity(t).min(brake)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Number of coordinates, including time and the bristle states.
    pub coordinates: usize,
    pub contacts: usize,
}

/// Largest sizes of a system that has fingers and is no grasp of two fingers: without and with bristles.
pub const MAX_SIZES: [Size; 2] = [Size { coordinates: 14, contacts: 24 }, Size { coordinates: 32, contacts: 24 }];

/// Error for a system too large for the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TooLarge {
    #[error(
        "{moving} discs move and {pairs} pairs of surfaces may come into contact; the analytic model takes up to {MAX_MOVING_DISCS} moving discs and \
         {limit} pairs: fix or remove some"
    )]
    Discs { moving: usize, pairs: usize, limit: usize },
    #[error(
        "fingers, discs and bristles have {} coordinates and {} contacts; the analytic model takes up to {} and {}: fix or remove \
         some discs",
        .size.coordinates, .size.contacts, .limit.coordinates, .limit.contacts
    )]
    Components { size: Size, limit: Size },
}

impl Size {
    pub(crate) fn of_hand(hand: &Hand) -> Self {
        let time = usize::from(hand.palm_motion.is_some());
        let positions = 2 * hand.fingers.len() + 3 * count_moving(hand) + time;
        Self { coordinates: positions + count_bristles(hand), contacts: hand.contact_ids().len() }
    }

    /// Whether this size is within `capacity`.
    pub fn fits(&self, capacity: &Self) -> bool {
        self.coordinates <= capacity.coordinates && self.contacts <= capacity.contacts
    }
}

/// Largest number of moving discs in a system without fingers.
const MAX_MOVING_DISCS: usize = 3;

/// How many discs of a system move.
fn count_moving(hand: &Hand) -> usize {
    hand.discs.iter().filter(|disc| disc.motion.moves()).count()
}

/// How many bristles the contacts and brakes of a system have.
pub(crate) fn count_bristles(hand: &Hand) -> usize {
    let contacts = hand.contact_ids();
    let bristles = contacts.iter().filter_map(|contact| hand.contact_laws(*contact)?.1?.bristle).count();
    let input = hand.differential.iter().map(|differential| &differential.motor);
    let motors = hand.fingers.iter().map(|finger| &finger.motor).chain(input);
    bristles + motors.filter(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some())).count()
}

/// Largest number of contact pairs in a system without fingers.
pub(super) const MAX_DISC_PAIRS: usize = 12;

/// Largest number of contact pairs with bristles in a system without fingers, by its number of moving discs.
const MAX_BRISTLE_PAIRS: [usize; MAX_MOVING_DISCS + 1] = [0, 4, 6, 9];

/// Number of coordinates over which errors are averaged in systems without fingers: all positions, and the largest
/// number of bristles allowed for this number of discs. If only existing bristles counted, a wheel that starts to roll
/// would take 333 steps instead of 33 (scenes/laws/bristle-rolls).
pub(super) fn error_coordinates(hand: &Hand) -> usize {
    let moving_discs = count_moving(hand);
    3 * moving_discs + if hand.has_stiction() { MAX_BRISTLE_PAIRS[moving_discs.min(MAX_MOVING_DISCS)] } else { 0 }
}
