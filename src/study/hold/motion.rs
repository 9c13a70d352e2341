//! Transformations of palm motions: scaled duration, delay and fade-out.

use crate::scene::{PalmMotion, Path, Vibration};

/// Scales the times of moves and path by `factor`, measured from 0. Start times of vibrations are scaled; their
/// frequencies are kept.
pub fn scale_time(motion: &PalmMotion, factor: f64) -> PalmMotion {
    let mut scaled = motion.clone();
    for segment in &mut scaled.moves {
        segment.start_s *= factor;
        segment.length_s *= factor;
    }
    scaled.vibrations.iter_mut().for_each(|vibration| vibration.start_s *= factor);
    scaled.path = map_path_times(motion, |time_s| time_s * factor);
    scaled
}

/// Delays a motion.
pub fn delay(motion: &PalmMotion, by_s: f64) -> PalmMotion {
    let mut delayed = motion.clone();
    delayed.moves.iter_mut().for_each(|segment| segment.start_s += by_s);
    delayed.vibrations.iter_mut().for_each(|vibration| vibration.start_s += by_s);
    delayed.path = map_path_times(motion, |time_s| time_s + by_s);
    delayed
}

fn map_path_times(motion: &PalmMotion, map: impl Fn(f64) -> f64) -> Option<Path> {
    let points = motion.path.as_ref()?.points();
    Path::new(points.iter().map(|(time_s, pose)| (map(*time_s), *pose)).collect())
}

/// Returns a vibration that fades out, and the time at which it has ended. The fade starts after a whole number of
/// periods, not before `from_s`: from there on, the same vibration with opposite sign and the same ramp cancels it.
pub fn fade_out(vibration: &Vibration, from_s: f64) -> ([Vibration; 2], f64) {
    let periods = ((from_s - vibration.start_s) * vibration.frequency_hz - 1e-9).ceil().max(0.0);
    let start_s = vibration.start_s + periods / vibration.frequency_hz;
    let opposite = Vibration { amplitude: -vibration.amplitude, start_s, ..*vibration };
    ([*vibration, opposite], start_s + vibration.ramp_periods / vibration.frequency_hz)
}

/// Largest acceleration of a point of the palm in the world during the moves and the path, without vibrations, m/s².
pub fn peak_acceleration(motion: &PalmMotion, point_m: [f64; 2]) -> f64 {
    let moves = PalmMotion { vibrations: Vec::new(), ..motion.clone() };
    moves.peak_acceleration_m_s2(point_m, moves.moves_end_s())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, Move, Ramp};

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
        let twice = delay(&scale_time(&slow, 2.0), 0.5);
        for time_s in [0.03, 0.1, 0.17, 0.33] {
            let (original, scaled) = (slow.pose(time_s), twice.pose(0.5 + 2.0 * time_s));
            for axis in 0..3 {
                assert!((original.position[axis] - scaled.position[axis]).abs() < 1e-14, "{time_s}");
                assert!((original.rate[axis] - 2.0 * scaled.rate[axis]).abs() < 1e-11, "{time_s}");
                assert!((original.acceleration[axis] - 4.0 * scaled.acceleration[axis]).abs() < 1e-9, "{time_s}");
            }
        }
        let ratio = peak_acceleration(&slow, [0.01, 0.02]) / peak_acceleration(&scale_time(&slow, 2.0), [0.01, 0.02]);
        assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
        let later = &delay(&scale_time(&motion(), 2.0), 0.5).vibrations[0];
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
