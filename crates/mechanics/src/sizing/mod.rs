//! Sizing of spring and motor for a test trajectory (thesis §3.3.2, spec of 2-design §2.2).
//!
//! The motor link moves from the start to the final posture in T = 10 ms along a polynomial of the 7th order. Until the
//! proximal contact the spring must keep the finger straight, so that it swings as one rigid body; then l21 rests and
//! the tip continues. The inverse dynamics r(t) = M q̈ + c give
//!
//! * k_s(t) = r2/|∂q_s/∂q21| in the rigid phase (3.1), and **k_s** = max k_s(t);
//! * the net motor torque τ(t) = r1 + r2 in the rigid phase, and **τ11** = RMS τ(t) by a [`Rule`].

mod phases;
mod profile;
mod task;

pub use profile::{Profile, ProfilePoint, profile};
pub use task::{CLOSING_S, Closing, OPENING_RAD, SizingError, Task, closing};

use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::powi;
use phases::{BendingPhase, RigidPhase};

/// Number of intervals of each phase. Mean squares use Simpson's rule; the maximum is refined by a parabola. A test
/// shows that doubling the number changes the torques of the thesis designs by a relative 5e-8 at most (1e-5 for
/// [`Rule::Whole`], because some designs pass near a fold of the tip).
pub const INTERVALS: usize = 400;

/// Averaging rule of the motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// RMS of the net torque r1 + r2 over the rigid phase.
    Rigid,
    /// RMS over all of T, with the constant spring acting at q22 and l21 at rest after its contact: r1 + (∂q22/∂q11)
    /// k_s.
    Whole,
}

impl Rule {
    /// Name in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::Rigid => "rigid",
            Rule::Whole => "whole",
        }
    }
}

/// Sized motor and spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// τ11.
    pub motor_n_m: f64,
    /// k_s, the torque of a constant spring at q22.
    pub spring_n_m: f64,
}

/// Sizes motor and spring (at q22) of a finger in the reference assembly mode.
///
/// # Errors
/// Returns an error if the finger cannot grasp the object, or does so without bending its tip after the proximal
/// contact.
pub fn size(finger: &Finger, task: &Task, rule: Rule) -> Result<Sizing, SizingError> {
    size_with(finger, task, rule, Placement::Phalanges, INTERVALS)
}

/// [`size`] with any placement of the spring and any number of intervals (even, at least 2).
pub fn size_with(
    finger: &Finger,
    task: &Task,
    rule: Rule,
    placement: Placement,
    intervals: usize,
) -> Result<Sizing, SizingError> {
    let closing = closing(finger, task)?;
    let rigid = RigidPhase::new(finger, &closing, task.gravity_m_s2);
    let rigid_nodes = Simpson::on_interval(0.0, closing.contact_x, intervals);

    let lever = rigid.spring_lever(placement).abs();
    let required_n_m = find_maximum(&rigid_nodes, |x| rigid.torques(&closing.trajectory.at(x))[1]).max(0.0);
    let spring_n_m = required_n_m / lever;
    let mean_square = match rule {
        Rule::Rigid => rigid_nodes.mean(|x| powi(rigid.net_torque(&closing.trajectory.at(x)), 2)),
        Rule::Whole => {
            // The placement of the spring has no influence: spring and limit together keep q22 fixed.
            let k_s = required_n_m / rigid.spring_lever(Placement::Phalanges).abs();
            let rigid_mean = rigid_nodes.mean(|x| powi(rigid.motor_with_spring(&closing.trajectory.at(x), k_s), 2));
            let bending_nodes = Simpson::on_interval(closing.contact_x, 1.0, intervals);
            let bending = BendingPhase::new(finger, &closing, task.gravity_m_s2);
            let bending_mean = bending_nodes.mean(|x| powi(bending.motor(&closing.trajectory.at(x), k_s), 2));
            rigid_mean * closing.contact_x + bending_mean * (1.0 - closing.contact_x)
        }
    };
    let sizing = Sizing { motor_n_m: mean_square.sqrt(), spring_n_m };
    match sizing.motor_n_m.is_finite() && sizing.spring_n_m.is_finite() {
        true => Ok(sizing),
        false => Err(SizingError::Singular { q21_rad: closing.q21_contact_rad }),
    }
}

/// Composite Simpson rule over an interval.
#[derive(Clone, Copy, Debug)]
struct Simpson {
    from: f64,
    width: f64,
    intervals: usize,
}

impl Simpson {
    /// `intervals` is rounded up to an even number, at least 2.
    fn on_interval(from: f64, to: f64, intervals: usize) -> Self {
        Self { from, width: to - from, intervals: intervals.max(2).next_multiple_of(2) }
    }

    #[inline]
    fn node(&self, i: usize) -> f64 {
        self.from + self.width * (i as f64 / self.intervals as f64)
    }

    /// Mean of a function over the interval.
    #[inline]
    fn mean(&self, value: impl Fn(f64) -> f64) -> f64 {
        let n = self.intervals;
        let mut sum = value(self.node(0)) + value(self.node(n));
        for i in 1..n {
            sum += if i % 2 == 1 { 4.0 } else { 2.0 } * value(self.node(i));
        }
        sum / (3 * n) as f64
    }
}

/// Largest value of a function over the nodes, refined by the parabola through the largest and its two neighbours.
#[inline]
fn find_maximum(nodes: &Simpson, value: impl Fn(f64) -> f64) -> f64 {
    let (mut best, mut at) = (f64::NEG_INFINITY, 0);
    for i in 0..=nodes.intervals {
        let sample = value(nodes.node(i));
        if sample > best || sample.is_nan() {
            (best, at) = (sample, i);
        }
    }
    if at == 0 || at == nodes.intervals {
        return best;
    }
    let (before, after) = (value(nodes.node(at - 1)), value(nodes.node(at + 1)));
    let curvature = before - 2.0 * best + after;
    if curvature < 0.0 { best - powi(after - before, 2) / (8.0 * curvature) } else { best }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simpson_is_exact_for_cubics() {
        let nodes = Simpson::on_interval(-1.0, 3.0, 3);
        assert!((nodes.mean(|x| x * x * x + 2.0 * x) - (20.0 + 8.0) / 4.0).abs() < 1e-14);
    }

    #[test]
    fn the_maximum_between_nodes_is_found() {
        let nodes = Simpson::on_interval(0.0, 1.0, 400);
        assert!((find_maximum(&nodes, |x| 1.0 - (x - 0.3333).powi(2)) - 1.0).abs() < 1e-15);
        assert!((find_maximum(&nodes, |x| (7.0 * x).sin()) - 1.0).abs() < 1e-8);
        assert_eq!(find_maximum(&nodes, |x| x), 1.0);
        assert_eq!(find_maximum(&nodes, |x| -x), 0.0);
    }
}
