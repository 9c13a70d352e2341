//! The integration loop: steps, event location, mode changes, termination.

use std::fmt::Debug;

use super::clock::Clock;
use super::control::{Controller, ToleranceSchedule};
use super::event_location::{Found, SearchMemory, may_have_passed, search_step};
use super::inside_step::{InsideMemory, StepEvaluator, observe};
use super::layout::{Layout, copy};
use super::method::{Attempt, Method, StepStart};
use super::stall::{Chatter, StallDetector};
use super::state::{Observer, Step, StepTools};
use super::step_attempts::{
    AcceptedStep, EventLocation, KEPT_ATTEMPTS, LocationAttempt, MIN_STEP_S, StepAttempts, simultaneous_events,
};
use super::{Counters, EventSet, Hybrid, Linearised, State, Tolerances, error_weight};

/// Options of an integration.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub tolerances: Tolerances,
    /// Maximum number of accepted steps.
    pub max_steps: u64,
}

/// Reason why an integration ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error("the step size fell to {h_s:.1e} s: the requested accuracy cannot be reached here; loosen the tolerances")]
    StepUnderflow { h_s: f64 },
    #[error("the accelerations are not finite")]
    NotFinite,
    #[error("{0}")]
    Obstacle(String),
    #[error("the budget of {0} steps is used up; raise `max_steps` or shorten the run")]
    Budget(u64),
    #[error(
        "the budget of {budget} contact sub-steps (ten for each of `max_steps`) is used up after {steps} steps; raise \
         `max_steps`, soften the contact, or shorten the run"
    )]
    SubstepBudget { budget: u64, steps: u64 },
    /// Interrupted by the observer.
    #[error("interrupted")]
    Stopped,
}

/// Time and reason of an integration that ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("at t = {time_s:.9} s: {reason}")]
pub struct Failure {
    pub time_s: f64,
    pub reason: Reason,
}

/// Result of an integration.
#[derive(Clone, Debug)]
pub struct End<L: Layout> {
    pub time_s: f64,
    pub state: State<L>,
    pub counters: Counters,
    pub result: Result<(), Failure>,
}

/// First step of a run, and smallest first step after a discontinuity of the right-hand side.
const FIRST_STEP_S: f64 = 1e-8;
/// First step after a discontinuity of the right-hand side, as a fraction of the step before it.
const RESTART_FRACTION: f64 = 0.01;
/// Clearance below which each step covers at most half of the remaining clearance.
const NEAR_OBSTACLE: f64 = 0.1;
/// Reduction of a step that may have passed a singularity.
const APPROACH_CUT: f64 = 0.25;
/// Step size at which the reduction stops: the singularity is reached.
const MIN_APPROACH_STEP_S: f64 = 1e-11;
/// Reduction of a step at whose end its mode is not valid.
const INVALID_MODE_CUT: f64 = 0.5;
/// Reduction of a step in which a sticking contact unloads.
const UNLOADING_CUT: f64 = 0.4;

/// Integrates from `t0` to `t_end` and locates every event; the method is chosen at compile time.
pub fn integrate<Y, K, O>(
    system: &Y,
    options: &Options,
    t0: f64,
    start: State<Y::Layout>,
    t_end: f64,
    observer: &mut O,
) -> End<Y::Layout>
where
    Y: Hybrid,
    K: Method<Y::Layout>,
    O: Observer<Y::Layout, Y::Mode>,
{
    integrate_by(K::new(system.layout()), system, options, t0, start, t_end, observer)
}

/// Integrates from `t0` to `t_end` and locates every event, with a method that has no history yet.
pub fn integrate_by<Y, K, O>(
    method: K,
    system: &Y,
    options: &Options,
    t0: f64,
    start: State<Y::Layout>,
    t_end: f64,
    observer: &mut O,
) -> End<Y::Layout>
where
    Y: Hybrid,
    K: Method<Y::Layout>,
    O: Observer<Y::Layout, Y::Mode>,
{
    let mut integration = Integration::new(method, system, options, t0, start);
    let result = integration.advance(system, t_end, t_end, observer);
    End { time_s: integration.time_s(), state: integration.state().clone(), counters: *integration.counters(), result }
}

