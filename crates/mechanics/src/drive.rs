//! Values over time, such as the torque of a motor, and brakes that block a drive.

use std::f64::consts::PI;

use crate::law::{Bristle, smoothstep};
use crate::numeric::elementary::sin_cos;

/// A value over time: the torque of a motor, or the set point of a controller, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    Constant {
        value: f64,
    },
    /// Values at times; constant before the first time and after the last.
    Table {
        points: Vec<(f64, f64)>,
        interpolation: Interpolation,
    },
    /// Smooth rise from 0 to the value over `rise_s` (cubic smoothstep), then constant.
    Ramp {
        value: f64,
        rise_s: f64,
    },
    /// A half sine of the given length, then zero.
    HalfSine {
        value: f64,
        length_s: f64,
    },
    /// Constant value that changes sign at `at_s` (closing, then opening).
    Reversal {
        value: f64,
        at_s: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    /// Each value holds until the next time.
    Step,
}

impl Profile {
    /// Returns the value and its rate at time `t`. At a jump, it is the value after the jump (t in [tᵢ, tᵢ₊₁)).
    #[inline(always)]
    pub fn at(&self, t: f64) -> (f64, f64) {
        match self {
            Profile::Constant { value } => (*value, 0.0),
            Profile::Table { points, interpolation } => table_value(points, *interpolation, t),
            Profile::Ramp { value, rise_s } => {
                let (sigma, slope) = smoothstep(t / rise_s);
                (value * sigma, value * slope / rise_s)
            }
            Profile::HalfSine { value, length_s } => {
                if t >= *length_s {
                    return (0.0, 0.0);
                }
                let omega = PI / length_s;
                let (sin, cos) = sin_cos(omega * t);
                (value * sin, value * omega * cos)
            }
            Profile::Reversal { value, at_s } => (if t < *at_s { *value } else { -value }, 0.0),
        }
    }

    /// Largest magnitude over all times.
    pub fn largest(&self) -> f64 {
        match self {
            Profile::Constant { value }
            | Profile::Ramp { value, .. }
            | Profile::HalfSine { value, .. }
            | Profile::Reversal { value, .. } => value.abs(),
            Profile::Table { points, .. } => points.iter().map(|(_, value)| value.abs()).fold(0.0, f64::max),
        }
    }

    /// Returns the next time after `t` at which the value or its slope jumps; infinite if there is none.
    ///
    /// The integrator ends a step there, so that no step contains a discontinuity.
    #[inline]
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let if_later = |corner: f64| if corner > t { corner } else { f64::INFINITY };
        match self {
            Profile::Constant { .. } => f64::INFINITY,
            Profile::Table { points, .. } => {
                points.get(points.partition_point(|p| p.0 <= t)).map_or(f64::INFINITY, |p| p.0)
            }
            Profile::Ramp { rise_s, .. } => if_later(*rise_s),
            Profile::HalfSine { length_s, .. } => if_later(*length_s),
            Profile::Reversal { at_s, .. } => if_later(*at_s),
        }
    }

    /// Returns max(0, value) over time. A linear table gets an additional point at each of its zeros, so that the
    /// result is exact.
    pub fn positive_part(&self) -> Self {
        let mut positive = self.clone();
        match &mut positive {
            Profile::Constant { value } | Profile::Ramp { value, .. } | Profile::HalfSine { value, .. } => {
                *value = value.max(0.0);
            }
            Profile::Reversal { value, at_s } => {
                let points = vec![(0.0, value.max(0.0)), (*at_s, (-*value).max(0.0))];
                return Profile::Table { points, interpolation: Interpolation::Step };
            }
            Profile::Table { points, interpolation } => {
                let zero = |pair: &[(f64, f64)]| {
                    let [(t0, y0), (t1, y1)] = [pair[0], pair[1]];
                    let crosses = *interpolation == Interpolation::Linear && y0 * y1 < 0.0;
                    crosses.then(|| (t0 + (t1 - t0) * y0 / (y0 - y1), 0.0))
                };
                let zeros: Vec<(f64, f64)> = points.windows(2).filter_map(zero).collect();
                points.extend(zeros);
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                points.iter_mut().for_each(|point| point.1 = point.1.max(0.0));
            }
        }
        positive
    }

    /// Returns a set point that starts from the value y at time t and follows this profile, a constant or a linear
    /// table, at a rate of at most `limit`. Applied to its own result, it returns the same set point.
    pub fn rate_limited(&self, (mut t, mut y): (f64, f64), limit: f64) -> Self {
        let mut points = Vec::new();
        loop {
            let ((x, slope), end) = (self.at(t), self.next_discontinuity(t));
            let is_reached = (x - y).abs() <= 1e-12 * (1.0 + x.abs());
            if is_reached && points.is_empty() {
                y = x;
            }
            points.push((t, y));
            let is_followed = is_reached && slope.abs() <= limit * (1.0 + 1e-12);
            let rate = match is_reached {
                true if is_followed => slope,
                true => limit.copysign(slope),
                false => limit.copysign(x - y),
            };
            let meeting = if is_reached { f64::INFINITY } else { t + (x - y) / (rate - slope) };
            let next = if meeting > t { end.min(meeting) } else { end };
            if next.is_infinite() {
                return Profile::Table { points, interpolation: Interpolation::Linear };
            }
            y = match next == meeting {
                true => x + slope * (next - t),
                false if is_followed && slope != 0.0 => self.at(next).0,
                false => y + rate * (next - t),
            };
            t = next;
        }
    }

    /// Returns the profile multiplied by `factor`.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        match &mut scaled {
            Profile::Constant { value }
            | Profile::Ramp { value, .. }
            | Profile::HalfSine { value, .. }
            | Profile::Reversal { value, .. } => *value *= factor,
            Profile::Table { points, .. } => points.iter_mut().for_each(|(_, value)| *value *= factor),
        }
        scaled
    }
}

