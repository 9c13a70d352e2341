//! Attempted steps, and steps that end on the first event within them.

use super::event_location::{Crossing, Found, SearchMemory, search_step};
use super::method::{Attempt, Method, StepStart};
use super::{Counters, EventSet, Hybrid, error_weight};

/// Below this size, a step counts as collapsed.
pub const MIN_STEP_S: f64 = 1e-22;
/// Last part of a step, over which the rate of an event function is measured.
const LAST_PART: f64 = 0.05;
/// Ratio of a step that is extrapolated to an event to the distance of the event, so that it ends just past the event.
const OVERSHOOT: f64 = 1.01;
/// Maximum number of attempts to locate one event.
const MAX_LOCATION_ATTEMPTS: usize = 12;

/// A step that satisfies the tolerances.
#[derive(Clone)]
pub struct AcceptedStep<const N: usize, const Z: usize> {
    pub attempt: Attempt<N, Z>,
    /// Event functions at its end.
    pub events: EventSet<N>,
    pub size: f64,
    /// Acceptable size before the step was shortened; the next step starts from it.
    pub resume_size: f64,
    pub event: Option<usize>,
    /// Whether the step ends exactly at the stop time.
    pub reaches_stop: bool,
}

/// Number of attempts to locate an event whose event functions are kept: the last one, and the best ones that end before and
/// after the event.
pub const ATTEMPTED_EVENTS: usize = 3;

/// An attempt to locate an event.
struct Candidate<const N: usize, const Z: usize> {
    attempt: Attempt<N, Z>,
    /// Index of its event functions.
    events: usize,
    size: f64,
    event: Option<usize>,
}

/// Result of an event location.
pub enum EventLocation {
    Located,
    /// An attempted step was not accurate enough.
    Rejected {
        size: f64,
        error: f64,
    },
    /// The event with this index occurs at the start of the step.
    AtStart(usize),
}

/// Attempts steps from one state.
pub struct StepAttempts<'a, K, const N: usize> {
    pub method: &'a mut K,
    pub counters: &'a mut Counters,
    /// Event functions at the state.
    pub events: &'a EventSet<N>,
    pub memory: &'a mut SearchMemory,
    /// Memory for the event functions of attempts to locate an event.
    pub attempted_events: &'a mut [EventSet<N>; ATTEMPTED_EVENTS],
}

