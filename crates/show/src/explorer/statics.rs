//! The grasp at rest as reported by `phalanx statics`.

use serde_json::{Value, json};

use crate::format::ToReport;
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
    let (report, caption, picture) = match scene.kind() {
        SceneKind::Bodies => return Ok(json!({ "sections": [], "pictures": [] })),
        SceneKind::Finger => {
            let result = grasp(scene, &GraspOverrides::default()).map_err(|error| problem(&error))?;
            let picture = plot::grasp(scene, &result, PictureFormat::Column);
            (StaticsReport::new(&result).report(), "The grasp at rest: forces on the object", picture)
        }
        SceneKind::Gripper => {
            let request = GripperGraspRequest {
                posture: PostureRequest::Run { at_s: None, within_m: None },
                mu_static: Vec::new(),
                motor_n_m: None,
                directions: DIRECTIONS,
            };
            let result = gripper_grasp(scene, &request, &|| true).map_err(|error| problem(&error))?;
            let picture = plot::balance(scene, &result, PictureFormat::Column);
            let report = GripperStaticsReport::new(&result, IN_TABLE).report();
            (report, "Accelerations of the palm that the grasp withstands", picture)
        }
    };
    let title = "At rest";
    Ok(json!({
        "sections": [{ "title": title, "html": report.html(title) }],
        "pictures": [{ "title": caption, "svg": picture }],
    }))
}

fn problem(error: &dyn std::fmt::Display) -> Value {
    let help = "the run does not depend on this analysis";
    json!([{ "message": error.to_string(), "help": help, "line": null, "field": null }])
}
