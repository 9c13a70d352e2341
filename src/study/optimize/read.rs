//! Reading and checking of an optimisation file.

use std::path::Path;

use toml::{Table, Value as Toml};

use super::cmaes::CmaEs;
use super::problem::{Algorithm, Method, Optimisation, Variable};
use super::raw::{RawMethod, RawOptimisation, RawVariable, schema_json};
use super::read_goals::{constraints, objectives};
use crate::scene::check::Checker;
use crate::scene::entry::Section;
use crate::scene::keywords::SceneKind;
use crate::study::sweep::{
    AxisValue, Field, MAX_RUNS, Range, RawAxis, StudyDocument, StudyError, StudySpec, SweepAxis, file_stem, find_field,
    invalid_study, parse_document, read_axes, read_filter, read_range, read_study_file, read_value,
    study_without_designs,
};
use crate::table::Value;
use crate::trace::Model;

/// Default number of designs per generation of NSGA-II.
const NSGA2_POPULATION: u64 = 64;
/// Default number of generations of NSGA-II: sufficient for the fronts of the tests, within seconds on two cores.
const NSGA2_GENERATIONS: u64 = 50;
/// Default maximum number of generations of CMA-ES, which usually converges earlier.
const CMA_ES_GENERATIONS: u64 = 100;

/// A variable before the start value is read from the base scene.
struct RangedField {
    field: Field,
    range: Range,
    start: Option<AxisValue>,
}

/// Reads and checks an optimisation file and its base scene.
///
/// # Errors
/// Returns the problem in either file, with file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Optimisation, StudyError> {
    let (text, file) = read_study_file(path.as_ref())?;
    parse(&text, &file)
}

/// Checks the text of an optimisation. `file_name` appears in messages, provides the default name, and sets the
/// directory for the path of the base scene.
///
/// # Errors
/// Returns the problem in the optimisation or its base scene.
pub fn parse(text: &str, file_name: &str) -> Result<Optimisation, StudyError> {
    let StudyDocument { raw, kind, problems, scene } =
        parse_document(text, file_name, &schema_json(), |raw: &RawOptimisation| &raw.scene)?;
    let invalid = |problems| invalid_study(text, file_name, problems);
    let mut checker = Checker::new(text, problems);
    scene.check(&mut checker, &raw.scene);
    let ranged_fields = variables(&mut checker, &raw.variables, kind);
    let conditions = conditions(&mut checker, &raw.conditions, kind, &ranged_fields);
    // A row starts with two numbers, followed by variables and conditions.
    let leading_columns = 2 + ranged_fields.len() + conditions.iter().map(|axis| axis.fields.len()).sum::<usize>();
    let objectives = objectives(&mut checker, &raw.objectives, kind, leading_columns);
    let constraints = constraints(&mut checker, &raw.constraints, kind, leading_columns);
    let filter = read_filter(&mut checker, &raw.filter, kind);
    let method = method(&mut checker, &raw.method, objectives.len(), ranged_fields.len());
    let name = checker.get("name", &raw.name).unwrap_or_else(|| file_stem(file_name));
    let description = checker.get("description", &raw.description).unwrap_or_default();
    let model = checker.get_or("model", &raw.model, Model::Analytic);
    if !checker.is_clean() {
        return Err(invalid(checker.into_problems()));
    }

    let (scene, base) = scene.assemble(text, file_name)?;
    let mut checker = Checker::new(text, Vec::new());
    let variables: Vec<Variable> = ranged_fields
        .into_iter()
        .zip(&raw.variables)
        .filter_map(|(field, raw)| variable(&mut checker, field, raw, &scene))
        .collect();
    report_duplicates(&mut checker, &variables, &objectives, &constraints, &raw);
    if !checker.is_clean() {
        return Err(invalid(checker.into_problems()));
    }
    let fields = variables.iter().map(|variable| variable.field.clone()).collect();
    let source = text.to_string();
    let spec = StudySpec { kind, name, description, model, filter, fields, conditions, scene, base, source };
    let read_error = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let study = study_without_designs(spec).map_err(read_error)?;
    let optimisation = Optimisation { variables, objectives, constraints, method, study };
    let Method { population, generations, .. } = method;
    let max_runs =
        population.checked_mul(generations).and_then(|designs| designs.checked_mul(optimisation.conditions()));
    if max_runs.is_none_or(|runs| runs >= MAX_RUNS) {
        let checker = Checker::new(text, Vec::new());
        checker.push(
            raw.method.span.clone(),
            format!("the optimisation has more than {MAX_RUNS} runs"),
            "population times generations times conditions",
            "reduce population, generations or conditions",
        );
        return Err(invalid(checker.into_problems()));
    }
    let runs = optimisation.max_runs();
    Ok(Optimisation { study: optimisation.study.with_run_count(runs), ..optimisation })
}

fn variables(checker: &mut Checker<'_>, raw: &[Section<RawVariable>], kind: SceneKind) -> Vec<RangedField> {
    if raw.is_empty() && checker.is_clean() {
        let help = "add the fields to vary: [[variables]] with field, from and to";
        checker.push(None, "there are no [[variables]]", "", help);
    }
    let mut variables: Vec<RangedField> = Vec::new();
    for raw in raw {
        if !raw.field.is_present() {
            checker.report_missing("field", raw, "name the scene field to vary: field = \"design.base\"");
            continue;
        }
        let Some(path) = checker.get("field", &raw.field) else { continue };
        let Some(field) = find_field(checker, &path, raw.field.span(), kind) else { continue };
        if variables.iter().any(|other| other.field.path == field.path) {
            let message = format!("`{path}` is declared twice");
            checker.push(raw.field.span(), message, "repeated here", "remove one of them");
            continue;
        }
        let Some(range) = read_range(checker, raw, &field, [&raw.from, &raw.to], &raw.spacing) else { continue };
        let start = match checker.get("start", &raw.start) {
            Some(value) => read_value(checker, &field, &value),
            None => None,
        };
        variables.push(RangedField { field, range, start });
    }
    variables
}

