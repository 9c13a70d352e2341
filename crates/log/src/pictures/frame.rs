//! The frame of pictures, and turns about the axis out of the plane.

use foxglove::messages::Quaternion;

use phalanx_core::numeric::elementary::sin_cos;

/// The frame that every other one hangs from.
pub const WORLD: &str = "world";

/// A turn in the plane.
pub fn about_z(angle_rad: f64) -> Quaternion {
    let (sin, cos) = sin_cos(0.5 * angle_rad);
    Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}
