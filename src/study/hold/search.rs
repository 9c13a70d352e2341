//! Search for the limit between loads that are held and loads that fail.

use crate::numeric::elementary::{exp, ln};

/// Result of a run under one load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Held,
    Failed,
    /// The run was not completed.
    Unknown,
}

/// Bracket of the first failure among the evaluated loads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limit {
    /// Largest load below the first failure that is held; `None` if the smallest load fails.
    pub held: Option<f64>,
    /// Smallest load that fails; `None` if no load fails.
    pub failed: Option<f64>,
    /// Largest load above the first failure that is held: the result is not always monotone.
    pub held_above: Option<f64>,
    /// Number of loads between the two, or above the only one, whose run was not completed.
    pub unknown: usize,
}

impl Limit {
    /// Returns the limit from the verdicts, in any order.
    pub(crate) fn from_verdicts(verdicts: impl Iterator<Item = (f64, Verdict)> + Clone) -> Self {
        let loads =
            |required: Verdict| verdicts.clone().filter(move |(_, verdict)| *verdict == required).map(|(load, _)| load);
        let failed = loads(Verdict::Failed).reduce(f64::min);
        let below = |load: &f64| failed.is_none_or(|failed| *load < failed);
        let held = loads(Verdict::Held).filter(below).reduce(f64::max);
        let above = |load: &f64| held.is_none_or(|held| *load > held);
        Limit {
            held,
            failed,
            held_above: loads(Verdict::Held).filter(|load| !below(load)).reduce(f64::max),
            unknown: loads(Verdict::Unknown).filter(|load| below(load) && above(load)).count(),
        }
    }

    /// Returns the geometric mean of the bracket as the next load; `None` if the limit is known to the relative
    /// `tolerance`, if only one end is known, or if a run in between was not completed.
    pub(crate) fn next_load(&self, tolerance: f64) -> Option<f64> {
        let (held, failed) = self.held.zip(self.failed)?;
        (self.unknown == 0 && failed - held > tolerance * failed).then(|| (held * failed).sqrt())
    }
}

/// Returns `count` geometrically spaced loads, with exact ends.
pub(crate) fn geometric_loads(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count - 1;
    let ratio = ln(to / from) / last as f64;
    let load_at = |index: usize| match index {
        0 => from,
        index if index == last => to,
        index => from * exp(ratio * index as f64),
    };
    (0..count).map(load_at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scans and bisects a predicate. Returns the limit and the number of evaluations.
    fn search(scan: &[f64], tolerance: f64, evaluate: impl Fn(f64) -> Verdict) -> (Limit, usize) {
        let mut evaluations: Vec<(f64, Verdict)> = scan.iter().map(|load| (*load, evaluate(*load))).collect();
        while let Some(load) = Limit::from_verdicts(evaluations.iter().copied()).next_load(tolerance) {
            evaluations.push((load, evaluate(load)));
        }
        (Limit::from_verdicts(evaluations.iter().copied()), evaluations.len())
    }

    fn octaves() -> Vec<f64> {
        (0..=10).map(|power| 2f64.powi(power)).collect()
    }

    fn below(limit: f64) -> impl Fn(f64) -> Verdict {
        move |load| if load <= limit { Verdict::Held } else { Verdict::Failed }
    }

    #[test]
    fn limit_is_bracketed_to_the_tolerance() {
        let scan = octaves();
        for limit in [1.0, 1.7, 37.3, 512.0, 1000.0] {
            for tolerance in [0.1, 1e-3, 1e-9] {
                let (found, count) = search(&scan, tolerance, below(limit));
                let (held, failed) = found.held.zip(found.failed).expect("a bracket");
                assert!(held <= limit && limit < failed && failed - held <= tolerance * failed, "{limit}: {found:?}");
                assert_eq!((found.held_above, found.unknown), (None, 0));
                // The bisection starts from one octave of the scan.
                let halvings = (1.0 / tolerance).log2().ceil() as usize;
                assert!(count <= scan.len() + halvings + 1, "{count}");
            }
        }
    }

    #[test]
    fn limit_outside_the_scan_has_one_end_only() {
        let scan = geometric_loads(1.0, 100.0, 5);
        let (found, count) = search(&scan, 0.01, below(1e6));
        assert_eq!((found.held, found.failed, count), (Some(100.0), None, 5));
        let (found, count) = search(&scan, 0.01, below(0.5));
        assert_eq!((found.held, found.failed, count), (None, Some(1.0), 5));
    }

    #[test]
    fn held_loads_above_a_failure_are_reported() {
        // Loads fail in a resonance from 30 to 50, and above 200.
        let resonance = |load: f64| match load {
            load if (30.0..50.0).contains(&load) || load > 200.0 => Verdict::Failed,
            _ => Verdict::Held,
        };
        let (found, _) = search(&octaves(), 1e-3, resonance);
        let (held, failed) = found.held.zip(found.failed).expect("a bracket");
        assert!(held < 30.0 && (30.0..30.1).contains(&failed), "{found:?}");
        assert_eq!(found.held_above, Some(128.0), "{found:?}");
        // Without the resonance, 200 is the first and only limit.
        let (found, _) = search(&octaves(), 1e-3, below(200.0));
        assert!(found.held_above.is_none() && found.held.is_some_and(|held| held > 199.0), "{found:?}");
    }

    #[test]
    fn incomplete_runs_are_neither_held_nor_failed() {
        let incomplete = |load: f64| match load {
            load if (20.0..30.0).contains(&load) => Verdict::Unknown,
            load => below(25.0)(load),
        };
        let (found, count) = search(&octaves(), 1e-6, incomplete);
        assert_eq!((found.held, found.failed, found.unknown), (Some(16.0), Some(32.0), 1), "{found:?}");
        assert_eq!(count, 12, "the bisection ends at the first incomplete run");
        let (found, _) =
            search(&[1.0, 2.0, 4.0], 0.1, |load| if load < 3.0 { Verdict::Held } else { Verdict::Unknown });
        assert_eq!((found.held, found.failed, found.unknown), (Some(2.0), None, 1));
    }

    #[test]
    fn geometric_loads_have_exact_ends() {
        let found = geometric_loads(0.1, 1e3, 9);
        assert_eq!((found[0], found[8], found.len()), (0.1, 1e3, 9));
        assert!(found.windows(2).all(|pair| (pair[1] / pair[0] - 1e4f64.powf(0.125)).abs() < 1e-12), "{found:?}");
        assert_eq!(geometric_loads(2.0, 3.0, 2), [2.0, 3.0]);
    }
}
