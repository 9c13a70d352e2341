//! The rigid phase: the straight finger turns about its ground joint as one body.
//!
//! Link angles keep their distance, so mass matrix, centrifugal coefficients and passive rates are those of the start, and
//! gravity turns. All of inverse dynamics is then constants times acceleration, rate squared and two components of gravity.

use super::Closing;
use super::trajectory::Motion;
use crate::fivebar::dynamics::{Dynamics, Terms, terms};
use crate::fivebar::kinematics::{PassiveRates, directions, reference_gamma};
use crate::fivebar::spring::gradient;
use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::sin_cos;

/// The straight finger as one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    /// Row sums of M: torques for a common acceleration.
    inertia: [f64; 2],
    /// Torques for a common rate squared.
    centrifugal: [f64; 2],
    /// Torques of gravity at the start, for 1 m/s² along x and along y.
    weight: [[f64; 2]; 2],
    gravity_m_s2: [f64; 2],
    rates: PassiveRates<f64>,
    start_rad: f64,
}

impl Rigid {
    pub fn new(finger: &Finger, closing: &Closing, gravity_m_s2: [f64; 2]) -> Self {
        let gamma = reference_gamma(&finger.lengths);
        let start = [closing.start.q11_rad, closing.start.q21_rad];
        let pose = directions(&finger.lengths, gamma, start);
        let under = |gravity| terms(&Dynamics::new(finger, gamma, gravity), pose);
        let Terms { mass, quadratic, gravity, rates, .. } = under([1.0, 0.0]);
        Self {
            inertia: [mass[0] + mass[1], mass[1] + mass[2]],
            centrifugal: quadratic.map(|row| row.iter().sum()),
            weight: [gravity, under([0.0, 1.0]).gravity],
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
        // Gravity as the finger sees it: turned back.
        let g = [cos * gx + sin * gy, cos * gy - sin * gx];
        let rate_squared = motion.rate_rad_s * motion.rate_rad_s;
        [0, 1].map(|row| {
            self.inertia[row] * motion.acceleration_rad_s2
                + self.centrifugal[row] * rate_squared
                + g[0] * self.weight[0][row]
                + g[1] * self.weight[1][row]
        })
    }

    /// r1 + r2: what the motor must give while spring and limit hold the tip.
    #[inline]
    pub fn net_torque(&self, motion: &Motion) -> f64 {
        let [r1, r2] = self.torques(motion);
        r1 + r2
    }

    /// What the motor must give against a constant spring k_s at q22 alone, without the limit's share: r1 + (∂q22/∂q11) k_s.
    #[inline]
    pub fn motor_with_spring(&self, motion: &Motion, k_s: f64) -> f64 {
        self.torques(motion)[0] + gradient(Placement::Phalanges, &self.rates)[0] * k_s
    }

    /// ∂q_s/∂q21: a spring torque of 1 N·m takes this much of r2.
    pub fn spring_lever(&self, placement: Placement) -> f64 {
        gradient(placement, &self.rates)[1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fivebar::dynamics::inverse_dynamics;
    use crate::gripper::{Assembly, Design, ProximalLength, bodies, disc, lengths};
    use crate::sizing::{Task, closing};

    /// Against the general inverse dynamic model, sample by sample.
    #[test]
    fn the_rigid_body_has_the_torques_of_the_five_bar() {
        let design = Design::thesis(0.0155, ProximalLength::Fraction(0.4), 1.9, 0.5);
        let lengths = lengths(&design).unwrap();
        let bodies = bodies(&lengths, 1070.0, 0.04).unwrap();
        let finger = Finger { lengths, bodies, assembly: Assembly::Reference };
        let task = Task { gravity_m_s2: [3.0, 9.81], ..Task::thesis(disc(&design)) };
        let closing = closing(&finger, &task).unwrap();
        let rigid = Rigid::new(&finger, &closing, task.gravity_m_s2);
        let dynamics = Dynamics::new(&finger, reference_gamma(&lengths), task.gravity_m_s2);
        for x in [0.0, 0.1, 0.25, 0.4, closing.contact_x] {
            let motion = closing.trajectory.at(x);
            let q = [motion.angle_rad, motion.angle_rad - closing.start.q11_rad + closing.start.q21_rad];
            let full = inverse_dynamics(&dynamics, q, [motion.rate_rad_s; 2], [motion.acceleration_rad_s2; 2]);
            let mine = rigid.torques(&motion);
            for (a, b) in mine.iter().zip(full) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
        }
        // A body that turns about a fixed point has no net centrifugal torque.
        assert!(rigid.centrifugal.iter().sum::<f64>().abs() < 1e-18);
    }
}
