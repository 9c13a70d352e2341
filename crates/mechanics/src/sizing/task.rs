//! The sizing task of a finger, its test trajectory (start, contact and end), and errors in the sizing.

use crate::gripper::{
    Assembly, FinalPosture, Finger, GraspError, NumberError, Posture, final_posture, positive, start_posture,
};
use crate::shape::PlacedShape;

/// T, duration of the closing motion (thesis §3.3.2).
pub const CLOSING_S: f64 = 0.010;

/// q_0, angle between the start and the proximal contact (thesis Table 3.2): 25°.
pub const OPENING_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// The task for which a finger is sized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    pub object: PlacedShape,
    /// Angle between the start, straight and at rest, and the proximal contact.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Duration T of the test trajectory.
    pub closing_s: f64,
}

impl Task {
    /// Returns the task of the thesis: 25° in 10 ms, gravity directed out of the palm.
    pub const fn thesis(object: PlacedShape) -> Self {
        Task { object, opening_rad: OPENING_RAD, gravity_m_s2: [0.0, 9.81], closing_s: CLOSING_S }
    }
}

/// The test trajectory of one finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closing {
    /// Start posture: straight, at rest.
    pub start: Posture,
    /// Final posture: both phalanges on the object.
    pub end: FinalPosture,
    /// Contact angle q_c21; l21 stays there after the contact.
    pub q21_contact_rad: f64,
    pub trajectory: Trajectory,
    /// x = t/T at the proximal contact, where the rigid phase ends.
    pub contact_x: f64,
}

impl Closing {
    /// Time at which the rigid phase ends, s.
    pub fn contact_s(&self) -> f64 {
        self.contact_x * self.trajectory.length_s
    }
}

/// Finds the test trajectory of a finger.
///
/// # Errors
/// Returns an error if the finger cannot grasp the object, or if its tip does not bend after the proximal contact.
pub fn closing(finger: &Finger, task: &Task) -> Result<Closing, SizingError> {
    positive(&[("closing_s", task.closing_s)])?;
    if !(task.opening_rad.is_finite() && task.opening_rad > 0.0) {
        return Err(SizingError::Opening { opening_rad: task.opening_rad });
    }
    if finger.assembly != Assembly::Reference {
        return Err(SizingError::OtherAssembly);
    }
    let start = start_posture(&finger.lengths, task.object, task.opening_rad)?;
    let end = final_posture(&finger.lengths, finger.assembly, task.object)?;
    let rigid_stroke_rad = end.posture.q21_rad - start.q21_rad;
    let stroke_rad = end.posture.q11_rad - start.q11_rad;
    if stroke_rad <= rigid_stroke_rad || stroke_rad.is_nan() {
        return Err(SizingError::NoBendingStroke { stroke_rad, rigid_stroke_rad });
    }
    Ok(Closing {
        start,
        end,
        q21_contact_rad: end.posture.q21_rad,
        trajectory: Trajectory { from_rad: start.q11_rad, stroke_rad, length_s: task.closing_s },
        contact_x: inverse_position(rigid_stroke_rad / stroke_rad),
    })
}

/// Error for a finger that cannot be sized.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SizingError {
    #[error(transparent)]
    Grasp(#[from] GraspError),
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "the finger starts {:.4} deg before the proximal contact, but must start more than 0 deg before it: open it further \
         (raise the offset, or lower q21)",
        .opening_rad.to_degrees()
    )]
    Opening { opening_rad: f64 },
    #[error(
        "the test trajectory moves l11 by {:.4} deg in total, but the finger swings {:.4} deg before it reaches the object: \
         its distal phalanx would have to bend backwards, so make l21 longer, or phi22 or arm_ratio larger",
        .stroke_rad.to_degrees(), .rigid_stroke_rad.to_degrees()
    )]
    NoBendingStroke { stroke_rad: f64, rigid_stroke_rad: f64 },
    #[error(
        "sizing requires the straight configuration, which the assembly \"other\" does not have: use \"reference\""
    )]
    OtherAssembly,
    #[error(
        "l12 and l22 are in line on the test trajectory (l21 at {:.4} deg), where no torque moves the distal phalanx: change phi22, \
         arm_ratio or l21",
        .q21_rad.to_degrees()
    )]
    Singular { q21_rad: f64 },
}

/// s(x) = 35x⁴ − 84x⁵ + 70x⁶ − 20x⁷ on 0 … 1: velocity, acceleration and jerk vanish at both ends.
#[inline]
pub fn position(x: f64) -> f64 {
    let x2 = x * x;
    x2 * x2 * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)))
}

/// ds/dx.
#[inline]
pub fn rate(x: f64) -> f64 {
    let product = x * (1.0 - x);
    140.0 * product * product * product
}

/// d²s/dx².
#[inline]
pub fn acceleration(x: f64) -> f64 {
    let product = x * (1.0 - x);
    420.0 * product * product * (1.0 - 2.0 * x)
}

/// Inverse of [`position`]: the x in 0 … 1 at which s(x) = `fraction`, clamped outside 0 … 1.
///
/// Newton iteration, safeguarded by bisection because s is flat at both ends.
pub(crate) fn inverse_position(fraction: f64) -> f64 {
    if fraction <= 0.0 {
        return 0.0;
    }
    if fraction >= 1.0 {
        return 1.0;
    }
    let (mut low, mut high, mut x) = (0.0, 1.0, 0.5);
    for _ in 0..100 {
        let residual = position(x) - fraction;
        if residual < 0.0 {
            low = x
        } else {
            high = x
        }
        let newton = x - residual / rate(x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

/// Trajectory of the motor link (thesis §3.3.2.1, Fig. 3.1): it starts at `from_rad` and covers `stroke_rad` in
/// `length_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory {
    pub from_rad: f64,
    pub stroke_rad: f64,
    pub length_s: f64,
}

/// Angle, rate and acceleration of the motor link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub angle_rad: f64,
    pub rate_rad_s: f64,
    pub acceleration_rad_s2: f64,
}

impl Trajectory {
    /// Motion of the motor link at x = t/T.
    #[inline]
    pub fn at(&self, x: f64) -> Motion {
        Motion {
            angle_rad: self.from_rad + self.stroke_rad * position(x),
            rate_rad_s: self.stroke_rad * rate(x) / self.length_s,
            acceleration_rad_s2: self.stroke_rad * acceleration(x) / (self.length_s * self.length_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomial_starts_and_ends_at_rest_and_has_consistent_derivatives() {
        assert_eq!([position(0.0), position(0.5), position(1.0)], [0.0, 0.5, 1.0]);
        assert_eq!([rate(0.0), rate(1.0), acceleration(0.0), acceleration(1.0)], [0.0; 4]);
        let h = 1e-5;
        for x in [0.1, 0.35, 0.5, 0.77, 0.95] {
            assert!(((position(x + h) - position(x - h)) / (2.0 * h) - rate(x)).abs() < 1e-8);
            assert!(((rate(x + h) - rate(x - h)) / (2.0 * h) - acceleration(x)).abs() < 1e-7);
        }
    }

    #[test]
    fn inverse_position_inverts_position() {
        for fraction in [0.0, 1e-12, 1e-3, 0.3, 0.5, 0.9, 1.0 - 1e-9, 1.0] {
            assert!((position(inverse_position(fraction)) - fraction).abs() < 1e-13, "{fraction}");
        }
    }
}
