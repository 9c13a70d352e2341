//! Builds the analytic model of a scene.

use super::grid::RecordingOptions;
#[cfg(feature = "lists")]
use super::mechanism::build_mechanism;
use super::stepper::{AnalyticStepper, Stepper};
use super::{Outcome, Reach, RunError};
#[cfg(feature = "lists")]
use crate::analytic::multibody::{MAX_SIZES, TooLarge, count_moving_discs};
use crate::analytic::multibody::{Multibody, Size};
use crate::analytic::{EVENT_FUNCTIONS, FingerMotion, QUADRATURES};
#[cfg(not(feature = "lists"))]
use crate::mechanism::Mechanism;
use crate::scene::keywords::SceneKind;
use crate::scene::{Integrator, Motor, Scene, Side, System};

/// Builds the analytic model of a scene at its start.
///
/// # Errors
/// Returns an error if the scene has more discs or pairs than the model supports or is unsupported
/// ([`System::unsupported`](crate::scene::System::unsupported)).
pub(super) fn build_analytic(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    if let Some(mechanism) = &scene.mechanism {
        return build_mechanism(scene, mechanism, recording);
    }
    let system = &scene.system;
    match scene.kind() {
        SceneKind::Finger if fits_finger_kernel(system) => match system.has_stiction() {
            true => build_finger::<4, 6>(scene, recording),
            false => build_finger::<2, 4>(scene, recording),
        },
        SceneKind::Finger => build_general(scene, recording),
        // Mechanisms have been built above.
        SceneKind::Bodies | SceneKind::Mechanism => build_discs(scene, recording),
        SceneKind::Gripper => build_gripper(scene, recording),
    }
}

/// Two fingers with at most one object, which has six contacts with phalanges, palm and table: 4, 7 or 8
/// coordinates, or up to 16 with bristle states.
fn build_gripper(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    let system = &scene.system;
    match (system.discs.len(), system.has_stiction(), Size::of_system(system).coordinates) {
        (0 | 1, false, 4) => build_multibody::<4, 8, 10, 24>(scene, 1.0, recording),
        (0 | 1, false, 7) => build_multibody::<7, 8, 10, 24>(scene, 1.0, recording),
        (0 | 1, false, 8) => build_multibody::<8, 8, 10, 24>(scene, 1.0, recording),
        (0 | 1, true, ..=16) => build_multibody::<16, 8, 10, 24>(scene, 1.0, recording),
        _ => build_general(scene, recording),
    }
}

/// A scene of discs.
#[cfg(feature = "lists")]
fn build_discs(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    match count_moving_discs(&scene.system).map(|moving| (moving, scene.system.has_stiction())) {
        Ok((0, _)) => Err(RunError::rejected(NOTHING_MOVES.to_string(), Outcome::default())),
        Ok((_, true)) => build_multibody::<18, 12, 14, 36>(scene, 1.0, recording),
        Ok((_, false)) => build_multibody::<9, 12, 14, 36>(scene, 1.0, recording),
        Err(error) => Err(too_large(&error)),
    }
}

/// Any other system that fits the largest kernel.
#[cfg(feature = "lists")]
fn build_general(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    let (size, has_stiction) = (Size::of_system(&scene.system), scene.system.has_stiction());
    let max_size = MAX_SIZES[usize::from(has_stiction)];
    // Unused coordinates have no errors; scaled tolerances compensate for their share in the mean over all coordinates.
    let tolerance_scale = (size.coordinates as f64 / max_size.coordinates as f64).sqrt();
    match (size.fits(&max_size), has_stiction) {
        (false, _) => Err(too_large(&TooLarge::Components { size, limit: max_size })),
        (true, false) => build_multibody::<{ MAX_SIZES[0].coordinates }, 24, 26, 72>(scene, tolerance_scale, recording),
        (true, true) => build_multibody::<{ MAX_SIZES[1].coordinates }, 24, 26, 72>(scene, tolerance_scale, recording),
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
fn build_mechanism(scene: &Scene, _: &Mechanism, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    build_general(scene, recording)
}

#[cfg(not(feature = "lists"))]
fn build_discs(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    build_general(scene, recording)
}

#[cfg(not(feature = "lists"))]
fn build_general(_: &Scene, _: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    let reason = "in this build the analytic model supports only a finger and a gripper with one object";
    Err(RunError::rejected(reason.to_string(), Outcome::default()))
}

/// Reason why a scene without moving discs has no simulation.
#[cfg(feature = "lists")]
const NOTHING_MOVES: &str = "no disc of the scene moves; give one a mass, or a motion";

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

/// A scene with the finger kernel.
fn build_finger<const N: usize, const W: usize>(
    scene: &Scene,
    recording: RecordingOptions,
) -> Result<Box<dyn Stepper>, RunError> {
    let model = FingerMotion::<N, W>::new(&scene.system);
    let start = FingerMotion::<N, W>::start(&scene.system);
    let settings = &scene.integrator;
    Ok(AnalyticStepper::<_, N, QUADRATURES, EVENT_FUNCTIONS>::new_boxed(
        model,
        start,
        settings,
        (scene, None),
        recording,
    ))
}

/// A system of up to N coordinates and C contacts, with Z quadratures and G event functions, and with all tolerances
/// multiplied by `tolerance_scale`.
fn build_multibody<const N: usize, const C: usize, const Z: usize, const G: usize>(
    scene: &Scene,
    tolerance_scale: f64,
    recording: RecordingOptions,
) -> Result<Box<dyn Stepper>, RunError> {
    let requested = &scene.integrator;
    let settings = Integrator {
        atol_angle_rad: tolerance_scale * requested.atol_angle_rad,
        atol_rate_rad_s: tolerance_scale * requested.atol_rate_rad_s,
        rtol: tolerance_scale * requested.rtol,
        ..*requested
    };
    let model = Multibody::<N, C>::new(&scene.system);
    let start = model.start::<Z>(&scene.system);
    let reach = Reach::from_system(&scene.system);
    Ok(AnalyticStepper::<_, N, Z, G>::new_boxed(model, start, &settings, (scene, reach), recording))
}
