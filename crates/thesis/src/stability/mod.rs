//! Convergence map of the engine model over step size, contact stiffness and contact damping.
//!
//! **Cells.** Each cell is a run of the finger scene with the engine at a fixed step, with the stiffness k and the
//! largest damping c_max of both object contacts multiplied by one factor each. The joint limit keeps its law. Each
//! pair of factors is compared with its own *reference*, the analytic model at
//! [`Preset::Reference`](crate::scene::Preset).
//!
//! | verdict | meaning |
//! |---|---|
//! | failed | the run ended in an error or violated a stability criterion: all numbers are finite; mechanical energy minus the motor's work never rises by more than `ENERGY_TOLERANCE` of the reference's throughput above an earlier value; dissipated energy never falls by as much; contacts and joint limit penetrate no deeper than the total energy plus `ENERGY_TOLERANCE` allows |
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

mod display;

use std::time::Instant;

use serde::Serialize;

use crate::check::perturbed;
use crate::integrator::{Failure, Reason};
use crate::invariants::{Finding, Invariant, Invariants};
use crate::scene::{Engine, Preset, Response, Scene, Stepping};
use crate::trace::{FingerState, Model, RequiredData, RunError, Sample, Sink, SinkError, interpolate};
use phalanx_parallel::{ComputeError, Monitor, map, require};

/// Spurious energy relative to the reference's throughput above which a run counts as failed.
pub(crate) const ENERGY_TOLERANCE: f64 = 0.1;
/// Default of the largest angle difference at which a run counts as accurate, rad.
pub const ACCURACY_RAD: f64 = 1e-3;
/// Invariants whose violation is a failure, in addition to the energy. The others measure accuracy.
const STABILITY_INVARIANTS: [Invariant; 4] =
    [Invariant::Finite, Invariant::Passivity, Invariant::Penetration, Invariant::JointLimit];
/// Number of samples of a reference, and their maximum rate; interpolation between them is exact to rounding.
const REFERENCE_SAMPLES: f64 = 1e5;
const MAX_REFERENCE_HZ: f64 = 1e6;
/// Relative increase of the motor torque that measures the sensitivity of a closing motion.
const SENSITIVITY_PERTURBATION: f64 = 1e-9;

/// Grid of the map: steps in descending order, factors in ascending order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grid {
    pub steps_s: Vec<f64>,
    pub stiffness_factors: Vec<f64>,
    pub damping_factors: Vec<f64>,
}

impl Grid {
    /// Returns the standard grid. With `quick`, the two shortest steps are omitted.
    pub fn standard(quick: bool) -> Self {
        let mut steps_s = vec![1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6];
        steps_s.truncate(if quick { 5 } else { 7 });
        Grid { steps_s, stiffness_factors: vec![1e-2, 1.0, 1e2, 1e4], damping_factors: vec![0.0, 1e-3, 1.0, 10.0] }
    }

    /// Returns pairs of stiffness and damping factors; stiffness varies fastest.
    fn columns(&self) -> Vec<(f64, f64)> {
        let pairs = |&damping: &f64| self.stiffness_factors.iter().map(move |&stiffness| (stiffness, damping));
        self.damping_factors.iter().flat_map(pairs).collect()
    }
}

/// Verdict on a run of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    Accurate,
    Inaccurate,
    Failed,
    #[default]
    NotJudged,
}

impl Verdict {
    pub const ALL: [Verdict; 4] = [Verdict::Accurate, Verdict::Inaccurate, Verdict::Failed, Verdict::NotJudged];

    /// Returns the label in tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Accurate => "stable, accurate",
            Verdict::Inaccurate => "stable, inaccurate",
            Verdict::Failed => "failed",
            Verdict::NotJudged => "not judged",
        }
    }
}

/// One run of the engine; a row of the CSV file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Cell {
    pub step_s: f64,
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub verdict: Verdict,
    /// Largest difference of any joint angle up to the end of the run, rad; `None` if it is not finite or unknown.
    pub angle_error_rad: Option<f64>,
    /// Spurious mechanical energy, J.
    pub energy_created_j: f64,
    /// Spurious mechanical energy, as a fraction of the energy exchanged in the reference run.
    pub energy_created: f64,
    /// Largest magnitude of the energy balance, as a fraction of the energy exchanged in the reference run.
    pub energy_balance: f64,
    pub loop_gap_m: f64,
    pub steps: u64,
    pub contact_substeps: u64,
    pub wall_s: f64,
    /// Reason why the run failed or was not judged.
    pub reason: Option<String>,
}

