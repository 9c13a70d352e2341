//! Free, driven and fixed bodies ("discs" of any shape), and half planes.

use crate::law::ContactLaw;
use crate::shape::{PlacedShape, Shape};

/// A body with its shape and motion; called a disc whatever its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    pub name: String,
    pub shape: Shape,
    /// Initial position of the centre.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: DiscMotion,
}

/// Motion of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscMotion {
    Fixed,
    /// Prescribed motion, not affected by contacts: x(t) = centre + velocity t + ½ acceleration t², angle = spin t.
    Driven {
        velocity_m_s: [f64; 2],
        acceleration_m_s2: [f64; 2],
        spin_rad_s: f64,
    },
    /// Moves under gravity and contact forces. `inertia_kg_m2` is `None` for a disc that does not rotate.
    Free {
        mass_kg: f64,
        inertia_kg_m2: Option<f64>,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

/// A half plane bounded by a horizontal line: solid below it for a palm or the ground, above it for a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    pub level_m: f64,
    /// Law of its contacts with discs; `None` if no moving disc can reach it.
    pub contact: Option<ContactLaw>,
}

impl DiscMotion {
    pub fn moves(&self) -> bool {
        !matches!(self, DiscMotion::Fixed)
    }
}

impl Disc {
    /// Name of the grasped object.
    pub const OBJECT: &str = "object";

    /// Creates a fixed object.
    pub fn fixed_object(placed: PlacedShape) -> Self {
        let PlacedShape { shape, centre_m, angle_rad } = placed;
        Self { name: Self::OBJECT.to_string(), shape, centre_m, angle_rad, motion: DiscMotion::Fixed }
    }

    /// Shape and initial pose.
    pub fn placed(&self) -> PlacedShape {
        PlacedShape { shape: self.shape, centre_m: self.centre_m, angle_rad: self.angle_rad }
    }
}
