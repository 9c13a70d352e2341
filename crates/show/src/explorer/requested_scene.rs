//! Parses the scene of a request, or reports its problems.

use serde_json::{Value, json};

use super::request::Request;
use crate::scene::{Layer, Problem, Scene, SceneError, parse_any, parse_layers, setting_from_parts};

/// Parses the scene with the settings of the request.
pub fn scene(request: &Request) -> Result<Scene, Value> {
    scene_with_settings(request, &[])
}

/// Parses the scene with the settings of the request and the `extra` settings.
pub fn scene_with_settings(request: &Request, extra: &[(String, String)]) -> Result<Scene, Value> {
    let base = Layer { file: request.scene.file.clone(), text: request.scene.text.clone() };
    let mut settings = Vec::new();
    for (field, value) in request.set.iter().chain(extra) {
        // The layer is named after its field, so that its errors refer to the field.
        settings.push(setting_from_parts(field, field, value).map_err(|message| single_problem(field, &message))?);
    }
    parse_layers(&[base], &settings, parse_any).map_err(|error| json!(problems(&error)))
}

fn single_problem(field: &str, message: &str) -> Value {
    json!([{ "message": message, "help": "", "line": null, "field": field }])
}

fn problems(error: &SceneError) -> Vec<Value> {
    match error {
        SceneError::Layers(errors) => errors.iter().flat_map(problems).collect(),
        SceneError::Invalid { file, text, problems } => {
            problems.iter().map(|problem| problem_json(problem, file, text)).collect()
        }
        other => vec![json!({ "message": other.to_string(), "help": "", "line": null, "field": null })],
    }
}

/// JSON of a problem of a file (with its line) or of a setting (with its field).
fn problem_json(problem: &Problem, file: &str, text: &str) -> Value {
    let is_file = file.ends_with(".toml");
    let lines = |offset: usize| text.get(..offset).map_or(1, |before| before.matches('\n').count() + 1);
    let line = problem.span.as_ref().filter(|_| is_file).map(|span| lines(span.start));
    json!({
        "message": problem.message,
        "label": problem.label,
        "help": problem.help,
        "line": line,
        "field": (!is_file).then_some(file),
    })
}
