//! A simulation that its user advances, with inputs that change: a controller in the loop.

use std::cell::OnceCell;
use std::sync::Arc;

use super::grid::{RecordingOptions, Span};
use super::sample::{Event, Sample};
use super::schema::{Channel, ContactSample, Schema};
use super::stepper::{Interruption, Stepper};
use super::{KeepRunning, Model, RequiredData, RunError, Sink, SinkError, build, check_supported};
use crate::drive::{Interpolation, Profile};
use crate::integrator::{Failure, Reason};
use crate::mechanism::{Actuator, Command};
use crate::scene::{Scene, closest_match};

/// Time after which a target stops that was set with a rate, s.
const MOVING_TARGET_S: f64 = 1e4;

/// A scene in one of the models, advanced by its user.
///
/// Between two calls, the model takes its natural steps and locates its events. The last step may end after the present
/// time of the simulation; values are then read inside this step. Results of the analytic model do not depend on how
/// the time is divided. The engine model ends a step at each present time: a closing in 1,000 pieces differs from one
/// in a single piece by up to 4e-6 rad, which is of the order of its error. A change of an input ends a step. The end
/// of the scene does not end a simulation.
///
/// A clone continues independently, bit for bit.
pub struct Simulation {
    origin: Arc<Origin>,
    schema: Schema,
    channels: Vec<Channel>,
    inputs: Vec<Input>,
    stepper: Box<dyn Stepper>,
    time_s: f64,
    events: Vec<Event>,
    actions: Vec<Action>,
    failure: Option<Failure>,
    /// Sample at the present time, once it has been read.
    sample: OnceCell<Sample>,
}

/// A call that has changed a simulation. On a new simulation, the same actions give bit-identical results.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Advance to a time, s.
    Advance(f64),
    /// Torque of the actuator with this index, N·m or N.
    Torque(usize, f64),
    /// Target of the actuator with this index and its rate.
    Target(usize, f64, f64),
}

impl Clone for Simulation {
    fn clone(&self) -> Self {
        Self {
            origin: Arc::clone(&self.origin),
            schema: self.schema.clone(),
            channels: self.channels.clone(),
            inputs: self.inputs.clone(),
            stepper: self.stepper.clone_boxed(),
            time_s: self.time_s,
            events: self.events.clone(),
            actions: self.actions.clone(),
            failure: self.failure.clone(),
            sample: self.sample.clone(),
        }
    }
}

/// Scene and model of a simulation.
struct Origin {
    scene: Scene,
    model: Model,
}

impl Origin {
    /// Whether both have the same equations and settings of the model; name, text, duration and log may differ.
    fn has_states_of(&self, other: &Self) -> bool {
        let (scene, others) = (&self.scene, &other.scene);
        let has_same_settings = match self.model {
            Model::Analytic => scene.integrator == others.integrator,
            Model::Engine => scene.engine == others.engine,
        };
        self.model == other.model
            && has_same_settings
            && (&scene.hand, &scene.mechanism) == (&others.hand, &others.mechanism)
    }

    fn description(&self) -> String {
        format!("the scene \"{}\" in the {} model", self.scene.name, self.model.name())
    }
}

/// An error of a simulation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The model does not simulate this scene.
    #[error("{0}")]
    Rejected(String),
    /// A wrong name or value; the simulation is unchanged and can continue.
    #[error("{0}")]
    Input(String),
    /// The model cannot advance further, or was cancelled; restore a clone to continue.
    #[error("the simulation cannot continue {0}")]
    Failed(#[from] Failure),
}

/// Input of an actuator: its torque, or the target of a servo, over time.
#[derive(Clone, Debug)]
struct Input {
    name: String,
    /// Index of the actuator in the model.
    index: usize,
    is_servo: bool,
    profile: Profile,
    /// The profile as it was set, without the limit of its rate.
    requested: Option<Profile>,
    /// Largest rate of the target.
    target_rate: Option<f64>,
}

/// Stores events.
struct EventList<'a> {
    events: &'a mut Vec<Event>,
    keep_running: KeepRunning<'a>,
}

impl Sink for EventList<'_> {
    fn required_data(&self) -> RequiredData {
        RequiredData::NONE
    }

    fn sample(&mut self, _: &Sample) -> Result<(), SinkError> {
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }

    fn should_continue(&self) -> bool {
        (self.keep_running)()
    }
}

