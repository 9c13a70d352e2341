//! The scene that a request means, or what is wrong with it.

use serde_json::{Value, json};

use super::request::Request;
use crate::scene::{Layer, Problem, Scene, SceneError, parse_any, parse_layers, setting_of};

/// The scene with what is set in it.
pub fn scene(request: &Request) -> Result<Scene, Value> {
    scene_with(request, &[])
}

/// The same with more that is set.
pub fn scene_with(request: &Request, more: &[(String, String)]) -> Result<Scene, Value> {
    let own = Layer { file: request.scene.file.clone(), text: request.scene.text.clone() };
    let mut settings = Vec::new();
    for (field, value) in request.set.iter().chain(more) {
        // A layer is called by its field: what is wrong with it is then said of that.
        settings.push(setting_of(field, field, value).map_err(|message| one(field, &message))?);
    }
    parse_layers(&[own], &settings, parse_any).map_err(|error| json!(problems(&error)))
}

fn one(field: &str, message: &str) -> Value {
    json!([{ "message": message, "help": "", "line": null, "field": field }])
}

fn problems(error: &SceneError) -> Vec<Value> {
    match error {
        SceneError::Layers(errors) => errors.iter().flat_map(problems).collect(),
        SceneError::Invalid { file, text, problems } => {
            problems.iter().map(|problem| of_text(problem, file, text)).collect()
        }
        other => vec![json!({ "message": other.to_string(), "help": "", "line": null, "field": null })],
    }
}

/// A problem of a file (which has lines), or of a field that was set.
fn of_text(problem: &Problem, file: &str, text: &str) -> Value {
    let is_file = file.ends_with(".toml");
    let lines = |at: usize| text.get(..at).map_or(1, |before| before.matches('\n').count() + 1);
    let line = problem.span.as_ref().filter(|_| is_file).map(|span| lines(span.start));
    json!({
        "message": problem.message,
        "label": problem.label,
        "help": problem.help,
        "line": line,
        "field": (!is_file).then_some(file),
    })
}
