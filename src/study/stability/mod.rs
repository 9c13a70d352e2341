//! Convergence map of the engine model over step size, contact stiffness and contact damping.
//!
//! **Cells.** Each cell is a run of the finger scene with the engine at a fixed step, with the stiffness k and the
//! largest damping c_max of both object contacts multiplied by one factor each. The joint limit keeps its law. Each
//! pair of factors is compared with its own *reference*, the analytic model at
//! [`Preset::Reference`](crate::scene::Preset).
//!
//! | verdict | meaning |
//! |---|---|
//! | failed | the run ended in an error or violated a stability criterion: all numbers are finite; mechanical energy minus the motor's work never rises by more than [`ENERGY_TOLERANCE`] of the reference's throughput above an earlier value; dissipated energy never falls by as much; contacts and joint limit penetrate no deeper than the total energy plus [`ENERGY_TOLERANCE`] allows |
//! | accurate | not failed, and q11, q21, q22 are within the bound of the reference at every step up to `[validate] until` |
//! | inaccurate | not failed, but beyond the bound at some step |
//! | not judged | the reference could not be completed, or the engine's step budget was too small |
//!
//! The throughput is the largest mechanical energy in the reference at any time; the throughput of a failed run would
//! grow with its errors. A run that is too coarse to be accurate may still be stable: a loss of energy is an error, not
//! a failure.
//!
//! Each reference is repeated with the motor torque increased by 1e-9. The change of the angles is the sensitivity of
//! the closing motion. If it exceeds the bound, no step size can be accurate.

mod map;

use std::sync::mpsc::Sender;
use std::time::Instant;

use crate::integrator::{Failure, Reason};
use crate::invariants::{Finding, Invariant, Invariants};
use crate::scene::keywords::SceneKind;
use crate::scene::{Engine, Response, Scene, Stepping};
use crate::study::pool;
use crate::trace::Cancellable;
use crate::trace::{Event, Model, RunError, Sample, Sink, SinkError, run};
use crate::validate::{Comparison, Recording, ensemble_member, record_cancellable, reference_scene, sampled_scene};

pub use map::{Cell, Grid, ReferenceRun, Stability, StudyError, Verdict};

/// Spurious energy relative to the reference's throughput above which a run counts as failed.
pub const ENERGY_TOLERANCE: f64 = 0.1;
/// Default for the largest angle difference of an accurate run, rad.
pub const ACCURACY_RAD: f64 = 1e-3;
/// Invariants whose violation is a failure, in addition to the energy. The others measure accuracy.
const STABILITY_INVARIANTS: [Invariant; 4] =
    [Invariant::Finite, Invariant::Passivity, Invariant::Penetration, Invariant::JointLimit];

/// Common settings of all cells.
struct CellSettings<'a> {
    steps_s: &'a [f64],
    accuracy_rad: f64,
    keep_running: &'a (dyn Fn() -> bool + Sync),
}

