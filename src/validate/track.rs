//! Differences of one quantity along the way: largest, root mean square over time, at the end.

use crate::numeric::plane::turned;
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

    pub fn of(self, finger: &FingerState) -> f64 {
        match self {
            Angle::Q11 => finger.q11_rad,
            Angle::Q21 => finger.q21_rad,
            Angle::Q22 => finger.q22_rad,
        }
    }

    /// How far one finger is from another: at most half a turn, for a whole turn leads back.
    pub fn difference(self, a: &FingerState, b: &FingerState) -> f64 {
        turned(self.of(a) - self.of(b))
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

    pub fn of(self, finger: &FingerState) -> f64 {
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

/// The difference of one quantity over a run. What is not a number counts as infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// Largest absolute difference, and when it was.
    pub max: f64,
    pub max_at_s: f64,
    /// Absolute difference at the end.
    pub end: f64,
    /// ∫ difference² dt by trapezia, and the time of it.
    square_s: f64,
    start_s: f64,
    time_s: f64,
    begun: bool,
}

impl Track {
    /// Takes the difference at a time; times do not go back.
    pub fn push(&mut self, time_s: f64, difference: f64) {
        let difference = if difference.is_nan() { f64::INFINITY } else { difference.abs() };
        if self.begun {
            self.square_s += 0.5 * (time_s - self.time_s) * (self.end * self.end + difference * difference);
        } else {
            (self.begun, self.start_s) = (true, time_s);
        }
        if difference > self.max {
            (self.max, self.max_at_s) = (difference, time_s);
        }
        (self.end, self.time_s) = (difference, time_s);
    }

    /// Root mean square over the time so far, every instant with the same weight.
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
    fn times_count_by_their_length() {
        let mut track = Track::default();
        // 3 for one second in a hundred samples, 0 for three seconds in one.
        for k in 0..=100 {
            track.push(0.01 * f64::from(k), -3.0);
        }
        track.push(1.0, 0.0);
        track.push(4.0, 0.0);
        assert!((track.rms() - 1.5).abs() < 1e-12, "{}", track.rms());
        assert_eq!((track.max, track.max_at_s, track.end), (3.0, 0.0, 0.0));
    }

    #[test]
    fn what_is_no_number_is_infinitely_far() {
        let mut track = Track::default();
        track.push(0.0, 0.0);
        track.push(1.0, f64::NAN);
        track.push(2.0, 0.0);
        assert_eq!((track.max, track.max_at_s, track.rms()), (f64::INFINITY, 1.0, f64::INFINITY));
    }
}
