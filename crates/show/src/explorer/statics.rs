//! The grasp at rest, as `phalanx statics` reports it.

use serde_json::{Value, json};

use crate::grasp::finger::{Instead, grasp};
use crate::grasp::gripper::{Asked, PostureOf, gripper_grasp};
use crate::plot::{self, Form};
use crate::report::statics::{GripperStaticsReport, StaticsReport};
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::wording::{Report, Reported};

/// Directions of acceleration in a picture.
const DIRECTIONS: usize = 72;
/// One in so many of them is in the table: 15° apart.
const IN_TABLE: usize = 3;

/// Tables and a picture; for a scene of discs neither.
pub fn statics(scene: &Scene) -> Result<Value, Value> {
    match scene.kind() {
        SceneKind::Finger => of_finger(scene),
        SceneKind::Gripper => of_gripper(scene),
        SceneKind::Bodies => Ok(json!({ "sections": [], "pictures": [] })),
    }
}

fn of_finger(scene: &Scene) -> Result<Value, Value> {
    let found = grasp(scene, &Instead { mu_static: Vec::new(), motor_n_m: None }).map_err(|error| refused(&error))?;
    Ok(shown(
        &StaticsReport::new(&found).report(),
        ("The grasp at rest: forces on the object", &plot::grasp(scene, &found, Form::Column)),
    ))
}

fn of_gripper(scene: &Scene) -> Result<Value, Value> {
    let asked = Asked {
        posture: PostureOf::Run { at_s: None, within_m: None },
        mu_static: Vec::new(),
        motor_n_m: None,
        directions: DIRECTIONS,
    };
    let found = gripper_grasp(scene, &asked, &|| true).map_err(|error| refused(&error))?;
    Ok(shown(
        &GripperStaticsReport::new(&found, IN_TABLE).report(),
        ("Accelerations of the palm that the grasp bears", &plot::balance(scene, &found, Form::Column)),
    ))
}

fn shown(text: &Report, (caption, picture): (&str, &str)) -> Value {
    let title = "At rest";
    json!({
        "sections": [{ "title": title, "html": text.html(title) }],
        "pictures": [{ "title": caption, "svg": picture }],
    })
}

fn refused(error: &dyn std::fmt::Display) -> Value {
    json!([{ "message": error.to_string(), "help": "the run itself does not need it", "line": null, "field": null }])
}
