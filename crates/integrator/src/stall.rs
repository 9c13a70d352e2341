//! Detection of stalled runs, whose steps have become too short to reach the end, and of chattering events.

use super::{Counters, Tolerances};
use crate::numeric::elementary::{pow, powi};

/// Number of remaining steps above which a run counts as stalled, at a relative tolerance of 1e-5: about 50 ms of wall
/// time, and 1 s at the tolerances of the reference.
const MAX_REMAINING_STEPS: f64 = 3e4;
/// Exponent of the growth of [`MAX_REMAINING_STEPS`] at finer tolerances.
const MAX_STEPS_EXPONENT: f64 = 0.08;
/// Ratio of [`MAX_REMAINING_STEPS`] to the number of steps over which progress is measured.
const WINDOWS_PER_LIMIT: f64 = 100.0;

/// Number of stalls after which the noise scale grows. Rounding alone makes a stiff contact at rest oscillate; steps
/// longer than its period damp this oscillation once the tolerance admits them.
const MAX_STALLS_BEFORE_NOISE: u32 = 30;
/// Growth factor of the noise scale with each further stall.
const NOISE_GROWTH: f64 = 4.0;
/// Maximum number of increases of the noise scale.
const MAX_NOISE_EXPONENT: u32 = 4;

/// Number of stalls before a run at finer than default tolerances projects an oscillating contact: such a run verifies
/// the projection. At the tolerances of the reference, the remaining oscillation is noise: resolving it caused an error
/// of 7.6e-6 rad.
const MAX_STALLS_FINE: u32 = 15;
/// Relative tolerances at which [`MAX_STALLS_FINE`] applies.
const FINE_TOLERANCES: std::ops::Range<f64> = 1e-10..3e-6;
/// Number of stalls before finer runs and the reference project a contact whose oscillation persists for lack of
/// damping; this is longer than a check allows its finer run. Such a contact leaves with its last rate at the next
/// impact: 4e-3 rad/s caused 3.5e-5 rad at the end (scenes/hard/limit-rings-on).
const MAX_STALLS_UNDAMPED: u32 = 300;
/// An oscillation persists if it decays by less than e to this power until the end.
const MIN_DECAY: f64 = 3.0;

/// Progress of a run over its last window of steps.
#[derive(Clone, Copy, Debug)]
pub struct StallDetector {
    max_remaining_steps: f64,
    steps: u64,
    events: u64,
    time: f64,
    stalls: u32,
    /// Whether steps and events of stalls are left out of the progress.
    omits_stalls: bool,
    /// Steps and events of windows in which the run was stalled.
    stalled: [u64; 2],
    max_stalls: u32,
    max_stalls_undamped: u32,
}

impl StallDetector {
    pub fn new(tolerances: &Tolerances, time: f64) -> Self {
        Self {
            max_remaining_steps: MAX_REMAINING_STEPS * pow(1e-5 / tolerances.rtol_v, MAX_STEPS_EXPONENT),
            steps: 0,
            events: 0,
            time,
            stalls: 0,
            omits_stalls: tolerances.rtol_v >= FINE_TOLERANCES.end,
            stalled: [0; 2],
            max_stalls: if FINE_TOLERANCES.contains(&tolerances.rtol_v) { MAX_STALLS_FINE } else { 0 },
            max_stalls_undamped: if tolerances.rtol_v < FINE_TOLERANCES.end { MAX_STALLS_UNDAMPED } else { 0 },
        }
    }

    /// Steps and events that tighten the tolerances of the run. At default tolerances those of stalls do not: a stalled run
    /// leaves its oscillation by chance, which finer tolerances would prevent.
    #[inline(always)]
    pub(crate) fn progress(&self, counters: &Counters) -> [u64; 2] {
        [counters.steps - self.stalled[0], counters.events - self.stalled[1]]
    }

    /// Whether oscillating contacts may be projected onto their equilibrium.
    #[inline(always)]
    pub(crate) fn may_project(&self) -> bool {
        self.stalls > self.max_stalls
    }

    /// Whether to project a contact whose oscillation decays at this rate, given the remaining time.
    pub(crate) fn should_project(&self, decay_rate: f64, remaining_time: f64) -> bool {
        decay_rate * remaining_time > MIN_DECAY || self.stalls > self.max_stalls_undamped
    }

    /// Noise level that steps may assume, relative to rounding noise.
    #[inline(always)]
    pub(crate) fn noise_scale(&self) -> f64 {
        powi(NOISE_GROWTH, self.stalls.saturating_sub(MAX_STALLS_BEFORE_NOISE).min(MAX_NOISE_EXPONENT) as i32)
    }

