//! Runs of a study: their parallel execution, and the simulation of a scene for a row.

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::figures::{Extrema, Figures, SceneFigures};
use super::hands::{FINGER_FIGURES, FingerRun, GRIPPER_FIGURES, GripperRun, Statics};
use super::results::{Cells, Row, Status};
use super::{Filter, Study};
use crate::check::{check_run, run_and_record};
use crate::criteria::{RunCriteriaTracker, StaticGrasp, Tracker, scene_static_grasp};
use crate::scene::{self, Scene, SceneError};
use crate::statics::{Equilibrium, form_closure};
use crate::study::KeepRunning;
use crate::trace::{self, Cancellable, Outcome, RunError, Sink};
use phalanx_parallel::thread_pool;

/// Statistics of one invocation of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStats {
    /// Number of runs performed in this invocation, without those finished earlier.
    pub runs: u64,
    pub threads: usize,
    pub wall_s: f64,
    /// Whether all requested runs are finished.
    pub complete: bool,
}

/// Performs the runs of a range that are not in `done`, and passes each row to `on_row` when it is finished, in any
/// order. Stops when `keep_running` or `on_row` returns false; an interrupted run has no row. With `threads` = 0, there
/// is one thread per core.
///
/// A free thread takes the next run, so that rows are finished nearly in order. It calls `on_row` itself, so that no
/// other thread has to be woken.
pub fn run_while(
    study: &Study,
    threads: usize,
    runs: RangeInclusive<u64>,
    done: &HashSet<u64>,
    keep_running: KeepRunning<'_>,
    on_row: impl FnMut(Row) -> bool + Send,
) -> RunStats {
    let start = Instant::now();
    let runs = *runs.start()..=study.runs().min(*runs.end());
    let total = (runs.end() + 1).saturating_sub(*runs.start());
    let missing = total - done.iter().filter(|run| runs.contains(run)).count() as u64;
    let pool = thread_pool(threads, usize::try_from(missing).unwrap_or(usize::MAX));
    let (stopped, finished, on_row) = (AtomicBool::new(false), AtomicU64::new(0), Mutex::new(on_row));
    let may_continue = || !stopped.load(Ordering::Relaxed) && keep_running();
    // `None` stops all threads.
    let work = |run| {
        let row = may_continue().then(|| run_one(study, run, &may_continue))??;
        // A poisoned lock means that `on_row` panicked on another thread.
        if !on_row.lock().ok()?(row) {
            stopped.store(true, Ordering::Relaxed);
        }
        finished.fetch_add(1, Ordering::Relaxed);
        Some(())
    };
    pool.install(|| runs.filter(|run| !done.contains(run)).par_bridge().try_for_each(work));
    let (runs, threads) = (finished.into_inner(), pool.current_num_threads());
    RunStats { runs, threads, wall_s: start.elapsed().as_secs_f64(), complete: runs == missing }
}

/// Performs one run of a study; `None` if it was interrupted.
fn run_one(study: &Study, run: u64, keep_running: KeepRunning<'_>) -> Option<Row> {
    let values = study.field_values(run);
    let text = study.template.fill(&values);
    let cells = Cells::new(study, run, values.into_iter().map(|value| value.value));
    let mut scene = match scene::parse_any(&text, "run.toml") {
        Ok(scene) => scene,
        Err(error) => return Some(cells.row(Status::Refused, &problem_messages(&error))),
    };
    if let Some(preset) = study.preset {
        scene.apply_preset(preset);
    }
    match (&study.results.figures, scene.finger_count()) {
        (Figures::Hand(2), 2) => run_gripper(study, &scene, cells, keep_running),
        (Figures::Hand(1), 1) => run_finger(study, &scene, cells, keep_running),
        (Figures::Scene(figures), 0) if figures.fit(&scene) => run_scene(study, figures, &scene, cells, keep_running),
        // An axis changes the kind of scene, or the number of its parts.
        _ => Some(cells.row(Status::Refused, OTHER_PARTS)),
    }
}

/// Reason why a run has no figures.
const OTHER_PARTS: &str = "the scene has other bodies, joints, actuators or contacts than the first one, so it has other columns; make a study of its own";

/// Problems of a scene in one line, without their location in the generated text.
pub(in crate::study) fn problem_messages(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}

/// Simulates a scene, checks the run if the study requires it, and returns its row; `None` if it was interrupted.
/// `set_results` sets the cells from the sink and the outcome and returns the reason if figures are missing; it returns
/// no result for a run without samples.
fn simulate_row<S: Sink>(
    study: &Study,
    scene: &Scene,
    mut cells: Cells,
    sink: S,
    keep_running: KeepRunning<'_>,
    set_results: impl FnOnce(&mut Cells, S, &Outcome) -> Option<String>,
) -> Option<Row> {
    let mut both = (sink, Extrema::of(study.results.extrema.clone()));
    let mut cancellable = Cancellable { sink: &mut both, keep_running };
    let (result, path) = if study.checked {
        let (result, path) = run_and_record(study.model, scene, &mut cancellable);
        (result, Some(path))
    } else {
        (trace::run(study.model, scene, &mut cancellable), None)
    };
    let outcome = match result {
        Ok(outcome) => outcome,
        Err(error) if error.is_stop() => return None,
        Err(RunError::Simulation { failure, partial_outcome }) => {
            cells.set("steps", partial_outcome.work.steps as i64);
            let reason = format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason);
            return Some(cells.row(Status::Failed, &reason));
        }
        Err(RunError::Sink(error)) => return Some(cells.row(Status::Failed, &error.to_string())),
    };
    let (sink, extrema) = both;
    let reason = set_results(&mut cells, sink, &outcome);
    extrema.values().into_iter().for_each(|(name, value)| cells.set_exactly(&name, value));
    let reason = reason.unwrap_or_else(|| "the run has no duration, so it has no verdict".to_string());
    cells.set("steps", outcome.work.steps as i64);
    if let Some(path) = path {
        let check = check_run(study.model, scene, path, keep_running);
        cells.set("check", check.verdict.name());
        cells.set("check_error_rad", check.errors.path);
    }
    // An interrupted check is invalid.
    keep_running().then(|| cells.row(Status::Completed, &reason))
}