/// Reads the conditions: axes with values that are not variables.
fn conditions(
    checker: &mut Checker<'_>,
    raw: &[Section<RawAxis>],
    kind: SceneKind,
    variables: &[RangedField],
) -> Vec<SweepAxis> {
    for raw in raw {
        checker.report_unused("again", &raw.again, "in a condition: conditions always repeat the designs");
        if raw.from.is_present() && raw.to.is_present() && !raw.count.is_present() {
            checker.report_missing("count", raw, "give the number of values of the range: count = 3");
        }
    }
    let mut axes = read_axes(checker, raw, kind);
    axes.retain(|axis| axis.len().is_some());
    for (axis, raw) in axes.iter_mut().zip(raw) {
        axis.repeats_designs = true;
        if let Some(field) =
            axis.fields.iter().find(|field| variables.iter().any(|variable| variable.field.path == field.path))
        {
            let message = format!("`{}` is both a variable and a condition", field.path);
            let help = "remove one of them: a field can be either varied or prescribed";
            checker.push(raw.field.span().or(raw.fields.span()), message, "also a condition", help);
        }
    }
    axes
}

/// Completes a variable with its start value from the file or the base scene.
fn variable(
    checker: &mut Checker<'_>,
    ranged: RangedField,
    raw: &Section<RawVariable>,
    scene: &Table,
) -> Option<Variable> {
    let RangedField { field, range, start } = ranged;
    let span = raw.start.span().or(raw.field.span());
    let start = match (start, lookup(scene, &field.path)) {
        (Some(start), _) => start,
        (None, Some(value)) => field.parse_toml(&value.to_string()).ok()?,
        (None, None) => {
            let message = format!("the base scene has no start value for `{}`", field.path);
            checker.push(span, message, "no start", "give a start value: start = .., or add the field to the scene");
            return None;
        }
    };
    let Value::Number(start_si) = start.value else { return None };
    let start_fraction = range.fraction_of(start_si);
    if !(0.0..=1.0).contains(&start_fraction) {
        let message =
            format!("the start value of `{}`, {}, is outside its range", field.path, start.text.trim_matches('"'));
        let help = "widen the range, or give a start value within it: start = ..";
        checker.push(span, message, "outside the range", help);
        return None;
    }
    Some(Variable { field, range, start, start_fraction })
}

/// Returns the value at a path of a scene.
fn lookup<'a>(table: &'a Table, path: &str) -> Option<&'a Toml> {
    match path.split_once('.') {
        None => table.get(path),
        Some((key, rest)) => lookup(table.get(key)?.as_table()?, rest),
    }
}

/// Reports columns of the results with equal names, and constraints on the same column.
fn report_duplicates(
    checker: &mut Checker<'_>,
    variables: &[Variable],
    objectives: &[super::problem::Objective],
    constraints: &[super::problem::Constraint],
    raw: &RawOptimisation,
) {
    let mut names: Vec<String> = variables.iter().map(Variable::column).collect();
    names.extend(super::result::FIXED_COLUMNS.map(|(name, _)| name.to_string()));
    for (objective, raw) in objectives.iter().zip(&raw.objectives) {
        if names.contains(&objective.figure.name) {
            let message = format!("the results would have two columns `{}`", objective.figure.name);
            let span = raw.name.span().or(raw.column.span()).or(raw.columns.span());
            checker.push(span, message, "duplicate name", "give the objective another name: name = ..");
        }
        names.push(objective.figure.name.clone());
    }
    for (index, constraint) in constraints.iter().enumerate() {
        if constraints[..index].iter().any(|other| other.column == constraint.column) {
            let message = format!("there are two constraints on `{}`", constraint.column);
            let span = raw.constraints.get(index).and_then(|raw| raw.column.span());
            checker.push(span, message, "repeated here", "combine them into one with at_least and at_most");
        }
    }
}

fn method(checker: &mut Checker<'_>, raw: &Section<RawMethod>, objectives: usize, variables: usize) -> Method {
    let default_algorithm = if objectives == 1 { Algorithm::CmaEs } else { Algorithm::Nsga2 };
    let algorithm = checker.get_or("method.algorithm", &raw.algorithm, default_algorithm);
    if algorithm == Algorithm::CmaEs && objectives > 1 {
        let message = format!("\"cma-es\" supports one objective, but the file has {objectives}");
        checker.push(
            raw.algorithm.span(),
            message,
            "one objective only",
            "use algorithm = \"nsga2\", or keep one objective",
        );
    }
    let (population, generations) = match algorithm {
        Algorithm::Nsga2 => (NSGA2_POPULATION, NSGA2_GENERATIONS),
        Algorithm::CmaEs => (CmaEs::default_population(variables.max(1)) as u64, CMA_ES_GENERATIONS),
    };
    let population = checker.get_or("method.population", &raw.population, population);
    if population < 4 {
        let message = format!("`method.population` is {population}, but a generation has at least 4 designs");
        checker.push(
            raw.population.span(),
            message,
            "too few",
            "use 4 or more; about ten times the number of variables is usual",
        );
    }
    let generations = checker.get_or("method.generations", &raw.generations, generations);
    Method { algorithm, population, generations, seed: checker.get_or("method.seed", &raw.seed, 1) }
}
