//! The spring that pulls the finger straight (thesis (2.30), §3.3.2.3, errata 4).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::kinematics::{Directions, PassiveRates, passive_rates, reference_gamma, straight};
use crate::gripper::{Lengths, Placement, Spring, SpringKind};
use crate::numeric::Real;
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{angle_between, near_turn, opening_angle, rotate};

/// A spring with what its placement needs of the straight configuration.
#[derive(Clone, Copy, Debug)]
pub struct SpringModel {
    kind: SpringKind,
    placement: Placement,
    /// +1 where q_s grows as the tip closes, −1 where it shrinks: the torque −s k_s always pulls back to straight.
    closing_sign: f64,
    /// (cos, sin) of −q_s in the straight configuration.
    straight: [f64; 2],
    /// Extension half a turn from the seam of angles, where no run comes by.
    centre_rad: f64,
}

/// The two directions q_s is the angle between.
#[inline(always)]
fn ends<T: Real>(placement: Placement, pose: &Directions<T>) -> [[T; 2]; 2] {
    match placement {
        Placement::GroundLinks => [pose.e1, pose.e2],
        Placement::DrivenCoupler => [pose.e1, pose.e3],
        Placement::Phalanges => [pose.e2, pose.e4],
        Placement::CouplerDistal => [pose.e4, pose.e3],
    }
}

/// ∂q_s/∂q_a.
#[inline(always)]
pub fn gradient<T: Real>(placement: Placement, rates: &PassiveRates<T>) -> [T; 2] {
    let (a3, a4) = (rates.a3, rates.a4);
    match placement {
        Placement::GroundLinks => [T::constant(-1.0), T::constant(1.0)],
        Placement::DrivenCoupler => [a3[0] - 1.0, a3[1]],
        Placement::Phalanges => [a4[0], a4[1] - 1.0],
        Placement::CouplerDistal => [a3[0] - a4[0], a3[1] - a4[1]],
    }
}

impl SpringModel {
    /// The spring of a finger in assembly mode γ, stretched least in its straight configuration, for a run that starts in
    /// the pose `start`.
    pub fn new(spring: &Spring, lengths: &Lengths, gamma: f64, start: &Directions<f64>) -> Self {
        let pose = straight(lengths);
        let [from, to] = ends(spring.placement, &pose);
        let q_s: f64 = angle_between(from, to);
        let closing = gradient(spring.placement, &passive_rates(lengths, &pose))[0];
        let model = Self {
            kind: spring.kind,
            placement: spring.placement,
            closing_sign: closing.signum(),
            straight: [cos(q_s), -sin(q_s)],
            centre_rad: 0.0,
        };
        let first = model.counted(start);
        let first = if first.is_finite() { first } else { FRAC_PI_2 };
        let centre = match spring.placement {
            // A12 is always behind A22 as seen along l21, and l22 always to the same side of it by less than half a turn:
            // all that a mode can reach is less than a turn about this.
            Placement::Phalanges if lengths.l21_m > lengths.l11_m => {
                let q22_rad = -gamma * reference_gamma(lengths) * FRAC_PI_2;
                model.closing_sign * (q22_rad + lengths.phi22_rad)
            }
            // Nor do l12 and l22 ever come into line within a mode.
            Placement::CouplerDistal => {
                let turned: f64 = angle_between(start.e4, start.e3);
                first + model.closing_sign * (FRAC_PI_2.copysign(turned) - turned)
            }
            // A crank may go round and round: the seam is a quarter of a turn behind straight.
            _ => FRAC_PI_2,
        };
        Self { centre_rad: near_turn(centre, first), ..model }
    }

    /// Extension with the seam a quarter of a turn behind straight.
    #[inline(always)]
    fn counted<T: Real>(&self, pose: &Directions<T>) -> T {
        let [from, to] = ends(self.placement, pose);
        let to = rotate(to, self.straight);
        if self.closing_sign > 0.0 { opening_angle(from, to) } else { opening_angle(to, from) }
    }

    /// Δq_s ≥ 0 in closing: how far the spring coordinate is from straight, in rad; without jumps wherever the run goes.
    #[inline(always)]
    pub fn extension<T: Real>(&self, pose: &Directions<T>) -> T {
        let counted = self.counted(pose);
        let off = counted.value() - self.centre_rad;
        if off.abs() <= PI { counted } else { counted + -TAU * (off / TAU).round() }
    }

    /// Generalised force τ_s (2.30): −(∂q_s/∂q_a)ᵀ s T with T = k_s, or c_s (q_p + Δq_s).
    #[inline(always)]
    pub fn generalised_force<T: Real>(&self, pose: &Directions<T>, rates: &PassiveRates<T>) -> [T; 2] {
        let [g0, g1] = gradient(self.placement, rates);
        match self.kind {
            SpringKind::Constant { torque_n_m } => {
                let t = -self.closing_sign * torque_n_m;
                [g0 * t, g1 * t]
            }
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                let t = (self.extension(pose) + preload_rad) * (-self.closing_sign * stiffness_n_m_per_rad);
                [g0 * t, g1 * t]
            }
        }
    }

    /// Stored energy in J, zero in the straight configuration.
    pub fn energy(&self, pose: &Directions<f64>) -> f64 {
        let extension = self.extension(pose);
        match self.kind {
            SpringKind::Constant { torque_n_m } => torque_n_m * extension,
            SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                stiffness_n_m_per_rad * extension * (preload_rad + 0.5 * extension)
            }
        }
    }
}
