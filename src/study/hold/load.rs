//! Loads: palm motions with a given peak acceleration, applied once the gripper holds the object; scaled, delayed and
//! fading motions.

use std::f64::consts::TAU;

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use crate::numeric::elementary::{powi, sin_cos};
use crate::scene::{Axis, Move, PalmMotion, Path, Ramp, Vibration};

/// Number of periods of a vibration at full amplitude.
const FULL_PERIODS: f64 = 10.0;
const RAMP_PERIODS: f64 = 2.0;

/// Kind of load. Its strength is given by the peak acceleration, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadCase {
    /// Rest-to-rest move along a line: first accelerated in this direction (counter-clockwise from +x), then braked.
    Pulse { direction_rad: f64, length_s: f64 },
    /// Twelve periods and a fade-out. For a rotation about the centre of the palm, the peak acceleration is the
    /// object's.
    Vibration { axis: Axis, frequency_hz: f64 },
    /// The scene's own move, faster or slower.
    Move,
}

impl LoadCase {
    /// The keys `load` (`pulse`, `vibration` or `move`), `direction_rad`, `length_s`, `axis` and `frequency_hz`, which
    /// are null for other kinds.
    pub(crate) fn object(&self) -> Object<'static> {
        let (load, [direction_rad, length_s, frequency_hz], axis) = match *self {
            LoadCase::Pulse { direction_rad, length_s } => ("pulse", [Some(direction_rad), Some(length_s), None], None),
            LoadCase::Vibration { axis, frequency_hz } => {
                ("vibration", [None, None, Some(frequency_hz)], Some(axis_name(axis)))
            }
            LoadCase::Move => ("move", [None; 3], None),
        };
        let object = Object::default().with("load", load).with("direction_rad", direction_rad);
        object.with("length_s", length_s).with("axis", axis).with("frequency_hz", frequency_hz)
    }
}

pub(crate) fn axis_name(axis: Axis) -> &'static str {
    match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Angle => "angle",
    }
}

/// Size of a load, under a key with its unit: `distance_m` of a pulse, `amplitude_m` or `amplitude_rad` of a vibration,
/// `time_s` of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadSize {
    pub key: &'static str,
    pub value: f64,
}

impl Serialize for LoadSize {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map([(self.key, self.value)])
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    pub motion: PalmMotion,
    /// Time at which the palm is at rest again.
    pub end_s: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LoadSetup {
    pub start_s: f64,
    /// Motion of the palm up to the start of the loads.
    pub prior_motion: PalmMotion,
    /// Move of the scene for [`LoadCase::Move`]. Its times are measured from its start.
    pub scene_motion: PalmMotion,
    /// Peak acceleration of this move, m/s².
    pub scene_peak_m_s2: f64,
    /// Distance from the centre of the palm to the centre of the object, m.
    pub lever_m: f64,
}

impl LoadCase {
    /// Direction of its accelerations; `None` for loads that turn or change their direction.
    pub(super) fn direction(&self) -> Option<[f64; 2]> {
        let (sin, cos) = match self {
            LoadCase::Pulse { direction_rad, .. } => sin_cos(*direction_rad),
            LoadCase::Vibration { axis: Axis::X, .. } => (0.0, 1.0),
            LoadCase::Vibration { axis: Axis::Y, .. } => (1.0, 0.0),
            LoadCase::Vibration { axis: Axis::Angle, .. } | LoadCase::Move => return None,
        };
        Some([cos, sin])
    }

    /// Returns the size of the load: the distance of a pulse, m; the amplitude of a vibration, m or rad; or the
    /// duration of a move relative to that of the scene's move.
    pub fn size(&self, setup: &LoadSetup, peak_m_s2: f64) -> f64 {
        match *self {
            LoadCase::Pulse { length_s, .. } => peak_m_s2 * length_s * length_s / Move::unit_peak_acceleration(),
            LoadCase::Vibration { axis, frequency_hz } => {
                let arm = if axis == Axis::Angle { setup.lever_m } else { 1.0 };
                peak_m_s2 / (powi(TAU * frequency_hz, 2) * arm)
            }
            LoadCase::Move => (setup.scene_peak_m_s2 / peak_m_s2).sqrt(),
        }
    }