#[inline]
fn table_value(points: &[(f64, f64)], interpolation: Interpolation, t: f64) -> (f64, f64) {
    let after = points.partition_point(|p| p.0 <= t);
    let Some(&(t0, y0)) = after.checked_sub(1).and_then(|i| points.get(i)) else {
        return (points.first().map_or(0.0, |p| p.1), 0.0);
    };
    match (interpolation, points.get(after)) {
        (Interpolation::Linear, Some(&(t1, y1))) => {
            let slope = (y1 - y0) / (t1 - t0);
            (y0 + slope * (t - t0), slope)
        }
        _ => (y0, 0.0),
    }
}

/// An electromagnetic brake of a drive: torque −T s(t) β(q̇).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Maximum torque, N·m.
    pub torque_n_m: f64,
    pub start_s: f64,
    /// Duration of engagement and of release.
    pub rise_s: f64,
    /// Time at which the release starts, s; `None` if the brake is never released.
    pub release_s: Option<f64>,
    /// Whether the brake resists opening only.
    pub one_way: bool,
    /// Half width of the sticking range of the regularised law.
    pub v_static_rad_s: f64,
    /// Bristle, in rad, that holds without creep below the maximum torque; `None` for the regularised law, which
    /// creeps.
    pub bristle: Option<Bristle>,
}

/// The torque of a brake at one instant, and its effect on the state of its bristle.
#[derive(Clone, Copy, Debug)]
pub struct BrakeTorque {
    /// Torque, N·m, and its derivatives with respect to the rate of the shaft and to time.
    pub torque: [f64; 3],
    /// Derivative of the torque with respect to the state of the bristle; 0 without a bristle.
    pub by_bristle: f64,
    /// Rate of the bristle's state per unit of brake torque; negative, or 0 without a bristle.
    pub gain: f64,
}

impl Brake {
    /// Engagement, 0…1, and its rate.
    #[inline]
    pub fn engagement(&self, t: f64) -> (f64, f64) {
        let step = |from: f64| {
            let (value, slope) = smoothstep((t - from) / self.rise_s);
            (value, slope / self.rise_s)
        };
        let (on, on_rate) = step(self.start_s);
        let (off, off_rate) = self.release_s.map_or((0.0, 0.0), step);
        (on * (1.0 - off), on_rate * (1.0 - off) - on * off_rate)
    }

    /// Smallest and largest torque, N·m.
    pub fn torque_range(&self, t: f64) -> [f64; 2] {
        let largest = self.torque_n_m * self.engagement(t).0;
        [if self.one_way { 0.0 } else { -largest }, largest]
    }

