//! What a validation does to a scene: settings that it changes, members of its ensemble, bounds.

use super::ensemble::TORQUE_STEP;
use super::verdict::{verdicts_of_discs, verdicts_of_gripper};
use super::{Differences, Recording, Verdict, ensemble, verdicts};
use crate::check::{LENGTH_M, pushed_gripper};
use crate::invariants::{Finding, Invariants};
use crate::scene::{AnyScene, BodiesScene, GripperScene, Preset, Scene, Side};
use crate::trace::{Model, Numerics, Simulated, Sink};

/// Samples that the grid of a reference has at most: five references of 500 bytes a sample stay below 250 MB.
const MOST_SAMPLES: f64 = 1e5;
/// Finest grid; beyond, interpolation is exact to rounding.
const FINEST_HZ: f64 = 1e6;

/// A scene of one kind, or of any, whose settings can be changed.
pub trait Subject: Clone {
    fn simulated(&self) -> Simulated<'_>;
    fn numerics(&mut self) -> Numerics<'_>;

    /// The scene as far as it is run for a validation: the time after `until` of a scene of discs is not run at all, so that
    /// every figure of a run, its peaks and impulses too, is of what is compared.
    fn compared(&self) -> Self {
        let scene = self.simulated();
        let end_s = match scene {
            Simulated::Finger(_) | Simulated::Gripper(_) => scene.duration_s(),
            Simulated::Discs(_) => until_s(scene).min(scene.duration_s()),
        };
        with(self, |numerics| *numerics.duration_s = end_s)
    }

    /// Judges the differences of the engine at the scene's own settings.
    fn judge(&self, found: &Differences) -> Verdict {
        match self.simulated() {
            Simulated::Finger(scene) => verdicts(found, &scene.bounds),
            Simulated::Discs(scene) => verdicts_of_discs(found, &scene.bounds),
            Simulated::Gripper(scene) => verdicts_of_gripper(found, &scene.bounds),
        }
    }

    /// How near a kept run came to breaking each invariant.
    fn invariants(&self, model: Model, run: &Recording) -> Vec<Finding> {
        let mut invariants = Invariants::new(model, self.simulated());
        for sample in &run.samples {
            invariants.sample(sample).expect("measuring writes nothing");
        }
        invariants.findings(run.outcome.loop_gap_m)
    }
}

macro_rules! subjects {
    ($($scene:ident)*) => {$(
        impl Subject for $scene {
            fn simulated(&self) -> Simulated<'_> {
                self.into()
            }

            fn numerics(&mut self) -> Numerics<'_> {
                self.into()
            }
        }
    )*};
}

subjects!(Scene BodiesScene GripperScene AnyScene);

/// The scene with something changed.
pub(super) fn with<S: Subject>(scene: &S, change: impl FnOnce(Numerics<'_>)) -> S {
    let mut changed = scene.clone();
    change(changed.numerics());
    changed
}

/// The scene as the reference runs it: the tightest settings, on a dense grid.
pub fn reference<S: Subject>(scene: &S) -> S {
    let tight = |numerics: Numerics<'_>| *numerics.integrator = numerics.integrator.with_preset(Preset::Reference);
    sampled(Model::Analytic, &with(scene, tight))
}

/// The scene with the samples that a comparison needs. The analytic model is exact between its steps, so a dense grid
/// is read off; of the engine every step is taken, and nothing that is interpolated.
pub fn sampled<S: Subject>(model: Model, scene: &S) -> S {
    match model {
        Model::Analytic => with(scene, |Numerics { duration_s, log, .. }| {
            let dense_hz = (MOST_SAMPLES / *duration_s).min(FINEST_HZ);
            log.numeric_hz = dense_hz.max(log.numeric_hz);
        }),
        Model::Engine => steps_only(scene),
    }
}

/// The scene with a sample at every step and at no other time.
pub fn steps_only<S: Subject>(scene: &S) -> S {
    with(scene, |Numerics { duration_s, log, .. }| log.numeric_hz = 1.0 / *duration_s)
}

/// The scene as the member `index` of the ensemble has it.
pub(super) fn member(scene: &AnyScene, index: usize) -> AnyScene {
    match scene {
        AnyScene::Finger(scene) => AnyScene::Finger(Box::new(ensemble::member(scene, index))),
        AnyScene::Bodies(scene) => AnyScene::Bodies(Box::new(ensemble::member_of_discs(scene, index))),
        AnyScene::Gripper(scene) => AnyScene::Gripper(Box::new(pushed_gripper(scene, index as f64 * TORQUE_STEP))),
    }
}

/// The time up to which trajectories are compared.
pub fn until_s(scene: Simulated<'_>) -> f64 {
    match scene {
        Simulated::Finger(scene) => scene.bounds.until_s,
        Simulated::Discs(scene) => scene.bounds.until_s,
        Simulated::Gripper(scene) => scene.bounds.until_s,
    }
}

/// What the engine may be off by along the way, in the unit of the errors of a check.
pub fn path_bound(scene: Simulated<'_>) -> f64 {
    match scene {
        Simulated::Finger(scene) => scene.bounds.angle_rad,
        Simulated::Discs(scene) => scene.bounds.position_m,
        Simulated::Gripper(scene) => scene.bounds.angle_rad.min(scene.bounds.position_m / LENGTH_M),
    }
}

/// Whether there is one finger, of whose joints coordinates can be made.
pub(super) fn is_jointed(scene: Simulated<'_>) -> bool {
    matches!(scene, Simulated::Finger(_))
}

/// Static friction of its contacts; `None` if nothing can touch.
pub(super) fn touching_friction(scene: Simulated<'_>) -> Option<f64> {
    let (touches, law) = match scene {
        Simulated::Finger(scene) => (scene.object.is_some(), scene.contact.proximal.friction),
        Simulated::Discs(scene) => (!scene.pairs().is_empty(), scene.contact.friction),
        Simulated::Gripper(scene) => (true, scene.finger(Side::Right).contact.proximal.friction),
    };
    touches.then(|| law.map_or(0.0, |law| law.mu_static))
}