    /// Whether the run would need too many steps at the rate of its last window. Evaluated once per window.
    #[inline(always)]
    pub(crate) fn is_stalled(&mut self, counters: &Counters, time: f64, end: f64) -> bool {
        let passed = [counters.steps - self.steps, counters.events - self.events];
        let steps_taken = passed[0] as f64;
        if steps_taken * WINDOWS_PER_LIMIT < self.max_remaining_steps {
            return false;
        }
        let remaining_steps = steps_taken * (end - time) / (time - self.time);
        (self.steps, self.events, self.time) = (counters.steps, counters.events, time);
        let stalled = remaining_steps > self.max_remaining_steps;
        self.stalls += u32::from(stalled);
        if stalled && self.omits_stalls {
            self.stalled = [self.stalled[0] + passed[0], self.stalled[1] + passed[1]];
        }
        stalled
    }
}

/// Largest time between consecutive events of one event function that counts as chattering.
const MAX_SPACING_S: f64 = 1e-15;
/// Number of rapid events after which one step uses the clamped law.
const MAX_RAPID_EVENTS: u32 = 6;

/// Detects chattering: events that trigger each other without progress in time. It is detected from rapid events of a
/// single event function.
#[derive(Clone, Debug)]
pub struct Chatter {
    recent: Vec<(f64, u32)>,
    is_clamped: bool,
}

impl Chatter {
    /// Creates a detector for `count` event functions.
    pub fn new(count: usize) -> Self {
        Self { recent: vec![(f64::NEG_INFINITY, 0); count], is_clamped: false }
    }

    /// Records an event. Returns whether the next step should use the clamped law of the contact to which this event
    /// function belongs.
    pub fn record(&mut self, index: usize, t: f64) -> bool {
        let (last, count) = &mut self.recent[index];
        *count = if t - *last <= MAX_SPACING_S { *count + 1 } else { 0 };
        *last = t;
        let is_chattering = *count >= MAX_RAPID_EVENTS;
        if is_chattering {
            *count = 0;
            self.is_clamped = true;
        }
        is_chattering
    }

    /// Whether the step just taken used a clamped law; resets the flag.
    pub(crate) fn take_clamped(&mut self) -> bool {
        std::mem::take(&mut self.is_clamped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after_steps(steps: u64) -> Counters {
        Counters { steps, ..Counters::default() }
    }

    #[test]
    fn a_run_stalls_if_it_would_need_too_many_steps() {
        let tolerances = Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 };
        let mut detector = StallDetector::new(&tolerances, 0.0);
        assert!(!detector.is_stalled(&after_steps(299), 1e-9, 0.02), "the first window is incomplete");
        assert!(detector.is_stalled(&after_steps(300), 1e-9, 0.02));
        assert!(!detector.is_stalled(&after_steps(500), 2e-9, 0.02), "the second window is incomplete");
        assert!(!detector.is_stalled(&after_steps(600), 0.01, 0.02), "half of the time in 300 steps");
        assert_eq!(detector.progress(&after_steps(700)), [400, 0], "without the first window");
    }

    #[test]
    fn noise_scale_grows_only_after_repeated_stalls() {
        let mut detector = StallDetector::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 }, 0.0);
        let mut noise_scales = Vec::new();
        for window in 1..=40u64 {
            assert!(detector.is_stalled(&after_steps(300 * window), 1e-9 * window as f64, 0.02));
            noise_scales.push(detector.noise_scale());
        }
        assert!(noise_scales[..30].iter().all(|noise_scale| *noise_scale == 1.0), "{noise_scales:?}");
        assert_eq!(noise_scales[30..35], [4.0, 16.0, 64.0, 256.0, 256.0]);
    }

    #[test]
    fn finer_runs_project_oscillating_contacts_later() {
        for (rtol, after) in [(1e-5, 1), (1e-7, 16), (1e-9, 16), (1e-11, 1)] {
            let mut detector = StallDetector::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: rtol }, 0.0);
            let first_projection = (1..=20u64).find(|window| {
                assert!(detector.is_stalled(&after_steps(1000 * window), 1e-9 * *window as f64, 0.02));
                detector.may_project()
            });
            assert_eq!(first_projection, Some(after), "rtol {rtol}");
        }
    }

    #[test]
    fn persistent_oscillations_are_projected_much_later_than_decaying_ones() {
        for (rtol, max_stalls_undamped) in [(1e-5, 0), (1e-7, 300), (1e-12, 300)] {
            let mut detector = StallDetector::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: rtol }, 0.0);
            for window in 1..=301u64 {
                assert!(detector.is_stalled(&after_steps(5000 * window), 1e-9 * window as f64, 0.02));
                assert!(detector.should_project(400.0, 0.01), "decays by e^4");
                assert_eq!(
                    detector.should_project(200.0, 0.01),
                    window > max_stalls_undamped,
                    "decays by e^2; rtol {rtol}, window {window}"
                );
            }
        }
    }
}
