//! Validates a scene: computes the verdict and, on request, the results of other solver configurations (the ladder).

use std::time::Instant;

use super::ensemble::ensemble_member;
use super::scenes::{modify, reference_path_bound};
use super::verdict::REFERENCE_BOUNDS;
use super::{
    Comparison, Cost, Criterion, Differences, MAX_PREDICTED_STEPS, Recording, SolverConfiguration, Statistics, Verdict,
    check_bounds, check_invariants, compare, compare_criteria, compare_statistics, compared_scene, criteria_checks,
    ensemble_size, finer_configurations, ladder_configurations, measure_cost, path_bound, reason_not_judged,
    record_cancellable, reference_scene, sampled_scene, scene_configuration,
};
use crate::check;
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{Cancellable, Model, RunError, run};

/// A callback that returns whether to continue, called from several threads.
pub type SyncKeepRunning<'a> = &'a (dyn Fn() -> bool + Sync);

/// Default time limit of a ladder, s: enough for all configurations of a finger except the shortest fixed steps.
pub const LADDER_TIME_S: f64 = 10.0;

/// Selects the configurations of a ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LadderOptions {
    /// Whether to omit configurations that take long, regardless of the time limit.
    pub quick: bool,
    /// Time limit, s. Configurations are started as long as the expected total time is below it.
    pub time_s: f64,
}

/// A configuration and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct LadderRow {
    pub configuration: SolverConfiguration,
    pub evaluation: Evaluation,
}

/// The result of a configuration.
#[derive(Clone, Debug, PartialEq)]
pub enum Evaluation {
    /// Completed, with the worst differences of its ensemble; `None` for the reference itself.
    Done {
        differences: Option<Box<Differences>>,
        cost: Cost,
    },
    Failed {
        reason: String,
    },
    /// Skipped because it is predicted to take this many steps.
    TooLong {
        steps: f64,
    },
    /// Skipped because it was expected to exceed the time limit of the ladder.
    NoTime,
}

/// All results of a validation.
#[derive(Clone, Debug, PartialEq)]
pub struct Validation {
    /// Trajectories are compared up to this time.
    pub until_s: f64,
    /// Largest allowed error of the engine's trajectory, rad; for scenes of discs, m.
    pub path_bound: f64,
    /// Run of the analytic model at its reference preset, on a dense grid, for the scene itself.
    pub reference: Recording,
    /// Run of the engine at the scene's settings, for the scene itself.
    pub engine: Recording,
    /// The other members of the ensemble with their references.
    other_members: Vec<(Scene, Recording)>,
    /// Differences of the engine at the scene's settings: the worst of the ensemble.
    pub differences: Differences,
    /// Comparison of the criteria of both runs.
    pub criteria: Vec<Criterion>,
    /// Reason why the criteria are not judged; `None` if they are.
    pub reason_not_judged: Option<&'static str>,
    /// Margins of the invariants in `reference`.
    pub reference_invariants: Vec<Finding>,
    /// Margins of the invariants in `engine`.
    pub engine_invariants: Vec<Finding>,
    /// Means over many runs beyond `until_s`; `None` where trajectories are compared to the end.
    pub statistics: Option<Statistics>,
    /// The evaluated configurations of the ladder; empty without a ladder.
    pub ladder: Vec<LadderRow>,
    pub verdict: Verdict,
    /// The check of the reference against another integration method.
    pub reference_check: check::Check,
    /// Finer configurations of the engine, run because the verdict failed, from coarse to fine, and whether each
    /// passes. The series ends with the first that passes.
    pub finer_configurations: Vec<(SolverConfiguration, bool)>,
}

impl Validation {
    /// Returns the estimated error of the reference, in the unit of a check; `None` where it could not be estimated.
    pub fn reference_error(&self) -> Option<f64> {
        (self.reference_check.verdict != check::Verdict::Unknown).then_some(self.reference_check.errors.path)
    }