    /// Returns the next time after `t` at which the engagement has a kink; infinite if there is none.
    #[inline]
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let from = [Some(self.start_s), self.release_s].into_iter().flatten();
        first_after(t, from.flat_map(|from| [from, from + self.rise_s]))
    }

    /// Returns the torque at a rate of the shaft, rad/s, and a state of the bristle. Without a state, the torque
    /// follows the regularised law.
    #[inline(always)]
    pub fn torque(&self, t: f64, rate: f64, bristle_state: Option<f64>) -> BrakeTorque {
        let Some((bristle, state)) = self.bristle.as_ref().zip(bristle_state) else {
            return BrakeTorque { torque: self.regularised_torque(t, rate), by_bristle: 0.0, gain: 0.0 };
        };
        let torque = self.bristle_torque(t, rate + state, bristle);
        BrakeTorque { torque, by_bristle: torque[1], gain: -bristle.stretch_gain() }
    }

    /// Torque of the bristle, N·m, and its derivatives with respect to `rate` and time; `rate` is the sum of the rate
    /// of the shaft and the internal state of the bristle.
    #[inline]
    fn bristle_torque(&self, t: f64, rate: f64, bristle: &Bristle) -> [f64; 3] {
        let (engagement, engagement_rate) = self.engagement(t);
        let (limit, limit_rate) = (self.torque_n_m * engagement, self.torque_n_m * engagement_rate);
        let torque = bristle.damping_n_s_per_m * rate;
        if torque < -limit {
            [limit, 0.0, limit_rate]
        } else if self.one_way && torque > 0.0 {
            [0.0; 3]
        } else if torque > limit {
            [-limit, 0.0, -limit_rate]
        } else {
            [-torque, -bristle.damping_n_s_per_m, 0.0]
        }
    }

    /// Torque at a rate of the shaft, N·m, and its derivatives with respect to rate and time.
    #[inline]
    fn regularised_torque(&self, t: f64, rate: f64) -> [f64; 3] {
        let (grip, grip_rate) = self.engagement(t);
        if grip == 0.0 && grip_rate == 0.0 || self.one_way && rate >= 0.0 {
            return [0.0; 3];
        }
        let (beta, slope) = if rate.abs() >= self.v_static_rad_s {
            (rate.signum(), 0.0)
        } else {
            let (sigma, slope) = smoothstep((rate + self.v_static_rad_s) / (2.0 * self.v_static_rad_s));
            (2.0 * sigma - 1.0, slope / self.v_static_rad_s)
        };
        [-grip * beta, -grip * slope, -grip_rate * beta].map(|part| self.torque_n_m * part)
    }
}

