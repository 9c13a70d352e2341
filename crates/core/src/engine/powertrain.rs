//! Actuators with a powertrain: a force along a shaft that depends on the command or on the error of a controller, on the
//! rate of the shaft, on the current of the motor, and on the bristle of the gear.
//!
//! Motor and gear are integrated with the contacts, because their forces change with the rate of the shaft as those of stiff
//! dampers do. The gap of such an element is minus its command, or the measured value less its target.

use super::coordinate::{BodyPose, Coordinate, Twist};
use crate::drive::Profile;
use crate::law::{FrictionLaw, FrictionPoint};
use crate::mechanism::{Actuator, Command, Motor, Powertrain};
use crate::numeric::{Dual, Real};

/// An actuator with a powertrain.
#[derive(Clone, Debug)]
pub struct PlannedPowertrain {
    pub shaft: Coordinate,
    /// Torque or voltage over time, or the target of a controller.
    pub input: Profile,
    /// What a controller measures; also without a controller, the distance of a feedback.
    pub measured: Option<Coordinate>,
    pub law: PowertrainLaw,
    /// Whether the feedback is a distance, which must not become 0.
    pub is_distance: bool,
    /// As in the mechanism.
    pub powertrain: Powertrain,
}

/// Force of a powertrain as a function of its gap, of the rates of gap and shaft, and of its states.
#[derive(Clone, Copy, Debug)]
pub struct PowertrainLaw {
    /// Gains of a controller with the sign of its feedback; `None` for a command over time.
    gains: Option<[f64; 2]>,
    /// Limit of the command.
    limit: f64,
    /// Decrease of the torque per rate of the motor.
    slope: f64,
    gear: f64,
    motor: Option<Motor>,
    /// Normal force per |n u|, and law of friction, of the loss.
    loss: Option<(f64, FrictionLaw)>,
}

/// States of a powertrain: of its bristle, and its current.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PowertrainState {
    pub bristle: f64,
    pub current: f64,
}

/// A powertrain at the end of an implicit step: effort on the shaft with its derivatives by the rates of gap and shaft,
/// torque and voltage of the motor, loss, and states.
#[derive(Clone, Copy, Debug, Default)]
pub struct PowertrainStep {
    pub effort: f64,
    pub d_gap_rate: f64,
    pub d_rate: f64,
    pub torque: f64,
    pub loss: f64,
    pub voltage: f64,
    pub(crate) state: PowertrainState,
}

type Number = Dual<2>;

impl PowertrainStep {
    /// Current of the motor, A.
    pub fn current(&self) -> f64 {
        self.state.current
    }
}

/// A number between ± a bound.
fn clipped(value: Number, bound: f64) -> Number {
    if value.value.abs() > bound { Number::constant(bound.copysign(value.value)) } else { value }
}

impl PlannedPowertrain {
    /// Plans an actuator along a coordinate; `measured` is what its controller measures.
    pub(super) fn new(actuator: &Actuator, shaft: Coordinate, measured: Coordinate) -> Self {
        let powertrain = &actuator.powertrain;
        let sign = powertrain.feedback.map_or(1.0, |feedback| feedback.sign);
        let (input, gains) = match &actuator.command {
            Command::Effort(profile) => (profile, None),
            Command::Servo { kp, kd, target, .. } => (target, Some([sign * kp, sign * kd])),
        };
        let law = PowertrainLaw {
            gains,
            limit: actuator.limit.unwrap_or(f64::INFINITY),
            slope: actuator.no_load_speed.map_or(0.0, f64::recip),
            gear: powertrain.gear,
            motor: powertrain.motor,
            loss: powertrain.loss.map(|loss| ((1.0 - loss.efficiency) * powertrain.gear.abs(), loss.law())),
        };
        Self {
            shaft,
            input: input.clone(),
            measured: (gains.is_some() || powertrain.feedback.is_some()).then_some(measured),
            law,
            is_distance: powertrain.feedback.is_some(),
            powertrain: powertrain.clone(),
        }
    }

