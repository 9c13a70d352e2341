//! Search loop: simulates one generation after another on all cores.

use std::collections::{HashMap, HashSet};
use std::time::Instant;

use super::evaluate::evaluate;
use super::problem::{Algorithm, Optimisation};
use super::result::{Design, OptimisationResult};
use super::score::Score;
use super::search::Search;
use crate::study::sweep::{AxisValue, Row, Status, Study, run_while};
use crate::table::Value;

/// Observer of an optimisation.
pub trait Listener: Send {
    /// Receives a new run; `false` ends the search.
    fn row(&mut self, row: &Row) -> bool;

    /// Receives all designs so far, after each generation.
    fn generation(&mut self, designs: &[Design]);
}

/// Outcome of running an optimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimisationRun {
    /// Result; `None` if the search was interrupted.
    pub result: Option<OptimisationResult>,
    /// Number of new runs, without those already known.
    pub runs: u64,
    /// Number of simulations among the new runs; filtered and refused runs do not count.
    pub simulations: u64,
    pub threads: usize,
    pub wall_s: f64,
}

/// Error: a known run belongs to another design than the one with its number in this search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("run {run} belongs to another design than the one in this search")]
pub struct DesignMismatch {
    pub run: u64,
}

/// Runs the search until it ends, or until `keep_running` or the listener returns `false`. Rows in `known`, from an
/// earlier search, are not simulated again. A resumed search gives the same result as an uninterrupted one.
///
/// `threads` = 0 means one thread per core. The result depends neither on the number of threads nor on the order in
/// which runs end.
///
/// # Errors
/// Returns an error if a row in `known` belongs to another search.
pub fn run(
    optimisation: &Optimisation,
    threads: usize,
    known: Vec<Vec<Value>>,
    keep_running: &(dyn Fn() -> bool + Sync),
    listener: &mut dyn Listener,
) -> Result<OptimisationRun, DesignMismatch> {
    let start = Instant::now();
    let mut known: HashMap<u64, Vec<Value>> =
        known.into_iter().filter_map(|cells| Some((run_number(&cells)?, cells))).collect();
    let mut search = Search::new(
        &optimisation.method,
        optimisation.variables.iter().map(|variable| variable.start_fraction).collect(),
    );
    let mut outcome = OptimisationRun { result: None, runs: 0, simulations: 0, threads: 0, wall_s: 0.0 };
    let (mut designs, mut generation) = (Vec::new(), 0);
    // CMA-ES evaluates the start as a separate generation.
    let max_generations =
        optimisation.method.generations + u64::from(optimisation.method.algorithm == Algorithm::CmaEs);
    while generation < max_generations && !search.has_converged() {
        let candidates = search.ask();
        // A generation can have many thousands of designs, so this loop can be interrupted too.
        let points = candidates
            .iter()
            .map(|candidate| keep_running().then(|| values_at(optimisation, candidate)))
            .collect::<Option<Vec<Vec<AxisValue>>>>();
        let previous_designs = designs.len() as u64;
        let rows = match &points {
            Some(points) => simulate_generation(
                optimisation,
                threads,
                previous_designs,
                points,
                &mut known,
                keep_running,
                listener,
                &mut outcome,
            )?,
            None => None,
        };
        let (Some(points), Some(rows)) = (points, rows) else {
            outcome.wall_s = start.elapsed().as_secs_f64();
            return Ok(outcome);
        };
        let first = designs.len() as u64 + 1;
        let evaluation = rows
            .chunks(optimisation.conditions() as usize)
            .map(|rows| evaluate(&optimisation.objectives, &optimisation.constraints, rows));
        let numbered = points.into_iter().zip(evaluation).zip(first..);
        designs.extend(numbered.map(|((points, evaluation), number)| Design {
            number,
            generation,
            points,
            evaluation,
        }));
        let scores: Vec<Score> =
            designs[first as usize - 1..].iter().map(|design| design.evaluation.score.clone()).collect();
        search.tell(&scores);
        listener.generation(&designs);
        generation += 1;
    }
    outcome.result = Some(OptimisationResult::new(designs, generation, search.has_converged()));
    outcome.wall_s = start.elapsed().as_secs_f64();
    Ok(outcome)
}

/// Returns the values of the variables of a candidate.
fn values_at(optimisation: &Optimisation, candidate: &[f64]) -> Vec<AxisValue> {
    optimisation.variables.iter().zip(candidate).map(|(variable, fraction)| variable.value_at(*fraction)).collect()
}

/// Returns the run number of a row.
fn run_number(cells: &[Value]) -> Option<u64> {
    match cells.first() {
        Some(Value::Integer(run)) => u64::try_from(*run).ok(),
        _ => None,
    }
}

/// Returns the rows of the runs of one generation, in order; `None` if interrupted. `previous_designs` is the number of
/// earlier designs.
#[expect(clippy::too_many_arguments)]
fn simulate_generation(
    optimisation: &Optimisation,
    threads: usize,
    previous_designs: u64,
    points: &[Vec<AxisValue>],
    known: &mut HashMap<u64, Vec<Value>>,
    keep_running: &(dyn Fn() -> bool + Sync),
    listener: &mut dyn Listener,
    outcome: &mut OptimisationRun,
) -> Result<Option<Vec<Row>>, DesignMismatch> {
    let study = optimisation.study.with_rows(points.to_vec());
    let offset = previous_designs * optimisation.conditions();
    let mut rows: Vec<Option<Row>> = (1..=study.runs())
        .map(|run| Some(Row::from_cells(study.kind, known.remove(&(offset + run))?)))
        .collect::<Vec<Option<Row>>>();
    for (run, row) in (1..).zip(&rows) {
        if row.as_ref().is_some_and(|row| !matches_study(row, &study, run)) {
            return Err(DesignMismatch { run: offset + run });
        }
    }
    let completed: HashSet<u64> = (1..).zip(&rows).filter(|(_, row)| row.is_some()).map(|(run, _)| run).collect();
    if completed.len() < rows.len() {
        let (mut simulations, mut new_rows) = (0, Vec::new());
        let ran = run_while(&study, threads, study.runs(), &completed, keep_running, |mut row| {
            // Runs and designs are numbered throughout the search.
            row.run += offset;
            row.cells[0] = Value::Integer(row.run as i64);
            if let Value::Integer(design) = &mut row.cells[1] {
                *design += previous_designs as i64;
            }
            simulations += u64::from(matches!(row.status, Status::Completed | Status::Failed));
            let should_continue = listener.row(&row);
            new_rows.push(row);
            should_continue
        });
        outcome.threads = outcome.threads.max(ran.threads);
        outcome.runs += ran.runs;
        outcome.simulations += simulations;
        for row in new_rows {
            let index = (row.run - offset - 1) as usize;
            rows[index] = Some(row);
        }
    }
    Ok(rows.into_iter().collect())
}

/// Returns whether a row has the design and the condition of this run of the study.
fn matches_study(row: &Row, study: &Study, run: u64) -> bool {
    let points = study.field_values(run);
    row.cells.get(2..2 + points.len()).is_some_and(|cells| cells.iter().zip(&points).all(|(a, b)| *a == b.value))
}
