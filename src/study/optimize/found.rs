//! What an optimisation found: every design, the front, and what is gained over the start.

use super::judge::Judged;
use super::problem::{Algorithm, Goal, Optimisation};
use super::score::{Score, front};
use crate::study::sweep::Point;
use crate::table::{Column, Kind, Table, Value};

/// A design that was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// From 1, which is the start.
    pub number: u64,
    /// From 0.
    pub generation: u64,
    /// A value of each variable.
    pub points: Vec<Point>,
    pub judged: Judged,
}

impl Design {
    /// Whether it meets all constraints.
    pub fn is_feasible(&self) -> bool {
        self.judged.score.is_feasible()
    }
}

/// All that was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// In the order in which they were asked for; the first is the start.
    pub designs: Vec<Design>,
    /// Indices of the feasible designs that no other one beats, by the first objective, the best first.
    pub front: Vec<usize>,
    /// Generations that were looked at.
    pub generations: u64,
    /// Whether the search ended because there was nothing left to find.
    pub converged: bool,
}

impl Found {
    /// Of designs in the order in which they were asked for.
    pub(super) fn new(designs: Vec<Design>, generations: u64, converged: bool) -> Self {
        let scores: Vec<&Score> = designs.iter().map(|design| &design.judged.score).collect();
        let mut front = front(&scores);
        front.sort_by(|&a, &b| {
            let pairs = scores[a].objectives.iter().zip(&scores[b].objectives);
            pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(a.cmp(&b))
        });
        Found { designs, front, generations, converged }
    }

    /// The start of the search, with which all is compared.
    pub fn start(&self) -> &Design {
        &self.designs[0]
    }

    /// How many designs meet all constraints.
    pub fn feasible(&self) -> usize {
        self.designs.iter().filter(|design| design.is_feasible()).count()
    }

    /// Runs by how they ended, in the order of [`Status::ALL`](crate::study::sweep::Status::ALL).
    pub fn by_status(&self) -> [u64; 4] {
        let mut all = [0; 4];
        for design in &self.designs {
            all.iter_mut().zip(design.judged.by_status).for_each(|(all, of)| *all += of);
        }
        all
    }

    /// The design of the front that is best by an objective.
    pub fn best(&self, objective: usize) -> Option<usize> {
        let value = |&index: &usize| self.designs[index].judged.score.objectives[objective];
        self.front.iter().copied().min_by(|a, b| value(a).total_cmp(&value(b)))
    }

    /// The design of the front that is nearest to what would be best by every objective at once, each counted in shares of the front's
    /// extent; `None` if the front is not at least three designs of several objectives.
    pub fn compromise(&self) -> Option<usize> {
        let value = |index: usize, objective: usize| self.designs[index].judged.score.objectives[objective];
        let objectives = self.front.first().map_or(0, |&first| self.designs[first].judged.score.objectives.len());
        if objectives < 2 || self.front.len() < 3 {
            return None;
        }
        let extent = |objective: usize| {
            let values = self.front.iter().map(|&index| value(index, objective));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), of| (f64::min(low, of), f64::max(high, of)))
        };
        let extents: Vec<(f64, f64)> = (0..objectives).map(extent).collect();
        let distance = |index: usize| -> f64 {
            let share = |(objective, (low, high)): (usize, &(f64, f64))| match high > low {
                true => (value(index, objective) - low) / (high - low),
                false => 0.0,
            };
            extents.iter().enumerate().map(share).map(|share| share * share).sum()
        };
        self.front.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
    }
}

/// Columns of the results that every optimisation has.
pub(super) const OWN_COLUMNS: [(&str, Kind); 9] = [
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

/// Every design as a row: number and generation, variables, objectives, the worst of each constraint, runs by how they ended, and
/// whether the design is feasible and on the front.
pub fn table(of: &Optimisation, found: &Found) -> Table {
    let own = |(name, kind): (&'static str, Kind)| Column::new(name, kind);
    let variables = of.variables.iter().map(|variable| Column::new(variable.column(), Kind::Number));
    let objectives = of.objectives.iter().map(|of| Column::new(of.figure.name.clone(), Kind::Number));
    let constraints = of.constraints.iter().map(|of| Column::new(format!("worst_{}", of.column), of.kind()));
    let [first, last] = [&OWN_COLUMNS[..2], &OWN_COLUMNS[2..]].map(|part| part.iter().copied().map(own));
    let columns = first.chain(variables).chain(objectives).chain(constraints).chain(last).collect();
    let mut on_front = vec![false; found.designs.len()];
    found.front.iter().for_each(|&index| on_front[index] = true);
    let row = |(design, on_front): (&Design, bool)| {
        let Judged { values, worst, by_status, score } = &design.judged;
        let mut row = vec![Value::Integer(design.number as i64), Value::Integer(design.generation as i64)];
        row.extend(design.points.iter().map(|point| point.value.clone()));
        row.extend(values.iter().map(|value| Value::from(*value)));
        row.extend(worst.iter().cloned());
        row.extend(by_status.map(|count| Value::Integer(count as i64)));
        row.extend([Value::Number(score.violation), Value::Flag(design.is_feasible()), Value::Flag(on_front)]);
        row
    };
    Table::new(columns, found.designs.iter().zip(on_front).map(row).collect())
}

/// How much better a value is than that of the start, as a share of the latter; below 0 if it is worse, `None` of nothing and of 0.
pub fn gain(goal: Goal, start: Option<f64>, value: Option<f64>) -> Option<f64> {
    let (start, value) = (start.filter(|start| *start != 0.0)?, value?);
    let less = (start - value) / start.abs();
    Some(if goal == Goal::Min { less } else { -less })
}

/// Whether the method names the front of several objectives or the best of one.
pub fn is_front(of: &Optimisation) -> bool {
    of.objectives.len() > 1 && of.method.algorithm == Algorithm::Nsga2
}
