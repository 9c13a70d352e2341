//! `[moves.NAME]`, `[vibrations.NAME]` and `[path]` of a gripper: the motion of its palm.

use super::{SettingsSection, settings};
use crate::numeric::elementary::hypot;
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::value_kinds::{Acceleration, Angle, Choice, Frequency, Keyword, Length, List, Number, Time};
use crate::scene::{Axis, Move, Path, Ramp, Vibration};

const UNSET: f64 = f64::NAN;

const AXES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Angle];

/// A move along any of the three coordinates.
#[derive(Clone, Copy, Debug)]
pub struct MoveSettings {
    distance: [f64; 3],
    pub start_s: f64,
    /// Duration of the move; NaN if `peak_m_s2` is given, and vice versa.
    pub length_s: f64,
    pub peak_m_s2: f64,
}

impl MoveSettings {
    /// Settings of the moves with the same name.
    pub fn from_moves(moves: &[&Move]) -> Self {
        let mut settings = Self::defaults();
        for item in moves {
            settings.distance[item.axis as usize] = item.distance;
            (settings.start_s, settings.length_s) = (item.start_s, item.length_s);
        }
        settings
    }

    /// Distance of the translation.
    pub fn distance_m(&self) -> f64 {
        hypot(self.distance[0], self.distance[1])
    }

    /// Moves along each coordinate that changes; the duration follows from the peak acceleration if that is given.
    pub fn moves(self) -> impl Iterator<Item = Move> {
        let distance_m = self.distance_m();
        let MoveSettings { distance, start_s, peak_m_s2, .. } = self;
        let length_s = if peak_m_s2.is_nan() {
            self.length_s
        } else {
            (Move::unit_peak_acceleration() * distance_m / peak_m_s2).sqrt()
        };
        nonzero_coordinates(distance).map(move |(axis, distance)| Move { axis, distance, start_s, length_s })
    }
}

fn nonzero_coordinates(values: [f64; 3]) -> impl Iterator<Item = (Axis, f64)> {
    AXES.into_iter().zip(values).filter(|(_, value)| *value != 0.0)
}

settings! {
    /// A move of the palm from rest to rest along a polynomial of order 7, with zero rate, acceleration and jerk at
    /// both ends. Overlapping moves add up.
    MoveSettings = Self { distance: [0.0; 3], start_s: UNSET, length_s: UNSET, peak_m_s2: UNSET }, m;
    /// Distance along the palm.
    "x": Length = Some(&mut m.distance[0]), default_text("0 mm");
    /// Distance out of the palm; negative to lift an object with the gripper upside down.
    "y": Length = Some(&mut m.distance[1]), default_text("0 mm");
    /// Rotation, counter-clockwise.
    "angle": Angle = Some(&mut m.distance[2]), default_text("0 deg");
    /// Time at which the move begins.
    "start": Time = Some(&mut m.start_s), allowed(NOT_NEGATIVE), required("add the start of the move: start = \"20 ms\"");
    /// Duration. Alternative to `acceleration`.
    "time": Time = Some(&mut m.length_s), allowed(POSITIVE);
    /// Peak acceleration a over the distance s = √(x² + y²), which determines the duration T = √(16.8/√5 s/a), with
    /// 16.8/√5 = 7.513. Alternative to `time`.
    "acceleration": Acceleration = Some(&mut m.peak_m_s2), allowed(POSITIVE);
}

/// A vibration along any of the three coordinates.
#[derive(Clone, Copy, Debug)]
pub struct VibrationSettings {
    amplitude: [f64; 3],
    frequency_hz: f64,
    phase_rad: f64,
    start_s: f64,
    ramp_periods: f64,
    ramp: Ramp,
}

impl VibrationSettings {
    /// Settings of the vibrations with the same name.
    pub fn from_vibrations(vibrations: &[&Vibration]) -> Self {
        let mut settings = Self::defaults();
        for vibration in vibrations {
            let Vibration { axis, frequency_hz, phase_rad, start_s, ramp_periods, ramp, .. } = **vibration;
            settings = Self { frequency_hz, phase_rad, start_s, ramp_periods, ramp, ..settings };
            settings.amplitude[axis as usize] = vibration.amplitude;
        }
        settings
    }

