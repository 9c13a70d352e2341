//! The JSON document of an optimisation.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::sweep::SweepWork;
use crate::study::optimize::{ConditionAggregation, Design, Goal, Limit, Optimisation, OptimisationResult, gain};
use crate::study::select::CLASSES;
use crate::study::sweep::{Reason, Status};
use crate::table::{Column, Value};
use crate::trace::Model;

/// Report of a finished optimisation.
#[derive(Clone, Debug, Serialize)]
pub struct OptimisationReport<'a> {
    #[serde(skip)]
    pub(super) optimisation: &'a Optimisation,
    #[serde(skip)]
    pub(super) found: &'a OptimisationResult,
    /// Maximum number of designs of the front in the text report.
    #[serde(skip)]
    pub max_designs: usize,
    /// Whether a scene file is written for each design of the front.
    #[serde(skip)]
    pub has_scenes: bool,
    pub name: String,
    pub model: &'static str,
    pub algorithm: &'static str,
    pub population: u64,
    pub seed: u64,
    /// Number of evaluated generations.
    pub generations: u64,
    /// Whether the search converged.
    #[serde(rename = "converged")]
    pub is_converged: bool,
    /// Number of runs per design.
    pub conditions: u64,
    pub designs: usize,
    pub feasible_designs: usize,
    pub runs: u64,
    /// Number of runs by status.
    pub by_status: BTreeMap<&'static str, u64>,
    /// Reasons why runs were not completed, or have no class.
    pub reasons: Vec<Reason>,
    pub variables: Vec<VariableReport>,
    pub objectives: Vec<ObjectiveReport>,
    pub constraints: Vec<ConstraintReport>,
    /// The design of the base scene, with which others are compared.
    pub start: DesignReport,
    /// The Pareto front of the feasible designs, sorted by the first objective.
    pub front: Vec<DesignReport>,
    /// Number of the design of the front that is closest to the best values of all objectives; null without such a
    /// front.
    pub compromise: Option<u64>,
    /// Gains of the best design for each objective and of the compromise.
    pub gains: Vec<GainReport>,
    /// Work of this invocation; the other results existed already.
    #[serde(rename = "now")]
    pub work: SweepWork,
}

/// A variable and its bounds, in SI units.
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

/// A constraint.
#[derive(Clone, Debug, Serialize)]
pub struct ConstraintReport {
    pub column: String,
    pub at_least: Option<Value>,
    pub at_most: Option<f64>,
    pub equals: Option<Value>,
}

/// A design: its values by column, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct DesignReport {
    pub design: u64,
    pub generation: u64,
    #[serde(rename = "feasible")]
    pub is_feasible: bool,
    pub violation: f64,
    pub variables: BTreeMap<String, Value>,
    pub objectives: BTreeMap<String, Option<f64>>,
    /// Worst value over the conditions.
    pub constraints: BTreeMap<String, Value>,
}

/// Gain of a design over the start, for each objective.
#[derive(Clone, Debug, Serialize)]
pub struct GainReport {
    /// `best tts_s` (with the name of the objective), or `compromise`.
    #[serde(rename = "of")]
    pub role: String,
    pub design: u64,
    /// Positive if the design is better; null if the start does not have the value.
    pub percent: BTreeMap<String, Option<f64>>,
}

impl<'a> OptimisationReport<'a> {
    pub fn new(
        (optimisation, found): (&'a Optimisation, &'a OptimisationResult),
        reasons: Vec<Reason>,
        work: SweepWork,
        max_designs: usize,
    ) -> Self {
        let design = |index: usize| DesignReport::new(optimisation, &found.designs[index]);
        let selected = selected_designs(optimisation, found);
        let by_status = Status::ALL.map(Status::name).into_iter().zip(found.by_status()).collect();
        OptimisationReport {
            optimisation,
            found,
            max_designs,
            has_scenes: false,
            name: optimisation.name().to_string(),
            model: Model::name(optimisation.study().model),
            algorithm: optimisation.method.algorithm.name(),
            population: optimisation.method.population,
            seed: optimisation.method.seed,
            generations: found.generations,
            is_converged: found.converged,
            conditions: optimisation.conditions(),
            designs: found.designs.len(),
            feasible_designs: found.feasible_count(),
            runs: found.by_status().iter().sum(),
            by_status,
            reasons,
            variables: optimisation.variables.iter().map(VariableReport::from).collect(),
            objectives: optimisation.objectives.iter().map(ObjectiveReport::from).collect(),
            constraints: optimisation.constraints.iter().map(ConstraintReport::from).collect(),
            start: DesignReport::new(optimisation, found.start()),
            front: found.front.iter().map(|&index| design(index)).collect(),
            compromise: found.compromise().map(|index| found.designs[index].number),
            gains: selected
                .into_iter()
                .map(|(role, index)| GainReport::new(optimisation, found, role, index))
                .collect(),
            work,
        }
    }
}

