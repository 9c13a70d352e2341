//! Stand-ins until scene loading and the analytic run are merged.

use std::path::Path;

use crate::scene::{Preset, Scene};

pub fn load(_: &Path) -> Result<Scene, String> {
    Err("scene loading is not merged yet".to_string())
}

pub fn apply_preset(scene: &mut Scene, preset: Preset) {
    scene.integrator.preset = preset;
}

pub fn duration(_: &str) -> Result<f64, String> {
    Err("not merged yet".to_string())
}
