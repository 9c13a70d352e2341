//! What a validation does to a scene: settings that it changes, and bounds.

use super::Recording;
use crate::check::{LENGTH_M, length_m};
use crate::gripper::Site;
use crate::invariants::{Finding, Invariants};
use crate::scene::words::SceneKind;
use crate::scene::{Place, Preset, Scene, Side};
use crate::trace::{Model, Sink};

/// Samples that the grid of a reference has at most: five references of 500 bytes a sample stay below 250 MB.
const MOST_SAMPLES: f64 = 1e5;
/// Finest grid; beyond, interpolation is exact to rounding.
const FINEST_HZ: f64 = 1e6;

/// The scene as far as it is run for a validation: the time after `until` of a scene of discs is not run at all, so that
/// every figure of a run, its peaks and impulses too, is of what is compared.
pub fn compared(scene: &Scene) -> Scene {
    with(scene, |scene| {
        if scene.kind() == SceneKind::Bodies {
            scene.duration_s = scene.bounds.until_s.min(scene.duration_s);
        }
    })
}

/// How near a kept run came to breaking each invariant.
pub fn invariants(scene: &Scene, model: Model, run: &Recording) -> Vec<Finding> {
    let mut invariants = Invariants::new(model, scene);
    for sample in &run.samples {
        invariants.sample(sample).expect("measuring writes nothing");
    }
    invariants.findings(run.outcome.loop_gap_m)
}

/// The scene with something changed.
pub(super) fn with(scene: &Scene, change: impl FnOnce(&mut Scene)) -> Scene {
    let mut changed = scene.clone();
    change(&mut changed);
    changed
}

/// The scene as the reference runs it: the tightest settings, on a dense grid.
pub fn reference(scene: &Scene) -> Scene {
    sampled(Model::Analytic, &with(scene, |scene| scene.integrate_by(Preset::Reference)))
}

/// The scene with the samples that a comparison needs. The analytic model is exact between its steps, so a dense grid
/// is read off; of the engine every step is taken, and nothing that is interpolated.
pub fn sampled(model: Model, scene: &Scene) -> Scene {
    match model {
        Model::Analytic => with(scene, |scene| {
            let dense_hz = (MOST_SAMPLES / scene.duration_s).min(FINEST_HZ);
            scene.log.numeric_hz = dense_hz.max(scene.log.numeric_hz);
        }),
        Model::Engine => steps_only(scene),
    }
}

/// The scene with a sample at every step and at no other time.
pub fn steps_only(scene: &Scene) -> Scene {
    with(scene, |scene| scene.log.numeric_hz = 1.0 / scene.duration_s)
}

/// What the engine may be off by along the way, in the unit of the errors of a check.
pub fn path_bound(scene: &Scene) -> f64 {
    let bounds = &scene.bounds;
    match scene.kind() {
        SceneKind::Finger => bounds.angle_rad,
        SceneKind::Bodies => bounds.position_m,
        SceneKind::Gripper => bounds.angle_rad.min(bounds.position_m / LENGTH_M),
    }
}

/// The same of the reference, whose check measures the object of a gripper by its radius.
pub(super) fn reference_bound(scene: &Scene) -> f64 {
    match scene.kind() {
        SceneKind::Gripper => scene.bounds.angle_rad.min(scene.bounds.position_m / length_m(&scene.system)),
        _ => path_bound(scene),
    }
}

/// Whether there is one finger, of whose joints coordinates can be made.
pub(super) fn is_jointed(scene: &Scene) -> bool {
    scene.kind() == SceneKind::Finger
}

/// Static friction of its contacts; `None` if nothing can touch.
pub(super) fn touching_friction(scene: &Scene) -> Option<f64> {
    let system = &scene.system;
    let (touches, law) = match system.fingers.is_empty() {
        true => (!system.pairs().is_empty(), system.between_discs),
        false => (system.object().is_some(), system.law(Place::Finger(Side::Right, Site::Proximal))),
    };
    touches.then(|| law.and_then(|law| law.friction).map_or(0.0, |law| law.mu_static))
}