impl Simulation {
    /// Creates the simulation of a scene at its start.
    ///
    /// # Errors
    /// Returns an error if the model does not simulate the scene.
    pub fn new(scene: &Scene, model: Model) -> Result<Self, SimulationError> {
        let rejected = |error: RunError| match error {
            RunError::Simulation { failure, .. } => SimulationError::Rejected(failure.reason.to_string()),
            RunError::Sink(error) => SimulationError::Rejected(error.to_string()),
        };
        check_supported(scene).map_err(rejected)?;
        let schema = Schema::from_scene(scene);
        let recording = RecordingOptions {
            counts: schema.counts(),
            span: Span::UNSAMPLED,
            ends_at_exit: false,
            threshold_n: None,
            // The analytic model computes the forces in joints when they are read.
            required_data: RequiredData { joint_forces: model == Model::Engine, ..RequiredData::NONE },
        };
        let mut stepper = build(model, scene, recording).map_err(rejected)?;
        let mut events = Vec::new();
        let begun = stepper.begin(&mut EventList { events: &mut events, keep_running: &|| true });
        begun.map_err(|error| SimulationError::Rejected(error.to_string()))?;
        let (channels, inputs) = (schema.channels(), inputs(scene));
        let origin = Arc::new(Origin { scene: scene.clone(), model });
        Ok(Self {
            origin,
            schema,
            channels,
            inputs,
            stepper,
            time_s: 0.0,
            events,
            actions: Vec::new(),
            failure: None,
            sample: OnceCell::new(),
        })
    }

    /// Checks that `state`, a clone of a simulation, has the same scene, model and settings.
    ///
    /// # Errors
    /// Returns an error that names both scenes and models.
    pub fn check_state(&self, state: &Simulation) -> Result<(), SimulationError> {
        if Arc::ptr_eq(&self.origin, &state.origin) || self.origin.has_states_of(&state.origin) {
            return Ok(());
        }
        let [state, own] = [&state.origin, &self.origin].map(|origin| origin.description());
        let differences = if state == own { ", with other values or settings" } else { "" };
        Err(SimulationError::Input(format!(
            "the state is of {state}{differences}, but this is a simulation of {own}; give a state of this simulation, or of one \
             of the same scene and model"
        )))
    }

    /// Continues from a state, bit for bit.
    ///
    /// # Errors
    /// See [`Simulation::check_state`]. After an error, the simulation is unchanged.
    pub fn restore(&mut self, state: &Simulation) -> Result<(), SimulationError> {
        self.check_state(state)?;
        self.clone_from(state);
        Ok(())
    }

    /// Actions since the start that have changed something. `None` if an observer has ended a step, because this cannot
    /// be repeated.
    pub fn actions(&self) -> Option<&[Action]> {
        let is_stopped = self.failure.as_ref().is_some_and(|failure| failure.reason == Reason::Stopped);
        (!is_stopped).then_some(&self.actions)
    }

    /// Repeats the actions of another simulation of the same scene and model. On a new simulation, the results are
    /// bit-identical. A failure is repeated as well, and is not an error.
    ///
    /// # Errors
    /// Returns an error for an action for which this simulation has no actuator.
    pub fn repeat(&mut self, actions: &[Action], keep_running: KeepRunning<'_>) -> Result<(), SimulationError> {
        for action in actions {
            let result = match *action {
                Action::Advance(time_s) => self.advance_while(time_s, keep_running),
                Action::Torque(index, torque) => self.input_name(index).and_then(|name| self.set_torque(&name, torque)),
                Action::Target(index, target, rate) => {
                    self.input_name(index).and_then(|name| self.set_target(&name, target, rate))
                }
            };
            match result {
                Err(SimulationError::Failed(_)) => return Ok(()),
                result => result?,
            }
        }
        Ok(())
    }

    fn input_name(&self, index: usize) -> Result<String, SimulationError> {
        let input = self.inputs.get(index).map(|input| input.name.clone());
        input.ok_or_else(|| SimulationError::Input(format!("there is no actuator with the index {index}")))
    }

    pub fn model(&self) -> Model {
        self.origin.model
    }

    /// Present time, s.
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// Channels of the sample, in the order of the columns of a recording.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Names of the actuators whose input is a torque, or a force for a prismatic joint.
    pub fn torque_inputs(&self) -> impl Iterator<Item = &str> {
        self.names(false)
    }

