//! Motion of the palm of a gripper.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::numeric::elementary::hypot;
use crate::scene::quantity::{
    Acceleration, Angle, Frequency, Keyword, Length, NotNegative, Plain, Positive, Quantity, Time, Word, quantities,
    si_values,
};
use crate::scene::{Axis, Move, Path, Ramp, Vibration};

/// Coordinates that are not 0.
fn nonzero(x: f64, y: f64, angle: f64) -> impl Iterator<Item = (Axis, f64)> {
    [(Axis::X, x), (Axis::Y, y), (Axis::Angle, angle)].into_iter().filter(|(_, value)| *value != 0.0)
}

/// A move of the palm from rest to rest along a polynomial of order 7, with zero rate, acceleration and jerk at
/// both ends. Overlapping moves add up.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct MoveSettings {
    /// Distance along the palm.
    #[schemars(extend("default" = "0 mm"))]
    pub x: Quantity<Length>,
    /// Distance out of the palm; negative to lift an object with the gripper upside down.
    #[schemars(extend("default" = "0 mm"))]
    pub y: Quantity<Length>,
    /// Rotation, counter-clockwise.
    #[schemars(extend("default" = "0 deg"))]
    pub angle: Quantity<Angle>,
    /// Time at which the move begins.
    #[schemars(extend("x-required" = "add the start of the move: start = \"20 ms\""))]
    pub start: Option<NotNegative<Time>>,
    /// Duration. Alternative to `acceleration`.
    pub time: Option<Positive<Time>>,
    /// Peak acceleration a over the distance s = √(x² + y²), which determines the duration T = √(16.8/√5 s/a), with
    /// 16.8/√5 = 7.513. Alternative to `time`.
    pub acceleration: Option<Positive<Acceleration>>,
}

impl MoveSettings {
    /// Adds a move along one coordinate.
    pub fn add(&mut self, item: &Move) {
        match item.axis {
            Axis::X => self.x = item.distance.into(),
            Axis::Y => self.y = item.distance.into(),
            Axis::Angle => self.angle = item.distance.into(),
        }
        (self.start, self.time) = (Some(item.start_s.into()), Some(item.length_s.into()));
    }

    /// Distance of the translation.
    pub fn distance_m(&self) -> f64 {
        hypot(*self.x, *self.y)
    }

    /// Moves along each coordinate that changes; the duration follows from the peak acceleration if that is given.
    pub fn moves(&self) -> impl Iterator<Item = Move> {
        let start_s = self.start.map_or(f64::NAN, |start| *start);
        let length_s = match self.acceleration {
            None => self.time.map_or(f64::NAN, |time| *time),
            Some(peak) => (Move::unit_peak_acceleration() * self.distance_m() / *peak).sqrt(),
        };
        nonzero(*self.x, *self.y, *self.angle).map(move |(axis, distance)| Move { axis, distance, start_s, length_s })
    }
}

/// A vibration of the palm, amplitude × sin(2π f (t − start) + phase), with a ramp over the first periods.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct VibrationSettings {
    /// Amplitude along x, in the direction of the palm.
    #[schemars(extend("default" = "0 mm"))]
    pub x: Quantity<Length>,
    /// Amplitude along y, out of the palm.
    #[schemars(extend("default" = "0 mm"))]
    pub y: Quantity<Length>,
    /// Amplitude of the angle.
    #[schemars(extend("default" = "0 deg"))]
    pub angle: Quantity<Angle>,
    /// Frequency. Required.
    #[schemars(extend("x-required" = "add the frequency: frequency = \"200 Hz\""))]
    pub frequency: Option<Positive<Frequency>>,
    /// Phase at the start.
    #[schemars(extend("default" = "0 deg"))]
    pub phase: Quantity<Angle>,
    /// Time at which the vibration begins.
    #[schemars(extend("default" = "0 ms"))]
    pub start: NotNegative<Time>,
    /// Duration of the ramp of the amplitude, in periods.
    #[schemars(extend("default" = 2.0))]
    pub ramp_periods: Positive<Plain>,
    /// Shape of the ramp: "quintic": 10 s³ − 15 s⁴ + 6 s⁵, with continuous acceleration; "cubic": 3 s² − 2 s³.
    #[schemars(extend("default" = "quintic"))]
    pub ramp: Word<Ramp>,
}

impl VibrationSettings {
    /// Adds a vibration along one coordinate.
    pub fn add(&mut self, item: &Vibration) {
        let Vibration { axis, amplitude, frequency_hz, phase_rad, start_s, ramp_periods, ramp } = *item;
        match axis {
            Axis::X => self.x = amplitude.into(),
            Axis::Y => self.y = amplitude.into(),
            Axis::Angle => self.angle = amplitude.into(),
        }
        (self.frequency, self.phase, self.start) = (Some(frequency_hz.into()), phase_rad.into(), start_s.into());
        (self.ramp_periods, self.ramp) = (ramp_periods.into(), Word(ramp));
    }

    /// Vibrations along each coordinate that changes.
    pub fn vibrations(&self) -> impl Iterator<Item = Vibration> {
        let frequency_hz = self.frequency.map_or(f64::NAN, |frequency| *frequency);
        let (phase_rad, start_s, ramp_periods, ramp) = (*self.phase, *self.start, *self.ramp_periods, self.ramp.0);
        nonzero(*self.x, *self.y, *self.angle).map(move |(axis, amplitude)| Vibration {
            axis,
            amplitude,
            frequency_hz,
            phase_rad,
            start_s,
            ramp_periods,
            ramp,
        })
    }
}

impl Keyword for Ramp {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("quintic", Ramp::Quintic), ("cubic", Ramp::Cubic)];
}

/// A path of the palm: a cubic spline through poses, at rest before the first and after the last; added to moves
/// and vibrations.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct PathSettings {
    /// Times of the poses, increasing.
    pub times: Option<Vec<Quantity<Time>>>,
    /// Positions along the palm, one per time. Default: 0.
    pub x: Option<Vec<Quantity<Length>>>,
    /// Positions out of the palm, one per time. Default: 0.
    pub y: Option<Vec<Quantity<Length>>>,
    /// Angles, one per time. Default: 0.
    pub angle: Option<Vec<Quantity<Angle>>>,
}

impl PathSettings {
    /// Times of the poses; empty if they are not given.
    pub fn times_s(&self) -> Vec<f64> {
        self.times.as_deref().map(si_values).unwrap_or_default()
    }

    /// X, Y and Φ over the poses; empty for a coordinate that is not given.
    pub fn coordinates(&self) -> [Vec<f64>; 3] {
        let lengths = |values: &Option<Vec<Quantity<Length>>>| values.as_deref().map(si_values).unwrap_or_default();
        [lengths(&self.x), lengths(&self.y), self.angle.as_deref().map(si_values).unwrap_or_default()]
    }

    /// Creates the spline; `None` for fewer than two times.
    pub fn path(&self) -> Option<Path> {
        let coordinates = self.coordinates();
        let at = |index: usize| coordinates.each_ref().map(|values| values.get(index).copied().unwrap_or(0.0));
        Path::new(self.times_s().into_iter().enumerate().map(|(index, time)| (time, at(index))).collect())
    }
}

impl From<&Path> for PathSettings {
    fn from(path: &Path) -> Self {
        let axis = |axis: usize| path.points().iter().map(move |point| point.1[axis]);
        PathSettings {
            times: Some(quantities(path.points().iter().map(|point| point.0))),
            x: Some(quantities(axis(0))),
            y: Some(quantities(axis(1))),
            angle: Some(quantities(axis(2))),
        }
    }
}
