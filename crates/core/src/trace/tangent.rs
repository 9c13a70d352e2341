//! Tangent-linear integration: derivatives of a run of the analytic model with respect to parameters of its scene.
//!
//! The derivative S = ∂y/∂p of a state at a fixed time satisfies Ṡ = J S + ∂f/∂p. It is integrated along the steps of the
//! run by Radau IIA of order 5, with the exact Jacobians J of the kernel; steps are halved until the error of S is small.
//! At an event g = 0 its time changes by dt/dp = −(∂g/∂y S + ∂g/∂p)/ġ, and S jumps by (f⁻ − f⁺) dt/dp.
//!
//! Instead of S, the integration uses the derivative S + τ f at a time that moves by τ, with τ = dt/dp of the last event. It
//! is continuous at the event, satisfies the same equation (with τ ∂f/∂t), and contacts have nearly the same depth after a
//! touch-down that moves. τ is 0 in steps to the times at which derivatives are read.
//!
//! ∂f/∂p is the difference quotient of f along the tangent, between (y + h S, p + h) and (y − h S, p − h), minus J S. At
//! fixed y a stiff contact would be lost or deepened by the change of p alone; along the tangent its depth hardly
//! changes, so that h can be large and rounding is small.

use std::any::Any;
use std::cell::OnceCell;

use super::analytic::with_kernel;
use super::grid::{RecordingOptions, Span};
use super::reading::{Kernel, KernelUser, Start};
use super::sampled::has_sampled_servos;
use super::schema::{ContactSample, Counts, Schema};
use super::stepper::{AnalyticStepper, Interruption};
use super::{Energy, Event, EventKind, Outcome, RequiredData, RunError, Sample, Sink};
use crate::analytic::ContactState;
use crate::integrator::{
    ErrorWeight, EventSet, Hybrid, Linearised, Observer, Rates, State, Step, StepTools, radau5_tableau,
};
use crate::numeric::array_from;
use crate::scene::Scene;

/// A parameter of a scene.
#[derive(Clone, Copy)]
pub struct TangentParameter<'a> {
    /// Returns the scene at a value of the parameter.
    pub scene_at: &'a dyn Fn(f64) -> Result<Scene, String>,
    pub value: f64,
    /// Largest change of the value in difference quotients.
    pub step: f64,
}

/// Derivatives of a run by all parameters. An error is the reason why there is no derivative.
pub struct TangentRun {
    pub outcome: Outcome,
    /// Derivatives of the numbers of the last sample.
    pub end: Vec<Result<Vec<f64>, String>>,
    /// Samples at the requested times, with their derivatives.
    pub at_times: Vec<SampleDerivatives>,
    /// Contact events after the start.
    pub events: Vec<TangentEvent>,
}

/// Derivatives of a contact event.
pub struct TangentEvent {
    pub event: Event,
    /// Sample just before the event.
    pub sample: Sample,
    /// Derivatives of its time, and of the numbers of its sample, by each parameter.
    pub derivatives: EventDerivatives,
}

/// A sample with the derivatives of its numbers by each parameter.
pub type SampleDerivatives = (Sample, Vec<Result<Vec<f64>, String>>);

/// Derivatives of the time and of the numbers of the sample of an event by each parameter.
pub type EventDerivatives = Vec<Result<(f64, Vec<f64>), String>>;

/// Simulates a scene with the analytic model, with derivatives by parameters at its events, at `times` and at its end.
///
/// # Errors
/// Returns an error if the run does not complete.
pub fn run_tangent(
    scene: &Scene,
    parameters: &[TangentParameter<'_>],
    times: &[f64],
    sink: &mut dyn Sink,
) -> Result<TangentRun, RunError> {
    super::check_supported(scene)?;
    if scene.mechanism.as_ref().is_some_and(has_sampled_servos) {
        let reason =
            "derivatives are not computed for servos with a `rate`, whose effort changes in steps: remove the rate";
        return Err(RunError::rejected(reason.to_string(), Outcome::default()));
    }
    with_kernel(scene, TangentRunner { scene, parameters, times, sink })?
}

/// Takes the kernel of a scene in whatever type it has.
struct Erase;

impl KernelUser for Erase {
    type Output = Box<dyn Any>;

    fn use_kernel<M, const N: usize, const Z: usize>(self, start: Start<M, N, Z>) -> Box<dyn Any>
    where
        M: Kernel<N, Z> + Hybrid<N, Z>,
    {
        Box::new((start.kernel, start.state))
    }
}

struct TangentRunner<'a> {
    scene: &'a Scene,
    parameters: &'a [TangentParameter<'a>],
    times: &'a [f64],
    sink: &'a mut dyn Sink,
}

impl KernelUser for TangentRunner<'_> {
    type Output = Result<TangentRun, RunError>;

    fn use_kernel<M, const N: usize, const Z: usize>(self, start: Start<M, N, Z>) -> Self::Output
    where
        M: Kernel<N, Z> + Hybrid<N, Z>,
    {
        let schema = Schema::from_scene(self.scene);
        let counts = schema.counts();
        let recording = RecordingOptions {
            span: Span { end_s: self.scene.duration_s, ..Span::UNSAMPLED },
            ..RecordingOptions::of_run(self.scene, self.sink)
        };
        let times: Vec<f64> = self.times.iter().copied().chain([self.scene.duration_s]).collect();
        let mut tangent = Tangent::<M, N, Z>::new(&start, &schema, self.parameters, &times);
        let mut stepper = AnalyticStepper::<M, N, Z>::new(start, self.scene.duration_s, recording);
        let mut sink = EventCollector { sink: self.sink, events: Vec::new() };
        super::stepper::Stepper::begin(&mut stepper, &mut sink)?;
        let at_start = sink.events.len();
        let result = stepper.step_to(self.scene.duration_s, false, &mut sink, Some(&mut tangent));
        if let Err(Interruption::Sink(error)) = result {
            return Err(error.into());
        }
        let outcome = super::stepper::Stepper::finish(&mut stepper, &mut sink);
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
    fn sample(&mut self, sample: &Sample) -> Result<(), super::SinkError> {
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), super::SinkError> {
        self.events.push(*event);
        self.sink.event(event)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), super::SinkError> {
        self.sink.extreme(sample)
    }

    fn required_data(&self) -> RequiredData {
        self.sink.required_data()
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}

/// The kernel at one value of a parameter, and its start.
struct Neighbour<M, const N: usize, const Z: usize> {
    kernel: M,
    start: State<N, Z>,
    start_energy: Energy,
}

/// Kernels at p ± h and p ± h/2, with the exact half differences of p.
struct Level<M, const N: usize, const Z: usize> {
    pairs: [[Neighbour<M, N, Z>; 2]; 2],
    h: [f64; 2],
}

/// A parameter with its neighbours at decreasing steps, built when they are first used.
struct Neighbours<'a, M: Kernel<N, Z>, const N: usize, const Z: usize> {
    parameter: TangentParameter<'a>,
    /// Mode at the start, which neighbours must share.
    start_mode: M::Mode,
    levels: [OnceCell<Result<Level<M, N, Z>, String>>; LEVELS],
    /// Derivatives of the last and the next time at which the right-hand side is discontinuous.
    discontinuities: [f64; 2],
}

