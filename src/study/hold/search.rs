//! Limits between what holds and what fails, among loads that were tried.

use crate::numeric::elementary::{exp, ln};

/// What a run said of a load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    Held,
    Failed,
    /// It could not be finished: neither of the two.
    Unknown,
}

/// Where it begins to fail, as far as the loads tried can say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// The largest load below the first failure at which it held; `None` if there is none.
    pub held: Option<f64>,
    /// The smallest load at which it failed; `None` if it never did.
    pub failed: Option<f64>,
    /// The largest load beyond that failure at which it held all the same: more is not always worse.
    pub held_above: Option<f64>,
    /// Loads between the two, or above the one there is, without an answer.
    pub unknown: usize,
}

impl Limit {
    /// What the answers say, in whatever order they came.
    pub fn of(answers: impl Iterator<Item = (f64, Answer)> + Clone) -> Self {
        let loads = |wanted: Answer| answers.clone().filter(move |(_, answer)| *answer == wanted).map(|(load, _)| load);
        let failed = loads(Answer::Failed).reduce(f64::min);
        let below = |load: &f64| failed.is_none_or(|failed| *load < failed);
        let held = loads(Answer::Held).filter(below).reduce(f64::max);
        let above = |load: &f64| held.is_none_or(|held| *load > held);
        Limit {
            held,
            failed,
            held_above: loads(Answer::Held).filter(|load| !below(load)).reduce(f64::max),
            unknown: loads(Answer::Unknown).filter(|load| below(load) && above(load)).count(),
        }
    }

    /// The load that halves what is not known yet, in its logarithm; `None` where it is known to `tolerance` of itself, where only one
    /// end of it is, or where a run between the two could not be finished: halving on would be guessing.
    pub fn next(&self, tolerance: f64) -> Option<f64> {
        let (held, failed) = self.held.zip(self.failed)?;
        (self.unknown == 0 && failed - held > tolerance * failed).then(|| (held * failed).sqrt())
    }
}

/// Loads from one to another, each the same multiple of the one before, both ends exactly.
pub fn ladder(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count - 1;
    let ratio = ln(to / from) / last as f64;
    let step = |index: usize| match index {
        0 => from,
        index if index == last => to,
        index => from * exp(ratio * index as f64),
    };
    (0..count).map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scans and bisects a predicate, and says how often it was asked.
    fn search(scan: &[f64], tolerance: f64, ask: impl Fn(f64) -> Answer) -> (Limit, usize) {
        let mut tried: Vec<(f64, Answer)> = scan.iter().map(|load| (*load, ask(*load))).collect();
        while let Some(load) = Limit::of(tried.iter().copied()).next(tolerance) {
            tried.push((load, ask(load)));
        }
        (Limit::of(tried.iter().copied()), tried.len())
    }

    fn octaves() -> Vec<f64> {
        (0..=10).map(|power| 2f64.powi(power)).collect()
    }

    fn below(limit: f64) -> impl Fn(f64) -> Answer {
        move |load| if load <= limit { Answer::Held } else { Answer::Failed }
    }

    #[test]
    fn a_limit_is_bracketed_as_finely_as_was_asked() {
        let scan = octaves();
        for limit in [1.0, 1.7, 37.3, 512.0, 1000.0] {
            for tolerance in [0.1, 1e-3, 1e-9] {
                let (found, asked) = search(&scan, tolerance, below(limit));
                let (held, failed) = found.held.zip(found.failed).expect("a bracket");
                assert!(held <= limit && limit < failed && failed - held <= tolerance * failed, "{limit}: {found:?}");
                assert_eq!((found.held_above, found.unknown), (None, 0));
                // The octave of the scan, halved in its logarithm.
                let halvings = (1.0 / tolerance).log2().ceil() as usize;
                assert!(asked <= scan.len() + halvings + 1, "{asked}");
            }
        }
    }

    #[test]
    fn what_never_fails_or_always_does_has_one_end_only() {
        let scan = ladder(1.0, 100.0, 5);
        let (found, asked) = search(&scan, 0.01, below(1e6));
        assert_eq!((found.held, found.failed, asked), (Some(100.0), None, 5));
        let (found, asked) = search(&scan, 0.01, below(0.5));
        assert_eq!((found.held, found.failed, asked), (None, Some(1.0), 5));
    }

    #[test]
    fn what_holds_beyond_a_failure_is_said() {
        // Fails in a resonance from 30 to 50, and for good from 200 on.
        let ask = |load: f64| match load {
            load if (30.0..50.0).contains(&load) || load > 200.0 => Answer::Failed,
            _ => Answer::Held,
        };
        let (found, _) = search(&octaves(), 1e-3, ask);
        let (held, failed) = found.held.zip(found.failed).expect("a bracket");
        assert!(held < 30.0 && (30.0..30.1).contains(&failed), "{found:?}");
        assert_eq!(found.held_above, Some(128.0), "{found:?}");
        // Without it, the same limit is the first and only one.
        let (found, _) = search(&octaves(), 1e-3, below(200.0));
        assert!(found.held_above.is_none() && found.held.is_some_and(|held| held > 199.0), "{found:?}");
    }

    #[test]
    fn what_could_not_be_finished_is_neither_held_nor_failed() {
        let ask = |load: f64| match load {
            load if (20.0..30.0).contains(&load) => Answer::Unknown,
            load => below(25.0)(load),
        };
        let (found, asked) = search(&octaves(), 1e-6, ask);
        assert_eq!((found.held, found.failed, found.unknown), (Some(16.0), Some(32.0), 1), "{found:?}");
        assert_eq!(asked, 12, "the first halving has no answer, and nobody guesses on");
        let (found, _) = search(&[1.0, 2.0, 4.0], 0.1, |load| if load < 3.0 { Answer::Held } else { Answer::Unknown });
        assert_eq!((found.held, found.failed, found.unknown), (Some(2.0), None, 1));
    }

    #[test]
    fn ladders_end_where_they_are_told_to() {
        let found = ladder(0.1, 1e3, 9);
        assert_eq!((found[0], found[8], found.len()), (0.1, 1e3, 9));
        assert!(found.windows(2).all(|pair| (pair[1] / pair[0] - 1e4f64.powf(0.125)).abs() < 1e-12), "{found:?}");
        assert_eq!(ladder(2.0, 3.0, 2), [2.0, 3.0]);
    }
}