/// An integration in progress. Its functions receive the system as an argument, which must be the same in every call.
///
/// The sizes of steps do not depend on the times to which the integration advances, and neither do the results. The
/// last step may therefore end after such a time. It is then pending, and states are read inside it. It is committed
/// once the integration advances to its end.
#[derive(Clone)]
pub struct Integration<L: Layout, M, K> {
    run: Run<L, M, K>,
    /// What follows the last committed step, if it is known.
    pending: Option<Pending>,
    /// Linearisation at the start of the pending step.
    linearised: Linearised<L>,
    /// The pending step. It stays in place, because it is large for a gripper.
    found: AcceptedStep<L>,
}

impl<L: Layout, M: Clone + Debug, K: Method<L>> Integration<L, M, K> {
    /// Starts an integration with a method that has no history yet.
    pub fn new<Y>(method: K, system: &Y, options: &Options, t0: f64, start: State<L>) -> Self
    where
        Y: Hybrid<Layout = L, Mode = M>,
    {
        let mode = system.mode_at(t0, &start.q, &start.v);
        let layout = system.layout();
        let mut events = EventSet::new(layout, system.event_count());
        system.eval_events(&start.q, &start.v, &mode, &mut events);
        let run = Run {
            options: *options,
            controller: Controller::new(method.error_order()),
            resolver: method.clone(),
            method,
            clock: Clock::at(t0),
            start: start.clone(),
            state: start,
            memory: SearchMemory::new(layout, system.event_count()),
            kept: std::array::from_fn(|_| LocationAttempt::new(layout, &events)),
            simultaneous: Vec::with_capacity(system.event_count()),
            events: events.clone(),
            mode,
            latest_time: f64::INFINITY,
            h: FIRST_STEP_S,
            chatter: Chatter::new(system.event_count()),
            stall_detector: StallDetector::new(&options.tolerances, t0),
            tolerance_schedule: ToleranceSchedule::new(&options.tolerances),
            counters: Counters::default(),
            inside: InsideMemory::new(layout),
        };
        let found = AcceptedStep {
            attempt: Attempt::new(layout),
            events,
            size: 0.0,
            resume_size: 0.0,
            event: None,
            reaches_stop: false,
        };
        Self { run, pending: None, linearised: Linearised::zero(layout), found }
    }

    /// Time at the end of the last committed step, s.
    pub fn time_s(&self) -> f64 {
        self.run.clock.now()
    }

    /// State at the end of the last committed step.
    pub fn state(&self) -> &State<L> {
        &self.run.state
    }

    pub fn mode(&self) -> &M {
        &self.run.mode
    }

    pub fn counters(&self) -> &Counters {
        &self.run.counters
    }

    /// Commits all steps that end before or at time `t`, at most `t_end`. One step ends at `t_end`, the end of the run,
    /// which must not change while a step is pending. Returns earlier if the observer suspends the advance.
    ///
    /// # Errors
    /// Returns an error if the integration cannot reach `t`, or if the observer ends it.
    pub fn advance<Y, O>(&mut self, system: &Y, t: f64, t_end: f64, observer: &mut O) -> Result<(), Failure>
    where
        Y: Hybrid<Layout = L, Mode = M>,
        O: Observer<L, M>,
    {
        self.step_to(system, t, (t_end, t_end), observer)
    }

    /// Like [`Integration::advance`], but the last step ends at `t`. A pending step is discarded.
    ///
    /// # Errors
    /// See [`Integration::advance`].
    pub fn advance_exactly<Y, O>(&mut self, system: &Y, t: f64, t_end: f64, observer: &mut O) -> Result<(), Failure>
    where
        Y: Hybrid<Layout = L, Mode = M>,
        O: Observer<L, M>,
    {
        self.advance(system, t, t_end, observer)?;
        self.pending = None;
        self.step_to(system, t, (t, t_end), observer)
    }

