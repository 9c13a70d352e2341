//! Runs the analytic model of a scene and tells a sink about it.

use super::grid::Span;
use super::reading::{Reader, SystemReader};
use super::recorder::Recorder;
use super::{Outcome, Reach, RunError, Sink, Work};
use crate::analytic::multibody::{Multibody, Size};
#[cfg(feature = "lists")]
use crate::analytic::multibody::{ROOM, TooMany, of_discs};
use crate::analytic::{FingerMotion, GUARDS, QUADRATURES};
use crate::integrator::{
    self, Counters, Failure, Hybrid, Options, RadauOrRodas, Reason, State, Tolerances, integrate_by,
};
use crate::scene::words::SceneKind;
use crate::scene::{Integrator, Method, Motor, Scene, Side, System};

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
        SceneKind::Finger if is_closing(system) => match system.holds() {
            true => finger::<4, 6>(scene, span, sink),
            false => finger::<2, 4>(scene, span, sink),
        },
        SceneKind::Finger => list(scene, span, sink),
        SceneKind::Bodies => discs(scene, span, sink),
        SceneKind::Gripper => gripper(scene, span, sink),
    }
}

/// Two fingers with what they grasp, which have six places, palm and table: of 4, 7 or 8 coordinates, or of up to 16 with the memories of
/// bristles.
fn gripper(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let system = &scene.system;
    match (system.discs.len(), system.holds(), Size::of(system).coordinates) {
        (0 | 1, false, 4) => parts::<4, 8, 10, 24>(scene, span, sink),
        (0 | 1, false, 7) => parts::<7, 8, 10, 24>(scene, span, sink),
        (0 | 1, false, 8) => parts::<8, 8, 10, 24>(scene, span, sink),
        (0 | 1, true, ..=16) => parts::<16, 8, 10, 24>(scene, span, sink),
        _ => list(scene, span, sink),
    }
}

/// Discs alone.
#[cfg(feature = "lists")]
fn discs(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match of_discs(&scene.system).map(|moving| (moving, scene.system.holds())) {
        Ok((0, _)) => Ok(Outcome::default()),
        Ok((_, true)) => parts::<18, 12, 14, 36>(scene, span, sink),
        Ok((_, false)) => parts::<9, 12, 14, 36>(scene, span, sink),
        Err(too_many) => Err(too_large(&too_many)),
    }
}

/// Anything that has room.
#[cfg(feature = "lists")]
fn list(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let (of, holds) = (Size::of(&scene.system), scene.system.holds());
    let most = ROOM[usize::from(holds)];
    // Coordinates that are not there have no errors: the tolerances make up for their part in the mean of all.
    let part = (of.coordinates as f64 / most.coordinates as f64).sqrt();
    match (of.fits(&most), holds) {
        (false, _) => Err(too_large(&TooMany::Parts { of, most })),
        (true, false) => parts_within::<{ ROOM[0].coordinates }, 24, 26, 72>(scene, part, span, sink),
        (true, true) => parts_within::<{ ROOM[1].coordinates }, 24, 26, 72>(scene, part, span, sink),
    }
}

#[cfg(feature = "lists")]
fn too_large(too_many: &TooMany) -> RunError {
    none_at_all(format!("{too_many}, or simulate with `--model engine`, which takes any number"))
}

#[cfg(not(feature = "lists"))]
fn discs(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    list(scene, span, sink)
}

#[cfg(not(feature = "lists"))]
fn list(_: &Scene, _: Span, _: &mut dyn Sink) -> Result<Outcome, RunError> {
    Err(none_at_all("this build has no analytic model but of a finger and of a gripper with one object".to_string()))
}

/// Whether it is one finger that closes on what does not move, driven by a torque alone: the kernel of a finger knows of nothing else.
fn is_closing(system: &System) -> bool {
    let motor = &system.finger(Side::Right).motor;
    let by_torque = *motor == Motor::of(motor.actuation.clone());
    system.discs.iter().all(|disc| !disc.motion.moves())
        && system.discs.len() < 2
        && system.palm_motion.is_none()
        && by_torque
}

/// A run that ends before it begins.
pub(super) fn none_at_all(reason: String) -> RunError {
    let failure = Failure { time_s: 0.0, reason: Reason::Obstacle(reason) };
    RunError::Simulation { failure, so_far: Box::default() }
}

fn finger<const N: usize, const W: usize>(scene: &Scene, span: Span, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let model = FingerMotion::<N, W>::new(&scene.system);
    let start = FingerMotion::<N, W>::start(&scene.system);
    simulate::<_, _, N, QUADRATURES, GUARDS>(&model, &model, start, &scene.integrator, (span, None), sink)
}

/// Of a system that has room in N coordinates and C contacts, with Z quadratures and G guards.
fn parts<const N: usize, const C: usize, const Z: usize, const G: usize>(
    scene: &Scene,
    span: Span,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    parts_within::<N, C, Z, G>(scene, 1.0, span, sink)
}

/// The same, with a part of all tolerances.
fn parts_within<const N: usize, const C: usize, const Z: usize, const G: usize>(
    scene: &Scene,
    part: f64,
    span: Span,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    let asked = &scene.integrator;
    let settings = Integrator {
        atol_angle_rad: part * asked.atol_angle_rad,
        atol_rate_rad_s: part * asked.atol_rate_rad_s,
        rtol: part * asked.rtol,
        ..*asked
    };
    let model = Multibody::<N, C>::new(&scene.system);
    let reader = SystemReader { model: &model, system: &scene.system };
    let start = model.start::<Z>(&scene.system);
    let until = (span, Reach::of(&scene.system));
    simulate::<_, _, N, Z, G>(&model, &reader, start, &settings, until, sink)
}

/// Integrates a model from `start` to the end of the span, or to where the object leaves the reach of the fingers, and shows what `reader`
/// makes of it.
fn simulate<M, R, const N: usize, const Z: usize, const G: usize>(
    model: &M,
    reader: &R,
    start: State<N, Z>,
    settings: &Integrator,
    (span, reach): (Span, Option<Reach>),
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError>
where
    M: Hybrid<N, Z, G>,
    R: Reader<N, Z, Mode = M::Mode>,
{
    let options = options(settings);
    let mode = model.read_mode(0.0, &start.q, &start.v);
    let mut recorder = Recorder::new(reader, mode, &start, (span, reach), sink);
    recorder.begin()?;
    let method: RadauOrRodas<N, Z> = match settings.method {
        Method::Rodas5p => RadauOrRodas::rodas(),
        Method::RadauIIa5 => integrator::Method::new(),
    };
    let end = integrate_by(method, model, &options, 0.0, start, span.end_s, &mut recorder);
    let outcome = recorder.finish(&end.state, work(&end.counters))?;
    match end.result {
        Err(failure) if outcome.ejected_s.is_none() => Err(RunError::Simulation { failure, so_far: Box::new(outcome) }),
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
