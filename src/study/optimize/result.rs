//! Result of an optimisation: all designs, the Pareto front and gains over the start.

use super::evaluate::DesignEvaluation;
use super::problem::{Algorithm, Goal, Optimisation};
use super::score::{Score, pareto_front};
use crate::study::sweep::AxisValue;
use crate::table::{Column, Kind, Table, Value};

/// An evaluated design.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Number from 1; the start is 1.
    pub number: u64,
    /// Number of the generation from 0.
    pub generation: u64,
    /// Values of the variables.
    pub points: Vec<AxisValue>,
    pub evaluation: DesignEvaluation,
}

impl Design {
    /// Returns whether all constraints are satisfied.
    pub fn is_feasible(&self) -> bool {
        self.evaluation.score.is_feasible()
    }
}

/// Result of an optimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimisationResult {
    /// Designs in the order of the search; the first is the start.
    pub designs: Vec<Design>,
    /// Indices of the Pareto-optimal feasible designs, sorted by the first objective, best first.
    pub front: Vec<usize>,
    /// Number of evaluated generations.
    pub generations: u64,
    /// Whether the search ended by convergence.
    pub converged: bool,
}

impl OptimisationResult {
    /// Creates the result from designs in the order of the search.
    pub(super) fn new(designs: Vec<Design>, generations: u64, converged: bool) -> Self {
        let scores: Vec<&Score> = designs.iter().map(|design| &design.evaluation.score).collect();
        let mut front = pareto_front(&scores);
        front.sort_by(|&a, &b| {
            let pairs = scores[a].objectives.iter().zip(&scores[b].objectives);
            pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(a.cmp(&b))
        });
        OptimisationResult { designs, front, generations, converged }
    }

    /// Returns the start of the search, the reference for gains.
    pub fn start(&self) -> &Design {
        &self.designs[0]
    }

    /// Returns the number of designs that satisfy all constraints.
    pub fn feasible_count(&self) -> usize {
        self.designs.iter().filter(|design| design.is_feasible()).count()
    }

    /// Returns the number of runs by status, in the order of [`Status::ALL`](crate::study::sweep::Status::ALL).
    pub fn by_status(&self) -> [u64; 4] {
        let mut totals = [0; 4];
        for design in &self.designs {
            totals.iter_mut().zip(design.evaluation.by_status).for_each(|(total, count)| *total += count);
        }
        totals
    }

    /// Returns the index of the design on the front that is best in an objective.
    pub fn best(&self, objective: usize) -> Option<usize> {
        let value = |&index: &usize| self.designs[index].evaluation.score.objectives[objective];
        self.front.iter().copied().min_by(|a, b| value(a).total_cmp(&value(b)))
    }

    /// Returns the index of the compromise: the design on the front nearest to the ideal point, with each objective
    /// scaled by the front's extent; `None` with a single objective or fewer than three designs on the front.
    pub fn compromise(&self) -> Option<usize> {
        let value = |index: usize, objective: usize| self.designs[index].evaluation.score.objectives[objective];
        let objectives = self.front.first().map_or(0, |&first| self.designs[first].evaluation.score.objectives.len());
        if objectives < 2 || self.front.len() < 3 {
            return None;
        }
        let extent = |objective: usize| {
            let values = self.front.iter().map(|&index| value(index, objective));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (f64::min(low, value), f64::max(high, value))
            })
        };
        let extents: Vec<(f64, f64)> = (0..objectives).map(extent).collect();
        let distance = |index: usize| -> f64 {
            let scaled = |(objective, (low, high)): (usize, &(f64, f64))| match high > low {
                true => (value(index, objective) - low) / (high - low),
                false => 0.0,
            };
            extents.iter().enumerate().map(scaled).map(|value| value * value).sum()
        };
        self.front.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }
}

/// Columns that the results of every optimisation have.
pub(super) const FIXED_COLUMNS: [(&str, Kind); 9] = [
    ("design", Kind::Integer),
    ("generation", Kind::Integer),
    ("completed", Kind::Integer),
    ("filtered", Kind::Integer),
    ("refused", Kind::Integer),
    ("failed", Kind::Integer),
    ("violation", Kind::Number),
    ("feasible", Kind::Flag),
    ("front", Kind::Flag),
];

/// Returns one row per design: number, generation, variables, objectives, worst value of each constraint, runs by
/// status, violation, and whether the design is feasible and on the front.
pub fn table(optimisation: &Optimisation, result: &OptimisationResult) -> Table {
    let fixed = |(name, kind): (&'static str, Kind)| Column::new(name, kind);
    let variables = optimisation.variables.iter().map(|variable| Column::new(variable.column(), Kind::Number));
    let objectives =
        optimisation.objectives.iter().map(|objective| Column::new(objective.figure.name.clone(), Kind::Number));
    let constraints = optimisation
        .constraints
        .iter()
        .map(|constraint| Column::new(format!("worst_{}", constraint.column), constraint.kind()));
    let [first, last] = [&FIXED_COLUMNS[..2], &FIXED_COLUMNS[2..]].map(|columns| columns.iter().copied().map(fixed));
    let columns = first.chain(variables).chain(objectives).chain(constraints).chain(last).collect();
    let mut on_front = vec![false; result.designs.len()];
    result.front.iter().for_each(|&index| on_front[index] = true);
    let row = |(design, on_front): (&Design, bool)| {
        let DesignEvaluation { values, worst, by_status, score } = &design.evaluation;
        let mut row = vec![Value::Integer(design.number as i64), Value::Integer(design.generation as i64)];
        row.extend(design.points.iter().map(|point| point.value.clone()));
        row.extend(values.iter().map(|value| Value::from(*value)));
        row.extend(worst.iter().cloned());
        row.extend(by_status.map(|count| Value::Integer(count as i64)));
        row.extend([Value::Number(score.violation), Value::Flag(design.is_feasible()), Value::Flag(on_front)]);
        row
    };
    Table::new(columns, result.designs.iter().zip(on_front).map(row).collect())
}

/// Returns the improvement of a value over the start, relative to the start; negative if it is worse. `None` if a value
/// is missing or the start is 0.
pub fn gain(goal: Goal, start: Option<f64>, value: Option<f64>) -> Option<f64> {
    let (start, value) = (start.filter(|start| *start != 0.0)?, value?);
    let decrease = (start - value) / start.abs();
    Some(if goal == Goal::Min { decrease } else { -decrease })
}

/// Returns whether the optimisation searches for a Pareto front instead of a single best design.
pub fn is_front(optimisation: &Optimisation) -> bool {
    optimisation.objectives.len() > 1 && optimisation.method.algorithm == Algorithm::Nsga2
}
