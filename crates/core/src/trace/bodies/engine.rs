//! Runs the engine model of a scene of discs and tells a sink about it.

use super::{BodiesOutcome, BodiesRunError, BodiesSample};
use crate::engine::plan_discs;
use crate::scene::BodiesScene;
use crate::trace::Sink;
use crate::trace::engine::simulate;
use crate::trace::grid::Span;

/// Simulates `scene` with the engine model, as `scene.engine` says. Samples and events are as in
/// [`run_engine`](crate::trace::run_engine).
pub fn run_engine(scene: &BodiesScene, sink: &mut dyn Sink<BodiesSample>) -> Result<BodiesOutcome, BodiesRunError> {
    let plan = plan_discs(scene);
    let span = Span { end_s: scene.duration_s, numeric_hz: scene.log.numeric_hz };
    simulate(&plan, scene, plan.contacts.len(), &scene.engine, span, sink)
}
