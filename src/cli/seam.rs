//! Stand-ins until scene loading and the analytic run are merged.

use std::path::Path;

use crate::scene::{Preset, Scene};
use crate::trace::{Outcome, Sink, SinkError};

#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    #[error("{reason}")]
    Simulation { time_s: f64, reason: String },
}

pub fn load(_: &Path) -> Result<Scene, String> {
    Err("scene loading is not merged yet".to_string())
}

pub fn simulate(_: &Scene, _: &mut impl Sink) -> Result<Outcome, RunError> {
    Err(RunError::Simulation {
        time_s: 0.0,
        reason: "the analytic model is not merged yet".to_string(),
    })
}

pub fn apply_preset(scene: &mut Scene, preset: Preset) {
    scene.integrator.preset = preset;
}

pub fn duration(_: &str) -> Result<f64, String> {
    Err("not merged yet".to_string())
}
