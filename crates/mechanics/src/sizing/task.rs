//! What a finger is sized for.

use crate::shape::Placed;

/// T, the time the closing may take (thesis §3.3.2).
pub const CLOSING_S: f64 = 0.010;

/// q_0, how far before the proximal contact the finger starts (thesis Table 3.2): 25°.
pub const OPENING_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// What a finger is sized for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// The object to be grasped.
    pub object: Placed,
    /// How far before the proximal contact the finger starts, straight and at rest.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Length T of the test trajectory.
    pub closing_s: f64,
}

impl Task {
    /// The task of the thesis: 25° in 10 ms, gravity out of the palm.
    pub const fn thesis(object: Placed) -> Self {
        Task { object, opening_rad: OPENING_RAD, gravity_m_s2: [0.0, 9.81], closing_s: CLOSING_S }
    }
}