/// Number of steps of difference quotients; each is a tenth of the one before.
const LEVELS: usize = 6;
/// Largest relative change of the depth of an active contact in a difference quotient.
const MAX_DEPTH_CHANGE: f64 = 0.1;
/// Depth at which a contact is released, as a fraction of its largest one, below which it is released by separation.
const MIN_RELEASE_DEPTH: f64 = 1e-4;
/// Relative difference of two difference quotients at which their extrapolation is accurate.
const QUOTIENT_TOLERANCE: f64 = 1e-6;
/// Ratio of the errors of two levels up to which the larger step is taken, which has the smaller rounding errors.
const LEVEL_MARGIN: f64 = 10.0;
/// Allowed difference of one step and two half steps, relative to the largest derivative so far. The error of the half
/// steps is a part of 1/31 of it.
const TANGENT_TOLERANCE: f64 = 1e-8;
/// Iterations of a step.
const ITERATIONS: usize = 2;
/// Weight of the relative error of the depth or slip of a contact. The depth is a small difference of coordinates.
const CONTACT_WEIGHT: f64 = 0.1;
/// Largest number of times that a step is halved.
const MAX_HALVINGS: u32 = 12;
/// A step is halved at least this often before its error can count as rounding.
const MIN_HALVINGS: u32 = 3;
/// Ratio of the errors of a half and of the whole above which the error is rounding; at a kink it is 1/2.
const MIN_DECREASE: f64 = 0.8;
/// Backward difference of order 4 for the rate at the end of a step, and its spacing as a fraction of the step.
const BACKWARD_WEIGHTS: [f64; 5] = [25.0 / 12.0, -4.0, 3.0, -4.0 / 3.0, 0.25];
const BACKWARD_STEP: f64 = 0.1;
/// Relative change of a parameter over which the time of an event must be linear in it; otherwise the event grazes.
const LINEAR_RANGE: f64 = 1e-6;
/// Fraction of the step before below which a step is too short for rates.
const SHORT_STEP: f64 = 1e-4;
/// Jump of the accelerations that counts as a discontinuity, relative to the largest acceleration so far.
const MIN_JUMP: f64 = 1e-6;

/// y + h d.
fn along<const N: usize, const Z: usize>(y: &State<N, Z>, h: f64, d: &State<N, Z>) -> State<N, Z> {
    State {
        q: array_from(|i| y.q[i] + h * d.q[i]),
        v: array_from(|i| y.v[i] + h * d.v[i]),
        z: array_from(|i| y.z[i] + h * d.z[i]),
    }
}

/// Extrapolates two difference quotients; the second one has half the step.
fn extrapolate([full, half]: [f64; 2]) -> f64 {
    half + (half - full) / 3.0
}

/// The first level whose quotients are about as accurate as any, from the relative differences of both quotients of each
/// level. Two quotients that are rounding errors may agree by chance, but their errors grow tenfold from level to level.
fn best_level(errors: &[f64; LEVELS]) -> usize {
    let estimates: [f64; LEVELS] = array_from(|level| {
        let next = errors.get(level + 1).filter(|error| error.is_finite());
        errors[level].max(0.1 * next.copied().unwrap_or(0.0))
    });
    let smallest = estimates.iter().copied().fold(f64::INFINITY, f64::min);
    estimates.iter().position(|estimate| *estimate <= LEVEL_MARGIN * smallest).unwrap_or(0)
}

/// A tangent of the family of runs, along which difference quotients are taken.
struct Direction<const N: usize, const Z: usize> {
    /// Derivatives of the state at times that move by `dt`.
    tangent: State<N, Z>,
    dt: f64,
    /// Level of the step.
    level: usize,
}

/// Derivatives of a state; the reason why there are none.
type Column<const N: usize, const Z: usize> = Result<State<N, Z>, String>;

/// State of the tangent-linear integration between two steps.
struct Tangent<'a, M: Kernel<N, Z>, const N: usize, const Z: usize> {
    kernel: M,
    schema: &'a Schema,
    counts: Counts,
    /// Number of contacts of the model; those without names follow those of a sample.
    contacts: usize,
    start_energy: Energy,
    history: M::History,
    neighbours: Vec<Neighbours<'a, M, N, Z>>,
    /// Derivatives of the state at a time that moves by `shifts`.
    columns: Vec<Column<N, Z>>,
    shifts: Vec<f64>,
    /// Largest magnitudes of the derivatives of each coordinate and rate so far.
    scales: Vec<[[f64; N]; 2]>,
    mode: M::Mode,
    /// Time and state at the end of the last step, and its size.
    time_s: f64,
    state: State<N, Z>,
    step_s: f64,
    /// Rates at the present time, if they may be needed; see [`Tangent::rates_before`].
    rates: Option<(Vec<f64>, Vec<f64>)>,
    /// Largest depth of each contact since its touch-down.
    deepest: Vec<f64>,
    /// Times before and after which all neighbours are in the same piece of their functions of time.
    bounds_s: [f64; 2],
    /// Last and next discontinuity of the right-hand side in time.
    discontinuities_s: [f64; 2],
    /// Rates just before a discontinuity at the present time.
    before_discontinuity: Option<Rates<N, Z>>,
    /// Largest acceleration of a coordinate so far.
    acceleration_scale: f64,
    times: &'a [f64],
    at_times: Vec<SampleDerivatives>,
    events: Vec<(Sample, EventDerivatives)>,
}

