//! How fast a run gets on, to tell when it gets nowhere.

use super::Tolerances;
use crate::numeric::elementary::{pow, powi};

/// Steps that a run may be about to take before it is asked whether it only resolves a trembling contact, at a relative tolerance of
/// 1e-5; more at finer ones, by this power. Some 50 ms of wall time, and 1 s at the reference's.
const MOST_STEPS: f64 = 3e4;
const FINER: f64 = 0.08;
/// A pace is taken over so many parts of these.
const PARTS: f64 = 100.0;

/// A run that has been lost so often, and nothing else has helped, …
const PATIENCE: u32 = 30;
/// …may take more for noise, by this each time, so often at most: a stiff contact that rests rings from rounding alone, and steps longer
/// than its period damp that, once they are let.
const LOUDER: f64 = 4.0;
const MOST_LOUDER: u32 = 4;

/// A finer run than the everyday one follows a trembling contact so many stretches before it is brought to rest: it is there to tell
/// whether that was right. Not so at the tolerances of the reference, where what is left to follow is noise: it was 7.6e-6 rad off with it.
const CURIOSITY: u32 = 15;
const FINE: std::ops::Range<f64> = 1e-10..3e-6;
/// What would ring on to the end for want of a damper leaves with its last rate at the next impact: 4e-3 rad/s of it were 3.5e-5 rad
/// in the end (scenes/hard/limit-rings-on). Finer runs and the reference follow such a contact for so many stretches, which is
/// longer than a check lets its finer run go on.
const WEARY: u32 = 300;
/// What falls by less than e to this power rings on.
const LASTING: f64 = 3.0;

/// The last stretch of a run.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    most: f64,
    steps: u64,
    time: f64,
    lost: u32,
    curiosity: u32,
    weary: u32,
}

impl Pace {
    pub fn new(tolerances: &Tolerances, time: f64) -> Self {
        Self {
            most: MOST_STEPS * pow(1e-5 / tolerances.rtol_v, FINER),
            steps: 0,
            time,
            lost: 0,
            curiosity: if FINE.contains(&tolerances.rtol_v) { CURIOSITY } else { 0 },
            weary: if tolerances.rtol_v < FINE.end { WEARY } else { 0 },
        }
    }

    /// Whether anything that trembles is to be brought to rest.
    #[inline(always)]
    pub fn may_settle(&self) -> bool {
        self.lost > self.curiosity
    }

    /// Whether that is so of what dies at this rate, with so much time left.
    pub fn settles(&self, decay: f64, left: f64) -> bool {
        decay * left > LASTING || self.lost > self.weary
    }

    /// What steps may take for noise, in parts of what rounding makes.
    #[inline(always)]
    pub fn loudness(&self) -> f64 {
        powi(LOUDER, self.lost.saturating_sub(PATIENCE).min(MOST_LOUDER) as i32)
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
        let lost = ahead > self.most;
        self.lost += u32::from(lost);
        lost
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

    #[test]
    fn what_is_taken_for_noise_grows_only_where_a_run_stays_lost() {
        let mut pace = Pace::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: 1e-5 }, 0.0);
        let mut loudness = Vec::new();
        for stretch in 1..=40u64 {
            assert!(pace.is_lost(300 * stretch, 1e-9 * stretch as f64, 0.02));
            loudness.push(pace.loudness());
        }
        assert!(loudness[..30].iter().all(|loudness| *loudness == 1.0), "{loudness:?}");
        assert_eq!(loudness[30..35], [4.0, 16.0, 64.0, 256.0, 256.0]);
    }

    #[test]
    fn a_finer_run_follows_what_trembles_for_longer() {
        for (rtol, after) in [(1e-5, 1), (1e-7, 16), (1e-9, 16), (1e-11, 1)] {
            let mut pace = Pace::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: rtol }, 0.0);
            let settles = (1..=20u64).find(|stretch| {
                assert!(pace.is_lost(1000 * stretch, 1e-9 * *stretch as f64, 0.02));
                pace.may_settle()
            });
            assert_eq!(settles, Some(after), "rtol {rtol}");
        }
    }

    #[test]
    fn what_would_ring_on_is_brought_to_rest_much_later_than_what_dies_by_itself() {
        for (rtol, weary) in [(1e-5, 0), (1e-7, 300), (1e-12, 300)] {
            let mut pace = Pace::new(&Tolerances { atol_q: 1e-9, atol_v: 1e-5, rtol_v: rtol }, 0.0);
            for stretch in 1..=301u64 {
                assert!(pace.is_lost(5000 * stretch, 1e-9 * stretch as f64, 0.02));
                assert!(pace.settles(400.0, 0.01), "falls by e^4");
                assert_eq!(pace.settles(200.0, 0.01), stretch > weary, "falls by e^2; rtol {rtol}, stretch {stretch}");
            }
        }
    }
}
