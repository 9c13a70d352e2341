//! World frame and rotations about the axis normal to the plane.

use foxglove::messages::Quaternion;

use phalanx_core::numeric::elementary::sin_cos;

/// Name of the root frame.
pub const WORLD: &str = "world";

/// Returns the quaternion of a rotation in the plane.
pub fn rotation_about_z(angle_rad: f64) -> Quaternion {
    let (sin, cos) = sin_cos(0.5 * angle_rad);
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}
