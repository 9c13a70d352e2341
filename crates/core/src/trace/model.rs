//! Common interface of the two models.

#[cfg(feature = "engine")]
use super::run_engine;
use super::{Outcome, RunError, Sink, run_analytic};
use crate::scene::{Keyword, Scene};

/// Which of the two independent models simulates a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    Analytic,
    Engine,
}

impl Model {
    /// Name in commands, reports and logs.
    pub fn name(self) -> &'static str {
        match self {
            Model::Analytic => "analytic",
            Model::Engine => "engine",
        }
    }
}

impl Keyword for Model {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("analytic", Model::Analytic), ("engine", Model::Engine)];
}

/// Simulates a scene of any kind with the given model.
///
/// Without the `engine` feature, runs of the engine model are rejected.
///
/// # Errors
/// Returns an error if the scene is rejected, the sink fails, or the simulation does not complete.
pub fn run(model: Model, scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        #[cfg(feature = "engine")]
        Model::Engine => run_engine(scene, sink),
        #[cfg(not(feature = "engine"))]
        Model::Engine => Err(RunError::rejected("this build has no engine model".to_string(), Outcome::default())),
    }
}