    /// Commits all steps that end before or at time `t`; a step ends at `stop`.
    fn step_to<Y, O>(&mut self, system: &Y, t: f64, (stop, t_end): (f64, f64), observer: &mut O) -> Result<(), Failure>
    where
        Y: Hybrid<Layout = L, Mode = M>,
        O: Observer<L, M>,
    {
        let Self { run, pending, linearised, found } = self;
        while run.clock.until(t) > MIN_STEP_S {
            if pending.is_none() {
                let next = run.find_next(system, stop, (linearised, found));
                *pending = Some(next.map_err(|reason| run.failure(reason))?);
            }
            let Some(next) = pending else { break };
            if next.ends_after(found, &run.clock, t) {
                break;
            }
            let result = run.commit(system, next, (linearised, found), t_end, observer);
            *pending = None;
            result.map_err(|reason| run.failure(reason))?;
            if observer.suspends(&run.state, &run.mode, run.events.clearance) {
                break;
            }
        }
        Ok(())
    }

    /// Whether the pending step ends after time `t`, so that an advance to `t` commits nothing.
    pub fn is_within_step(&self, t: f64) -> bool {
        self.pending.as_ref().is_some_and(|pending| pending.ends_after(&self.found, &self.run.clock, t))
    }

    /// Reads states inside the pending step; `None` if no step is pending. `read` receives the step, its mode, and
    /// tools that evaluate states inside it. The integration does not change.
    pub fn read_pending<Y, R>(
        &self,
        system: &Y,
        read: impl FnOnce(&Step<L>, &M, &mut dyn StepTools<L>) -> R,
    ) -> Option<R>
    where
        Y: Hybrid<Layout = L, Mode = M>,
    {
        let Some(Pending { next: Next::Step, .. }) = &self.pending else { return None };
        let Self { run, linearised, found: accepted, .. } = self;
        let mut end = run.clock;
        end.advance(accepted.size);
        let step = Step {
            t0: run.clock.now(),
            t1: end.now(),
            h: accepted.size,
            start: &run.state,
            end: &accepted.attempt.end,
        };
        // Readings inside a committed step start from the same history.
        let mut resolver = run.method.clone();
        resolver.accept_step();
        let origin = run.origin(system, &run.options.tolerances, linearised);
        let mut memory = run.inside.clone();
        let mut tools = StepEvaluator::new((&run.method, &mut resolver), origin, accepted.size, &mut memory);
        Some(read(&step, &run.mode, &mut tools))
    }

    /// Continues from the end of the last committed step with another state, mode and right-hand side.
    pub fn restart<Y: Hybrid<Layout = L, Mode = M>>(&mut self, system: &Y, state: State<L>, mode: M) {
        self.pending = None;
        (self.run.state, self.run.mode) = (state, mode);
        self.run.update_events(system);
        self.run.restart_method();
    }
}

/// State of an integration at the end of the last committed step.
#[derive(Clone)]
struct Run<L: Layout, M, K> {
    options: Options,
    method: K,
    /// Method of steps that end inside the last one.
    resolver: K,
    controller: Controller,
    clock: Clock,
    state: State<L>,
    /// State at the start of the last step.
    start: State<L>,
    /// Event functions of `mode` at `state`.
    events: EventSet<L>,
    memory: SearchMemory<L>,
    kept: [LocationAttempt<L>; KEPT_ATTEMPTS],
    /// Other events at the end of the last step, for reuse of the allocation.
    simultaneous: Vec<usize>,
    mode: M,
    /// Latest time before the next discontinuity of the right-hand side.
    latest_time: f64,
    h: f64,
    chatter: Chatter,
    stall_detector: StallDetector,
    tolerance_schedule: ToleranceSchedule,
    counters: Counters,
    inside: InsideMemory<L>,
}

/// What follows the last committed step.
#[derive(Clone, Copy)]
struct Pending {
    next: Next,
    stop: f64,
    /// Whether the right-hand side is discontinuous at the stop.
    stops_at_discontinuity: bool,
}

impl Pending {
    /// Whether the step ends after time `t`.
    fn ends_after<L: Layout>(&self, accepted: &AcceptedStep<L>, clock: &Clock, t: f64) -> bool {
        match self.next {
            Next::Step if accepted.reaches_stop => self.stop > t,
            Next::Step => accepted.size > clock.until(t),
            Next::Event(_) => false,
        }
    }
}

/// Outcome of the search for the next step.
#[derive(Clone, Copy)]
enum Next {
    Step,
    /// An event with this index at the current time: no step is taken.
    Event(usize),
}

