//! Maximum, root mean square over time and final value of the difference of one quantity over a run.

use crate::numeric::plane::wrap_angle;
use crate::trace::FingerState;

/// Joint angles that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Angle {
    Q11,
    Q21,
    Q22,
}

/// Joint rates that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    Qd11,
    Qd21,
    Qd22,
}

impl Angle {
    pub const ALL: [Angle; 3] = [Angle::Q11, Angle::Q21, Angle::Q22];

    pub fn value(self, finger: &FingerState) -> f64 {
        match self {
            Angle::Q11 => finger.q11_rad,
            Angle::Q21 => finger.q21_rad,
            Angle::Q22 => finger.q22_rad,
        }
    }

    /// Difference of this angle between two fingers, modulo a full turn: at most half a turn.
    pub fn difference(self, a: &FingerState, b: &FingerState) -> f64 {
        wrap_angle(self.value(a) - self.value(b))
    }

    pub fn name(self) -> &'static str {
        match self {
            Angle::Q11 => "q11",
            Angle::Q21 => "q21",
            Angle::Q22 => "q22",
        }
    }
}

impl Rate {
    pub const ALL: [Rate; 3] = [Rate::Qd11, Rate::Qd21, Rate::Qd22];

    pub fn value(self, finger: &FingerState) -> f64 {
        match self {
            Rate::Qd11 => finger.qd11_rad_s,
            Rate::Qd21 => finger.qd21_rad_s,
            Rate::Qd22 => finger.qd22_rad_s,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Rate::Qd11 => "qd11",
            Rate::Qd21 => "qd21",
            Rate::Qd22 => "qd22",
        }
    }
}

/// The difference of one quantity over a run. NaN counts as infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningDifference {
    /// Largest absolute difference.
    pub max: f64,
    /// Time of the largest difference, s.
    pub max_at_s: f64,
    /// Absolute difference at the end.
    pub end: f64,
    /// ∫ difference² dt by the trapezoidal rule, from `start_s` to `time_s`.
    square_s: f64,
    start_s: f64,
    time_s: f64,
    has_started: bool,
}

impl RunningDifference {
    /// Adds the difference at a time. Times must not decrease.
    pub fn push(&mut self, time_s: f64, difference: f64) {
        let difference = if difference.is_nan() { f64::INFINITY } else { difference.abs() };
        if self.has_started {
            self.square_s += 0.5 * (time_s - self.time_s) * (self.end * self.end + difference * difference);
        } else {
            (self.has_started, self.start_s) = (true, time_s);
        }
        if difference > self.max {
            (self.max, self.max_at_s) = (difference, time_s);
        }
        (self.end, self.time_s) = (difference, time_s);
    }

    /// Root mean square over the time so far, weighted by time.
    pub fn rms(&self) -> f64 {
        let length = self.time_s - self.start_s;
        match (self.square_s / length).sqrt() {
            _ if length <= 0.0 => self.end,
            rms if rms.is_nan() => f64::INFINITY,
            rms => rms,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rms_is_weighted_by_time() {
        let mut running = RunningDifference::default();
        // 3 for one second in a hundred samples, then 0 for three seconds in one sample.
        for k in 0..=100 {
            running.push(0.01 * f64::from(k), -3.0);
        }
        running.push(1.0, 0.0);
        running.push(4.0, 0.0);
        assert!((running.rms() - 1.5).abs() < 1e-12, "{}", running.rms());
        assert_eq!((running.max, running.max_at_s, running.end), (3.0, 0.0, 0.0));
    }

    #[test]
    fn nan_is_an_infinite_difference() {
        let mut running = RunningDifference::default();
        running.push(0.0, 0.0);
        running.push(1.0, f64::NAN);
        running.push(2.0, 0.0);
        assert_eq!((running.max, running.max_at_s, running.rms()), (f64::INFINITY, 1.0, f64::INFINITY));
    }
}
