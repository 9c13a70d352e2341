//! The two models behind one face.

use super::{Outcome, RunError, Simulated, Sink, analytic, engine, run_analytic, run_engine};
use crate::scene::{GripperScene, Words};

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

/// Simulates a scene of either kind with one of the models.
pub fn run<'a>(model: Model, scene: impl Into<Simulated<'a>>, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => run_analytic(scene, sink),
        Model::Engine => run_engine(scene, sink),
    }
}

/// Simulates a gripper with one of the models: its fingers are right and left, its one body is the object, and its contacts are all of
/// [`Place::ALL`](crate::scene::Place::ALL), of which those that the scene lacks have infinite gaps.
///
/// # Errors
/// Why the run did not get to its end, with what there is of it.
pub fn run_gripper(model: Model, scene: &GripperScene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match model {
        Model::Analytic => analytic::gripper(scene, sink),
        Model::Engine => engine::gripper(scene, sink),
    }
}
