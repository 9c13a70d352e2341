//! Reads the study file of an optimisation.

use super::figures::{check_names, read_constraints, read_objectives};
use super::tables::{Algorithm, MethodTable, OptimisationFile};
use super::variables::{combinations, read_conditions, read_ranges, read_starts, start_scene};
use super::{Method, Optimisation};
use crate::numeric::elementary::ln;
use crate::study::sweep::{Document, MAX_RUNS, Results, StudyError, default_name, file_schema, read_study};

/// Returns the JSON Schema of study files. `[scene]` and `[set]` accept the keys of all kinds of scene.
pub fn schema() -> String {
    file_schema::<OptimisationFile>()
}

/// Reads and checks a study file and the base scene that it names.
///
/// # Errors
/// Returns an error if the study or its base scene is invalid; the message contains file, line and column.
pub fn load(path: impl AsRef<std::path::Path>) -> Result<Optimisation, StudyError> {
    let (text, file) = read_study(path.as_ref())?;
    parse(&text, &file)
}

/// Parses the text of a study. `file_name` appears in messages. It also determines the default name, and the directory
/// to which the path of the base scene is relative.
pub fn parse(text: &str, file_name: &str) -> Result<Optimisation, StudyError> {
    let (file, mut document) = Document::read::<OptimisationFile>(text, file_name)?;
    let base = document.read_base(&file.scene)?;
    if file.variables.is_empty() {
        let help = "add the fields to vary: [[variables]] with field, from and to";
        document.missing::<()>("[[variables]]", "", help);
    }
    if file.objectives.is_empty() {
        let help = "add a figure to minimise or maximise: [[objectives]] with column = \"tts_s\"";
        document.missing::<()>("[[objectives]]", "", help);
    }
    document.check()?;
    // A missing scene has been reported.
    let Some(base) = base else { return Err(document.invalid(Vec::new()).into()) };
    let ranges = read_ranges(&document, &file.variables, &base);
    let (layers, scene) = start_scene(&mut document, &ranges)?;
    let results =
        if base.is_hand() { Ok(Results::of_hand(base.kind.fingers())) } else { Results::of(&scene, &[], &[]) };
    let names = results.map_or_else(|_| Vec::new(), |results| results.names.to_vec());
    let variables = read_starts(&document, ranges, &scene);
    let axes = read_conditions(&document, &file, &base);
    let objectives = read_objectives(&document, &file.objectives, &names);
    let constraints = read_constraints(&document, &file.constraints, &names);
    document.check_filter();
    let method = read_method(&document, &file);
    document.check()?;
    check_names(&document, &variables, &objectives, &constraints);
    let conditions = axes.iter().map(|(_, rows)| rows.len() as u64).fold(1, u64::saturating_mul);
    // CMA-ES evaluates the start as a separate generation.
    let designs = method.population.saturating_mul(method.generations);
    let designs = designs.saturating_add(u64::from(method.algorithm == Algorithm::CmaEs));
    if designs.saturating_mul(conditions) > MAX_RUNS {
        let message =
            format!("the optimisation has more than {MAX_RUNS} runs: population times generations times conditions");
        document.refuse::<()>("method", message, "too many", "reduce population, generations or conditions");
    }
    document.check()?;
    Ok(Optimisation {
        name: if file.name.is_empty() { default_name(file_name) } else { file.name },
        description: file.description,
        model: file.model.0,
        scene: layers,
        files: document.files(),
        variables,
        conditions: combinations(&axes),
        objectives,
        constraints,
        method,
        verdict: ["class", "grasp", "fate"].into_iter().find(|verdict| names.iter().any(|name| name == verdict)),
        keys: document.keys(),
    })
}

fn read_method(document: &Document<'_>, file: &OptimisationFile) -> Method {
    let MethodTable { algorithm, population, generations, seed } = file.method;
    let objectives = file.objectives.len();
    let algorithm = algorithm.unwrap_or(if objectives == 1 { Algorithm::CmaEs } else { Algorithm::Nsga2 });
    if algorithm == Algorithm::CmaEs && objectives > 1 {
        let message = format!("\"cma-es\" supports one objective, but the file has {objectives}");
        let help = "use algorithm = \"nsga2\", or keep one objective";
        document.refuse::<()>("method.algorithm", message, "for one objective", help);
    }
    let defaults = match algorithm {
        Algorithm::Nsga2 => (64, 50),
        // Hansen, The CMA evolution strategy: a tutorial, table 1.
        Algorithm::CmaEs => (4 + (3.0 * ln(file.variables.len() as f64)) as u64, 100),
    };
    Method {
        algorithm,
        population: population.unwrap_or(defaults.0),
        generations: generations.unwrap_or(defaults.1),
        seed: seed.unwrap_or(1),
    }
}