    /// Returns the model to trust if the models differ by more than a bound: the analytic one, if its two integration
    /// methods agree and it breaks no invariant.
    pub fn trusted_model(&self) -> Option<Model> {
        (!self.verdict.passed() && !self.verdict.fails(&REFERENCE_BOUNDS)).then_some(Model::Analytic)
    }
}

/// Error for a scene whose reference or engine run could not be completed.
#[derive(Debug, thiserror::Error)]
#[error("the {} model did not complete the scene, so there is nothing to compare: {error}", model.name())]
pub struct ValidationError {
    pub model: Model,
    #[source]
    pub error: RunError,
}

/// Progress of the evaluation of a ladder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress<'a> {
    pub done: usize,
    pub total: usize,
    /// Name of the next family.
    pub next: &'a str,
}

/// One member of the ensemble: its scene, its reference and its differences. Only the first stores the engine's run.
struct Member {
    scene: Scene,
    reference: Recording,
    engine: Option<Recording>,
    differences: Differences,
}

/// Compares the engine at the scene's settings with the reference and judges it. Each member of the ensemble runs on
/// its own thread.
///
/// # Errors
/// Returns an error if a reference run, or the engine at the scene's own settings, could not be completed, or if
/// `keep_running` returned false.
pub fn validate(full_scene: &Scene, keep_running: SyncKeepRunning) -> Result<Validation, ValidationError> {
    let scene = &compared_scene(full_scene);
    let (until_s, path_bound) = (full_scene.bounds.until_s, path_bound(full_scene));
    let (members, reference_check) = std::thread::scope(|scope| {
        let reference_check = scope.spawn(|| check_reference(scene, until_s, keep_running));
        let runs = (0..ensemble_size(scene)).map(|index| scope.spawn(move || run_member(scene, index, keep_running)));
        let runs: Vec<_> = runs.collect();
        let members: Result<Vec<Member>, ValidationError> = runs.into_iter().map(join_or_panic).collect();
        (members, join_or_panic(reference_check))
    });
    let members = members?;
    let differences =
        members[1..].iter().fold(members[0].differences.clone(), |worst, member| worst.worst(&member.differences));
    let mut members = members.into_iter();
    let (reference_run, engine) =
        members.next().map(|first| (first.reference, first.engine.unwrap_or_default())).unwrap_or_default();
    let other_members: Vec<_> = members.map(|member| (member.scene, member.reference)).collect();

    let engine_error = |error: RunError| ValidationError { model: Model::Engine, error };
    let statistics = late_statistics(scene, keep_running).map_err(engine_error)?;
    let reference_invariants = check_invariants(&reference_scene(scene), Model::Analytic, &reference_run);
    let reason_not_judged = reason_not_judged(scene, &reference_check);
    let judge_engine = |engine: &Recording, differences: &Differences| {
        let criteria = compare_criteria(scene, &reference_run, engine);
        let engine_invariants = check_invariants(scene, Model::Engine, engine);
        let verdict = check_bounds(differences, &scene.bounds)
            .with_criteria(if reason_not_judged.is_none() { criteria_checks(&criteria) } else { Vec::new() })
            .with_reference(&reference_check, reference_path_bound(full_scene))
            .with_invariants("analytic_invariants", &reference_invariants)
            .with_invariants("engine_invariants", &engine_invariants)
            .with_statistics(statistics.as_ref());
        (verdict, criteria, engine_invariants)
    };
    let (verdict, criteria, engine_invariants) = judge_engine(&engine, &differences);
    let mut finer = Vec::new();
    // Finer configurations are not compared by statistics, which take many runs of the engine.
    if !verdict.passed() && !verdict.fails(&REFERENCE_BOUNDS) && !verdict.fails(&["statistics"]) {
        for configuration in finer_configurations(scene, engine.outcome.work.steps) {
            let run = record_configuration(&configuration, scene, &reference_run, keep_running).and_then(
                |(engine, first)| {
                    Ok((engine, worst_over_members(first, &configuration, &other_members, keep_running)?))
                },
            );
            let passed = match run {
                Ok((engine, differences)) => judge_engine(&engine, &differences).0.passed(),
                Err(error) if error.is_stop() => return Err(engine_error(error)),
                Err(_) => false,
            };
            finer.push((configuration, passed));
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
        reference: reference_run,
        engine,
        other_members,
        differences,
        criteria,
        ladder: Vec::new(),
    })
}

