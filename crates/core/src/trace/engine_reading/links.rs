//! Links of a finger at a node of the engine model.

use std::f64::consts::PI;

use crate::engine::{L11, L12, L21, L22, Motion, PalmFrame, Twist, first_link};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{angle_between, nearest_equivalent_angle, opening_angle, rotate};
use crate::scene::Side;
use crate::trace::FingerState;

/// Links of a finger in the plan: index of the first link, and −1 for a mirrored finger.
#[derive(Clone, Copy)]
pub struct Links {
    pub first: usize,
    pub mirror: f64,
    /// Angle of the base of the finger, and its two time derivatives.
    pub base_rotation: [f64; 3],
}

impl Links {
    /// Returns the links of the finger on a side, mounted on a palm with the motion of `frame`.
    pub fn new(side: Side, frame: &PalmFrame) -> Self {
        Self { first: first_link(side), mirror: side.mirror(), base_rotation: frame.angular_motion() }
    }

    /// Reads the state of the finger.
    ///
    /// The angles of bodies count whole turns, but the passive angles of the analytic model do not. For the same values
    /// here, q12 is the equivalent nearest to the angle from l11 to l12, and q22 the one nearest to the bend q22 + φ22
    /// (with a branch cut at −90°) minus φ22.
    pub fn read(self, motion: &Motion, phi22_rad: f64, motor_torque_n_m: f64) -> FingerState {
        let poses = &motion.linkage.poses;
        let rate = |link: usize| self.mirror * (motion.velocities[self.first + link][2] - self.base_rotation[1]);
        let angle = |link: usize| {
            let angle = poses[self.first + link].angle - self.base_rotation[0];
            if self.mirror > 0.0 { angle } else { PI - angle }
        };
        let direction = |link: usize| {
            let [x, y] = poses[self.first + link].direction;
            [self.mirror * x, y]
        };
        let (sin, cos) = sin_cos(phi22_rad);
        let bend = opening_angle(direction(L21), rotate(direction(L22), [cos, sin]));
        let q12_rad = nearest_equivalent_angle(angle(L12) - angle(L11), angle_between(direction(L11), direction(L12)));
        let q22_rad = nearest_equivalent_angle(angle(L22) - angle(L21), bend - phi22_rad);
        FingerState {
            q11_rad: angle(L11),
            q21_rad: angle(L21),
            q12_rad,
            q22_rad,
            q13_rad: angle(L21) + q22_rad,
            qd11_rad_s: rate(L11),
            qd21_rad_s: rate(L21),
            qd12_rad_s: rate(L12) - rate(L11),
            qd22_rad_s: rate(L22) - rate(L21),
            motor_torque_n_m,
        }
    }

    /// Sets angles and rates by extrapolation over a time at constant accelerations of all bodies.
    pub fn extrapolate(self, finger: &mut FingerState, from: &FingerState, time_s: f64, accelerations: &[Twist]) {
        let [a11, a12, a21, a22] = [L11, L12, L21, L22]
            .map(|link| self.mirror * (accelerations[self.first + link][2] - self.base_rotation[2]));
        let angle = |q: f64, rate: f64, a: f64| q + time_s * (rate + 0.5 * time_s * a);
        finger.q11_rad = angle(from.q11_rad, from.qd11_rad_s, a11);
        finger.q21_rad = angle(from.q21_rad, from.qd21_rad_s, a21);
        finger.q12_rad = angle(from.q12_rad, from.qd12_rad_s, a12 - a11);
        finger.q22_rad = angle(from.q22_rad, from.qd22_rad_s, a22 - a21);
        finger.q13_rad = finger.q21_rad + finger.q22_rad;
        finger.qd11_rad_s = from.qd11_rad_s + time_s * a11;
        finger.qd21_rad_s = from.qd21_rad_s + time_s * a21;
        finger.qd12_rad_s = from.qd12_rad_s + time_s * (a12 - a11);
        finger.qd22_rad_s = from.qd22_rad_s + time_s * (a22 - a21);
    }
}
