//! The links of a finger at a node of the engine model.

use std::f64::consts::PI;

use crate::engine::{Frame, L11, L12, L21, L22, Motion, Twist, base};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{angle_between, near_turn, opening_angle, rotate};
use crate::scene::Side;
use crate::trace::FingerState;

/// The links of a finger among the bodies of a plan: the first of them, and −1 where they are the mirror image of what is read.
#[derive(Clone, Copy)]
pub struct Links {
    pub first: usize,
    pub mirror: f64,
    /// Angle of what it stands on, and two derivatives.
    pub stands: [f64; 3],
}

impl Links {
    /// Of the finger of a side, in a palm that turns so.
    pub fn of(side: Side, frame: &Frame) -> Self {
        Self { first: base(side), mirror: side.mirror(), stands: frame.turning() }
    }

    /// Bodies count their turns; passive angles do not. Their turn is the one both models show: q12 is the angle between two
    /// directions, and q22 is measured from the straight line by the bend q22 + φ22, whose seam is at −90°.
    pub fn read(self, motion: &Motion, phi22_rad: f64, motor_torque_n_m: f64) -> FingerState {
        let places = &motion.linkage.places;
        let rate = |link: usize| self.mirror * (motion.velocities[self.first + link][2] - self.stands[1]);
        let angle = |link: usize| {
            let angle = places[self.first + link].angle - self.stands[0];
            if self.mirror > 0.0 { angle } else { PI - angle }
        };
        let direction = |link: usize| {
            let [x, y] = places[self.first + link].direction;
            [self.mirror * x, y]
        };
        let (sin, cos) = sin_cos(phi22_rad);
        let bend = opening_angle(direction(L21), rotate(direction(L22), [cos, sin]));
        let q12_rad = near_turn(angle(L12) - angle(L11), angle_between(direction(L11), direction(L12)));
        let q22_rad = near_turn(angle(L22) - angle(L21), bend - phi22_rad);
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

    /// Angles and rates after a time under these accelerations of all bodies.
    pub fn fly(self, finger: &mut FingerState, from: &FingerState, time_s: f64, accelerations: &[Twist]) {
        let [a11, a12, a21, a22] =
            [L11, L12, L21, L22].map(|link| self.mirror * (accelerations[self.first + link][2] - self.stands[2]));
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
