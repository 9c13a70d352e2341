//! Runs the analytic model of a scene and tells a sink about it.

use super::ejection::up_to_ejection;
use super::grid::Span;
#[cfg(feature = "discs")]
use super::reading::DiscsReader;
use super::reading::Reader;
use super::recorder::Recorder;
use super::{Outcome, RunError, Sink, Work};
#[cfg(feature = "discs")]
use crate::analytic::discs::{self, Discs, HOLDING, moving_discs};
use crate::analytic::gripper::{self as grasp, GripperModel};
use crate::analytic::{FingerMotion, GUARDS, QUADRATURES};
use crate::integrator::{
    self, Counters, Failure, Hybrid, Options, RadauOrRodas, Reason, State, Tolerances, integrate_by,
};
use crate::scene::words::SceneKind;
use crate::scene::{Integrator, Method, Scene};

/// Simulates `scene` with the analytic model.
///
/// The sink gets a sample at every point of the grid `scene.log.numeric_hz`, at every integrator step shorter than its
/// interval, and at both ends; and every event, in order of time. Runs of grippers with more than 1000 points have 4 to 7 of
/// those within a step that is longer.
///
/// A scene with more discs or pairs than the model takes is refused, and one that has an objection ([`System::objection`](crate::scene::System::objection)).
pub fn run_analytic(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let (system, span) = (&scene.system, Span::of(scene));
    if let Some(why) = system.objection() {
        return Err(none_at_all(why.to_string()));
    }
    match scene.kind() {
        SceneKind::Finger if system.holds() => finger::<4, 6>(scene, span, sink),
        SceneKind::Finger => finger::<2, 4>(scene, span, sink),
        #[cfg(feature = "discs")]
        SceneKind::Bodies => match moving_discs(system) {
            Ok(1) if system.holds() => some_discs::<{ 3 + HOLDING[1] }, { 6 + 2 * HOLDING[1] }>(scene, span, sink),
            Ok(2) if system.holds() => some_discs::<{ 6 + HOLDING[2] }, { 12 + 2 * HOLDING[2] }>(scene, span, sink),
            Ok(3) if system.holds() => some_discs::<{ 9 + HOLDING[3] }, { 18 + 2 * HOLDING[3] }>(scene, span, sink),
            Ok(1) => some_discs::<3, 6>(scene, span, sink),
            Ok(2) => some_discs::<6, 12>(scene, span, sink),
            Ok(3) => some_discs::<9, 18>(scene, span, sink),
            Ok(_) => Ok(Outcome::default()),
            Err(too_many) => {
                Err(none_at_all(format!("{too_many}, or simulate with `--model engine`, which takes any number")))
            }
        },
        #[cfg(not(feature = "discs"))]
        SceneKind::Bodies => Err(none_at_all("this build has no analytic model of discs".to_string())),
        SceneKind::Gripper => up_to_ejection(system, sink, |sink| match system.moving_object() {
            _ if system.holds() => gripper::<{ grasp::HELD }>(scene, span, sink),
            Some(_) if system.palm_motion.is_some() => gripper::<8>(scene, span, sink),
            Some(_) => gripper::<7>(scene, span, sink),
            None => gripper::<4>(scene, span, sink),
        }),
    }
}

/// A run that ends before it begins.
pub(super) fn none_at_all(reason: String) -> RunError {
    let failure = Failure { time_s: 0.0, reason: Reason::Obstacle(reason) };
    RunError::Simulation { failure, so_far: Box::default() }
}

fn finger<const N: usize, const W: usize>(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let model = FingerMotion::<N, W>::new(&scene.system);
    let start = FingerMotion::<N, W>::start(&scene.system);
    simulate::<_, _, N, QUADRATURES, GUARDS>(&model, &model, start, &scene.integrator, span, sink)
}

#[cfg(feature = "discs")]
fn some_discs<const N: usize, const M: usize>(
    scene: &Scene,
    span: Span,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    let model = Discs::<N, M>::new(&scene.system);
    let reader = DiscsReader { model: &model, system: &scene.system };
    let start = Discs::<N, M>::start(&scene.system);
    simulate::<_, _, N, { discs::QUADRATURES }, { discs::GUARDS }>(
        &model,
        &reader,
        start,
        &scene.integrator,
        span,
        sink,
    )
}

fn gripper<const N: usize>(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let model = GripperModel::<N>::new(&scene.system);
    let start = grasp::start::<N>(&scene.system);
    simulate::<_, _, N, { grasp::QUADRATURES }, { grasp::GUARDS }>(&model, &model, start, &scene.integrator, span, sink)
}

/// Integrates a model from `start` on, and shows what `reader` makes of it.
fn simulate<M, R, const N: usize, const Z: usize, const G: usize>(
    model: &M,
    reader: &R,
    start: State<N, Z>,
    settings: &Integrator,
    span: Span,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError>
where
    M: Hybrid<N, Z, G>,
    R: Reader<N, Z, Mode = M::Mode>,
{
    let options = options(settings);
    let mode = model.read_mode(0.0, &start.q, &start.v);
    let mut recorder = Recorder::new(reader, mode, &start, span, sink);
    recorder.begin()?;
    let method: RadauOrRodas<N, Z> = match settings.method {
        Method::Rodas5p => RadauOrRodas::rodas(),
        Method::RadauIIa5 => integrator::Method::new(),
    };
    let end = integrate_by(method, model, &options, 0.0, start, span.end_s, &mut recorder);
    let outcome = recorder.finish(&end.state, work(&end.counters))?;
    match end.result {
        Ok(()) => Ok(outcome),
        Err(failure) => Err(RunError::Simulation { failure, so_far: Box::new(outcome) }),
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