impl<const N: usize, K> StepAttempts<'_, K, N> {
    /// Attempts a step; its error includes the error weights of active contacts.
    #[inline(always)]
    pub fn attempt<const Z: usize, Y: Hybrid<N, Z>>(&mut self, origin: &StepStart<Y, N, Z>, size: f64) -> Attempt<N, Z>
    where
        K: Method<N, Z>,
    {
        let mut attempt = self.method.attempt(origin, size);
        self.counters.rhs += attempt.rhs;
        if attempt.is_acceptable() {
            attempt.error =
                attempt.error.max(error_weight::error(self.events, &attempt, origin.state, origin.tolerances));
        }
        attempt
    }

    /// Repeats a step of `size` until it ends on the event, and stores it in `found`. If an earlier event is found on the way,
    /// locates that one instead.
    pub fn locate_event<const Z: usize, Y: Hybrid<N, Z>>(
        &mut self,
        origin: &StepStart<Y, N, Z>,
        mut crossing: Crossing,
        size: f64,
        found: &mut AcceptedStep<N, Z>,
    ) -> EventLocation
    where
        K: Method<N, Z>,
    {
        let system = origin.system;
        let mut full_size = size;
        'crossing: loop {
            let event_index = crossing.event_index;
            let tolerance = system.event_tolerance(event_index, origin.mode);
            let (mut low, mut high) = (0.0, crossing.negative_at * full_size);
            let mut target = crossing.theta * full_size;
            // The earliest step found that ends past the event, and the last one that ends before it.
            let (mut after_event, mut before_event): (Option<Candidate<N, Z>>, Option<Candidate<N, Z>>) = (None, None);
            let mut last_size = 0.0;
            for _ in 0..MAX_LOCATION_ATTEMPTS {
                if target < MIN_STEP_S {
                    break;
                }
                let attempt = self.attempt(origin, target);
                last_size = target;
                self.counters.rejected += 1;
                if !attempt.is_acceptable() {
                    return EventLocation::Rejected { size: target, error: attempt.error };
                }
                let is_kept = |index: usize| {
                    [&after_event, &before_event].into_iter().flatten().any(|candidate| candidate.events == index)
                };
                let free = (0..ATTEMPTED_EVENTS - 1).find(|index| !is_kept(*index)).unwrap_or(ATTEMPTED_EVENTS - 1);
                let events = &mut self.attempted_events[free];
                system.eval_events(&attempt.end.q, &attempt.end.v, origin.mode, events);
                if error_weight::unloads(self.events, events, &attempt, origin.state, origin.tolerances) {
                    return EventLocation::Rejected { size: target, error: f64::INFINITY };
                }
                let value = events.functions[event_index].value;
                let is_within_tolerance = value.abs() <= tolerance;
                let event = (is_within_tolerance || value < 0.0).then_some(event_index);
                // The shortened step may contain the crossing, or an earlier crossing of another event function.
                let dense = || self.method.dense(None);
                let ends = [origin.state, &attempt.end];
                let output = (dense, || self.method.dense_positions());
                let both = [self.events, &*events];
                let recheck = match search_step(system, origin.mode, both, (ends, target), &output, self.memory) {
                    Found::Nothing => None,
                    Found::Crossing(crossing) => Some(crossing),
                    Found::Obstacle | Found::Unresolved => {
                        return EventLocation::Rejected { size: target, error: f64::INFINITY };
                    }
                };
                if let Some(earlier) = recheck.filter(|c| c.event_index != event_index && c.theta < 1.0) {
                    let value = events.functions[earlier.event_index].value;
                    if value.abs() > system.event_tolerance(earlier.event_index, origin.mode) {
                        (crossing, full_size) = (earlier, target);
                        continue 'crossing;
                    }
                }
                let candidate = Some(Candidate { attempt, events: free, size: target, event });
                match recheck.filter(|c| c.event_index == event_index && event.is_none()) {
                    // The step ends after a dip.
                    Some(dip) => (low, high) = (0.0, dip.negative_at * target),
                    None if value < 0.0 => (after_event, high) = (candidate, target),
                    None if is_within_tolerance => (after_event, low) = (candidate, target),
                    None => (before_event, low) = (candidate, target),
                }
                if is_within_tolerance || high - low <= 4.0 * f64::EPSILON * high {
                    break;
                }
                // If the step ends before the event, extrapolate, at most to the middle between its end and the end of a
                // longer step that contains the event.
                let middle = 0.5 * (low + high);
                target = match recheck {
                    Some(crossing) => crossing.theta * target,
                    None => {
                        let (q, v) = dense().motion(1.0 - LAST_PART);
                        let before = system.eval_event(&q, &v, origin.mode, event_index).value;
                        let next = target * (1.0 + OVERSHOOT * LAST_PART * value / (before - value));
                        if before > value && next < middle { next } else { middle }
                    }
                };
            }
            // If rounding prevents a closer step, one that ends past the event is better: after one that ends before
            // it, the next step would repeat the search.
            let Some(accepted) = after_event.or(before_event) else {
                return EventLocation::AtStart(event_index);
            };
            if accepted.size != last_size {
                // The method stores its last attempt; repeat the accepted one.
                self.method.attempt(origin, accepted.size);
                self.counters.rhs += accepted.attempt.rhs;
            }
            std::mem::swap(&mut found.events, &mut self.attempted_events[accepted.events]);
            (found.attempt, found.size, found.event) = (accepted.attempt, accepted.size, accepted.event);
            (found.resume_size, found.reaches_stop) = (size, false);
            return EventLocation::Located;
        }
    }
}

/// Collects the other event functions that reach zero at the end of a step, within their tolerances, as those of both fingers of a
/// symmetric gripper.
pub fn simultaneous_events<const N: usize, const Z: usize, Y: Hybrid<N, Z>>(
    system: &Y,
    mode: &Y::Mode,
    event_index: usize,
    [at_start, at_end]: [&EventSet<N>; 2],
    found: &mut Vec<usize>,
) {
    let is_simultaneous = |index: &usize| {
        let tolerance = system.event_tolerance(*index, mode);
        let values = [at_start, at_end].map(|events| events.functions[*index].value);
        *index != event_index && values[0] > tolerance && values[1].abs() <= tolerance
    };
    found.clear();
    found.extend((0..at_end.functions.len()).filter(is_simultaneous));
}
