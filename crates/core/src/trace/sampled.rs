//! Servos that are computed at a rate: their effort is constant between two samples.

use super::sample::Sample;
use super::schema::DistanceState;
use super::stepper::{Interruption, Stepper};
use super::{Outcome, RunError, Sink, SinkError};
use crate::drive::Profile;
use crate::mechanism::{Actuator, Command, JointCombination, Mechanism};
use crate::scene::Scene;

/// A servo that is computed at a rate.
#[derive(Clone, Debug)]
struct SampledServo {
    /// Index of the actuator.
    actuator: usize,
    on: JointCombination,
    /// Index among the distances of a sample, if it measures a distance in place of the coordinate.
    distance: Option<usize>,
    /// Gains with the sign of the feedback.
    gains: [f64; 2],
    target: Profile,
    rate_hz: f64,
    /// Number of the next sample from the start of the run.
    next: u64,
}

impl SampledServo {
    fn next_time_s(&self) -> f64 {
        self.next as f64 / self.rate_hz
    }

    /// Effort, or voltage of a motor, before its limit, from the state of its joints or its distance.
    fn effort(&self, sample: &Sample) -> f64 {
        let [kp, kd] = self.gains;
        let [value, rate] = match self.distance {
            Some(index) => {
                let DistanceState { distance_m, distance_rate_m_s } = sample.distance(index);
                [distance_m, distance_rate_m_s]
            }
            None => {
                let coordinate = self.on.value(|joint| sample.joint_state(joint).angle_rad);
                [coordinate, self.on.sum(|joint| sample.joint_state(joint).rate_rad_s)]
            }
        };
        let (target, target_rate) = self.target.at(sample.time_s);
        kp * (target - value) + kd * (target_rate - rate)
    }
}

/// Sampled servos of a mechanism.
fn sampled_servos(mechanism: &Mechanism) -> Vec<SampledServo> {
    let mut distances = 0;
    let servo = |(index, actuator): (usize, &Actuator)| {
        let feedback = actuator.powertrain.feedback;
        let distance = feedback.map(|_| distances);
        distances += usize::from(distance.is_some());
        let Command::Servo { kp, kd, target, rate_hz: Some(rate_hz), .. } = &actuator.command else { return None };
        let sign = feedback.map_or(1.0, |feedback| feedback.sign);
        Some(SampledServo {
            actuator: index,
            on: actuator.on.clone(),
            distance,
            gains: [sign * kp, sign * kd],
            target: target.clone(),
            rate_hz: *rate_hz,
            next: 1,
        })
    };
    mechanism.actuators.iter().enumerate().filter_map(servo).collect()
}

/// Whether a mechanism has servos that are computed at a rate.
pub(crate) fn has_sampled_servos(mechanism: &Mechanism) -> bool {
    !sampled_servos(mechanism).is_empty()
}

/// Builds the stepper of a scene; `build` builds it without sampled servos.
pub(super) fn with_sampled_servos(
    scene: &Scene,
    build: impl Fn(&Scene) -> Result<Box<dyn Stepper>, RunError>,
) -> Result<Box<dyn Stepper>, RunError> {
    let Some(mechanism) = &scene.mechanism else { return build(scene) };
    let servos = sampled_servos(mechanism);
    if servos.is_empty() {
        return build(scene);
    }
    let hold = |effort: &dyn Fn(&SampledServo) -> f64| {
        let mut held = mechanism.clone();
        for servo in &servos {
            held.actuators[servo.actuator].command = Command::Effort(Profile::Constant { value: effort(servo) });
        }
        build(&Scene { mechanism: Some(held), ..scene.clone() })
    };
    let mut start = Sample::default();
    hold(&|_| 0.0)?.read(0.0, &mut start);
    let stepper = hold(&|servo| servo.effort(&start))?;
    Ok(Box::new(SampledStepper { stepper, servos, sample: start }))
}

/// A stepper whose servos are sampled.
struct SampledStepper {
    stepper: Box<dyn Stepper>,
    servos: Vec<SampledServo>,
    sample: Sample,
}

impl Stepper for SampledStepper {
    fn begin(&mut self, sink: &mut dyn Sink) -> Result<(), SinkError> {
        self.stepper.begin(sink)
    }

    fn advance(&mut self, t: f64, sink: &mut dyn Sink) -> Result<(), Interruption> {
        let Self { stepper, servos, sample } = self;
        loop {
            let next_s = servos.iter().map(SampledServo::next_time_s).fold(f64::INFINITY, f64::min);
            stepper.advance(t.min(next_s), sink)?;
            if next_s > t {
                return Ok(());
            }
            stepper.read(next_s, sample);
            for servo in servos.iter_mut().filter(|servo| servo.next_time_s() == next_s) {
                servo.next += 1;
                let effort = Profile::Constant { value: servo.effort(sample) };
                stepper.set_input(next_s, servo.actuator, effort, sink)?;
            }
        }
    }

    fn is_within_step(&self, t: f64) -> bool {
        self.servos.iter().all(|servo| servo.next_time_s() > t) && self.stepper.is_within_step(t)
    }

    fn read(&self, t: f64, sample: &mut Sample) {
        self.stepper.read(t, sample);
    }

    /// The target of a sampled servo acts from its next sample on.
    fn set_input(&mut self, t: f64, index: usize, input: Profile, sink: &mut dyn Sink) -> Result<(), Interruption> {
        match self.servos.iter_mut().find(|servo| servo.actuator == index) {
            Some(servo) => {
                servo.target = input;
                Ok(())
            }
            None => self.stepper.set_input(t, index, input, sink),
        }
    }

    fn remove_contacts(&mut self, t: f64, contacts: &[usize], sink: &mut dyn Sink) -> Result<(), Interruption> {
        self.stepper.remove_contacts(t, contacts, sink)
    }

    fn finish(&mut self, sink: &mut dyn Sink) -> Outcome {
        self.stepper.finish(sink)
    }

    fn clone_boxed(&self) -> Box<dyn Stepper> {
        let Self { stepper, servos, sample } = self;
        Box::new(Self { stepper: stepper.clone_boxed(), servos: servos.clone(), sample: sample.clone() })
    }
}
