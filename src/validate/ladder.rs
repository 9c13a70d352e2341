//! The ladder: other configurations of both models, their errors and their wall times.

use std::time::Instant;

use super::configuration::{Cost, LadderRow, MAX_PREDICTED_STEPS, SolverConfiguration, Status, ladder_configurations};
use super::scenes::{compared_scene, modify, scene_sampled_at_steps};
use super::validation::{Validation, ValidationError, compare_with_reference, worst_over_members};
use crate::scene::{Preset, Scene};
use crate::trace::{Cancellable, Model, RunError, run};
use phalanx_parallel::{KeepRunning, Monitor};

/// Default time limit of a ladder, s. It suffices for all configurations of a finger except the shortest fixed steps.
pub const LADDER_TIME_S: f64 = 10.0;
/// Wall time spent on repeated runs of one configuration, s.
const TIMING_BUDGET_S: f64 = 0.2;
/// [`TIMING_BUDGET_S`] of a quick ladder.
const QUICK_TIMING_BUDGET_S: f64 = 0.03;
/// Maximum number of timed runs of one configuration.
const MAX_TIMED_RUNS: usize = 15;
/// Runs of the analytic model per timed run. Each takes a fraction of a millisecond.
const ANALYTIC_RUNS_PER_RUN: usize = 3;

/// Options that select the configurations of a ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LadderOptions {
    /// Whether to omit configurations that take long, regardless of the time limit.
    pub quick: bool,
    /// Time limit, s. A configuration is started only if the expected total time is below it.
    pub time_s: f64,
}

/// Adds the ladder to a validation: other configurations of both models, which are compared with the same references
/// and timed, but not judged. They run sequentially, because their times are measured, in the order of their predicted
/// number of steps. The monitor counts the configurations and names the family of the current one.
///
/// # Errors
/// Returns an error if the scene's own configuration has failed, or if the monitor stops the ladder. A failure of any
/// other configuration is reported in its row.
pub fn run_ladder(
    validation: &mut Validation,
    full_scene: &Scene,
    options: LadderOptions,
    monitor: &Monitor<'_>,
) -> Result<(), ValidationError> {
    let scene = &compared_scene(full_scene);
    let configurations = ladder_configurations(scene, options.quick);
    let start = Instant::now();
    monitor.start(configurations.len(), "");
    let scene_steps = validation.engine.outcome.work.steps;
    // The scene's own configuration and the reference are always run, because their times are always reported.
    let is_always_run = |it: &SolverConfiguration| it.is_from_scene || it.is_reference();
    let steps = |it: &SolverConfiguration| match it.predicted_steps(scene, scene_steps) {
        _ if is_always_run(it) => -1.0,
        predicted => predicted.map_or(0.0, |steps| steps * it.members as f64),
    };
    let mut order: Vec<(usize, SolverConfiguration)> = configurations.into_iter().enumerate().collect();
    order.sort_by(|(_, a), (_, b)| steps(a).total_cmp(&steps(b)));
    let mut rows = Vec::with_capacity(order.len());
    // Wall time per step of the engine at the scene's settings.
    let mut step_wall_s = 0.0;
    for (index, configuration) in order {
        let family = configuration.family.name();
        monitor.advance(0, family);
        let remaining_s = options.time_s - start.elapsed().as_secs_f64();
        let has_time = remaining_s > 0.0 && steps(&configuration) * step_wall_s < remaining_s;
        let row = match is_always_run(&configuration) || has_time {
            true => evaluate(configuration, scene, validation, options.quick, monitor.keep_running())?,
            false => {
                let reason = "beyond the time limit of the ladder".to_string();
                LadderRow::new(configuration, Status::NoTime, Some(reason))
            }
        };
        if let (true, Some(wall_s), Some(steps)) = (row.is_from_scene, row.cost.wall_s, row.cost.steps) {
            step_wall_s = wall_s / steps.max(1) as f64;
        }
        rows.push((index, row));
        monitor.advance(1, family);
    }
    rows.sort_by_key(|(index, _)| *index);
    validation.ladder = rows.into_iter().map(|(_, row)| row).collect();
    Ok(())
}

/// Compares and times one configuration.
fn evaluate(
    configuration: SolverConfiguration,
    scene: &Scene,
    validation: &Validation,
    quick: bool,
    keep_running: KeepRunning,
) -> Result<LadderRow, ValidationError> {
    let predicted = configuration.predicted_steps(scene, validation.engine.outcome.work.steps);
    if let Some(steps) = predicted.filter(|&steps| steps > MAX_PREDICTED_STEPS && !configuration.is_from_scene) {
        let reason = format!("would take {steps:.1e} steps");
        return Ok(LadderRow::new(configuration, Status::TooLong, Some(reason)));
    }
    let differences = match (configuration.is_from_scene, configuration.is_reference()) {
        (true, _) => Ok(Some(validation.differences.clone())),
        (_, true) => Ok(None),
        _ => compare_with_reference(&configuration, scene, &validation.reference, keep_running)
            .and_then(|first| worst_over_members(first, &configuration, &validation.other_members, keep_running))
            .map(Some),
    };
    let model = configuration.model();
    let timed = differences.and_then(|differences| {
        Ok((differences, measure_cost(model, &configuration.apply(scene), quick, keep_running)?))
    });
    match timed {
        Ok((differences, cost)) => {
            Ok(LadderRow { differences, cost, ..LadderRow::new(configuration, Status::Done, None) })
        }
        Err(error) if error.is_stop() || configuration.is_from_scene => Err(ValidationError { model, error }),
        Err(error) => Ok(LadderRow::new(configuration, Status::Failed, Some(error.to_string()))),
    }
}

/// Measures the cost of a scene with one of the models: the median over the runs that fit into the time budget, at
/// least one. Sampling for a log is excluded, because its cost depends on the log rate and not on the solver
/// configuration. Ends early if `keep_running` returns false.
fn measure_cost(model: Model, scene: &Scene, quick: bool, keep_running: KeepRunning) -> Result<Cost, RunError> {
    let budget_s = if quick { QUICK_TIMING_BUDGET_S } else { TIMING_BUDGET_S };
    let scene = &scene_sampled_at_steps(scene);
    let engineering_scene = modify(scene, |scene| scene.apply_preset(Preset::Engineering));
    let timed_steps = |model: Model, scene: &Scene, times: &mut Vec<f64>| {
        let start = Instant::now();
        let outcome = run(model, scene, &mut Cancellable { sink: &mut (), keep_running })?;
        times.push(start.elapsed().as_secs_f64());
        Ok::<_, RunError>(outcome.work.steps)
    };
    let (mut times, mut analytic_times) = (Vec::new(), Vec::new());
    let (mut steps, mut required_runs) = (0, 1);
    while times.len() < required_runs {
        steps = timed_steps(model, scene, &mut times)?;
        if times.len() == 1 {
            required_runs = ((budget_s / times[0]) as usize).clamp(1, MAX_TIMED_RUNS);
        }
        for _ in 0..ANALYTIC_RUNS_PER_RUN {
            timed_steps(Model::Analytic, &engineering_scene, &mut analytic_times)?;
        }
    }
    // The first run warms the caches and is discarded if there are enough others.
    if times.len() > 2 {
        times.remove(0);
    }
    let timed_runs = times.len();
    let [wall_s, analytic_wall_s] = [times, analytic_times].map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    Ok(Cost {
        steps: Some(steps),
        wall_s: Some(wall_s),
        timed_runs: Some(timed_runs),
        real_time_factor: Some(scene.duration_s / wall_s),
        analytic_factor: Some(wall_s / analytic_wall_s),
    })
}
