//! The grasp at rest as reported by `phalanx statics`.

use serde_json::{Value, json};

use crate::format::{Report, ToReport};
use crate::grasp::finger::{GraspOverrides, grasp};
use crate::grasp::gripper::{GripperGraspRequest, PostureRequest, gripper_grasp};
use crate::plot::{self, PictureFormat};
use crate::report::statics::{GripperStaticsReport, StaticsReport};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;

/// Number of directions of acceleration in the picture.
const DIRECTIONS: usize = 72;
/// Stride of the directions in the table, which are 15° apart.
const IN_TABLE: usize = 3;

/// Returns tables and a picture; a scene of discs has neither.
pub fn statics(scene: &Scene) -> Result<Value, Value> {
    match scene.kind() {
        SceneKind::Finger => finger_statics(scene),
        SceneKind::Gripper => gripper_statics(scene),
        SceneKind::Bodies => Ok(json!({ "sections": [], "pictures": [] })),
    }
}

fn finger_statics(scene: &Scene) -> Result<Value, Value> {
    let result =
        grasp(scene, &GraspOverrides { mu_static: Vec::new(), motor_n_m: None }).map_err(|error| problem(&error))?;
    Ok(section_and_picture(
        &StaticsReport::new(&result).report(),
        ("The grasp at rest: forces on the object", &plot::grasp(scene, &result, PictureFormat::Column)),
    ))
}

fn gripper_statics(scene: &Scene) -> Result<Value, Value> {
    let request = GripperGraspRequest {
        posture: PostureRequest::Run { at_s: None, within_m: None },
        mu_static: Vec::new(),
        motor_n_m: None,
        directions: DIRECTIONS,
    };
    let result = gripper_grasp(scene, &request, &|| true).map_err(|error| problem(&error))?;
    Ok(section_and_picture(
        &GripperStaticsReport::new(&result, IN_TABLE).report(),
        ("Accelerations of the palm that the grasp withstands", &plot::balance(scene, &result, PictureFormat::Column)),
    ))
}

fn section_and_picture(text: &Report, (caption, picture): (&str, &str)) -> Value {
    let title = "At rest";
    json!({
        "sections": [{ "title": title, "html": text.html(title) }],
        "pictures": [{ "title": caption, "svg": picture }],
    })
}

fn problem(error: &dyn std::fmt::Display) -> Value {
    json!([{ "message": error.to_string(), "help": "the run does not depend on this analysis", "line": null, "field": null }])
}
