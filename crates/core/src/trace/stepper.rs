//! Steppers: a model of a scene whose run is advanced in pieces and recorded.

use super::grid::RecordingOptions;
use super::reading::{Kernel, Start};
use super::recorder::{Recorder, RecorderState, StepObserver};
use super::{Outcome, Sample, Sink, SinkError, Work};
use crate::drive::Profile;
use crate::integrator::{self, Counters, Failure, Hybrid, Integration, Options, SwitchedMethod, Tolerances};
use crate::scene::{Integrator, Method};

/// Reason why a stepper did not advance.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Interruption {
    #[error(transparent)]
    Failure(#[from] Failure),
    #[error(transparent)]
    Sink(#[from] SinkError),
}

/// A model of a scene whose run is advanced in pieces. Between two calls its steps may end later than the time to which
/// it has advanced; see [`Integration`].
pub(crate) trait Stepper: Send {
    /// Emits the events and the sample of the start.
    fn begin(&mut self, sink: &mut dyn Sink) -> Result<(), SinkError>;

    /// Advances to time `t` and emits events and samples of all steps that end before.
    fn advance(&mut self, t: f64, sink: &mut dyn Sink) -> Result<(), Interruption>;

    /// Whether an advance to time `t` takes no step.
    fn is_within_step(&self, _t: f64) -> bool {
        false
    }

    /// Reads the state at time `t`, to which the stepper has advanced.
    fn read(&self, t: f64, sample: &mut Sample);

    /// Ends a step at time `t`, to which the stepper has advanced, and replaces the input of an actuator from then on.
    fn set_input(&mut self, t: f64, index: usize, input: Profile, sink: &mut dyn Sink) -> Result<(), Interruption>;

    /// Ends a step at time `t`, to which the stepper has advanced, and removes contacts between surfaces from then on.
    fn remove_contacts(&mut self, t: f64, contacts: &[usize], sink: &mut dyn Sink) -> Result<(), Interruption>;

    /// Summarises the run.
    fn finish(&mut self, sink: &mut dyn Sink) -> Outcome;

    fn clone_boxed(&self) -> Box<dyn Stepper>;
}

/// A kernel of the analytic model, its integration, and its recorder.
#[derive(Clone)]
pub(crate) struct AnalyticStepper<M: Kernel> {
    kernel: M,
    integration: Integration<M::Layout, M::Mode, SwitchedMethod<M::Layout>>,
    recorder: RecorderState<M>,
    duration_s: f64,
    /// Number of durations at whose end the integration ends a step.
    durations: u32,
}

impl<M: Kernel + Hybrid> AnalyticStepper<M> {
    /// Creates the stepper of a kernel, from its start.
    pub fn new(start: Start<M>, duration_s: f64, recording: RecordingOptions) -> Self {
        let Start { kernel, state, settings, exit } = start;
        let method: SwitchedMethod<M::Layout> = match settings.method {
            Method::Rodas5p => SwitchedMethod::rodas(kernel.layout()),
            Method::RadauIIa5 => integrator::Method::new(kernel.layout()),
        };
        let mode = kernel.mode_at(0.0, &state.q, &state.v);
        let exit = exit.filter(|_| recording.ends_at_exit);
        Self {
            recorder: RecorderState::new(&kernel, (&state, mode), exit, recording),
            integration: Integration::new(method, &kernel, &options(&settings), 0.0, state),
            kernel,
            duration_s,
            durations: 1,
        }
    }

    /// Advances to time `t`. A step ends there if `exact` is true. The observer sees every step and every event.
    pub fn step_to(
        &mut self,
        t: f64,
        exact: bool,
        sink: &mut dyn Sink,
        mut observer: Option<&mut dyn StepObserver<M>>,
    ) -> Result<(), Interruption> {
        loop {
            let end_s = f64::from(self.durations) * self.duration_s;
            let until_s = t.min(end_s);
            let mut recorder = Recorder {
                kernel: &self.kernel,
                sink: &mut *sink,
                state: &mut self.recorder,
                observer: reborrow(&mut observer),
                error: None,
            };
            let result = match exact {
                true => self.integration.advance_exactly(&self.kernel, until_s, end_s, &mut recorder),
                false => self.integration.advance(&self.kernel, until_s, end_s, &mut recorder),
            };
            if let Some(error) = recorder.error.take() {
                return Err(error.into());
            }
            result?;
            if self.recorder.take_suspended() {
                self.exchange(reborrow(&mut observer));
                continue;
            }
            if t <= end_s {
                return Ok(());
            }
            self.durations += 1;
        }
    }

    /// Continues from the end of the last step in other coordinates, if some are much better conditioned there.
    fn exchange(&mut self, observer: Option<&mut dyn StepObserver<M>>) {
        let (state, mode) = (self.integration.state(), self.integration.mode());
        match self.kernel.exchanged(state, mode) {
            None => self.recorder.keep(self.kernel.conditioning(state, mode)),
            Some((kernel, state, mode)) => {
                self.kernel = kernel;
                if let Some(observer) = observer {
                    observer.exchange(&self.kernel, &state, &mode);
                }
                self.recorder.exchange(&state, &mode);
                self.integration.restart(&self.kernel, state, mode);
            }
        }
    }
}

/// The observer for a shorter time.
fn reborrow<'a, M: Kernel>(observer: &'a mut Option<&mut dyn StepObserver<M>>) -> Option<&'a mut dyn StepObserver<M>> {
    match observer {
        Some(observer) => Some(*observer),
        None => None,
    }
}

