//! A scene of either kind, as whoever runs it needs it.

use super::Layout;
use super::grid::Span;
use crate::scene::{AnyScene, BodiesScene, Engine, Integrator, LogRates, Response, Scene};

/// What is simulated: a finger, or discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Simulated<'a> {
    Finger(&'a Scene),
    Discs(&'a BodiesScene),
}

/// How a scene of either kind is run and logged, to be changed.
#[derive(Debug)]
pub struct Numerics<'a> {
    pub duration_s: &'a mut f64,
    pub log: &'a mut LogRates,
    pub integrator: &'a mut Integrator,
    pub engine: &'a mut Engine,
}

impl<'a> From<&'a mut Scene> for Numerics<'a> {
    fn from(scene: &'a mut Scene) -> Self {
        let Scene { duration_s, log, integrator, engine, .. } = scene;
        Numerics { duration_s, log, integrator, engine }
    }
}

impl<'a> From<&'a mut BodiesScene> for Numerics<'a> {
    fn from(scene: &'a mut BodiesScene) -> Self {
        let BodiesScene { duration_s, log, integrator, engine, .. } = scene;
        Numerics { duration_s, log, integrator, engine }
    }
}

impl<'a> From<&'a mut AnyScene> for Numerics<'a> {
    fn from(scene: &'a mut AnyScene) -> Self {
        match scene {
            AnyScene::Finger(scene) => scene.as_mut().into(),
            AnyScene::Bodies(scene) => scene.as_mut().into(),
        }
    }
}

impl<'a> From<&'a Scene> for Simulated<'a> {
    fn from(scene: &'a Scene) -> Self {
        Simulated::Finger(scene)
    }
}

impl<'a> From<&'a BodiesScene> for Simulated<'a> {
    fn from(scene: &'a BodiesScene) -> Self {
        Simulated::Discs(scene)
    }
}

impl<'a> From<&'a Box<Scene>> for Simulated<'a> {
    fn from(scene: &'a Box<Scene>) -> Self {
        Simulated::Finger(scene)
    }
}

impl<'a> From<&'a Box<BodiesScene>> for Simulated<'a> {
    fn from(scene: &'a Box<BodiesScene>) -> Self {
        Simulated::Discs(scene)
    }
}

impl<'a> From<&'a AnyScene> for Simulated<'a> {
    fn from(scene: &'a AnyScene) -> Self {
        match scene {
            AnyScene::Finger(scene) => Simulated::Finger(scene),
            AnyScene::Bodies(scene) => Simulated::Discs(scene),
        }
    }
}

impl<'a> Simulated<'a> {
    /// The scene itself.
    pub fn to_owned(self) -> AnyScene {
        match self {
            Simulated::Finger(scene) => AnyScene::Finger(Box::new(scene.clone())),
            Simulated::Discs(scene) => AnyScene::Bodies(Box::new(scene.clone())),
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
        }
    }

    pub fn name(self) -> &'a str {
        match self {
            Simulated::Finger(scene) => &scene.name,
            Simulated::Discs(scene) => &scene.name,
        }
    }

    /// What the scene is for, in the user's words.
    pub fn description(self) -> &'a str {
        match self {
            Simulated::Finger(scene) => &scene.description,
            Simulated::Discs(scene) => &scene.description,
        }
    }

    pub fn duration_s(self) -> f64 {
        match self {
            Simulated::Finger(scene) => scene.duration_s,
            Simulated::Discs(scene) => scene.duration_s,
        }
    }

    pub fn log(self) -> &'a LogRates {
        match self {
            Simulated::Finger(scene) => &scene.log,
            Simulated::Discs(scene) => &scene.log,
        }
    }

    pub fn integrator(self) -> &'a Integrator {
        match self {
            Simulated::Finger(scene) => &scene.integrator,
            Simulated::Discs(scene) => &scene.integrator,
        }
    }

    pub fn engine(self) -> &'a Engine {
        match self {
            Simulated::Finger(scene) => &scene.engine,
            Simulated::Discs(scene) => &scene.engine,
        }
    }

    /// Whether the engine answers contact by the scene's laws, as the analytic model does.
    pub fn uses_laws(self) -> bool {
        self.engine().response == Response::Laws
    }

    pub(super) fn span(self) -> Span {
        Span { end_s: self.duration_s(), numeric_hz: self.log().numeric_hz }
    }
}