    /// Returns the size of the load with its key; a move has its duration.
    pub(super) fn named_size(&self, setup: &LoadSetup, peak_m_s2: f64) -> LoadSize {
        let size = self.size(setup, peak_m_s2);
        let (key, value) = match self {
            LoadCase::Pulse { .. } => ("distance_m", size),
            LoadCase::Vibration { axis: Axis::Angle, .. } => ("amplitude_rad", size),
            LoadCase::Vibration { .. } => ("amplitude_m", size),
            LoadCase::Move => ("time_s", size * setup.scene_motion.moves_end_s()),
        };
        LoadSize { key, value }
    }

    pub fn load(&self, setup: &LoadSetup, peak_m_s2: f64) -> Load {
        let (size, start_s) = (self.size(setup, peak_m_s2), setup.start_s);
        let mut motion = setup.prior_motion.clone();
        match *self {
            LoadCase::Pulse { direction_rad, length_s } => {
                let (sin, cos) = sin_cos(direction_rad);
                for (axis, component) in [(Axis::X, cos), (Axis::Y, sin)] {
                    // The cosine of a quarter turn is 6e-17, not 0.
                    if component.abs() > f64::EPSILON {
                        motion.moves.push(Move { axis, distance: size * component, start_s, length_s });
                    }
                }
                Load { motion, end_s: start_s + length_s }
            }
            LoadCase::Vibration { axis, frequency_hz } => {
                let vibration = Vibration {
                    axis,
                    amplitude: size,
                    frequency_hz,
                    phase_rad: 0.0,
                    start_s,
                    ramp_periods: RAMP_PERIODS,
                    ramp: Ramp::Quintic,
                };
                let fade_start_s = start_s + (RAMP_PERIODS + FULL_PERIODS) / frequency_hz;
                let (both, end_s) = fade_out(&vibration, fade_start_s);
                motion.vibrations.extend(both);
                Load { motion, end_s }
            }
            LoadCase::Move => {
                let scene_motion = rescale(&setup.scene_motion, size, start_s);
                let arrival_s = scene_motion.moves_end_s();
                let ends = scene_motion.vibrations.iter().map(|vibration| fade_out(vibration, arrival_s));
                let (vibrations, over): (Vec<_>, Vec<f64>) = ends.unzip();
                motion.moves.extend(scene_motion.moves);
                motion.vibrations.extend(vibrations.into_iter().flatten());
                motion.path = scene_motion.path.or(motion.path);
                Load { motion, end_s: over.into_iter().fold(arrival_s, f64::max) }
            }
        }
    }
}

/// Scales the times of a motion by `factor`, measured from 0, and delays it. The frequencies of vibrations are kept.
pub(super) fn rescale(motion: &PalmMotion, factor: f64, delay_s: f64) -> PalmMotion {
    let map = |time_s: f64| time_s * factor + delay_s;
    let mut mapped = motion.clone();
    for segment in &mut mapped.moves {
        (segment.start_s, segment.length_s) = (map(segment.start_s), segment.length_s * factor);
    }
    mapped.vibrations.iter_mut().for_each(|vibration| vibration.start_s = map(vibration.start_s));
    let points = motion.path.as_ref().map(|path| path.points().iter().map(|(time_s, pose)| (map(*time_s), *pose)));
    mapped.path = points.and_then(|points| Path::new(points.collect()));
    mapped
}

/// Returns a vibration that fades out, and the time at which it has ended. The fade starts after a whole number of
/// periods, not before `from_s`: from there on, the same vibration with opposite sign and the same ramp cancels it.
fn fade_out(vibration: &Vibration, from_s: f64) -> ([Vibration; 2], f64) {
    let periods = ((from_s - vibration.start_s) * vibration.frequency_hz - 1e-9).ceil().max(0.0);
    let start_s = vibration.start_s + periods / vibration.frequency_hz;
    let opposite = Vibration { amplitude: -vibration.amplitude, start_s, ..*vibration };
    ([*vibration, opposite], start_s + vibration.ramp_periods / vibration.frequency_hz)
}

/// Returns the moves and the path alone.
fn without_vibrations(motion: &PalmMotion) -> PalmMotion {
    PalmMotion { vibrations: Vec::new(), ..motion.clone() }
}

/// Largest acceleration of a point of the palm in the world during the moves and the path, m/s².
pub(super) fn peak_acceleration(motion: &PalmMotion, point_m: [f64; 2]) -> f64 {
    let moves = without_vibrations(motion);
    moves.peak_acceleration_m_s2(point_m, moves.moves_end_s())
}

/// Returns the start time of the moves and the path, if there are any.
pub(super) fn moves_start(motion: &PalmMotion) -> Option<f64> {
    Some(without_vibrations(motion).start_s()).filter(|start_s| start_s.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup() -> LoadSetup {
        let transfer = Move { axis: Axis::X, distance: 0.3, start_s: 0.0, length_s: 0.2 };
        LoadSetup {
            start_s: 0.03,
            prior_motion: PalmMotion::default(),
            scene_peak_m_s2: Move::unit_peak_acceleration() * 0.3 / 0.04,
            scene_motion: PalmMotion { moves: vec![transfer], ..PalmMotion::default() },
            lever_m: 0.02,
        }
    }

    /// Largest acceleration of the palm, or of a point at the lever arm if the palm rotates.
    fn peak(load: &Load, setup: &LoadSetup) -> f64 {
        let acceleration_at = |index: usize| {
            let time_s = setup.start_s + (load.end_s - setup.start_s) * index as f64 / 1e5;
            let [x, y, angular] = load.motion.pose(time_s).acceleration;
            x.hypot(y) + angular.abs() * setup.lever_m
        };
        (0..=100_000).map(acceleration_at).fold(0.0, f64::max)
    }

    #[test]
    fn loads_have_the_requested_peak_acceleration() {
        let setup = setup();
        for peak_m_s2 in [3.0, 250.0] {
            for case in [
                LoadCase::Pulse { direction_rad: 0.0, length_s: 0.04 },
                LoadCase::Pulse { direction_rad: 2.0, length_s: 0.01 },
                LoadCase::Vibration { axis: Axis::Y, frequency_hz: 200.0 },
                LoadCase::Vibration { axis: Axis::Angle, frequency_hz: 50.0 },
                LoadCase::Move,
            ] {
                let load = case.load(&setup, peak_m_s2);
                let found = peak(&load, &setup) / peak_m_s2;
                // The envelope of a vibration adds a little during its ramps.
                let excess = if matches!(case, LoadCase::Vibration { .. }) { 0.03 } else { 1e-8 };
                assert!(found > 1.0 - 1e-8 && found < 1.0 + excess, "{case:?}: {found}");
                assert_eq!(load.motion.pose(setup.start_s).acceleration, [0.0; 3], "{case:?}");
                let after = load.motion.pose(load.end_s + 0.01);
                for (rate, acceleration) in after.rate.iter().zip(after.acceleration) {
                    assert!(rate.abs() < 1e-12 && acceleration.abs() < 1e-9 * peak_m_s2, "{case:?}: {after:?}");
                }
            }
        }
    }

    #[test]
    fn pulse_along_an_axis_has_a_single_move() {
        for (quarter, axis) in [Axis::X, Axis::Y, Axis::X, Axis::Y].into_iter().enumerate() {
            let direction_rad = quarter as f64 * TAU / 4.0;
            let load = LoadCase::Pulse { direction_rad, length_s: 0.04 }.load(&setup(), 10.0);
            let moves = &load.motion.moves;
            assert!(moves.len() == 1 && moves[0].axis == axis, "{quarter}: {moves:?}");
            assert_eq!(moves[0].distance > 0.0, quarter < 2);
        }
    }

    fn motion() -> PalmMotion {
        let path = Path::new(vec![(0.01, [0.0; 3]), (0.2, [0.1, -0.02, 0.3]), (0.4, [0.05, 0.0, 0.0])]);
        let shake = Vibration {
            axis: Axis::Y,
            amplitude: 1e-3,
            frequency_hz: 40.0,
            phase_rad: 0.3,
            start_s: 0.1,
            ramp_periods: 2.0,
            ramp: Ramp::Quintic,
        };
        let across = Move { axis: Axis::X, distance: 0.3, start_s: 0.05, length_s: 0.2 };
        PalmMotion { moves: vec![across], vibrations: vec![shake], path, ..PalmMotion::default() }
    }

    #[test]
    fn doubled_duration_quarters_the_acceleration() {
        let slow = PalmMotion { vibrations: Vec::new(), ..motion() };
        let twice = rescale(&slow, 2.0, 0.5);
        for time_s in [0.03, 0.1, 0.17, 0.33] {
            let (original, scaled) = (slow.pose(time_s), twice.pose(0.5 + 2.0 * time_s));
            for axis in 0..3 {
                assert!((original.position[axis] - scaled.position[axis]).abs() < 1e-14, "{time_s}");
                assert!((original.rate[axis] - 2.0 * scaled.rate[axis]).abs() < 1e-11, "{time_s}");
                assert!((original.acceleration[axis] - 4.0 * scaled.acceleration[axis]).abs() < 1e-9, "{time_s}");
            }
        }
        let ratio = peak_acceleration(&slow, [0.01, 0.02]) / peak_acceleration(&rescale(&slow, 2.0, 0.0), [0.01, 0.02]);
        assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
        let later = &rescale(&motion(), 2.0, 0.5).vibrations[0];
        assert_eq!((later.start_s, later.frequency_hz), (0.7, 40.0));
    }

    #[test]
    fn peak_acceleration_of_translations_and_rotations() {
        let single_move = |axis, distance| PalmMotion {
            moves: vec![Move { axis, distance, start_s: 0.0, length_s: 0.2 }],
            ..PalmMotion::default()
        };
        let unit = Move::unit_peak_acceleration();
        let found = peak_acceleration(&single_move(Axis::Y, 0.3), [0.0, 0.02]);
        assert!((found / (unit * 0.3 / 0.04) - 1.0).abs() < 1e-6, "{found}");
        // The rotation about the centre of the palm is so small that the centripetal acceleration is negligible.
        let found = peak_acceleration(&single_move(Axis::Angle, 1e-6), [0.0, 0.02]);
        assert!((found / (unit * 1e-6 * 0.02 / 0.04) - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn faded_vibration_is_unchanged_before_and_zero_after_the_fade() {
        let shake = motion().vibrations[0];
        let (both, end_s) = fade_out(&shake, 0.333);
        assert!(both[1].start_s >= 0.333 && both[1].start_s < 0.333 + 1.0 / 40.0);
        let motion = |vibrations: Vec<Vibration>| PalmMotion { vibrations, ..PalmMotion::default() };
        let (alone, faded) = (motion(vec![shake]), motion(both.to_vec()));
        assert_eq!(alone.pose(0.32), faded.pose(0.32));
        let after = faded.pose(end_s + 0.0123);
        assert!(after.position[1].abs() < 1e-15 && after.acceleration[1].abs() < 1e-9, "{after:?}");
        // A whole number of periods is not rounded up.
        assert_eq!(fade_out(&shake, 0.1 + 8.0 / 40.0).0[1].start_s, 0.1 + 8.0 / 40.0);
    }
}
