//! One document of plain figures.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::sweep::SweepWork;
use crate::study::optimize::{Design, Found, Goal, Limit, Optimisation, Over, gain};
use crate::study::select::CLASSES;
use crate::study::sweep::{Reason, Status};
use crate::table::{Column, Value};
use crate::trace::Model;

/// A finished optimisation.
#[derive(Clone, Debug, Serialize)]
pub struct OptimisationReport<'a> {
    #[serde(skip)]
    pub(super) of: &'a Optimisation,
    #[serde(skip)]
    pub(super) found: &'a Found,
    /// How many designs of the front are told to people.
    #[serde(skip)]
    pub most: usize,
    /// Whether each design of the front is a scene file.
    #[serde(skip)]
    pub scenes: bool,
    pub name: String,
    pub model: &'static str,
    pub algorithm: &'static str,
    pub population: u64,
    pub seed: u64,
    /// Generations that were looked at; `converged`: there was nothing left to find.
    pub generations: u64,
    pub converged: bool,
    /// How often each design runs.
    pub conditions: u64,
    pub designs: usize,
    pub feasible_designs: usize,
    pub runs: u64,
    /// Runs by how they ended.
    pub by_status: BTreeMap<&'static str, u64>,
    /// Why runs were not completed, or have no class.
    pub reasons: Vec<Reason>,
    pub variables: Vec<VariableReport>,
    pub objectives: Vec<ObjectiveReport>,
    pub constraints: Vec<ConstraintReport>,
    /// The base scene, with which all is compared.
    pub start: DesignReport,
    /// The feasible designs that no other one beats, by the first objective.
    pub front: Vec<DesignReport>,
    /// Number of the design that is near to the best by every objective; null if there is no such front.
    pub compromise: Option<u64>,
    /// What is gained by the best of each objective and by the compromise.
    pub gains: Vec<GainReport>,
    /// What was done now; all else was there already.
    pub now: SweepWork,
}

/// A variable and its bounds, in SI.
#[derive(Clone, Debug, Serialize)]
pub struct VariableReport {
    pub column: String,
    pub from: Option<f64>,
    pub to: Option<f64>,
    pub spacing: &'static str,
}

/// An objective.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectiveReport {
    pub name: String,
    pub columns: Vec<String>,
    pub goal: &'static str,
    pub over: &'static str,
}

/// A constraint in words and figures.
#[derive(Clone, Debug, Serialize)]
pub struct ConstraintReport {
    pub column: String,
    pub at_least: Option<Value>,
    pub at_most: Option<f64>,
    pub equals: Option<Value>,
}

/// A design: its values by their columns, in SI.
#[derive(Clone, Debug, Serialize)]
pub struct DesignReport {
    pub design: u64,
    pub generation: u64,
    pub feasible: bool,
    pub violation: f64,
    pub variables: BTreeMap<String, Value>,
    pub objectives: BTreeMap<String, Option<f64>>,
    /// The worst over the conditions.
    pub constraints: BTreeMap<String, Value>,
}

/// What a design gains over the start, by each objective.
#[derive(Clone, Debug, Serialize)]
pub struct GainReport {
    /// `best tts_s`, or `compromise`.
    pub of: String,
    pub design: u64,
    /// Above 0 if it is better; null where the start has no such figure.
    pub percent: BTreeMap<String, Option<f64>>,
}

impl<'a> OptimisationReport<'a> {
    pub fn new((of, found): (&'a Optimisation, &'a Found), reasons: Vec<Reason>, now: SweepWork, most: usize) -> Self {
        let design = |index: usize| DesignReport::new(of, &found.designs[index]);
        let chosen: Vec<(String, usize)> = chosen(of, found);
        let by_status = Status::ALL.map(Status::name).into_iter().zip(found.by_status()).collect();
        OptimisationReport {
            of,
            found,
            most,
            scenes: false,
            name: of.name().to_string(),
            model: Model::name(of.study().model),
            algorithm: of.method.algorithm.name(),
            population: of.method.population,
            seed: of.method.seed,
            generations: found.generations,
            converged: found.converged,
            conditions: of.conditions(),
            designs: found.designs.len(),
            feasible_designs: found.feasible(),
            runs: found.by_status().iter().sum(),
            by_status,
            reasons,
            variables: of.variables.iter().map(VariableReport::from).collect(),
            objectives: of.objectives.iter().map(ObjectiveReport::from).collect(),
            constraints: of.constraints.iter().map(ConstraintReport::from).collect(),
            start: DesignReport::new(of, found.start()),
            front: found.front.iter().map(|&index| design(index)).collect(),
            compromise: found.compromise().map(|index| found.designs[index].number),
            gains: chosen.into_iter().map(|(name, index)| GainReport::new(of, found, name, index)).collect(),
            now,
        }
    }
}

