//! Inertial accelerations in the frame of a moving palm (Spec 6.5).

use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{perp, rotate};
use crate::scene::{PalmMotion, Pose};

/// Inertial accelerations in a moving frame, or their time derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct AccelerationField {
    /// Uniform acceleration e, m/s².
    pub uniform: [f64; 2],
    /// Ω², or its time derivative.
    pub centrifugal: f64,
    /// Ω, or its time derivative.
    pub coriolis: f64,
    /// α, or its time derivative.
    pub euler: f64,
}

/// Field of inertial accelerations beyond gravity in the axes of the palm at the start, and its time derivative.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InertialField {
    pub field: AccelerationField,
    pub rate: AccelerationField,
}

/// Inertial field of a moving palm (Spec 6.5): inertial accelerations, and the change of gravity by the rotated frame, from
/// gravity in the world.
pub(super) fn inertial_field(motion: &PalmMotion, gravity: [f64; 2], t: f64) -> InertialField {
    let Pose { position, rate, acceleration, jerk } = motion.pose(t);
    let ([_, _, angle], [_, _, omega]) = (position, rate);
    let (sin, cos) = sin_cos(angle);
    let rotate_into_frame = |[x, y]: [f64; 2]| rotate([x, y], [cos, -sin]);
    let total = rotate_into_frame([gravity[0] - acceleration[0], gravity[1] - acceleration[1]]);
    let [gx, gy] = motion.in_initial_axes(gravity);
    let normal_to_total = perp(total);
    let [jx, jy] = rotate_into_frame([-jerk[0], -jerk[1]]);
    InertialField {
        field: AccelerationField {
            uniform: [total[0] - gx, total[1] - gy],
            centrifugal: omega * omega,
            coriolis: omega,
            euler: acceleration[2],
        },
        rate: AccelerationField {
            uniform: [jx - omega * normal_to_total[0], jy - omega * normal_to_total[1]],
            centrifugal: 2.0 * omega * acceleration[2],
            coriolis: acceleration[2],
            euler: jerk[2],
        },
    }
}