/// One run of the analytic model.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReferenceRun {
    pub stiffness_factor: f64,
    pub damping_factor: f64,
    pub steps: u64,
    pub touchdowns: [u32; 2],
    /// Energy throughput, J: the largest mechanical energy in the system at any time.
    pub throughput_j: f64,
    /// Largest change of any joint angle if the motor torque increases by the relative amount 1e-9, rad; `None` if
    /// unknown.
    pub sensitivity_rad: Option<f64>,
    pub wall_s: f64,
    /// Reason why the run was not completed.
    pub reason: Option<String>,
}

/// Stability map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    pub scene: String,
    pub accuracy_rad: f64,
    pub duration_s: f64,
    pub until_s: f64,
    /// Contact stiffness k of the scene for the proximal and the distal contact, N/m^e.
    pub stiffness_si: [f64; 2],
    /// Largest contact damping c_max of the scene for the proximal and the distal contact, N·s/m.
    pub damping_max_n_s_per_m: [f64; 2],
    pub grid: Grid,
    pub references: Vec<ReferenceRun>,
    /// Cells; the step varies fastest, then stiffness, then damping.
    pub cells: Vec<Cell>,
    pub wall_s: f64,
}

impl Stability {
    pub fn cell(&self, step: usize, stiffness: usize, damping: usize) -> &Cell {
        let Grid { steps_s, stiffness_factors, .. } = &self.grid;
        &self.cells[(damping * stiffness_factors.len() + stiffness) * steps_s.len() + step]
    }

    pub fn reference(&self, stiffness: usize, damping: usize) -> &ReferenceRun {
        &self.references[damping * self.grid.stiffness_factors.len() + stiffness]
    }

    pub fn count(&self, verdict: Verdict) -> usize {
        self.cells.iter().filter(|cell| cell.verdict == verdict).count()
    }
}

/// Computes the map on all cores. The monitor counts runs as parts of the computation.
///
/// # Errors
/// Returns an error if the scene or the grid is not suitable, or if the monitor stops the computation. Failed runs are
/// part of the map.
pub fn stability(scene: &Scene, grid: &Grid, accuracy_rad: f64, monitor: &Monitor) -> Result<Stability, ComputeError> {
    check(scene, grid)?;
    let start = Instant::now();
    let factors = grid.columns();
    monitor.start(factors.len() * (grid.steps_s.len() + 1), "references");
    let columns = map(0, &factors, |&factors| column(scene, factors, grid, accuracy_rad, monitor))?;
    let (references, cells): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let laws = [scene.finger().contact.proximal.normal, scene.finger().contact.distal.normal];
    Ok(Stability {
        scene: scene.name.clone(),
        accuracy_rad,
        duration_s: scene.duration_s,
        until_s: scene.bounds.until_s,
        stiffness_si: laws.map(|law| law.stiffness_n_per_m_e),
        damping_max_n_s_per_m: laws.map(|law| law.damping_max()),
        grid: grid.clone(),
        references,
        cells: cells.into_iter().flatten().collect(),
        wall_s: start.elapsed().as_secs_f64(),
    })
}

