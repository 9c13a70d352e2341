//! Optimisation problem: variables, objectives, constraints and search method.

use crate::study::sweep::{AxisValue, Field, FieldType, Range, Spacing, Study};
use crate::table::Kind;
use crate::trace::Model;

/// Direction of an objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    Min,
    Max,
}

/// Aggregation of an objective over the conditions of a design.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConditionAggregation {
    Worst,
    Mean,
}

/// Aggregation of several columns of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnAggregation {
    Largest,
    Smallest,
    Sum,
}

/// Search algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    Nsga2,
    CmaEs,
}

impl Algorithm {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Algorithm::Nsga2 => "NSGA-II",
            Algorithm::CmaEs => "CMA-ES",
        }
    }
}

/// Parameters of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    pub algorithm: Algorithm,
    /// Number of designs per generation.
    pub population: u64,
    /// Maximum number of generations.
    pub generations: u64,
    pub seed: u64,
}

/// A field that is varied within a range.
#[derive(Clone, Debug)]
pub struct Variable {
    pub(super) field: Field,
    pub(super) range: Range,
    /// Start value: the one given in the file, or the value in the base scene.
    pub(super) start: AxisValue,
    /// Start value as a fraction of the range.
    pub(super) start_fraction: f64,
}

impl Variable {
    /// Returns the path of the field in a scene.
    pub fn path(&self) -> &str {
        &self.field.path
    }

    /// Returns the column name: the path with the unit of the SI value.
    pub fn column(&self) -> String {
        self.field.column()
    }

    /// Returns the start value of the search.
    pub fn start(&self) -> &AxisValue {
        &self.start
    }

    /// Returns the bounds as scene values.
    pub fn bounds(&self) -> [AxisValue; 2] {
        [self.range.value_at(0.0, false), self.range.value_at(1.0, false)]
    }

    /// Returns whether the range has logarithmic spacing.
    pub fn is_logarithmic(&self) -> bool {
        self.range.spacing == Spacing::Log
    }

    /// Returns the value at a fraction of the range, from 0 to 1.
    pub(super) fn value_at(&self, fraction: f64) -> AxisValue {
        if fraction == self.start_fraction { self.start.clone() } else { self.range.value_at(fraction, false) }
    }
}

/// A figure of a run, from one column or several.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name with the unit of the SI value.
    pub name: String,
    pub columns: Vec<String>,
    pub aggregation: ColumnAggregation,
    /// Type of the columns; plain numbers if their types differ.
    pub column_type: FieldType,
    /// Indices of the columns in a row.
    pub(super) cells: Vec<usize>,
}

/// A figure to be minimised or maximised.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    pub figure: Figure,
    pub goal: Goal,
    pub condition_aggregation: ConditionAggregation,
}

/// A requirement that must be satisfied under every condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    pub column: String,
    pub limit: Limit,
    pub(super) cell: usize,
}

/// Limit of a constraint.
#[derive(Clone, Debug, PartialEq)]
pub enum Limit {
    /// Range of numbers in SI units.
    Between {
        at_least: Option<f64>,
        at_most: Option<f64>,
    },
    Flag(bool),
    Equals(String),
    /// Worst class allowed, as its index from good to bad.
    Class(usize),
}

impl Constraint {
    /// Returns the kind of its column in the results, which contains the worst value over the conditions.
    pub fn kind(&self) -> Kind {
        match self.limit {
            Limit::Between { .. } => Kind::Number,
            Limit::Flag(_) => Kind::Flag,
            Limit::Equals(_) | Limit::Class(_) => Kind::Text,
        }
    }
}

/// A validated optimisation problem.
#[derive(Clone, Debug)]
pub struct Optimisation {
    pub variables: Vec<Variable>,
    pub objectives: Vec<Objective>,
    pub constraints: Vec<Constraint>,
    pub method: Method,
    /// Scene, conditions, model and filter; designs are inserted during the search.
    pub(super) study: Study,
}

impl Optimisation {
    /// Returns the name in reports.
    pub fn name(&self) -> &str {
        &self.study.name
    }

    /// Returns the description; empty if none is given.
    pub fn description(&self) -> &str {
        &self.study.description
    }

    /// Returns the study whose rows are the runs of the optimisation; it defines their columns, file and fingerprint.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Sets the model, instead of the file's.
    pub fn set_model(&mut self, model: Model) {
        self.study.model = model;
    }

    /// Returns the number of runs per design.
    pub fn conditions(&self) -> u64 {
        self.study.conditions()
    }

    /// Returns the maximum number of designs.
    pub fn max_design_count(&self) -> u64 {
        let Method { algorithm, population, generations, .. } = self.method;
        match algorithm {
            Algorithm::Nsga2 => population * generations,
            // CMA-ES evaluates the start as a separate generation.
            Algorithm::CmaEs => 1 + population * generations,
        }
    }

    /// Returns the maximum number of runs.
    pub fn max_runs(&self) -> u64 {
        self.max_design_count() * self.conditions()
    }

    /// Returns the scene file of a design under its first condition.
    pub fn scene_text(&self, points: &[AxisValue]) -> String {
        self.study.with_rows(vec![points.to_vec()]).scene_text(1)
    }
}
