//! Discs, or whatever shape they have, and half planes.

use crate::law::ContactLaw;
use crate::shape::{Placed, Shape};

/// A disc, or a body of another shape, and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    pub name: String,
    pub shape: Shape,
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

    /// What fingers grasp, of a shape at a place: it does not move.
    pub fn object(placed: Placed) -> Self {
        let Placed { shape, centre_m, angle_rad } = placed;
        Self { name: Self::OBJECT.to_string(), shape, centre_m, angle_rad, motion: DiscMotion::Fixed }
    }

    /// Where it starts, as postures and grasps know it.
    pub fn placed(&self) -> Placed {
        Placed { shape: self.shape, centre_m: self.centre_m, angle_rad: self.angle_rad }
    }
}
