//! The runs that a check compares.

use super::path::{Heard, Keep, POINTS, Path, coordinates};
use super::scale::units;
use crate::analytic::multibody::of_discs;
use crate::criteria::Rebounds;
use crate::invariants::EnergyAudit;
use crate::scene::words::SceneKind;
use crate::scene::{DiscMotion, Engine, Integrator, Method, Scene, Stepping, System, Words, scaled};
use crate::shape::reach;
use crate::trace::{self, Layout, Model, Outcome, RunError, Sink};

/// Part of a run's tolerance at which it is checked, and the finest one that other methods are asked for.
const FINER: f64 = 1e-2;
const FINEST: f64 = 1e-9;
/// How far runs are made of one that ended early: beyond that end by a quarter of its length.
const BEYOND: f64 = 1.25;

/// How a scene is run for a check.
#[derive(Clone, Copy)]
pub struct Way<'a> {
    /// By the other family of methods, more exactly.
    pub finer: bool,
    pub push: f64,
    /// Length of time over which the path is sampled.
    pub span_s: f64,
    /// Whether energies are recorded along the path.
    pub energies: bool,
    /// Steps it may take at most.
    pub budget: u64,
    pub go_on: &'a dyn Fn() -> bool,
}

/// What a scene starts with, changed by a small part `by` of itself: the motor of a finger is stronger; of a gripper the right one, and
/// the left one by half of that, so that both fingers part ways; with a differential its input, and the object is that part of its
/// radius further to the right besides; discs without fingers start faster and fall harder.
pub fn pushed(scene: &Scene, by: f64) -> Scene {
    let mut scene = scene.clone();
    let System { fingers, differential, discs, gravity_m_s2, .. } = &mut scene.system;
    for (finger, part) in fingers.iter_mut().zip([by, 0.5 * by]) {
        finger.motor.actuation = scaled(&finger.motor.actuation, 1.0 + part);
    }
    if let Some(differential) = differential {
        differential.motor.actuation = scaled(&differential.motor.actuation, 1.0 + by);
        for object in &mut *discs {
            object.centre_m[0] += by * reach(&object.shape);
        }
    }
    if fingers.is_empty() {
        let factor = 1.0 + by;
        *gravity_m_s2 = gravity_m_s2.map(|g| g * factor);
        for disc in discs {
            if let DiscMotion::Driven { velocity_m_s, spin_rad_s, .. }
            | DiscMotion::Free { velocity_m_s, spin_rad_s, .. } = &mut disc.motion
            {
                *velocity_m_s = velocity_m_s.map(|v| v * factor);
                *spin_rad_s *= factor;
            }
        }
    }
    scene
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
        used.stepping = finer_stepping(own.stepping, way.span_s);
    }
    used.max_steps = way.budget.min(used.max_steps);
    used
}

/// What a run is held to, in words.
pub fn words(scene: &Scene, judge: Model) -> String {
    match judge {
        Model::Analytic => {
            let used = other(&scene.integrator);
            format!("the analytic model, {} (rtol {:.0e})", used.method.word(), used.rtol)
        }
        Model::Engine => "the engine with finer steps".to_string(),
    }
}

/// Whether both models answer contact by the same laws, and the analytic one takes the scene.
pub fn is_comparable(scene: &Scene) -> bool {
    let taken = scene.kind() != SceneKind::Bodies || of_discs(&scene.system).is_ok();
    scene.engine.uses_laws() && taken
}

/// The scene as it is run for a check.
fn changed(scene: &Scene, way: &Way<'_>) -> Scene {
    let mut changed = pushed(scene, way.push);
    changed.integrator = integrator(&scene.integrator, way);
    changed.engine = engine(&scene.engine, way);
    changed.log.numeric_hz = POINTS / way.span_s;
    changed.duration_s = scene.duration_s.min(BEYOND * way.span_s);
    changed
}

/// Runs the scene, and keeps its path; `heard` hears it as well.
pub fn run(scene: &Scene, model: Model, way: &Way<'_>, heard: &mut dyn Sink) -> Path {
    let layout = Layout::of(&scene.system);
    let surfaces: Vec<usize> = layout.surfaces().collect();
    let is_discs = scene.kind() == SceneKind::Bodies;
    let rebounds = is_discs.then(|| Rebounds::of(&scene.system));
    let audit = way.energies.then(|| EnergyAudit::new(model, scene));
    let mut keep = Keep::new(way.span_s, rebounds, audit, way.go_on);
    let mut heard = Heard { keep: &mut keep, sink: heard };
    let (outcome, failure) = match trace::run(model, &changed(scene, way), &mut heard) {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, so_far }) => (*so_far, Some(failure.reason)),
        // A path takes whatever comes; who cannot hear it to its end has not.
        Err(RunError::Sink(_)) => (Outcome::default(), None),
    };
    let contacts = surfaces.iter().filter_map(|index| outcome.contacts.get(*index));
    let forces = surfaces.iter().filter_map(|index| outcome.last.contacts.get(*index));
    Path {
        last: coordinates(&outcome.last, keep.points.last()),
        points: keep.points,
        energies: keep.energies,
        energy: outcome.last.energy,
        rebounds: keep.rebounds.iter().flat_map(Rebounds::pairs).copied().collect(),
        speed_m_s: keep.speed_m_s,
        loop_gap_m: outcome.loop_gap_m,
        audit: keep.audit,
        ejected: outcome.ejected_s.is_some(),
        first_s: contacts.map(|contact| contact.first_s).collect(),
        normal_n: forces.map(|contact| contact.normal_n).collect(),
        end_s: outcome.last.time_s,
        failure,
        units: units(&scene.system),
        steps: outcome.work.steps,
        events: outcome.work.events,
    }
}

/// A step a quarter as long, or a tolerance a tenth as large and steps of at most a quarter: what flies straight has no error that a
/// tolerance would see.
fn finer_stepping(stepping: Stepping, span_s: f64) -> Stepping {
    match stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: 0.25 * step_s },
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            Stepping::Adaptive { tolerance_m: 0.1 * tolerance_m, max_step_s: 0.25 * max_step_s.min(span_s) }
        }
    }
}
