//! The gripper of a scene, made for a largest positioning error, with its object at an offset.

use crate::scene::words::SceneKind;
use crate::scene::{Layer, Scene, SceneError, parse_any, parse_layers};
use crate::units::{self, Dimension};

/// The texts of a scene, and what is set besides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    pub layers: Vec<Layer>,
    pub settings: Vec<Layer>,
}

impl Source {
    /// The gripper, made for errors up to `error_m`, with its object `offset_m` off the middle of the palm.
    ///
    /// # Errors
    /// What is wrong with the scene there, or that it is no gripper.
    pub fn placed(&self, error_m: f64, offset_m: f64) -> Result<Scene, SceneError> {
        let of = |key: &str, value_m: f64| Layer {
            file: "the study".to_string(),
            text: format!("{key} = \"{}\"", units::format(value_m, Dimension::Length)),
        };
        let more = [of("positioning_error", error_m), of("object.offset", offset_m)];
        let settings: Vec<Layer> = self.settings.iter().cloned().chain(more).collect();
        let scene = parse_layers(&self.layers, &settings, parse_any)?;
        match scene.kind() {
            SceneKind::Gripper => Ok(scene),
            _ => {
                let file = self.layers.last().map(|own| own.file.clone()).unwrap_or_default();
                Err(SceneError::Read { file, reason: "it is no gripper (kind = \"gripper\")".to_string() })
            }
        }
    }
}
