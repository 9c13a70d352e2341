//! Loads: palm motions with a given peak acceleration, applied once the gripper holds the object.

use std::f64::consts::TAU;

use super::motion::{delay, fade_out, scale_time};
use crate::numeric::elementary::{powi, sin_cos};
use crate::scene::{Axis, Move, PalmMotion, Ramp, Vibration};

/// Number of periods of a vibration at full amplitude.
const FULL_PERIODS: f64 = 10.0;
/// Number of periods of each ramp of a vibration.
const RAMP_PERIODS: f64 = 2.0;

/// Kind of load. The peak acceleration, m/s², sets its strength.
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

/// Palm motion of a load.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    pub motion: PalmMotion,
    /// Time at which the palm is at rest again.
    pub end_s: f64,
}

/// Common data of the loads.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSetup {
    /// Start time of the loads.
    pub start_s: f64,
    /// Palm motion up to the start of the loads.
    pub prior_motion: PalmMotion,
    /// Move of [`LoadCase::Move`], with times measured from its start.
    pub scene_motion: PalmMotion,
    /// Peak acceleration of this move.
    pub scene_peak_m_s2: f64,
    /// Distance from the centre of the palm to the object's centre.
    pub lever_m: f64,
}

impl LoadCase {
    /// Returns the size of the load: the distance of a pulse, m, the amplitude of a vibration, m or rad, or the
    /// duration of a move relative to the scene's own move.
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

    /// Returns the complete palm motion of the load.
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
                let scene_motion = delay(&scale_time(&setup.scene_motion, size), start_s);
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
}
