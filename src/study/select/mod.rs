//! Selection of designs from the results of a sweep: criteria, runs removed by each criterion, and ranking of the
//! remaining designs (thesis §4.1.2, §4.2.1, §4.3; errata 11).
//!
//! | file | content |
//! |---|---|
//! | `candidates` | runs, axes and conditions from a table of results |
//! | `criteria` | criteria and their evaluation |
//! | `ranking` | score r_WC and ranks of the selected runs |
//! | `tally` | runs removed by each criterion, runs per class |
//! | `error` | errors |
//!
//! Only the table is required: the axes are the columns between `design` and `l12_m`. Axes that vary within a design,
//! such as the friction in the study of the thesis, define the **conditions**; every design occurs once per condition.

mod candidates;
mod classes;
mod criteria;
mod error;
mod ranking;
mod tally;

pub use candidates::{Axis, Candidate, Condition, parse_class};
pub use classes::CLASSES;
pub use criteria::{Bound, Criterion, SelectionCriteria, Side, Verdict};
pub use error::SelectError;
pub use ranking::{Figures, Ranked, ScoreTerms, Weights, rank};
pub use tally::{ClassCounts, Tally};

use crate::study::sweep::Reason;
use crate::table::Table;

/// A finished selection.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Criteria in the order of application.
    pub criteria: Vec<Criterion>,
    pub weights: Weights,
    pub axes: Vec<Axis>,
    pub conditions: Vec<Condition>,
    /// All runs of the table, sorted by number.
    pub runs: Vec<Candidate>,
    /// Verdicts by run and criterion.
    pub verdicts: Vec<Vec<Verdict>>,
    /// One tally per criterion.
    pub tallies: Vec<Tally>,
    /// Counts of each condition.
    pub classes: Vec<ClassCounts>,
    /// Reasons for a missing class of completed runs, grouped without numbers.
    pub cannot_grasp: Vec<Reason>,
    /// Reasons for the classes from best to worst; `status` is the class. Empty if the table has no column
    /// `class_reason`.
    pub class_reasons: Vec<Reason>,
    /// Runs that meet every criterion, best first.
    pub ranking: Vec<Ranked>,
    /// Run numbers missing up to the largest one; not empty if the sweep is unfinished.
    pub missing_runs: Vec<i64>,
}

impl Selection {
    /// Number of different designs.
    pub fn designs(&self) -> usize {
        let mut numbers: Vec<i64> = self.runs.iter().map(|run| run.design).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.len()
    }

    /// First criterion, in the order of application, after which no run remains; `None` if some runs remain.
    pub fn emptied_by(&self) -> Option<&Tally> {
        self.tallies.iter().find(|tally| tally.remaining == 0)
    }
}

/// Applies the criteria to every run of a table of results and ranks the runs that meet all of them.
///
/// The columns are those of `phalanx sweep`. Required are `run`, `design`, `l12_m`, `status`,
/// `force_positive`, `form_closed`, `class`, `tts_s`, `f21_n`, `f22_n`, `pfp_n`, and the bounded columns. A
/// completed run may lack figures if it has a `reason`; it does not meet the criteria on these figures.
///
/// # Errors
/// Returns an error if the table is not the result of a sweep, or the criteria are invalid.
pub fn select(results: &Table, criteria: &SelectionCriteria) -> Result<Selection, SelectError> {
    criteria.weights.check()?;
    let candidates::ResultRuns { axes, conditions, runs } = candidates::read_results(results)?;
    let mut list = criteria.criteria();
    if runs.iter().any(Candidate::cannot_grasp) {
        list.insert(1, Criterion::Graspable);
    }
    let bound_columns = criteria::bound_columns(results, &list)?;
    let evaluate = |run: &Candidate| {
        let verdict = |(criterion, column): (&Criterion, &Option<Vec<Option<f64>>>)| {
            criterion.evaluate(run, column.as_ref().and_then(|values| values[run.row]))
        };
        list.iter().zip(&bound_columns).map(verdict).collect::<Vec<_>>()
    };
    let verdicts: Vec<Vec<Verdict>> = runs.iter().map(evaluate).collect();
    let selected: Vec<usize> =
        (0..runs.len()).filter(|&run| verdicts[run].iter().all(|&verdict| verdict == Verdict::Holds)).collect();
    let figures: Vec<Figures> = selected.iter().map(|&run| Figures::from_candidate(&runs[run])).collect();
    let mut ranking = rank(&figures, &criteria.weights);
    for ranked in &mut ranking {
        ranked.run_index = selected[ranked.run_index];
    }
    Ok(Selection {
        tallies: tally::tallies(&list, &verdicts),
        classes: tally::count_classes(&runs, conditions.len()),
        cannot_grasp: tally::cannot_grasp_reasons(&runs),
        class_reasons: tally::class_reasons(&runs),
        missing_runs: tally::missing_runs(&runs),
        weights: criteria.weights,
        criteria: list,
        axes,
        conditions,
        runs,
        verdicts,
        ranking,
    })
}
