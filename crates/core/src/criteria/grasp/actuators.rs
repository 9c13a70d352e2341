//! Efforts, rates, powers and energies of the actuators during a run.
//!
//! Samples are too far apart for the work of an actuator: its effort jumps where its command does, and a servo follows
//! motions between them. The run knows the work of all actuators together. Its part for each of them is estimated in every
//! step by the law of the actuator along the interpolated motion; the actuators share the difference in proportion to how
//! much this estimate differs from the mean power, so that those without a jump or an impact have none of it.

use crate::criteria::segments::Hermite;
use crate::drive::Profile;
use crate::mechanism::{Actuator, Command, Mechanism};
use crate::scene::Scene;
use crate::trace::{RequiredData, Sample, Sink, SinkError};
use serde::Serialize;

/// A command within this part of the limit counts as at the limit: a servo that presses against a contact approaches it.
const LIMIT_MARGIN: f64 = 1e-6;

/// Nodes and weights of Gauss's quadrature on [0, 1], exact for polynomials of degree 7: the power of a constant gain on a
/// cubic motion has degree 5.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Figures of an actuator over a run. Units are N·m and rad/s, or N and m/s.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ActuatorCriteria {
    #[serde(skip)]
    pub name: String,
    #[serde(skip)]
    pub is_linear: bool,
    /// Largest magnitude of the effort, including that of the brake.
    pub largest_effort: f64,
    /// Largest magnitude of the rate.
    pub largest_rate: f64,
    /// Largest magnitude of the product of effort and rate, W.
    pub largest_power_w: f64,
    /// Work on the mechanism, without that of the brake, J.
    pub energy_j: f64,
    /// Whether the command reached the limit.
    pub saturated: bool,
    /// Command at the end, before it is limited; for a servo with a rate, the last computed command; with a powertrain, its
    /// effort without the loss of its gear.
    #[serde(skip)]
    pub command: f64,
    /// Whether the command at the end is at or beyond the limit.
    #[serde(skip)]
    pub is_at_limit: bool,
}

/// Coordinate of an actuator, and its rate.
type State = [f64; 2];

/// Estimates of the work in a step: by the law of the actuator, and by the mean of the powers at both ends, J.
type Estimates = [f64; 2];

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

    /// Adds the step between two samples, or the first sample.
    pub(super) fn add(all: &mut [Self], mechanism: &Mechanism, last: Option<&Sample>, next: &Sample) {
        let tendons = mechanism.tendons.iter().enumerate();
        let pulls = tendons.filter_map(|(index, tendon)| Some((index, tendon.actuator.as_ref()?)));
        let (of_joints, of_cables) = all.split_at_mut(mechanism.actuators.len());
        let mut estimates = Vec::with_capacity(of_joints.len() + of_cables.len());
        let mut shafts = 0;
        for (index, (found, actuator)) in of_joints.iter_mut().zip(&mechanism.actuators).enumerate() {
            found.add_peaks(next.actuator(index), state(actuator, next)[1]);
            let powertrain = &actuator.powertrain;
            if powertrain.is_direct() {
                estimates.push(found.add_joint_step(actuator, last, next));
                continue;
            }
            let shaft = powertrain.has_shaft().then_some(shafts);
            shafts += usize::from(shaft.is_some());
            let drive = |sample: &Sample| {
                // Before the loss of the gear.
                let torque = shaft.map(|shaft| powertrain.gear * sample.shaft(shaft).motor_torque_n_m);
                (torque.unwrap_or_else(|| sample.actuator(index)), state(actuator, sample)[1])
            };
            estimates.push(found.add_drive_step(actuator, (last, next), &drive));
        }
        for (found, (tendon, actuator)) in of_cables.iter_mut().zip(pulls) {
            // A cable that becomes shorter receives power.
            let state = |sample: &Sample| {
                let cable = sample.tendon(tendon);
                (sample.time_s, [-cable.length_m, -cable.rate_m_s])
            };
            let pull = |time_s: f64, _: State| actuator.tension.at(time_s).0.max(0.0);
            let (time_s, [_, rate]) = state(next);
            found.add_peaks(pull(time_s, [0.0; 2]), rate);
            estimates.push(last.map_or([0.0; 2], |last| work([state(last), state(next)], &actuator.tension, &pull)));
        }
        let Some(last) = last else { return };
        // A prescribed motion does work as well.
        let is_prescribed = mechanism.bodies.iter().any(|body| body.motion.is_some());
        let known_j = (!is_prescribed).then(|| next.energy().motor_work_j - last.energy().motor_work_j);
        let difference_j = known_j.map_or(0.0, |known_j| known_j - estimates.iter().map(|[law, _]| law).sum::<f64>());
        let doubt_j: f64 = estimates.iter().map(|[law, mean]| (law - mean).abs()).sum();
        let even = 1.0 / estimates.len() as f64;
        for (found, [law, mean]) in all.iter_mut().zip(estimates) {
            let share = if doubt_j > 0.0 { (law - mean).abs() / doubt_j } else { even };
            found.energy_j += law + share * difference_j;
        }
    }

    fn add_peaks(&mut self, effort: f64, rate: f64) {
        self.largest_effort = self.largest_effort.max(effort.abs());
        self.largest_rate = self.largest_rate.max(rate.abs());
        self.largest_power_w = self.largest_power_w.max((effort * rate).abs());
    }

    fn add_joint_step(&mut self, actuator: &Actuator, last: Option<&Sample>, next: &Sample) -> Estimates {
        let end = (next.time_s, state(actuator, next));
        let Some(start) = last.map(|last| (last.time_s, state(actuator, last))) else {
            self.set_command(actuator, end);
            return [0.0; 2];
        };
        let Command::Servo { rate_hz: Some(rate_hz), .. } = actuator.command else {
            let law = |time_s: f64, state: State| effort(actuator, command(actuator, time_s, state), state[1]);
            self.set_command(actuator, end);
            return work([start, end], actuator.command.profile(), &law);
        };
        // The servo computes its command at whole multiples of its period.
        let (motion, mut from, mut sum) = (motion([start, end]), start, [0.0; 2]);
        let mut tick = (start.0 * rate_hz).floor();
        loop {
            let time_s = tick / rate_hz;
            if time_s > from.0 {
                let to_s = time_s.min(end.0);
                let to = if to_s < end.0 { (to_s, [motion.value(to_s), motion.rate(to_s)]) } else { end };
                let held = |_: f64, [_, rate]: State| effort(actuator, self.command, rate);
                let part = work([from, to], &Profile::Constant { value: 0.0 }, &held);
                sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
                from = to;
            }
            if time_s > end.0 {
                return sum;
            }
            if time_s == from.0 {
                self.set_command(actuator, from);
            }
            tick += 1.0;
        }
    }

    /// Adds a step of an actuator with a powertrain, whose samples contain its torque; `drive` reads effort and rate.
    fn add_drive_step(
        &mut self,
        actuator: &Actuator,
        (last, next): (Option<&Sample>, &Sample),
        drive: &dyn Fn(&Sample) -> (f64, f64),
    ) -> Estimates {
        let (effort, rate) = drive(next);
        self.command = effort;
        self.is_at_limit = actuator.effort_limit().is_some_and(|limit| effort.abs() >= (1.0 - LIMIT_MARGIN) * limit);
        self.saturated |= self.is_at_limit;
        last.map_or([0.0; 2], |last| {
            let (before, length_s) = (drive(last), next.time_s - last.time_s);
            let powers = [before.0 * before.1, effort * rate];
            [0.5 * (powers[0] + powers[1]) * length_s, powers[0] * length_s]
        })
    }

    fn set_command(&mut self, actuator: &Actuator, (time_s, state): (f64, State)) {
        self.command = command(actuator, time_s, state);
        self.is_at_limit = actuator.limit.is_some_and(|limit| self.command.abs() >= (1.0 - LIMIT_MARGIN) * limit);
        self.saturated |= self.is_at_limit;
    }
}