/// Returns the result of a thread, or resumes its panic.
fn join_or_panic<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

fn run_member(scene: &Scene, index: usize, keep_running: SyncKeepRunning) -> Result<Member, ValidationError> {
    let model_error = |model: Model| move |error: RunError| ValidationError { model, error };
    let scene = ensemble_member(scene, index);
    let expected = record_cancellable(Model::Analytic, &reference_scene(&scene), keep_running)
        .map_err(model_error(Model::Analytic))?;
    if index > 0 {
        let differences = compare_with_reference(&scene_configuration(&scene), &scene, &expected, keep_running)
            .map_err(model_error(Model::Engine))?;
        return Ok(Member { scene, reference: expected, engine: None, differences });
    }
    let (engine, differences) = record_configuration(&scene_configuration(&scene), &scene, &expected, keep_running)
        .map_err(model_error(Model::Engine))?;
    Ok(Member { scene, reference: expected, engine: Some(engine), differences })
}

/// Runs the engine at a configuration, and returns the recorded run and its differences from the reference.
fn record_configuration(
    configuration: &SolverConfiguration,
    scene: &Scene,
    reference: &Recording,
    keep_running: SyncKeepRunning,
) -> Result<(Recording, Differences), RunError> {
    let engine =
        record_cancellable(Model::Engine, &sampled_scene(Model::Engine, &configuration.apply(scene)), keep_running)?;
    let differences = compare(&engine, reference, scene.bounds.until_s);
    Ok((engine, differences))
}

/// Adds the ladder to a validation: other configurations of both models, compared with the same references and timed,
/// but not judged. They run sequentially, because their times are measured, in order of their predicted number of
/// steps.
///
/// # Errors
/// Returns an error if the scene's own configuration failed or `keep_running` returned false. A failure of any other
/// configuration is reported in its row.
pub fn run_ladder(
    validation: &mut Validation,
    full_scene: &Scene,
    options: LadderOptions,
    report_progress: &mut dyn FnMut(Progress),
    keep_running: SyncKeepRunning,
) -> Result<(), ValidationError> {
    let scene = &compared_scene(full_scene);
    let configurations = ladder_configurations(scene, options.quick);
    let (total, start) = (configurations.len(), Instant::now());
    let scene_steps = validation.engine.outcome.work.steps;
    let mut order: Vec<usize> = (0..total).collect();
    let steps = |configuration: &SolverConfiguration| match configuration.is_from_scene || configuration.is_reference()
    {
        // The scene's own configuration and the reference come first, because their times are always reported.
        true => -1.0,
        false => {
            configuration.predicted_steps(scene, scene_steps).map_or(0.0, |steps| steps * configuration.members as f64)
        }
    };
    order.sort_by(|a, b| steps(&configurations[*a]).total_cmp(&steps(&configurations[*b])));
    let mut rows: Vec<Option<Evaluation>> = vec![None; total];
    // Wall time per step of the engine at the scene's settings.
    let mut step_wall_s = 0.0;
    for (done, index) in order.into_iter().enumerate() {
        let configuration = &configurations[index];
        report_progress(Progress { done, total, next: configuration.family.name() });
        let remaining_s = options.time_s - start.elapsed().as_secs_f64();
        let is_run = configuration.is_from_scene
            || configuration.is_reference()
            || (remaining_s > 0.0 && steps(configuration) * step_wall_s < remaining_s);
        let evaluation = match is_run {
            true => evaluate(configuration, scene, validation, options.quick, keep_running)?,
            false => Evaluation::NoTime,
        };
        if let (true, Evaluation::Done { cost, .. }) = (configuration.is_from_scene, &evaluation) {
            step_wall_s = cost.wall_s / cost.steps.max(1) as f64;
        }
        rows[index] = Some(evaluation);
    }
    let rows = configurations.into_iter().zip(rows);
    validation.ladder = rows
        .filter_map(|(configuration, evaluation)| Some(LadderRow { configuration, evaluation: evaluation? }))
        .collect();
    Ok(())
}

