//! Requests of the explorer page. Input is a scene with settings; output is playbacks, figures and texts. All results
//! are computed by the same functions as on the command line, with the analytic model.
//!
//! A request is a JSON text. A response is a JSON text and an array of numbers, to which the text refers by offset.
//!
//! | file | job |
//! |---|---|
//! | `request` | format of a request, and its scene or the errors of the scene |
//! | `fields` | every field of a scene: type, allowed values, current value |
//! | `run` | a run as playback and figures, as CSV, or checked; figures of many runs |
//! | `figures` | the figures of a run by the keys of its JSON document, with labels and texts |
//! | `statics` | the grasp at rest |

mod fields;
mod figures;
mod request;
mod run;
mod statics;

use serde_json::{Value, json};

use crate::scene::Scene;
use request::{Request, RequestKind};

/// A JSON text, and the numbers that it refers to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Response {
    pub text: String,
    pub data: Vec<f64>,
}

/// Returns the response to a request. Errors are listed under `problems`, each with its `message` and `help`.
pub fn respond(request: &str) -> Response {
    let mut data = Vec::new();
    let found = match serde_json::from_str::<Request>(request) {
        Ok(request) => handle(&request, &mut data),
        Err(error) => {
            Err(json!([{ "message": format!("invalid request: {error}"), "help": "this is an error of the page" }]))
        }
    };
    let text = found.unwrap_or_else(|problems| json!({ "problems": problems }));
    Response { text: text.to_string(), data }
}

/// Returns the response, or the problems of the scene.
fn handle(request: &Request, data: &mut Vec<f64>) -> Result<Value, Value> {
    if request.kind == RequestKind::Criteria {
        return Ok(run::criteria(request, data));
    }
    let scene = request.scene(&[])?;
    match request.kind {
        RequestKind::Fields => Ok(fields::fields(&scene)),
        RequestKind::Run => Ok(run::run(&scene, data)),
        RequestKind::Check => Ok(run::check(&scene)),
        RequestKind::Statics => statics::statics(&scene),
        RequestKind::Toml => Ok(scene_file(request, &scene)),
        RequestKind::Csv | RequestKind::Criteria => run::samples(&scene),
    }
}

/// Returns the text of the scene file with the settings applied.
fn scene_file(request: &Request, scene: &Scene) -> Value {
    let set: Vec<String> = request.set.iter().map(|(field, value)| format!("{field} = {value}")).collect();
    let changes = if set.is_empty() { String::new() } else { format!(" with {}", set.join(", ")) };
    // The comment must stay on one line.
    let changes = changes.replace(char::is_control, " ");
    let text = scene.source.strip_prefix('\n').unwrap_or(&scene.source);
    json!({ "text": format!("# {}{changes}, from the explorer of phalanx.\n{text}", request.file.file) })
}
