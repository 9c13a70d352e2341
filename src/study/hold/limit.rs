//! Outcomes of runs under loads, and the limits between loads that are held and loads that fail.

use phalanx_show::format::object::Object;
use serde::{Serialize, Serializer};

use super::load::{LoadCase, LoadSize};
use super::plan::LoadOutcome;
use crate::criteria::Fate;
use crate::numeric::elementary::{exp, ln, log2};
use crate::statics::MechanismLimit;

/// Outcome of the run under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    pub peak_m_s2: f64,
    pub size: LoadSize,
    /// The outcome, or the reason why the run was not completed.
    pub outcome: Result<LoadOutcome, String>,
}

impl Evaluation {
    /// Whether the object is held at the end, regardless of its slip; `None` if the run was not completed.
    pub fn is_held(&self) -> Option<bool> {
        Some(self.outcome.as_ref().ok()?.fate == Fate::Held)
    }

    /// Whether the object is held at the end and slips by at most `max_slip_m`; `None` if the run was not completed.
    pub fn is_held_within(&self, max_slip_m: f64) -> Option<bool> {
        let outcome = self.outcome.as_ref().ok()?;
        Some(outcome.fate == Fate::Held && outcome.slip.displacement_m <= max_slip_m)
    }
}

/// Serialises the load with the outcome of the run, or nulls and the reason.
impl Serialize for Evaluation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let found = self.outcome.as_ref().ok();
        Object::default()
            .with("peak_m_s2", self.peak_m_s2)
            .with(self.size.key, self.size.value)
            .with("fate", found.map(|found| found.fate.name()))
            .with("slip", found.map(|found| found.slip))
            .with("brake_slip_rad", found.map(|found| found.brake_slip_rad))
            .with("end_s", found.map(|found| found.end_s))
            .with("steps", found.map(|found| found.steps))
            .with("reason", self.outcome.as_ref().err())
            .serialize(serializer)
    }
}

/// Bracket of the first failure, that is, the failure at the smallest load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadBracket {
    /// Largest load below the first failure at which the object is held; `None` if the smallest load fails.
    pub held: Option<f64>,
    /// Smallest load that fails; `None` if no load fails.
    pub failed: Option<f64>,
    /// Largest load that is held although a smaller load fails; `None` if there is none.
    pub held_above: Option<f64>,
    /// Number of loads between `held` and `failed` whose run was not completed; if only one of the two exists, the
    /// number above it.
    pub unknown: usize,
}

impl LoadBracket {
    /// Returns the limit from loads in any order and whether each is held; `None`: the run was not completed.
    pub(super) fn from_loads(all: impl Iterator<Item = (f64, Option<bool>)> + Clone) -> Self {
        let loads = |held: Option<bool>| all.clone().filter(move |(_, found)| *found == held).map(|(load, _)| load);
        let failed = loads(Some(false)).reduce(f64::min);
        let below = |load: &f64| failed.is_none_or(|failed| *load < failed);
        let held = loads(Some(true)).filter(below).reduce(f64::max);
        let above = |load: &f64| held.is_none_or(|held| *load > held);
        LoadBracket {
            held,
            failed,
            held_above: loads(Some(true)).filter(|load| !below(load)).reduce(f64::max),
            unknown: loads(None).filter(|load| below(load) && above(load)).count(),
        }
    }

    /// Returns the geometric mean of the bracket as the next load; `None` if the limit is known to the relative
    /// `tolerance`, if only one end is known, or if a run in between was not completed.
    pub(super) fn next_load(&self, tolerance: f64) -> Option<f64> {
        let (held, failed) = self.held.zip(self.failed)?;
        (self.unknown == 0 && failed - held > tolerance * failed).then(|| (held * failed).sqrt())
    }
}

/// Results for one kind of load.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadResult {
    pub case: LoadCase,
    /// Largest load of the scan: that of the plan, or the largest one that keeps the object clear of the table.
    pub to_m_s2: f64,
    /// Acceleration that can be balanced at rest at the start of the loads; `None` if this kind of load has no such
    /// limit.
    pub static_limit: Option<MechanismLimit>,
    /// Evaluations, sorted by load.
    pub evaluations: Vec<Evaluation>,
    pub slips: LoadBracket,
    pub drops: LoadBracket,
}

impl LoadResult {
    pub(crate) fn evaluation_at(&self, peak_m_s2: f64) -> Option<&Evaluation> {
        self.evaluations.iter().find(|evaluation| evaluation.peak_m_s2 == peak_m_s2)
    }

