//! Builds the analytic model of a scene: the kernel for its size.

use super::grid::RecordingOptions;
use super::mechanism::build_mechanism;
use super::reading::{Kernel, KernelUser, Start};
use super::stepper::{AnalyticStepper, Stepper};
use super::{Outcome, RunError};
use crate::analytic::FingerMotion;
use crate::integrator::Hybrid;
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

/// Builds the kernel of a scene for a use of it: the closed form of one finger, or that of any mechanism.
///
/// # Errors
/// Returns an error for links that do not close their loops, and for a mechanism without independent coordinates.
pub(crate) fn with_kernel<U: KernelUser>(scene: &Scene, user: U) -> Result<U::Output, RunError> {
    let hand = &scene.hand;
    if scene.mechanism.is_none() && scene.finger_count() == 1 && fits_finger_kernel(hand) {
        return match hand.has_stiction() {
            true => build_finger::<4, 6, U>(scene, user),
            false => build_finger::<2, 4, U>(scene, user),
        };
    }
    let mechanism = scene.mechanism().map_err(|error| RunError::rejected(error.to_string(), Outcome::default()))?;
    build_mechanism(scene, &mechanism, user)
}

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
