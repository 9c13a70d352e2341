//! `[moves.NAME]`, `[vibrations.NAME]` and `[path]` of a gripper: how its palm moves.

use super::{Table, lines};
use crate::numeric::elementary::hypot;
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::{Acceleration, Angle, Choice, Frequency, Length, List, Number, Time, Words};
use crate::scene::{Axis, Move, Path, Ramp, Vibration};

const GIVEN: f64 = f64::NAN;

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Angle];

/// A move along any of the three coordinates.
#[derive(Clone, Copy, Debug)]
pub struct MoveKeys {
    distance: [f64; 3],
    pub start_s: f64,
    /// Not a number where `peak_m_s2` says it, and the other way round.
    pub length_s: f64,
    pub peak_m_s2: f64,
}

impl MoveKeys {
    /// Moves of one name.
    pub fn of(parts: &[&Move]) -> Self {
        let mut keys = Self::usual();
        for one in parts {
            keys.distance[one.axis as usize] = one.distance;
            (keys.start_s, keys.length_s) = (one.start_s, one.length_s);
        }
        keys
    }

    /// How far it goes, without its turn.
    pub fn way_m(&self) -> f64 {
        hypot(self.distance[0], self.distance[1])
    }

    /// One for each coordinate that changes; the peak acceleration says the time where it is given.
    pub fn moves(self) -> impl Iterator<Item = Move> {
        let way_m = self.way_m();
        let MoveKeys { distance, start_s, peak_m_s2, .. } = self;
        let length_s = if peak_m_s2.is_nan() { self.length_s } else { (Move::unit_peak() * way_m / peak_m_s2).sqrt() };
        parts(distance).map(move |(axis, distance)| Move { axis, distance, start_s, length_s })
    }
}

fn parts(values: [f64; 3]) -> impl Iterator<Item = (Axis, f64)> {
    AXES.into_iter().zip(values).filter(|(_, value)| *value != 0.0)
}

lines! {
    /// A move of the palm from rest to rest, by a polynomial of the 7th order whose rate, acceleration and jerk vanish at both ends.
    /// Moves that overlap add up.
    MoveKeys = Self { distance: [0.0; 3], start_s: GIVEN, length_s: GIVEN, peak_m_s2: GIVEN }, m;
    /// How far along the palm.
    "x": Length = Some(&mut m.distance[0]), said("0 mm");
    /// How far out of the palm; a robot that holds its gripper upside down lifts by less than 0.
    "y": Length = Some(&mut m.distance[1]), said("0 mm");
    /// How far it turns, counter-clockwise.
    "angle": Angle = Some(&mut m.distance[2]), said("0 deg");
    /// When it begins.
    "start": Time = Some(&mut m.start_s), allowed(NOT_NEGATIVE), needed("add when it begins: start = \"20 ms\"");
    /// How long it takes. Either this or `acceleration`.
    "time": Time = Some(&mut m.length_s), allowed(POSITIVE);
    /// Largest acceleration on its way s = √(x² + y²), which says the time: T = √(16.8/√5 s/a), where 16.8/√5 = 7.513. Either this or `time`.
    "acceleration": Acceleration = Some(&mut m.peak_m_s2), allowed(POSITIVE);
}

/// A vibration along any of the three coordinates.
#[derive(Clone, Copy, Debug)]
pub struct VibrationKeys {
    amplitude: [f64; 3],
    frequency_hz: f64,
    phase_rad: f64,
    start_s: f64,
    ramp_periods: f64,
    ramp: Ramp,
}

impl VibrationKeys {
    /// Vibrations of one name.
    pub fn of(parts: &[&Vibration]) -> Self {
        let mut keys = Self::usual();
        for one in parts {
            let Vibration { axis, frequency_hz, phase_rad, start_s, ramp_periods, ramp, .. } = **one;
            keys = Self { frequency_hz, phase_rad, start_s, ramp_periods, ramp, ..keys };
            keys.amplitude[axis as usize] = one.amplitude;
        }
        keys
    }

    /// One for each coordinate that changes.
    pub fn vibrations(self) -> impl Iterator<Item = Vibration> {
        let VibrationKeys { amplitude, frequency_hz, phase_rad, start_s, ramp_periods, ramp } = self;
        let one = move |(axis, amplitude)| Vibration {
            axis,
            amplitude,
            frequency_hz,
            phase_rad,
            start_s,
            ramp_periods,
            ramp,
        };
        parts(amplitude).map(one)
    }
}

impl Words for Ramp {
    const WORDS: &'static [(&'static str, Self)] = &[("quintic", Ramp::Quintic), ("cubic", Ramp::Cubic)];
}

lines! {
    /// A vibration of the palm, amplitude × sin(2π f (t − start) + phase), that grows over some periods and goes on to the end.
    VibrationKeys = Self {
        amplitude: [0.0; 3],
        frequency_hz: GIVEN,
        phase_rad: 0.0,
        start_s: 0.0,
        ramp_periods: 2.0,
        ramp: Ramp::Quintic,
    }, v;
    /// Amplitude along the palm.
    "x": Length = Some(&mut v.amplitude[0]), said("0 mm");
    /// Amplitude out of the palm.
    "y": Length = Some(&mut v.amplitude[1]), said("0 mm");
    /// Amplitude of its angle.
    "angle": Angle = Some(&mut v.amplitude[2]), said("0 deg");
    /// Cycles per time.
    "frequency": Frequency = Some(&mut v.frequency_hz), allowed(POSITIVE),
        needed("add how often: frequency = \"200 Hz\"");
    /// Phase at the start.
    "phase": Angle = Some(&mut v.phase_rad), said("0 deg");
    /// When it begins.
    "start": Time = Some(&mut v.start_s), allowed(NOT_NEGATIVE), said("0 ms");
    /// Periods in which it grows from nothing.
    "ramp_periods": Number = Some(&mut v.ramp_periods), allowed(POSITIVE);
    /// How it grows: "quintic": 10 s³ − 15 s⁴ + 6 s⁵, without a jump of the acceleration; "cubic": 3 s² − 2 s³.
    "ramp": Choice<Ramp> = Some(&mut v.ramp);
}

/// A path through poses at given times.
#[derive(Clone, Debug, Default)]
pub struct PathKeys {
    pub times_s: Vec<f64>,
    /// X, Y and Φ; none of a coordinate that stays 0.
    pub coordinates: [Vec<f64>; 3],
}

impl PathKeys {
    pub fn of(path: &Path) -> Self {
        let axis = |axis: usize| path.points().iter().map(|point| point.1[axis]).collect();
        Self { times_s: path.points().iter().map(|point| point.0).collect(), coordinates: std::array::from_fn(axis) }
    }

    /// The spline; `None` where times are too few.
    pub fn path(&self) -> Option<Path> {
        let at = |index: usize| self.coordinates.each_ref().map(|values| values.get(index).copied().unwrap_or(0.0));
        Path::new(self.times_s.iter().enumerate().map(|(index, time)| (*time, at(index))).collect())
    }
}

lines! {
    /// A path of the palm: a cubic spline through poses, at rest before the first and after the last; it adds to moves and vibrations.
    PathKeys = Self::default(), p;
    /// Times, increasing.
    "times": List<Time> = Some(&mut p.times_s);
    /// Along the palm, one for each time. Default: 0 at all.
    "x": List<Length> = Some(&mut p.coordinates[0]);
    /// Out of the palm, one for each time. Default: 0 at all.
    "y": List<Length> = Some(&mut p.coordinates[1]);
    /// Its angle, one for each time. Default: 0 at all.
    "angle": List<Angle> = Some(&mut p.coordinates[2]);
}
