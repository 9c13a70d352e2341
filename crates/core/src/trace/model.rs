//! The two models behind one face.

use super::{Outcome, RunError, Simulated, Sink, run_analytic, run_engine};
use crate::scene::Words;

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

/// Simulates a scene of any kind with one of the models.
pub fn run<'a>(model: Model, scene: impl Into<Simulated<'a>>, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        Model::Engine => run_engine(scene, sink),
    }
}
