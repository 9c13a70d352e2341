//! Accuracy check of a run: an error estimate from a second, independent simulation, and a test whether the outcome
//! depends on the last digits of the input.
//!
//! A run of the analytic model is compared with a run by the other family of methods (Rodas5P or Radau IIA) at a
//! hundredth of its tolerance. A run of the engine is compared with the analytic model. If the analytic model does not
//! support the scene (singular configurations of the linkage, rapier's own contact), the reference is the engine at a
//! tenth of the tolerance and a quarter of the step limit. Two runs of one method with the same steps and the same digits
//! are no evidence of accuracy. To measure the sensitivity, the actuation of the scene is multiplied by 1 +
//! [`PERTURBATION`].
//!
//! The check compares the path, energies and works, and the restitution of discs.

mod path;
mod verdict;

use crate::scene::Scene;
use crate::trace::{Cancellable, KeepRunning, Model, Sink};
use path::{RunOptions, is_comparable, reference_name, run};
use verdict::{Comparison, error_limits, verdict};

pub use path::{Errors, Path, REFERENCE_LENGTH_M, perturbed, run_and_record, units};
pub use verdict::{
    ANALYTIC_LIMITS, CHAOS_THRESHOLD, ENGINE_LIMITS, ErrorLimits, MOTION_FRACTION, Verdict, reference_length_m,
};

/// Relative change of the actuation of a scene: of the motor torques, or of the velocities and the gravity of discs.
pub const PERTURBATION: f64 = 1e-7;
/// Largest number of steps of a run that is checked without a request. The check then takes some tenths of a second.
pub const MAX_CHECKED_STEPS: u64 = 20_000;

/// Step budget of each run of a check, per step of the checked run.
const STEPS_PER_STEP: u64 = 10;
/// Additional step budget, so that a check outlasts the some 30,000 steps of chatter before the integrator damps it.
const EXTRA_CHECK_STEPS: u64 = 50_000;

/// Result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    pub verdict: Verdict,
    pub errors: Errors,
    /// Largest change of the path due to the perturbation, rad (discs: m).
    pub sensitivity: f64,
    /// Path error above which the run is uncertain, rad (discs: m).
    pub max_path_error: f64,
    /// Length scale of `max_path_error`, in words.
    pub max_path_error_basis: String,
    /// Largest displacement along the path, if the motion is so small that it determines `max_path_error`; `None`
    /// otherwise.
    pub largest_displacement: Option<f64>,
    /// Energy error above which the run is uncertain, as a fraction of the energy exchanged.
    pub max_energy_error: f64,
    /// Name of the reference with which the run was compared.
    pub reference: String,
    /// Reason for the verdict, if the path error alone does not explain it.
    pub reason: Option<String>,
}

impl Check {
    /// Result without a comparison: errors are unknown.
    fn unknown(model: Model, reason: String) -> Self {
        let errors = Errors { path: f64::INFINITY, energy: f64::INFINITY, ..Errors::default() };
        let limits = error_limits(model, 0);
        Check {
            verdict: Verdict::Unknown,
            errors,
            sensitivity: f64::INFINITY,
            max_path_error: limits.path,
            max_path_error_basis: String::new(),
            largest_displacement: None,
            max_energy_error: limits.energy,
            reference: String::new(),
            reason: Some(reason),
        }
    }

    /// Returns the result for a run that was not completed. It has no verdict.
    pub fn not_completed(model: Model, time_s: f64, reason: &str) -> Self {
        Self::unknown(model, format!("the run ended at {:.6} ms because: {reason}", time_s * 1e3))
    }
}

/// Runs a model with the settings of the scene and checks the run. The check stops once `keep_running` returns false.
pub fn check(model: Model, scene: &Scene, keep_running: KeepRunning<'_>) -> Check {
    check_with_sinks(model, scene, [&mut (), &mut ()], keep_running)
}