/// Computes the map on all cores. `progress` receives the completed and the total number of runs, and the model of the
/// last one.
///
/// # Errors
/// Returns an error if the scene or the grid is not suitable, or `keep_running` returned `false`. Failed runs are part
/// of the map.
pub fn stability(
    scene: &Scene,
    grid: &Grid,
    accuracy_rad: f64,
    progress: &mut dyn FnMut(usize, usize, &str),
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Stability, StudyError> {
    check(scene, grid)?;
    let start = Instant::now();
    let columns = grid.columns();
    let total = columns.len() * (grid.steps_s.len() + 1);
    let settings = CellSettings { steps_s: &grid.steps_s, accuracy_rad, keep_running };
    let mut done = 0;
    progress(done, total, "references");
    let work = |&factors: &_, sender: &_| column(scene, factors, &settings, sender);
    let found = pool::map(0, &columns, work, |model| {
        done += 1;
        progress(done, total, model);
    });
    let found: Option<Vec<(ReferenceRun, Vec<Cell>)>> = found.into_iter().collect();
    let (references, cells): (Vec<_>, Vec<_>) = found.ok_or(StudyError::Stopped { done, total })?.into_iter().unzip();
    let laws = [scene.finger().contact.proximal.normal, scene.finger().contact.distal.normal];
    Ok(Stability {
        scene: scene.name.clone(),
        accuracy_rad,
        duration_s: scene.duration_s,
        until_s: scene.bounds.until_s,
        stiffness_si: laws.map(|law| law.stiffness_n_per_m_e),
        damping_max_n_s_per_m: laws.map(|law| law.damping_max_n_s_per_m),
        grid: grid.clone(),
        references,
        cells: cells.into_iter().flatten().collect(),
        wall_s: start.elapsed().as_secs_f64(),
    })
}

fn check(scene: &Scene, grid: &Grid) -> Result<(), StudyError> {
    if scene.require_kind(SceneKind::Finger)?.object().is_none() {
        return Err(StudyError::NoObject);
    }
    if scene.engine.response != Response::Laws {
        return Err(StudyError::RigidContact);
    }
    if let Some(&step_s) = grid.steps_s.iter().find(|&&step_s| step_s >= scene.duration_s) {
        return Err(StudyError::LongStep { step_s, duration_s: scene.duration_s });
    }
    let max_steps = scene.engine.max_steps.max(Engine::DEFAULT.max_steps);
    if let Some(&step_s) = grid.steps_s.iter().find(|&&step_s| scene.duration_s / step_s > max_steps as f64) {
        return Err(StudyError::ShortStep { step_s, duration_s: scene.duration_s, max_steps });
    }
    for (stiffness, damping) in grid.columns() {
        let contact = scaled(scene, stiffness, damping).finger().contact;
        for law in [contact.proximal.normal, contact.distal.normal] {
            let (k, c) = (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m);
            if !(k.is_finite() && c.is_finite() && k.max(c) > 0.0) {
                return Err(StudyError::InvalidLaw { stiffness, damping, k, c });
            }
        }
    }
    Ok(())
}

/// Returns the scene with contact stiffness and damping multiplied by the factors.
fn scaled(scene: &Scene, stiffness: f64, damping: f64) -> Scene {
    let mut scene = scene.clone();
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= stiffness;
        contact.normal.damping_max_n_s_per_m *= damping;
    }
    scene
}

/// Computes the reference for a pair of factors and the cells compared with it; `None` if interrupted.
fn column(
    scene: &Scene,
    factors: (f64, f64),
    settings: &CellSettings,
    sender: &Sender<&str>,
) -> Option<(ReferenceRun, Vec<Cell>)> {
    let scene = scaled(scene, factors.0, factors.1);
    let (found, recording) = run_reference(&scene, factors, settings)?;
    // A missing receiver does not end the study.
    let _ = sender.send("references");
    let mut cells = Vec::with_capacity(settings.steps_s.len());
    for &step_s in settings.steps_s {
        cells.push(match &recording {
            Some(recording) => cell(&scene, factors, step_s, (&found, recording), settings)?,
            None => unjudged_cell(factors, step_s, "the reference could not be completed"),
        });
        let _ = sender.send("engine");
    }
    Some((found, cells))
}

/// Runs the reference, and repeats it with a slightly larger torque.
fn run_reference(
    scene: &Scene,
    (stiffness, damping): (f64, f64),
    settings: &CellSettings,
) -> Option<(ReferenceRun, Option<Recording>)> {
    let reference = reference_scene(scene);
    let start = Instant::now();
    let recording = record_cancellable(Model::Analytic, &reference, settings.keep_running);
    let wall_s = start.elapsed().as_secs_f64();
    let mut found = ReferenceRun {
        stiffness_factor: stiffness,
        damping_factor: damping,
        steps: 0,
        touchdowns: [0; 2],
        throughput_j: 0.0,
        sensitivity_rad: None,
        wall_s,
        reason: None,
    };
    match recording {
        Ok(recording) => {
            found.steps = recording.outcome.work.steps;
            found.touchdowns = [0, 1].map(|contact| recording.outcome.contacts[contact].touchdowns);
            let mut invariants = Invariants::new(Model::Analytic, &reference);
            for sample in &recording.samples {
                invariants.sample(sample).expect("invariants write no output");
            }
            found.throughput_j = invariants.throughput_j();
            let mut comparison = Comparison::new(&recording, scene.bounds.until_s);
            let perturbed = ensemble_member(&reference, 1);
            match run(
                Model::Analytic,
                &perturbed,
                &mut Cancellable { sink: &mut comparison, keep_running: settings.keep_running },
            ) {
                Ok(outcome) => found.sensitivity_rad = Some(comparison.finish(&outcome).path_max()),
                Err(error) if error.is_stop() => return None,
                Err(_) => {}
            }
            Some((found, Some(recording)))
        }
        Err(error) if error.is_stop() => None,
        Err(error) => {
            found.reason = Some(error.to_string());
            Some((found, None))
        }
    }
}

