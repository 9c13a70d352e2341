//! Requests of the explorer page, in JSON.

use serde::Deserialize;
use serde_json::{Value, json};

use crate::scene::{Layer, Problem, Scene, SceneError, parse_any, parse_layers, setting_from_parts};

/// A request about a scene.
#[derive(Debug, Deserialize)]
pub struct Request {
    #[serde(rename = "ask")]
    pub kind: RequestKind,
    #[serde(rename = "scene")]
    pub file: SceneFile,
    /// Fields and their values, as in `--set FIELD=VALUE`.
    #[serde(default)]
    pub set: Vec<(String, String)>,
    /// The fields that a map varies, and their values: one row per run.
    #[serde(default)]
    pub fields: Vec<String>,
    #[serde(default)]
    pub points: Vec<Vec<String>>,
}

/// A scene file.
#[derive(Debug, Deserialize)]
pub struct SceneFile {
    pub file: String,
    pub text: String,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(crate) enum RequestKind {
    Fields,
    Run,
    Check,
    Statics,
    Criteria,
    Toml,
    Csv,
}

impl Request {
    /// Parses the scene with the settings of the request and the `extra` settings, or returns its problems.
    pub fn scene(&self, extra: &[(String, String)]) -> Result<Scene, Value> {
        let base = Layer { file: self.file.file.clone(), text: self.file.text.clone() };
        let mut settings = Vec::new();
        for (field, value) in self.set.iter().chain(extra) {
            // The layer is named after its field, so that its errors refer to the field.
            settings
                .push(setting_from_parts(field, field, value).map_err(|message| json!([problem(&message, field)]))?);
        }
        parse_layers(&[base], &settings, parse_any).map_err(|error| json!(problems(&error)))
    }
}

/// A problem with a field, which may be empty, without advice.
fn problem(message: &str, field: &str) -> Value {
    json!({ "message": message, "help": "", "line": null, "field": Some(field).filter(|field| !field.is_empty()) })
}

fn problems(error: &SceneError) -> Vec<Value> {
    match error {
        SceneError::Layers(errors) => errors.iter().flat_map(problems).collect(),
        SceneError::Invalid { file, text, problems } => {
            problems.iter().map(|problem| problem_json(problem, file, text)).collect()
        }
        other => vec![problem(&other.to_string(), "")],
    }
}

/// JSON of a problem of a file (with its line) or of a setting (with its field).
fn problem_json(problem: &Problem, file: &str, text: &str) -> Value {
    let is_file = file.ends_with(".toml");
    let lines = |offset: usize| text.get(..offset).map_or(1, |before| before.matches('\n').count() + 1);
    json!({
        "message": problem.message,
        "label": problem.label,
        "help": problem.help,
        "line": problem.span.as_ref().filter(|_| is_file).map(|span| lines(span.start)),
        "field": (!is_file).then_some(file),
    })
}