fn check(scene: &Scene, grid: &Grid) -> Result<(), ComputeError> {
    let finger = scene.require_fingers(1).map_err(|error| ComputeError::Unsuitable(error.to_string()))?;
    require(finger.object().is_some(), || {
        "the scene has no contacts, so factors of contact stiffness and damping have no effect; add an object: [object] radius and \
         centre"
            .to_string()
    })?;
    require(scene.engine.response == Response::Laws, || {
        "the engine of this scene uses rapier's own contact, which has neither stiffness nor damping; remove `law = \"rapier\"` \
         under [engine]"
            .to_string()
    })?;
    for values in [&grid.steps_s, &grid.stiffness_factors, &grid.damping_factors] {
        for (index, value) in values.iter().enumerate() {
            require(!values[..index].contains(value), || format!("the value {value:e} is given twice; give it once"))?;
        }
    }
    let duration_s = scene.duration_s;
    let max_steps = scene.engine.max_steps.max(Engine::DEFAULT.max_steps);
    for step_s in &grid.steps_s {
        require(*step_s < duration_s, || {
            format!(
                "the step of {step_s:e} s is not shorter than the run of {duration_s:e} s; use shorter steps or a longer `duration`"
            )
        })?;
        require(duration_s / step_s <= max_steps as f64, || {
            format!(
                "with steps of {step_s:e} s the run of {duration_s:e} s takes more than {max_steps} steps; use longer steps or a \
                 shorter `duration`, or raise max_steps under [engine]"
            )
        })?;
    }
    for (stiffness, damping) in grid.columns() {
        let contact = scaled(scene, stiffness, damping).finger().contact;
        for law in [contact.proximal.normal, contact.distal.normal] {
            let (k, c) = (law.stiffness_n_per_m_e, law.damping_max());
            require(k.is_finite() && c.is_finite() && k.max(c) > 0.0, || {
                format!(
                    "the stiffness factor {stiffness:e} and the damping factor {damping:e} give a contact with k = {k:e} and c_max = \
                     {c:e}; both must be finite and one of them above 0; use other factors"
                )
            })?;
        }
    }
    Ok(())
}

/// Returns the scene with contact stiffness and damping multiplied by the factors.
fn scaled(scene: &Scene, stiffness: f64, damping: f64) -> Scene {
    let mut scene = scene.clone();
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= stiffness;
        contact.normal = contact.normal.with_damping_max(contact.normal.damping_max() * damping);
    }
    scene
}

/// Computes the reference for a pair of factors and the cells compared with it.
fn column(
    scene: &Scene,
    factors: (f64, f64),
    grid: &Grid,
    accuracy_rad: f64,
    monitor: &Monitor,
) -> Result<(ReferenceRun, Vec<Cell>), ComputeError> {
    let scene = scaled(scene, factors.0, factors.1);
    let (reference, samples) = run_reference(&scene, factors, monitor)?;
    monitor.advance(1, "references");
    let cell_of = |&step_s: &f64| {
        let cell = cell(&scene, factors, step_s, (&reference, &samples), accuracy_rad, monitor)?;
        monitor.advance(1, "engine");
        Ok(cell)
    };
    let cells = grid.steps_s.iter().map(cell_of).collect::<Result<_, _>>()?;
    Ok((reference, cells))
}

/// Compares the joint angles of a run with its reference and checks the invariants. Without a reference, the samples are
/// stored. The engine is observed at the ends of its steps, the analytic model on the grid.
struct Observer<'a> {
    model: Model,
    reference: Option<&'a [Sample]>,
    until_s: f64,
    /// Largest difference of a joint angle.
    error_rad: f64,
    samples: Vec<Sample>,
    invariants: Invariants,
}

impl<'a> Observer<'a> {
    fn new(model: Model, scene: &Scene, reference: Option<&'a [Sample]>) -> Self {
        let invariants = Invariants::new(model, scene).with_energy_tolerance(ENERGY_TOLERANCE);
        let until_s = scene.bounds.until_s;
        Observer { model, reference, until_s, error_rad: 0.0, samples: Vec::new(), invariants }
    }

    fn compare(&mut self, sample: &Sample, reference: &[Sample]) {
        let Some(last) = reference.len().checked_sub(1) else { return };
        if sample.time_s > self.until_s.min(reference[last].time_s) {
            return;
        }
        let next = reference.partition_point(|reference| reference.time_s <= sample.time_s);
        let (from, to) = (&reference[next.saturating_sub(1)], &reference[next.max(1).min(last)]);
        let angles = |sample: &Sample| {
            let FingerState { q11_rad, q21_rad, q22_rad, .. } = sample.finger(0);
            [q11_rad, q21_rad, q22_rad]
        };
        let expected = angles(&interpolate(from, to, sample.time_s.min(to.time_s)));
        for (found, expected) in angles(sample).into_iter().zip(expected) {
            let error_rad = (found - expected).abs();
            self.error_rad = if error_rad.is_nan() { f64::INFINITY } else { self.error_rad.max(error_rad) };
        }
    }
}

