//! Runs the analytic model of a scene of discs and tells a sink about it.

use super::recorder::Recorder;
use super::{BodiesOutcome, BodiesRunError, BodiesSample};
use crate::analytic::discs::{Discs, GUARDS, QUADRATURES, moving_discs};
use crate::integrator::{Failure, Options, RadauOrRodas, Reason, Rodas5p, Tolerances, integrate};
use crate::scene::{BodiesScene, Method};
use crate::trace::Sink;
use crate::trace::analytic::work;

/// Simulates `scene` with the analytic model.
///
/// The sink gets a sample at every point of the grid `scene.log.numeric_hz`, at every integrator step shorter than its
/// interval, and at both ends; and every event, in order of time. A scene with more discs or pairs than the model takes is
/// refused.
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
    let start = Discs::<N, M>::start(scene);
    let settings = &scene.integrator;
    let options = Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    };
    let mut recorder = Recorder::new(&model, scene, start, sink);
    recorder.begin()?;
    let end_s = scene.duration_s;
    let end = match settings.method {
        Method::Rodas5p => integrate::<N, QUADRATURES, GUARDS, _, Rodas5p<N, QUADRATURES>, _>(
            &model,
            &options,
            0.0,
            start,
            end_s,
            &mut recorder,
        ),
        Method::RadauIIa5 => integrate::<N, QUADRATURES, GUARDS, _, RadauOrRodas<N, QUADRATURES>, _>(
            &model,
            &options,
            0.0,
            start,
            end_s,
            &mut recorder,
        ),
    };
    let outcome = recorder.finish(&end.state, work(&end.counters))?;
    match end.result {
        Ok(()) => Ok(outcome),
        Err(failure) => Err(BodiesRunError::Simulation { failure, so_far: Box::new(outcome) }),
    }
}