    /// Names of the actuators whose input is a target.
    pub fn target_inputs(&self) -> impl Iterator<Item = &str> {
        self.names(true)
    }

    fn names(&self, is_servo: bool) -> impl Iterator<Item = &str> {
        self.inputs.iter().filter(move |input| input.is_servo == is_servo).map(|input| &input.name[..])
    }

    /// Reason why the simulation cannot advance; `None` if it can.
    pub fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    /// Events so far, in order of time. They are those of steps that end at or before the present time.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Removes and returns the events so far.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Returns the sample at the present time.
    pub fn sample(&self) -> &Sample {
        self.sample.get_or_init(|| {
            let mut sample = Sample::default();
            self.stepper.read(self.time_s, &mut sample);
            sample
        })
    }

    /// Returns a number of the sample by the name of its column, such as `q11_rad`.
    ///
    /// # Errors
    /// Returns an error that lists the columns if there is no such column.
    pub fn get(&self, column: &str) -> Result<f64, SimulationError> {
        match self.channels.iter().find(|channel| channel.name == column) {
            Some(channel) => Ok(channel.value(self.sample())),
            None => {
                let names: Vec<&str> = self.channels.iter().map(|channel| &channel.name[..]).collect();
                let similar = closest_match(column, &names);
                let suggestion = similar.map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
                let message = format!("`{column}` is no column{suggestion}; columns: {}", names.join(", "));
                Err(SimulationError::Input(message))
            }
        }
    }

    /// Returns numbers of the sample, in the order of `columns`.
    ///
    /// # Errors
    /// See [`Simulation::get`].
    pub fn observe(&self, columns: &[String]) -> Result<Vec<f64>, SimulationError> {
        columns.iter().map(|column| self.get(column)).collect()
    }

    /// Returns the contacts of the scene with their names.
    pub fn contacts(&self) -> impl Iterator<Item = (&str, ContactSample)> {
        let contacts = self.schema.contacts.iter().zip(self.sample().contacts());
        contacts.map(|(name, contact)| (&name.name[..], contact))
    }

    /// Advances by a duration, s.
    ///
    /// # Errors
    /// See [`Simulation::advance_to`].
    pub fn advance(&mut self, duration_s: f64) -> Result<(), SimulationError> {
        self.advance_to(self.time_s + duration_s)
    }

    /// Advances to a time, s.
    ///
    /// # Errors
    /// Returns an error if the time is before the present time, or if the model cannot reach it. In the latter case,
    /// the simulation stays at the time of the failure.
    pub fn advance_to(&mut self, time_s: f64) -> Result<(), SimulationError> {
        self.advance_while(time_s, &|| true)
    }

    /// Whether an advance to a time, s, needs no new step of the model and therefore takes almost no computing time.
    pub fn is_within_step(&self, time_s: f64) -> bool {
        self.failure.is_none() && self.stepper.is_within_step(time_s)
    }

    /// Advances to a time, s. `keep_running` is called once per step; once it returns false, the simulation stops and
    /// cannot continue.
    ///
    /// # Errors
    /// See [`Simulation::advance_to`].
    pub fn advance_while(&mut self, time_s: f64, keep_running: KeepRunning<'_>) -> Result<(), SimulationError> {
        if !(time_s >= self.time_s && time_s.is_finite()) {
            let now_s = self.time_s;
            return Err(SimulationError::Input(format!(
                "the simulation is at {now_s} s and cannot advance to {time_s} s; give a finite time that is not earlier"
            )));
        }
        let is_within_step = self.is_within_step(time_s);
        if self.failure.is_none() {
            self.record_advance(time_s);
        }
        if is_within_step {
            self.sample.take();
            self.time_s = time_s;
            return Ok(());
        }
        self.step(time_s, |stepper, sink| stepper.advance(time_s, sink), keep_running)
    }

    /// Records an advance. It replaces the one before where the division of time has no effect.
    fn record_advance(&mut self, time_s: f64) {
        match self.actions.last_mut() {
            Some(Action::Advance(last_s)) if self.origin.model == Model::Analytic => *last_s = time_s,
            _ => self.actions.push(Action::Advance(time_s)),
        }
    }

    /// Sets the torque of an actuator, N·m (of a prismatic joint: the force, N; of a motor behind a gear: its torque; of an
    /// electric motor: its voltage, V), from now on.
    ///
    /// # Errors
    /// Returns an error that lists the actuators if the name is wrong, or if the model cannot end a step here.
    pub fn set_torque(&mut self, actuator: &str, torque: f64) -> Result<(), SimulationError> {
        self.set_input(actuator, false, Profile::Constant { value: torque }, [torque, 0.0])
    }

