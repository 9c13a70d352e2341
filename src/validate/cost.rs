//! Wall time of a setting, beside that of the everyday analytic run.

use std::time::Instant;

use super::steps_only;
use super::subject::with;
use crate::scene::{Preset, Scene};
use crate::trace::{GoOn, While};
use crate::trace::{Model, RunError, run};

/// Time spent on repeating one setting, in earnest and in haste, and how often at most.
const PATIENCE_S: f64 = 0.2;
const QUICK_PATIENCE_S: f64 = 0.03;
const MOST_RUNS: usize = 15;
/// Runs of the analytic model per timed run: one is over in a fraction of a millisecond.
const BESIDE: usize = 3;

/// What a setting costs, alone and with nothing listening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Timed runs; the wall time is their median.
    pub runs: usize,
    pub wall_s: f64,
    /// Median wall time of the analytic model at its engineering preset, measured between those runs.
    pub analytic_wall_s: f64,
    pub steps: u64,
    /// Simulated time of one run.
    pub simulated_s: f64,
}

impl Cost {
    /// Simulated time over wall time.
    pub fn real_time_factor(&self) -> f64 {
        self.simulated_s / self.wall_s
    }

    /// Wall time over that of the everyday analytic run.
    pub fn analytic_factor(&self) -> f64 {
        self.wall_s / self.analytic_wall_s
    }
}

/// Times a scene with one of the models: the median of as many runs as there is patience for, at least one. Reading off
/// a grid of times for a log is not part of it: that costs what the log rate says, whatever the settings. Ends
/// early when `go_on` says no.
pub fn cost(model: Model, scene: &Scene, quick: bool, go_on: GoOn) -> Result<Cost, RunError> {
    let patience_s = if quick { QUICK_PATIENCE_S } else { PATIENCE_S };
    let scene = &steps_only(scene);
    let everyday = with(scene, |scene| scene.integrate_by(Preset::Engineering));
    let (mut times, mut beside) = (Vec::new(), Vec::new());
    let (mut steps, mut wanted) = (0, 1);
    while times.len() < wanted {
        let start = Instant::now();
        steps = steps_of(model, scene, go_on)?;
        times.push(start.elapsed().as_secs_f64());
        if times.len() == 1 {
            wanted = ((patience_s / times[0]) as usize).clamp(1, MOST_RUNS);
        }
        for _ in 0..BESIDE {
            let start = Instant::now();
            steps_of(Model::Analytic, &everyday, go_on)?;
            beside.push(start.elapsed().as_secs_f64());
        }
    }
    // The first run warms caches; where there are others it does not count.
    if times.len() > 2 {
        times.remove(0);
    }
    let runs = times.len();
    let (wall_s, analytic_wall_s) = (median(times), median(beside));
    Ok(Cost { runs, wall_s, analytic_wall_s, steps, simulated_s: scene.duration_s })
}

/// Steps of a run with nothing listening.
fn steps_of(model: Model, scene: &Scene, go_on: GoOn) -> Result<u64, RunError> {
    Ok(run(model, scene, &mut While { sink: &mut (), go_on })?.work.steps)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
