//! The two models behind one face.

#[cfg(feature = "engine")]
use super::run_engine;
use super::{Outcome, RunError, Sink, run_analytic};
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

/// Simulates a scene of any kind with one of the models. Where the engine was left out of the build, its runs end before they begin.
pub fn run(model: Model, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        #[cfg(feature = "engine")]
        Model::Engine => run_engine(scene, sink),
        #[cfg(not(feature = "engine"))]
        Model::Engine => Err(super::analytic::none_at_all("this build has no engine model".to_string())),
    }
}