/// A state with its time and mode.
type Instant<'a, X, const N: usize, const Z: usize> = (f64, &'a State<N, Z>, &'a X);

impl<M: Kernel<N, Z>, const N: usize, const Z: usize> Neighbours<'_, M, N, Z> {
    fn level(&self, index: usize, counts: Counts) -> Result<&Level<M, N, Z>, String>
    where
        M: Hybrid<N, Z>,
    {
        let built = self.levels[index].get_or_init(|| {
            let TangentParameter { scene_at, value, step } = self.parameter;
            let step = step * crate::numeric::elementary::powi(0.1, index as i32);
            let neighbour = |value: f64| -> Result<Neighbour<M, N, Z>, String> {
                let other = || format!("the structure of the model changes at a value of {value}");
                let erased = with_kernel(&scene_at(value)?, Erase).map_err(|error| error.to_string())?;
                let built = erased.downcast::<(M, State<N, Z>)>().map_err(|_| other())?;
                let (kernel, start) = *built;
                let start_mode = kernel.mode_at(0.0, &start.q, &start.v);
                if (0..counts.contacts)
                    .map(|contact| kernel.contact_index(contact))
                    .any(|index| start_mode[index] != self.start_mode[index])
                {
                    return Err(format!("a contact opens or closes at the start for a value of {value}"));
                }
                let mut sample = Sample::new(0.0, counts);
                let (none, mut history) = (Energy::default(), M::History::default());
                kernel.read((&start, &start_mode), &none, RequiredData::EVALUATION, &mut history, &mut sample);
                Ok(Neighbour { kernel, start, start_energy: sample.energy() })
            };
            let pair = |h: f64| -> Result<_, String> {
                let [below, above] = [value - h, value + h];
                Ok(([neighbour(below)?, neighbour(above)?], 0.5 * (above - below)))
            };
            let ((full, h), (half, half_h)) = (pair(step)?, pair(0.5 * step)?);
            Ok(Level { pairs: [full, half], h: [h, half_h] })
        });
        built.as_ref().map_err(Clone::clone)
    }
}

