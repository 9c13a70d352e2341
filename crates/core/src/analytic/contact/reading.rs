//! What is read of a contact, and of the energies, in one state.

use crate::numeric::plane::{Vector, perp};
use crate::shape::Support;

/// Geometry of one contact (thesis (B.1)–(B.2), errata 5): the gap, and the rows that give the gap rate and the slip
/// from q̇_a.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<T> {
    /// Distance between the surfaces, −δ; negative in penetration.
    pub gap: T,
    /// Rate of the gap = normal_row · q̇_a.
    pub normal_row: [T; 2],
    /// Slip velocity = tangent_row · q̇_a.
    pub tangent_row: [T; 2],
    /// Unit normal from the object to the phalanx.
    pub normal: Vector<T>,
    /// Contact point on the surface of the phalanx.
    pub point: Vector<T>,
    /// Support function of the object along the normal.
    pub support: Support<T>,
}

/// Energies of one state, in J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    pub kinetic: f64,
    pub gravity: f64,
    pub spring: f64,
    pub elastic: f64,
}

/// Geometry, kinematics and forces of one contact in one state.
#[derive(Clone, Copy, Debug)]
pub struct ContactReading {
    pub geometry: Geometry<f64>,
    /// Penetration δ.
    pub delta: f64,
    pub delta_rate: f64,
    pub slip: f64,
    /// Normal force (limit: torque), clamped to ≥ 0.
    pub normal: f64,
    /// Friction force.
    pub tangential: f64,
}

impl ContactReading {
    /// Force on the phalanx, N.
    pub(crate) fn force(&self) -> [f64; 2] {
        let ([x, y], tangent) = (self.geometry.normal, perp(self.geometry.normal));
        [self.normal * x + self.tangential * tangent[0], self.normal * y + self.tangential * tangent[1]]
    }
}