    /// Gap at time `t`, and its rate.
    fn gap(&self, t: f64, poses: &[BodyPose], velocities: &[Twist]) -> [f64; 2] {
        let (input, input_rate) = self.input.at(t);
        match self.measured.as_ref().filter(|_| self.law.gains.is_some()) {
            None => [-input, -input_rate],
            Some(measured) => [measured.value(poses) - input, measured.row(poses).rate(velocities) - input_rate],
        }
    }

    /// The measured distance and its rate; 0 without feedback.
    pub(crate) fn distance(&self, (poses, velocities): (&[BodyPose], &[Twist])) -> [f64; 2] {
        let distance = self.measured.as_ref().filter(|_| self.is_distance);
        distance.map_or([0.0; 2], |distance| [distance.value(poses), distance.row(poses).rate(velocities)])
    }

    /// The vector between the points whose distance is measured, if there are any.
    pub(super) fn offset(&self, poses: &[BodyPose]) -> Option<[f64; 2]> {
        Some(self.measured.as_ref().filter(|_| self.is_distance)?.between(poses))
    }

    /// The powertrain at a node.
    pub(crate) fn at_node(
        &self,
        t: f64,
        (poses, velocities): (&[BodyPose], &[Twist]),
        state: PowertrainState,
    ) -> PowertrainStep {
        let [gap, gap_rate] = self.gap(t, poses, velocities);
        self.law.step(gap, [gap_rate, self.shaft.row(poses).rate(velocities)], state, 0.0)
    }
}

impl PowertrainLaw {
    /// Whether the gap is a function of time alone.
    pub(crate) fn has_prescribed_gap(&self) -> bool {
        self.gains.is_none()
    }

    /// Law of friction of the gear.
    pub(crate) fn loss_law(&self) -> Option<&FrictionLaw> {
        self.loss.as_ref().map(|(_, law)| law)
    }

    /// Returns the forces at the end of an implicit step of length `h` from these states, with the gap and the rates there.
    #[inline(never)]
    pub(crate) fn step(&self, gap: f64, rates: [f64; 2], state: PowertrainState, h: f64) -> PowertrainStep {
        let [gap_rate, rate] = [Number::variable(rates[0], 0), Number::variable(rates[1], 1)];
        let command = match self.gains {
            None => Number::constant(-gap),
            Some([kp, kd]) => -(gap_rate.chain(gap, h) * kp + gap_rate * kd),
        };
        let command = clipped(command, self.limit);
        let shaft_rate = rate * self.gear;
        let (torque, current, voltage) = match &self.motor {
            None => {
                let decrease = command.value.abs() * self.slope;
                let by_command = command.value.signum() * self.slope * shaft_rate.value;
                (command - shaft_rate * decrease - (command - command.value) * by_command, 0.0, 0.0)
            }
            Some(motor) => {
                let net = command - shaft_rate * motor.back_emf;
                let free = match motor.inductance {
                    None => net * motor.resistance.recip(),
                    Some(inductance) => {
                        let ratio = h / inductance;
                        (net * ratio + state.current) * (1.0 + ratio * motor.resistance).recip()
                    }
                };
                let current = clipped(free, motor.current_limit.unwrap_or(f64::INFINITY));
                (current * motor.torque_constant, current.value, command.value)
            }
        };
        let (mut loss, mut bristle) = (Number::constant(0.0), state.bristle);
        if let Some((part, law)) = &self.loss {
            let normal = torque * (part * torque.value.signum());
            let point = FrictionPoint { slip: rate.value, state: bristle, normal: normal.value };
            let found = law.implicit_step(point, h, false);
            loss = rate.chain2(normal, found.force, found.d_slip, found.d_normal);
            bristle = found.state;
        }
        let effort = torque * self.gear - loss;
        PowertrainStep {
            effort: effort.value,
            d_gap_rate: effort.grad[0],
            d_rate: effort.grad[1],
            torque: torque.value,
            loss: loss.value,
            voltage,
            state: PowertrainState { bristle, current },
        }
    }
}
