//! How fast a run gets on, to tell when it gets nowhere.

use super::Tolerances;

/// Steps that a run may be about to take before it is asked whether it only resolves a trembling contact, at a relative tolerance of
/// 1e-5; more at finer ones, by this power. Some 50 ms of wall time, and 1 s at the reference's.
const MOST_STEPS: f64 = 3e4;
const FINER: f64 = 0.08;
/// A pace is taken over so many parts of these.
const PARTS: f64 = 100.0;

/// The last stretch of a run.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    most: f64,
    steps: u64,
    time: f64,
}

impl Pace {
    pub fn new(tolerances: &Tolerances, time: f64) -> Self {
        Self { most: MOST_STEPS * (1e-5 / tolerances.rtol_v).powf(FINER), steps: 0, time }
    }

    /// Whether the run, going on as in its last stretch, would take too many steps; asked once a stretch.
    #[inline(always)]
    pub fn is_lost(&mut self, steps: u64, time: f64, end: f64) -> bool {
        let taken = (steps - self.steps) as f64;
        if taken * PARTS < self.most {
            return false;
        }
        let ahead = taken * (end - time) / (time - self.time);
        (self.steps, self.time) = (steps, time);
        ahead > self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_lost_if_its_pace_would_never_bring_it_to_its_end() {
        let tolerances = Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 };
        let mut pace = Pace::new(&tolerances, 0.0);
        assert!(!pace.is_lost(299, 1e-9, 0.02), "too early to tell");
        assert!(pace.is_lost(300, 1e-9, 0.02));
        assert!(!pace.is_lost(500, 2e-9, 0.02), "the next stretch has just begun");
        assert!(!pace.is_lost(600, 0.01, 0.02), "half the way in 300 steps");
    }
}