impl<'a, M: Kernel<N, Z> + Hybrid<N, Z>, const N: usize, const Z: usize> Tangent<'a, M, N, Z> {
    fn new(
        start: &Start<M, N, Z>,
        schema: &'a Schema,
        parameters: &'a [TangentParameter<'a>],
        times: &'a [f64],
    ) -> Self {
        let (kernel, state, counts) = (start.kernel.clone(), start.state, schema.counts());
        let contacts = kernel.contact_count();
        let mode = kernel.mode_at(0.0, &state.q, &state.v);
        let (mut sample, mut history) = (Sample::new(0.0, counts), M::History::default());
        kernel.read((&state, &mode), &Energy::default(), RequiredData::EVALUATION, &mut history, &mut sample);
        let neighbours: Vec<Neighbours<'a, M, N, Z>> = parameters
            .iter()
            .map(|parameter| Neighbours {
                parameter: *parameter,
                start_mode: mode,
                levels: [const { OnceCell::new() }; LEVELS],
                discontinuities: [0.0; 2],
            })
            .collect();
        let column = |neighbours: &Neighbours<'a, M, N, Z>| -> Column<N, Z> {
            let Level { pairs, h } = neighbours.level(0, counts)?;
            let quotient = |of: &dyn Fn(&State<N, Z>) -> f64| {
                extrapolate([0, 1].map(|k| (of(&pairs[k][1].start) - of(&pairs[k][0].start)) / (2.0 * h[k])))
            };
            Ok(State {
                q: array_from(|i| quotient(&|state| state.q[i])),
                v: array_from(|i| quotient(&|state| state.v[i])),
                z: [0.0; Z],
            })
        };
        let columns = neighbours.iter().map(column).collect();
        let mut tangent = Self {
            start_energy: sample.energy(),
            scales: vec![[[0.0; N]; 2]; neighbours.len()],
            shifts: vec![0.0; neighbours.len()],
            kernel,
            schema,
            counts,
            contacts,
            history,
            neighbours,
            columns,
            mode,
            time_s: 0.0,
            state,
            step_s: 0.0,
            rates: None,
            deepest: vec![0.0; contacts],
            bounds_s: [f64::NEG_INFINITY, f64::INFINITY],
            discontinuities_s: [f64::NEG_INFINITY; 2],
            before_discontinuity: None,
            acceleration_scale: 0.0,
            times,
            at_times: Vec::new(),
            events: Vec::new(),
        };
        tangent.find_discontinuity(0.0);
        tangent
    }

    fn contact_name(&self, contact: usize) -> &str {
        let contacts = &self.schema.contacts;
        let of_sample = self.kernel.sample_contact(contact, contacts.len());
        of_sample.map_or("of a tendon", |contact| &contacts[contact].name)
    }

    /// Ends all derivatives.
    fn refuse(&mut self, reason: &str) {
        for column in self.columns.iter_mut().filter(|column| column.is_ok()) {
            *column = Err(reason.to_string());
        }
    }

    /// Finds the next discontinuity of the right-hand side after time `t`, and its derivatives.
    fn find_discontinuity(&mut self, t: f64) {
        let after = t.max(self.bounds_s[0]);
        let next = self.kernel.next_discontinuity(t);
        self.discontinuities_s = [self.discontinuities_s[1], next];
        let mut before = next;
        for neighbours in &mut self.neighbours {
            let level = neighbours.level(0, self.counts);
            let moved = level.map_or(0.0, |Level { pairs, h }| {
                let times = pairs[0].each_ref().map(|neighbour| neighbour.kernel.next_discontinuity(after));
                before = before.min(times[0]).min(times[1]);
                (times[1] - times[0]) / (2.0 * h[0])
            });
            let moved = if moved.is_finite() { moved } else { 0.0 };
            neighbours.discontinuities = [neighbours.discontinuities[1], moved];
        }
        self.bounds_s[1] = before.next_down();
    }

    #[inline(never)]
    fn rates(kernel: &M, (t, state, mode): Instant<'_, M::Mode, N, Z>) -> Rates<N, Z> {
        kernel.rates(t, &state.q, &state.v, mode)
    }

    #[inline(never)]
    fn linearise(kernel: &M, (t, state, mode): Instant<'_, M::Mode, N, Z>) -> Linearised<N, Z> {
        kernel.linearise(t, &state.q, &state.v, mode)
    }

    /// Change of a time that stays in the same piece of the functions of time.
    fn room_s(&self, t: f64) -> f64 {
        (t - self.bounds_s[0]).min(self.bounds_s[1] - t)
    }

    /// All event functions of a state.
    fn events(&self, (state, mode): (&State<N, Z>, &M::Mode)) -> EventSet<N> {
        let mut events = EventSet::new(self.kernel.event_count());
        self.kernel.eval_events(&state.q, &state.v, mode, &mut events);
        events
    }

    fn contact(&self, (_, state, mode): Instant<'_, M::Mode, N, Z>, contact: usize) -> ContactSample {
        self.kernel.contact(state, contact, mode)
    }

    /// Difference quotients at the full and the half step of a level.
    fn quotients<const R: usize>(
        level: &Level<M, N, Z>,
        (t, state): (f64, &State<N, Z>),
        (direction, dt): (&State<N, Z>, f64),
        f: impl Fn(&M, f64, &State<N, Z>) -> [f64; R],
    ) -> [[f64; R]; 2] {
        [0, 1].map(|k| {
            let ([below, above], h) = (&level.pairs[k], level.h[k]);
            let below = f(&below.kernel, t - h * dt, &along(state, -h, direction));
            let above = f(&above.kernel, t + h * dt, &along(state, h, direction));
            array_from(|i| (above[i] - below[i]) / (2.0 * h))
        })
    }

    /// Returns the total derivatives of accelerations and quadrature rates for derivatives of the state at a moving time, and
    /// the tangent along which difference quotients are taken there.
    fn differentiate(
        &self,
        neighbours: &Neighbours<'a, M, N, Z>,
        (t, state, mode): Instant<'_, M::Mode, N, Z>,
        lin: &Linearised<N, Z>,
        moving: (&State<N, Z>, f64),
    ) -> Result<(Rates<N, Z>, Direction<N, Z>), String> {
        let (mut direction, change) = self.direction((t, state, mode), &lin.rates, neighbours, moving)?;
        let none = Rates { a: [0.0; N], g: [0.0; Z] };
        let (mut found, mut errors) = ([none; LEVELS], [f64::INFINITY; LEVELS]);
        for index in 0..LEVELS {
            let level = neighbours.level(index, self.counts)?;
            let is_too_large = change * level.h[0] > MAX_DEPTH_CHANGE && index + 1 < LEVELS;
            if is_too_large || level.h[0] * (direction.dt - moving.1).abs() > self.room_s(t) {
                continue;
            }
            let [full, half] = [0, 1].map(|k| {
                let rates = |side: usize, h: f64| {
                    let Direction { tangent, dt, .. } = &direction;
                    Self::rates(&level.pairs[k][side].kernel, (t + h * dt, &along(state, h, tangent), mode))
                };
                let (h, [below, above]) = (level.h[k], [rates(0, -level.h[k]), rates(1, level.h[k])]);
                let quotient = |above: f64, below: f64| (above - below) / (2.0 * h);
                Rates::<N, Z> {
                    a: array_from(|i| quotient(above.a[i], below.a[i])),
                    g: array_from(|i| quotient(above.g[i], below.g[i])),
                }
            });
            let largest = |of: &dyn Fn(usize) -> f64| (0..N).fold(0.0, |largest: f64, i| largest.max(of(i).abs()));
            errors[index] = largest(&|i| half.a[i] - full.a[i]) / largest(&|i| half.a[i]).max(f64::MIN_POSITIVE);
            found[index] = Rates {
                a: array_from(|i| extrapolate([full.a[i], half.a[i]])),
                g: array_from(|i| extrapolate([full.g[i], half.g[i]])),
            };
            if errors[index] <= QUOTIENT_TOLERANCE {
                break;
            }
        }
        direction.level = best_level(&errors);
        let mut found = found[direction.level];
        let dt = direction.dt - moving.1;
        if dt != 0.0 {
            for i in 0..N {
                let rate = product(&lin.a_q[i], &state.v) + product(&lin.a_v[i], &lin.rates.a) + lin.a_t[i];
                found.a[i] -= dt * rate;
            }
            for i in 0..Z {
                let rate = product(&lin.g_q[i], &state.v) + product(&lin.g_v[i], &lin.rates.a) + lin.g_t[i];
                found.g[i] -= dt * rate;
            }
        }
        Ok((found, direction))
    }

    /// Returns a tangent along which the depths of active contacts change little, and their largest relative change per
    /// change of the parameter: the given derivatives, or those at the time at which a contact has the same depth.
    fn direction(
        &self,
        (t, state, mode): Instant<'_, M::Mode, N, Z>,
        rates: &Rates<N, Z>,
        neighbours: &Neighbours<'a, M, N, Z>,
        (column, shift): (&State<N, Z>, f64),
    ) -> Result<(Direction<N, Z>, f64), String> {
        let level = neighbours.level(0, self.counts)?;
        let contacts = (0..self.contacts).filter(|contact| mode[*contact].has_force()).map(|contact| {
            let reading = self.contact((t, state, mode), contact);
            let gap = |kernel: &M, _: f64, state: &State<N, Z>| [kernel.contact(state, contact, mode).gap_m];
            let [_, [change]] = Self::quotients(level, (t, state), (column, shift), gap);
            [-reading.gap_m, -reading.gap_rate_m_s, -change]
        });
        let contacts: Vec<[f64; 3]> = contacts.collect();
        let change_of = |[depth, rate, change]: &[f64; 3], dt: f64| ((change + rate * dt) / depth).abs();
        let largest = |dt: f64| contacts.iter().map(|contact| change_of(contact, dt)).fold(0.0, f64::max);
        let worst = contacts.iter().max_by(|a, b| change_of(a, 0.0).total_cmp(&change_of(b, 0.0)));
        let aligned = worst.map_or(0.0, |[_, rate, change]| -change / rate);
        let is_better = largest(aligned) < 0.5 * largest(0.0);
        let smallest_h = level.h[0] * crate::numeric::elementary::powi(0.1, LEVELS as i32 - 1);
        let is_inside = smallest_h * aligned.abs() <= self.room_s(t);
        let dt = if is_better && is_inside && largest(0.0) * level.h[0] > MAX_DEPTH_CHANGE { aligned } else { 0.0 };
        let flow = State { q: state.v, v: rates.a, z: rates.g };
        Ok((Direction { tangent: along(column, dt, &flow), dt: shift + dt, level: 0 }, largest(dt)))
    }

    /// Derivatives at `to` (a fraction of the step) from those at `from`, by one step of Radau IIA. Not inlined, so that the
    /// recursion of its caller has small frames.
    #[inline(never)]
    fn collocate(
        &self,
        columns: &[Column<N, Z>],
        [from, to]: [f64; 2],
        (step, mode): (&Step<N, Z>, &M::Mode),
        tools: &mut dyn StepTools<N, Z>,
    ) -> (Vec<Column<N, Z>>, State<N, Z>) {
        let (n, h) = (self.kernel.coordinate_count(), (to - from) * step.h);
        let (c, a) = radau5_tableau();
        let mut node = |c: f64| {
            let theta = from + c * (to - from);
            let state = if theta < 1.0 { tools.resolve(theta) } else { *step.end };
            let t = (step.t0 + theta * step.h).max(self.bounds_s[0]).min(self.bounds_s[1]);
            (t, state, Self::linearise(&self.kernel, (t, &state, mode)))
        };
        let nodes: Vec<(f64, State<N, Z>, Linearised<N, Z>)> = c.into_iter().map(&mut node).collect();
        // V_i = V₀ + h Σ a_ij (A_v V_j + A_q Q_j + ∂a/∂p), Q_j = Q₀ + h Σ a_jk V_k.
        let size = 3 * n;
        let mut matrix = vec![0.0; size * size];
        for (i, j) in (0..9).map(|index| (index / 3, index % 3)) {
            for (row, column) in (0..n * n).map(|index| (index / n, index % n)) {
                let unit = if i == j && row == column { 1.0 } else { 0.0 };
                let stiffness: f64 = (0..3).map(|l| a[i][l] * a[l][j] * nodes[l].2.a_q[row][column]).sum();
                let entry = unit - h * a[i][j] * nodes[j].2.a_v[row][column] - h * h * stiffness;
                matrix[(i * n + row) * size + j * n + column] = entry;
            }
        }
        let order = factor(&mut matrix, size);
        let advance =
            |((neighbours, column), shift): ((&Neighbours<'a, M, N, Z>, &Column<N, Z>), &f64)| -> Column<N, Z> {
                let start = column.as_ref().map_err(Clone::clone)?;
                let mut stages = [*start; 3];
                let mut end = *start;
                for (stage, c) in stages.iter_mut().zip(c) {
                    (0..N).for_each(|i| stage.q[i] += c * h * start.v[i]);
                }
                // Newton's method on a linear system: the second iteration takes difference quotients along the solution.
                for _ in 0..ITERATIONS {
                    let mut loads = [Rates { a: [0.0; N], g: [0.0; Z] }; 3];
                    for ((load, (t, state, lin)), stage) in loads.iter_mut().zip(&nodes).zip(&stages) {
                        (*load, _) = self.differentiate(neighbours, (*t, state, mode), lin, (stage, *shift))?;
                    }
                    let residual = |i: usize, row: usize| {
                        start.v[row] - stages[i].v[row] + h * (0..3).map(|j| a[i][j] * loads[j].a[row]).sum::<f64>()
                    };
                    let mut solution: Vec<f64> = (0..size).map(|index| residual(index / n, index % n)).collect();
                    substitute(&matrix, &order, &mut solution);
                    let corrections: [State<N, Z>; 3] = [0, 1, 2].map(|j| State {
                        q: array_from(|i| match i < n {
                            true => h * (0..3).map(|k| a[j][k] * solution[k * n + i]).sum::<f64>(),
                            false => 0.0,
                        }),
                        v: array_from(|i| if i < n { solution[j * n + i] } else { 0.0 }),
                        z: [0.0; Z],
                    });
                    for (stage, correction) in stages.iter_mut().zip(&corrections) {
                        *stage = along(stage, 1.0, correction);
                    }
                    end = stages[2];
                    for m in 0..Z {
                        let rate = |j: usize| {
                            let (lin, State { q, v, .. }) = (&nodes[j].2, &corrections[j]);
                            loads[j].g[m] + product(&lin.g_q[m], q) + product(&lin.g_v[m], v)
                        };
                        end.z[m] = start.z[m] + h * (0..3).map(|j| a[2][j] * rate(j)).sum::<f64>();
                    }
                }
                match end.is_finite() {
                    true => Ok(end),
                    false => Err(format!("the derivatives are not finite at {} s", step.t0)),
                }
            };
        (self.neighbours.iter().zip(columns).zip(&self.shifts).map(advance).collect(), nodes[2].1)
    }

    /// Advances all derivatives over a part of a step, in halves until their error is small.
    fn advance(
        &mut self,
        [from, to]: [f64; 2],
        (step, mode): (&Step<N, Z>, &M::Mode),
        tools: &mut dyn StepTools<N, Z>,
        (halvings, error_before): (u32, f64),
    ) {
        if self.columns.iter().all(Result::is_err) {
            return;
        }
        let middle = 0.5 * (from + to);
        let (whole, end) = self.collocate(&self.columns, [from, to], (step, mode), tools);
        let (half, _) = self.collocate(&self.columns, [from, middle], (step, mode), tools);
        let (halves, _) = self.collocate(&half, [middle, to], (step, mode), tools);
        let error = self.difference(&whole, &halves, (&end, mode));
        // Rounding errors do not decrease with the step.
        let is_noise = halvings >= MIN_HALVINGS && error > MIN_DECREASE * error_before;
        if error <= TANGENT_TOLERANCE || halvings == MAX_HALVINGS || is_noise {
            self.columns = halves;
        } else {
            self.advance([from, middle], (step, mode), tools, (halvings + 1, error));
            self.advance([middle, to], (step, mode), tools, (halvings + 1, error));
        }
    }

    /// Largest relative difference of two approximations of all derivatives at the same state.
    #[inline(never)]
    fn difference(
        &mut self,
        whole: &[Column<N, Z>],
        halves: &[Column<N, Z>],
        (end, mode): (&State<N, Z>, &M::Mode),
    ) -> f64 {
        let events = self.events((end, mode));
        let mut error = 0.0_f64;
        for (index, (whole, halves)) in whole.iter().zip(halves).enumerate() {
            let (Ok(whole), Ok(halves)) = (whole, halves) else { continue };
            let [q, v]: [[f64; N]; 2] =
                [array_from(|i| whole.q[i] - halves.q[i]), array_from(|i| whole.v[i] - halves.v[i])];
            for (scale, difference, halves) in
                self.scales[index].iter_mut().zip([&q, &v]).zip([&halves.q, &halves.v]).map(|((a, b), c)| (a, b, c))
            {
                (0..N).for_each(|i| scale[i] = scale[i].max(halves[i].abs()));
                let largest = scale.iter().fold(0.0_f64, |a, b| a.max(*b));
                let relative = |i: usize| difference[i].abs() / scale[i].max(1e-3 * largest);
                error = (0..N).map(relative).filter(|x| x.is_finite()).fold(error, f64::max);
            }
            let parameter = &self.neighbours[index].parameter;
            let value = parameter.value.abs().max(parameter.step);
            for (_, weight) in &events.weights {
                let relative = match weight {
                    ErrorWeight::Depth { row, depth, .. } => product(row, &q) * value / depth,
                    ErrorWeight::Slip { row, slip_scale, .. } => product(row, &v) * value / slip_scale,
                };
                error = error.max(CONTACT_WEIGHT * relative.abs());
            }
        }
        error
    }

    /// Derivatives of the numbers of a sample that moves by `dt`.
    fn read_along(
        &self,
        neighbours: &Neighbours<'a, M, N, Z>,
        (t, state, mode): Instant<'_, M::Mode, N, Z>,
        moving: (&State<N, Z>, f64),
        dt: f64,
    ) -> Result<Vec<f64>, String> {
        let lin = Self::linearise(&self.kernel, (t, state, mode));
        let (_, direction) = self.differentiate(neighbours, (t, state, mode), &lin, moving)?;
        let level = neighbours.level(direction.level, self.counts)?;
        let mut history = self.history.clone();
        let mut sample = Sample::new(t, self.counts);
        self.kernel.read((state, mode), &self.start_energy, RequiredData::ALL, &mut history, &mut sample);
        let read = |Neighbour { kernel, start_energy, .. }: &Neighbour<M, N, Z>, h: f64| {
            let Direction { tangent, dt, .. } = &direction;
            let (state, mut sample) = (along(state, h, tangent), Sample::new(t + h * dt, self.counts));
            kernel.read((&state, mode), start_energy, RequiredData::ALL, &mut history.clone(), &mut sample);
            sample
        };
        let quotient = |[below, above]: [Sample; 2], h: f64| -> Vec<f64> {
            above.values().iter().zip(below.values()).map(|(above, below)| (above - below) / (2.0 * h)).collect()
        };
        let of_run: [Vec<f64>; 2] = [0, 1].map(|k| {
            let (pair, h) = (&level.pairs[k], level.h[k]);
            quotient([read(&pair[0], -h), read(&pair[1], h)], h)
        });
        let derivatives = of_run[0].iter().zip(&of_run[1]).map(|(full, half)| extrapolate([*full, *half]));
        let moved = dt - direction.dt;
        if moved == 0.0 {
            return Ok(derivatives.collect());
        }
        // The tangent moves in time by `direction.dt`; the rest is along the run itself.
        let rates = self.rates_before(t)?.0.iter();
        Ok(derivatives.zip(rates).map(|(derivative, rate)| derivative + moved * rate).collect())
    }

    /// Rates of the numbers of the sample, and of the event functions of contacts, just before an event.
    fn rates_before(&self, t: f64) -> Result<&(Vec<f64>, Vec<f64>), String> {
        let found = self.rates.as_ref().filter(|_| t == self.time_s);
        found.ok_or_else(|| format!("an event at {t} s is not at the end of a step"))
    }

    /// Finds the rates at a fraction of a step. The force of a stiff damper has no accurate rate along the accelerations of
    /// a state, which are small differences of large forces.
    fn find_rates(&mut self, (step, mode): (&Step<N, Z>, &M::Mode), to: f64, tools: &mut dyn StepTools<N, Z>) {
        let (mut sums, mut event_sums) = (vec![0.0; self.counts.values()], vec![0.0; self.contacts]);
        for (index, weight) in BACKWARD_WEIGHTS.into_iter().enumerate() {
            let theta = to * (1.0 - BACKWARD_STEP * index as f64);
            let state = if theta < 1.0 { tools.resolve(theta) } else { *step.end };
            let sample = self.sample((step.t0 + theta * step.h, &state, mode));
            sums.iter_mut().zip(sample.values()).for_each(|(sum, value)| *sum += weight * value);
            let functions = self.events((&state, mode)).functions;
            event_sums.iter_mut().zip(functions).for_each(|(sum, function)| *sum += weight * function.value);
        }
        let scale = 1.0 / (BACKWARD_STEP * to * step.h);
        sums.iter_mut().chain(&mut event_sums).for_each(|sum| *sum *= scale);
        self.rates = Some((sums, event_sums));
    }

    fn sample(&self, (t, state, mode): Instant<'_, M::Mode, N, Z>) -> Sample {
        let mut sample = Sample::new(t, self.counts);
        let mut history = self.history.clone();
        self.kernel.read((state, mode), &self.start_energy, RequiredData::ALL, &mut history, &mut sample);
        sample
    }

    /// Derivatives of the sample at the end of the last step.
    fn sample_derivatives(&self) -> Vec<Result<Vec<f64>, String>> {
        let at_end = (self.time_s, &self.state, &self.mode);
        let of_column = |((neighbours, column), shift): ((&Neighbours<'a, M, N, Z>, &Column<N, Z>), &f64)| {
            self.read_along(neighbours, at_end, (column.as_ref().map_err(Clone::clone)?, *shift), 0.0)
        };
        self.neighbours.iter().zip(&self.columns).zip(&self.shifts).map(of_column).collect()
    }

    /// Applies the mode of a step at its start, if no event has reported its changes.
    fn enter(&mut self, step: &Step<N, Z>, mode: &M::Mode) {
        let contacts = 0..self.contacts;
        if (self.state.q, self.state.v) != (step.start.q, step.start.v) {
            self.refuse(&format!("a contact that oscillates is set to its equilibrium at {} s", step.t0));
        }
        if let Some(contact) = contacts.clone().find(|contact| mode[*contact] == ContactState::Clamped) {
            let message = "chatters, and its force has a kink that is not located";
            self.refuse(&format!("the contact {} {message}, at {} s", self.contact_name(contact), step.t0));
        }
        self.pass_discontinuity(mode);
        if *mode == self.mode {
            return;
        }
        let rates = Self::rates(&self.kernel, (step.t0, step.start, &self.mode));
        let next = Self::rates(&self.kernel, (step.t0, step.start, mode));
        let opened: Vec<usize> =
            contacts.filter(|contact| is_touch_down(self.mode[*contact], mode[*contact])).collect();
        for contact in &opened {
            self.pass_event((step.t0, step.start), *contact, mode);
        }
        if opened.is_empty() && self.is_jump(&rates.a, &next.a) {
            self.refuse(&format!("the accelerations jump at {} s without an event of a contact", step.t0));
        }
        self.mode = *mode;
    }

    /// Passes a jump of the rates that moves with the next discontinuity in time.
    fn pass_jump(&mut self, before: &Rates<N, Z>, after: &Rates<N, Z>) {
        for (index, column) in self.columns.iter_mut().enumerate() {
            let dt = self.neighbours[index].discontinuities[1] - self.shifts[index];
            let Ok(column) = column else { continue };
            (0..N).for_each(|i| column.v[i] += (before.a[i] - after.a[i]) * dt);
            (0..Z).for_each(|i| column.z[i] += (before.g[i] - after.g[i]) * dt);
        }
    }

    /// Passes an event of the normal law of a contact: returns the derivatives of its time and its sample, and applies
    /// the jump of the derivatives of the state.
    fn pass_event(&mut self, (t, state): (f64, &State<N, Z>), contact: usize, mode: &M::Mode) -> EventDerivatives {
        let before = (t, state, &self.mode.clone());
        let is_touch_down = is_touch_down(self.mode[contact], mode[contact]);
        let rates = Self::rates(&self.kernel, before);
        let jumps = is_touch_down && self.jumps_at_touch_down((t, state), contact, mode);
        let mut results = Vec::new();
        for index in 0..self.neighbours.len() {
            let neighbours = &self.neighbours[index];
            let shift = self.shifts[index];
            let moved = self.columns[index].clone().and_then(|column| {
                let dt = self.time_derivative(neighbours, before, (&rates, &column, shift), contact)?;
                Ok((dt, self.read_along(neighbours, before, (&column, shift), dt)))
            });
            match moved {
                Ok((dt, sample)) => {
                    self.shift(index, (state, &rates), dt);
                    results.push(sample.map(|sample| (dt, sample)));
                }
                Err(reason) => {
                    self.columns[index] = Err(reason.clone());
                    results.push(Err(reason));
                }
            }
        }
        if jumps {
            self.rates = None;
        }
        results
    }

    /// How the time of a step moves. Near a discontinuity in time it moves with it: otherwise difference quotients would
    /// cross it.
    fn shift_of_step(&self, index: usize, step: &Step<N, Z>) -> f64 {
        let (neighbours, shift) = (&self.neighbours[index], self.shifts[index]);
        let ([last, next], [last_s, next_s]) = (neighbours.discontinuities, self.discontinuities_s);
        let reach = |discontinuity: f64| neighbours.parameter.step * (shift - discontinuity).abs();
        if step.t1 + reach(next) >= next_s {
            next
        } else if step.t0 - reach(last) < last_s {
            last
        } else {
            shift
        }
    }

    /// Changes how the time moves at which the derivatives of a column are taken.
    fn shift(&mut self, index: usize, (state, rates): (&State<N, Z>, &Rates<N, Z>), shift: f64) {
        if shift == self.shifts[index] {
            return;
        }
        let flow = State { q: state.v, v: rates.a, z: rates.g };
        if let Ok(column) = &mut self.columns[index] {
            *column = along(column, shift - self.shifts[index], &flow);
        }
        self.shifts[index] = shift;
    }

    /// Whether the accelerations jump at a touch-down. The force just beyond it is extrapolated from two small depths.
    fn jumps_at_touch_down(&self, (t, state): (f64, &State<N, Z>), contact: usize, mode: &M::Mode) -> bool {
        let reading = self.contact((t, state, mode), contact);
        let duration_s = (2.0 * reading.gap_m.abs()).max(1e-12) / reading.gap_rate_m_s.abs();
        let beyond = |factor: f64| {
            let mut state = *state;
            (0..N).for_each(|i| state.q[i] += (factor * duration_s) * state.v[i]);
            let [with, without] = [mode, &self.mode].map(|mode| Self::rates(&self.kernel, (t, &state, mode)));
            (with, without)
        };
        let ([near, without], [far, far_without]) = (<[_; 2]>::from(beyond(1.0)), <[_; 2]>::from(beyond(2.0)));
        let jump = |i: usize| 2.0 * (near.a[i] - without.a[i]) - (far.a[i] - far_without.a[i]);
        self.is_jump(&without.a, &array_from(|i| without.a[i] + jump(i)))
    }

    fn is_jump(&self, before: &[f64; N], after: &[f64; N]) -> bool {
        let largest = before.iter().chain(after).fold(self.acceleration_scale, |largest, a| largest.max(a.abs()));
        before.iter().zip(after).any(|(before, after)| (before - after).abs() > MIN_JUMP * largest)
    }

    /// dt/dp of an event of the normal law of a contact.
    fn time_derivative(
        &self,
        neighbours: &Neighbours<'a, M, N, Z>,
        (t, state, mode): Instant<'_, M::Mode, N, Z>,
        (rates, column, shift): (&Rates<N, Z>, &State<N, Z>, f64),
        contact: usize,
    ) -> Result<f64, String> {
        let level = neighbours.level(0, self.counts)?;
        let gap = |kernel: &M, _: f64, state: &State<N, Z>| [kernel.contact(state, contact, mode).gap_m];
        let reading = self.contact((t, state, mode), contact);
        let [[full], [half]] = Self::quotients(level, (t, state), (column, shift), gap);
        let gap_derivative = extrapolate([full, half]);
        let flow = State { q: state.v, v: rates.a, z: rates.g };
        // The force of a contact without a damper ends at zero depth, located at a small force.
        let from_gap = shift - gap_derivative / reading.gap_rate_m_s;
        if mode[contact] == ContactState::Free || -reading.gap_m < MIN_RELEASE_DEPTH * self.deepest[contact] {
            let rate = reading.gap_rate_m_s;
            let h = 0.01 * self.step_s;
            let rate_at = |h: f64| self.contact((t, &along(state, h, &flow), mode), contact).gap_rate_m_s;
            let curvature = (rate_at(h) - rate_at(-h)) / (2.0 * h);
            let turning = 0.5 * rate * rate / curvature.abs().max(f64::MIN_POSITIVE);
            let parameter = &neighbours.parameter;
            let change = LINEAR_RANGE * parameter.value.abs().max(parameter.step);
            if turning < ((from_gap * rate) * change).abs() || rate == 0.0 {
                return Err(format!(
                    "the contact {} grazes at {t} s: its gap changes at {rate:.1e} m/s (limit: rad/s), and the time of the \
                     event is not linear in the parameter",
                    self.contact_name(contact)
                ));
            }
            return Ok(from_gap);
        }
        let lin = Self::linearise(&self.kernel, (t, state, mode));
        let (_, direction) = self.differentiate(neighbours, (t, state, mode), &lin, (column, shift))?;
        let force =
            |kernel: &M, _: f64, state: &State<N, Z>| [kernel.eval_event(&state.q, &state.v, mode, contact).value];
        let level = neighbours.level(direction.level, self.counts)?;
        let [[full], [half]] = Self::quotients(level, (t, state), (&direction.tangent, direction.dt), force);
        // Along the direction, time moves by its own part.
        let derivative = direction.dt - extrapolate([full, half]) / self.rates_before(t)?.1[contact];
        match derivative.is_finite() {
            true => Ok(derivative),
            false => {
                Err(format!("the force of the contact {} does not cross zero at {t} s", self.contact_name(contact)))
            }
        }
    }

    /// Passes a discontinuity of the right-hand side in time, at the present time, in the mode that follows it.
    fn pass_discontinuity(&mut self, mode: &M::Mode) {
        let Some(before) = self.before_discontinuity.take() else { return };
        let (t, state) = (self.time_s, self.state);
        let after = Self::rates(&self.kernel, (t, &state, mode));
        self.pass_jump(&before, &after);
        let moved =
            |neighbours: &Neighbours<'a, M, N, Z>| neighbours.parameter.step * neighbours.discontinuities[1].abs();
        let latest = t + self.neighbours.iter().map(moved).fold(0.0, f64::max);
        self.mode = *mode;
        self.bounds_s[0] = latest.next_up();
        self.find_discontinuity(t);
    }
}

/// Whether a contact without a force begins to have one.
fn is_touch_down(before: ContactState, after: ContactState) -> bool {
    before == ContactState::Free && after.has_force()
}

fn product<const N: usize>(row: &[f64; N], column: &[f64; N]) -> f64 {
    row.iter().zip(column).map(|(a, b)| a * b).sum()
}

/// LU factorisation with row pivoting; returns the order of the rows.
fn factor(matrix: &mut [f64], size: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..size).collect();
    for k in 0..size {
        let magnitude = |row: &usize| matrix[row * size + k].abs();
        let pivot = (k..size).max_by(|a, b| magnitude(a).total_cmp(&magnitude(b))).unwrap_or(k);
        order.swap(k, pivot);
        (0..size).for_each(|j| matrix.swap(k * size + j, pivot * size + j));
        for i in k + 1..size {
            let multiple = matrix[i * size + k] / matrix[k * size + k];
            matrix[i * size + k] = multiple;
            if multiple != 0.0 {
                (k + 1..size).for_each(|j| matrix[i * size + j] -= multiple * matrix[k * size + j]);
            }
        }
    }
    order
}

