//! Variants of a scene that a validation runs, the members of its ensemble, and bounds in the unit of its errors.

use super::Recording;
use crate::check::{REFERENCE_LENGTH_M, perturbed, reference_length_m};
use crate::gripper::FingerContact;
use crate::invariants::{Finding, Invariants};
use crate::limits::MAX_VALIDATED_SAMPLES;
use crate::scene::{HandContact, Preset, Scene, Side};
use crate::trace::{Model, Sink};

/// Number of runs of a scene with a finger or discs; the worst one determines the result.
pub(crate) const ENSEMBLE_SIZE: usize = 5;
/// Number of runs of a gripper scene, which take 50 times as long: the scene itself and one perturbed scene.
pub(crate) const GRIPPER_ENSEMBLE_SIZE: usize = 2;
/// Relative difference between the motor torques of consecutive members. It shifts the integrator's steps, but its
/// effect is far below any bound.
pub(crate) const MEMBER_PERTURBATION: f64 = 1e-9;

/// Maximum number of samples of a reference grid: five references at 500 bytes a sample stay below 250 MB.
const MAX_REFERENCE_SAMPLES: f64 = 1e5;
/// Maximum rate of a reference grid; interpolation at this rate is exact to rounding.
const MAX_REFERENCE_HZ: f64 = 1e6;

/// Returns the scene that a validation runs. A scene without joints ends at `until`, so that every figure of a run,
/// including peaks and impulses, is limited to the compared interval.
pub fn compared_scene(scene: &Scene) -> Scene {
    modify(scene, |scene| {
        if !scene.has_joints() {
            scene.duration_s = scene.bounds.until_s.min(scene.duration_s);
        }
    })
}

/// Returns the number of runs of a scene; the worst one determines the result.
pub(crate) fn ensemble_size(scene: &Scene) -> usize {
    if scene.finger_count() == 2 { GRIPPER_ENSEMBLE_SIZE } else { ENSEMBLE_SIZE }
}

/// Returns the scene of member `index`; member 0 is the scene itself.
pub(crate) fn ensemble_member(scene: &Scene, index: usize) -> Scene {
    perturbed(scene, index as f64 * MEMBER_PERTURBATION)
}

/// Checks that a validation of the scene fits into memory. Whole runs are stored for the comparison.
///
/// # Errors
/// Returns an error if the number of samples exceeds [`MAX_VALIDATED_SAMPLES`].
pub fn check_sample_count(scene: &Scene) -> Result<(), String> {
    let (numeric_hz, duration_s) = (scene.log.numeric_hz, scene.duration_s);
    let samples = numeric_hz * duration_s;
    let allowed_hz = (MAX_VALIDATED_SAMPLES / duration_s).floor();
    match samples <= MAX_VALIDATED_SAMPLES {
        true => Ok(()),
        false => Err(format!(
            "the scene requests {samples:.0} samples of a run ({numeric_hz:e} Hz over {duration_s} s), but a validation stores \
             several runs in memory and accepts at most {MAX_VALIDATED_SAMPLES:e}; lower numeric_rate in [log] to {allowed_hz:e} \
             Hz, or shorten the run"
        )),
    }
}

/// Returns the margin of each invariant in a recorded run.
pub fn check_invariants(scene: &Scene, model: Model, run: &Recording) -> Vec<Finding> {
    let mut invariants = Invariants::new(model, scene);
    for sample in &run.samples {
        invariants.sample(sample).expect("Invariants::sample does not write output");
    }
    invariants.findings(run.outcome.loop_gap_m)
}

/// Returns a modified copy of the scene.
pub(super) fn modify(scene: &Scene, change: impl FnOnce(&mut Scene)) -> Scene {
    let mut changed = scene.clone();
    change(&mut changed);
    changed
}

/// Returns the scene of the reference run: with the tightest settings and a dense grid.
pub fn reference_scene(scene: &Scene) -> Scene {
    sampled_scene(Model::Analytic, &modify(scene, |scene| scene.apply_preset(Preset::Reference)))
}

/// Returns the scene with the sampling that a comparison needs. The analytic model is sampled on a dense grid, because
/// it has dense output. The engine is sampled at every step, without interpolation.
pub fn sampled_scene(model: Model, scene: &Scene) -> Scene {
    match model {
        Model::Analytic => modify(scene, |scene| {
            let dense_hz = (MAX_REFERENCE_SAMPLES / scene.duration_s).min(MAX_REFERENCE_HZ);
            scene.log.numeric_hz = dense_hz.max(scene.log.numeric_hz);
        }),
        Model::Engine => scene_sampled_at_steps(scene),
    }
}

/// Returns the scene that is sampled only at the steps of the integrator.
pub fn scene_sampled_at_steps(scene: &Scene) -> Scene {
    modify(scene, |scene| scene.log.numeric_hz = 1.0 / scene.duration_s)
}

/// Largest allowed error of the engine's trajectory, in the unit of the errors of [`check`](crate::check).
pub(crate) fn path_bound(scene: &Scene) -> f64 {
    let bounds = &scene.bounds;
    match scene.finger_count() {
        0 if !scene.has_joints() => bounds.position_m,
        1 => bounds.angle_rad,
        _ => bounds.angle_rad.min(bounds.position_m / REFERENCE_LENGTH_M),
    }
}

/// Largest allowed error of the reference trajectory. The check of the reference scales the position of a grasped
/// object by its radius.
pub(super) fn reference_path_bound(scene: &Scene) -> f64 {
    match scene.finger_count() {
        2 => scene.bounds.angle_rad.min(scene.bounds.position_m / reference_length_m(&scene.hand)),
        _ => path_bound(scene),
    }
}

/// Whether the scene is a single finger.
pub(super) fn is_single_finger(scene: &Scene) -> bool {
    scene.finger_count() == 1
}

/// Coefficient of static friction of the contacts; `None` if no contact is possible.
pub(super) fn contact_static_friction(scene: &Scene) -> Option<f64> {
    let hand = &scene.hand;
    let (has_contacts, law) = match &scene.mechanism {
        Some(mechanism) => (!mechanism.contacts.is_empty(), mechanism.contacts.first().map(|pair| pair.law)),
        None => (hand.object.is_some(), hand.law(HandContact::Finger(Side::Right, FingerContact::Proximal))),
    };
    has_contacts.then(|| law.and_then(|law| law.friction).map_or(0.0, |friction| friction.mu_static))
}
