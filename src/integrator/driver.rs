//! The integration loop: steps, landings on events, mode changes, ends.

use super::control::Controller;
use super::landing::first_crossing;
use super::method::{Attempt, Method};
use super::{Dense, Hybrid, State, Tolerances};

/// How to integrate.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    pub tolerances: Tolerances,
    /// Budget of accepted steps.
    pub max_steps: u64,
    /// Longest step.
    pub max_step_s: f64,
}

/// What an integration cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    pub steps: u64,
    pub rejected: u64,
    pub rhs: u64,
    pub jacobians: u64,
    pub events: u64,
}

/// Why an integration ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    #[error("the step size fell to {h_s:.1e} s: the accuracy asked for cannot be reached here; loosen the tolerances")]
    StepUnderflow { h_s: f64 },
    #[error("the right-hand side is not finite")]
    NotFinite,
    #[error("{0}")]
    Obstacle(String),
    #[error("the budget of {0} steps is used up; raise `max_steps` or shorten the run")]
    Budget(u64),
    #[error("the observer asked to stop")]
    Stopped,
}

/// An integration that could not be completed, and where it stood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("at t = {time_s:.9} s: {reason}")]
pub struct Failure {
    pub time_s: f64,
    pub reason: Reason,
}

/// Watches an integration.
pub trait Observer<const N: usize, const Z: usize, M> {
    /// An accepted step, taken in `mode`. `false` ends the integration.
    ///
    /// `resolve` gives the state at a fraction of the step by a step of its own from the same start. Angles may be read off
    /// the dense output; a stiff damper's force needs the rates of a proper end of step.
    fn step(&mut self, dense: &Dense<N, Z>, mode: &M, resolve: &mut dyn FnMut(f64) -> State<N, Z>) -> bool;

    /// An event at `site`, at the end of the step just reported.
    fn event(&mut self, t: f64, state: &State<N, Z>, site: usize, mode: &M);
}

impl<const N: usize, const Z: usize, M> Observer<N, Z, M> for () {
    #[inline(always)]
    fn step(&mut self, _: &Dense<N, Z>, _: &M, _: &mut dyn FnMut(f64) -> State<N, Z>) -> bool {
        true
    }

    fn event(&mut self, _: f64, _: &State<N, Z>, _: usize, _: &M) {}
}

/// Events within this time of each other count as chatter…
const CHATTER_S: f64 = 1e-9;
/// …and after this many of them at one site, one step is left to the natural branches.
const CHATTER_EVENTS: u32 = 6;
/// First step of all, and after a jump of the right-hand side.
const FIRST_STEP_S: f64 = 1e-8;
const SMALLEST_STEP_S: f64 = 1e-21;
const MAX_LANDINGS: usize = 8;