impl<L: Layout, M: Clone + Debug, K: Method<L>> Run<L, M, K> {
    fn failure(&self, reason: Reason) -> Failure {
        Failure { time_s: self.clock.now(), reason }
    }

    /// Start of the next step.
    fn origin<'a, Y: Hybrid<Layout = L, Mode = M>>(
        &'a self,
        system: &'a Y,
        tolerances: &'a Tolerances,
        linearised: &'a Linearised<L>,
    ) -> StepStart<'a, Y> {
        let Self { mode, latest_time, state, .. } = self;
        let (t, latest_time) = (self.clock.now(), *latest_time);
        StepStart { system, mode, linearised, tolerances, t, latest_time, state }
    }

    /// Finds the next step, at most up to `stop`, or an event at the current time.
    fn find_next<Y: Hybrid<Layout = L, Mode = M>>(
        &mut self,
        system: &Y,
        stop: f64,
        (linearised, found): (&mut Linearised<L>, &mut AcceptedStep<L>),
    ) -> Result<Pending, Reason> {
        let t = self.clock.now();
        if t > self.latest_time {
            system.pass_discontinuity(t, &self.state.q, &self.state.v, &mut self.mode);
            self.update_events(system);
        }
        // Written so that a NaN clearance counts as negative.
        if self.events.clearance.partial_cmp(&0.0).is_none_or(|order| order.is_lt()) {
            return Err(Reason::Obstacle(system.describe_obstacle(&self.state.q)));
        }
        if self.counters.steps >= self.options.max_steps {
            return Err(Reason::Budget(self.options.max_steps));
        }
        let start = (t, &self.state, &self.mode);
        let has_derivatives = self.method.evaluate_start(system, start, self.h, linearised);
        self.counters.jacobians += u64::from(has_derivatives);
        self.controller.set_order(self.method.error_order());
        if !linearised.rates.a.as_ref().iter().all(|a| a.is_finite()) {
            return Err(Reason::NotFinite);
        }
        let discontinuity = system.next_discontinuity(t);
        self.latest_time = discontinuity.next_down();
        let stop = discontinuity.min(stop);
        let next = self.find_step(system, linearised, stop, found)?;
        Ok(Pending { next, stop, stops_at_discontinuity: stop == discontinuity })
    }

    /// Takes the step that was found, or handles the event at the current time.
    fn commit<Y: Hybrid<Layout = L, Mode = M>, O: Observer<L, M>>(
        &mut self,
        system: &Y,
        pending: &Pending,
        (linearised, accepted): (&Linearised<L>, &mut AcceptedStep<L>),
        t_end: f64,
        observer: &mut O,
    ) -> Result<(), Reason> {
        if let Next::Event(event_index) = pending.next {
            self.apply_event(system, event_index, observer);
            return Ok(());
        }
        if let Some(event) = accepted.event {
            let events = [&self.events, &accepted.events];
            simultaneous_events(system, &self.mode, event, events, &mut self.simultaneous);
        }
        self.take_step(system, linearised, accepted, pending.stop, observer)?;
        if self.stall_detector.is_stalled(&self.counters, self.clock.now(), t_end) && accepted.event.is_none() {
            self.method.on_stall();
            if self.stall_detector.may_project() {
                self.project_quasi_static(system, t_end);
            }
        }
        if let Some(event_index) = accepted.event {
            self.apply_event(system, event_index, observer);
            for place in 0..self.simultaneous.len() {
                let index = self.simultaneous[place];
                // The first event may have changed the other event functions.
                if self.events.functions[index].value.abs() <= system.event_tolerance(index, &self.mode) {
                    self.apply_event(system, index, observer);
                }
            }
        } else if accepted.reaches_stop && pending.stops_at_discontinuity {
            self.h = (RESTART_FRACTION * self.h).max(FIRST_STEP_S);
            self.restart_method();
        }
        Ok(())
    }

    /// Finds a step with an acceptable error, shortened to the first event within it.
    fn find_step<Y: Hybrid<Layout = L, Mode = M>>(
        &mut self,
        system: &Y,
        linearised: &Linearised<L>,
        stop: f64,
        found: &mut AcceptedStep<L>,
    ) -> Result<Next, Reason> {
        let mut tolerances =
            self.tolerance_schedule.tolerances(&self.options.tolerances, self.stall_detector.progress(&self.counters));
        error_weight::raise_above_noise(
            &mut tolerances,
            &self.events,
            &self.state,
            linearised,
            self.stall_detector.noise_scale(),
        );
        let approach_limit = self.approach_limit();
        let Self { state, mode, events, method, counters, memory, kept, controller, .. } = self;
        let (state, mode, events, tolerances) = (&*state, &*mode, &*events, &tolerances);
        let (t, latest_time) = (self.clock.now(), self.latest_time);
        let origin = StepStart { system, mode, linearised, tolerances, t, latest_time, state };
        let mut attempts = StepAttempts { method, counters, events, memory, kept };
        let requested_size = self.h;
        let max_step = system.max_step(t, &state.q, &state.v, mode);
        let mut h = requested_size.min(approach_limit).min(max_step);
        let remaining = self.clock.until(stop);
        loop {
            // A step that would end just short of the stop is extended to it.
            let reaches_stop = 1.0001 * h >= remaining;
            let size = if reaches_stop { remaining } else { h };
            if size < MIN_STEP_S && !reaches_stop {
                return Err(Reason::StepUnderflow { h_s: size });
            }
            attempts.attempt(&origin, size, &mut found.attempt);
            let attempt = &found.attempt;
            if !attempt.is_acceptable() {
                attempts.counters.rejected += 1;
                h = controller.reject(size, attempt.error);
                continue;
            }
            system.eval_events(&attempt.end.q, &attempt.end.v, mode, &mut found.events);
            let at_end = &found.events;
            let clearance = |w: &EventSet<L>| (w.clearance, w.clearance_rate);
            // A state beyond a singularity may not exist.
            let nearest = if at_end.clearance.is_nan() { &state.q } else { &attempt.end.q };
            if at_end.clearance.is_nan() || may_have_passed(clearance(events), clearance(at_end), size) {
                if size < MIN_APPROACH_STEP_S {
                    return Err(Reason::Obstacle(system.describe_obstacle(nearest)));
                }
                attempts.counters.rejected += 1;
                h = APPROACH_CUT * size;
                continue;
            }
            if !system.is_mode_valid(size, &attempt.end.q, &attempt.end.v, mode) {
                if size < MIN_APPROACH_STEP_S {
                    return Err(Reason::Obstacle(system.describe_obstacle(nearest)));
                }
                attempts.counters.rejected += 1;
                h = INVALID_MODE_CUT * size;
                continue;
            }
            if error_weight::unloads(events, at_end, attempt, state, tolerances) {
                attempts.counters.rejected += 1;
                h = controller.cut(size, UNLOADING_CUT);
                continue;
            }
            let ends = ([state, &attempt.end], size);
            let of_step = (system, mode, &*attempts.method);
            let crossing = match search_step(of_step, [events, at_end], ends, attempts.memory) {
                Found::Crossing(crossing) => crossing,
                Found::Obstacle | Found::Unresolved if size >= MIN_APPROACH_STEP_S => {
                    attempts.counters.rejected += 1;
                    h = APPROACH_CUT * size;
                    continue;
                }
                Found::Obstacle => return Err(Reason::Obstacle(system.describe_obstacle(nearest))),
                Found::Nothing | Found::Unresolved => {
                    found.resume_size = if reaches_stop { requested_size } else { size };
                    (found.size, found.event, found.reaches_stop) = (size, None, reaches_stop);
                    return Ok(Next::Step);
                }
            };
            match attempts.locate_event(&origin, crossing, size, found) {
                EventLocation::Located => return Ok(Next::Step),
                EventLocation::AtStart(event_index) => return Ok(Next::Event(event_index)),
                EventLocation::Rejected { size, error } => h = controller.reject(size, error),
            }
        }
    }

    /// Half of the time in which a small clearance would vanish at its present rate.
    fn approach_limit(&self) -> f64 {
        let EventSet { clearance, clearance_rate, .. } = self.events;
        if clearance < NEAR_OBSTACLE && clearance_rate < 0.0 {
            (-0.5 * clearance / clearance_rate).max(MIN_APPROACH_STEP_S)
        } else {
            f64::INFINITY
        }
    }

    /// Advances to the end of an accepted step and notifies the observer.
    fn take_step<Y: Hybrid<Layout = L, Mode = M>, O: Observer<L, M>>(
        &mut self,
        system: &Y,
        linearised: &Linearised<L>,
        accepted: &mut AcceptedStep<L>,
        stop: f64,
        observer: &mut O,
    ) -> Result<(), Reason> {
        let t0 = self.clock.now();
        self.method.accept_step();
        if accepted.reaches_stop {
            self.clock = Clock::at(stop);
        } else {
            self.clock.advance(accepted.size);
        }
        self.start.copy_from(&self.state);
        self.state.copy_from(&accepted.attempt.end);
        std::mem::swap(&mut self.events, &mut accepted.events);
        self.counters.steps += 1;
        let proposed_size = self.controller.accept(accepted.size, accepted.attempt.error);
        self.h =
            if accepted.size < accepted.resume_size { proposed_size.max(accepted.resume_size) } else { proposed_size };

        let step = Step { t0, t1: self.clock.now(), h: accepted.size, start: &self.start, end: &self.state };
        let origin = StepStart {
            system,
            mode: &self.mode,
            linearised,
            tolerances: &self.options.tolerances,
            t: t0,
            latest_time: self.latest_time,
            state: &self.start,
        };
        self.resolver.follow(&self.method);
        let mut tools = StepEvaluator::new((&self.method, &mut self.resolver), origin, accepted.size, &mut self.inside);
        if !observe(&step, &self.mode, &mut tools, observer) {
            return Err(Reason::Stopped);
        }
        if accepted.event.is_none() && self.chatter.take_clamped() {
            self.mode = system.mode_after(self.clock.now(), &self.state.q, &self.state.v, &self.mode);
            self.update_events(system);
        } else if system.pass_step(&self.events.functions, &mut self.mode) {
            self.update_events(system);
        }
        system.count_turns(&self.state.q, &self.state.v, &mut self.mode);
        Ok(())
    }

    /// Applies the mode change of an event at the current state and restarts the method.
    fn apply_event<Y: Hybrid<Layout = L, Mode = M>, O: Observer<L, M>>(
        &mut self,
        system: &Y,
        event_index: usize,
        observer: &mut O,
    ) {
        system.pass_event(event_index, &self.state.q, &self.state.v, &mut self.mode);
        let is_reported = system.is_reported(event_index);
        self.report_event(system, (event_index, is_reported), observer);
        if !is_reported {
            return;
        }
        if let Some(first) = system.restart_step(event_index, &self.state.q, &self.state.v, &self.mode) {
            self.h = self.h.min(first);
        }
        self.restart_method();
    }

    /// Counts and reports an event, and handles chattering.
    fn report_event<Y: Hybrid<Layout = L, Mode = M>, O: Observer<L, M>>(
        &mut self,
        system: &Y,
        (event_index, is_reported): (usize, bool),
        observer: &mut O,
    ) {
        if is_reported {
            self.counters.events += 1;
            observer.event(self.clock.now(), &self.state, event_index, &self.mode);
        }
        if self.chatter.record(event_index, self.clock.now()) {
            system.clamp_law(event_index, &mut self.mode);
        }
        self.update_events(system);
    }

    /// Projects oscillating contacts onto their equilibrium depth.
    fn project_quasi_static<Y: Hybrid<Layout = L, Mode = M>>(&mut self, system: &Y, t_end: f64) {
        let t = self.clock.now();
        let projected =
            system.project_quasi_static(t, (&self.state.q, &self.state.v), &self.mode, &self.options.tolerances);
        if let Some(projected) =
            projected.filter(|projected| self.stall_detector.should_project(projected.decay_rate, t_end - t))
        {
            copy(&mut self.state.q, &projected.q);
            copy(&mut self.state.v, &projected.v);
            self.mode = system.mode_after(t, &self.state.q, &self.state.v, &self.mode);
            self.update_events(system);
            self.restart_method();
        }
    }

    fn update_events<Y: Hybrid<Layout = L, Mode = M>>(&mut self, system: &Y) {
        system.eval_events(&self.state.q, &self.state.v, &self.mode, &mut self.events);
    }

    fn restart_method(&mut self) {
        self.method.restart();
        self.controller.restart();
    }
}