/// The designs that are compared with the start: the best of each objective, and the compromise; each once.
pub(super) fn chosen(of: &Optimisation, found: &Found) -> Vec<(String, usize)> {
    let several = of.objectives.len() > 1;
    let best = |(index, objective): (usize, &crate::study::optimize::Objective)| {
        let name = if several { format!("best {}", objective.figure.name) } else { "best".to_string() };
        Some((name, found.best(index)?))
    };
    let mut all: Vec<(String, usize)> = of.objectives.iter().enumerate().filter_map(best).collect();
    all.extend(found.compromise().map(|index| ("compromise".to_string(), index)));
    all
}

/// File of a design among the scenes of the front: the order of names is that of numbers.
pub fn scene_file(found: &Found, design: &Design) -> String {
    let width = found.designs.len().to_string().len();
    format!("design-{:0width$}.toml", design.number)
}

impl GainReport {
    fn new(of: &Optimisation, found: &Found, name: String, index: usize) -> Self {
        let (start, design) = (found.start(), &found.designs[index]);
        let pairs = start.judged.values.iter().zip(&design.judged.values);
        let percent = of.objectives.iter().zip(pairs).map(|(objective, (start, value))| {
            (objective.figure.name.clone(), gain(objective.goal, *start, *value).map(|share| 100.0 * share))
        });
        GainReport { of: name, design: design.number, percent: percent.collect() }
    }
}

impl From<&crate::study::optimize::Variable> for VariableReport {
    fn from(of: &crate::study::optimize::Variable) -> Self {
        let [from, to] = of.bounds().map(|point| match point.value {
            Value::Number(number) => Some(number),
            _ => None,
        });
        VariableReport { column: of.column(), from, to, spacing: if of.is_logarithmic() { "log" } else { "linear" } }
    }
}

impl From<&crate::study::optimize::Objective> for ObjectiveReport {
    fn from(of: &crate::study::optimize::Objective) -> Self {
        ObjectiveReport {
            name: of.figure.name.clone(),
            columns: of.figure.columns.clone(),
            goal: if of.goal == Goal::Min { "min" } else { "max" },
            over: if of.over == Over::Worst { "worst" } else { "mean" },
        }
    }
}

impl From<&crate::study::optimize::Constraint> for ConstraintReport {
    fn from(of: &crate::study::optimize::Constraint) -> Self {
        let none = ConstraintReport { column: of.column.clone(), at_least: None, at_most: None, equals: None };
        match &of.limit {
            Limit::Between { at_least, at_most } => {
                ConstraintReport { at_least: at_least.map(Value::Number), at_most: *at_most, ..none }
            }
            Limit::Flag(flag) => ConstraintReport { equals: Some(Value::Flag(*flag)), ..none },
            Limit::Word(word) => ConstraintReport { equals: Some(Value::Text(word.clone())), ..none },
            Limit::Class(rank) => ConstraintReport { at_least: Some(Value::from(CLASSES[*rank].name())), ..none },
        }
    }
}

impl DesignReport {
    fn new(of: &Optimisation, design: &Design) -> Self {
        let judged = &design.judged;
        let variables = of.variables.iter().zip(&design.points);
        let objectives = of.objectives.iter().zip(&judged.values);
        let constraints = of.constraints.iter().zip(&judged.worst);
        DesignReport {
            design: design.number,
            generation: design.generation,
            feasible: design.is_feasible(),
            violation: judged.score.violation,
            variables: variables.map(|(of, point)| (of.column(), point.value.clone())).collect(),
            objectives: objectives.map(|(of, value)| (of.figure.name.clone(), *value)).collect(),
            constraints: constraints.map(|(of, value)| (of.column.clone(), value.clone())).collect(),
        }
    }
}

/// Whether columns are those of a table of designs.
pub fn is_designs(columns: &[Column]) -> bool {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    names.starts_with(&["design", "generation"]) && names.ends_with(&["violation", "feasible", "front"])
}