    /// Sets the target of a servo, rad or m, from now on. The target moves at `rate`, rad/s or m/s, for at most 10,000
    /// s. For a servo with a `target_rate`, the set point starts from its present value and follows the target at no
    /// more than that rate.
    ///
    /// # Errors
    /// See [`Simulation::set_torque`].
    pub fn set_target(&mut self, actuator: &str, target: f64, rate: f64) -> Result<(), SimulationError> {
        let profile = match rate {
            0.0 => Profile::Constant { value: target },
            _ => {
                let end = (self.time_s + MOVING_TARGET_S, target + rate * MOVING_TARGET_S);
                Profile::Table { points: vec![(self.time_s, target), end], interpolation: Interpolation::Linear }
            }
        };
        self.set_input(actuator, true, profile, [target, rate])
    }

    fn set_input(
        &mut self,
        name: &str,
        is_servo: bool,
        profile: Profile,
        values: [f64; 2],
    ) -> Result<(), SimulationError> {
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(SimulationError::Input(format!("the input of `{name}` is {value}; give a finite number")));
        }
        let found = self.inputs.iter().position(|input| input.name == name && input.is_servo == is_servo);
        let position = found.ok_or_else(|| self.unknown_input(name, is_servo))?;
        let (time_s, input) = (self.time_s, &mut self.inputs[position]);
        if input.requested.as_ref().unwrap_or(&input.profile) == &profile {
            return Ok(());
        }
        input.requested = Some(profile.clone());
        let profile = match input.target_rate {
            Some(limit) => profile.rate_limited((time_s, input.profile.at(time_s).0), limit),
            None => profile,
        };
        input.profile.clone_from(&profile);
        let index = input.index;
        if self.failure.is_none() {
            let [value, rate] = values;
            self.actions.push(if is_servo {
                Action::Target(position, value, rate)
            } else {
                Action::Torque(position, value)
            });
        }
        self.step(time_s, |stepper, sink| stepper.set_input(time_s, index, profile, sink), &|| true)
    }

    fn unknown_input(&self, name: &str, is_servo: bool) -> SimulationError {
        let quoted = |is_servo| self.names(is_servo).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        let (input, other) = if is_servo { ("target", "torque") } else { ("torque", "target") };
        let allowed = match quoted(is_servo) {
            names if names.is_empty() => format!("no actuator of the scene has a {input}"),
            names => format!("actuators with a {input}: {names}"),
        };
        SimulationError::Input(match self.names(!is_servo).any(|known| known == name) {
            true => format!("the actuator `{name}` has a {other}, not a {input}; use `set_{other}`, or {allowed}"),
            false => format!("`{name}` is no actuator with a {input}; {allowed}"),
        })
    }

    /// Moves the stepper to a time, and stores its failure.
    fn step(
        &mut self,
        time_s: f64,
        step: impl FnOnce(&mut dyn Stepper, &mut dyn Sink) -> Result<(), Interruption>,
        keep_running: KeepRunning<'_>,
    ) -> Result<(), SimulationError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone().into());
        }
        self.sample.take();
        let mut sink = EventList { events: &mut self.events, keep_running };
        match step(&mut *self.stepper, &mut sink) {
            Ok(()) => {
                self.time_s = time_s;
                Ok(())
            }
            Err(Interruption::Failure(failure)) => {
                self.time_s = failure.time_s;
                self.failure = Some(failure.clone());
                Err(failure.into())
            }
            Err(Interruption::Sink(error)) => unreachable!("a list of events cannot fail: {error}"),
        }
    }
}

/// Inputs of a scene: the actuators of its mechanism.
fn inputs(scene: &Scene) -> Vec<Input> {
    let mechanism = scene.drawn_mechanism();
    let input = |(index, actuator): (usize, &Actuator)| {
        let (is_servo, target_rate) = match &actuator.command {
            Command::Effort(_) => (false, None),
            Command::Servo { target_rate, .. } => (true, *target_rate),
        };
        let (name, profile) = (actuator.name.clone(), actuator.command.profile().clone());
        Input { name, index, is_servo, profile, requested: None, target_rate }
    };
    mechanism.actuators.iter().enumerate().map(input).collect()
}
