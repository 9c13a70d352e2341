//! Discs and half planes.

use crate::gripper::Circle;
use crate::law::ContactLaw;

/// A disc and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    pub name: String,
    pub radius_m: f64,
    /// Where its centre starts.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: DiscMotion,
}

/// What moves a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscMotion {
    Fixed,
    /// Moves as told, whatever it meets: x(t) = centre + velocity t + ½ acceleration t², angle = spin t.
    Driven {
        velocity_m_s: [f64; 2],
        acceleration_m_s2: [f64; 2],
        spin_rad_s: f64,
    },
    /// Moves under gravity and contact. `inertia_kg_m2` is `None` for a disc that does not turn.
    Free {
        mass_kg: f64,
        inertia_kg_m2: Option<f64>,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

/// A surface along x at some height. That of a palm or of the ground is solid below it, that of a table above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    pub level_m: f64,
    /// Law by which discs touch it; `None` where nothing can reach it.
    pub contact: Option<ContactLaw>,
}

impl DiscMotion {
    pub fn moves(&self) -> bool {
        !matches!(self, DiscMotion::Fixed)
    }
}

impl Disc {
    /// Name of the one that fingers grasp.
    pub const OBJECT: &str = "object";

    /// What fingers grasp, of a size at a place: it does not move.
    pub fn object(circle: Circle) -> Self {
        let Circle { radius_m, centre_m } = circle;
        Self { name: Self::OBJECT.to_string(), radius_m, centre_m, angle_rad: 0.0, motion: DiscMotion::Fixed }
    }

    /// The disc as postures and grasps know it.
    pub fn circle(&self) -> Circle {
        Circle { radius_m: self.radius_m, centre_m: self.centre_m }
    }
}
