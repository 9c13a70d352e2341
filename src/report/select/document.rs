//! The JSON document of a selection.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::criteria::Class;
use crate::format::{criterion_key, criterion_name};
use crate::study::select::{CLASSES, Criterion, ScoreTerms, Selection, Side, Weights};
use crate::study::sweep::{Reason, Status};
use crate::table::Value;

/// Report of a selection, with SI values.
#[derive(Clone, Debug, Serialize)]
pub struct SelectionReport<'a> {
    #[serde(skip)]
    pub(super) selection: &'a Selection,
    /// Maximum number of ranked runs in the text report.
    #[serde(skip)]
    pub max_ranked: usize,
    /// Source of the results.
    pub source: String,
    pub runs: usize,
    pub designs: usize,
    /// Missing runs with a number below the largest one.
    pub missing_runs: usize,
    pub axes: Vec<AxisReport>,
    pub classes: Vec<ClassesReport>,
    /// Reasons for the classes, from the best class, grouped by their text without numbers.
    pub class_reasons: Vec<ClassReasonReport>,
    /// Reasons why completed runs have no class.
    pub cannot_grasp: Vec<Reason>,
    pub criteria: Vec<CriterionReport>,
    pub selected: usize,
    /// The criterion that removed the last run, if no run is left.
    pub emptied_by: Option<String>,
    pub weights: Weights,
    pub ranking: Vec<RankedReport>,
}

/// An axis of the study.
#[derive(Clone, Debug, Serialize)]
pub struct AxisReport {
    pub column: String,
    /// Number of different values.
    pub values: usize,
    /// Whether the axis varies within a design.
    #[serde(rename = "again")]
    pub varies_within_design: bool,
}

/// Runs of one class with the same reason.
#[derive(Clone, Debug, Serialize)]
pub struct ClassReasonReport {
    pub class: String,
    /// Reason of the first of these runs; others differ in numbers only.
    pub class_reason: String,
    pub runs: u64,
    pub first_run: u64,
}

impl ClassReasonReport {
    fn new(reason: &Reason) -> Self {
        let Reason { status, reason, runs, first_run } = reason.clone();
        ClassReasonReport { class: status, class_reason: reason, runs, first_run }
    }
}

/// Classes of the runs of one condition.
#[derive(Clone, Debug, Serialize)]
pub struct ClassesReport {
    /// Values of the axes that define the condition.
    pub condition: BTreeMap<String, Value>,
    pub runs: usize,
    pub statuses: StatusesReport,
    /// Completed runs without a class.
    pub cannot_grasp: usize,
    pub statically_stable: usize,
    pub statically_unstable: usize,
    pub form_closed: usize,
    pub stable: usize,
    pub semi_stable: usize,
    pub semi_unstable: usize,
    pub unstable: usize,
}

/// Number of runs by status.
#[derive(Clone, Debug, Serialize)]
pub struct StatusesReport {
    pub completed: usize,
    pub filtered: usize,
    pub refused: usize,
    pub failed: usize,
}

/// One selection criterion.
#[derive(Clone, Debug, Serialize)]
pub struct CriterionReport {
    /// `completed`, `graspable`, `force_positive`, `form_closed`, `class`, `settled`, or the column of a bound.
    pub criterion: String,
    /// Name of the criterion in tables.
    #[serde(rename = "words")]
    pub name: String,
    /// Lowest accepted class, or lower bound of a column in its unit.
    pub at_least: Option<Value>,
    pub at_most: Option<f64>,
    /// Number of runs that meet the criterion.
    pub holds: usize,
    /// Number of runs that fail the criterion.
    pub fails: usize,
    /// Number of runs for which the criterion is unknown.
    pub unknown: usize,
    /// Number of runs that meet this and all previous criteria.
    #[serde(rename = "left")]
    pub remaining: usize,
    /// Number of runs that meet all other criteria but not this one.
    #[serde(rename = "removed_by_it_alone")]
    pub removed_alone: usize,
}

