//! Requests of the explorer page. Input is a scene with settings; output is playbacks, figures and texts. All results
//! are computed by the same functions as on the command line, with the analytic model.
//!
//! A request is a JSON text. A response is a JSON text and an array of numbers, to which the text refers by offset.
//!
//! | file | job |
//! |---|---|
//! | `request` | format of a request |
//! | `requested_scene` | the scene of a request, or its errors |
//! | `fields` | every field of a scene: type, allowed values, current value |
//! | `run` | a run as playback and figures; the result of a check |
//! | `figures`, `labels` | the figures of a run by the keys of its JSON document, and their labels |
//! | `statics` | the grasp at rest |
//! | `map` | figures of many runs that vary two fields |
//! | `exports` | the scene as a file, the samples as CSV |

mod exports;
mod fields;
mod figures;
mod labels;
mod map;
mod request;
mod requested_scene;
mod run;
mod statics;

use serde_json::{Value, json};

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
    let text = match found {
        Ok(found) => found,
        Err(problems) => json!({ "problems": problems }),
    };
    Response { text: text.to_string(), data }
}

/// Returns the response, or the problems of the scene.
fn handle(request: &Request, data: &mut Vec<f64>) -> Result<Value, Value> {
    match request.kind {
        RequestKind::Fields => Ok(fields::fields(&requested_scene::scene(request)?)),
        RequestKind::Run => Ok(run::run(&requested_scene::scene(request)?, data)),
        RequestKind::Check => Ok(run::check(&requested_scene::scene(request)?)),
        RequestKind::Statics => statics::statics(&requested_scene::scene(request)?),
        RequestKind::Criteria => map::criteria(request, data),
        RequestKind::Toml => Ok(exports::scene_file(request, &requested_scene::scene(request)?)),
        RequestKind::Csv => exports::samples(&requested_scene::scene(request)?),
    }
}
