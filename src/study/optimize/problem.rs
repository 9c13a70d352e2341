//! What is optimised: variables, objectives, constraints, and how it is searched.

use crate::study::sweep::{Field, Holds, Point, Range, Spacing, Study};
use crate::table::Kind;
use crate::trace::Model;

/// Which way of an objective is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    Min,
    Max,
}

/// What is taken of the conditions that a design runs under.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    Worst,
    Mean,
}

/// What is taken of several columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Of {
    Largest,
    Smallest,
    Sum,
}

/// How it is searched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    Nsga2,
    CmaEs,
}

impl Algorithm {
    /// As people write it.
    pub fn name(self) -> &'static str {
        match self {
            Algorithm::Nsga2 => "NSGA-II",
            Algorithm::CmaEs => "CMA-ES",
        }
    }
}

/// The search: which, and how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    pub algorithm: Algorithm,
    /// Designs of a generation.
    pub population: u64,
    /// Generations at most.
    pub generations: u64,
    pub seed: u64,
}

/// A field that may change, within its range.
#[derive(Clone, Debug)]
pub struct Variable {
    pub(super) field: Field,
    pub(super) range: Range,
    /// Its value in the base scene.
    pub(super) start: Point,
    /// The same as a share of the range.
    pub(super) start_share: f64,
}

impl Variable {
    /// Path of the field in a scene.
    pub fn path(&self) -> &str {
        &self.field.path
    }

    /// Name of its column: the path with the unit of its SI value.
    pub fn column(&self) -> String {
        self.field.column()
    }

    /// Its value in the base scene, where the search begins.
    pub fn start(&self) -> &Point {
        &self.start
    }

    /// The bounds as values of a scene.
    pub fn bounds(&self) -> [Point; 2] {
        [self.range.at(0.0, false), self.range.at(1.0, false)]
    }

    /// Whether equal ratios rather than equal differences count as equally far.
    pub fn is_logarithmic(&self) -> bool {
        self.range.spacing == Spacing::Log
    }

    /// The value that lies so far along the range, from 0 to 1.
    pub(super) fn at(&self, share: f64) -> Point {
        if share == self.start_share { self.start.clone() } else { self.range.at(share, false) }
    }
}

/// A figure of a run: that of one column, or one of several.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name with the unit of its SI value.
    pub name: String,
    pub columns: Vec<String>,
    pub of: Of,
    /// What all of the columns hold; plain numbers where they differ.
    pub holds: Holds,
    /// Where the columns are in a row.
    pub(super) cells: Vec<usize>,
}

/// What is to be made small or large.
#[derive(Clone, Debug, PartialEq)]
pub struct Objective {
    pub figure: Figure,
    pub goal: Goal,
    pub over: Over,
}

/// What has to hold under every condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraint {
    pub column: String,
    pub limit: Limit,
    pub(super) cell: usize,
}

/// What a constraint allows.
#[derive(Clone, Debug, PartialEq)]
pub enum Limit {
    /// Numbers in SI.
    Between {
        at_least: Option<f64>,
        at_most: Option<f64>,
    },
    Flag(bool),
    Word(String),
    /// The worst class allowed, as its place among all from good to bad.
    Class(usize),
}

impl Constraint {
    /// What its column in the results holds: the worst over the conditions.
    pub fn kind(&self) -> Kind {
        match self.limit {
            Limit::Between { .. } => Kind::Number,
            Limit::Flag(_) => Kind::Flag,
            Limit::Word(_) | Limit::Class(_) => Kind::Text,
        }
    }
}

/// An optimisation that can be run.
#[derive(Clone, Debug)]
pub struct Optimisation {
    pub variables: Vec<Variable>,
    pub objectives: Vec<Objective>,
    pub constraints: Vec<Constraint>,
    pub method: Method,
    /// Scene, conditions, model, and filter; designs are put in as they are asked for.
    pub(super) study: Study,
}

impl Optimisation {
    /// The name in reports.
    pub fn name(&self) -> &str {
        &self.study.name
    }

    /// What it is for; empty if nothing was said.
    pub fn description(&self) -> &str {
        &self.study.description
    }

    /// The study that its runs are rows of: for their columns, their file, and their fingerprint.
    pub fn study(&self) -> &Study {
        &self.study
    }

    /// Simulates with this model instead of the file's.
    pub fn simulate_with(&mut self, model: Model) {
        self.study.model = model;
    }

    /// How often each design runs.
    pub fn conditions(&self) -> u64 {
        self.study.conditions()
    }

    /// How many designs there are at most.
    pub fn most_designs(&self) -> u64 {
        let Method { algorithm, population, generations, .. } = self.method;
        match algorithm {
            Algorithm::Nsga2 => population * generations,
            // The start has a generation of its own.
            Algorithm::CmaEs => 1 + population * generations,
        }
    }

    /// How many runs there are at most.
    pub fn most_runs(&self) -> u64 {
        self.most_designs() * self.conditions()
    }

    /// The scene of a design under the first of its conditions, as the text of a file.
    pub fn scene_text(&self, points: &[Point]) -> String {
        self.study.with_rows(vec![points.to_vec()]).scene_text(1)
    }
}
