//! Study files of optimisations: variables, conditions, objectives and constraints of the designs of a scene. The search is
//! part of the Python package.

mod figures;
mod study_file;
mod tables;
mod variables;

pub use study_file::{load, parse, schema};
pub use tables::{Aggregation, Algorithm, Goal, Over};

use std::path::PathBuf;

use serde::Serialize;
use serde_json::Value as Json;

use super::sweep::{AxisValue, Field, Range};
use crate::scene::Layer;
use crate::trace::Model;

/// A field that the search varies, with its range.
#[derive(Clone, Debug)]
pub struct Variable {
    pub field: Field,
    range: Range,
    start: AxisValue,
    /// Fraction of the range at which the start value lies.
    pub start_fraction: f64,
}

impl Variable {
    /// Returns the value at a fraction of the range, from 0 to 1. The start value is returned as it is written in the
    /// scene.
    pub fn value_at(&self, fraction: f64) -> AxisValue {
        if fraction == self.start_fraction { self.start.clone() } else { self.range.value_at(fraction, false) }
    }

    /// Returns the value at a fraction of the range, in SI units.
    pub fn si_at(&self, fraction: f64) -> f64 {
        self.range.si_at(fraction)
    }

    /// Whether the search measures distances by ratios of values, on a logarithmic scale.
    pub fn is_log(&self) -> bool {
        self.range.is_log()
    }
}

/// A figure to minimise or maximise.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Objective {
    /// Column of the results.
    pub name: String,
    /// Columns of a run from which the figure is computed.
    pub columns: Vec<String>,
    pub of: Aggregation,
    pub goal: Goal,
    pub over: Over,
}

/// A requirement that must be met under every condition. Bounds are in SI units.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Constraint {
    pub column: String,
    pub at_least: Option<f64>,
    pub at_most: Option<f64>,
    /// Required text or flag.
    pub equals: Option<Json>,
    /// Index of the worst class that is allowed, in the order of `Class::ALL`.
    pub worst_class: Option<usize>,
}

/// Parameters of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Method {
    pub algorithm: Algorithm,
    /// Number of designs per generation.
    pub population: u64,
    pub generations: u64,
    pub seed: u64,
}

/// A checked optimisation.
#[derive(Clone, Debug)]
pub struct Optimisation {
    pub name: String,
    pub description: String,
    pub model: Model,
    /// The base scene with the start values of the study, given as texts for `scene::parse_layers`.
    pub scene: Vec<Layer>,
    /// The study file, and the files of the base scene.
    pub files: Vec<PathBuf>,
    pub variables: Vec<Variable>,
    /// Fields and values of each condition. Without conditions, there is one empty condition.
    pub conditions: Vec<Vec<(String, AxisValue)>>,
    pub objectives: Vec<Objective>,
    pub constraints: Vec<Constraint>,
    pub method: Method,
    /// Name of the column that contains the verdict of a run; `None` for scenes without a grasp.
    pub verdict: Option<&'static str>,
    /// Keys of the study file, without `scene` and `set`.
    pub keys: toml::Table,
}
