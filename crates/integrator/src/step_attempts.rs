//! Attempted steps, and steps that end on the first event within them.

use super::event_location::{Crossing, Found, SearchMemory, function_inside, search_step};
use super::layout::Layout;
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
pub struct AcceptedStep<L: Layout> {
    pub attempt: Attempt<L>,
    /// Event functions at the end of the step.
    pub events: EventSet<L>,
    pub size: f64,
    /// Acceptable size before the step was shortened. The next step starts from this size.
    pub resume_size: f64,
    pub event: Option<usize>,
    /// Whether the step ends exactly at the stop time.
    pub reaches_stop: bool,
}

/// Number of attempts to locate an event that are kept: the last attempt, the best attempt that ends before the event,
/// and the best one that ends after it.
pub const KEPT_ATTEMPTS: usize = 3;

/// An attempt to locate an event, with the event functions at its end.
#[derive(Clone)]
pub struct LocationAttempt<L: Layout> {
    attempt: Attempt<L>,
    events: EventSet<L>,
}

impl<L: Layout> LocationAttempt<L> {
    /// Creates the memory for an attempt, with as many event functions as `events`.
    pub fn new(layout: L, events: &EventSet<L>) -> Self {
        Self { attempt: Attempt::new(layout), events: events.clone() }
    }
}

/// An attempt that is kept.
#[derive(Clone, Copy)]
struct Candidate {
    /// Index of the attempt.
    index: usize,
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
pub struct StepAttempts<'a, K, L: Layout> {
    pub method: &'a mut K,
    pub counters: &'a mut Counters,
    /// Event functions at the state.
    pub events: &'a EventSet<L>,
    pub memory: &'a mut SearchMemory<L>,
    /// Memory for attempts to locate an event.
    pub kept: &'a mut [LocationAttempt<L>; KEPT_ATTEMPTS],
}

impl<L: Layout, K: Method<L>> StepAttempts<'_, K, L> {
    /// Attempts a step; its error includes the error weights of active contacts.
    #[inline(always)]
    pub fn attempt<Y: Hybrid<Layout = L>>(&mut self, origin: &StepStart<Y>, size: f64, attempt: &mut Attempt<L>) {
        attempt_step(self.method, self.counters, self.events, origin, size, attempt);
    }

    /// Repeats a step of `size` until it ends on the event, and stores the step in `found`. If an earlier event is
    /// found on the way, that event is located instead.
    pub fn locate_event<Y: Hybrid<Layout = L>>(
        &mut self,
        origin: &StepStart<Y>,
        mut crossing: Crossing,
        size: f64,
        found: &mut AcceptedStep<L>,
    ) -> EventLocation {
        let system = origin.system;
        let mut full_size = size;
        'crossing: loop {
            let event_index = crossing.event_index;
            let tolerance = system.event_tolerance(event_index, origin.mode);
            let (mut low, mut high) = (0.0, crossing.negative_at * full_size);
            let mut target = crossing.theta * full_size;
            // The earliest step found that ends past the event, and the last one that ends before it.
            let (mut after_event, mut before_event): (Option<Candidate>, Option<Candidate>) = (None, None);
            let mut last_size = 0.0;
            for _ in 0..MAX_LOCATION_ATTEMPTS {
                if target < MIN_STEP_S {
                    break;
                }
                let is_kept = |index: usize| {
                    [after_event, before_event].into_iter().flatten().any(|candidate| candidate.index == index)
                };
                let free = (0..KEPT_ATTEMPTS - 1).find(|index| !is_kept(*index)).unwrap_or(KEPT_ATTEMPTS - 1);
                let LocationAttempt { attempt, events } = &mut self.kept[free];
                attempt_step(self.method, self.counters, self.events, origin, target, attempt);
                last_size = target;
                self.counters.rejected += 1;
                if !attempt.is_acceptable() {
                    return EventLocation::Rejected { size: target, error: attempt.error };
                }
                system.eval_events(&attempt.end.q, &attempt.end.v, origin.mode, events);
                if error_weight::unloads(self.events, events, attempt, origin.state, origin.tolerances) {
                    return EventLocation::Rejected { size: target, error: f64::INFINITY };
                }
                let value = events.functions[event_index].value;
                let is_within_tolerance = value.abs() <= tolerance;
                let event = (is_within_tolerance || value < 0.0).then_some(event_index);
                // The shortened step may contain the crossing, or an earlier crossing of another event function.
                let ends = [origin.state, &attempt.end];
                let of_step = (system, origin.mode, &*self.method);
                let recheck = match search_step(of_step, [self.events, &*events], (ends, target), self.memory) {
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
                let candidate = Some(Candidate { index: free, size: target, event });
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
                        let of_step = (system, origin.mode, &*self.method);
                        let before = function_inside(of_step, event_index, 1.0 - LAST_PART, self.memory).value;
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
                self.method.attempt(origin, accepted.size, &mut found.attempt);
                self.counters.rhs += found.attempt.rhs;
            }
            let LocationAttempt { attempt, events } = &mut self.kept[accepted.index];
            std::mem::swap(&mut found.attempt, attempt);
            std::mem::swap(&mut found.events, events);
            (found.size, found.event) = (accepted.size, accepted.event);
            (found.resume_size, found.reaches_stop) = (size, false);
            return EventLocation::Located;
        }
    }
}

/// Attempts a step; its error includes the error weights of active contacts at its start.
#[inline(always)]
fn attempt_step<Y: Hybrid, K: Method<Y::Layout>>(
    method: &mut K,
    counters: &mut Counters,
    events: &EventSet<Y::Layout>,
    origin: &StepStart<Y>,
    size: f64,
    attempt: &mut Attempt<Y::Layout>,
) {
    method.attempt(origin, size, attempt);
    counters.rhs += attempt.rhs;
    if attempt.is_acceptable() {
        attempt.error = attempt.error.max(error_weight::error(events, attempt, origin.state, origin.tolerances));
    }
}

/// Collects the other event functions that reach zero, within their tolerances, at the end of a step. Both fingers of a
/// symmetric gripper have such simultaneous events.
pub fn simultaneous_events<Y: Hybrid>(
    system: &Y,
    mode: &Y::Mode,
    event_index: usize,
    [at_start, at_end]: [&EventSet<Y::Layout>; 2],
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
