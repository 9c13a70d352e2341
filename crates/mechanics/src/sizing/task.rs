//! The sizing task.

use crate::shape::PlacedShape;

/// T, duration of the closing motion (thesis §3.3.2).
pub const CLOSING_S: f64 = 0.010;

/// q_0, angle between the start and the proximal contact (thesis Table 3.2): 25°.
pub const OPENING_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// The task for which a finger is sized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// The object to be grasped.
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