/// Coordinate of an actuator in a sample, and its rate.
fn state(actuator: &Actuator, sample: &Sample) -> State {
    let coordinate = actuator.on.value(|joint| sample.joint_state(joint).angle_rad);
    [coordinate, actuator.on.sum(|joint| sample.joint_state(joint).rate_rad_s)]
}

/// Command of an actuator before its limit.
fn command(actuator: &Actuator, time_s: f64, [coordinate, rate]: State) -> f64 {
    match &actuator.command {
        Command::Effort(profile) => profile.at(time_s).0,
        Command::Servo { kp, kd, target, .. } => {
            let (target, target_rate) = target.at(time_s);
            kp * (target - coordinate) + kd * (target_rate - rate)
        }
    }
}

/// Effort of an actuator without its brake: the command within its limit, which falls with the speed.
fn effort(actuator: &Actuator, command: f64, rate: f64) -> f64 {
    let limit = actuator.limit.unwrap_or(f64::INFINITY);
    let command = command.clamp(-limit, limit);
    actuator.no_load_speed.map_or(command, |speed| command - command.abs() * rate / speed)
}

fn motion([(t0, [q0, v0]), (t1, [q1, v1])]: [(f64, State); 2]) -> Hermite {
    Hermite::new((t0, q0, v0), (t1, q1, v1))
}

/// Work of an effort between two states, whose command jumps or has kinks where a profile does.
fn work(ends: [(f64, State); 2], profile: &Profile, effort: &dyn Fn(f64, State) -> f64) -> Estimates {
    let [(mut from_s, start), (end_s, end)] = ends;
    let motion = motion(ends);
    let powers = effort(from_s, start) * start[1] + effort(end_s, end) * end[1];
    let (mut work, mean) = (0.0, 0.5 * powers * (end_s - from_s));
    while from_s < end_s {
        let length_s = profile.next_discontinuity(from_s).min(end_s) - from_s;
        for (node, weight) in GAUSS {
            let time_s = from_s + node * length_s;
            let rate = motion.rate(time_s);
            work += weight * length_s * rate * effort(time_s, [motion.value(time_s), rate]);
        }
        from_s += length_s;
    }
    [work, mean]
}

/// A [`Sink`] that computes the figures of all actuators of a scene.
#[derive(Clone, Debug)]
pub struct ActuatorTracker {
    mechanism: Mechanism,
    actuators: Vec<ActuatorCriteria>,
    last: Option<Sample>,
}

impl ActuatorTracker {
    pub fn for_scene(scene: &Scene) -> Self {
        let mechanism = scene.drawn_mechanism().into_owned();
        ActuatorTracker { actuators: ActuatorCriteria::of(&mechanism), mechanism, last: None }
    }

    /// Figures up to the last sample, in the order of the actuators in a sample.
    pub fn actuators(&self) -> &[ActuatorCriteria] {
        &self.actuators
    }
}

impl Sink for ActuatorTracker {
    fn required_data(&self) -> RequiredData {
        RequiredData { energies: true, passive: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        ActuatorCriteria::add(&mut self.actuators, &self.mechanism, self.last.as_ref(), sample);
        self.last = Some(sample.clone());
        Ok(())
    }
}