/// Like [`check`], with sinks for the two finer runs: the reference and the perturbed run. Their samples have no
/// energies or peaks. If the analytic model is the reference and fails, the reference sink receives its samples before
/// those of the engine.
pub fn check_with_sinks(
    model: Model,
    scene: &Scene,
    sinks: [&mut dyn Sink; 2],
    keep_running: KeepRunning<'_>,
) -> Check {
    let (_, path) = run_and_record(model, scene, &mut Cancellable { sink: &mut (), keep_running });
    check_path(model, scene, path, sinks, keep_running)
}

/// Checks a run of a model with the settings of the scene, given the path of the run. The check stops once
/// `keep_running` returns false.
pub fn check_run(model: Model, scene: &Scene, path: Path, keep_running: KeepRunning<'_>) -> Check {
    check_path(model, scene, path, [&mut (), &mut ()], keep_running)
}

fn check_path(
    model: Model,
    scene: &Scene,
    checked_run: Path,
    [reference_sink, perturbed_sink]: [&mut dyn Sink; 2],
    keep_running: KeepRunning<'_>,
) -> Check {
    let options = RunOptions {
        finer: false,
        perturbation: 0.0,
        span_s: scene.duration_s,
        energies: true,
        max_steps: u64::MAX,
        keep_running,
    };
    if let Some(reason) = &checked_run.failure {
        return Check::not_completed(model, checked_run.end_s, &reason.to_string());
    }
    // A run that ended early because the object left the gripper is compared up to that time.
    let span_s = if checked_run.ejected { checked_run.end_s } else { scene.duration_s };
    let checked_run = if span_s < scene.duration_s {
        run(scene, model, &RunOptions { span_s, ..options }, &mut ())
    } else {
        checked_run
    };
    let finer = RunOptions {
        finer: true,
        span_s,
        max_steps: STEPS_PER_STEP * checked_run.steps + EXTRA_CHECK_STEPS,
        ..options
    };
    let analytic =
        (model == Model::Analytic || is_comparable(scene)).then(|| run(scene, Model::Analytic, &finer, reference_sink));
    // The analytic model is the reference for the engine up to its failure; the engine itself is the reference if it
    // fails.
    let until_failure = analytic.as_ref().filter(|_| model == Model::Engine);
    let error_until_failure = until_failure.map_or(0.0, |path| path::difference(&checked_run, path));
    let is_reference = |path: &Path| model == Model::Analytic || path.failure.is_none();
    let (reference_run, reference_model) = match analytic.filter(is_reference) {
        Some(analytic) => (analytic, Model::Analytic),
        None => (run(scene, Model::Engine, &finer, reference_sink), Model::Engine),
    };
    let perturbed = RunOptions { perturbation: PERTURBATION, energies: false, ..finer };
    let perturbed_run = run(scene, reference_model, &perturbed, perturbed_sink);
    let limits = error_limits(model, checked_run.events);
    let limit = verdict::path_error_limit(scene, &checked_run, limits.path);
    let mut errors = path::errors(&checked_run, &reference_run);
    errors.path = errors.path.max(error_until_failure);
    let sensitivity = path::difference(&reference_run, &perturbed_run);
    let (verdict, reason) = verdict(&Comparison {
        run: &checked_run,
        reference_run: &reference_run,
        perturbed_run: &perturbed_run,
        errors: &errors,
        sensitivity,
        chaos_threshold: limit.chaos_threshold,
        limits: ErrorLimits { path: limit.error, ..limits },
        max_loop_gap_m: ENGINE_LIMITS.path * scene.hand.shortest_link_m(),
        // The reference of the analytic model uses another method.
        same_method: reference_model == Model::Engine,
    });
    let reference = reference_name(scene, reference_model);
    if verdict == Verdict::Unknown {
        return Check { reference, ..Check::unknown(model, reason.unwrap_or_default()) };
    }
    Check {
        verdict,
        errors,
        sensitivity,
        max_path_error: limit.error,
        max_path_error_basis: limit.basis,
        largest_displacement: limit.largest_displacement,
        max_energy_error: limits.energy,
        reference,
        reason,
    }
}