/// Compares means over many runs beyond the time up to which trajectories are compared; `None` if they are compared to
/// the end.
fn late_statistics(scene: &Scene, keep_running: SyncKeepRunning) -> Result<Option<Statistics>, RunError> {
    let is_shortened = scene.kind() == SceneKind::Finger && scene.bounds.until_s < scene.duration_s;
    is_shortened.then(|| compare_statistics(scene, keep_running)).transpose()
}

/// Checks the reference up to `until_s`, the end of the comparison of trajectories.
fn check_reference(scene: &Scene, until_s: f64, keep_running: SyncKeepRunning) -> check::Check {
    let shortened_scene = modify(scene, |scene| scene.duration_s = until_s.min(scene.duration_s));
    check::check(Model::Analytic, &reference_scene(&shortened_scene), keep_running)
}

/// Compares and times one configuration.
fn evaluate(
    configuration: &SolverConfiguration,
    scene: &Scene,
    validation: &Validation,
    quick: bool,
    keep_running: SyncKeepRunning,
) -> Result<Evaluation, ValidationError> {
    let model_error = |error: RunError| ValidationError { model: configuration.model(), error };
    if configuration.is_from_scene {
        let cost = measure_cost(Model::Engine, scene, quick, keep_running).map_err(model_error)?;
        return Ok(Evaluation::Done { differences: Some(Box::new(validation.differences.clone())), cost });
    }
    let predicted = configuration.predicted_steps(scene, validation.engine.outcome.work.steps);
    if let Some(steps) = predicted.filter(|&steps| steps > MAX_PREDICTED_STEPS) {
        return Ok(Evaluation::TooLong { steps });
    }
    let differences = match configuration.is_reference() {
        true => Ok(None),
        false => compare_with_reference(configuration, scene, &validation.reference, keep_running)
            .and_then(|first| worst_over_members(first, configuration, &validation.other_members, keep_running))
            .map(Some),
    };
    let timed = differences.and_then(|differences| {
        Ok((differences, measure_cost(configuration.model(), &configuration.apply(scene), quick, keep_running)?))
    });
    match timed {
        Ok((differences, cost)) => Ok(Evaluation::Done { differences: differences.map(Box::new), cost }),
        Err(error) if error.is_stop() => Err(model_error(error)),
        Err(error) => Ok(Evaluation::Failed { reason: error.to_string() }),
    }
}

/// Returns the worst differences of a configuration over its members. `first` are the differences of the scene itself.
fn worst_over_members(
    first: Differences,
    configuration: &SolverConfiguration,
    other_members: &[(Scene, Recording)],
    keep_running: SyncKeepRunning,
) -> Result<Differences, RunError> {
    other_members.iter().take(configuration.members.saturating_sub(1)).try_fold(first, |worst, (scene, reference)| {
        Ok(worst.worst(&compare_with_reference(configuration, scene, reference, keep_running)?))
    })
}

/// Returns the differences of a configuration from the reference of one member.
fn compare_with_reference(
    configuration: &SolverConfiguration,
    scene: &Scene,
    reference: &Recording,
    keep_running: SyncKeepRunning,
) -> Result<Differences, RunError> {
    let mut comparison = Comparison::new(reference, scene.bounds.until_s);
    let sampled = sampled_scene(configuration.model(), &configuration.apply(scene));
    let outcome = run(configuration.model(), &sampled, &mut Cancellable { sink: &mut comparison, keep_running })?;
    Ok(comparison.finish(&outcome))
}
