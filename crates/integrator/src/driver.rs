//! The integration loop: steps, landings on events, mode changes, ends.

use super::chatter::Chatter;
use super::clock::Clock;
use super::control::{Controller, Pacing};
use super::landing::{Crossing, first_crossing, may_have_passed};
use super::method::{Attempt, Method, Origin};
use super::observer::{Observer, Step, StepTools};
use super::pace::Pace;
use super::{Counters, Hybrid, Linearised, State, Tolerances, Watch, strain};

/// How to integrate.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub tolerances: Tolerances,
    /// Budget of accepted steps.
    pub max_steps: u64,
}

/// Why an integration ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error("the step size fell to {h_s:.1e} s: the accuracy asked for cannot be reached here; loosen the tolerances")]
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
    /// Whoever watches said so.
    #[error("it was told to stop")]
    Stopped,
}

/// An integration that could not be completed, and where it stood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("at t = {time_s:.9} s: {reason}")]
pub struct Failure {
    pub time_s: f64,
    pub reason: Reason,
}

/// How an integration ended.
#[derive(Clone, Debug)]
pub struct End<const N: usize, const Z: usize> {
    pub time_s: f64,
    pub state: State<N, Z>,
    pub counters: Counters,
    pub result: Result<(), Failure>,
}

/// First step of all, and after a jump of the right-hand side.
const FIRST_STEP_S: f64 = 1e-8;
/// Below this a step size has collapsed.
const SMALLEST_STEP_S: f64 = 1e-22;
/// Clearance below which an obstacle is approached by halves.
const NEAR_OBSTACLE: f64 = 0.1;
/// A step that may have passed an obstacle is cut to this fraction…
const APPROACH_CUT: f64 = 0.25;
/// …until it is shorter than this: then the obstacle is there.
const NEAREST_APPROACH_S: f64 = 1e-11;
/// A step in which a contact that sticks lets go is cut to this part.
const LETTING_GO_CUT: f64 = 0.4;
/// Error of a part of a step, in what a whole one may err by, beyond which the interpolant is better.
const WORST_RESOLVED: f64 = 10.0;
/// Tries to land on one event.
const MAX_LANDINGS: usize = 12;

/// Integrates from `t0` to `t_end` with every event located, by a method that is known where this is compiled.
pub fn integrate<const N: usize, const Z: usize, const S: usize, Y, K, O>(
    system: &Y,
    options: &Options,
    t0: f64,
    start: State<N, Z>,
    t_end: f64,
    observer: &mut O,
) -> End<N, Z>
where
    Y: Hybrid<N, Z, S>,
    K: Method<N, Z>,
    O: Observer<N, Z, Y::Mode>,
{
    integrate_by(K::new(), system, options, t0, start, t_end, observer)
}

/// Integrates from `t0` to `t_end` with every event located, by a method that has learned nothing yet.
pub fn integrate_by<const N: usize, const Z: usize, const S: usize, Y, K, O>(
    method: K,
    system: &Y,
    options: &Options,
    t0: f64,
    start: State<N, Z>,
    t_end: f64,
    observer: &mut O,
) -> End<N, Z>
where
    Y: Hybrid<N, Z, S>,
    K: Method<N, Z>,
    O: Observer<N, Z, Y::Mode>,
{
    let controller = Controller::new(method.error_order());
    let mode = system.read_mode(t0, &start.q, &start.v);
    let mut run = Run::<N, Z, S, Y, K> {
        system,
        options,
        method,
        controller,
        clock: Clock::at(t0),
        state: start,
        watch: system.watch(&start.q, &start.v, &mode),
        mode,
        latest: f64::INFINITY,
        h: FIRST_STEP_S,
        chatter: Chatter::new(),
        pace: Pace::new(&options.tolerances, t0),
        pacing: Pacing::new(&options.tolerances),
        counters: Counters::default(),
    };
    let result = loop {
        if run.clock.until(t_end) <= SMALLEST_STEP_S {
            break Ok(());
        }
        if let Err(reason) = run.advance(t_end, observer) {
            break Err(Failure { time_s: run.clock.now(), reason });
        }
    };
    End { time_s: run.clock.now(), state: run.state, counters: run.counters, result }
}

/// An integration under way.
struct Run<'a, const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>, K> {
    system: &'a Y,
    options: &'a Options,
    method: K,
    controller: Controller,
    clock: Clock,
    state: State<N, Z>,
    /// Guards of `mode` at `state`.
    watch: Watch<N, S>,
    mode: Y::Mode,
    /// The last time before the next jump of the right-hand side.
    latest: f64,
    h: f64,
    chatter: Chatter<S>,
    pace: Pace,
    pacing: Pacing,
    counters: Counters,
}

