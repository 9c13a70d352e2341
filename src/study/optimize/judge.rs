//! What the runs of a design say of it.

use super::problem::{Constraint, Figure, Goal, Limit, Objective, Of, Over};
use super::score::Score;
use crate::criteria::Class;
use crate::study::select::CLASSES;
use crate::study::sweep::{Row, Status};
use crate::table::Value;

/// A design judged by its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// Of each objective, in SI and as it is, large or small; `None` where a run has no such figure.
    pub values: Vec<Option<f64>>,
    /// Of each constraint the worst over the conditions.
    pub worst: Vec<Value>,
    /// Runs by how they ended, in the order of [`Status::ALL`].
    pub by_status: [u64; 4],
    pub score: Score,
}

/// Judges a design by its rows, one for each condition.
///
/// The violation counts, over all conditions: 1 for a run that did not come to its end or has no verdict, because its finger cannot
/// grasp the object, 1 for each figure that it has not, and for each
/// constraint that is missed how far it is missed, from 0 to 1.
pub fn judge(objectives: &[Objective], constraints: &[Constraint], rows: &[Row]) -> Judged {
    let by_status = Status::ALL.map(|status| rows.iter().filter(|row| row.status == status).count() as u64);
    let unfinished = rows.iter().filter(|row| !row.judged).count() as f64;
    let figures: Vec<Vec<Option<f64>>> =
        objectives.iter().map(|of| rows.iter().map(|row| figure(&of.figure, row)).collect()).collect();
    let lacking = figures.iter().flatten().filter(|value| value.is_none()).count() as f64;
    let missed: f64 = constraints.iter().flat_map(|of| rows.iter().map(|row| missed(of, row))).sum();
    let values: Vec<Option<f64>> = objectives.iter().zip(&figures).map(|(of, all)| over(of, all)).collect();
    let smaller = |(of, value): (&Objective, &Option<f64>)| match (of.goal, value) {
        (Goal::Min, Some(value)) => *value,
        (Goal::Max, Some(value)) => -value,
        (_, None) => f64::INFINITY,
    };
    let score = Score {
        objectives: objectives.iter().zip(&values).map(smaller).collect(),
        violation: unfinished + lacking + missed,
    };
    Judged { worst: constraints.iter().map(|of| worst(of, rows)).collect(), values, by_status, score }
}

fn number(row: &Row, cell: usize) -> Option<f64> {
    match row.cells.get(cell) {
        Some(Value::Number(number)) if number.is_finite() => Some(*number),
        Some(Value::Integer(integer)) => Some(*integer as f64),
        _ => None,
    }
}

/// `None` if one of the columns has no value.
fn figure(of: &Figure, row: &Row) -> Option<f64> {
    let values = of.cells.iter().map(|cell| number(row, *cell)).collect::<Option<Vec<f64>>>()?;
    values.into_iter().reduce(|a, b| match of.of {
        Of::Largest => a.max(b),
        Of::Smallest => a.min(b),
        Of::Sum => a + b,
    })
}

fn over(of: &Objective, values: &[Option<f64>]) -> Option<f64> {
    let values = values.iter().copied().collect::<Option<Vec<f64>>>()?;
    let count = values.len() as f64;
    match (of.over, of.goal) {
        (Over::Mean, _) => (count > 0.0).then(|| values.iter().sum::<f64>() / count),
        (Over::Worst, Goal::Min) => values.into_iter().reduce(f64::max),
        (Over::Worst, Goal::Max) => values.into_iter().reduce(f64::min),
    }
}

/// The place of a class, from good to bad.
fn rank(name: &str) -> Option<usize> {
    CLASSES.map(Class::name).iter().position(|of| *of == name)
}

/// How far a run misses a constraint: 0 if it does not, 1 at most, and where it has no such figure.
fn missed(of: &Constraint, row: &Row) -> f64 {
    let cell = row.cells.get(of.cell);
    match (&of.limit, cell) {
        (Limit::Between { at_least, at_most }, _) => {
            let Some(found) = number(row, of.cell) else { return 1.0 };
            let below = at_least.map_or(0.0, |bound| short(bound - found, bound));
            below.max(at_most.map_or(0.0, |bound| short(found - bound, bound)))
        }
        (Limit::Flag(wanted), Some(Value::Flag(found))) if wanted == found => 0.0,
        (Limit::Word(wanted), Some(Value::Text(found))) if wanted == found => 0.0,
        (Limit::Class(wanted), Some(Value::Text(found))) => match rank(found) {
            Some(rank) => rank.saturating_sub(*wanted) as f64 / (CLASSES.len() - 1) as f64,
            None => 1.0,
        },
        _ => 1.0,
    }
}

/// What is lacking, in shares of the bound, squeezed below 1; where the bound is 0, of one SI unit.
fn short(lacking: f64, bound: f64) -> f64 {
    let share = lacking / if bound == 0.0 { 1.0 } else { bound.abs() };
    if share > 0.0 { share / (1.0 + share) } else { 0.0 }
}

/// The value of the run that misses a constraint most; of those that meet it, the nearest to the bound.
fn worst(of: &Constraint, rows: &[Row]) -> Value {
    let room = |row: &Row| match &of.limit {
        Limit::Between { at_least, at_most } => number(row, of.cell).map_or(f64::NEG_INFINITY, |found| {
            let above = at_least.map_or(f64::INFINITY, |bound| found - bound);
            above.min(at_most.map_or(f64::INFINITY, |bound| bound - found))
        }),
        Limit::Class(_) => match row.cells.get(of.cell) {
            Some(Value::Text(found)) => rank(found).map_or(f64::NEG_INFINITY, |rank| -(rank as f64)),
            _ => f64::NEG_INFINITY,
        },
        _ => -missed(of, row),
    };
    let worst = rows.iter().min_by(|a, b| room(a).total_cmp(&room(b)));
    match worst.and_then(|row| row.cells.get(of.cell)) {
        Some(Value::Integer(integer)) => Value::Number(*integer as f64),
        Some(value) => value.clone(),
        None => Value::Missing,
    }
}
