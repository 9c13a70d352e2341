//! Sizing of spring and motor for a test trajectory (thesis §3.3.2).
//!
//! The motor link moves from the start to the final posture in T = 10 ms along a polynomial of the 7th order. Until the
//! proximal contact the spring must keep the finger straight, so that it swings as one rigid body; then l21 rests and
//! the tip continues. The inverse dynamics r(t) = M q̈ + c give
//!
//! * k_s(t) = r2/|∂q_s/∂q21| in the rigid phase (3.1), and **k_s** = max k_s(t);
//! * the net motor torque τ(t) = r1 + r2 in the rigid phase, and **τ11** = RMS τ(t) by a [`Rule`].

mod phases;
mod task;

use crate::gripper::{Finger, Placement, positive};
use crate::numeric::elementary::powi;
use phases::{BendingPhase, RigidPhase};

pub use task::{CLOSING_S, Closing, OPENING_RAD, SizingError, Task, closing};

/// Number of intervals of each phase. Mean squares use Simpson's rule; the maximum is refined by a parabola. A test
/// shows that doubling the number changes the torques of the thesis designs by a relative 5e-8 at most (1e-5 for
/// [`Rule::Whole`], because some designs pass near a fold of the tip).
pub const INTERVALS: usize = 400;

/// Averaging rule of the motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// RMS of the net torque r1 + r2 over the rigid phase.
    Rigid,
    /// RMS of r1 + (∂q22/∂q11) k_s over all of T: with the constant spring at q22, and with l21 at rest after its
    /// contact.
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

/// Sizes the motor and the spring (at q22) of a finger in the reference assembly mode. Fails under the same conditions
/// as [`closing`].
pub fn size(finger: &Finger, task: &Task, rule: Rule) -> Result<Sizing, SizingError> {
    size_with(finger, task, rule, Placement::Phalanges, INTERVALS)
}

/// Like [`size`], with any placement of the spring and any number of intervals (even, at least 2).
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

/// The test trajectory with its required torques and the resulting sizing.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub closing: Closing,
    /// Sizing by [`Rule::Rigid`] with the spring at q22.
    pub rigid: Sizing,
    /// Sizing by [`Rule::Whole`] with the spring at q22.
    pub whole: Sizing,
    /// Largest relative change of these torques when the number of samples is doubled.
    pub convergence: f64,
    /// k_s for each placement of the spring, in the order of [`Placement::ALL`].
    pub placements_n_m: [f64; 4],
    /// Stiffness c_s of the torsional spring: k_s/q_p.
    pub torsional_n_m_per_rad: f64,
    pub points: Vec<ProfilePoint>,
}

/// One sample of the trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    pub time_s: f64,
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
    pub qd11_rad_s: f64,
    pub qdd11_rad_s2: f64,
    /// k_s(t) for each placement of the spring, in the order of [`Placement::ALL`]; `None` after the proximal contact.
    pub springs_n_m: Option<[f64; 4]>,
    /// Net motor torque r1 + r2; `None` after the proximal contact.
    pub net_n_m: Option<f64>,
    /// Motor torque against the constant spring k_s.
    pub constant_n_m: f64,
    /// Motor torque against the torsional spring whose torque is k_s when the finger is straight.
    pub torsional_n_m: f64,
}

/// Evaluates the test trajectory at `samples` equal time steps. The contact is an additional time with two samples, one
/// for each side.
///
/// `preload_rad` is q_p, the deflection of the torsional spring when the finger is straight: c_s = k_s/q_p (2.30).
/// Fails under the same conditions as [`size`], and if the preload is not above 0.
pub fn profile(finger: &Finger, task: &Task, preload_rad: f64, samples: usize) -> Result<Profile, SizingError> {
    positive(&[("preload_rad", preload_rad)])?;
    let closing = closing(finger, task)?;
    let size_both = |intervals| -> Result<[Sizing; 2], SizingError> {
        let size_by = |rule| size_with(finger, task, rule, Placement::Phalanges, intervals);
        Ok([size_by(Rule::Rigid)?, size_by(Rule::Whole)?])
    };
    let [rigid, whole] = size_both(INTERVALS)?;
    let finer = size_both(2 * INTERVALS)?;
    let change = |a: f64, b: f64| if b == 0.0 { a.abs() } else { (a / b - 1.0).abs() };
    let convergence = [rigid, whole]
        .iter()
        .zip(&finer)
        .flat_map(|(a, b)| [change(a.motor_n_m, b.motor_n_m), change(a.spring_n_m, b.spring_n_m)])
        .fold(0.0, f64::max);
    let mut placements_n_m = [0.0; 4];
    for (torque, placement) in placements_n_m.iter_mut().zip(Placement::ALL) {
        *torque = size_with(finger, task, Rule::Rigid, placement, INTERVALS)?.spring_n_m;
    }
    let torsional_n_m_per_rad = rigid.spring_n_m / preload_rad;

    let rigid_phase = RigidPhase::new(finger, &closing, task.gravity_m_s2);
    let bending_phase = BendingPhase::new(finger, &closing, task.gravity_m_s2);
    let k_s = rigid.spring_n_m;
    let point = |x: f64, straight: bool| {
        let motion = closing.trajectory.at(x);
        let common = ProfilePoint {
            time_s: x * closing.trajectory.length_s,
            q11_rad: motion.angle_rad,
            q21_rad: closing.q21_contact_rad,
            q22_rad: closing.start.q22_rad,
            qd11_rad_s: motion.rate_rad_s,
            qdd11_rad_s2: motion.acceleration_rad_s2,
            springs_n_m: None,
            net_n_m: None,
            constant_n_m: 0.0,
            torsional_n_m: 0.0,
        };
        if straight {
            let r2 = rigid_phase.torques(&motion)[1];
            let motor = rigid_phase.motor_with_spring(&motion, k_s);
            return ProfilePoint {
                q21_rad: motion.angle_rad - closing.start.q11_rad + closing.start.q21_rad,
                springs_n_m: Some(Placement::ALL.map(|placement| r2 / rigid_phase.spring_lever(placement).abs())),
                net_n_m: Some(rigid_phase.net_torque(&motion)),
                constant_n_m: motor,
                torsional_n_m: motor,
                ..common
            };
        }
        let q22_rad = bending_phase.q22(&motion);
        let [r1, lever] = bending_phase.row(&motion);
        let extension = q22_rad - closing.start.q22_rad;
        ProfilePoint {
            q22_rad,
            constant_n_m: r1 + lever * k_s,
            torsional_n_m: r1 + lever * (k_s + torsional_n_m_per_rad * extension),
            ..common
        }
    };
    let mut points = Vec::with_capacity(samples + 3);
    let xs = (0..=samples).map(|i| i as f64 / samples.max(1) as f64);
    let (swing, bend): (Vec<f64>, Vec<f64>) = xs.partition(|x| *x < closing.contact_x);
    for x in swing.into_iter().chain([closing.contact_x]) {
        points.push(point(x, true));
    }
    for x in [closing.contact_x].into_iter().chain(bend.into_iter().filter(|x| *x > closing.contact_x)) {
        points.push(point(x, false));
    }
    Ok(Profile { closing, rigid, whole, convergence, placements_n_m, torsional_n_m_per_rad, points })
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
