//! The runs that a check compares.

use super::finer_stepping;
use super::path::{Keep, POINTS, Path, angles, centres};
use crate::analytic::discs::moving_discs;
use crate::scene::{BodiesScene, DiscMotion, Engine, Integrator, Method, Response, Scene, Words, scaled};
use crate::trace::bodies::{BodiesOutcome, BodiesRunError, run_bodies};
use crate::trace::{self, Model, Outcome, RunError};

/// Part of a run's tolerance at which it is checked, and the finest one that other methods are asked for.
const FINER: f64 = 1e-2;
const FINEST: f64 = 1e-9;

/// How a scene is run for a check.
#[derive(Clone, Copy)]
pub struct Way<'a> {
    /// By the other family of methods, more exactly.
    pub finer: bool,
    pub push: f64,
    /// Steps it may take at most.
    pub budget: u64,
    pub go_on: &'a dyn Fn() -> bool,
}

/// A scene whose motor is stronger by a part of its torque.
pub fn pushed(scene: &Scene, by: f64) -> Scene {
    Scene { actuation: scaled(&scene.actuation, 1.0 + by), ..scene.clone() }
}

/// A scene whose discs start faster, and fall harder, by a part of what they do.
pub fn pushed_bodies(scene: &BodiesScene, by: f64) -> BodiesScene {
    let (mut scene, factor) = (scene.clone(), 1.0 + by);
    scene.gravity_m_s2 = scene.gravity_m_s2.map(|g| g * factor);
    for disc in &mut scene.discs {
        if let DiscMotion::Driven { velocity_m_s, spin_rad_s, .. } | DiscMotion::Free { velocity_m_s, spin_rad_s, .. } =
            &mut disc.motion
        {
            *velocity_m_s = velocity_m_s.map(|v| v * factor);
            *spin_rad_s *= factor;
        }
    }
    scene
}

/// A scene that can be checked.
pub trait Subject {
    fn run(&self, model: Model, way: &Way<'_>) -> Path;

    /// Whether both models answer contact by the same laws, and the analytic one takes the scene.
    fn is_comparable(&self) -> bool;

    /// What a run is held to, in words.
    fn words(&self, judge: Model) -> String;
}

/// The other family of methods at a finer tolerance.
fn other(own: &Integrator) -> Integrator {
    let method = match own.method {
        Method::Rodas5p => Method::RadauIIa5,
        Method::RadauIIa5 => Method::Rodas5p,
    };
    Integrator { method, ..own.with_rtol((FINER * own.rtol).max(FINEST)) }
}

fn integrator(own: &Integrator, way: &Way<'_>) -> Integrator {
    let mut used = if way.finer { other(own) } else { *own };
    used.max_steps = way.budget.min(used.max_steps);
    used
}

fn engine(own: &Engine, way: &Way<'_>) -> Engine {
    let mut used = *own;
    if way.finer {
        used.stepping = finer_stepping(own.stepping);
    }
    used.max_steps = way.budget.min(used.max_steps);
    used
}

fn words(integrator_used: &Integrator, judge: Model) -> String {
    match judge {
        Model::Analytic => {
            let used = other(integrator_used);
            format!("the analytic model, {} (rtol {:.0e})", used.method.word(), used.rtol)
        }
        Model::Engine => "the engine with finer steps".to_string(),
    }
}

impl Subject for Scene {
    fn run(&self, model: Model, way: &Way<'_>) -> Path {
        let mut scene = pushed(self, way.push);
        scene.integrator = integrator(&self.integrator, way);
        scene.engine = engine(&self.engine, way);
        scene.log.numeric_hz = POINTS / scene.duration_s;
        let mut keep = Keep::new(scene.duration_s, way.go_on);
        let (outcome, failure) = match trace::run(model, &scene, &mut keep) {
            Ok(outcome) => (outcome, None),
            Err(RunError::Simulation { failure, so_far }) => (*so_far, Some(failure.reason)),
            // It takes whatever comes.
            Err(RunError::Sink(_)) => (Outcome::default(), None),
        };
        Path {
            last: angles(&outcome.last, keep.points.last()),
            points: keep.points,
            first_s: outcome.sites.iter().take(2).map(|site| site.first_s).collect(),
            normal_n: vec![outcome.last.proximal.normal_n, outcome.last.distal.normal_n],
            end_s: outcome.last.time_s,
            failure,
            steps: outcome.work.steps,
        }
    }

    fn is_comparable(&self) -> bool {
        self.engine.response == Response::Laws
    }

    fn words(&self, judge: Model) -> String {
        words(&self.integrator, judge)
    }
}

impl Subject for BodiesScene {
    fn run(&self, model: Model, way: &Way<'_>) -> Path {
        let mut scene = pushed_bodies(self, way.push);
        scene.integrator = integrator(&self.integrator, way);
        scene.engine = engine(&self.engine, way);
        scene.log.numeric_hz = POINTS / scene.duration_s;
        let mut keep = Keep::new(scene.duration_s, way.go_on);
        let (outcome, failure) = match run_bodies(model, &scene, &mut keep) {
            Ok(outcome) => (outcome, None),
            Err(BodiesRunError::Simulation { failure, so_far }) => (*so_far, Some(failure.reason)),
            Err(BodiesRunError::Sink(_)) => (BodiesOutcome::default(), None),
        };
        Path {
            points: keep.points,
            last: centres(&outcome.last),
            first_s: outcome.pairs.iter().map(|pair| pair.first_s).collect(),
            normal_n: outcome.last.contacts.iter().map(|contact| contact.normal_n).collect(),
            end_s: outcome.last.time_s,
            failure,
            steps: outcome.work.steps,
        }
    }

    fn is_comparable(&self) -> bool {
        self.engine.response == Response::Laws && moving_discs(self).is_ok()
    }

    fn words(&self, judge: Model) -> String {
        words(&self.integrator, judge)
    }
}
