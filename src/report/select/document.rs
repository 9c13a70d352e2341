//! The JSON document of a selection.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::criteria::Class;
use crate::study::select::{CLASSES, Criterion, Parts, Selection, Side, Weights};
use crate::study::sweep::{Reason, Status};
use crate::table::Value;
use crate::wording::{criterion_key, criterion_name};

/// Everything the tables say, with SI values.
#[derive(Clone, Debug, Serialize)]
pub struct SelectionReport<'a> {
    #[serde(skip)]
    pub(super) selection: &'a Selection,
    /// How many of the ranking are told to people.
    #[serde(skip)]
    pub most: usize,
    /// What was selected from.
    pub source: String,
    pub runs: usize,
    pub designs: usize,
    /// Runs that are missing up to the largest number.
    pub missing_runs: usize,
    pub axes: Vec<VariedReport>,
    pub classes: Vec<ClassesReport>,
    /// What decides the classes, from the best, by the sentence without its numbers.
    pub class_reasons: Vec<ClassReasonReport>,
    /// Why runs that were simulated to the end have no class.
    pub cannot_grasp: Vec<Reason>,
    pub criteria: Vec<CriterionReport>,
    pub selected: usize,
    /// The criterion that removed the last run, where none is left.
    pub emptied_by: Option<String>,
    pub weights: Weights,
    pub ranking: Vec<RankedReport>,
}

#[derive(Clone, Debug, Serialize)]
pub struct VariedReport {
    pub column: String,
    /// Different values.
    pub values: usize,
    /// Whether it varies within a design.
    pub again: bool,
}

/// Runs of one class that one sentence decides.
#[derive(Clone, Debug, Serialize)]
pub struct ClassReasonReport {
    pub class: String,
    /// As it is in the first of these runs; others differ in their numbers.
    pub class_reason: String,
    pub runs: u64,
    pub first_run: u64,
}

impl ClassReasonReport {
    fn new(of: &Reason) -> Self {
        let Reason { status, reason, runs, first_run } = of.clone();
        ClassReasonReport { class: status, class_reason: reason, runs, first_run }
    }
}

/// One condition.
#[derive(Clone, Debug, Serialize)]
pub struct ClassesReport {
    /// Values of the axes that make the condition.
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

#[derive(Clone, Debug, Serialize)]
pub struct StatusesReport {
    pub completed: usize,
    pub filtered: usize,
    pub refused: usize,
    pub failed: usize,
}

/// One criterion.
#[derive(Clone, Debug, Serialize)]
pub struct CriterionReport {
    /// `completed`, `graspable`, `force_positive`, `form_closed`, `class`, `settled`, or the column of a bound.
    pub criterion: String,
    pub words: String,
    /// The least class, or the bound in the unit of its column.
    pub at_least: Option<Value>,
    pub at_most: Option<f64>,
    pub holds: usize,
    pub fails: usize,
    pub unknown: usize,
    pub left: usize,
    pub removed_by_it_alone: usize,
}

/// A selected run.
#[derive(Clone, Debug, Serialize)]
pub struct RankedReport {
    pub place: usize,
    pub run: i64,
    pub design: i64,
    pub axes: BTreeMap<String, Value>,
    pub class: Option<Class>,
    /// What decides the class.
    pub class_reason: Option<String>,
    pub pfp_n: Option<f64>,
    pub tts_s: Option<f64>,
    pub f21_n: Option<f64>,
    pub f22_n: Option<f64>,
    pub parts: Parts,
    pub r_wc: f64,
}

impl<'a> SelectionReport<'a> {
    pub fn new(source: &str, selection: &'a Selection, most: usize) -> Self {
        let axes = selection.axes.iter();
        SelectionReport {
            selection,
            most,
            source: source.to_string(),
            runs: selection.runs.len(),
            designs: selection.designs(),
            missing_runs: selection.missing_runs.len(),
            axes: axes
                .map(|axis| VariedReport { column: axis.column.clone(), values: axis.values.len(), again: axis.again })
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
    let one = |(condition, of): (&crate::study::select::Condition, &crate::study::select::Classes)| {
        let status = |status: Status| of.statuses[status as usize];
        ClassesReport {
            condition: condition.values.iter().map(|(column, value)| (column.clone(), value.clone())).collect(),
            runs: of.runs,
            statuses: StatusesReport {
                completed: status(Status::Completed),
                filtered: status(Status::Filtered),
                refused: status(Status::Refused),
                failed: status(Status::Failed),
            },
            cannot_grasp: of.cannot_grasp,
            statically_stable: of.statically_stable,
            statically_unstable: of.statically_unstable,
            form_closed: of.form_closed,
            stable: of.dynamic[0],
            semi_stable: of.dynamic[1],
            semi_unstable: of.dynamic[2],
            unstable: of.dynamic[3],
        }
    };
    const { assert!(CLASSES.len() == 4) };
    selection.conditions.iter().zip(&selection.classes).map(one).collect()
}

fn criteria(selection: &Selection) -> Vec<CriterionReport> {
    let one = |tally: &crate::study::select::Tally| {
        let (at_least, at_most) = match &tally.criterion {
            Criterion::Class(least) => (Some(Value::from(least.name())), None),
            Criterion::Bound(bound) if bound.side == Side::AtLeast => (Some(Value::Number(bound.value)), None),
            Criterion::Bound(bound) => (None, Some(bound.value)),
            _ => (None, None),
        };
        CriterionReport {
            criterion: criterion_key(&tally.criterion).to_string(),
            words: criterion_name(&tally.criterion),
            at_least,
            at_most,
            holds: tally.holds,
            fails: tally.fails,
            unknown: tally.unknown,
            left: tally.left,
            removed_by_it_alone: tally.only,
        }
    };
    selection.tallies.iter().map(one).collect()
}

fn ranking(selection: &Selection) -> Vec<RankedReport> {
    let one = |ranked: &crate::study::select::Ranked| {
        let run = &selection.runs[ranked.run_index];
        let axes = selection.axes.iter().zip(&run.axes);
        RankedReport {
            place: ranked.place,
            run: run.run,
            design: run.design,
            axes: axes.map(|(axis, value)| (axis.column.clone(), value.clone())).collect(),
            class: run.class,
            class_reason: run.class_reason.clone(),
            pfp_n: run.pfp_n,
            tts_s: run.tts_s,
            f21_n: run.f21_n,
            f22_n: run.f22_n,
            parts: ranked.parts,
            r_wc: ranked.r_wc,
        }
    };
    selection.ranking.iter().map(one).collect()
}