impl<M: Kernel + Hybrid> Stepper for AnalyticStepper<M> {
    fn begin(&mut self, sink: &mut dyn Sink) -> Result<(), SinkError> {
        Recorder { kernel: &self.kernel, sink, state: &mut self.recorder, observer: None, error: None }.begin()
    }

    fn advance(&mut self, t: f64, sink: &mut dyn Sink) -> Result<(), Interruption> {
        self.step_to(t, false, sink, None)
    }

    fn is_within_step(&self, t: f64) -> bool {
        self.integration.is_within_step(t)
    }

    fn read(&self, t: f64, sample: &mut Sample) {
        let Self { kernel, integration, recorder, .. } = self;
        let read_pending = integration
            .read_pending(kernel, |step, mode, tools| recorder.read_within(kernel, t, (step, mode, tools), sample));
        if read_pending.is_none() {
            recorder.read_at(kernel, t, (integration.state(), integration.mode()), sample);
        }
    }

    fn set_input(&mut self, t: f64, index: usize, input: Profile, sink: &mut dyn Sink) -> Result<(), Interruption> {
        self.step_to(t, true, sink, None)?;
        let (mut state, mut mode) = (self.integration.state().clone(), self.integration.mode().clone());
        self.kernel.set_input(index, input, t, (&mut state, &mut mode));
        self.integration.restart(&self.kernel, state, mode);
        Ok(())
    }

    fn remove_contacts(&mut self, t: f64, contacts: &[usize], sink: &mut dyn Sink) -> Result<(), Interruption> {
        self.step_to(t, true, sink, None)?;
        let (mut state, mut mode) = (self.integration.state().clone(), self.integration.mode().clone());
        self.kernel.remove_contacts(contacts, (&mut state, &mut mode));
        self.recorder.replace(&state, &mode);
        self.integration.restart(&self.kernel, state, mode);
        Ok(())
    }

    fn finish(&mut self, sink: &mut dyn Sink) -> Outcome {
        let work = work(self.integration.counters());
        let mut recorder =
            Recorder { kernel: &self.kernel, sink, state: &mut self.recorder, observer: None, error: None };
        recorder.finish(self.integration.state(), work)
    }

    fn clone_boxed(&self) -> Box<dyn Stepper> {
        Box::new(self.clone())
    }
}

fn options(settings: &Integrator) -> Options {
    Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    }
}

fn work(counters: &Counters) -> Work {
    Work {
        steps: counters.steps,
        rejected: counters.rejected,
        rhs_evaluations: counters.rhs,
        jacobian_evaluations: counters.jacobians,
        events: counters.events,
        ..Work::default()
    }
}
