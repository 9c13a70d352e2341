//! The convergence map of the engine model: over step size, contact stiffness and contact damping.
//!
//! **Cells.** The scene of a finger as it is given, the engine with a fixed step, and in both contacts with the object the
//! stiffness k and the greatest damping c_max times a factor each. The joint limit keeps its law. Each pair of factors is
//! compared with a *reference* of its own, the analytic model at [`Preset::Reference`](crate::scene::Preset).
//!
//! | verdict | what it says |
//! |---|---|
//! | failed | the run ended in an error, or broke what stability means: every number finite; mechanical energy beyond the motor's work never [`ENERGY`] of the reference's throughput above an earlier value; what is dissipated does not fall by as much; contacts and joint limit no deeper than all energy there is (and [`ENERGY`] more) could push them |
//! | accurate | not failed, and q11, q21, q22 within the bound of the reference at every step up to `[validate] until` |
//! | inaccurate | not failed, but further away somewhere |
//! | not judged | the reference could not be completed, or the engine's step budget was too small |
//!
//! The throughput is the most energy that was ever about in the reference. That of a broken run would grow with its errors.
//! A run that is too coarse to be right may still be stable: energy that gets lost is an error, not a failure.
//!
//! Each reference is also run with a motor torque larger by 1e-9: by how much that turns the angles says how well the
//! closing itself is determined. Where that is more than the bound, no step size could be right.

mod map;

use std::sync::mpsc::Sender;
use std::time::Instant;

use crate::integrator::{Failure, Reason};
use crate::invariants::{Finding, Invariant, Invariants};
use crate::scene::words::SceneKind;
use crate::scene::{Engine, Response, Scene, Stepping};
use crate::study::pool;
use crate::trace::While;
use crate::trace::{Event, Model, RunError, Sample, Sink, SinkError, run};
use crate::validate::{Comparison, Recording, member, record_while, reference, sampled};

pub use map::{Cell, Grid, ReferenceRun, Stability, StudyError, Verdict};

/// Part of the reference's energy throughput that may come from nowhere before a run counts as failed.
pub const ENERGY: f64 = 0.1;
/// Largest angle difference of an accurate run, unless another is asked for, in rad.
pub const ACCURACY_RAD: f64 = 1e-3;
/// Invariants whose breach is a failure, beside the energy; the others say how accurate a run is.
const STABILITY: [Invariant; 4] =
    [Invariant::Finite, Invariant::Passivity, Invariant::Penetration, Invariant::JointLimit];

/// What is the same for all cells.
struct Task<'a> {
    steps_s: &'a [f64],
    accuracy_rad: f64,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