/// What comes next.
enum Found<const N: usize, const Z: usize> {
    Step(Accepted<N, Z>),
    /// An event at this site, where the run stands: no time passes.
    Event(usize),
}

/// A step that may be taken.
struct Accepted<const N: usize, const Z: usize> {
    attempt: Attempt<N, Z>,
    size: f64,
    /// Size that was acceptable before the step was cut short, for the next one to start from.
    resume: f64,
    event: Option<usize>,
    /// Whether it ends exactly at the stop.
    stops: bool,
}

impl<const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>, K: Method<N, Z>> Run<'_, N, Z, S, Y, K> {
    /// One accepted step, or one event that takes no time.
    fn advance<O: Observer<N, Z, Y::Mode>>(&mut self, t_end: f64, observer: &mut O) -> Result<(), Reason> {
        // Written so that a clearance that is not a number counts as none.
        if self.watch.clearance.partial_cmp(&0.0).is_none_or(|order| order.is_lt()) {
            return Err(Reason::Obstacle(self.system.obstacle(&self.state.q)));
        }
        if self.counters.steps >= self.options.max_steps {
            return Err(Reason::Budget(self.options.max_steps));
        }
        let t = self.clock.now();
        let linearised = self.system.linearise(t, &self.state.q, &self.state.v, &self.mode);
        self.counters.jacobians += 1;
        if !linearised.rates.a.iter().all(|a| a.is_finite()) {
            return Err(Reason::NotFinite);
        }
        let corner = self.system.next_corner(t);
        self.latest = corner.next_down();
        let stop = corner.min(t_end);
        let accepted = match self.find_step(&linearised, stop)? {
            Found::Step(accepted) => accepted,
            Found::Event(site) => {
                self.apply_event(site, observer);
                return Ok(());
            }
        };
        self.take_step(&linearised, &accepted, stop, observer)?;
        if self.pace.is_lost(self.counters.steps, self.clock.now(), t_end) && accepted.event.is_none() {
            self.method.is_lost();
            if self.pace.may_settle() {
                self.settle(t_end);
            }
        }
        if let Some(site) = accepted.event {
            self.apply_event(site, observer);
        } else if accepted.stops && stop == corner {
            self.h = FIRST_STEP_S;
            self.forget();
        }
        Ok(())
    }

    /// A step whose error is acceptable, cut short at the first event within it.
    fn find_step(&mut self, linearised: &Linearised<N, Z>, stop: f64) -> Result<Found<N, Z>, Reason> {
        let (state, mode) = (self.state, self.mode);
        let mut tolerances = self.pacing.tolerances(&self.options.tolerances, &self.counters);
        strain::above_noise(&mut tolerances, &self.watch.guards, &self.state, linearised, self.pace.loudness());
        let origin = Origin {
            system: self.system,
            mode: &mode,
            linearised,
            tolerances: &tolerances,
            t: self.clock.now(),
            latest: self.latest,
            state: &state,
        };
        let wanted = self.h;
        let longest = self.system.longest_step(origin.t, &state.q, &state.v, &mode);
        let mut h = wanted.min(self.approach_limit()).min(longest);
        let left = self.clock.until(stop);
        loop {
            // A step that would leave a sliver before the stop takes the sliver along.
            let stops = 1.0001 * h >= left;
            let size = if stops { left } else { h };
            if size < SMALLEST_STEP_S && !stops {
                return Err(Reason::StepUnderflow { h_s: size });
            }
            let attempt = self.attempt(&origin, size);
            if !attempt.is_acceptable() {
                self.counters.rejected += 1;
                h = self.controller.reject(size, attempt.error);
                continue;
            }
            let watch = self.system.watch(&attempt.end.q, &attempt.end.v, &mode);
            let clearance = |w: &Watch<N, S>| (w.clearance, w.clearance_rate);
            if watch.clearance.is_nan() || may_have_passed(clearance(&self.watch), clearance(&watch), size) {
                if size < NEAREST_APPROACH_S {
                    return Err(Reason::Obstacle(self.system.obstacle(&attempt.end.q)));
                }
                self.counters.rejected += 1;
                h = APPROACH_CUT * size;
                continue;
            }
            if strain::lets_go(&self.watch.guards, &watch.guards, &attempt, &state, &tolerances) {
                self.counters.rejected += 1;
                h = LETTING_GO_CUT * size;
                continue;
            }
            let (now, then) = (&self.watch.guards, &watch.guards);
            let crossing = first_crossing(self.system, &mode, now, then, size, &|| self.method.dense());
            let Some(crossing) = crossing else {
                self.watch = watch;
                let resume = if stops { wanted } else { size };
                return Ok(Found::Step(Accepted { attempt, size, resume, event: None, stops }));
            };
            match self.land(&origin, crossing, size) {
                Landing::Done(accepted) => return Ok(Found::Step(accepted)),
                Landing::Now(site) => return Ok(Found::Event(site)),
                Landing::Refused { size, error } => h = self.controller.reject(size, error),
            }
        }
    }

    /// A try of the method; its error is also that of what the laws of pressing contacts are sensitive to.
    #[inline(always)]
    fn attempt(&mut self, origin: &Origin<Y, N, Z>, size: f64) -> Attempt<N, Z> {
        let mut attempt = self.method.attempt(origin, size);
        self.counters.rhs += attempt.rhs;
        if attempt.is_acceptable() {
            attempt.error =
                attempt.error.max(strain::error(&self.watch.guards, &attempt, origin.state, origin.tolerances));
        }
        attempt
    }

    /// Half the time in which a small clearance would be used up at its present rate.
    fn approach_limit(&self) -> f64 {
        let Watch { clearance, clearance_rate, .. } = self.watch;
        if clearance < NEAR_OBSTACLE && clearance_rate < 0.0 {
            (-0.5 * clearance / clearance_rate).max(NEAREST_APPROACH_S)
        } else {
            f64::INFINITY
        }
    }

    /// Repeats a step of `size` with the size that ends on the event, until it does; an earlier event at another site that
    /// comes to light on the way is landed on instead.
    fn land(&mut self, origin: &Origin<Y, N, Z>, mut crossing: Crossing, size: f64) -> Landing<N, Z> {
        let mut whole = size;
        'site: loop {
            let site = crossing.site;
            let tolerance = self.system.landing_tolerance(site, origin.mode);
            let (mut low, mut high) = (0.0, crossing.beyond * whole);
            let mut target = crossing.theta * whole;
            // The tightest landing past the event, and the last one short of it.
            let (mut past, mut short) = (None, None);
            let mut tried = 0.0;
            for _ in 0..MAX_LANDINGS {
                if target < SMALLEST_STEP_S {
                    break;
                }
                let attempt = self.attempt(origin, target);
                tried = target;
                self.counters.rejected += 1;
                if !attempt.is_acceptable() {
                    return Landing::Refused { size: target, error: attempt.error };
                }
                let watch = self.system.watch(&attempt.end.q, &attempt.end.v, origin.mode);
                if strain::lets_go(&self.watch.guards, &watch.guards, &attempt, origin.state, origin.tolerances) {
                    return Landing::Refused { size: target, error: f64::INFINITY };
                }
                let value = watch.guards[site].value;
                let near = value.abs() <= tolerance;
                let event = (near || value < 0.0).then_some(site);
                let landed = Some((Accepted { attempt, size: target, resume: size, event, stops: false }, watch));
                // The landed step shows where the crossing is, if it is within it, or an earlier one elsewhere.
                let (now, then) = (&self.watch.guards, &watch.guards);
                let again = first_crossing(origin.system, origin.mode, now, then, target, &|| self.method.dense());
                if let Some(earlier) = again.filter(|c| c.site != site && c.theta < 1.0) {
                    let value = watch.guards[earlier.site].value;
                    if value.abs() > self.system.landing_tolerance(earlier.site, origin.mode) {
                        (crossing, whole) = (earlier, target);
                        continue 'site;
                    }
                }
                match again.filter(|c| c.site == site && event.is_none()) {
                    // Beyond a dip that is over.
                    Some(dip) => (low, high) = (0.0, dip.beyond * target),
                    None if value < 0.0 => (past, high) = (landed, target),
                    None if near => (past, low) = (landed, target),
                    None => (short, low) = (landed, target),
                }
                if near || high - low <= 4.0 * f64::EPSILON * high {
                    break;
                }
                // Short of it, it is between here and where a longer step has seen it.
                target = again.map_or(0.5 * (low + high), |c| c.theta * target);
            }
            // Where positions have no digits left to land more exactly, past the event is better than short of it: from
            // short of it the next step would try the same again.
            let Some((accepted, watch)) = past.or(short) else { return Landing::Now(site) };
            self.watch = watch;
            if accepted.size != tried {
                // The method remembers its last attempt: make that the one that is kept.
                self.method.attempt(origin, accepted.size);
                self.counters.rhs += accepted.attempt.rhs;
            }
            return Landing::Done(accepted);
        }
    }

    /// Moves to the end of an accepted step and tells the observer.
    fn take_step<O: Observer<N, Z, Y::Mode>>(
        &mut self,
        linearised: &Linearised<N, Z>,
        accepted: &Accepted<N, Z>,
        stop: f64,
        observer: &mut O,
    ) -> Result<(), Reason> {
        let (t0, start) = (self.clock.now(), self.state);
        self.method.keep();
        if accepted.stops {
            self.clock = Clock::at(stop);
        } else {
            self.clock.advance(accepted.size);
        }
        self.state = accepted.attempt.end;
        self.counters.steps += 1;
        let grown = self.controller.accept(accepted.size, accepted.attempt.error);
        self.h = if accepted.size < accepted.resume { grown.max(accepted.resume) } else { grown };

        let step = Step { t0, t1: self.clock.now(), h: accepted.size, start: &start, end: &self.state };
        let origin = Origin {
            system: self.system,
            mode: &self.mode,
            linearised,
            tolerances: &self.options.tolerances,
            t: t0,
            latest: self.latest,
            state: &start,
        };
        let mut tools = Tools { method: &mut self.method, origin, size: accepted.size, dense: None };
        if !observer.step(&step, &self.mode, &mut tools) {
            return Err(Reason::Stopped);
        }
        if accepted.event.is_none() && self.chatter.over() {
            self.mode = self.system.read_mode(self.clock.now(), &self.state.q, &self.state.v);
            self.refresh_watch();
        } else if let Some(mode) = self.system.relax(&self.watch.guards, &self.mode) {
            self.mode = mode;
            self.refresh_watch();
        }
        Ok(())
    }

    /// Switches the mode where the run stands, and starts anew from there.
    fn apply_event<O: Observer<N, Z, Y::Mode>>(&mut self, site: usize, observer: &mut O) {
        self.mode = self.system.switch(site, &self.state.q, &self.state.v, &self.mode);
        let told = self.system.is_told(site);
        self.announce(site, told, observer);
        if !told {
            return;
        }
        if let Some(first) = self.system.restart_step(site, &self.state.q, &self.state.v, &self.mode) {
            self.h = self.h.min(first);
        }
        self.forget();
    }

    fn announce<O: Observer<N, Z, Y::Mode>>(&mut self, site: usize, told: bool, observer: &mut O) {
        if told {
            self.counters.events += 1;
            observer.event(self.clock.now(), &self.state, site, &self.mode);
        }
        if self.chatter.note(site, self.clock.now()) {
            self.mode = self.system.with_natural(site, &self.mode);
        }
        self.refresh_watch();
    }

    /// Brings contacts to rest that only tremble.
    fn settle(&mut self, t_end: f64) {
        let t = self.clock.now();
        let settled = self.system.settle(t, (&self.state.q, &self.state.v), &self.mode, &self.options.tolerances);
        if let Some(settled) = settled.filter(|settled| self.pace.settles(settled.decay, t_end - t)) {
            (self.state.q, self.state.v) = (settled.q, settled.v);
            self.mode = self.system.read_mode(t, &self.state.q, &self.state.v);
            self.refresh_watch();
            self.forget();
        }
    }

    fn refresh_watch(&mut self) {
        self.watch = self.system.watch(&self.state.q, &self.state.v, &self.mode);
    }

    fn forget(&mut self) {
        self.method.restart();
        self.controller.restart();
    }
}

