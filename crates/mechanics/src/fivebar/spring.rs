//! The return spring of a finger (thesis (2.30), §3.3.2.3, errata 4).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::kinematics::{Directions, PassiveRates, passive_rates, reference_gamma, straight_directions};
use crate::gripper::{Lengths, Placement, Spring, SpringKind};
use crate::numeric::Real;
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{angle_between, nearest_equivalent_angle, opening_angle, rotate};

/// A spring with its reference angle in the straight configuration.
#[derive(Clone, Copy, Debug)]
pub struct SpringModel {
    kind: SpringKind,
    placement: Placement,
    /// s: +1 if q_s increases as the tip closes, −1 if it decreases. The torque −s k_s always acts towards the straight
    /// configuration.
    closing_sign: f64,
    /// (cos, sin) of −q_s in the straight configuration.
    straight: [f64; 2],
    /// Extension opposite to the branch cut of the angle; the cut lies where no run passes.
    centre_rad: f64,
}

/// Returns the two directions that enclose the angle q_s.
#[inline(always)]
fn directions_of<T: Real>(placement: Placement, pose: &Directions<T>) -> [[T; 2]; 2] {
    match placement {
        Placement::GroundLinks => [pose.e1, pose.e2],
        Placement::DrivenCoupler => [pose.e1, pose.e3],
        Placement::Phalanges => [pose.e2, pose.e4],
        Placement::CouplerDistal => [pose.e4, pose.e3],
    }
}

/// Gradient ∂q_s/∂q_a of the spring angle.
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
    /// Returns the spring of a finger in assembly mode γ, with zero extension in the straight configuration, for a run
    /// that starts in the pose `start`.
    pub fn new(spring: &Spring, lengths: &Lengths, gamma: f64, start: &Directions<f64>) -> Self {
        let pose = straight_directions(lengths);
        let [from, to] = directions_of(spring.placement, &pose);
        let q_s: f64 = angle_between(from, to);
        let closing = gradient(spring.placement, &passive_rates(lengths, &pose))[0];
        let model = Self {
            kind: spring.kind,
            placement: spring.placement,
            closing_sign: closing.signum(),
            straight: [cos(q_s), -sin(q_s)],
            centre_rad: 0.0,
        };
        let first = model.principal_extension(start);
        let first = if first.is_finite() { first } else { FRAC_PI_2 };
        let centre = match spring.placement {
            // A12 is always behind A22 along l21, and l22 is always on the same side of l21 by less than half a turn:
            // the extensions that a mode can reach span less than one turn about this value.
            Placement::Phalanges if lengths.l21_m > lengths.l11_m => {
                let q22_rad = -gamma * reference_gamma(lengths) * FRAC_PI_2;
                model.closing_sign * (q22_rad + lengths.phi22_rad)
            }
            // l12 and l22 are never in line within a mode.
            Placement::CouplerDistal => {
                let initial_angle: f64 = angle_between(start.e4, start.e3);
                first + model.closing_sign * (FRAC_PI_2.copysign(initial_angle) - initial_angle)
            }
            // A crank may rotate fully: the branch cut is a quarter of a turn before the straight configuration.
            _ => FRAC_PI_2,
        };
        Self { centre_rad: nearest_equivalent_angle(centre, first), ..model }
    }

    /// Extension with the branch cut a quarter of a turn before the straight configuration.
    #[inline(always)]
    fn principal_extension<T: Real>(&self, pose: &Directions<T>) -> T {
        let [from, to] = directions_of(self.placement, pose);
        let to = rotate(to, self.straight);
        if self.closing_sign > 0.0 { opening_angle(from, to) } else { opening_angle(to, from) }
    }

    /// Δq_s ≥ 0 in closing: deviation of the spring coordinate from the straight configuration, in rad; continuous
    /// along a run.
    #[inline(always)]
    pub fn extension<T: Real>(&self, pose: &Directions<T>) -> T {
        let principal_extension = self.principal_extension(pose);
        let off = principal_extension.value() - self.centre_rad;
        if off.abs() <= PI { principal_extension } else { principal_extension + -TAU * (off / TAU).round() }
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

    /// Torques on l12 and l22, N·m.
    pub fn link_torques(&self, pose: &Directions<f64>) -> [f64; 2] {
        let torque = -self.closing_sign
            * match self.kind {
                SpringKind::Constant { torque_n_m } => torque_n_m,
                SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad } => {
                    (self.extension(pose) + preload_rad) * stiffness_n_m_per_rad
                }
            };
        match self.placement {
            Placement::GroundLinks => [0.0; 2],
            Placement::DrivenCoupler => [torque, 0.0],
            Placement::Phalanges => [0.0, torque],
            Placement::CouplerDistal => [torque, -torque],
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