    /// Returns the size of the largest load below the first failure.
    pub(crate) fn held_size(&self, limit: &LoadBracket) -> Option<LoadSize> {
        Some(self.evaluation_at(limit.held?)?.size)
    }

    /// Returns how the grasp fails at the limit: `slip`, or the fate of the object. `None` if no load fails.
    pub fn ended_by(&self, limit: &LoadBracket) -> Option<&'static str> {
        let run = self.evaluation_at(limit.failed?)?;
        let fate = run.outcome.as_ref().ok()?.fate;
        Some(if run.is_held() == Some(true) { "slip" } else { fate.name() })
    }

    /// Adds evaluations and updates the limits.
    pub(super) fn with_evaluations(mut self, evaluations: Vec<Evaluation>, slip_m: f64) -> Self {
        self.evaluations.extend(evaluations);
        self.evaluations.sort_by(|a, b| a.peak_m_s2.total_cmp(&b.peak_m_s2));
        self.slips =
            LoadBracket::from_loads(self.evaluations.iter().map(|run| (run.peak_m_s2, run.is_held_within(slip_m))));
        self.drops = LoadBracket::from_loads(self.evaluations.iter().map(|run| (run.peak_m_s2, run.is_held())));
        self
    }

    /// Largest number of runs that the refinement of both limits takes.
    pub(super) fn max_bisections(&self, tolerance: f64) -> u64 {
        let bisections = |limit: &LoadBracket| match limit.held.zip(limit.failed) {
            Some((held, failed)) => log2(ln(failed / held) / tolerance).ceil().max(0.0),
            None => 0.0,
        };
        (bisections(&self.slips) + bisections(&self.drops)) as u64
    }
}

/// Serialises the kind of load with its limits and runs. `quasi_static` is `nothing`, `up to` (`quasi_static_m_s2`) or
/// `any`; null for loads that rotate the palm, and where statics has no solution.
impl Serialize for LoadResult {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (quasi_static, quasi_static_m_s2) = match &self.static_limit {
            None => (None, None),
            Some(MechanismLimit::Infeasible { .. }) => (Some("nothing"), None),
            Some(MechanismLimit::Limited { acceleration_m_s2, .. }) => (Some("up to"), Some(*acceleration_m_s2)),
            Some(MechanismLimit::Unlimited) => (Some("any"), None),
        };
        let limit = |limit: &LoadBracket| {
            Object::default()
                .with("held_m_s2", limit.held)
                .with("failed_m_s2", limit.failed)
                .with("held_size", self.held_size(limit))
                .with("ended_by", self.ended_by(limit))
                .with("monotone", limit.held_above.is_none())
                .with("held_above_m_s2", limit.held_above)
                .with("unfinished", limit.unknown)
        };
        let object = self.case.object().with("to_m_s2", self.to_m_s2).with("quasi_static", quasi_static);
        let object = object.with("quasi_static_m_s2", quasi_static_m_s2).with("slips", limit(&self.slips));
        object.with("drops", limit(&self.drops)).with("runs", &self.evaluations).serialize(serializer)
    }
}

/// Returns `count` geometrically spaced loads, with exact ends.
pub(super) fn geometric_loads(from: f64, to: f64, count: usize) -> Vec<f64> {
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
    fn search(scan: &[f64], tolerance: f64, evaluate: impl Fn(f64) -> Option<bool>) -> (LoadBracket, usize) {
        let mut evaluations: Vec<(f64, Option<bool>)> = scan.iter().map(|load| (*load, evaluate(*load))).collect();
        while let Some(load) = LoadBracket::from_loads(evaluations.iter().copied()).next_load(tolerance) {
            evaluations.push((load, evaluate(load)));
        }
        (LoadBracket::from_loads(evaluations.iter().copied()), evaluations.len())
    }

    fn octaves() -> Vec<f64> {
        (0..=10).map(|power| 2f64.powi(power)).collect()
    }

    fn below(limit: f64) -> impl Fn(f64) -> Option<bool> {
        move |load| Some(load <= limit)
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
        let resonance = |load: f64| Some(!(30.0..50.0).contains(&load) && load <= 200.0);
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
        let incomplete = |load: f64| below(25.0)(load).filter(|_| !(20.0..30.0).contains(&load));
        let (found, count) = search(&octaves(), 1e-6, incomplete);
        assert_eq!((found.held, found.failed, found.unknown), (Some(16.0), Some(32.0), 1), "{found:?}");
        assert_eq!(count, 12, "the bisection ends at the first incomplete run");
        let (found, _) = search(&[1.0, 2.0, 4.0], 0.1, |load| (load < 3.0).then_some(true));
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
