//! The whole search: generation after generation, each simulated on all cores.

use std::collections::{HashMap, HashSet};
use std::time::Instant;

use super::found::{Design, Found};
use super::judge::judge;
use super::problem::{Algorithm, Optimisation};
use super::score::Score;
use super::search::Search;
use crate::study::sweep::{Point, Row, Status, Study, run_while};
use crate::table::Value;

/// Who hears what comes of an optimisation.
pub trait Listener: Send {
    /// A run that was made now; `false` ends the search.
    fn row(&mut self, row: &Row) -> bool;

    /// All designs so far, after each generation.
    fn generation(&mut self, designs: &[Design]);
}

/// What running an optimisation came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimised {
    /// `None` if it was ended before it was through.
    pub found: Option<Found>,
    /// Runs made now; those that were known do not count.
    pub runs: u64,
    /// Of these, those that were simulated: neither filtered nor refused.
    pub simulations: u64,
    pub threads: usize,
    pub wall_s: f64,
}

/// A run that was known, but not of the design that has its number in this search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("run {run} is of another design than this search asks for")]
pub struct OtherDesign {
    pub run: u64,
}

/// Searches, until `go_on` or the listener says no. Rows in `known`, from an earlier search, are not made again; equal rows lead to equal
/// searches, so that one that is taken up again goes the way of an undisturbed one.
///
/// With 0 threads there is one for each core; neither their number nor the order in which rows are found changes anything.
///
/// # Errors
/// A row in `known` is of another search.
pub fn run(
    of: &Optimisation,
    threads: usize,
    known: Vec<Vec<Value>>,
    go_on: &(dyn Fn() -> bool + Sync),
    listener: &mut dyn Listener,
) -> Result<Optimised, OtherDesign> {
    let start = Instant::now();
    let mut known: HashMap<u64, Vec<Value>> =
        known.into_iter().filter_map(|cells| Some((number(&cells)?, cells))).collect();
    let mut search = Search::new(&of.method, of.variables.iter().map(|variable| variable.start_share).collect());
    let mut done = Optimised { found: None, runs: 0, simulations: 0, threads: 0, wall_s: 0.0 };
    let (mut designs, mut generation) = (Vec::new(), 0);
    // The start has a generation of its own in CMA-ES.
    let most = of.method.generations + u64::from(of.method.algorithm == Algorithm::CmaEs);
    while generation < most && !search.is_over() {
        let places = search.ask();
        // Before the first run of a generation of many thousands too.
        let points = places.iter().map(|place| go_on().then(|| at(of, place))).collect::<Option<Vec<Vec<Point>>>>();
        let before = designs.len() as u64;
        let rows = match &points {
            Some(points) => simulated(of, threads, before, points, &mut known, go_on, listener, &mut done)?,
            None => None,
        };
        let (Some(points), Some(rows)) = (points, rows) else {
            done.wall_s = start.elapsed().as_secs_f64();
            return Ok(done);
        };
        let first = designs.len() as u64 + 1;
        let judged = rows.chunks(of.conditions() as usize).map(|rows| judge(&of.objectives, &of.constraints, rows));
        let of_generation = points.into_iter().zip(judged).zip(first..);
        designs.extend(of_generation.map(|((points, judged), number)| Design { number, generation, points, judged }));
        let scores: Vec<Score> =
            designs[first as usize - 1..].iter().map(|design| design.judged.score.clone()).collect();
        search.tell(&scores);
        listener.generation(&designs);
        generation += 1;
    }
    done.found = Some(Found::new(designs, generation, search.is_over()));
    done.wall_s = start.elapsed().as_secs_f64();
    Ok(done)
}

/// The values of the variables at a place.
fn at(of: &Optimisation, place: &[f64]) -> Vec<Point> {
    of.variables.iter().zip(place).map(|(variable, share)| variable.at(*share)).collect()
}

/// The number of the run that a row is of.
fn number(cells: &[Value]) -> Option<u64> {
    match cells.first() {
        Some(Value::Integer(run)) => u64::try_from(*run).ok(),
        _ => None,
    }
}

/// The rows of the runs of some designs, in order; `before`: how many designs there were before. `None` if it was ended on the way.
#[expect(clippy::too_many_arguments)]
fn simulated(
    of: &Optimisation,
    threads: usize,
    before: u64,
    points: &[Vec<Point>],
    known: &mut HashMap<u64, Vec<Value>>,
    go_on: &(dyn Fn() -> bool + Sync),
    listener: &mut dyn Listener,
    done: &mut Optimised,
) -> Result<Option<Vec<Row>>, OtherDesign> {
    let study = of.study.with_rows(points.to_vec());
    let offset = before * of.conditions();
    let mut rows: Vec<Option<Row>> = (1..=study.runs())
        .map(|run| Some(Row::of_cells(study.kind, known.remove(&(offset + run))?)))
        .collect::<Vec<Option<Row>>>();
    for (run, row) in (1..).zip(&rows) {
        if row.as_ref().is_some_and(|row| !is_of(row, &study, run)) {
            return Err(OtherDesign { run: offset + run });
        }
    }
    let there: HashSet<u64> = (1..).zip(&rows).filter(|(_, row)| row.is_some()).map(|(run, _)| run).collect();
    if there.len() < rows.len() {
        let (mut simulations, mut heard) = (0, Vec::new());
        let ran = run_while(&study, threads, study.runs(), &there, go_on, |mut row| {
            // Runs and designs are numbered over the whole search.
            row.run += offset;
            row.cells[0] = Value::Integer(row.run as i64);
            if let Value::Integer(design) = &mut row.cells[1] {
                *design += before as i64;
            }
            simulations += u64::from(matches!(row.status, Status::Completed | Status::Failed));
            let more = listener.row(&row);
            heard.push(row);
            more
        });
        done.threads = done.threads.max(ran.threads);
        done.runs += ran.runs;
        done.simulations += simulations;
        for row in heard {
            let at = (row.run - offset - 1) as usize;
            rows[at] = Some(row);
        }
    }
    Ok(rows.into_iter().collect())
}

/// Whether a row is of the design and the condition that a study has there.
fn is_of(row: &Row, study: &Study, run: u64) -> bool {
    let points = study.points(run);
    row.cells.get(2..2 + points.len()).is_some_and(|cells| cells.iter().zip(&points).all(|(a, b)| *a == b.value))
}
