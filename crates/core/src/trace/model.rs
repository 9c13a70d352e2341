//! The two models behind one face.

use super::{Outcome, RunError, Sink, run_analytic, run_engine};
use crate::scene::{Scene, Words};

/// Which of the two independent models simulates a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    Analytic,
    Engine,
}

impl Model {
    /// In commands, reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            Model::Analytic => "analytic",
            Model::Engine => "engine",
        }
    }
}

impl Words for Model {
    const WORDS: &'static [(&'static str, Self)] = &[("analytic", Model::Analytic), ("engine", Model::Engine)];
}

/// Simulates the scene with one of the models.
pub fn run(model: Model, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        Model::Engine => run_engine(scene, sink),
    }
}
