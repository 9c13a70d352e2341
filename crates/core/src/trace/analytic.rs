//! Runs the analytic model of a scene and tells a sink about it.

use super::recorder::Recorder;
use super::{Outcome, Sink, SinkError, Work};
use crate::analytic::{GUARDS, Model, QUADRATURES};
use crate::integrator::{
    Counters, End, Failure, Method as OneStep, Options, RadauOrRodas, Reason, Rodas5p, State, Tolerances, integrate,
};
use crate::scene::{Method, Scene};

/// Why a run did not get to its end.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The simulation could not be completed; `so_far` is the run up to there, which the sink has in full.
    #[error("the simulation could not be completed {failure}")]
    Simulation { failure: Failure, so_far: Box<Outcome> },
}

impl RunError {
    /// Whether the run ended because its sink said so, see [`Sink::proceed`].
    pub fn is_stop(&self) -> bool {
        matches!(self, RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. })
    }
}

/// Integration options of a scene.
fn options(scene: &Scene) -> Options {
    let settings = &scene.integrator;
    Options {
        tolerances: Tolerances {
            atol_q: settings.atol_angle_rad,
            atol_v: settings.atol_rate_rad_s,
            rtol_v: settings.rtol,
        },
        max_steps: settings.max_steps,
    }
}

/// The initial state of a scene.
fn initial_state(scene: &Scene) -> State<2, QUADRATURES> {
    let start = &scene.initial;
    State { q: [start.q11_rad, start.q21_rad], v: [start.qd11_rad_s, start.qd21_rad_s], z: [0.0; QUADRATURES] }
}

/// Simulates `scene` with the analytic model.
///
/// The sink gets a sample at every point of the grid `scene.log.numeric_hz`, at every integrator step shorter than its
/// interval, and at both ends; and every event, in order of time.
pub fn run_analytic(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let model = Model::new(scene);
    let (options, start) = (options(scene), initial_state(scene));
    let mut recorder = Recorder::new(&model, scene, start, sink);
    recorder.begin()?;
    let end = match scene.integrator.method {
        Method::Rodas5p => drive::<Rodas5p<2, QUADRATURES>>(&model, &options, start, scene.duration_s, &mut recorder),
        Method::RadauIIa5 => {
            drive::<RadauOrRodas<2, QUADRATURES>>(&model, &options, start, scene.duration_s, &mut recorder)
        }
    };
    let outcome = recorder.finish(&end.state, work(&end.counters))?;
    match end.result {
        Ok(()) => Ok(outcome),
        Err(failure) => Err(RunError::Simulation { failure, so_far: Box::new(outcome) }),
    }
}

/// The integration itself, with one of the methods.
fn drive<K: OneStep<2, QUADRATURES>>(
    model: &Model,
    options: &Options,
    start: State<2, QUADRATURES>,
    duration_s: f64,
    recorder: &mut Recorder,
) -> End<2, QUADRATURES> {
    integrate::<2, QUADRATURES, GUARDS, _, K, _>(model, options, 0.0, start, duration_s, recorder)
}

pub(super) fn work(counters: &Counters) -> Work {
    Work {
        steps: counters.steps,
        rejected: counters.rejected,
        rhs_evaluations: counters.rhs,
        jacobian_evaluations: counters.jacobians,
        events: counters.events,
        ..Work::default()
    }
}
