//! Runs the analytic model of a scene of discs and tells a sink about it.

use super::reading::DiscsReader;
use super::{BodiesOutcome, BodiesRunError, BodiesSample};
use crate::analytic::discs::{Discs, GUARDS, QUADRATURES, moving_discs};
use crate::integrator::{Failure, Reason};
use crate::scene::BodiesScene;
use crate::trace::Sink;
use crate::trace::analytic::simulate;
use crate::trace::grid::Span;

/// Simulates `scene` with the analytic model. Samples and events are as in [`run_analytic`](crate::trace::run_analytic).
///
/// A scene with more discs or pairs than the model takes is refused.
pub fn run_analytic(scene: &BodiesScene, sink: &mut dyn Sink<BodiesSample>) -> Result<BodiesOutcome, BodiesRunError> {
    match moving_discs(scene) {
        Ok(1) => run::<3, 6>(scene, sink),
        Ok(2) => run::<6, 12>(scene, sink),
        Ok(3) => run::<9, 18>(scene, sink),
        Ok(_) => Ok(BodiesOutcome::default()),
        Err(too_many) => Err(BodiesRunError::Simulation {
            failure: Failure {
                time_s: 0.0,
                reason: Reason::Obstacle(format!(
                    "{too_many}, or simulate with `--model engine`, which takes any number"
                )),
            },
            so_far: Box::default(),
        }),
    }
}

fn run<const N: usize, const M: usize>(
    scene: &BodiesScene,
    sink: &mut dyn Sink<BodiesSample>,
) -> Result<BodiesOutcome, BodiesRunError> {
    let model = Discs::<N, M>::new(scene);
    let reader = DiscsReader { model: &model, scene };
    let span = Span { end_s: scene.duration_s, numeric_hz: scene.log.numeric_hz };
    let start = Discs::<N, M>::start(scene);
    simulate::<_, _, N, QUADRATURES, GUARDS>(&model, &reader, start, &scene.integrator, span, sink)
}