fn run_finger(study: &Study, scene: &Scene, mut cells: Cells, keep_running: KeepRunning<'_>) -> Option<Row> {
    let grasp = scene_static_grasp(scene);
    let is_closed = |grasp: &StaticGrasp| match form_closure(&scene.finger().linkage, &grasp.end) {
        Ok(closure) => Ok(closure.closed),
        Err(error) => Err(error.to_string()),
    };
    let statics = Statics { form_closed: grasp.as_ref().map_err(String::clone).and_then(is_closed), grasp };
    let design = FingerRun { scene, statics: &statics, closing: None };
    FINGER_FIGURES.design.iter().for_each(|figure| cells.set(&figure.name, (figure.value)(&design)));
    if let Some(reason) = filter_reason(&study.filter, &statics) {
        return Some(cells.row(Status::Filtered, &reason));
    }
    let grasp = statics.grasp.as_ref().ok();
    let tracker = grasp.map(|grasp| Tracker::new(grasp.final_angles()));
    simulate_row(study, scene, cells, tracker, keep_running, |cells, tracker, outcome| {
        if let Some((tracker, grasp)) = tracker.zip(grasp) {
            let closing = Some((tracker.criteria(grasp.static_forces_n())?, outcome));
            let run = FingerRun { closing, ..design };
            FINGER_FIGURES.run.iter().for_each(|figure| cells.set(&figure.name, (figure.value)(&run)));
        }
        Some(missing_statics_reason(&statics))
    })
}

/// Reasons for missing static figures, and for a missing class if there is no grasp; empty if there are none.
fn missing_statics_reason(statics: &Statics) -> String {
    let grasp = match &statics.grasp {
        Ok(grasp) => grasp,
        Err(reason) => return reason.clone(),
    };
    let forces = grasp.forces.as_ref().err().map(|error| format!("no static forces: {error}"));
    let form_closure = statics.form_closed.as_ref().err().map(|error| format!("no form closure: {error}"));
    forces.into_iter().chain(form_closure).collect::<Vec<_>>().join("; ")
}

/// Returns the reason why the filter excludes a run, if it does.
fn filter_reason(filter: &Filter, statics: &Statics) -> Option<String> {
    let forces = statics.grasp.as_ref().map_err(String::clone);
    let forces = forces.and_then(|grasp| grasp.forces.as_ref().map_err(ToString::to_string));
    let tests = [
        ("force positive", filter.force_positive, forces.clone().map(Equilibrium::is_force_positive)),
        ("palm force positive", filter.palm_force_positive, forces.map(Equilibrium::is_palm_force_positive)),
        ("form-closed", filter.form_closed, statics.form_closed.clone()),
    ];
    tests.into_iter().find_map(|(name, required, actual)| match (required?, actual) {
        (required, Ok(actual)) if required == actual => None,
        (true, Ok(_)) => Some(format!("not {name}")),
        (false, Ok(_)) => Some(name.to_string()),
        (_, Err(reason)) => Some(format!("cannot determine whether it is {name}: {reason}")),
    })
}

fn run_scene(
    study: &Study,
    figures: &SceneFigures,
    scene: &Scene,
    cells: Cells,
    keep_running: KeepRunning<'_>,
) -> Option<Row> {
    let tracker = SceneFigures::tracker(scene);
    simulate_row(study, scene, cells, tracker, keep_running, |cells, tracker, outcome| {
        let values = figures.values(scene, &tracker, outcome);
        values.into_iter().for_each(|(name, value)| cells.set_exactly(name, value));
        Some(String::new())
    })
}

fn run_gripper(study: &Study, scene: &Scene, mut cells: Cells, keep_running: KeepRunning<'_>) -> Option<Row> {
    let figures = &GRIPPER_FIGURES;
    let design = GripperRun { scene, grasp: None };
    figures.all().for_each(|figure| cells.set(&figure.name, (figure.value)(&design)));
    let tracker = RunCriteriaTracker::for_scene(scene);
    simulate_row(study, scene, cells, tracker, keep_running, |cells, tracker, outcome| {
        let found = tracker.finish(true);
        let overlap_m = found.overlaps.iter().map(|overlap| overlap.depth_m).fold(0.0, f64::max);
        let run = GripperRun { scene, grasp: Some((found.grasp?, overlap_m, outcome)) };
        figures.run.iter().for_each(|figure| cells.set(&figure.name, (figure.value)(&run)));
        Some(String::new())
    })
}
