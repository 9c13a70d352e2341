//! Wall time of a solver configuration, next to that of the analytic model at its engineering preset.

use std::time::Instant;

use super::scene_sampled_at_steps;
use super::scenes::modify;
use crate::scene::{Preset, Scene};
use crate::trace::{Cancellable, KeepRunning};
use crate::trace::{Model, RunError, run};

/// Wall time spent on repeated runs of one configuration, s.
const TIMING_BUDGET_S: f64 = 0.2;
/// [`TIMING_BUDGET_S`] of a quick ladder.
const QUICK_TIMING_BUDGET_S: f64 = 0.03;
/// Maximum number of timed runs of one configuration.
const MAX_TIMED_RUNS: usize = 15;
/// Runs of the analytic model per timed run. Each takes a fraction of a millisecond.
const ANALYTIC_RUNS_PER_RUN: usize = 3;

/// Cost of a solver configuration without any output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Number of timed runs.
    pub runs: usize,
    /// Median wall time of the timed runs.
    pub wall_s: f64,
    /// Median wall time of the analytic model at its engineering preset, measured between the timed runs.
    pub analytic_wall_s: f64,
    pub steps: u64,
    /// Simulated time of one run.
    pub simulated_s: f64,
}

impl Cost {
    /// Ratio of simulated time to wall time.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated_s / self.wall_s
    }

    /// Ratio of the wall time to that of the analytic model at its engineering preset.
    pub fn analytic_factor(&self) -> f64 {
        self.wall_s / self.analytic_wall_s
    }
}

/// Measures the cost of a scene with one of the models: the median over the runs that fit into the time budget, at
/// least one. Sampling for a log is excluded, because its cost depends on the log rate and not on the solver
/// configuration. Ends early if `keep_running` returns false.
pub fn measure_cost(model: Model, scene: &Scene, quick: bool, keep_running: KeepRunning) -> Result<Cost, RunError> {
    let budget_s = if quick { QUICK_TIMING_BUDGET_S } else { TIMING_BUDGET_S };
    let scene = &scene_sampled_at_steps(scene);
    let engineering_scene = modify(scene, |scene| scene.apply_preset(Preset::Engineering));
    let (mut times, mut analytic_times) = (Vec::new(), Vec::new());
    let (mut steps, mut required_runs) = (0, 1);
    while times.len() < required_runs {
        let start = Instant::now();
        steps = count_steps(model, scene, keep_running)?;
        times.push(start.elapsed().as_secs_f64());
        if times.len() == 1 {
            required_runs = ((budget_s / times[0]) as usize).clamp(1, MAX_TIMED_RUNS);
        }
        for _ in 0..ANALYTIC_RUNS_PER_RUN {
            let start = Instant::now();
            count_steps(Model::Analytic, &engineering_scene, keep_running)?;
            analytic_times.push(start.elapsed().as_secs_f64());
        }
    }
    // The first run warms the caches and is discarded if there are enough others.
    if times.len() > 2 {
        times.remove(0);
    }
    let runs = times.len();
    let (wall_s, analytic_wall_s) = (median(times), median(analytic_times));
    Ok(Cost { runs, wall_s, analytic_wall_s, steps, simulated_s: scene.duration_s })
}

/// Returns the number of steps of a run without output.
fn count_steps(model: Model, scene: &Scene, keep_running: KeepRunning) -> Result<u64, RunError> {
    Ok(run(model, scene, &mut Cancellable { sink: &mut (), keep_running })?.work.steps)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
