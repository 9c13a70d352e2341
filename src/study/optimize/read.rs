//! From the file of an optimisation to the optimisation.

use std::path::Path;

use toml::{Table, Value as Toml};

use super::cmaes::CmaEs;
use super::problem::{Algorithm, Method, Optimisation, Variable};
use super::raw::{RawMethod, RawOptimisation, RawVariable, schema_json};
use super::read_goals::{constraints, objectives};
use crate::scene::check::Checker;
use crate::scene::entry::Section;
use crate::scene::words::SceneKind;
use crate::study::sweep::{
    Designs, Document, Field, MOST_RUNS, Point, Range, RawAxis, StudyError, SweepAxis, axes, between, document, field,
    filter_of, of_designs, read, refused, stem, text_of,
};
use crate::table::Value;
use crate::trace::Model;

/// Designs of a generation of NSGA-II, and how many generations: enough for the fronts of the tests, seconds of two cores.
const POPULATION: u64 = 64;
const GENERATIONS: u64 = 50;
/// Generations of CMA-ES, which mostly converges before.
const GENERATIONS_OF_ONE: u64 = 100;

/// A variable as far as the file alone says what it is.
struct Ranged {
    field: Field,
    range: Range,
    start: Option<Point>,
}

/// Reads and checks the file of an optimisation and the base scene it names.
///
/// # Errors
/// What is wrong with either, with file, line and column.
pub fn load(path: impl AsRef<Path>) -> Result<Optimisation, StudyError> {
    let (text, file) = text_of(path.as_ref())?;
    parse(&text, &file)
}

/// Checks the text of an optimisation; `file_name` appears in messages, gives the default name, and the directory from which a base
/// scene is looked for.
///
/// # Errors
/// What is wrong with the optimisation or its base scene.
pub fn parse(text: &str, file_name: &str) -> Result<Optimisation, StudyError> {
    let Document { raw, kind, problems, scene } =
        document(text, file_name, &schema_json(), |raw: &RawOptimisation| &raw.scene)?;
    let refuse = |problems| refused(text, file_name, problems);
    let mut c = Checker::new(text, problems);
    scene.check(&mut c, &raw.scene);
    let ranged = variables(&mut c, &raw.variables, kind);
    let conditions = conditions(&mut c, &raw.conditions, kind, &ranged);
    // In a row stand two numbers, then variables and conditions.
    let before = 2 + ranged.len() + conditions.iter().map(|axis| axis.fields.len()).sum::<usize>();
    let objectives = objectives(&mut c, &raw.objectives, kind, before);
    let constraints = constraints(&mut c, &raw.constraints, kind, before);
    let filter = filter_of(&mut c, &raw.filter, kind);
    let method = method(&mut c, &raw.method, objectives.len(), ranged.len());
    let name = c.get("name", &raw.name).unwrap_or_else(|| stem(file_name));
    let description = c.get("description", &raw.description).unwrap_or_default();
    let model = c.or("model", &raw.model, Model::Analytic);
    if !c.is_clean() {
        return Err(refuse(c.into_problems()));
    }

    let (scene, base) = scene.put_together(text, file_name)?;
    let mut c = Checker::new(text, Vec::new());
    let variables: Vec<Variable> =
        ranged.into_iter().zip(&raw.variables).filter_map(|(of, raw)| variable(&mut c, of, raw, &scene)).collect();
    twice(&mut c, &variables, &objectives, &constraints, &raw);
    if !c.is_clean() {
        return Err(refuse(c.into_problems()));
    }
    let fields = variables.iter().map(|of| of.field.clone()).collect();
    let source = text.to_string();
    let designs = Designs { kind, name, description, model, filter, fields, conditions, scene, base, source };
    let broken = |reason: String| StudyError::Read { file: file_name.to_string(), reason };
    let study = of_designs(designs).map_err(broken)?;
    let found = Optimisation { variables, objectives, constraints, method, study };
    let Method { population, generations, .. } = method;
    let most = population.checked_mul(generations).and_then(|designs| designs.checked_mul(found.conditions()));
    if most.is_none_or(|runs| runs >= MOST_RUNS) {
        let mut c = Checker::new(text, Vec::new());
        c.push(
            raw.method.span.clone(),
            format!("the optimisation has more than {MOST_RUNS} runs"),
            "population times generations times conditions",
            "take fewer designs (population), generations or conditions",
        );
        return Err(refuse(c.into_problems()));
    }
    let runs = found.most_runs();
    Ok(Optimisation { study: found.study.expecting(runs), ..found })
}

fn variables(c: &mut Checker<'_>, raw: &[Section<RawVariable>], kind: SceneKind) -> Vec<Ranged> {
    if raw.is_empty() && c.is_clean() {
        let help = "say what may change: [[variables]] with field, from and to";
        c.push(None, "there are no [[variables]]", "", help);
    }
    let mut found: Vec<Ranged> = Vec::new();
    for raw in raw {
        if !raw.field.is_given() {
            c.missing("field", raw, "say which field of the scene may change: field = \"design.base\"");
            continue;
        }
        let Some(path) = c.get("field", &raw.field) else { continue };
        let Some(field) = field(c, &path, raw.field.span(), kind) else { continue };
        if found.iter().any(|other| other.field.path == field.path) {
            let message = format!("`{path}` is a variable twice");
            c.push(raw.field.span(), message, "and here again", "remove one of them");
            continue;
        }
        let Some(range) = between(c, raw, &field, [&raw.from, &raw.to], &raw.spacing) else { continue };
        let start = match c.get("start", &raw.start) {
            Some(given) => read(c, &field, &given),
            None => None,
        };
        found.push(Ranged { field, range, start });
    }
    found
}

