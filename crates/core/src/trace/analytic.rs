//! Builds the analytic model of a scene: the kernel for its size.

use super::grid::RecordingOptions;
#[cfg(feature = "lists")]
use super::mechanism::build_mechanism;
use super::reading::{Kernel, KernelUser, Start};
use super::stepper::{AnalyticStepper, Stepper};
use super::{Outcome, Reach, RunError};
use crate::analytic::multibody::{MAX_GRASP_BRISTLES, MAX_GRASP_COORDINATES, Multibody, Size, count_bristles};
#[cfg(feature = "lists")]
use crate::analytic::multibody::{MAX_SIZES, TooLarge};
use crate::analytic::{EVENT_FUNCTIONS, FingerMotion, QUADRATURES};
use crate::integrator::Hybrid;
#[cfg(not(feature = "lists"))]
use crate::mechanism::Mechanism;
use crate::scene::{Hand, Integrator, Motor, Scene, Side};

/// Builds the stepper of a scene.
struct StepperBuilder<'a> {
    scene: &'a Scene,
    recording: RecordingOptions,
}

impl KernelUser for StepperBuilder<'_> {
    type Output = Box<dyn Stepper>;

    fn use_kernel<M, const N: usize, const Z: usize, const G: usize>(self, start: Start<M, N, Z>) -> Box<dyn Stepper>
    where
        M: Kernel<N, Z> + Hybrid<N, Z, G>,
    {
        Box::new(AnalyticStepper::<M, N, Z, G>::new(start, self.scene.duration_s, self.recording))
    }
}

/// Builds the analytic model of a scene at its start.
///
/// # Errors
/// See [`with_kernel`].
pub(super) fn build_analytic(scene: &Scene, recording: RecordingOptions) -> Result<Box<dyn Stepper>, RunError> {
    with_kernel(scene, StepperBuilder { scene, recording })
}

/// Builds the kernel of a scene for a use of it.
///
/// # Errors
/// Returns an error if the scene has more discs or pairs than the model supports or is unsupported
/// ([`Hand::unsupported`](crate::scene::Hand::unsupported)).
pub(super) fn with_kernel<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    if let Some(mechanism) = &scene.mechanism {
        return build_mechanism(scene, mechanism, user);
    }
    let hand = &scene.hand;
    match (scene.finger_count(), hand.has_stiction()) {
        (1, true) if fits_finger_kernel(hand) => build_finger::<4, 6, U>(scene, user),
        (1, false) if fits_finger_kernel(hand) => build_finger::<2, 4, U>(scene, user),
        (2, _) => build_gripper(scene, user),
        _ => build_general(scene, user),
    }
}

/// Two fingers with at most one object, which has six contacts with phalanges, palm and table: 4, 7 or 8
/// coordinates, or 16 with bristle states.
fn build_gripper<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let hand = &scene.hand;
    match (hand.discs.len(), count_bristles(hand), Size::of_hand(hand).coordinates) {
        (0 | 1, 0, 4) => build_multibody::<4, 8, 10, 24, U>(scene, 1.0, user),
        (0 | 1, 0, 7) => build_multibody::<7, 8, 10, 24, U>(scene, 1.0, user),
        (0 | 1, 0, 8) => build_multibody::<8, 8, 10, 24, U>(scene, 1.0, user),
        (0 | 1, 1..=MAX_GRASP_BRISTLES, _) => build_multibody::<MAX_GRASP_COORDINATES, 8, 10, 24, U>(scene, 1.0, user),
        _ => build_general(scene, user),
    }
}

/// Any other system that fits the largest kernel.
#[cfg(feature = "lists")]
fn build_general<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let (size, has_stiction) = (Size::of_hand(&scene.hand), scene.hand.has_stiction());
    let max_size = MAX_SIZES[usize::from(has_stiction)];
    // Unused coordinates have no errors; scaled tolerances compensate for their share in the mean over all coordinates.
    let tolerance_scale = (size.coordinates as f64 / max_size.coordinates as f64).sqrt();
    match (size.fits(&max_size), has_stiction) {
        (false, _) => Err(too_large(&TooLarge::Components { size, limit: max_size })),
        (true, false) => build_multibody::<{ MAX_SIZES[0].coordinates }, 24, 26, 72, U>(scene, tolerance_scale, user),
        (true, true) => build_multibody::<{ MAX_SIZES[1].coordinates }, 24, 26, 72, U>(scene, tolerance_scale, user),
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
fn build_mechanism<U: KernelUser>(scene: &Scene, _: &Mechanism, user: U) -> Result<U::Output, RunError> {
    build_general(scene, user)
}

#[cfg(not(feature = "lists"))]
fn build_general<U: KernelUser>(_: &Scene, _: U) -> Result<U::Output, RunError> {
    let reason = "in this build the analytic model supports only a finger and a gripper with one object";
    Err(RunError::rejected(reason.to_string(), Outcome::default()))
}

/// Whether the system is one finger that closes on fixed surfaces, driven by a torque alone; the finger kernel supports
/// nothing else.
fn fits_finger_kernel(hand: &Hand) -> bool {
    let motor = &hand.finger(Side::Right).motor;
    let is_torque_driven = *motor == Motor::from_actuation(motor.actuation.clone());
    hand.discs.iter().all(|disc| !disc.motion.moves())
        && hand.discs.len() < 2
        && hand.palm_motion.is_none()
        && is_torque_driven
}

/// A scene with the finger kernel.
fn build_finger<const N: usize, const W: usize, U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let kernel = FingerMotion::<N, W>::new(&scene.hand);
    let state = FingerMotion::<N, W>::start(&scene.hand);
    let start = Start { kernel, state, settings: scene.integrator, reach: None };
    Ok(user.use_kernel::<_, N, QUADRATURES, EVENT_FUNCTIONS>(start))
}

/// A system of up to N coordinates and C contacts, with Z quadratures and G event functions, and with all tolerances
/// multiplied by `tolerance_scale`.
fn build_multibody<const N: usize, const C: usize, const Z: usize, const G: usize, U: KernelUser>(
    scene: &Scene,
    tolerance_scale: f64,
    user: U,
) -> Result<U::Output, RunError> {
    let requested = &scene.integrator;
    let settings = Integrator {
        atol_angle_rad: tolerance_scale * requested.atol_angle_rad,
        atol_rate_rad_s: tolerance_scale * requested.atol_rate_rad_s,
        rtol: tolerance_scale * requested.rtol,
        ..*requested
    };
    let kernel = Multibody::<N, C>::new(&scene.hand);
    let (state, reach) = (kernel.start::<Z>(&scene.hand), Reach::from_hand(&scene.hand));
    Ok(user.use_kernel::<_, N, Z, G>(Start { kernel, state, settings, reach }))
}
