//! Runs with their derivatives: of the last sample, of samples at given times, and of events.

use super::neighbours::{Exchange, TangentParameter};
use super::tangent::{EventDerivatives, SampleDerivatives, Tangent};
use crate::analytic::ContactState;
use crate::integrator::{Hybrid, Observer, State, Step, StepTools};
use crate::scene::Scene;
use crate::trace::{
    AnalyticStepper, Event, EventKind, Interruption, Kernel, KernelUser, Outcome, RecordingOptions, RequiredData,
    RunError, Sample, Schema, Sink, SinkError, Span, Start, StepObserver, Stepper, check_supported, has_sampled_servos,
    with_kernel,
};

/// Fraction of the step before below which a step is too short for rates.
const SHORT_STEP: f64 = 1e-4;

/// Derivatives of a run by all parameters. An error is the reason why there is no derivative.
pub(super) struct TangentRun {
    pub outcome: Outcome,
    /// Derivatives of the numbers of the last sample.
    pub end: Vec<Result<Vec<f64>, String>>,
    /// Samples at the requested times, with their derivatives.
    pub at_times: Vec<SampleDerivatives>,
    /// Contact events after the start.
    pub events: Vec<TangentEvent>,
}

/// Derivatives of a contact event.
pub(super) struct TangentEvent {
    pub event: Event,
    /// Sample just before the event.
    pub sample: Sample,
    /// Derivatives of the time of the event and of the numbers of its sample, with respect to each parameter.
    pub derivatives: EventDerivatives,
}

/// Simulates a scene with the analytic model, with derivatives by parameters at its events, at `times` and at its end.
///
/// # Errors
/// Returns an error if the run does not complete.
pub(super) fn run_tangent(
    scene: &Scene,
    parameters: &[TangentParameter<'_>],
    times: &[f64],
    sink: &mut dyn Sink,
) -> Result<TangentRun, RunError> {
    check_supported(scene)?;
    if scene.mechanism.as_ref().is_some_and(has_sampled_servos) {
        let reason =
            "derivatives are not computed for servos with a `rate`, whose effort changes in steps: remove the rate";
        return Err(RunError::rejected(reason.to_string(), Outcome::default()));
    }
    with_kernel(scene, TangentRunner { scene, parameters, times, sink })?
}

struct TangentRunner<'a> {
    scene: &'a Scene,
    parameters: &'a [TangentParameter<'a>],
    times: &'a [f64],
    sink: &'a mut dyn Sink,
}

impl KernelUser for TangentRunner<'_> {
    type Output = Result<TangentRun, RunError>;

    fn use_kernel<M: Kernel + Hybrid>(self, start: Start<M>) -> Self::Output {
        let schema = Schema::from_scene(self.scene);
        let counts = schema.counts();
        let recording = RecordingOptions {
            span: Span { end_s: self.scene.duration_s, ..Span::UNSAMPLED },
            ..RecordingOptions::of_run(self.scene, self.sink)
        };
        let times: Vec<f64> = self.times.iter().copied().chain([self.scene.duration_s]).collect();
        let mut tangent = Tangent::new(&start, &schema, self.parameters, &times);
        let mut stepper = AnalyticStepper::new(start, self.scene.duration_s, recording);
        let mut sink = EventCollector { sink: self.sink, events: Vec::new() };
        Stepper::begin(&mut stepper, &mut sink)?;
        let at_start = sink.events.len();
        let result = stepper.step_to(self.scene.duration_s, false, &mut sink, Some(&mut tangent));
        if let Err(Interruption::Sink(error)) = result {
            return Err(error.into());
        }
        let outcome = Stepper::finish(&mut stepper, &mut sink);
        if let Err(Interruption::Failure(failure)) = result
            && outcome.ejected_s.is_none()
        {
            return Err(RunError::Simulation { failure, partial_outcome: Box::new(outcome) });
        }
        let end = match (tangent.at_times.len() == times.len()).then(|| tangent.at_times.pop()).flatten() {
            Some((_, end)) => end,
            None => {
                let end_s = outcome.last.time_s;
                let reason = format!("the run ends at {end_s} s, where the object leaves the reach of the fingers");
                vec![Err(reason); self.parameters.len()]
            }
        };
        let mut derivatives = tangent.events.into_iter();
        let none = || vec![Err("slip and stick events have no derivatives".to_string()); self.parameters.len()];
        let of_event = |event: Event| {
            let has_derivatives = !matches!(event.kind, EventKind::Slips | EventKind::Sticks);
            let found = if has_derivatives { derivatives.next() } else { None };
            let (sample, derivatives) = found.unwrap_or_else(|| (Sample::new(event.time_s, counts), none()));
            TangentEvent { event, sample, derivatives }
        };
        let events = sink.events.drain(..).skip(at_start).map(of_event).collect();
        Ok(TangentRun { outcome, end, at_times: tangent.at_times, events })
    }
}

