//! Validates a scene: computes its verdict.

use rayon::prelude::*;
use serde::Serialize;

use super::configuration::{LadderRow, engine_keys};
use super::scenes::{modify, reference_path_bound};
use super::verdict::{Evidence, REFERENCE_BOUNDS, judge};
use super::{
    Comparison, Criterion, Differences, Recording, SolverConfiguration, Statistics, Verdict, check_invariants, compare,
    compare_criteria, compare_statistics, compared_scene, ensemble_member, ensemble_size, finer_configurations,
    path_bound, reason_not_judged, record_cancellable, reference_scene, sampled_scene, scene_configuration,
};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::trace::{Cancellable, Model, RunError, run};
use phalanx_parallel::{KeepRunning, on_all_cores};

/// A finer configuration of the engine, which was run because a bound failed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FinerConfiguration {
    /// The configuration, written as keys of `[engine]`.
    pub setting: String,
    pub passed: bool,
}

/// All results of a validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Time up to which trajectories are compared, s.
    pub until_s: f64,
    /// Largest allowed error of the engine's trajectory, rad; for scenes without joints, m.
    pub path_bound: f64,
    /// Run of the analytic model with its reference preset, on a dense grid. It is that of the scene itself, not of
    /// another member of the ensemble.
    pub reference: Recording,
    /// Run of the engine with the settings of the scene, for the scene itself.
    pub engine: Recording,
    /// The other members of the ensemble with their references.
    pub(super) other_members: Vec<(Scene, Recording)>,
    /// Differences of the engine with the settings of the scene: the worst ones of the ensemble.
    pub differences: Differences,
    /// Comparison of the criteria of the two runs.
    pub criteria: Vec<Criterion>,
    /// Reason why the criteria are not judged; `None` if they are judged.
    pub reason_not_judged: Option<&'static str>,
    /// Margins of the invariants in `reference`.
    pub reference_invariants: Vec<Finding>,
    /// Margins of the invariants in `engine`.
    pub engine_invariants: Vec<Finding>,
    /// Means over many runs beyond `until_s`; `None` if trajectories are compared to the end.
    pub statistics: Option<Statistics>,
    /// The evaluated configurations of the ladder; empty without a ladder.
    pub ladder: Vec<LadderRow>,
    pub verdict: Verdict,
    /// The check that compares the reference with another integration method.
    pub reference_check: check::Check,
    /// Finer configurations of the engine that were run because the verdict failed, from coarse to fine, each with its
    /// result. The series ends with the first configuration that passes.
    pub finer_configurations: Vec<FinerConfiguration>,
}

impl Validation {
    /// Returns the estimated error of the reference, in the unit of a check; `None` if it could not be estimated.
    pub fn reference_error(&self) -> Option<f64> {
        (self.reference_check.verdict != check::Verdict::Unknown).then_some(self.reference_check.errors.path)
    }

    /// Returns the model to trust if the models differ by more than a bound: the analytic one, if its two integration
    /// methods agree and it breaks no invariant.
    pub(crate) fn trusted_model(&self) -> Option<Model> {
        (!self.verdict.passed() && !self.verdict.fails(&REFERENCE_BOUNDS)).then_some(Model::Analytic)
    }
}

/// Error for a scene whose reference run or engine run could not be completed.
#[derive(Debug, thiserror::Error)]
#[error("the {} model did not complete the scene, so there is nothing to compare: {error}", model.name())]
pub struct ValidationError {
    pub model: Model,
    #[source]
    pub error: RunError,
}

/// One member of the ensemble: its scene, both runs and their differences.
struct Member {
    scene: Scene,
    reference: Recording,
    engine: Recording,
    differences: Differences,
}

