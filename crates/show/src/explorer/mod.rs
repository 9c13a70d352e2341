//! Requests of the explorer page. Input is a scene with settings; output is playbacks, figures and texts. All results
//! are computed by the same functions as on the command line, with the analytic model.
//!
//! A request is a JSON text. A response is a JSON text and an array of numbers, to which the text refers by offset.
//!
//! | file | job |
//! |---|---|
//! | `fields` | every field of a scene: type, allowed values, current value |
//! | `run` | a run as playback and figures, as CSV, or checked; figures of many runs |
//! | `figures` | the figures of a run by the keys of its JSON document, with labels and texts |

mod fields;
mod figures;
mod run;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::format::ToReport;
use crate::grasp::finger::{GraspOverrides, grasp};
use crate::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use crate::plot::{self, PictureFormat};
use crate::report::statics::{GripperStaticsReport, StaticsReport};
use crate::scene::keywords::SceneKind;
use crate::scene::{Layer, Scene, SceneError, parse_any, parse_layers, setting_from_parts};

/// Number of directions of acceleration in the picture of a gripper's grasp at rest.
const DIRECTIONS: usize = 72;
/// Stride of the directions in its table, which are 15° apart.
const IN_TABLE: usize = 3;

/// A JSON text, and the numbers that it refers to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    pub text: String,
    pub data: Vec<f64>,
}

/// A request about a scene.
#[derive(Debug, Deserialize)]
struct Request {
    #[serde(rename = "ask")]
    kind: RequestKind,
    #[serde(rename = "scene")]
    file: SceneFile,
    /// Fields and their values, as in `--set FIELD=VALUE`.
    #[serde(default)]
    set: Vec<(String, String)>,
    /// The fields that a map varies, and their values: one row per run.
    #[serde(default)]
    fields: Vec<String>,
    #[serde(default)]
    points: Vec<Vec<String>>,
}

#[derive(Debug, Deserialize)]
struct SceneFile {
    file: String,
    text: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum RequestKind {
    Fields,
    Run,
    Check,
    Statics,
    Criteria,
    Toml,
    Csv,
}

/// Returns the response to a request. Errors are listed under `problems`, each with its `message` and `help`.
pub fn respond(request: &str) -> Response {
    let mut data = Vec::new();
    let found = match serde_json::from_str::<Request>(request) {
        Ok(request) => request.respond(&mut data),
        Err(error) => {
            Err(json!([{ "message": format!("invalid request: {error}"), "help": "this is an error of the page" }]))
        }
    };
    let text = found.unwrap_or_else(|problems| json!({ "problems": problems }));
    Response { text: text.to_string(), data }
}

impl Request {
    /// Returns the response, or the problems of the scene.
    fn respond(&self, data: &mut Vec<f64>) -> Result<Value, Value> {
        let scene = || self.scene(&[]);
        Ok(match self.kind {
            RequestKind::Criteria => run::criteria(self, data),
            RequestKind::Fields => fields::fields(&scene()?),
            RequestKind::Run => run::run(&scene()?, data),
            RequestKind::Check => run::check(&scene()?),
            RequestKind::Statics => statics(&scene()?)?,
            RequestKind::Toml => self.scene_file(&scene()?),
            RequestKind::Csv => run::samples(&scene()?)?,
        })
    }

    /// Parses the scene with the settings of the request and the `extra` settings, or returns its problems.
    fn scene(&self, extra: &[(String, String)]) -> Result<Scene, Value> {
        let base = Layer { file: self.file.file.clone(), text: self.file.text.clone() };
        // A layer is named after its field, so that its errors refer to the field.
        let layer = |(field, value): &(String, String)| {
            setting_from_parts(field, field, value).map_err(|message| json!([problem(&message, Some(field))]))
        };
        let settings = self.set.iter().chain(extra).map(layer).collect::<Result<Vec<_>, Value>>()?;
        parse_layers(&[base], &settings, parse_any).map_err(|error| json!(problems(&error)))
    }

    /// Returns the text of the scene file with the settings applied.
    fn scene_file(&self, scene: &Scene) -> Value {
        let set: Vec<String> = self.set.iter().map(|(field, value)| format!("{field} = {value}")).collect();
        let changes = if set.is_empty() { String::new() } else { format!(" with {}", set.join(", ")) };
        // The comment must stay on one line.
        let changes = changes.replace(char::is_control, " ");
        let text = scene.source.strip_prefix('\n').unwrap_or(&scene.source);
        json!({ "text": format!("# {}{changes}, from the explorer of phalanx.\n{text}", self.file.file) })
    }
}

/// A problem with a field, if known, without advice.
fn problem(message: &str, field: Option<&str>) -> Value {
    json!({ "message": message, "help": "", "line": null, "field": field.filter(|field| !field.is_empty()) })
}

/// Problems of a file (with their lines) or of a setting (with its field).
fn problems(error: &SceneError) -> Vec<Value> {
    let (file, text, problems) = match error {
        SceneError::Layers(errors) => return errors.iter().flat_map(problems).collect(),
        SceneError::Invalid { file, text, problems } => (file, text, problems),
        other => return vec![problem(&other.to_string(), None)],
    };
    let is_file = file.ends_with(".toml");
    let line = |offset: usize| text.get(..offset).map_or(1, |before| before.matches('\n').count() + 1);
    let document = problems.iter().map(|problem| {
        json!({
            "message": problem.message,
            "label": problem.label,
            "help": problem.help,
            "line": problem.span.as_ref().filter(|_| is_file).map(|span| line(span.start)),
            "field": (!is_file).then_some(file),
        })
    });
    document.collect()
}

/// Returns tables and a picture of the grasp at rest, as reported by `phalanx statics`; a scene of discs has neither.
fn statics(scene: &Scene) -> Result<Value, Value> {
    let problem = |error: &dyn std::fmt::Display| {
        let help = "the run does not depend on this analysis";
        json!([{ "message": error.to_string(), "help": help, "line": null, "field": null }])
    };
    let (report, caption, picture) = match scene.kind() {
        SceneKind::Bodies => return Ok(json!({ "sections": [], "pictures": [] })),
        SceneKind::Finger => {
            let result = grasp(scene, &GraspOverrides::default()).map_err(|error| problem(&error))?;
            let picture = plot::grasp(scene, &result, PictureFormat::Column);
            (StaticsReport::new(&result).report(), "The grasp at rest: forces on the object", picture)
        }
        SceneKind::Gripper => {
            let posture = PostureRequest::Run { at_s: None, within_m: None };
            let request =
                GripperGraspRequest { posture, mu_static: Vec::new(), motor_n_m: None, directions: DIRECTIONS };
            let result = gripper_grasp(scene, &request, &|| true).map_err(|error| problem(&error))?;
            let picture = plot::balance(scene, &result, PictureFormat::Column);
            let report = GripperStaticsReport::new(&result, IN_TABLE).report();
            (report, "Accelerations of the palm that the grasp withstands", picture)
        }
    };
    Ok(json!({
        "sections": [{ "title": "At rest", "html": report.html("At rest") }],
        "pictures": [{ "title": caption, "svg": picture }],
    }))
}
