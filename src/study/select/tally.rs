//! Number of runs removed by each criterion, and number of runs per class.

use std::cmp::Reverse;
use std::collections::HashSet;

use super::Candidate;
use super::classes::CLASSES;
use super::criteria::{Criterion, Verdict};
use crate::study::sweep::Status;
use crate::study::sweep::{Reason, group_reasons};

/// Counts of one criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    pub criterion: Criterion,
    /// Runs by verdict of this criterion alone.
    pub holds: usize,
    pub fails: usize,
    pub unknown: usize,
    /// Runs that fail only this criterion.
    pub removed_alone: usize,
    /// Runs that meet this criterion and all previous ones.
    pub remaining: usize,
}

impl Tally {
    /// Runs that do not meet this criterion, regardless of the others.
    pub fn removed(&self) -> usize {
        self.fails + self.unknown
    }
}

/// Counts of every criterion.
pub fn tallies(criteria: &[Criterion], verdicts: &[Vec<Verdict>]) -> Vec<Tally> {
    let tally = |index: usize| {
        let count = |verdict: Verdict| verdicts.iter().filter(|run| run[index] == verdict).count();
        let holds = |verdict: &Verdict| *verdict == Verdict::Holds;
        let fails_only_this = |run: &&Vec<Verdict>| {
            !holds(&run[index]) && run.iter().enumerate().all(|(other, verdict)| other == index || holds(verdict))
        };
        Tally {
            criterion: criteria[index].clone(),
            holds: count(Verdict::Holds),
            fails: count(Verdict::Fails),
            unknown: count(Verdict::Unknown),
            removed_alone: verdicts.iter().filter(fails_only_this).count(),
            remaining: verdicts.iter().filter(|run| run[..=index].iter().all(holds)).count(),
        }
    };
    (0..criteria.len()).map(tally).collect()
}

/// Counts of the runs of one condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassCounts {
    pub runs: usize,
    /// Completed runs without a class.
    pub cannot_grasp: usize,
    /// Runs by status, in the order of [`Status::ALL`].
    pub statuses: [usize; 4],
    /// Runs by dynamic class, in the order of [`CLASSES`].
    pub dynamic: [usize; 4],
    pub statically_stable: usize,
    pub statically_unstable: usize,
    pub form_closed: usize,
}

impl ClassCounts {
    /// Number of stable and semi-stable runs.
    pub fn dynamically_stable(&self) -> usize {
        self.dynamic[0] + self.dynamic[1]
    }
}

/// Counts of every condition.
pub fn count_classes(runs: &[Candidate], conditions: usize) -> Vec<ClassCounts> {
    let count_condition = |condition: usize| {
        let members: Vec<&Candidate> = runs.iter().filter(|run| run.condition == condition).collect();
        let count = |test: &dyn Fn(&Candidate) -> bool| members.iter().filter(|run| test(run)).count();
        ClassCounts {
            runs: members.len(),
            cannot_grasp: count(&Candidate::cannot_grasp),
            statuses: Status::ALL.map(|status| count(&|run| run.status == status)),
            dynamic: CLASSES.map(|class| count(&|run| run.class == Some(class))),
            statically_stable: count(&|run| run.force_positive == Some(true)),
            statically_unstable: count(&|run| run.force_positive == Some(false)),
            form_closed: count(&|run| run.form_closed == Some(true)),
        }
    };
    (0..conditions).map(count_condition).collect()
}

/// Reasons for a missing class of completed runs, most frequent first.
pub fn cannot_grasp_reasons(runs: &[Candidate]) -> Vec<Reason> {
    let unclassified = runs.iter().filter(|run| run.cannot_grasp());
    let mut reasons = group_reasons(
        unclassified.filter_map(|run| Some((run.run.unsigned_abs(), run.status.name(), run.reason.as_deref()?))),
    );
    reasons.sort_by_key(|reason| (Reverse(reason.runs), reason.first_run));
    reasons
}

/// Reasons for the classes, best class first, most frequent reason first.
pub fn class_reasons(runs: &[Candidate]) -> Vec<Reason> {
    let mut reasons = group_reasons(
        runs.iter().filter_map(|run| Some((run.run.unsigned_abs(), run.class?.name(), run.class_reason.as_deref()?))),
    );
    let rank = |name: &str| CLASSES.iter().position(|class| class.name() == name);
    reasons.sort_by_key(|reason| (rank(&reason.status), Reverse(reason.runs), reason.first_run));
    reasons
}

/// Run numbers missing between 1 and the largest one.
pub fn missing_runs(runs: &[Candidate]) -> Vec<i64> {
    let present: HashSet<i64> = runs.iter().map(|run| run.run).collect();
    let last = runs.iter().map(|run| run.run).max().unwrap_or(0);
    // Limits the list if a table contains a wrong, very large run number.
    let limit = 1_000_000;
    (1..=last).filter(|run| !present.contains(run)).take(limit).collect()
}
