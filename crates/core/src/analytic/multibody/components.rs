//! Constant data of fingers, object and contacts, and the coordinates that they depend on.

use super::GraspMode;
use crate::analytic::closed_form::FingerModel;
use crate::analytic::contact::ContactLaws;
use crate::drive::BrakeTorque;
use crate::fivebar::dynamics::InertialForces;
use crate::gripper::FingerContact;
use crate::law::{Bristle, FrictionLaw, NormalLaw};
use crate::scene::{Brake, Motor, Object, ObjectMotion, Profile, Side};
use crate::shape::Shape;

/// Constant data of a finger.
#[derive(Clone, Debug)]
pub(crate) struct FingerComponent {
    pub side: Side,
    pub model: FingerModel,
    pub inertial_load: InertialForces,
}

/// The object. Masses and their inverses are 0 if it is fixed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObjectComponent {
    pub shape: Shape,
    pub mass: f64,
    pub inertia: f64,
    pub inverse_mass: f64,
    pub inverse_inertia: f64,
    /// Pose (x, y, θ) at the start; a fixed object keeps it.
    pub pose: [f64; 3],
}

/// A half plane that only the object can touch. `normal` points towards it; the surface is at −`offset` along it.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: [f64; 2],
    pub offset: f64,
}

/// The two surfaces of a contact. A finger is given by its index.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ContactPair {
    Phalanx {
        finger: usize,
        phalanx: FingerContact,
    },
    Stop {
        finger: usize,
    },
    Plane(Plane),
    /// A table at rest in the world, seen from a moving frame.
    MovingPlane(Plane),
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactModel {
    pub pair: ContactPair,
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Index of the contact's bristle state among the rates, if the contact has a bristle.
    pub bristle_index: Option<usize>,
}

impl ObjectComponent {
    pub fn new(object: &Object) -> Self {
        let ([x, y], angle) = (object.centre_m, object.angle_rad);
        let [mass, inertia, inverse_mass, inverse_inertia] = match object.motion {
            ObjectMotion::Fixed => [0.0; 4],
            ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } => {
                [mass_kg, inertia_kg_m2, mass_kg.recip(), inertia_kg_m2.recip()]
            }
        };
        Self { shape: object.shape, mass, inertia, inverse_mass, inverse_inertia, pose: [x, y, angle] }
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
    pub fn laws(&self, mode: &GraspMode, index: usize) -> Option<ContactLaws<'_>> {
        ContactLaws::in_mode(mode, index, (&self.normal, self.friction.as_ref()))
    }

    /// Returns the bristle of the friction law.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}

/// Index of a coordinate, and the sign of its contribution. An index beyond the last belongs to a fixed object.
pub(crate) type SignedIndex = (usize, f64);

#[inline(always)]
pub(crate) fn finger_indices(finger: usize) -> [SignedIndex; 2] {
    [(2 * finger, 1.0), (2 * finger + 1, 1.0)]
}

#[inline(always)]
pub(crate) fn object_indices(first: usize) -> [SignedIndex; 3] {
    [(first, 1.0), (first + 1, 1.0), (first + 2, 1.0)]
}

/// Indices of x and y of the object, time, and the angle of the object, in this order.
#[inline(always)]
pub(crate) fn object_time_indices(first: usize, time: usize) -> [SignedIndex; 4] {
    [(first, 1.0), (first + 1, 1.0), (time, 1.0), (first + 2, 1.0)]
}

/// Indices of the coordinates of a phalanx's contact, with the object's coordinates in the finger's frame.
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
pub struct HandDrive {
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

impl HandDrive {
    pub fn new(motor: &Motor, weights: [f64; 2]) -> Self {
        let Motor { actuation, no_load_speed_rad_s, brake, .. } = motor;
        Self { actuation: actuation.clone(), weights, no_load_speed: *no_load_speed_rad_s, brake: *brake }
    }

    #[inline(always)]
    fn rate(&self, driven_rates: [f64; 2]) -> f64 {
        self.weights[0] * driven_rates[0] + self.weights[1] * driven_rates[1]
    }

    /// Torque of the brake on the shaft, if the drive has one.
    #[inline(always)]
    pub fn brake_torque(
        &self,
        t: f64,
        driven_rates: [f64; 2],
        bristle_state: Option<f64>,
    ) -> Option<(ShaftTorque, BrakeTorque)> {
        let (brake, rate) = (self.brake.as_ref()?, self.rate(driven_rates));
        let brake = brake.torque(t, rate, bristle_state);
        let [torque, by_rate, by_time] = brake.torque;
        Some((ShaftTorque { rate, torque, by_rate, by_time }, brake))
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
