//! Evaluation of a design from its runs.

use super::problem::{ColumnAggregation, ConditionAggregation, Constraint, Figure, Goal, Limit, Objective};
use super::score::Score;
use crate::criteria::Class;
use crate::study::select::CLASSES;
use crate::study::sweep::{Row, Status};
use crate::table::Value;

/// Evaluation of a design from its runs.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignEvaluation {
    /// Value of each objective in SI units, without sign change; `None` if a run has no such figure.
    pub values: Vec<Option<f64>>,
    /// Worst value of each constraint over the conditions.
    pub worst: Vec<Value>,
    /// Number of runs by status, in the order of [`Status::ALL`].
    pub by_status: [u64; 4],
    pub score: Score,
}

/// Evaluates a design from its rows, one for each condition.
///
/// The violation is a sum over all conditions: 1 for a run that was not completed or has no verdict because its finger
/// cannot grasp the object, 1 for each missing figure, and from 0 to 1 for each violated constraint, depending on the
/// deviation.
pub fn evaluate(objectives: &[Objective], constraints: &[Constraint], rows: &[Row]) -> DesignEvaluation {
    let by_status = Status::ALL.map(|status| rows.iter().filter(|row| row.status == status).count() as u64);
    let incomplete = rows.iter().filter(|row| !row.has_verdict).count() as f64;
    let figures: Vec<Vec<Option<f64>>> = objectives
        .iter()
        .map(|objective| rows.iter().map(|row| figure_value(&objective.figure, row)).collect())
        .collect();
    let missing = figures.iter().flatten().filter(|value| value.is_none()).count() as f64;
    let violated: f64 =
        constraints.iter().flat_map(|constraint| rows.iter().map(|row| violation(constraint, row))).sum();
    let values: Vec<Option<f64>> =
        objectives.iter().zip(&figures).map(|(objective, values)| aggregate(objective, values)).collect();
    let minimised = |(objective, value): (&Objective, &Option<f64>)| match (objective.goal, value) {
        (Goal::Min, Some(value)) => *value,
        (Goal::Max, Some(value)) => -value,
        (_, None) => f64::INFINITY,
    };
    let score = Score {
        objectives: objectives.iter().zip(&values).map(minimised).collect(),
        violation: incomplete + missing + violated,
    };
    DesignEvaluation {
        worst: constraints.iter().map(|constraint| worst(constraint, rows)).collect(),
        values,
        by_status,
        score,
    }
}

fn number(row: &Row, cell: usize) -> Option<f64> {
    match row.cells.get(cell) {
        Some(Value::Number(number)) if number.is_finite() => Some(*number),
        Some(Value::Integer(integer)) => Some(*integer as f64),
        _ => None,
    }
}

/// Returns the value of a figure in a row; `None` if one of its columns has no value.
fn figure_value(figure: &Figure, row: &Row) -> Option<f64> {
    let values = figure.cells.iter().map(|cell| number(row, *cell)).collect::<Option<Vec<f64>>>()?;
    values.into_iter().reduce(|a, b| match figure.aggregation {
        ColumnAggregation::Largest => a.max(b),
        ColumnAggregation::Smallest => a.min(b),
        ColumnAggregation::Sum => a + b,
    })
}

/// Aggregates the values of an objective over the conditions; `None` if one is missing.
fn aggregate(objective: &Objective, values: &[Option<f64>]) -> Option<f64> {
    let values = values.iter().copied().collect::<Option<Vec<f64>>>()?;
    let count = values.len() as f64;
    match (objective.condition_aggregation, objective.goal) {
        (ConditionAggregation::Mean, _) => (count > 0.0).then(|| values.iter().sum::<f64>() / count),
        (ConditionAggregation::Worst, Goal::Min) => values.into_iter().reduce(f64::max),
        (ConditionAggregation::Worst, Goal::Max) => values.into_iter().reduce(f64::min),
    }
}

/// Returns the index of a class, from good to bad.
fn rank(name: &str) -> Option<usize> {
    CLASSES.map(Class::name).iter().position(|class| *class == name)
}

/// Returns the violation of a constraint in a run, from 0 (satisfied) to 1; 1 if the run has no such figure.
fn violation(constraint: &Constraint, row: &Row) -> f64 {
    let cell = row.cells.get(constraint.cell);
    match (&constraint.limit, cell) {
        (Limit::Between { at_least, at_most }, _) => {
            let Some(value) = number(row, constraint.cell) else { return 1.0 };
            let below = at_least.map_or(0.0, |bound| relative_deficit(bound - value, bound));
            below.max(at_most.map_or(0.0, |bound| relative_deficit(value - bound, bound)))
        }
        (Limit::Flag(required), Some(Value::Flag(value))) if required == value => 0.0,
        (Limit::Equals(required), Some(Value::Text(value))) if required == value => 0.0,
        (Limit::Class(required), Some(Value::Text(value))) => match rank(value) {
            Some(rank) => rank.saturating_sub(*required) as f64 / (CLASSES.len() - 1) as f64,
            None => 1.0,
        },
        _ => 1.0,
    }
}

/// Returns the deficit relative to the bound, or to one SI unit if the bound is 0, mapped to values below 1.
fn relative_deficit(deficit: f64, bound: f64) -> f64 {
    let ratio = deficit / if bound == 0.0 { 1.0 } else { bound.abs() };
    if ratio > 0.0 { ratio / (1.0 + ratio) } else { 0.0 }
}

/// Returns the value of the run with the largest violation, or, if all runs satisfy the constraint, the value nearest
/// to the bound.
fn worst(constraint: &Constraint, rows: &[Row]) -> Value {
    let margin = |row: &Row| match &constraint.limit {
        Limit::Between { at_least, at_most } => number(row, constraint.cell).map_or(f64::NEG_INFINITY, |value| {
            let above = at_least.map_or(f64::INFINITY, |bound| value - bound);
            above.min(at_most.map_or(f64::INFINITY, |bound| bound - value))
        }),
        Limit::Class(_) => match row.cells.get(constraint.cell) {
            Some(Value::Text(value)) => rank(value).map_or(f64::NEG_INFINITY, |rank| -(rank as f64)),
            _ => f64::NEG_INFINITY,
        },
        _ => -violation(constraint, row),
    };
    let worst = rows.iter().min_by(|a, b| margin(a).total_cmp(&margin(b)));
    match worst.and_then(|row| row.cells.get(constraint.cell)) {
        Some(Value::Integer(integer)) => Value::Number(*integer as f64),
        Some(value) => value.clone(),
        None => Value::Missing,
    }
}
