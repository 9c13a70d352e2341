//! Motor torque over time, and brakes that block a drive.

use std::f64::consts::PI;

use crate::law::{Bristle, smoothstep};
use crate::numeric::elementary::sin_cos;

/// Motor torque τ11 on l11.
#[derive(Clone, Debug, PartialEq)]
pub enum Actuation {
    Constant {
        torque_n_m: f64,
    },
    /// Torque over time; constant before the first time and after the last.
    Table {
        points: Vec<(f64, f64)>,
        interpolation: Interpolation,
    },
    /// Smooth rise 0 → torque over `rise_s` (cubic smoothstep), then constant.
    Ramp {
        torque_n_m: f64,
        rise_s: f64,
    },
    /// A half sine of the given length, then zero.
    HalfSine {
        torque_n_m: f64,
        length_s: f64,
    },
    /// Constant torque that changes sign at `at_s` (closing, then opening).
    Reversal {
        torque_n_m: f64,
        at_s: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    /// Each value holds until the next time.
    Step,
}

/// τ11 and dτ11/dt at time t, in N·m and N·m/s. At a jump the value is that after it (t in [tᵢ, tᵢ₊₁)).
#[inline(always)]
pub fn torque(actuation: &Actuation, t: f64) -> (f64, f64) {
    match actuation {
        Actuation::Constant { torque_n_m } => (*torque_n_m, 0.0),
        Actuation::Table { points, interpolation } => table_torque(points, *interpolation, t),
        Actuation::Ramp { torque_n_m, rise_s } => {
            let (sigma, slope) = smoothstep(t / rise_s);
            (torque_n_m * sigma, torque_n_m * slope / rise_s)
        }
        Actuation::HalfSine { torque_n_m, length_s } => {
            if t >= *length_s {
                return (0.0, 0.0);
            }
            let omega = PI / length_s;
            let (sin, cos) = sin_cos(omega * t);
            (torque_n_m * sin, torque_n_m * omega * cos)
        }
        Actuation::Reversal { torque_n_m, at_s } => (if t < *at_s { *torque_n_m } else { -torque_n_m }, 0.0),
    }
}

/// Largest magnitude of the torque over all times, N·m.
pub fn largest_torque(actuation: &Actuation) -> f64 {
    match actuation {
        Actuation::Constant { torque_n_m }
        | Actuation::Ramp { torque_n_m, .. }
        | Actuation::HalfSine { torque_n_m, .. }
        | Actuation::Reversal { torque_n_m, .. } => torque_n_m.abs(),
        Actuation::Table { points, .. } => points.iter().map(|(_, torque_n_m)| torque_n_m.abs()).fold(0.0, f64::max),
    }
}

#[inline]
fn table_torque(points: &[(f64, f64)], interpolation: Interpolation, t: f64) -> (f64, f64) {
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

/// Returns the next time after `t` at which the torque or its slope jumps; infinite if there is none.
///
/// The integrator ends a step there, so that no step contains a discontinuity.
#[inline]
pub fn next_discontinuity(actuation: &Actuation, t: f64) -> f64 {
    let if_later = |corner: f64| if corner > t { corner } else { f64::INFINITY };
    match actuation {
        Actuation::Constant { .. } => f64::INFINITY,
        Actuation::Table { points, .. } => {
            points.get(points.partition_point(|p| p.0 <= t)).map_or(f64::INFINITY, |p| p.0)
        }
        Actuation::Ramp { rise_s, .. } => if_later(*rise_s),
        Actuation::HalfSine { length_s, .. } => if_later(*length_s),
        Actuation::Reversal { at_s, .. } => if_later(*at_s),
    }
}

/// Returns the actuation with its torque multiplied by `factor`.
pub fn scaled(actuation: &Actuation, factor: f64) -> Actuation {
    let mut scaled = actuation.clone();
    match &mut scaled {
        Actuation::Constant { torque_n_m }
        | Actuation::Ramp { torque_n_m, .. }
        | Actuation::HalfSine { torque_n_m, .. }
        | Actuation::Reversal { torque_n_m, .. } => *torque_n_m *= factor,
        Actuation::Table { points, .. } => points.iter_mut().for_each(|(_, torque_n_m)| *torque_n_m *= factor),
    }
    scaled
}

/// An electromagnetic brake of a drive: torque −T s(t) β(q̇).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Maximum torque, N·m.
    pub torque_n_m: f64,
    pub start_s: f64,
    /// Duration of engagement and of release.
    pub rise_s: f64,
    /// Time at which the release starts; `None` if the brake is never released.
    pub release_s: Option<f64>,
    /// Whether the brake resists opening only.
    pub one_way: bool,
    /// Half width of the sticking range of the regularised law.
    pub v_static_rad_s: f64,
    /// Bristle that holds without creep below the maximum torque, in rad; `None` for the regularised law, which creeps.
    pub bristle: Option<Bristle>,
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

    /// Returns the next time after `t` at which the engagement has a kink; infinite if there is none.
    #[inline]
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let from = [Some(self.start_s), self.release_s].into_iter().flatten();
        first_after(t, from.flat_map(|from| [from, from + self.rise_s]))
    }