impl Sink for Observer<'_> {
    fn required_data(&self) -> RequiredData {
        RequiredData { grid: self.model == Model::Analytic, ..RequiredData::EVALUATION }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        match self.reference {
            Some(reference) => self.compare(sample, reference),
            None => self.samples.push(sample.clone()),
        }
        self.invariants.sample(sample)
    }
}

/// Runs the reference, and repeats it with a slightly larger torque. Returns its samples unless it failed.
fn run_reference(
    scene: &Scene,
    (stiffness_factor, damping_factor): (f64, f64),
    monitor: &Monitor,
) -> Result<(ReferenceRun, Option<Vec<Sample>>), ComputeError> {
    let mut scene = scene.clone();
    scene.apply_preset(Preset::Reference);
    let dense_hz = (REFERENCE_SAMPLES / scene.duration_s).min(MAX_REFERENCE_HZ);
    scene.log.numeric_hz = dense_hz.max(scene.log.numeric_hz);
    let start = Instant::now();
    let mut observer = Observer::new(Model::Analytic, &scene, None);
    let result = monitor.run(Model::Analytic, &scene, &mut observer)?;
    let wall_s = start.elapsed().as_secs_f64();
    let mut reference = ReferenceRun { stiffness_factor, damping_factor, wall_s, ..ReferenceRun::default() };
    let outcome = match result {
        Ok(outcome) => outcome,
        Err(error) => {
            reference.reason = Some(error.to_string());
            return Ok((reference, None));
        }
    };
    reference.steps = outcome.work.steps;
    reference.touchdowns = [0, 1].map(|contact| outcome.contacts[contact].touchdowns);
    reference.throughput_j = observer.invariants.throughput_j();
    let perturbed = perturbed(&scene, SENSITIVITY_PERTURBATION);
    let mut repeated = Observer::new(Model::Analytic, &perturbed, Some(&observer.samples));
    let result = monitor.run(Model::Analytic, &perturbed, &mut repeated)?;
    reference.sensitivity_rad = result.is_ok().then_some(repeated.error_rad);
    Ok((reference, Some(observer.samples)))
}

/// Runs the engine with a fixed step and judges the run.
fn cell(
    scene: &Scene,
    (stiffness_factor, damping_factor): (f64, f64),
    step_s: f64,
    reference: (&ReferenceRun, &Option<Vec<Sample>>),
    accuracy_rad: f64,
    monitor: &Monitor,
) -> Result<Cell, ComputeError> {
    let (ReferenceRun { throughput_j, .. }, samples) = reference;
    let unjudged = |reason: &str| Cell {
        step_s,
        stiffness_factor,
        damping_factor,
        reason: Some(reason.to_string()),
        ..Cell::default()
    };
    let Some(samples) = samples else { return Ok(unjudged("the reference could not be completed")) };
    let mut scene = scene.clone();
    scene.engine.stepping = Stepping::Fixed { step_s };
    let mut observer = Observer::new(Model::Engine, &scene, Some(samples));
    let start = Instant::now();
    let result = monitor.run(Model::Engine, &scene, &mut observer)?;
    let wall_s = start.elapsed().as_secs_f64();
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure)),
        Err(RunError::Sink(error)) => return Ok(unjudged(&error.to_string())),
    };
    let Observer { error_rad, invariants, .. } = observer;
    let (created_j, findings) = (invariants.created_j(), invariants.findings(outcome.loop_gap_m));
    let (verdict, reason) = match failure {
        Some(Failure { reason: reason @ (Reason::Budget(_) | Reason::SubstepBudget { .. }), .. }) => {
            (Verdict::NotJudged, Some(reason.to_string()))
        }
        Some(failure) => (Verdict::Failed, Some(failure.to_string())),
        None => match violations(&findings, created_j, ENERGY_TOLERANCE * throughput_j) {
            Some(violations) => (Verdict::Failed, Some(violations)),
            None if error_rad <= accuracy_rad => (Verdict::Accurate, None),
            None => (Verdict::Inaccurate, None),
        },
    };
    let relative = |energy_j: f64| if energy_j > 0.0 { energy_j / throughput_j } else { 0.0 };
    Ok(Cell {
        step_s,
        stiffness_factor,
        damping_factor,
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