/// Makes the map on all cores. `tell` hears how many of how many parts are done, and which was the last.
///
/// # Errors
/// A scene or grid that cannot be mapped, or `go_on` said no. Runs that fail are part of the map.
pub fn stability(
    scene: &Scene,
    grid: &Grid,
    accuracy_rad: f64,
    tell: &mut dyn FnMut(usize, usize, &str),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Stability, StudyError> {
    check(scene, grid)?;
    let start = Instant::now();
    let columns = grid.columns();
    let total = columns.len() * (grid.steps_s.len() + 1);
    let task = Task { steps_s: &grid.steps_s, accuracy_rad, go_on };
    let mut done = 0;
    tell(done, total, "references");
    let work = |&factors: &_, sender: &_| column(scene, factors, &task, sender);
    let found = pool::map(0, &columns, work, |note| {
        done += 1;
        tell(done, total, note);
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
    if scene.only(SceneKind::Finger)?.object().is_none() {
        return Err(StudyError::NoObject);
    }
    if scene.engine.response != Response::Laws {
        return Err(StudyError::Rigid);
    }
    if let Some(&step_s) = grid.steps_s.iter().find(|&&step_s| step_s >= scene.duration_s) {
        return Err(StudyError::LongStep { step_s, duration_s: scene.duration_s });
    }
    let most = scene.engine.max_steps.max(Engine::DEFAULT.max_steps);
    if let Some(&step_s) = grid.steps_s.iter().find(|&&step_s| scene.duration_s / step_s > most as f64) {
        return Err(StudyError::ShortStep { step_s, duration_s: scene.duration_s, most });
    }
    for (stiffness, damping) in grid.columns() {
        let contact = scaled(scene, stiffness, damping).finger().contact;
        for law in [contact.proximal.normal, contact.distal.normal] {
            let (k, c) = (law.stiffness_n_per_m_e, law.damping_max_n_s_per_m);
            if !(k.is_finite() && c.is_finite() && k.max(c) > 0.0) {
                return Err(StudyError::Law { stiffness, damping, k, c });
            }
        }
    }
    Ok(())
}

/// The scene with its contacts times the factors.
fn scaled(scene: &Scene, stiffness: f64, damping: f64) -> Scene {
    let mut scene = scene.clone();
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= stiffness;
        contact.normal.damping_max_n_s_per_m *= damping;
    }
    scene
}

/// The reference of a pair of factors and the cells judged by it; `None` if it was told to stop.
fn column(scene: &Scene, factors: (f64, f64), task: &Task, sender: &Sender<&str>) -> Option<(ReferenceRun, Vec<Cell>)> {
    let scene = scaled(scene, factors.0, factors.1);
    let (found, recording) = expected(&scene, factors, task)?;
    // Nobody listening is no reason to stop.
    let _ = sender.send("references");
    let mut cells = Vec::with_capacity(task.steps_s.len());
    for &step_s in task.steps_s {
        cells.push(match &recording {
            Some(recording) => cell(&scene, factors, step_s, (&found, recording), task)?,
            None => unjudged(factors, step_s, "the reference could not be completed"),
        });
        let _ = sender.send("engine");
    }
    Some((found, cells))
}

/// Runs the reference, and once more with a little more torque.
fn expected(scene: &Scene, (stiffness, damping): (f64, f64), task: &Task) -> Option<(ReferenceRun, Option<Recording>)> {
    let tight = reference(scene);
    let start = Instant::now();
    let recording = record_while(Model::Analytic, &tight, task.go_on);
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
            found.touchdowns = [0, 1].map(|site| recording.outcome.contacts[site].touchdowns);
            let mut invariants = Invariants::new(Model::Analytic, &tight);
            for sample in &recording.samples {
                invariants.sample(sample).expect("measuring writes nothing");
            }
            found.throughput_j = invariants.throughput_j();
            let mut comparison = Comparison::new(&recording, scene.bounds.until_s);
            let nearby = member(&tight, 1);
            match run(Model::Analytic, &nearby, &mut While { sink: &mut comparison, go_on: task.go_on }) {
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

/// Compares with the reference and watches the invariants in one go.
struct Watched<'a> {
    comparison: Comparison<'a>,
    invariants: Invariants,
}

impl Sink for Watched<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.comparison.sample(sample)?;
        self.invariants.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.comparison.event(event)
    }
}

/// Runs the engine with a fixed step and judges it; `None` if it was told to stop.
fn cell(
    scene: &Scene,
    factors: (f64, f64),
    step_s: f64,
    (expected, reference): (&ReferenceRun, &Recording),
    task: &Task,
) -> Option<Cell> {
    let mut scene = sampled(Model::Engine, scene);
    scene.engine.stepping = Stepping::Fixed { step_s };
    let mut watched = Watched {
        comparison: Comparison::new(reference, scene.bounds.until_s),
        invariants: Invariants::new(Model::Engine, &scene).tolerating(ENERGY),
    };
    let start = Instant::now();
    let result = run(Model::Engine, &scene, &mut While { sink: &mut watched, go_on: task.go_on });
    let wall_s = start.elapsed().as_secs_f64();
    let (outcome, broken) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure: Failure { reason: Reason::Stopped, .. }, .. }) => return None,
        Err(RunError::Simulation { failure, so_far }) => (*so_far, Some(failure)),
        Err(RunError::Sink(error)) => return Some(unjudged(factors, step_s, &error.to_string())),
    };
    let Watched { comparison, invariants } = watched;
    let error_rad = comparison.finish(&outcome).path_max();
    let (created_j, findings) = (invariants.created_j(), invariants.findings(outcome.loop_gap_m));
    let (verdict, reason) = match broken {
        Some(Failure { reason: reason @ (Reason::Budget(_) | Reason::SubstepBudget { .. }), .. }) => {
            (Verdict::NotJudged, Some(reason.to_string()))
        }
        Some(failure) => (Verdict::Failed, Some(failure.to_string())),
        None => match breach(&findings, created_j, ENERGY * expected.throughput_j) {
            Some(breach) => (Verdict::Failed, Some(breach)),
            None if error_rad <= task.accuracy_rad => (Verdict::Accurate, None),
            None => (Verdict::Inaccurate, None),
        },
    };
    let part = |energy_j: f64| if energy_j > 0.0 { energy_j / expected.throughput_j } else { 0.0 };
    Some(Cell {
        verdict,
        angle_error_rad: Some(error_rad).filter(|error| error.is_finite()),
        energy_created_j: created_j,
        energy_created: part(created_j),
        energy_balance: part(findings[Invariant::Energy as usize].measured),
        loop_gap_m: outcome.loop_gap_m,
        steps: outcome.work.steps,
        contact_substeps: outcome.work.contact_substeps,
        wall_s,
        reason,
        ..unjudged(factors, step_s, "")
    })
}

/// In what a finished run broke what stability means, everything that did.
fn breach(findings: &[Finding], created_j: f64, allowed_j: f64) -> Option<String> {
    let mut broken = Vec::new();
    if created_j > allowed_j || !created_j.is_finite() {
        broken.push(format!("energy created: {created_j:.3e} of {allowed_j:.3e} J allowed"));
    }
    for found in findings.iter().filter(|found| STABILITY.contains(&found.invariant)) {
        let held_to_reference = found.invariant == Invariant::Passivity;
        let found = if held_to_reference { &Finding { allowed: allowed_j, ..found.clone() } } else { found };
        if found.is_broken() {
            broken.push(found.to_string());
        }
    }
    (!broken.is_empty()).then(|| broken.join("; "))
}

/// A cell about which nothing is known.
fn unjudged((stiffness_factor, damping_factor): (f64, f64), step_s: f64, reason: &str) -> Cell {
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