/// Compares the engine with the reference, and judges it. The engine has the settings of the scene. The members of the
/// ensemble run in parallel.
///
/// # Errors
/// Returns an error if a reference run, or the engine with the scene's own settings, could not be completed, or if
/// `keep_running` returned false.
pub fn validate(full_scene: &Scene, keep_running: KeepRunning) -> Result<Validation, ValidationError> {
    let scene = &compared_scene(full_scene);
    let (until_s, path_bound) = (full_scene.bounds.until_s, path_bound(full_scene));
    // Trajectories are compared up to `until_s`, and so is the reference with another method.
    let checked = reference_scene(&modify(scene, |scene| scene.duration_s = until_s.min(scene.duration_s)));
    let members = || (0..ensemble_size(scene)).into_par_iter().map(|index| run_member(scene, index, keep_running));
    let check = || check::check(Model::Analytic, &checked, keep_running);
    let (reference_check, members): (_, Vec<_>) = on_all_cores(|| rayon::join(check, || members().collect()));
    let mut members = members.into_iter().collect::<Result<Vec<Member>, _>>()?;
    let Member { reference, engine, differences, .. } = members.remove(0);
    let differences = members.iter().fold(differences, |worst, member| worst.worst(&member.differences));
    let other_members: Vec<_> = members.into_iter().map(|member| (member.scene, member.reference)).collect();

    let engine_error = |error: RunError| ValidationError { model: Model::Engine, error };
    // Beyond the time up to which trajectories are compared, means over many runs are compared instead.
    let is_shortened = scene.finger_count() == 1 && scene.bounds.until_s < scene.duration_s;
    let statistics = is_shortened.then(|| compare_statistics(scene, keep_running)).transpose().map_err(engine_error)?;
    let reference_invariants = check_invariants(&reference_scene(scene), Model::Analytic, &reference);
    let reason_not_judged = reason_not_judged(scene, &reference_check);
    let judge_engine = |engine: &Recording, differences: &Differences| {
        let criteria = compare_criteria(scene, &reference, engine);
        let engine_invariants = check_invariants(scene, Model::Engine, engine);
        let evidence = Evidence {
            reference_check: &reference_check,
            path_bound: reference_path_bound(full_scene),
            criteria: if reason_not_judged.is_none() { &criteria } else { &[] },
            reference_invariants: &reference_invariants,
            engine_invariants: &engine_invariants,
            statistics: statistics.as_ref(),
        };
        let verdict = judge(differences, &scene.bounds, &evidence);
        (verdict, criteria, engine_invariants)
    };
    let (verdict, criteria, engine_invariants) = judge_engine(&engine, &differences);
    let mut finer = Vec::new();
    // Finer configurations are not compared by statistics, which take many runs of the engine.
    if !verdict.passed() && !verdict.fails(&REFERENCE_BOUNDS) && !verdict.fails(&["statistics"]) {
        for configuration in finer_configurations(scene, engine.outcome.work.steps) {
            let run = record_configuration(&configuration, scene, &reference, keep_running);
            let worst = |first: Differences| worst_over_members(first, &configuration, &other_members, keep_running);
            let passed = match run.and_then(|(engine, first)| Ok((engine, worst(first)?))) {
                Ok((engine, differences)) => judge_engine(&engine, &differences).0.passed(),
                Err(error) if error.is_stop() => return Err(engine_error(error)),
                Err(_) => false,
            };
            finer.push(FinerConfiguration { setting: engine_keys(&configuration), passed });
            if passed {
                break;
            }
        }
    }
    Ok(Validation {
        until_s,
        path_bound,
        verdict,
        reason_not_judged,
        reference_check,
        finer_configurations: finer,
        statistics,
        reference_invariants,
        engine_invariants,
        reference,
        engine,
        other_members,
        differences,
        criteria,
        ladder: Vec::new(),
    })
}

/// Runs both models for one member. Only the run of the first member, the scene itself, is kept.
fn run_member(scene: &Scene, index: usize, keep_running: KeepRunning) -> Result<Member, ValidationError> {
    let error_of = |model: Model| move |error: RunError| ValidationError { model, error };
    let scene = ensemble_member(scene, index);
    let reference = record_cancellable(Model::Analytic, &reference_scene(&scene), keep_running)
        .map_err(error_of(Model::Analytic))?;
    let configuration = scene_configuration(&scene);
    let run = match index {
        0 => record_configuration(&configuration, &scene, &reference, keep_running),
        _ => compare_with_reference(&configuration, &scene, &reference, keep_running)
            .map(|differences| (Recording::default(), differences)),
    };
    let (engine, differences) = run.map_err(error_of(Model::Engine))?;
    Ok(Member { scene, reference, engine, differences })
}

/// Runs the engine at a configuration, and returns the recorded run and its differences from the reference.
fn record_configuration(
    configuration: &SolverConfiguration,
    scene: &Scene,
    reference: &Recording,
    keep_running: KeepRunning,
) -> Result<(Recording, Differences), RunError> {
    let sampled = sampled_scene(Model::Engine, &configuration.apply(scene));
    let engine = record_cancellable(Model::Engine, &sampled, keep_running)?;
    let differences = compare(&engine, reference, scene.bounds.until_s);
    Ok((engine, differences))
}

/// Returns the differences of a configuration from the reference of one member.
pub(super) fn compare_with_reference(
    configuration: &SolverConfiguration,
    scene: &Scene,
    reference: &Recording,
    keep_running: KeepRunning,
) -> Result<Differences, RunError> {
    let mut comparison = Comparison::new(reference, scene.bounds.until_s);
    let sampled = sampled_scene(configuration.model(), &configuration.apply(scene));
    let outcome = run(configuration.model(), &sampled, &mut Cancellable { sink: &mut comparison, keep_running })?;
    Ok(comparison.finish(&outcome))
}

/// Returns the worst differences of a configuration over its members. `first` are the differences of the scene itself.
pub(super) fn worst_over_members(
    first: Differences,
    configuration: &SolverConfiguration,
    other_members: &[(Scene, Recording)],
    keep_running: KeepRunning,
) -> Result<Differences, RunError> {
    other_members.iter().take(configuration.members.saturating_sub(1)).try_fold(first, |worst, (scene, reference)| {
        Ok(worst.worst(&compare_with_reference(configuration, scene, reference, keep_running)?))
    })
}
