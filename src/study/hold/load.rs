//! What moves the palm at a peak acceleration, once the gripper holds.

use std::f64::consts::TAU;

use super::motion::{delayed, faded, stretched};
use crate::numeric::elementary::{powi, sin_cos};
use crate::scene::{Axis, Move, PalmMotion, Ramp, Vibration};

/// Whole periods of a vibration at its full amplitude, and those in which it grows and fades.
const PERIODS: f64 = 10.0;
const RAMP_PERIODS: f64 = 2.0;

/// A kind of load; how strong it is is its peak acceleration, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Case {
    /// From rest to rest along a line, counter-clockwise from +x: accelerated that way first, then braked.
    Pulse { direction_rad: f64, length_s: f64 },
    /// Twelve periods and their fading; about the palm's middle it is the object's acceleration there.
    Vibration { axis: Axis, frequency_hz: f64 },
    /// A move of the scene's own, faster or slower.
    Move,
}

/// What a load does to the palm.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    pub motion: PalmMotion,
    /// When the palm is at rest again.
    pub over_s: f64,
}

/// Where loads begin, and what they move.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    pub begins_s: f64,
    /// What has moved the palm by then.
    pub before: PalmMotion,
    /// The move that is made faster or slower, counted from its beginning, and its peak acceleration.
    pub own: PalmMotion,
    pub own_peak_m_s2: f64,
    /// From the palm's middle to the object's centre.
    pub lever_m: f64,
}

impl Case {
    /// How large the load is: how far a pulse goes, m, the amplitude of a vibration, m or rad, or how often the time of the scene's own
    /// move it takes.
    pub fn size(&self, stage: &Stage, peak_m_s2: f64) -> f64 {
        match *self {
            Case::Pulse { length_s, .. } => peak_m_s2 * length_s * length_s / Move::unit_peak(),
            Case::Vibration { axis, frequency_hz } => {
                let arm = if axis == Axis::Angle { stage.lever_m } else { 1.0 };
                peak_m_s2 / (powi(TAU * frequency_hz, 2) * arm)
            }
            Case::Move => (stage.own_peak_m_s2 / peak_m_s2).sqrt(),
        }
    }

    /// The whole motion of the palm.
    pub fn load(&self, stage: &Stage, peak_m_s2: f64) -> Load {
        let (size, start_s) = (self.size(stage, peak_m_s2), stage.begins_s);
        let mut motion = stage.before.clone();
        match *self {
            Case::Pulse { direction_rad, length_s } => {
                let (sin, cos) = sin_cos(direction_rad);
                for (axis, part) in [(Axis::X, cos), (Axis::Y, sin)] {
                    // A quarter turn has a cosine of 6e-17.
                    if part.abs() > f64::EPSILON {
                        motion.moves.push(Move { axis, distance: size * part, start_s, length_s });
                    }
                }
                Load { motion, over_s: start_s + length_s }
            }
            Case::Vibration { axis, frequency_hz } => {
                let vibration = Vibration {
                    axis,
                    amplitude: size,
                    frequency_hz,
                    phase_rad: 0.0,
                    start_s,
                    ramp_periods: RAMP_PERIODS,
                    ramp: Ramp::Quintic,
                };
                let full_s = start_s + (RAMP_PERIODS + PERIODS) / frequency_hz;
                let (both, over_s) = faded(&vibration, full_s);
                motion.vibrations.extend(both);
                Load { motion, over_s }
            }
            Case::Move => {
                let own = delayed(&stretched(&stage.own, size), start_s);
                let arrives_s = own.arrives_s();
                let ends = own.vibrations.iter().map(|vibration| faded(vibration, arrives_s));
                let (vibrations, over): (Vec<_>, Vec<f64>) = ends.unzip();
                motion.moves.extend(own.moves);
                motion.vibrations.extend(vibrations.into_iter().flatten());
                motion.path = own.path.or(motion.path);
                Load { motion, over_s: over.into_iter().fold(arrives_s, f64::max) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage() -> Stage {
        let across = Move { axis: Axis::X, distance: 0.3, start_s: 0.0, length_s: 0.2 };
        Stage {
            begins_s: 0.03,
            before: PalmMotion::default(),
            own_peak_m_s2: Move::unit_peak() * 0.3 / 0.04,
            own: PalmMotion { moves: vec![across], ..PalmMotion::default() },
            lever_m: 0.02,
        }
    }

    /// Largest acceleration of the palm, or of a point of it at the lever where it turns.
    fn peak(load: &Load, stage: &Stage) -> f64 {
        let at = |index: usize| {
            let time_s = stage.begins_s + (load.over_s - stage.begins_s) * index as f64 / 1e5;
            let [x, y, turn] = load.motion.pose(time_s).acceleration;
            x.hypot(y) + turn.abs() * stage.lever_m
        };
        (0..=100_000).map(at).fold(0.0, f64::max)
    }

    #[test]
    fn peaks_are_those_that_were_asked_for() {
        let stage = stage();
        for peak_m_s2 in [3.0, 250.0] {
            for case in [
                Case::Pulse { direction_rad: 0.0, length_s: 0.04 },
                Case::Pulse { direction_rad: 2.0, length_s: 0.01 },
                Case::Vibration { axis: Axis::Y, frequency_hz: 200.0 },
                Case::Vibration { axis: Axis::Angle, frequency_hz: 50.0 },
                Case::Move,
            ] {
                let load = case.load(&stage, peak_m_s2);
                let found = peak(&load, &stage) / peak_m_s2;
                // While a vibration grows or fades, its envelope adds a little.
                let above = if matches!(case, Case::Vibration { .. }) { 0.03 } else { 1e-8 };
                assert!(found > 1.0 - 1e-8 && found < 1.0 + above, "{case:?}: {found}");
                assert_eq!(load.motion.pose(stage.begins_s).acceleration, [0.0; 3], "{case:?}");
                let after = load.motion.pose(load.over_s + 0.01);
                for (rate, acceleration) in after.rate.iter().zip(after.acceleration) {
                    assert!(rate.abs() < 1e-12 && acceleration.abs() < 1e-9 * peak_m_s2, "{case:?}: {after:?}");
                }
            }
        }
    }

    #[test]
    fn a_pulse_along_an_axis_leaves_the_other_alone() {
        for (quarter, axis) in [Axis::X, Axis::Y, Axis::X, Axis::Y].into_iter().enumerate() {
            let direction_rad = quarter as f64 * TAU / 4.0;
            let load = Case::Pulse { direction_rad, length_s: 0.04 }.load(&stage(), 10.0);
            let moves = &load.motion.moves;
            assert!(moves.len() == 1 && moves[0].axis == axis, "{quarter}: {moves:?}");
            assert_eq!(moves[0].distance > 0.0, quarter < 2);
        }
    }
}