    /// Vibrations along each coordinate that changes.
    pub fn vibrations(self) -> impl Iterator<Item = Vibration> {
        let VibrationSettings { amplitude, frequency_hz, phase_rad, start_s, ramp_periods, ramp } = self;
        let vibration = move |(axis, amplitude)| Vibration {
            axis,
            amplitude,
            frequency_hz,
            phase_rad,
            start_s,
            ramp_periods,
            ramp,
        };
        nonzero_coordinates(amplitude).map(vibration)
    }
}

impl Keyword for Ramp {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("quintic", Ramp::Quintic), ("cubic", Ramp::Cubic)];
}

settings! {
    /// A vibration of the palm, amplitude × sin(2π f (t − start) + phase), with a ramp over the first periods.
    VibrationSettings = Self {
        amplitude: [0.0; 3],
        frequency_hz: UNSET,
        phase_rad: 0.0,
        start_s: 0.0,
        ramp_periods: 2.0,
        ramp: Ramp::Quintic,
    }, v;
    /// Amplitude along x, in the direction of the palm.
    "x": Length = Some(&mut v.amplitude[0]), default_text("0 mm");
    /// Amplitude along y, out of the palm.
    "y": Length = Some(&mut v.amplitude[1]), default_text("0 mm");
    /// Amplitude of the angle.
    "angle": Angle = Some(&mut v.amplitude[2]), default_text("0 deg");
    /// Frequency. Required.
    "frequency": Frequency = Some(&mut v.frequency_hz), allowed(POSITIVE),
        required("add the frequency: frequency = \"200 Hz\"");
    /// Phase at the start.
    "phase": Angle = Some(&mut v.phase_rad), default_text("0 deg");
    /// Time at which the vibration begins.
    "start": Time = Some(&mut v.start_s), allowed(NOT_NEGATIVE), default_text("0 ms");
    /// Duration of the ramp of the amplitude, in periods.
    "ramp_periods": Number = Some(&mut v.ramp_periods), allowed(POSITIVE);
    /// Shape of the ramp: "quintic": 10 s³ − 15 s⁴ + 6 s⁵, with continuous acceleration; "cubic": 3 s² − 2 s³.
    "ramp": Choice<Ramp> = Some(&mut v.ramp);
}

/// A path through poses at given times.
#[derive(Clone, Debug, Default)]
pub struct PathSettings {
    pub times_s: Vec<f64>,
    /// X, Y and Φ; empty for a coordinate that remains 0.
    pub coordinates: [Vec<f64>; 3],
}

impl PathSettings {
    pub fn from_path(path: &Path) -> Self {
        let axis = |axis: usize| path.points().iter().map(|point| point.1[axis]).collect();
        Self { times_s: path.points().iter().map(|point| point.0).collect(), coordinates: std::array::from_fn(axis) }
    }

    /// Creates the spline; `None` for fewer than two times.
    pub fn path(&self) -> Option<Path> {
        let at = |index: usize| self.coordinates.each_ref().map(|values| values.get(index).copied().unwrap_or(0.0));
        Path::new(self.times_s.iter().enumerate().map(|(index, time)| (*time, at(index))).collect())
    }
}

settings! {
    /// A path of the palm: a cubic spline through poses, at rest before the first and after the last; added to moves
    /// and vibrations.
    PathSettings = Self::default(), p;
    /// Times of the poses, increasing.
    "times": List<Time> = Some(&mut p.times_s);
    /// Positions along the palm, one per time. Default: 0.
    "x": List<Length> = Some(&mut p.coordinates[0]);
    /// Positions out of the palm, one per time. Default: 0.
    "y": List<Length> = Some(&mut p.coordinates[1]);
    /// Angles, one per time. Default: 0.
    "angle": List<Angle> = Some(&mut p.coordinates[2]);
}
