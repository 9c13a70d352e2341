//! A scene of any kind, as whoever runs it needs it.

use super::Layout;
use super::grid::Span;
use crate::scene::words::SceneKind;
use crate::scene::{AnyScene, BodiesScene, Engine, GripperScene, Integrator, LogRates, Preset, Response, Scene};

/// What is simulated: a finger, discs, or a gripper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Simulated<'a> {
    Finger(&'a Scene),
    Discs(&'a BodiesScene),
    Gripper(&'a GripperScene),
}

/// How a scene of any kind is run and logged, to be changed.
#[derive(Debug)]
pub struct Numerics<'a> {
    pub duration_s: &'a mut f64,
    pub log: &'a mut LogRates,
    pub integrator: &'a mut Integrator,
    pub engine: &'a mut Engine,
    kind: SceneKind,
}

impl Numerics<'_> {
    /// Integrates as a preset says for this kind of scene, within the same step budget.
    pub fn integrate_by(&mut self, preset: Preset) {
        let max_steps = self.integrator.max_steps;
        *self.integrator = match preset {
            Preset::Engineering => Integrator { max_steps, ..Integrator::everyday(self.kind) },
            Preset::Reference => self.integrator.with_preset(preset),
        };
    }
}

/// What all kinds of scene have.
macro_rules! scenes {
    ($($scene:ident as $variant:ident of $kind:ident,)*) => {$(
        impl<'a> From<&'a mut $scene> for Numerics<'a> {
            fn from(scene: &'a mut $scene) -> Self {
                let $scene { duration_s, log, integrator, engine, .. } = scene;
                Numerics { duration_s, log, integrator, engine, kind: SceneKind::$kind }
            }
        }

        impl<'a> From<&'a $scene> for Simulated<'a> {
            fn from(scene: &'a $scene) -> Self {
                Simulated::$variant(scene)
            }
        }

        impl<'a> From<&'a Box<$scene>> for Simulated<'a> {
            fn from(scene: &'a Box<$scene>) -> Self {
                Simulated::$variant(scene)
            }
        }
    )*};
}

scenes!(Scene as Finger of Finger, BodiesScene as Discs of Bodies, GripperScene as Gripper of Gripper,);

impl<'a> From<&'a mut AnyScene> for Numerics<'a> {
    fn from(scene: &'a mut AnyScene) -> Self {
        match scene {
            AnyScene::Finger(scene) => scene.as_mut().into(),
            AnyScene::Bodies(scene) => scene.as_mut().into(),
            AnyScene::Gripper(scene) => scene.as_mut().into(),
        }
    }
}

impl<'a> From<&'a AnyScene> for Simulated<'a> {
    fn from(scene: &'a AnyScene) -> Self {
        match scene {
            AnyScene::Finger(scene) => Simulated::Finger(scene),
            AnyScene::Bodies(scene) => Simulated::Discs(scene),
            AnyScene::Gripper(scene) => Simulated::Gripper(scene),
        }
    }
}

impl<'a> Simulated<'a> {
    /// The scene itself.
    pub fn to_owned(self) -> AnyScene {
        match self {
            Simulated::Finger(scene) => AnyScene::Finger(Box::new(scene.clone())),
            Simulated::Discs(scene) => AnyScene::Bodies(Box::new(scene.clone())),
            Simulated::Gripper(scene) => AnyScene::Gripper(Box::new(scene.clone())),
        }
    }

    /// Of which kind it is.
    pub fn kind(self) -> SceneKind {
        match self {
            Simulated::Finger(_) => SceneKind::Finger,
            Simulated::Discs(_) => SceneKind::Bodies,
            Simulated::Gripper(_) => SceneKind::Gripper,
        }
    }

    /// What its samples consist of.
    pub fn layout(self) -> Layout {
        match self {
            Simulated::Finger(_) => Layout::finger(),
            Simulated::Discs(scene) => {
                let pairs = scene.pairs().into_iter().map(|pair| scene.pair_name(pair)).collect();
                Layout::discs(scene.discs.iter().map(|disc| disc.name.clone()).collect(), pairs)
            }
            Simulated::Gripper(_) => Layout::gripper(),
        }
    }

    pub fn name(self) -> &'a str {
        match self {
            Simulated::Finger(scene) => &scene.name,
            Simulated::Discs(scene) => &scene.name,
            Simulated::Gripper(scene) => &scene.name,
        }
    }

    /// What the scene is for, in the user's words.
    pub fn description(self) -> &'a str {
        match self {
            Simulated::Finger(scene) => &scene.description,
            Simulated::Discs(scene) => &scene.description,
            Simulated::Gripper(scene) => &scene.description,
        }
    }

    pub fn duration_s(self) -> f64 {
        match self {
            Simulated::Finger(scene) => scene.duration_s,
            Simulated::Discs(scene) => scene.duration_s,
            Simulated::Gripper(scene) => scene.duration_s,
        }
    }

    pub fn log(self) -> &'a LogRates {
        match self {
            Simulated::Finger(scene) => &scene.log,
            Simulated::Discs(scene) => &scene.log,
            Simulated::Gripper(scene) => &scene.log,
        }
    }

    pub fn integrator(self) -> &'a Integrator {
        match self {
            Simulated::Finger(scene) => &scene.integrator,
            Simulated::Discs(scene) => &scene.integrator,
            Simulated::Gripper(scene) => &scene.integrator,
        }
    }

    pub fn engine(self) -> &'a Engine {
        match self {
            Simulated::Finger(scene) => &scene.engine,
            Simulated::Discs(scene) => &scene.engine,
            Simulated::Gripper(scene) => &scene.engine,
        }
    }

    /// Whether the engine answers contact by the scene's laws, as the analytic model does.
    pub fn uses_laws(self) -> bool {
        self.engine().response == Response::Laws
    }

    pub(super) fn span(self) -> Span {
        // What a gripper carries is at rest in the hand for most of a run.
        let thins = matches!(self, Self::Gripper(_));
        Span { end_s: self.duration_s(), numeric_hz: self.log().numeric_hz, thins }
    }
}