/// How a landing went.
enum Landing<const N: usize, const Z: usize> {
    Done(Accepted<N, Z>),
    /// A trial step was not accurate enough.
    Refused {
        size: f64,
        error: f64,
    },
    /// The event is where the step starts.
    Now(usize),
}

/// What an observer may ask of the step just taken.
struct Tools<'a, Y: Hybrid<N, Z, S>, K, const N: usize, const Z: usize, const S: usize> {
    method: &'a mut K,
    origin: Origin<'a, Y, N, Z>,
    size: f64,
    dense: Option<super::Dense<N, Z>>,
}

impl<Y: Hybrid<N, Z, S>, K: Method<N, Z>, const N: usize, const Z: usize, const S: usize> StepTools<N, Z>
    for Tools<'_, Y, K, N, Z, S>
{
    fn interpolate(&mut self, theta: f64) -> State<N, Z> {
        self.dense.get_or_insert_with(|| self.method.dense()).at(theta)
    }

    fn resolve(&mut self, theta: f64) -> State<N, Z> {
        let interpolated = self.interpolate(theta);
        let attempt = self.method.attempt(&self.origin, theta * self.size);
        // A part of a step that was good may be none: where friction falls with slip, some size meets the reciprocal of what grows.
        if attempt.error <= WORST_RESOLVED { attempt.end } else { interpolated }
    }
}
