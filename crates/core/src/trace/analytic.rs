//! Runs the analytic model of a scene and reports the run to a sink.

#[cfg(feature = "lists")]
use super::mechanism::run_mechanism;
use super::reading::SystemReader;
use super::simulate::simulate;
use super::{Outcome, Reach, RunError, Sink};
#[cfg(feature = "lists")]
use crate::analytic::multibody::{MAX_SIZES, TooLarge, count_moving_discs};
use crate::analytic::multibody::{Multibody, Size};
use crate::analytic::{EVENT_FUNCTIONS, FingerMotion, QUADRATURES};
#[cfg(not(feature = "lists"))]
use crate::mechanism::Mechanism;
use crate::scene::keywords::SceneKind;
use crate::scene::{Integrator, Motor, Scene, Side, System};

/// Simulates `scene` with the analytic model.
///
/// The sink receives a sample at every point of the grid `scene.log.numeric_hz`, at every integrator step shorter than
/// the grid interval, and at both ends; and every event, in order of time. In gripper runs with more than 1000 grid
/// points, longer steps get 4 to 7 of their grid points.
///
/// # Errors
/// Returns an error if the scene has more discs or pairs than the model supports or is unsupported
/// ([`System::unsupported`](crate::scene::System::unsupported)), the sink fails, or the simulation does not complete.
pub fn run_analytic(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    if let Some(mechanism) = &scene.mechanism {
        return run_mechanism(scene, mechanism, sink);
    }
    let system = &scene.system;
    if let Some(reason) = system.unsupported() {
        return Err(RunError::rejected(reason.to_string(), Outcome::default()));
    }
    match scene.kind() {
        SceneKind::Finger if fits_finger_kernel(system) => match system.has_stiction() {
            true => run_finger::<4, 6>(scene, sink),
            false => run_finger::<2, 4>(scene, sink),
        },
        SceneKind::Finger => run_general(scene, sink),
        // Mechanisms have been run above.
        SceneKind::Bodies | SceneKind::Mechanism => run_discs(scene, sink),
        SceneKind::Gripper => run_gripper(scene, sink),
    }
}

/// Runs two fingers with at most one object, which has six contacts with phalanges, palm and table: 4, 7 or 8
/// coordinates, or up to 16 with bristle states.
fn run_gripper(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let system = &scene.system;
    match (system.discs.len(), system.has_stiction(), Size::of_system(system).coordinates) {
        (0 | 1, false, 4) => run_multibody::<4, 8, 10, 24>(scene, 1.0, sink),
        (0 | 1, false, 7) => run_multibody::<7, 8, 10, 24>(scene, 1.0, sink),
        (0 | 1, false, 8) => run_multibody::<8, 8, 10, 24>(scene, 1.0, sink),
        (0 | 1, true, ..=16) => run_multibody::<16, 8, 10, 24>(scene, 1.0, sink),
        _ => run_general(scene, sink),
    }
}

/// Runs a scene of discs.
#[cfg(feature = "lists")]
fn run_discs(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    match count_moving_discs(&scene.system).map(|moving| (moving, scene.system.has_stiction())) {
        Ok((0, _)) => Ok(Outcome::default()),
        Ok((_, true)) => run_multibody::<18, 12, 14, 36>(scene, 1.0, sink),
        Ok((_, false)) => run_multibody::<9, 12, 14, 36>(scene, 1.0, sink),
        Err(error) => Err(too_large(&error)),
    }
}

/// Runs any other system that fits the largest kernel.
#[cfg(feature = "lists")]
fn run_general(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let (size, has_stiction) = (Size::of_system(&scene.system), scene.system.has_stiction());
    let max_size = MAX_SIZES[usize::from(has_stiction)];
    // Unused coordinates have no errors; scaled tolerances compensate for their share in the mean over all coordinates.
    let tolerance_scale = (size.coordinates as f64 / max_size.coordinates as f64).sqrt();
    match (size.fits(&max_size), has_stiction) {
        (false, _) => Err(too_large(&TooLarge::Components { size, limit: max_size })),
        (true, false) => run_multibody::<{ MAX_SIZES[0].coordinates }, 24, 26, 72>(scene, tolerance_scale, sink),
        (true, true) => run_multibody::<{ MAX_SIZES[1].coordinates }, 24, 26, 72>(scene, tolerance_scale, sink),
    }
}

/// Error for a system that exceeds the largest kernel.
#[cfg(feature = "lists")]
fn too_large(error: &TooLarge) -> RunError {
    RunError::rejected(
        format!("{error}, or simulate with `--model engine`, which takes any number"),
        Outcome::default(),
    )
}

#[cfg(not(feature = "lists"))]
fn run_mechanism(scene: &Scene, _: &Mechanism, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    run_general(scene, sink)
}

#[cfg(not(feature = "lists"))]
fn run_discs(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    run_general(scene, sink)
}

#[cfg(not(feature = "lists"))]
fn run_general(_: &Scene, _: &mut dyn Sink) -> Result<Outcome, RunError> {
    let reason = "in this build the analytic model supports only a finger and a gripper with one object";
    Err(RunError::rejected(reason.to_string(), Outcome::default()))
}

/// Whether the system is one finger that closes on fixed surfaces, driven by a torque alone; the finger kernel supports
/// nothing else.
fn fits_finger_kernel(system: &System) -> bool {
    let motor = &system.finger(Side::Right).motor;
    let is_torque_driven = *motor == Motor::from_actuation(motor.actuation.clone());
    system.discs.iter().all(|disc| !disc.motion.moves())
        && system.discs.len() < 2
        && system.palm_motion.is_none()
        && is_torque_driven
}

/// Runs a scene with the finger kernel.
fn run_finger<const N: usize, const W: usize>(scene: &Scene, sink: &mut dyn Sink) -> Result<Outcome, RunError> {
    let model = FingerMotion::<N, W>::new(&scene.system);
    let start = FingerMotion::<N, W>::start(&scene.system);
    simulate::<_, _, N, QUADRATURES, EVENT_FUNCTIONS>(&model, &model, start, &scene.integrator, (scene, None), sink)
}

/// Runs a system of up to N coordinates and C contacts, with Z quadratures and G event functions, and with all tolerances
/// multiplied by `tolerance_scale`.
fn run_multibody<const N: usize, const C: usize, const Z: usize, const G: usize>(
    scene: &Scene,
    tolerance_scale: f64,
    sink: &mut dyn Sink,
) -> Result<Outcome, RunError> {
    let requested = &scene.integrator;
    let settings = Integrator {
        atol_angle_rad: tolerance_scale * requested.atol_angle_rad,
        atol_rate_rad_s: tolerance_scale * requested.atol_rate_rad_s,
        rtol: tolerance_scale * requested.rtol,
        ..*requested
    };
    let model = Multibody::<N, C>::new(&scene.system);
    let reader = SystemReader { model: &model, system: &scene.system };
    let start = model.start::<Z>(&scene.system);
    let reach = Reach::from_system(&scene.system);
    simulate::<_, _, N, Z, G>(&model, &reader, start, &settings, (scene, reach), sink)
}
