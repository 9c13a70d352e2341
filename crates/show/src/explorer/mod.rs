//! What the explorer's page asks: a scene and what is set in it come in, films, figures and texts go out. Everything is computed as the
//! command line does it, with the analytic model.
//!
//! A request is a JSON text; an answer is a JSON text, and beside it numbers in a row that the text points into.
//!
//! | file | job |
//! |---|---|
//! | `request` | what can be asked |
//! | `given` | the scene that is meant, or what is wrong with it |
//! | `fields` | every field of a scene: what it is, what it may be, what it holds |
//! | `run` | a run as film and figures; what a check finds of it |
//! | `figures`, `labels` | the figures of a run, by the keys of its JSON document, and in words |
//! | `statics` | the grasp at rest |
//! | `map` | figures of many runs, two fields varied |
//! | `texts` | the scene as a file, the samples as CSV |

mod fields;
mod figures;
mod given;
mod labels;
mod map;
mod request;
mod run;
mod statics;
mod texts;

use serde_json::{Value, json};

use request::{Ask, Request};

/// A JSON text, and the numbers that it points into.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    pub text: String,
    pub data: Vec<f64>,
}

/// Answers a request. What cannot be answered is said under `problems`, each with its `message` and `help`.
pub fn answer(request: &str) -> Answer {
    let mut data = Vec::new();
    let found = match serde_json::from_str::<Request>(request) {
        Ok(request) => answered(&request, &mut data),
        Err(error) => {
            Err(json!([{ "message": format!("no request: {error}"), "help": "this is a fault of the page" }]))
        }
    };
    let text = match found {
        Ok(found) => found,
        Err(problems) => json!({ "problems": problems }),
    };
    Answer { text: text.to_string(), data }
}

/// The answer, or what is wrong with the scene.
fn answered(request: &Request, data: &mut Vec<f64>) -> Result<Value, Value> {
    match request.ask {
        Ask::Fields => Ok(fields::fields(&given::scene(request)?)),
        Ask::Run => Ok(run::run(&given::scene(request)?, data)),
        Ask::Check => Ok(run::check(&given::scene(request)?)),
        Ask::Statics => statics::statics(&given::scene(request)?),
        Ask::Criteria => map::criteria(request, data),
        Ask::Toml => Ok(texts::scene_file(request, &given::scene(request)?)),
        Ask::Csv => texts::samples(&given::scene(request)?),
    }
}