/// Passes a run on, and stores its events.
struct EventCollector<'a> {
    sink: &'a mut dyn Sink,
    events: Vec<Event>,
}

impl Sink for EventCollector<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        self.sink.event(event)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sink.extreme(sample)
    }

    fn required_data(&self) -> RequiredData {
        self.sink.required_data()
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}

impl<M: Kernel + Hybrid> Observer<M::Layout, M::Mode> for Tangent<'_, M> {
    fn step(&mut self, step: &Step<M::Layout>, mode: &M::Mode, tools: &mut dyn StepTools<M::Layout>) -> bool {
        self.enter(step, mode);
        let rates = Self::rates(&self.kernel, (step.t0, step.start, mode));
        self.acceleration_scale =
            rates.a.as_ref().iter().fold(self.acceleration_scale, |largest, a| largest.max(a.abs()));
        let is_read = self.times.get(self.at_times.len()).is_some_and(|time_s| *time_s <= step.t1);
        for index in 0..self.neighbours.len() {
            let shift = if is_read { 0.0 } else { self.shift_of_step(index, step) };
            self.shift(index, (step.start, &rates), shift);
        }
        let mut from = 0.0;
        while let Some(time_s) = self.times.get(self.at_times.len()).filter(|time_s| **time_s <= step.t1) {
            let to = ((time_s - step.t0) / step.h).clamp(from, 1.0);
            if to > from {
                self.advance([from, to], (step, mode), tools, (0, f64::INFINITY));
            }
            let state = if to < 1.0 { tools.resolve(to).clone() } else { step.end.clone() };
            (self.time_s, self.state, from) = (*time_s, state.clone(), to);
            self.find_rates((step, mode), to, tools);
            let sample = self.sample((*time_s, &state, mode));
            self.at_times.push((sample, self.sample_derivatives()));
        }
        if from < 1.0 {
            self.advance([from, 1.0], (step, mode), tools, (0, f64::INFINITY));
        }
        (self.time_s, self.state) = (step.t1, step.end.clone());
        // Rounding in a step between events at nearly the same time exceeds its changes.
        let is_short = step.h < SHORT_STEP * self.step_s;
        if !is_short {
            let is_end_read = self.at_times.last().is_some_and(|(sample, _)| sample.time_s == step.t1);
            self.rates = self.rates.take().filter(|_| is_end_read);
            self.step_s = step.h;
        }
        let events = self.events((step.end, mode)).functions;
        let is_at_event = |index: usize| events[index].value <= self.kernel.event_tolerance(index, mode);
        if self.rates.is_none() && (0..self.contacts).any(is_at_event) {
            self.find_rates((step, mode), 1.0, tools);
        }
        // Counts the turns of joints.
        let mut sample = Sample::new(step.t1, self.counts);
        self.kernel.read((step.end, mode), &self.start_energy, RequiredData::NONE, &mut self.history, &mut sample);
        for (index, deepest) in self.deepest.iter_mut().enumerate() {
            let depth = match mode[index] {
                ContactState::Free => continue,
                _ => -self.kernel.contact(step.end, index, mode).gap_m,
            };
            *deepest = deepest.max(depth);
        }
        if step.t1 == self.discontinuities_s[1] {
            let before = (step.t1.next_down(), step.end, mode);
            self.before_discontinuity = Some(Self::rates(&self.kernel, before));
        }
        true
    }

    fn event(&mut self, t: f64, state: &State<M::Layout>, index: usize, mode: &M::Mode) {
        self.pass_discontinuity(&self.mode.clone());
        let sample = self.sample((t, state, &self.mode));
        let derivatives = self.pass_event((t, state), index, mode);
        self.events.push((sample, derivatives));
        self.mode.clone_from(mode);
    }
}

impl<M: Kernel + Hybrid> StepObserver<M> for Tangent<'_, M> {
    fn exchange(&mut self, kernel: &M, state: &State<M::Layout>, mode: &M::Mode) {
        self.pass_discontinuity(&self.mode.clone());
        for (index, column) in self.columns.iter_mut().enumerate() {
            if let Ok(tangent) = column {
                let (before, tangent) = (self.state.clone(), tangent.clone());
                let exchange = Exchange { kernel: kernel.clone(), state: before, mode: self.mode.clone(), tangent };
                *column = self.neighbours[index].exchange(exchange, self.counts);
            }
            self.scales[index].iter_mut().for_each(|scale| scale.as_mut().fill(0.0));
        }
        (self.kernel, self.state, self.mode) = (kernel.clone(), state.clone(), mode.clone());
    }
}
