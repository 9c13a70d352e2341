//! What each criterion removed, and how many runs each class has.

use std::cmp::Reverse;
use std::collections::HashSet;

use super::Candidate;
use super::classes::CLASSES;
use super::criteria::{Criterion, Verdict};
use crate::study::sweep::Status;
use crate::study::sweep::{Reason, grouped};

/// What one criterion did.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    pub criterion: Criterion,
    /// Runs by verdict, each criterion by itself.
    pub holds: usize,
    pub fails: usize,
    pub unknown: usize,
    /// Runs that only this one removes: they meet every other.
    pub only: usize,
    /// Runs that this one and all before it leave.
    pub left: usize,
}

impl Tally {
    /// Runs that do not meet it, whatever the others say.
    pub fn removes(&self) -> usize {
        self.fails + self.unknown
    }
}

/// One for each criterion.
pub fn tallies(criteria: &[Criterion], verdicts: &[Vec<Verdict>]) -> Vec<Tally> {
    let one = |index: usize| {
        let count = |of: Verdict| verdicts.iter().filter(|run| run[index] == of).count();
        let holds = |verdict: &Verdict| *verdict == Verdict::Holds;
        let only = |run: &&Vec<Verdict>| {
            !holds(&run[index]) && run.iter().enumerate().all(|(other, verdict)| other == index || holds(verdict))
        };
        Tally {
            criterion: criteria[index].clone(),
            holds: count(Verdict::Holds),
            fails: count(Verdict::Fails),
            unknown: count(Verdict::Unknown),
            only: verdicts.iter().filter(only).count(),
            left: verdicts.iter().filter(|run| run[..=index].iter().all(holds)).count(),
        }
    };
    (0..criteria.len()).map(one).collect()
}

/// Runs of one condition, counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Classes {
    pub runs: usize,
    /// Simulated to the end, without a class.
    pub cannot_grasp: usize,
    /// In the order of [`Status::ALL`].
    pub statuses: [usize; 4],
    /// In the order of [`CLASSES`].
    pub dynamic: [usize; 4],
    pub statically_stable: usize,
    pub statically_unstable: usize,
    pub form_closed: usize,
}

impl Classes {
    /// Stable and semi-stable ones.
    pub fn dynamically_stable(&self) -> usize {
        self.dynamic[0] + self.dynamic[1]
    }
}

/// One for each condition.
pub fn classes(runs: &[Candidate], conditions: usize) -> Vec<Classes> {
    let of = |condition: usize| {
        let of: Vec<&Candidate> = runs.iter().filter(|run| run.condition == condition).collect();
        let count = |test: &dyn Fn(&Candidate) -> bool| of.iter().filter(|run| test(run)).count();
        Classes {
            runs: of.len(),
            cannot_grasp: count(&Candidate::cannot_grasp),
            statuses: Status::ALL.map(|status| count(&|run| run.status == status)),
            dynamic: CLASSES.map(|class| count(&|run| run.class == Some(class))),
            statically_stable: count(&|run| run.force_positive == Some(true)),
            statically_unstable: count(&|run| run.force_positive == Some(false)),
            form_closed: count(&|run| run.form_closed == Some(true)),
        }
    };
    (0..conditions).map(of).collect()
}

/// Why completed runs have no class, the most frequent reason first.
pub fn cannot_grasp(runs: &[Candidate]) -> Vec<Reason> {
    let of = runs.iter().filter(|run| run.cannot_grasp());
    let mut found =
        grouped(of.filter_map(|run| Some((run.run.unsigned_abs(), run.status.name(), run.reason.as_deref()?))));
    found.sort_by_key(|reason| (Reverse(reason.runs), reason.first_run));
    found
}

/// What decides the classes, from the best class, the most frequent reason first.
pub fn class_reasons(runs: &[Candidate]) -> Vec<Reason> {
    let mut found = grouped(
        runs.iter().filter_map(|run| Some((run.run.unsigned_abs(), run.class?.name(), run.class_reason.as_deref()?))),
    );
    let rank = |name: &str| CLASSES.iter().position(|class| class.name() == name);
    found.sort_by_key(|reason| (rank(&reason.status), Reverse(reason.runs), reason.first_run));
    found
}

/// Numbers from 1 to the largest that no run has.
pub fn missing(runs: &[Candidate]) -> Vec<i64> {
    let there: HashSet<i64> = runs.iter().map(|run| run.run).collect();
    let last = runs.iter().map(|run| run.run).max().unwrap_or(0);
    // As many numbers may be missing as a table may have rows; a stray huge number is not worth a list of its gaps.
    let most = 1_000_000;
    (1..=last).filter(|run| !there.contains(run)).take(most).collect()
}
