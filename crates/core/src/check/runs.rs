//! The runs that a check compares.

use super::path::{GRID_INTERVALS, Path, PathRecorder, coordinates};
use super::scale::units;
use crate::analytic::multibody::count_moving_discs;
use crate::criteria::Rebounds;
use crate::invariants::EnergyAudit;
use crate::scene::keywords::SceneKind;
use crate::scene::{DiscMotion, Integrator, Keyword, Method, Scene, Stepping, System, scaled};
use crate::shape::max_radius;
use crate::trace::{self, Layout, Model, Outcome, RunError, Sink};

/// Tolerance of the reference, as a fraction of the run's tolerance.
const TOLERANCE_FACTOR: f64 = 1e-2;
/// Smallest tolerance of the reference.
const MIN_TOLERANCE: f64 = 1e-9;
/// Duration of the reference relative to the end of a run that ended early.
const DURATION_FACTOR: f64 = 1.25;

/// Options of one run of a check.
#[derive(Clone, Copy)]
pub struct RunOptions<'a> {
    /// Whether to use the reference settings: another method, or smaller steps.
    pub finer: bool,
    /// Relative change of the actuation.
    pub perturbation: f64,
    /// Duration over which the path is sampled.
    pub span_s: f64,
    /// Whether energies are recorded along the path.
    pub energies: bool,
    /// Largest number of steps.
    pub max_steps: u64,
    pub keep_running: &'a dyn Fn() -> bool,
}

/// Increases the actuation of a scene by the relative amount `relative_change`. In a gripper the left motor torque
/// increases by half of it only, so that the fingers differ. With a differential, its input torque increases and the
/// object moves to the right by that part of its radius. Discs without fingers start faster, and gravity increases.
pub fn perturbed(scene: &Scene, relative_change: f64) -> Scene {
    let mut scene = scene.clone();
    let System { fingers, differential, discs, gravity_m_s2, .. } = &mut scene.system;
    for (finger, part) in fingers.iter_mut().zip([relative_change, 0.5 * relative_change]) {
        finger.motor.actuation = scaled(&finger.motor.actuation, 1.0 + part);
    }
    if let Some(differential) = differential {
        differential.motor.actuation = scaled(&differential.motor.actuation, 1.0 + relative_change);
        for object in &mut *discs {
            object.centre_m[0] += relative_change * max_radius(&object.shape);
        }
    }
    if fingers.is_empty() {
        let factor = 1.0 + relative_change;
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

/// Returns the other family of methods at a smaller tolerance.
fn other_method(integrator: &Integrator) -> Integrator {
    let method = match integrator.method {
        Method::Rodas5p => Method::RadauIIa5,
        Method::RadauIIa5 => Method::Rodas5p,
    };
    Integrator { method, ..integrator.with_rtol((TOLERANCE_FACTOR * integrator.rtol).max(MIN_TOLERANCE)) }
}

/// Name of the reference.
pub fn reference_name(scene: &Scene, reference_model: Model) -> String {
    match reference_model {
        Model::Analytic => {
            let integrator = other_method(&scene.integrator);
            format!("the analytic model, {} (rtol {:.0e})", integrator.method.keyword(), integrator.rtol)
        }
        Model::Engine => "the engine with finer steps".to_string(),
    }
}

/// Whether the analytic model takes the scene, and both models use the same contact laws.
pub fn is_comparable(scene: &Scene) -> bool {
    let is_supported = scene.kind() != SceneKind::Bodies || count_moving_discs(&scene.system).is_ok();
    scene.engine.uses_laws() && is_supported
}

/// Returns the scene with the settings of a run of a check.
fn configured_scene(scene: &Scene, options: &RunOptions<'_>) -> Scene {
    let mut configured = perturbed(scene, options.perturbation);
    if options.finer {
        configured.integrator = other_method(&scene.integrator);
        configured.engine.stepping = finer_stepping(scene.engine.stepping, options.span_s);
    }
    for max_steps in [&mut configured.integrator.max_steps, &mut configured.engine.max_steps] {
        *max_steps = options.max_steps.min(*max_steps);
    }
    configured.log.numeric_hz = GRID_INTERVALS / options.span_s;
    configured.duration_s = scene.duration_s.min(DURATION_FACTOR * options.span_s);
    configured
}

/// Runs the scene and returns its path; `sink` receives the samples and events as well.
pub fn run(scene: &Scene, model: Model, options: &RunOptions<'_>, sink: &mut dyn Sink) -> Path {
    let mut recorder = PathRecorder {
        interval_s: options.span_s / GRID_INTERVALS,
        path: Path {
            audit: options.energies.then(|| EnergyAudit::new(model, scene)),
            units: units(&scene.system),
            ..Path::default()
        },
        rebounds: (scene.kind() == SceneKind::Bodies).then(|| Rebounds::for_system(&scene.system)),
        sink,
        keep_running: options.keep_running,
    };
    let (outcome, failure) = match trace::run(model, &configured_scene(scene, options), &mut recorder) {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure.reason)),
        // The recorder never fails. If the other sink fails, its caller handles the error.
        Err(RunError::Sink(_)) => (Outcome::default(), None),
    };
    let surfaces: Vec<usize> = Layout::from_system(&scene.system).surfaces().collect();
    let contacts = surfaces.iter().filter_map(|index| outcome.contacts.get(*index));
    let forces = surfaces.iter().filter_map(|index| outcome.last.contacts.get(*index));
    Path {
        last: coordinates(&outcome.last, recorder.path.points.last()),
        energy: outcome.last.energy,
        rebounds: recorder.rebounds.iter().flat_map(Rebounds::pairs).copied().collect(),
        loop_gap_m: outcome.loop_gap_m,
        ejected: outcome.ejected_s.is_some(),
        first_s: contacts.map(|contact| contact.first_s).collect(),
        normal_n: forces.map(|contact| contact.normal_n).collect(),
        end_s: outcome.last.time_s,
        failure,
        steps: outcome.work.steps,
        events: outcome.work.events,
        ..recorder.path
    }
}

/// Returns a quarter of a fixed step; or a tenth of the tolerance and at most a quarter of the step limit, because free
/// flight has no error that a tolerance would control.
fn finer_stepping(stepping: Stepping, span_s: f64) -> Stepping {
    match stepping {
        Stepping::Fixed { step_s } => Stepping::Fixed { step_s: 0.25 * step_s },
        Stepping::Adaptive { tolerance_m, max_step_s } => {
            Stepping::Adaptive { tolerance_m: 0.1 * tolerance_m, max_step_s: 0.25 * max_step_s.min(span_s) }
        }
    }
}
