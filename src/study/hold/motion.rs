//! What moves a palm, at another pace, later, or only for a while.

use crate::scene::{PalmMotion, Path, Vibration};

/// The same way in `factor` times the time, counted from 0; vibrations begin that much later, but keep their frequencies.
pub fn stretched(motion: &PalmMotion, factor: f64) -> PalmMotion {
    let mut found = motion.clone();
    for one in &mut found.moves {
        one.start_s *= factor;
        one.length_s *= factor;
    }
    found.vibrations.iter_mut().for_each(|one| one.start_s *= factor);
    found.path = at_times(motion, |time_s| time_s * factor);
    found
}

/// The same so much later.
pub fn delayed(motion: &PalmMotion, by_s: f64) -> PalmMotion {
    let mut found = motion.clone();
    found.moves.iter_mut().for_each(|one| one.start_s += by_s);
    found.vibrations.iter_mut().for_each(|one| one.start_s += by_s);
    found.path = at_times(motion, |time_s| time_s + by_s);
    found
}

fn at_times(motion: &PalmMotion, of: impl Fn(f64) -> f64) -> Option<Path> {
    let points = motion.path.as_ref()?.points();
    Path::new(points.iter().map(|(time_s, pose)| (of(*time_s), *pose)).collect())
}

/// A vibration that begins to fade after so many whole periods that it is no earlier than a time, and when it is gone: the same one in
/// opposite sense that begins there takes it away as it grew.
pub fn faded(vibration: &Vibration, from_s: f64) -> ([Vibration; 2], f64) {
    let periods = ((from_s - vibration.start_s) * vibration.frequency_hz - 1e-9).ceil().max(0.0);
    let start_s = vibration.start_s + periods / vibration.frequency_hz;
    let against = Vibration { amplitude: -vibration.amplitude, start_s, ..*vibration };
    ([*vibration, against], start_s + vibration.ramp_periods / vibration.frequency_hz)
}

/// The largest acceleration of a point of the palm in the world while moves and path last, m/s²: vibrations are left out.
pub fn peak(motion: &PalmMotion, point_m: [f64; 2]) -> f64 {
    let moves = PalmMotion { vibrations: Vec::new(), ..motion.clone() };
    moves.peak_m_s2(point_m, moves.arrives_s())
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
    fn twice_the_time_is_the_same_way_at_a_quarter_of_the_acceleration() {
        let slow = PalmMotion { vibrations: Vec::new(), ..motion() };
        let twice = delayed(&stretched(&slow, 2.0), 0.5);
        for time_s in [0.03, 0.1, 0.17, 0.33] {
            let (one, other) = (slow.pose(time_s), twice.pose(0.5 + 2.0 * time_s));
            for axis in 0..3 {
                assert!((one.place[axis] - other.place[axis]).abs() < 1e-14, "{time_s}");
                assert!((one.rate[axis] - 2.0 * other.rate[axis]).abs() < 1e-11, "{time_s}");
                assert!((one.acceleration[axis] - 4.0 * other.acceleration[axis]).abs() < 1e-9, "{time_s}");
            }
        }
        let ratio = peak(&slow, [0.01, 0.02]) / peak(&stretched(&slow, 2.0), [0.01, 0.02]);
        assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
        let later = &delayed(&stretched(&motion(), 2.0), 0.5).vibrations[0];
        assert_eq!((later.start_s, later.frequency_hz), (0.7, 40.0));
    }

    #[test]
    fn peaks_are_those_of_single_moves_and_of_turns() {
        let one = |axis, distance| PalmMotion {
            moves: vec![Move { axis, distance, start_s: 0.0, length_s: 0.2 }],
            ..PalmMotion::default()
        };
        let unit = Move::unit_peak();
        let found = peak(&one(Axis::Y, 0.3), [0.0, 0.02]);
        assert!((found / (unit * 0.3 / 0.04) - 1.0).abs() < 1e-6, "{found}");
        // About the palm's middle by so little that nothing is centripetal.
        let found = peak(&one(Axis::Angle, 1e-6), [0.0, 0.02]);
        assert!((found / (unit * 1e-6 * 0.02 / 0.04) - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn what_fades_is_gone_and_was_whole_before() {
        let shake = motion().vibrations[0];
        let (both, gone_s) = faded(&shake, 0.333);
        assert!(both[1].start_s >= 0.333 && both[1].start_s < 0.333 + 1.0 / 40.0);
        let motion = |vibrations: Vec<Vibration>| PalmMotion { vibrations, ..PalmMotion::default() };
        let (alone, faded) = (motion(vec![shake]), motion(both.to_vec()));
        assert_eq!(alone.pose(0.32), faded.pose(0.32));
        let after = faded.pose(gone_s + 0.0123);
        assert!(after.place[1].abs() < 1e-15 && after.acceleration[1].abs() < 1e-9, "{after:?}");
        // A whole number of periods already is not rounded up by another one.
        assert_eq!(super::faded(&shake, 0.1 + 8.0 / 40.0).0[1].start_s, 0.1 + 8.0 / 40.0);
    }
}
