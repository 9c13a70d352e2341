//! Integrates an analytic model and records the samples that its reader produces.

use super::grid::Span;
use super::reading::Reader;
use super::recorder::Recorder;
use super::{Outcome, Reach, RunError, Sink, Work};
use crate::integrator::{self, Counters, Hybrid, Options, RadauOrRodas, State, Tolerances, integrate_by};
use crate::scene::{Integrator, Method, Scene};

/// Integrates a model from `start` to the end of the scene, or to where the object leaves the reach of the fingers, and
/// records the samples that `reader` produces.
pub(super) fn simulate<M, R, const N: usize, const Z: usize, const G: usize>(
    model: &M,
    reader: &R,
    start: State<N, Z>,
    settings: &Integrator,
    (scene, reach): (&Scene, Option<Reach>),
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError>
where
    M: Hybrid<N, Z, G>,
    R: Reader<N, Z, Mode = M::Mode>,
{
    let span = Span::from_scene(scene);
    let options = options(settings);
    let mode = model.mode_at(0.0, &start.q, &start.v);
    let mut recorder = Recorder::new(reader, mode, &start, (span, reach), sink);
    recorder.begin()?;
    let method: RadauOrRodas<N, Z> = match settings.method {
        Method::Rodas5p => RadauOrRodas::rodas(),
        Method::RadauIIa5 => integrator::Method::new(),
    };
    let end = integrate_by(method, model, &options, 0.0, start, span.end_s, &mut recorder);
    let outcome = recorder.finish(&end.state, work(&end.counters))?;
    match end.result {
        Err(failure) if outcome.ejected_s.is_none() => {
            Err(RunError::Simulation { failure, partial_outcome: Box::new(outcome) })
        }
        _ => Ok(outcome),
    }
}

fn options(settings: &Integrator) -> Options {
    Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    }
}

fn work(counters: &Counters) -> Work {
    Work {
        steps: counters.steps,
        rejected: counters.rejected,
        rhs_evaluations: counters.rhs,
        jacobian_evaluations: counters.jacobians,
        events: counters.events,
        ..Work::default()
    }
}
