//! Efforts, rates, powers and energies of the actuators during a run.

use crate::mechanism::{Actuator, Command, Mechanism};
use crate::trace::Sample;
use serde::Serialize;

/// A command within this part of the limit counts as at the limit: a servo that presses against a contact approaches it.
const LIMIT_MARGIN: f64 = 1e-6;

/// Figures of an actuator over a run, in N·m and rad/s, or N and m/s.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ActuatorCriteria {
    #[serde(skip)]
    pub name: String,
    #[serde(skip)]
    pub is_linear: bool,
    /// Largest magnitudes of the effort, with that of the brake, of the rate, and of their product, W.
    pub largest_effort: f64,
    pub largest_rate: f64,
    pub largest_power_w: f64,
    /// Work on the mechanism, J.
    pub energy_j: f64,
    /// Whether the command reached the limit.
    pub saturated: bool,
    #[serde(skip)]
    last: Option<(f64, f64)>,
}

impl ActuatorCriteria {
    /// Creates the figures of all actuators, in the order of a sample.
    pub(super) fn of(mechanism: &Mechanism) -> Vec<Self> {
        let of_joints = mechanism.actuators.iter().map(|actuator| {
            let is_angle = actuator.on.terms.iter().all(|(joint, _)| mechanism.joints[*joint].kind.is_angle());
            (actuator.name.clone(), !is_angle)
        });
        let pulls = mechanism.tendons.iter().filter_map(|tendon| tendon.actuator.as_ref());
        let all = of_joints.chain(pulls.map(|actuator| (actuator.name.clone(), true)));
        all.map(|(name, is_linear)| ActuatorCriteria { name, is_linear, ..Self::default() }).collect()
    }

    /// Adds a sample.
    pub(super) fn add(all: &mut [Self], mechanism: &Mechanism, sample: &Sample) {
        let tendons = mechanism.tendons.iter().enumerate().filter(|(_, tendon)| tendon.actuator.is_some());
        let rates = mechanism.actuators.iter().map(|actuator| {
            let is_at_limit = is_at_limit(actuator, sample);
            (actuator.on.sum(|joint| sample.joint_state(joint).rate_rad_s), is_at_limit)
        });
        // A cable that becomes shorter receives power.
        let pulls = tendons.map(|(index, _)| (-sample.tendon(index).rate_m_s, false));
        for (index, (found, (rate, is_at_limit))) in all.iter_mut().zip(rates.chain(pulls)).enumerate() {
            let effort = sample.actuator(index);
            let power_w = effort * rate;
            found.largest_effort = found.largest_effort.max(effort.abs());
            found.largest_rate = found.largest_rate.max(rate.abs());
            found.largest_power_w = found.largest_power_w.max(power_w.abs());
            if let Some((time_s, last_w)) = found.last {
                found.energy_j += 0.5 * (last_w + power_w) * (sample.time_s - time_s);
            }
            found.last = Some((sample.time_s, power_w));
            found.saturated |= is_at_limit;
        }
    }
}

/// Command of an actuator in a sample, before its limit.
pub(super) fn command(actuator: &Actuator, sample: &Sample) -> f64 {
    match &actuator.command {
        Command::Effort(profile) => profile.at(sample.time_s).0,
        Command::Servo { kp, kd, target, .. } => {
            let coordinate = actuator.on.value(|joint| sample.joint_state(joint).angle_rad);
            let rate = actuator.on.sum(|joint| sample.joint_state(joint).rate_rad_s);
            let (target, target_rate) = target.at(sample.time_s);
            kp * (target - coordinate) + kd * (target_rate - rate)
        }
    }
}

/// Whether the command of an actuator is at or beyond its limit.
pub(super) fn is_at_limit(actuator: &Actuator, sample: &Sample) -> bool {
    actuator.limit.is_some_and(|limit| command(actuator, sample).abs() >= (1.0 - LIMIT_MARGIN) * limit)
}
