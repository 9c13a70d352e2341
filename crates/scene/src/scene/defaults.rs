//! Defaults of scenes: thesis Table 3.2.

use crate::shape::Shape;

pub const DURATION_S: f64 = 0.020;
/// The gripper hangs upside down: gravity pulls the object out of it.
pub const GRAVITY_M_S2: [f64; 2] = [0.0, crate::units::G_M_S2];
/// Half width of the phalanges.
pub const HALF_WIDTH_M: f64 = 0.0025;
/// Density of the links.
pub const DENSITY_KG_M3: f64 = 1070.0;
/// Depth of links and object, perpendicular to the plane.
pub const DEPTH_M: f64 = 0.040;
/// Grasped object.
pub const OBJECT: Shape = Shape::Disc { radius_m: 0.020 };
/// q_0, the initial angle before the proximal contact, degrees.
pub const OFFSET_DEG: f64 = 25.0;
/// μ_d = 0.7 μ_s; exactly 0.56 for 0.8.
pub fn mu_dynamic(mu_static: f64) -> f64 {
    7.0 * mu_static / 10.0
}

/// Damping of a bristle if the normal law has no damper.
pub const BRISTLE_DAMPING_N_S_PER_M: f64 = 1e6;
