//! Selection of designs from the results of a sweep: criteria, runs removed by each criterion, and ranking of the
//! remaining designs (thesis §4.1.2, §4.2.1, §4.3; errata 11).
//!
//! Only the table is required: the axes are the columns between `design` and `l12_m`. Axes that vary within a design,
//! such as the friction in the study of the thesis, define the **conditions**; every design occurs once per condition.

mod candidates;
mod criteria;
mod ranking;

use std::collections::HashSet;

use serde::{Serialize, Serializer};

use crate::criteria::Class;
use crate::study::sweep::{Reason, Status, group_reasons};
use crate::table::Table;

pub use candidates::{Axis, Candidate, Condition, SelectError};

pub(crate) use candidates::parse_class;
pub use criteria::{Bound, Criterion, SelectionCriteria, Side};
pub use ranking::{PerTerm, Ranked, TERMS, Term, Weights};

#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    pub weights: Weights,
    pub axes: Vec<Axis>,
    pub conditions: Vec<Condition>,
    /// All runs of the table, sorted by number.
    pub runs: Vec<Candidate>,
    /// For each run, whether it meets each criterion; `None` if the figure is missing.
    pub verdicts: Vec<Vec<Option<bool>>>,
    /// Criteria in the order of application, with their results.
    pub tallies: Vec<Tally>,
    pub classes: Vec<ClassCounts>,
    /// Reasons why completed runs have no class. Reasons that differ only in numbers are grouped.
    pub cannot_grasp: Vec<Reason>,
    /// Reasons for the classes, from the best to the worst class; `status` is the class. Empty if the table has no
    /// column `class_reason`.
    pub class_reasons: Vec<Reason>,
    /// Runs that meet every criterion, best first.
    pub ranking: Vec<Ranked>,
    /// Numbers of runs that are missing below the largest number. Not empty if the sweep is unfinished.
    pub missing_runs: Vec<i64>,
}

impl Selection {
    pub fn designs(&self) -> usize {
        let mut numbers: Vec<i64> = self.runs.iter().map(|run| run.design).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.len()
    }

    /// Returns the first criterion, in the order of application, after which no run remains; `None` if some runs
    /// remain.
    pub fn emptied_by(&self) -> Option<&Tally> {
        self.tallies.iter().find(|tally| tally.remaining == 0)
    }
}