    /// Torque of the bristle, N·m, and its derivatives with respect to `rate` and time; `rate` is the sum of the rate
    /// of the shaft and the internal state of the bristle.
    #[inline]
    pub fn bristle_torque(&self, t: f64, rate: f64, bristle: &Bristle) -> [f64; 3] {
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
    pub fn torque(&self, t: f64, rate: f64) -> [f64; 3] {
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
pub(crate) fn first_after(t: f64, times: impl Iterator<Item = f64>) -> f64 {
    times.filter(|time| *time > t).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_interpolate_and_report_their_corners() {
        let points = vec![(0.0, 1.0), (1.0, 3.0), (2.0, -1.0)];
        let linear = Actuation::Table { points: points.clone(), interpolation: Interpolation::Linear };
        let step = Actuation::Table { points, interpolation: Interpolation::Step };
        assert_eq!(torque(&linear, -1.0), (1.0, 0.0));
        assert_eq!(torque(&linear, 0.25), (1.5, 2.0));
        assert_eq!(torque(&linear, 1.5), (1.0, -4.0));
        assert_eq!(torque(&linear, 9.0), (-1.0, 0.0));
        assert_eq!(torque(&step, 0.999), (1.0, 0.0));
        assert_eq!(torque(&step, 1.0), (3.0, 0.0));
        assert_eq!(next_discontinuity(&step, 0.0), 1.0);
        assert_eq!(next_discontinuity(&step, 1.0), 2.0);
        assert_eq!(next_discontinuity(&step, 2.0), f64::INFINITY);
    }

    #[test]
    fn profile_derivatives_match_finite_differences() {
        let profiles = [
            Actuation::Ramp { torque_n_m: 0.4, rise_s: 2e-3 },
            Actuation::HalfSine { torque_n_m: 0.4, length_s: 5e-3 },
        ];
        for profile in &profiles {
            for t in [3e-4, 1.7e-3, 4.9e-3, 6e-3] {
                let h = 1e-8;
                let slope = (torque(profile, t + h).0 - torque(profile, t - h).0) / (2.0 * h);
                assert!((torque(profile, t).1 - slope).abs() < 1e-5 * (1.0 + slope.abs()));
            }
        }
        let reversal = Actuation::Reversal { torque_n_m: 0.4, at_s: 1e-3 };
        assert_eq!((torque(&reversal, 9e-4).0, torque(&reversal, 1e-3).0), (0.4, -0.4));
    }

    #[test]
    fn scaling_applies_to_every_profile() {
        let points = vec![(0.0, 0.1), (1e-3, 0.4), (5e-3, -0.2)];
        for actuation in [
            Actuation::Constant { torque_n_m: 0.48 },
            Actuation::Ramp { torque_n_m: 0.48, rise_s: 2e-3 },
            Actuation::HalfSine { torque_n_m: 0.48, length_s: 8e-3 },
            Actuation::Reversal { torque_n_m: 0.48, at_s: 3e-3 },
            Actuation::Table { points: points.clone(), interpolation: Interpolation::Linear },
            Actuation::Table { points, interpolation: Interpolation::Step },
        ] {
            let doubled = scaled(&actuation, 2.0);
            for t in [0.0, 0.7e-3, 2.1e-3, 6e-3] {
                assert_eq!(torque(&doubled, t).0, 2.0 * torque(&actuation, t).0, "{actuation:?} at {t}");
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
        assert_eq!(brake.torque(9e-3, 5.0), [0.0; 3]);
        assert_eq!(brake.torque(0.02, 5.0)[0], -2.0);
        assert_eq!(brake.torque(0.02, -5.0)[0], 2.0);
        assert!((brake.torque(0.0105, 5.0)[0] + 1.0).abs() < 1e-12);
        assert!((brake.torque(0.02, 0.0)[1] + 300.0).abs() < 1e-9, "1.5 T/v_s");
        assert_eq!(brake.torque(0.06, 5.0)[0], 0.0);
        let ratchet = Brake { one_way: true, ..brake };
        assert_eq!((ratchet.torque(0.02, 5.0)[0], ratchet.torque(0.02, -5.0)[0]), (0.0, 2.0));
        let (t, rate, h) = (0.0107, 0.004, 1e-7);
        let [_, by_rate, by_time] = brake.torque(t, rate);
        let slope = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]) / (2.0 * h);
        assert!((by_rate - slope(brake.torque(t, rate + h), brake.torque(t, rate - h))).abs() < 1e-3);
        assert!((by_time - slope(brake.torque(t + h, rate), brake.torque(t - h, rate))).abs() < 1e-3);
    }
}
