//! Constant data of fingers, discs and contacts, and the coordinates that they depend on.

use crate::analytic::ContactState;
use crate::analytic::finger::FingerModel;
use crate::fivebar::inertial_forces::InertialForces;
use crate::gripper::FingerContact;
use crate::law::{Bristle, FrictionLaw, NormalLaw};
use crate::scene::{Disc, DiscMotion, Side};
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

/// A half plane that only discs can touch: `normal` points towards the discs; the surface is at −`offset` along
/// `normal`.
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

/// A contact with its laws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactModel {
    pub pair: ContactPair,
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Index of the contact's bristle state among the rates, if the contact has a bristle.
    pub bristle_index: Option<usize>,
}

/// Laws of one contact, and the branch that is active.
#[derive(Clone, Copy)]
pub(crate) struct ContactLaws<'a> {
    pub normal: &'a NormalLaw,
    pub friction: Option<&'a FrictionLaw>,
    pub state: ContactState,
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
    /// Creates a horizontal half plane whose surface is at y = `level_m`: solid below it for `up` = 1, above it for
    /// `up` = −1.
    pub(crate) fn at_level(level_m: f64, up: f64) -> Self {
        Self { normal: [0.0, up], offset: -up * level_m }
    }
}

impl ContactModel {
    pub fn new(pair: ContactPair, law: (NormalLaw, Option<FrictionLaw>)) -> Self {
        Self { pair, normal: law.0, friction: law.1, bristle_index: None }
    }

    /// Returns the laws if the contact has a force in this state.
    #[inline(always)]
    pub fn laws(&self, state: ContactState) -> Option<ContactLaws<'_>> {
        state.has_force().then_some(ContactLaws { normal: &self.normal, friction: self.friction.as_ref(), state })
    }

    /// Returns the bristle of the friction law.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}

/// Index of a coordinate, and the sign of its contribution. An index beyond the last represents a coordinate of a fixed
/// disc.
pub(crate) type SignedIndex = (usize, f64);

/// Indices of the coordinates of a finger.
#[inline(always)]
pub(crate) fn finger_indices(finger: usize) -> [SignedIndex; 2] {
    [(2 * finger, 1.0), (2 * finger + 1, 1.0)]
}

/// Indices of the coordinates of a disc.
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
