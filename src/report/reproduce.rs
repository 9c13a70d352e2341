//! The reproduction of the thesis with the simulations and the selection of its study.

use std::collections::HashSet;
use std::fmt::Display;

use serde::Serialize;

use super::sweep::SelectionReport;
use crate::check::Check;
use crate::format::{ColumnFormat, Report, ToReport};
use crate::plot;
use crate::scene;
use crate::study::select::{Candidate, Condition, Ranked, Selection, SelectionCriteria, Tally, select};
use crate::study::sweep::{self, Row, Status, Study};
use crate::table::{Table, Value};
use crate::thesis::reproduce::{self, RankedRun, Reproduction, Run, STEPS, Simulations};
use phalanx_parallel::{ComputeError, Monitor};

const STUDY: &str = include_str!("../../scenes/studies/thesis.toml");
const CHOSEN: &str = include_str!("../../scenes/experiment-95.toml");
const CAD: &str = include_str!("../../scenes/experiment-95-cad.toml");
const ERRATA: &str = include_str!("../docs/errata.md");

/// A reproduction, and the tables on which it is based.
#[derive(Clone, Debug)]
pub struct Reproduced {
    pub reproduction: Reproduction,
    /// Results of the 384 simulations, including their checks.
    pub results: Table,
    pub selection: Selection,
}

/// JSON document and text of a reproduction.
#[derive(Clone, Debug, Serialize)]
pub struct ReproductionReport<'a> {
    #[serde(flatten)]
    reproduction: &'a Reproduction,
    selection: SelectionReport<'a>,
}

impl<'a> ReproductionReport<'a> {
    pub fn new(found: &'a Reproduced) -> Self {
        let selection = SelectionReport::new("thesis.toml", &found.selection, usize::MAX);
        ReproductionReport { reproduction: &found.reproduction, selection }
    }
}

impl ToReport for ReproductionReport<'_> {
    fn report(&self) -> Report {
        self.reproduction.report()
    }
}

/// Simulates and selects the designs of the thesis, and reproduces all figures, on `threads` threads (0: one per core).
///
/// # Errors
/// Returns an error if the monitor stops the computation. Any other error is a bug, because all inputs are shipped.
pub fn reproduce(quick: bool, threads: usize, monitor: &Monitor) -> Result<Reproduced, ComputeError> {
    monitor.start(STEPS, "the 384 simulations");
    let mut study = sweep::parse(STUDY, "thesis.toml").map_err(failed)?;
    // The reproduction checks the runs later, because it needs the runs of the checks.
    study.checked = false;
    let mut rows = Vec::new();
    let collect = |row: Row| {
        rows.push(row.cells);
        true
    };
    let ran = sweep::run_while(&study, threads, 1..=study.runs(), &HashSet::new(), monitor.keep_running(), collect);
    if !ran.complete {
        return Err(monitor.stopped());
    }
    let mut results = sweep::sorted_table(&study, rows);
    let selection = select(&results, &SelectionCriteria::default()).map_err(failed)?;
    let simulations = simulations(&study, &results, &selection)?;
    let chosen = scene::parse(CHOSEN, "experiment-95.toml").map_err(failed)?;
    let cad = scene::parse(CAD, "experiment-95-cad.toml").map_err(failed)?;
    let reproduction = reproduce::reproduce(simulations, [chosen, cad], ERRATA, quick, threads, monitor)?;
    for (run, check) in &reproduction.checked_runs {
        write_check(&mut results, selection.runs[*run].row, check);
    }
    Ok(Reproduced { reproduction, results, selection })
}

fn failed(error: impl Display) -> ComputeError {
    ComputeError::Failed(format!("the simulations could not be computed: {error}"))
}

/// Returns the runs and their selection in the form that the reproduction needs.
fn simulations(study: &Study, results: &Table, selection: &Selection) -> Result<Simulations, ComputeError> {
    let run = |found: &Candidate| -> Result<Run, ComputeError> {
        let number = u64::try_from(found.run).map_err(failed)?;
        Ok(Run {
            run: found.run,
            design: found.design,
            condition: found.condition,
            scene: scene::parse(&study.scene_text(number), "run.toml").map_err(failed)?,
            is_completed: found.status == Status::Completed,
            is_failed: found.status == Status::Failed,
            force_positive: found.force_positive,
            form_closed: found.form_closed,
            class: found.class,
            tts_s: found.tts_s,
            f21_n: found.f21_n,
            f22_n: found.f22_n,
            pfp_n: found.pfp_n,
        })
    };
    let extremes = |name: &str| -> Result<[f64; 2], ComputeError> {
        let values = results.numbers(name).map_err(failed)?.into_iter().flatten();
        Ok(values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]))
    };
    let criterion = |tally: &Tally| {
        let counts = [tally.holds, tally.removed(), tally.remaining, tally.removed_alone];
        (tally.criterion.name(), counts)
    };
    let of_design = selection.axes.iter().enumerate().filter(|(_, axis)| !axis.varies_within_design);
    let axes: Vec<_> = of_design.map(|(index, axis)| (index, ColumnFormat::for_column(&axis.column))).collect();
    let ranked = |ranked: &Ranked| {
        let values = &selection.runs[ranked.run_index].axes;
        let axes = axes.iter().map(|(axis, quantity)| quantity.value(&values[*axis], 4)).collect();
        RankedRun { run: ranked.run_index, rank: ranked.rank, r_wc: ranked.r_wc, axes }
    };
    Ok(Simulations {
        runs: selection.runs.iter().map(run).collect::<Result<_, _>>()?,
        conditions: selection.conditions.iter().map(Condition::name).collect(),
        mass_kg: extremes("mass_kg")?,
        trajectory_rad: extremes("trajectory_rad")?,
        criteria: selection.tallies.iter().map(criterion).collect(),
        axes: axes.iter().map(|(_, quantity)| quantity.label()).collect(),
        ranking: selection.ranking.iter().map(ranked).collect(),
        pictures: plot::selection("thesis", results, selection),
    })
}

/// Writes the check of a run into its row, as a sweep with `--check` does.
fn write_check(results: &mut Table, row: usize, check: &Check) {
    let error = Some(check.errors.path).filter(|error| error.is_finite()).map_or(Value::Missing, Value::Number);
    for (name, value) in [("check", Value::from(check.verdict.name())), ("check_error_rad", error)] {
        if let Some(column) = results.find(name) {
            results.rows[row][column] = value;
        }
    }
}
