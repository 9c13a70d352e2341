//! Both phases of the test trajectory: the rigid phase, in which the straight finger rotates about its ground joint as
//! one body, and the bending phase after the proximal contact, in which l21 rests on the object and l11 drives the tip.
//!
//! In the rigid phase relative link angles are constant, so mass matrix, centrifugal coefficients and passive rates
//! keep their initial values, and only gravity rotates in the body frame. The inverse dynamics are constants times
//! acceleration, rate squared and two components of gravity.

use super::Closing;
use super::task::Motion;
use crate::fivebar::dynamics::{Dynamics, Terms, absolute_rates, bias, terms};
use crate::fivebar::kinematics::gradient;
use crate::fivebar::kinematics::{Directions, PassiveRates, directions, reference_gamma};
use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{opening_angle, rotate};

/// The straight finger as one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct RigidPhase {
    /// Row sums of M: torques for a common acceleration.
    inertia: [f64; 2],
    /// Sums of the quadratic terms: torques per square of the common rate.
    centrifugal: [f64; 2],
    /// Torques of gravity at the start, per 1 m/s² along x and along y.
    weight: [[f64; 2]; 2],
    gravity_m_s2: [f64; 2],
    rates: PassiveRates<f64>,
    start_rad: f64,
}

impl RigidPhase {
    pub fn new(finger: &Finger, closing: &Closing, gravity_m_s2: [f64; 2]) -> Self {
        let gamma = reference_gamma(&finger.lengths);
        let start = [closing.start.q11_rad, closing.start.q21_rad];
        let pose = directions(&finger.lengths, gamma, start);
        let terms_under = |gravity| terms(&Dynamics::new(finger, gamma, gravity), pose);
        let Terms { mass, quadratic, gravity, rates, .. } = terms_under([1.0, 0.0]);
        Self {
            inertia: [mass[0] + mass[1], mass[1] + mass[2]],
            centrifugal: quadratic.map(|row| row.iter().sum()),
            weight: [gravity, terms_under([0.0, 1.0]).gravity],
            gravity_m_s2,
            rates,
            start_rad: closing.start.q11_rad,
        }
    }

    /// r1 and r2 of the inverse dynamic model, N·m.
    #[inline]
    pub fn torques(&self, motion: &Motion) -> [f64; 2] {
        let (sin, cos) = sin_cos(motion.angle_rad - self.start_rad);
        let [gx, gy] = self.gravity_m_s2;
        // Gravity in the frame of the finger.
        let g = [cos * gx + sin * gy, cos * gy - sin * gx];
        let rate_squared = motion.rate_rad_s * motion.rate_rad_s;
        [0, 1].map(|row| {
            self.inertia[row] * motion.acceleration_rad_s2
                + self.centrifugal[row] * rate_squared
                + g[0] * self.weight[0][row]
                + g[1] * self.weight[1][row]
        })
    }

    /// r1 + r2: motor torque while spring and limit keep the tip fixed.
    #[inline]
    pub(crate) fn net_torque(&self, motion: &Motion) -> f64 {
        let [r1, r2] = self.torques(motion);
        r1 + r2
    }

    /// Motor torque against a constant spring k_s at q22 alone, without the torque of the limit: r1 + (∂q22/∂q11) k_s.
    #[inline]
    pub(crate) fn motor_with_spring(&self, motion: &Motion, k_s: f64) -> f64 {
        self.torques(motion)[0] + gradient(Placement::Phalanges, &self.rates)[0] * k_s
    }

    /// Lever ∂q_s/∂q21 of the spring: the part of r2 that a spring torque of 1 N·m balances.
    pub(crate) fn spring_lever(&self, placement: Placement) -> f64 {
        gradient(placement, &self.rates)[1]
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fivebar::dynamics::inverse_dynamics;
    use crate::gripper::{Assembly, Design, ProximalLength, bodies, disc, lengths};
    use crate::sizing::{Task, closing};

    /// Compares with the general inverse dynamic model, sample by sample.
    #[test]
    fn rigid_body_torques_match_the_five_bar() {
        let design = Design::thesis(0.0155, ProximalLength::Fraction(0.4), 1.9, 0.5);
        let lengths = lengths(&design).unwrap();
        let bodies = bodies(&lengths, 1070.0, 0.04).unwrap();
        let finger = Finger { lengths, bodies, assembly: Assembly::Reference };
        let task = Task { gravity_m_s2: [3.0, 9.81], ..Task::thesis(disc(&design)) };
        let closing = closing(&finger, &task).unwrap();
        let rigid = RigidPhase::new(&finger, &closing, task.gravity_m_s2);
        let dynamics = Dynamics::new(&finger, reference_gamma(&lengths), task.gravity_m_s2);
        for x in [0.0, 0.1, 0.25, 0.4, closing.contact_x] {
            let motion = closing.trajectory.at(x);
            let q = [motion.angle_rad, motion.angle_rad - closing.start.q11_rad + closing.start.q21_rad];
            let full_torques = inverse_dynamics(&dynamics, q, [motion.rate_rad_s; 2], [motion.acceleration_rad_s2; 2]);
            let found = rigid.torques(&motion);
            for (a, b) in found.iter().zip(full_torques) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        }
        // A body that rotates about a fixed point has no net centrifugal torque.
        assert!(rigid.centrifugal.iter().sum::<f64>().abs() < 1e-18);
    }
}
