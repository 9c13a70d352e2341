//! Torques and forces of actuators: the command, its limit, and the fall of the torque with the speed, in ranges that
//! end where one of them has a kink.

use crate::drive::BrakeTorque;
use crate::mechanism::{Actuator, Command};

/// A range ends this part of its scale beyond its nominal end, so that neighbouring ranges do not alternate.
pub(super) const RANGE_MARGIN: f64 = 1e-9;
/// Tolerance of locating that end, as a fraction of the margin.
pub(super) const RANGE_TOLERANCE: f64 = 0.3;

/// Range of each actuator: the number of its thresholds below the command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ranges(pub Vec<u8>);

/// Range of an actuator without events: kinks are not resolved.
pub(super) const UNMONITORED: u8 = u8::MAX;

/// Force or torque of an actuator with its derivatives by coordinate, rate and time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    pub value: f64,
    pub by_coordinate: f64,
    pub by_rate: f64,
    pub by_time: f64,
}

/// Returns the command before the limit, with its derivatives.
pub(super) fn command(actuator: &Actuator, t: f64, coordinate: f64, rate: f64) -> Effort {
    match &actuator.command {
        Command::Effort(profile) => {
            let (value, by_time) = profile.at(t);
            Effort { value, by_time, ..Effort::default() }
        }
        Command::Servo { kp, kd, target, .. } => {
            let (target, target_rate) = target.at(t);
            Effort {
                value: kp * (target - coordinate) + kd * (target_rate - rate),
                by_coordinate: -kp,
                by_rate: -kd,
                by_time: kp * target_rate,
            }
        }
    }
}

/// Thresholds of the command, in order; not a number where there is none.
fn thresholds(actuator: &Actuator) -> [f64; 3] {
    let limit = actuator.limit.unwrap_or(f64::NAN);
    [-limit, if actuator.no_load_speed.is_some() { 0.0 } else { f64::NAN }, limit]
}

/// Range of the command in a state.
pub(super) fn range(actuator: &Actuator, t: f64, coordinate: f64, rate: f64) -> u8 {
    range_of_value(actuator, command(actuator, t, coordinate, rate).value)
}

/// Range of a command.
pub(super) fn range_of_value(actuator: &Actuator, value: f64) -> u8 {
    thresholds(actuator).iter().fold(0, |range, threshold| range << 1 | u8::from(value > *threshold))
}

/// Ends of a range: the command is above the first and not above the second.
pub(super) fn ends(actuator: &Actuator, range: u8) -> [f64; 2] {
    let mut ends = [f64::NEG_INFINITY, f64::INFINITY];
    for (index, threshold) in thresholds(actuator).into_iter().enumerate() {
        match range >> (2 - index) & 1 == 1 {
            true => ends[0] = ends[0].max(threshold),
            false => ends[1] = ends[1].min(threshold),
        }
    }
    ends
}

/// Effort of an actuator in a range.
pub(super) fn effort(actuator: &Actuator, range: u8, t: f64, coordinate: f64, rate: f64) -> Effort {
    let mut u = command(actuator, t, coordinate, rate);
    if let Some(limit) = actuator.limit {
        let [lower, upper] = if range == UNMONITORED { [u.value; 2] } else { ends(actuator, range) };
        if lower >= limit {
            u = Effort { value: limit, ..Effort::default() };
        } else if upper <= -limit {
            u = Effort { value: -limit, ..Effort::default() };
        }
    }
    let Some(speed) = actuator.no_load_speed else { return u };
    let is_negative = if range == UNMONITORED { u.value < 0.0 } else { ends(actuator, range)[1] <= 0.0 };
    let sign = if is_negative { -1.0 } else { 1.0 };
    let factor = 1.0 - sign * rate / speed;
    Effort {
        value: u.value * factor,
        by_coordinate: u.by_coordinate * factor,
        by_rate: u.by_rate * factor - sign * u.value / speed,
        by_time: u.by_time * factor,
    }
}

/// Magnitude against which the ends of ranges are located.
pub(super) fn command_scale(actuator: &Actuator) -> f64 {
    let largest = match &actuator.command {
        Command::Effort(profile) => profile.largest(),
        Command::Servo { kp, kd, target, .. } => kp.max(*kd) * target.largest().max(1.0),
    };
    actuator.limit.unwrap_or(largest).max(f64::MIN_POSITIVE)
}

/// Event function of the range of a command: not negative within it.
pub(super) fn margin(actuator: &Actuator, range: u8, value: impl FnOnce() -> f64) -> f64 {
    if range == UNMONITORED || actuator.limit.is_none() && actuator.no_load_speed.is_none() {
        return f64::INFINITY;
    }
    let value = value();
    let [lower, upper] = ends(actuator, range);
    (value - lower).min(upper - value) + RANGE_MARGIN * command_scale(actuator)
}

pub(super) fn margin_tolerance(actuator: &Actuator) -> f64 {
    RANGE_TOLERANCE * RANGE_MARGIN * command_scale(actuator)
}

/// Range after the end of a range was located: that of the command, or its neighbour if the command is still within the
/// margin.
pub(super) fn range_after(actuator: &Actuator, old: u8, value: f64) -> u8 {
    let found = range_of_value(actuator, value);
    if found != old {
        return found;
    }
    let [lower, upper] = ends(actuator, old);
    let is_below = value - lower < upper - value;
    let end = if is_below { lower } else { upper };
    thresholds(actuator)
        .iter()
        .fold(0, |range, threshold| range << 1 | u8::from(end > *threshold || end == *threshold && !is_below))
}

/// Torque or force of the brake of an actuator, with its effect on the state of its bristle.
#[derive(Clone, Copy, Debug)]
pub(super) struct BrakeEffort {
    pub effort: Effort,
    /// Index of the state of the brake's bristle.
    pub bristle: Option<usize>,
    /// Derivative of the effort with respect to this state.
    pub by_bristle: f64,
    /// Rate of this state per unit effort.
    pub gain: f64,
}

/// Effort of the brake of an actuator at the state of its bristle.
pub(super) fn brake_effort(actuator: &Actuator, t: f64, rate: f64, state: Option<(usize, f64)>) -> Option<BrakeEffort> {
    let brake = actuator.brake.as_ref()?;
    let (index, state) = state.unzip();
    let BrakeTorque { torque: [value, by_rate, by_time], by_bristle, gain } = brake.torque(t, rate, state);
    let effort = Effort { value, by_rate, by_time, by_coordinate: 0.0 };
    Some(BrakeEffort { effort, bristle: brake.bristle.and(index), by_bristle, gain })
}