/// A selected run.
#[derive(Clone, Debug, Serialize)]
pub struct RankedReport {
    #[serde(rename = "place")]
    pub rank: usize,
    pub run: i64,
    pub design: i64,
    pub axes: BTreeMap<String, Value>,
    pub class: Option<Class>,
    /// Reason for the class.
    pub class_reason: Option<String>,
    pub pfp_n: Option<f64>,
    pub tts_s: Option<f64>,
    pub f21_n: Option<f64>,
    pub f22_n: Option<f64>,
    #[serde(rename = "parts")]
    pub terms: ScoreTerms,
    pub r_wc: f64,
}

impl<'a> SelectionReport<'a> {
    pub fn new(source: &str, selection: &'a Selection, max_ranked: usize) -> Self {
        let axes = selection.axes.iter();
        SelectionReport {
            selection,
            max_ranked,
            source: source.to_string(),
            runs: selection.runs.len(),
            designs: selection.designs(),
            missing_runs: selection.missing_runs.len(),
            axes: axes
                .map(|axis| AxisReport {
                    column: axis.column.clone(),
                    values: axis.values.len(),
                    varies_within_design: axis.varies_within_design,
                })
                .collect(),
            classes: classes(selection),
            class_reasons: selection.class_reasons.iter().map(ClassReasonReport::new).collect(),
            cannot_grasp: selection.cannot_grasp.clone(),
            criteria: criteria(selection),
            selected: selection.ranking.len(),
            emptied_by: selection.emptied_by().map(|tally| criterion_key(&tally.criterion).to_string()),
            weights: selection.weights,
            ranking: ranking(selection),
        }
    }
}

fn classes(selection: &Selection) -> Vec<ClassesReport> {
    let report = |(condition, counts): (&crate::study::select::Condition, &crate::study::select::ClassCounts)| {
        let status = |status: Status| counts.statuses[status as usize];
        ClassesReport {
            condition: condition.values.iter().map(|(column, value)| (column.clone(), value.clone())).collect(),
            runs: counts.runs,
            statuses: StatusesReport {
                completed: status(Status::Completed),
                filtered: status(Status::Filtered),
                refused: status(Status::Refused),
                failed: status(Status::Failed),
            },
            cannot_grasp: counts.cannot_grasp,
            statically_stable: counts.statically_stable,
            statically_unstable: counts.statically_unstable,
            form_closed: counts.form_closed,
            stable: counts.dynamic[0],
            semi_stable: counts.dynamic[1],
            semi_unstable: counts.dynamic[2],
            unstable: counts.dynamic[3],
        }
    };
    const { assert!(CLASSES.len() == 4) };
    selection.conditions.iter().zip(&selection.classes).map(report).collect()
}

fn criteria(selection: &Selection) -> Vec<CriterionReport> {
    let report = |tally: &crate::study::select::Tally| {
        let (at_least, at_most) = match &tally.criterion {
            Criterion::Class(least) => (Some(Value::from(least.name())), None),
            Criterion::Bound(bound) if bound.side == Side::AtLeast => (Some(Value::Number(bound.value)), None),
            Criterion::Bound(bound) => (None, Some(bound.value)),
            _ => (None, None),
        };
        CriterionReport {
            criterion: criterion_key(&tally.criterion).to_string(),
            name: criterion_name(&tally.criterion),
            at_least,
            at_most,
            holds: tally.holds,
            fails: tally.fails,
            unknown: tally.unknown,
            remaining: tally.remaining,
            removed_alone: tally.removed_alone,
        }
    };
    selection.tallies.iter().map(report).collect()
}

fn ranking(selection: &Selection) -> Vec<RankedReport> {
    let report = |ranked: &crate::study::select::Ranked| {
        let run = &selection.runs[ranked.run_index];
        let axes = selection.axes.iter().zip(&run.axes);
        RankedReport {
            rank: ranked.rank,
            run: run.run,
            design: run.design,
            axes: axes.map(|(axis, value)| (axis.column.clone(), value.clone())).collect(),
            class: run.class,
            class_reason: run.class_reason.clone(),
            pfp_n: run.pfp_n,
            tts_s: run.tts_s,
            f21_n: run.f21_n,
            f22_n: run.f22_n,
            terms: ranked.terms,
            r_wc: ranked.r_wc,
        }
    };
    selection.ranking.iter().map(report).collect()
}