/// Compares a run with the reference and checks the invariants.
struct CellObserver<'a> {
    comparison: Comparison<'a>,
    invariants: Invariants,
}

impl Sink for CellObserver<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.comparison.sample(sample)?;
        self.invariants.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.comparison.event(event)
    }
}

/// Runs the engine with a fixed step and judges the run; `None` if interrupted.
fn cell(
    scene: &Scene,
    factors: (f64, f64),
    step_s: f64,
    (run_reference, reference): (&ReferenceRun, &Recording),
    settings: &CellSettings,
) -> Option<Cell> {
    let mut scene = sampled_scene(Model::Engine, scene);
    scene.engine.stepping = Stepping::Fixed { step_s };
    let mut observer = CellObserver {
        comparison: Comparison::new(reference, scene.bounds.until_s),
        invariants: Invariants::new(Model::Engine, &scene).with_energy_tolerance(ENERGY_TOLERANCE),
    };
    let start = Instant::now();
    let result =
        run(Model::Engine, &scene, &mut Cancellable { sink: &mut observer, keep_running: settings.keep_running });
    let wall_s = start.elapsed().as_secs_f64();
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. }) => return None,
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure)),
        Err(RunError::Sink(error)) => return Some(unjudged_cell(factors, step_s, &error.to_string())),
    };
    let CellObserver { comparison, invariants } = observer;
    let error_rad = comparison.finish(&outcome).path_max();
    let (created_j, findings) = (invariants.created_j(), invariants.findings(outcome.loop_gap_m));
    let (verdict, reason) = match failure {
        Some(Failure { reason: reason @ (Reason::Budget(_) | Reason::SubstepBudget { .. }), .. }) => {
            (Verdict::NotJudged, Some(reason.to_string()))
        }
        Some(failure) => (Verdict::Failed, Some(failure.to_string())),
        None => match violations(&findings, created_j, ENERGY_TOLERANCE * run_reference.throughput_j) {
            Some(violations) => (Verdict::Failed, Some(violations)),
            None if error_rad <= settings.accuracy_rad => (Verdict::Accurate, None),
            None => (Verdict::Inaccurate, None),
        },
    };
    let relative = |energy_j: f64| if energy_j > 0.0 { energy_j / run_reference.throughput_j } else { 0.0 };
    Some(Cell {
        verdict,
        angle_error_rad: Some(error_rad).filter(|error| error.is_finite()),
        energy_created_j: created_j,
        energy_created: relative(created_j),
        energy_balance: relative(findings[Invariant::Energy as usize].measured),
        loop_gap_m: outcome.loop_gap_m,
        steps: outcome.work.steps,
        contact_substeps: outcome.work.contact_substeps,
        wall_s,
        reason,
        ..unjudged_cell(factors, step_s, "")
    })
}

/// Returns the stability criteria that a completed run violates, if any.
fn violations(findings: &[Finding], created_j: f64, allowed_j: f64) -> Option<String> {
    let mut violations = Vec::new();
    if created_j > allowed_j || !created_j.is_finite() {
        violations.push(format!("energy created: {created_j:.3e} of {allowed_j:.3e} J allowed"));
    }
    for found in findings.iter().filter(|found| STABILITY_INVARIANTS.contains(&found.invariant)) {
        // Passivity is judged relative to the reference's throughput.
        let is_relative_to_reference = found.invariant == Invariant::Passivity;
        let found = if is_relative_to_reference { &Finding { allowed: allowed_j, ..found.clone() } } else { found };
        if found.is_violated() {
            violations.push(found.to_string());
        }
    }
    (!violations.is_empty()).then(|| violations.join("; "))
}

/// Returns a cell without a result.
fn unjudged_cell((stiffness_factor, damping_factor): (f64, f64), step_s: f64, reason: &str) -> Cell {
    Cell {
        step_s,
        stiffness_factor,
        damping_factor,
        verdict: Verdict::NotJudged,
        angle_error_rad: None,
        energy_created_j: 0.0,
        energy_created: 0.0,
        energy_balance: 0.0,
        loop_gap_m: 0.0,
        steps: 0,
        contact_substeps: 0,
        wall_s: 0.0,
        reason: Some(reason.to_string()),
    }
}