/// Integrates from `t0` to `t_end`, with every event located. Returns the final state and what it cost.
pub fn integrate<const N: usize, const Z: usize, const S: usize, Y, K, O>(
    system: &Y,
    options: &Options,
    t0: f64,
    start: State<N, Z>,
    t_end: f64,
    observer: &mut O,
) -> (State<N, Z>, Counters, Result<(), Failure>)
where
    Y: Hybrid<N, Z, S>,
    K: Method<N, Z>,
    O: Observer<N, Z, Y::Mode>,
{
    let mut count = Counters::default();
    let mut method = K::new();
    let mut controller = Controller::new(K::ERROR_ORDER);
    let (mut t, mut state) = (t0, start);
    let mut mode = system.read_mode(t, &state.q, &state.v);
    let mut h = FIRST_STEP_S.min(options.max_step_s);
    let mut chatter = [(f64::NEG_INFINITY, 0u32); S];
    let fail = |time_s, reason| Err(Failure { time_s, reason });

    'run: while t < t_end {
        if let Some(text) = system.obstacle(&state.q) {
            return (state, count, fail(t, Reason::Obstacle(text)));
        }
        if count.steps >= options.max_steps {
            return (state, count, fail(t, Reason::Budget(options.max_steps)));
        }
        let lin = system.linearise(t, &state.q, &state.v, &mode);
        count.jacobians += 1;
        if !lin.rates.a.iter().all(|a| a.is_finite()) {
            return (state, count, fail(t, Reason::NotFinite));
        }
        let corner = system.next_corner(t);
        let stop = corner.min(t_end);
        let mut try_step = |h: f64, count: &mut Counters| -> Attempt<N, Z> {
            let attempt = method.attempt(system, &mode, &lin, t, &state, h, &options.tolerances);
            count.rhs += attempt.rhs;
            attempt
        };

        // A step whose error is acceptable, cut short at the first event within it.
        let wanted = h;
        h = h.min(options.max_step_s);
        let (mut attempt, mut clipped);
        let mut event = None;
        'step: loop {
            // A step that would leave a sliver before the stop takes the sliver along.
            clipped = t + 1.0001 * h >= stop;
            let size = if clipped { stop - t } else { h };
            if size < SMALLEST_STEP_S || t + size == t {
                return (state, count, fail(t, Reason::StepUnderflow { h_s: size }));
            }
            attempt = try_step(size, &mut count);
            // Written so that a step that is not a number is refused too.
            if !(attempt.error <= 1.0) {
                count.rejected += 1;
                h = controller.reject(size, attempt.error);
                continue;
            }
            let Some(found) = first_crossing(system, &mode, &attempt.dense) else {
                break;
            };
            let (mut low, mut high) = (0.0, attempt.dense.h);
            let mut target = found.theta * attempt.dense.h;
            let mut landed = None;
            for _ in 0..MAX_LANDINGS {
                if target < SMALLEST_STEP_S || t + target == t {
                    break;
                }
                let trial = try_step(target, &mut count);
                count.rejected += 1;
                if !(trial.error <= 1.0) {
                    h = controller.reject(target, trial.error);
                    continue 'step;
                }
                let end = trial.dense.end;
                let value = system.guards(t + target, &end.q, &end.v, &mode)[found.site].value;
                let near = value.abs() <= system.landing_tolerance(found.site, &mode);
                let crossed = near || value < 0.0;
                if value < 0.0 {
                    high = target
                } else {
                    low = target
                }
                // The landed step shows where the crossing is, if it is within it.
                target = match first_crossing(system, &mode, &trial.dense) {
                    Some(again) => again.theta * target,
                    None => 0.5 * (low + high),
                };
                landed = Some((trial, crossed));
                if near || high - low <= 4.0 * f64::EPSILON * high.max(t) {
                    break;
                }
            }
            match landed {
                Some((trial, crossed)) => {
                    clipped = false;
                    attempt = trial;
                    event = crossed.then_some(found.site);
                    break;
                }
                // The event is here and now: no time passes.
                None => {
                    mode = system.switch(found.site, &mode);
                    count.events += 1;
                    observer.event(t, &state, found.site, &mode);
                    settle_chatter(system, &mut chatter, found.site, t, &mut mode);
                    method.restart();
                    controller.restart();
                    continue 'run;
                }
            }
        }

        let dense = attempt.dense;
        method.kept();
        let mut resolve = |theta: f64| {
            let part = method.attempt(
                system,
                &mode,
                &lin,
                dense.t0,
                &dense.start,
                theta * dense.h,
                &options.tolerances,
            );
            if part.error.is_finite() {
                part.dense.end
            } else {
                dense.at(theta)
            }
        };
        let going_on = observer.step(&dense, &mode, &mut resolve);
        count.steps += 1;
        t = if clipped { stop } else { dense.end_time() };
        state = dense.end;
        let grown = controller.accept(dense.h, attempt.error);
        h = if clipped && event.is_none() {
            wanted.max(grown)
        } else {
            grown
        };
        if !going_on {
            return (state, count, fail(t, Reason::Stopped));
        }
        for (_, repeats) in chatter.iter_mut() {
            if *repeats > CHATTER_EVENTS {
                *repeats = 0;
                mode = system.read_mode(t, &state.q, &state.v);
            }
        }
        mode = system.relax(&state.q, &mode);
        if let Some(site) = event {
            mode = system.switch(site, &mode);
            count.events += 1;
            observer.event(t, &state, site, &mode);
            settle_chatter(system, &mut chatter, site, t, &mut mode);
            if let Some(first) = system.restart_step(site, &state.q, &state.v, &mode) {
                h = first;
            }
            method.restart();
            controller.restart();
        } else if clipped && t == corner {
            h = FIRST_STEP_S;
            method.restart();
            controller.restart();
        }
    }
    (state, count, Ok(()))
}

/// Counts events that follow each other without delay; too many, and the site is left to its natural branches for a step.
fn settle_chatter<const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>>(
    system: &Y,
    chatter: &mut [(f64, u32); S],
    site: usize,
    t: f64,
    mode: &mut Y::Mode,
) {
    let (last, repeats) = &mut chatter[site];
    *repeats = if t - *last <= CHATTER_S { *repeats + 1 } else { 0 };
    *last = t;
    if *repeats > CHATTER_EVENTS {
        *mode = system.with_natural(site, true, mode);
    }
}