/// First of these times after `t`; infinite if there is none.
#[inline]
pub fn first_after(t: f64, times: impl Iterator<Item = f64>) -> f64 {
    times.filter(|time| *time > t).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_interpolate_and_report_their_corners() {
        let points = vec![(0.0, 1.0), (1.0, 3.0), (2.0, -1.0)];
        let linear = Profile::Table { points: points.clone(), interpolation: Interpolation::Linear };
        let step = Profile::Table { points, interpolation: Interpolation::Step };
        assert_eq!(linear.at(-1.0), (1.0, 0.0));
        assert_eq!(linear.at(0.25), (1.5, 2.0));
        assert_eq!(linear.at(1.5), (1.0, -4.0));
        assert_eq!(linear.at(9.0), (-1.0, 0.0));
        assert_eq!(step.at(0.999), (1.0, 0.0));
        assert_eq!(step.at(1.0), (3.0, 0.0));
        assert_eq!(step.next_discontinuity(0.0), 1.0);
        assert_eq!(step.next_discontinuity(1.0), 2.0);
        assert_eq!(step.next_discontinuity(2.0), f64::INFINITY);
    }

    #[test]
    fn profile_derivatives_match_finite_differences() {
        let profiles = [Profile::Ramp { value: 0.4, rise_s: 2e-3 }, Profile::HalfSine { value: 0.4, length_s: 5e-3 }];
        for profile in &profiles {
            for t in [3e-4, 1.7e-3, 4.9e-3, 6e-3] {
                let h = 1e-8;
                let slope = (profile.at(t + h).0 - profile.at(t - h).0) / (2.0 * h);
                assert!((profile.at(t).1 - slope).abs() < 1e-5 * (1.0 + slope.abs()));
            }
        }
        let reversal = Profile::Reversal { value: 0.4, at_s: 1e-3 };
        assert_eq!((reversal.at(9e-4).0, reversal.at(1e-3).0), (0.4, -0.4));
    }

    #[test]
    fn scaling_applies_to_every_profile() {
        let points = vec![(0.0, 0.1), (1e-3, 0.4), (5e-3, -0.2)];
        for actuation in [
            Profile::Constant { value: 0.48 },
            Profile::Ramp { value: 0.48, rise_s: 2e-3 },
            Profile::HalfSine { value: 0.48, length_s: 8e-3 },
            Profile::Reversal { value: 0.48, at_s: 3e-3 },
            Profile::Table { points: points.clone(), interpolation: Interpolation::Linear },
            Profile::Table { points, interpolation: Interpolation::Step },
        ] {
            let doubled = actuation.scaled(2.0);
            for t in [0.0, 0.7e-3, 2.1e-3, 6e-3] {
                assert_eq!(doubled.at(t).0, 2.0 * actuation.at(t).0, "{actuation:?} at {t}");
            }
        }
    }

    #[test]
    fn rate_limited_set_points_follow_as_small_steps_do() {
        let points = vec![(0.1, 0.0), (0.2, 1.0), (0.5, 1.2), (0.6, -1.0), (2.0, 0.4)];
        for target in [
            Profile::Constant { value: -0.7 },
            Profile::Table { points: points.clone(), interpolation: Interpolation::Linear },
            Profile::Table { points, interpolation: Interpolation::Step },
        ] {
            for limit in [0.3, 2.0, 50.0] {
                let set_point = target.rate_limited((0.0, 0.25), limit);
                assert_eq!(set_point.rate_limited((0.0, 0.25), limit), set_point, "{target:?} {limit}");
                let (mut y, steps) = (0.25f64, 300_000);
                for step in 0..steps {
                    let (t, h) = (3.0 * step as f64 / steps as f64, 3.0 / steps as f64);
                    let (found, rate) = set_point.at(t);
                    assert!((found - y).abs() < 1e-3, "{target:?} {limit} at {t}: {found}, {y}");
                    assert!(rate.abs() <= limit * (1.0 + 1e-9));
                    y += (target.at(t + h).0 - y).clamp(-limit * h, limit * h);
                }
            }
        }
    }

    #[test]
    fn positive_parts_are_exact() {
        let points = vec![(0.0, -1.0), (1.0, 3.0), (2.0, -1.0), (3.0, -2.0)];
        for profile in [
            Profile::Table { points: points.clone(), interpolation: Interpolation::Linear },
            Profile::Table { points, interpolation: Interpolation::Step },
            Profile::Reversal { value: -2.0, at_s: 1.3 },
            Profile::HalfSine { value: -2.0, length_s: 1.3 },
        ] {
            for t in [0.0, 0.1, 0.25, 0.3, 1.2, 1.7, 1.8, 2.5, 4.0] {
                let (found, expected) = (profile.positive_part().at(t).0, profile.at(t).0.max(0.0));
                assert!((found - expected).abs() < 1e-15, "{profile:?} at {t}: {found}, {expected}");
            }
        }
    }

    #[test]
    fn brake_torque_follows_engagement_and_rate() {
        let brake = Brake {
            torque_n_m: 2.0,
            start_s: 0.01,
            rise_s: 1e-3,
            release_s: Some(0.05),
            one_way: false,
            v_static_rad_s: 0.01,
            bristle: None,
        };
        let torque = |brake: &Brake, t: f64, rate: f64| brake.torque(t, rate, None).torque;
        assert_eq!(torque(&brake, 9e-3, 5.0), [0.0; 3]);
        assert_eq!(torque(&brake, 0.02, 5.0)[0], -2.0);
        assert_eq!(torque(&brake, 0.02, -5.0)[0], 2.0);
        assert!((torque(&brake, 0.0105, 5.0)[0] + 1.0).abs() < 1e-12);
        assert!((torque(&brake, 0.02, 0.0)[1] + 300.0).abs() < 1e-9, "1.5 T/v_s");
        assert_eq!(torque(&brake, 0.06, 5.0)[0], 0.0);
        let ratchet = Brake { one_way: true, ..brake };
        assert_eq!((torque(&ratchet, 0.02, 5.0)[0], torque(&ratchet, 0.02, -5.0)[0]), (0.0, 2.0));
        let (t, rate, h) = (0.0107, 0.004, 1e-7);
        let [_, by_rate, by_time] = torque(&brake, t, rate);
        let slope = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]) / (2.0 * h);
        assert!((by_rate - slope(torque(&brake, t, rate + h), torque(&brake, t, rate - h))).abs() < 1e-3);
        assert!((by_time - slope(torque(&brake, t + h, rate), torque(&brake, t - h, rate))).abs() < 1e-3);
    }
}
