//! Selection over the results of a sweep: which designs meet the criteria, what each criterion removed, and which of the
//! designs left is best (thesis §4.1.2, §4.2.1, §4.3; errata 11).
//!
//! | file | job |
//! |---|---|
//! | `candidates` | a table of results → runs with their figures, axes and conditions |
//! | `criteria` | what a run must meet, and whether it does |
//! | `ranking` | r_WC of those that do, and their places |
//! | `tally` | what each criterion removed, and the classes counted |
//! | `error` | what a table or a question can have wrong |
//!
//! Nothing but the table is needed: the axes are the columns between `design` and `l12_m`, whatever a study varied. Axes
//! that vary within one design (the friction of the thesis's study) make its **conditions**: every design is there once
//! in each of them.

mod candidates;
mod classes;
mod criteria;
mod error;
mod ranking;
mod tally;

pub use candidates::{Axis, Candidate, Condition, class_named};
pub use classes::CLASSES;
pub use criteria::{Bound, Criterion, SelectionCriteria, Side, Verdict};
pub use error::SelectError;
pub use ranking::{Figures, Parts, Ranked, Weights, rank};
pub use tally::{Classes, Tally};

use crate::study::sweep::Reason;
use crate::table::Table;

/// A finished selection.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// In the order in which they were applied.
    pub criteria: Vec<Criterion>,
    pub weights: Weights,
    pub axes: Vec<Axis>,
    pub conditions: Vec<Condition>,
    /// Every run of the table, in the order of its numbers.
    pub runs: Vec<Candidate>,
    /// By run and criterion.
    pub verdicts: Vec<Vec<Verdict>>,
    /// One for each criterion.
    pub tallies: Vec<Tally>,
    /// One for each condition.
    pub classes: Vec<Classes>,
    /// Why runs that were simulated to the end have no class, by the reason without its numbers.
    pub cannot_grasp: Vec<Reason>,
    /// What decides the classes, from the best; `status` is the class. Empty if the table has no column `class_reason`.
    pub class_reasons: Vec<Reason>,
    /// The runs that meet every criterion, best first.
    pub ranking: Vec<Ranked>,
    /// Numbers up to the largest that no row has: the sweep was not finished.
    pub missing_runs: Vec<i64>,
}

impl Selection {
    /// How many different designs there are.
    pub fn designs(&self) -> usize {
        let mut numbers: Vec<i64> = self.runs.iter().map(|run| run.design).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.len()
    }

    /// The criterion after which none was left, applied one after the other; `None` while some are.
    pub fn emptied_by(&self) -> Option<&Tally> {
        self.tallies.iter().find(|tally| tally.left == 0)
    }
}

/// Applies the criteria to every run of a table of results, and ranks those that meet all of them.
///
/// Columns as `phalanx sweep` writes them. The table must have `run`, `design`, `l12_m`, `status`,
/// `force_positive`, `form_closed`, `class`, `tts_s`, `f21_n`, `f22_n`, `pfp_n`, and what is bounded; others may be missing. A
/// completed run may lack figures if its `reason` says why; it meets no criterion about them.
pub fn select(results: &Table, criteria: &SelectionCriteria) -> Result<Selection, SelectError> {
    criteria.weights.check()?;
    let candidates::Read { axes, conditions, runs } = candidates::read(results)?;
    let mut list = criteria.list();
    if runs.iter().any(Candidate::cannot_grasp) {
        list.insert(1, Criterion::Graspable);
    }
    let bounded = criteria::bounded(results, &list)?;
    let judge = |run: &Candidate| {
        let of = |(criterion, column): (&Criterion, &Option<Vec<Option<f64>>>)| {
            criterion.judge(run, column.as_ref().and_then(|values| values[run.row]))
        };
        list.iter().zip(&bounded).map(of).collect::<Vec<_>>()
    };
    let verdicts: Vec<Vec<Verdict>> = runs.iter().map(judge).collect();
    let selected: Vec<usize> =
        (0..runs.len()).filter(|&run| verdicts[run].iter().all(|&verdict| verdict == Verdict::Holds)).collect();
    let figures: Vec<Figures> = selected.iter().map(|&run| Figures::of(&runs[run])).collect();
    let mut ranking = rank(&figures, &criteria.weights);
    for ranked in &mut ranking {
        ranked.run_index = selected[ranked.run_index];
    }
    Ok(Selection {
        tallies: tally::tallies(&list, &verdicts),
        classes: tally::classes(&runs, conditions.len()),
        cannot_grasp: tally::cannot_grasp(&runs),
        class_reasons: tally::class_reasons(&runs),
        missing_runs: tally::missing(&runs),
        weights: criteria.weights,
        criteria: list,
        axes,
        conditions,
        runs,
        verdicts,
        ranking,
    })
}