/// The conditions: axes with values, none of them a variable.
fn conditions(c: &mut Checker<'_>, raw: &[Section<RawAxis>], kind: SceneKind, variables: &[Ranged]) -> Vec<SweepAxis> {
    for raw in raw {
        c.unused("again", &raw.again, "among conditions: all of them run the same designs again");
        if raw.from.is_given() && raw.to.is_given() && !raw.count.is_given() {
            c.missing("count", raw, "say how many values of the range: count = 3");
        }
    }
    let mut found = axes(c, raw, kind);
    found.retain(|axis| axis.len().is_some());
    for (axis, raw) in found.iter_mut().zip(raw) {
        axis.again = true;
        if let Some(field) =
            axis.fields.iter().find(|field| variables.iter().any(|variable| variable.field.path == field.path))
        {
            let message = format!("`{}` is a variable and a condition", field.path);
            let help = "remove one of them: what may change is not what every design is tried under";
            c.push(raw.field.span().or(raw.fields.span()), message, "and here a condition", help);
        }
    }
    found
}

/// A variable with its start, from the file or from the base scene.
fn variable(c: &mut Checker<'_>, of: Ranged, raw: &Section<RawVariable>, scene: &Table) -> Option<Variable> {
    let Ranged { field, range, start } = of;
    let span = raw.start.span().or(raw.field.span());
    let start = match (start, at(scene, &field.path)) {
        (Some(start), _) => start,
        (None, Some(value)) => field.parsed(&value.to_string()).ok()?,
        (None, None) => {
            let message = format!("the base scene has no `{}` from which the search could begin", field.path);
            c.push(span, message, "no start", "give it one: start = .., or put the field into the scene");
            return None;
        }
    };
    let Value::Number(start_si) = start.value else { return None };
    let share = range.share(start_si);
    if !(0.0..=1.0).contains(&share) {
        let message =
            format!("`{}` begins at {}, which is not within its range", field.path, start.text.trim_matches('"'));
        let help = "widen the range, or give a start within it: start = ..";
        c.push(span, message, "starts outside", help);
        return None;
    }
    Some(Variable { field, range, start, start_share: share })
}

/// The value at a path of a scene.
fn at<'a>(table: &'a Table, path: &str) -> Option<&'a Toml> {
    match path.split_once('.') {
        None => table.get(path),
        Some((key, rest)) => at(table.get(key)?.as_table()?, rest),
    }
}

/// Columns of the results have names of their own.
fn twice(
    c: &mut Checker<'_>,
    variables: &[Variable],
    objectives: &[super::problem::Objective],
    constraints: &[super::problem::Constraint],
    raw: &RawOptimisation,
) {
    let mut names: Vec<String> = variables.iter().map(Variable::column).collect();
    names.extend(super::found::OWN_COLUMNS.map(|(name, _)| name.to_string()));
    for (of, raw) in objectives.iter().zip(&raw.objectives) {
        if names.contains(&of.figure.name) {
            let message = format!("the results would have two columns `{}`", of.figure.name);
            let span = raw.name.span().or(raw.column.span()).or(raw.columns.span());
            c.push(span, message, "this name again", "give the objective another name: name = ..");
        }
        names.push(of.figure.name.clone());
    }
    for (index, of) in constraints.iter().enumerate() {
        if constraints[..index].iter().any(|other| other.column == of.column) {
            let message = format!("there are two constraints on `{}`", of.column);
            let span = raw.constraints.get(index).and_then(|raw| raw.column.span());
            c.push(span, message, "and here again", "make one of them, with at_least and at_most");
        }
    }
}

fn method(c: &mut Checker<'_>, raw: &Section<RawMethod>, objectives: usize, variables: usize) -> Method {
    let usual = if objectives == 1 { Algorithm::CmaEs } else { Algorithm::Nsga2 };
    let algorithm = c.or("method.algorithm", &raw.algorithm, usual);
    if algorithm == Algorithm::CmaEs && objectives > 1 {
        let message = format!("\"cma-es\" makes one objective small or large, and these are {objectives}");
        c.push(raw.algorithm.span(), message, "for one objective", "use algorithm = \"nsga2\", or keep one objective");
    }
    let (population, generations) = match algorithm {
        Algorithm::Nsga2 => (POPULATION, GENERATIONS),
        Algorithm::CmaEs => (CmaEs::usual_population(variables.max(1)) as u64, GENERATIONS_OF_ONE),
    };
    let population = c.or("method.population", &raw.population, population);
    if population < 4 {
        let message = format!("`method.population` is {population}, but a generation has at least 4 designs");
        c.push(raw.population.span(), message, "too few", "take 4 or more; some ten times the variables is usual");
    }
    let generations = c.or("method.generations", &raw.generations, generations);
    Method { algorithm, population, generations, seed: c.or("method.seed", &raw.seed, 1) }
}