/// Applies the criteria to every run of a table of results, and ranks the runs that meet all of them.
///
/// The columns are those of `phalanx sweep`. Required are `run`, `design`, `l12_m`, `status`, `force_positive`,
/// `form_closed`, `class`, `tts_s`, `f21_n`, `f22_n`, `pfp_n`, and the bounded columns. A completed run may lack
/// figures if it has a `reason`. It then does not meet the criteria for these figures.
///
/// # Errors
/// Returns an error if the table is not the result of a sweep, or if the criteria are invalid.
pub fn select(results: &Table, criteria: &SelectionCriteria) -> Result<Selection, SelectError> {
    criteria.weights.check()?;
    let (axes, conditions, runs) = candidates::read_results(results)?;
    let mut list = criteria.criteria();
    if runs.iter().any(Candidate::cannot_grasp) {
        list.insert(1, Criterion::Graspable);
    }
    // Values of the bounded columns by row; empty for criteria that are not bounds.
    let bounded = |criterion: &Criterion| match criterion {
        Criterion::Bound(bound) => results.numbers(&bound.column),
        _ => Ok(Vec::new()),
    };
    let columns = list.iter().map(bounded).collect::<Result<Vec<_>, _>>()?;
    let evaluate = |run: &Candidate| {
        let criteria = list.iter().zip(&columns);
        criteria.map(|(criterion, values)| criterion.evaluate(run, values.get(run.row).copied().flatten())).collect()
    };
    let verdicts: Vec<Vec<Option<bool>>> = runs.iter().map(evaluate).collect();
    let selected: Vec<usize> =
        (0..runs.len()).filter(|&run| verdicts[run].iter().all(|verdict| *verdict == Some(true))).collect();
    let figure = |run: &Candidate, term: usize| (TERMS[term].figure)(run).unwrap_or(f64::NAN);
    let figures: Vec<_> = selected.iter().map(|&run| [0, 1, 2, 3].map(|term| figure(&runs[run], term))).collect();
    let mut ranking = ranking::rank(&figures, &criteria.weights);
    for ranked in &mut ranking {
        ranked.run_index = selected[ranked.run_index];
    }
    let no_class = |run: &Candidate| {
        let reason = run.reason.as_deref().filter(|_| run.cannot_grasp())?;
        Some(Reason::of_run(run.run, run.status.name(), reason))
    };
    let class = |run: &Candidate| Some(Reason::of_run(run.run, run.class?.name(), run.class_reason.as_deref()?));
    Ok(Selection {
        tallies: (0..list.len()).map(|index| Tally::new(index, &list, &verdicts)).collect(),
        classes: (0..conditions.len()).map(|condition| ClassCounts::new(&runs, condition)).collect(),
        cannot_grasp: group_reasons(&[], runs.iter().filter_map(no_class)),
        class_reasons: group_reasons(&Class::ALL.map(Class::name), runs.iter().filter_map(class)),
        missing_runs: missing_runs(&runs),
        weights: criteria.weights,
        axes,
        conditions,
        runs,
        verdicts,
        ranking,
    })
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tally {
    #[serde(flatten)]
    pub criterion: Criterion,
    /// Number of runs that meet this criterion, regardless of the others.
    pub holds: usize,
    /// Number of runs that do not meet this criterion, regardless of the others.
    pub fails: usize,
    /// Number of runs for which the figure of this criterion is missing.
    pub unknown: usize,
    /// Number of runs that meet this criterion and all previous ones.
    #[serde(rename = "left")]
    pub remaining: usize,
    /// Number of runs that fail only this criterion.
    #[serde(rename = "removed_by_it_alone")]
    pub removed_alone: usize,
}

impl Tally {
    fn new(index: usize, criteria: &[Criterion], verdicts: &[Vec<Option<bool>>]) -> Self {
        let count = |verdict: Option<bool>| verdicts.iter().filter(|run| run[index] == verdict).count();
        let holds = |verdict: &Option<bool>| *verdict == Some(true);
        let fails_only_this = |run: &&Vec<Option<bool>>| {
            !holds(&run[index]) && run.iter().enumerate().all(|(other, verdict)| other == index || holds(verdict))
        };
        Tally {
            criterion: criteria[index].clone(),
            holds: count(Some(true)),
            fails: count(Some(false)),
            unknown: count(None),
            removed_alone: verdicts.iter().filter(fails_only_this).count(),
            remaining: verdicts.iter().filter(|run| run[..=index].iter().all(holds)).count(),
        }
    }

    /// Number of runs that do not meet this criterion, regardless of the others.
    pub fn removed(&self) -> usize {
        self.fails + self.unknown
    }
}

/// Counts of the runs of one condition.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ClassCounts {
    pub runs: usize,
    /// Numbers of runs by status, in the order of [`Status::ALL`].
    #[serde(serialize_with = "by_status")]
    pub statuses: [usize; 4],
    /// Number of completed runs without a class.
    pub cannot_grasp: usize,
    pub statically_stable: usize,
    pub statically_unstable: usize,
    pub form_closed: usize,
    /// Numbers of runs by dynamic class, in the order of [`Class::ALL`].
    #[serde(flatten, serialize_with = "by_class")]
    pub dynamic: [usize; 4],
}

fn by_status<S: Serializer>(counts: &[usize; 4], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(Status::ALL.map(Status::name).into_iter().zip(counts))
}

fn by_class<S: Serializer>(counts: &[usize; 4], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(Class::ALL.map(|class| class.name().replace('-', "_")).into_iter().zip(counts))
}

impl ClassCounts {
    fn new(runs: &[Candidate], condition: usize) -> Self {
        let count = |test: &dyn Fn(&Candidate) -> bool| {
            runs.iter().filter(|run| run.condition == condition && test(run)).count()
        };
        ClassCounts {
            runs: count(&|_| true),
            cannot_grasp: count(&Candidate::cannot_grasp),
            statuses: Status::ALL.map(|status| count(&|run| run.status == status)),
            dynamic: Class::ALL.map(|class| count(&|run| run.class == Some(class))),
            statically_stable: count(&|run| run.force_positive == Some(true)),
            statically_unstable: count(&|run| run.force_positive == Some(false)),
            form_closed: count(&|run| run.form_closed == Some(true)),
        }
    }
}

/// Run numbers missing between 1 and the largest one.
fn missing_runs(runs: &[Candidate]) -> Vec<i64> {
    let present: HashSet<i64> = runs.iter().map(|run| run.run).collect();
    let last = runs.iter().map(|run| run.run).max().unwrap_or(0);
    // Limits the list if a table contains a wrong, very large run number.
    let limit = 1_000_000;
    (1..=last).filter(|run| !present.contains(run)).take(limit).collect()
}
