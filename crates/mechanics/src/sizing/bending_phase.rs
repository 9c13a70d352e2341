//! The bending phase after the proximal contact: l21 rests on the object, and l11 drives the tip.

use super::Closing;
use super::trajectory::Motion;
use crate::fivebar::dynamics::{Dynamics, absolute_rates, bias, terms};
use crate::fivebar::kinematics::{Directions, directions, reference_gamma};
use crate::fivebar::spring::gradient;
use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{opening_angle, rotate};

/// The finger with l21 at rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct BendingPhase {
    dynamics: Dynamics,
    q21_rad: f64,
    /// (cos, sin) of −φ22: direction of the arm of a straight finger relative to l21.
    straight: [f64; 2],
}

impl BendingPhase {
    pub fn new(finger: &Finger, closing: &Closing, gravity_m_s2: [f64; 2]) -> Self {
        let gamma = reference_gamma(&finger.lengths);
        let (sin, cos) = sin_cos(finger.lengths.phi22_rad);
        Self {
            dynamics: Dynamics::new(finger, gamma, gravity_m_s2),
            q21_rad: closing.q21_contact_rad,
            straight: [cos, -sin],
        }
    }

    /// Motor torque against a constant spring k_s at q22: r1 + (∂q22/∂q11) k_s, N·m.
    #[inline]
    pub fn motor(&self, motion: &Motion, k_s: f64) -> f64 {
        let [r1, lever] = self.row(motion);
        r1 + lever * k_s
    }

    /// q22, within −φ22 … 2π − φ22.
    pub fn q22(&self, motion: &Motion) -> f64 {
        let pose = self.pose(motion);
        let bend: f64 = opening_angle(rotate(pose.e2, self.straight), pose.e4);
        bend - self.dynamics.lengths.phi22_rad
    }

    fn pose(&self, motion: &Motion) -> Directions<f64> {
        directions(&self.dynamics.lengths, self.dynamics.gamma, [motion.angle_rad, self.q21_rad])
    }

    /// Returns r1 and ∂q22/∂q11.
    #[inline]
    pub fn row(&self, motion: &Motion) -> [f64; 2] {
        let terms = terms(&self.dynamics, self.pose(motion));
        let c = bias(&terms, absolute_rates(&terms.rates, [motion.rate_rad_s, 0.0]));
        [terms.mass[0] * motion.acceleration_rad_s2 + c[0], gradient(Placement::Phalanges, &terms.rates)[0]]
    }
}
