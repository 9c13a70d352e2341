//! Builds the analytic model of a scene: the kernel for its size.

use super::grid::RecordingOptions;
#[cfg(feature = "mechanisms")]
use super::mechanism::build_mechanism;
use super::reading::{Kernel, KernelUser, Start};
use super::stepper::{AnalyticStepper, Stepper};
use super::{Exit, Outcome, RunError};
use crate::analytic::FingerMotion;
use crate::analytic::multibody::{MAX_GRASP_BRISTLES, MAX_GRASP_COORDINATES, Multibody};
use crate::integrator::Hybrid;
#[cfg(not(feature = "mechanisms"))]
use crate::mechanism::Mechanism;
use crate::scene::{Hand, Motor, Scene, Side};

/// Builds the stepper of a scene.
struct StepperBuilder<'a> {
    scene: &'a Scene,
    recording: RecordingOptions,
}

impl KernelUser for StepperBuilder<'_> {
    type Output = Box<dyn Stepper>;

    fn use_kernel<M: Kernel + Hybrid>(self, start: Start<M>) -> Box<dyn Stepper> {
        Box::new(AnalyticStepper::new(start, self.scene.duration_s, self.recording))
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
/// Returns an error if a mechanism exceeds the largest model, or if the hand has too many bristles.
pub(crate) fn with_kernel<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    if let Some(mechanism) = &scene.mechanism {
        return build_mechanism(scene, mechanism, user);
    }
    let hand = &scene.hand;
    match (scene.finger_count(), hand.has_stiction()) {
        (1, true) if fits_finger_kernel(hand) => build_finger::<4, 6, U>(scene, user),
        (1, false) if fits_finger_kernel(hand) => build_finger::<2, 4, U>(scene, user),
        (1, _) => Err(RunError::rejected(UNSUPPORTED_FINGER.to_string(), Outcome::default())),
        _ => build_gripper(scene, user),
    }
}

/// Two fingers with their object, palm and table: 4, 7 or 8 coordinates, or 16 with bristle states.
fn build_gripper<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let hand = &scene.hand;
    match (hand.moving_object().is_some(), hand.palm_motion.is_some(), hand.bristle_count()) {
        (false, false, 0) => build_multibody::<4, U>(scene, user),
        (true, false, 0) => build_multibody::<7, U>(scene, user),
        (true, true, 0) => build_multibody::<8, U>(scene, user),
        (.., 0..=MAX_GRASP_BRISTLES) => build_multibody::<MAX_GRASP_COORDINATES, U>(scene, user),
        (.., bristles) => {
            let reason = format!(
                "contacts and brakes have {bristles} bristles; the analytic model takes up to {MAX_GRASP_BRISTLES}: remove some, \
                 or simulate with `--model engine`, which takes any number"
            );
            Err(RunError::rejected(reason, Outcome::default()))
        }
    }
}

#[cfg(not(feature = "mechanisms"))]
fn build_mechanism<U: KernelUser>(_: &Scene, _: &Mechanism, _: U) -> Result<U::Output, RunError> {
    let reason = "in this build the analytic model supports only a closing finger and a gripper with one object";
    Err(RunError::rejected(reason.to_string(), Outcome::default()))
}

/// Reason for the rejection of a single finger that no scene file describes.
const UNSUPPORTED_FINGER: &str = "the analytic model simulates a single finger only on fixed surfaces and driven by a torque; \
     describe others as a mechanism (`kind = \"mechanism\"`), or use `--model engine`";

/// Whether the hand is one finger that closes on fixed surfaces, driven by a torque alone; the finger kernel supports
/// nothing else.
fn fits_finger_kernel(hand: &Hand) -> bool {
    let motor = &hand.finger(Side::Right).motor;
    let is_torque_driven = *motor == Motor::from_actuation(motor.actuation.clone());
    hand.moving_object().is_none() && hand.palm_motion.is_none() && is_torque_driven
}

/// A scene with the finger kernel.
fn build_finger<const N: usize, const W: usize, U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let kernel = FingerMotion::<N, W>::new(&scene.hand);
    let state = FingerMotion::<N, W>::start(&scene.hand);
    let start = Start { kernel, state, settings: scene.integrator, exit: None };
    Ok(user.use_kernel(start))
}

/// A hand of up to N coordinates.
fn build_multibody<const N: usize, U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let kernel = Multibody::<N>::new(&scene.hand);
    let (state, exit) = (kernel.start(&scene.hand), Exit::from_scene(scene));
    Ok(user.use_kernel(Start { kernel, state, settings: scene.integrator, exit }))
}
