//! Gripper scenes for a largest positioning error, with the object at an offset.

use crate::scene::keywords::SceneKind;
use crate::scene::{Layer, Scene, SceneError, parse_any, parse_layers};
use crate::units::{self, Dimension};

/// Texts of a scene and additional settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneSource {
    pub layers: Vec<Layer>,
    pub settings: Vec<Layer>,
}

impl SceneSource {
    /// Loads the gripper designed for errors up to `error_m`, with its object `offset_m` from the middle of the palm.
    ///
    /// # Errors
    /// Returns an error if the scene is invalid with these values, or is not a gripper.
    pub fn load_at_offset(&self, error_m: f64, offset_m: f64) -> Result<Scene, SceneError> {
        let setting = |key: &str, value_m: f64| Layer {
            file: "the study".to_string(),
            text: format!("{key} = \"{}\"", units::format(value_m, Dimension::Length)),
        };
        let added = [setting("positioning_error", error_m), setting("object.offset", offset_m)];
        let settings: Vec<Layer> = self.settings.iter().cloned().chain(added).collect();
        let scene = parse_layers(&self.layers, &settings, parse_any)?;
        match scene.kind() {
            SceneKind::Gripper => Ok(scene),
            _ => {
                let file = self.layers.last().map(|scene_layer| scene_layer.file.clone()).unwrap_or_default();
                Err(SceneError::Read { file, reason: "it is not a gripper (kind = \"gripper\")".to_string() })
            }
        }
    }
}