/// Returns the designs that are compared with the start: the best for each objective, and the compromise.
pub(super) fn selected_designs(optimisation: &Optimisation, found: &OptimisationResult) -> Vec<(String, usize)> {
    let has_several_objectives = optimisation.objectives.len() > 1;
    let best = |(index, objective): (usize, &crate::study::optimize::Objective)| {
        let name = if has_several_objectives { format!("best {}", objective.figure.name) } else { "best".to_string() };
        Some((name, found.best(index)?))
    };
    let mut selected: Vec<(String, usize)> = optimisation.objectives.iter().enumerate().filter_map(best).collect();
    selected.extend(found.compromise().map(|index| ("compromise".to_string(), index)));
    selected
}

/// Returns the file name of the scene of a design. The alphabetical order of the names is the numerical order.
pub fn scene_file(found: &OptimisationResult, design: &Design) -> String {
    let width = found.designs.len().to_string().len();
    format!("design-{:0width$}.toml", design.number)
}

impl GainReport {
    fn new(optimisation: &Optimisation, found: &OptimisationResult, role: String, index: usize) -> Self {
        let (start, design) = (found.start(), &found.designs[index]);
        let pairs = start.evaluation.values.iter().zip(&design.evaluation.values);
        let percent = optimisation.objectives.iter().zip(pairs).map(|(objective, (start, value))| {
            (objective.figure.name.clone(), gain(objective.goal, *start, *value).map(|ratio| 100.0 * ratio))
        });
        GainReport { role, design: design.number, percent: percent.collect() }
    }
}

impl From<&crate::study::optimize::Variable> for VariableReport {
    fn from(variable: &crate::study::optimize::Variable) -> Self {
        let [from, to] = variable.bounds().map(|point| match point.value {
            Value::Number(number) => Some(number),
            _ => None,
        });
        let spacing = if variable.is_logarithmic() { "log" } else { "linear" };
        VariableReport { column: variable.column(), from, to, spacing }
    }
}

impl From<&crate::study::optimize::Objective> for ObjectiveReport {
    fn from(objective: &crate::study::optimize::Objective) -> Self {
        ObjectiveReport {
            name: objective.figure.name.clone(),
            columns: objective.figure.columns.clone(),
            goal: if objective.goal == Goal::Min { "min" } else { "max" },
            over: if objective.condition_aggregation == ConditionAggregation::Worst { "worst" } else { "mean" },
        }
    }
}

impl From<&crate::study::optimize::Constraint> for ConstraintReport {
    fn from(constraint: &crate::study::optimize::Constraint) -> Self {
        let no_limit =
            ConstraintReport { column: constraint.column.clone(), at_least: None, at_most: None, equals: None };
        match &constraint.limit {
            Limit::Between { at_least, at_most } => {
                ConstraintReport { at_least: at_least.map(Value::Number), at_most: *at_most, ..no_limit }
            }
            Limit::Flag(flag) => ConstraintReport { equals: Some(Value::Flag(*flag)), ..no_limit },
            Limit::Equals(word) => ConstraintReport { equals: Some(Value::Text(word.clone())), ..no_limit },
            Limit::Class(rank) => ConstraintReport { at_least: Some(Value::from(CLASSES[*rank].name())), ..no_limit },
        }
    }
}

impl DesignReport {
    fn new(optimisation: &Optimisation, design: &Design) -> Self {
        let evaluation = &design.evaluation;
        let variables = optimisation.variables.iter().zip(&design.points);
        let objectives = optimisation.objectives.iter().zip(&evaluation.values);
        let constraints = optimisation.constraints.iter().zip(&evaluation.worst);
        DesignReport {
            design: design.number,
            generation: design.generation,
            is_feasible: design.is_feasible(),
            violation: evaluation.score.violation,
            variables: variables.map(|(variable, point)| (variable.column(), point.value.clone())).collect(),
            objectives: objectives.map(|(objective, value)| (objective.figure.name.clone(), *value)).collect(),
            constraints: constraints.map(|(constraint, value)| (constraint.column.clone(), value.clone())).collect(),
        }
    }
}

/// Whether a table with these columns is a table of designs.
pub fn is_design_table(columns: &[Column]) -> bool {
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    names.starts_with(&["design", "generation"]) && names.ends_with(&["violation", "feasible", "front"])
}