/// Solves a factored system.
fn substitute(matrix: &[f64], order: &[usize], rhs: &mut Vec<f64>) {
    let size = order.len();
    let mut x: Vec<f64> = order.iter().map(|row| rhs[*row]).collect();
    for i in 0..size {
        x[i] -= (0..i).map(|j| matrix[i * size + j] * x[j]).sum::<f64>();
    }
    for i in (0..size).rev() {
        x[i] -= (i + 1..size).map(|j| matrix[i * size + j] * x[j]).sum::<f64>();
        x[i] /= matrix[i * size + i];
    }
    *rhs = x;
}

impl<M, const N: usize, const Z: usize> Observer<N, Z, M::Mode> for Tangent<'_, M, N, Z>
where
    M: Kernel<N, Z> + Hybrid<N, Z>,
{
    fn step(&mut self, step: &Step<N, Z>, mode: &M::Mode, tools: &mut dyn StepTools<N, Z>) -> bool {
        self.enter(step, mode);
        let rates = Self::rates(&self.kernel, (step.t0, step.start, mode));
        self.acceleration_scale = rates.a.iter().fold(self.acceleration_scale, |largest, a| largest.max(a.abs()));
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
            let state = if to < 1.0 { tools.resolve(to) } else { *step.end };
            (self.time_s, self.state, from) = (*time_s, state, to);
            self.find_rates((step, mode), to, tools);
            let sample = self.sample((*time_s, &state, mode));
            self.at_times.push((sample, self.sample_derivatives()));
        }
        if from < 1.0 {
            self.advance([from, 1.0], (step, mode), tools, (0, f64::INFINITY));
        }
        (self.time_s, self.state) = (step.t1, *step.end);
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

    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &M::Mode) {
        self.pass_discontinuity(&self.mode.clone());
        let sample = self.sample((t, state, &self.mode));
        let derivatives = self.pass_event((t, state), index, mode);
        self.events.push((sample, derivatives));
        self.mode = *mode;
    }
}
