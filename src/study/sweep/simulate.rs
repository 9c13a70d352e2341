//! Simulation of a run of a finger or a gripper, its check, and the rows of failed runs.

use super::Study;
use super::row::{Cells, Row, Status};
use crate::check::check;
use crate::scene::{Scene, SceneError};
use crate::trace::Cancellable;
use crate::trace::{self, Outcome, RunError, Sink};

/// Reason for a missing verdict of a completed run without samples.
pub(super) const NO_SAMPLES: &str = "the run has no duration, so it has no verdict";

/// Simulates a scene, checks the run if the study requires it, and returns its row; `None` if it was interrupted.
/// `set_results` sets the cells from the sink and the outcome and returns the reason if figures or the verdict are
/// missing.
pub(super) fn simulate_row<S: Sink>(
    study: &Study,
    run: u64,
    scene: &Scene,
    mut cells: Cells,
    mut sink: S,
    keep_running: &(dyn Fn() -> bool + Sync),
    set_results: impl FnOnce(&mut Cells, &S, &Outcome) -> Option<String>,
) -> Option<Row> {
    let outcome = match trace::run(study.model, scene, &mut Cancellable { sink: &mut sink, keep_running }) {
        Ok(outcome) => outcome,
        Err(error) => return failed_row(cells, run, error),
    };
    let reason = set_results(&mut cells, &sink, &outcome);
    cells.set("steps", outcome.work.steps as i64);
    if study.checked {
        let check = check(study.model, scene, keep_running);
        cells.set("check", check.verdict.name());
        cells.set("check_error_rad", check.errors.path);
    }
    // An interrupted check is invalid.
    keep_running().then(|| cells.row(run, Status::Completed, &reason.unwrap_or_default()))
}

/// Row of a run that did not finish; `None` if it was interrupted.
fn failed_row(mut cells: Cells, run: u64, error: RunError) -> Option<Row> {
    if error.is_stop() {
        return None;
    }
    let reason = match error {
        RunError::Simulation { failure, partial_outcome } => {
            cells.set("steps", partial_outcome.work.steps as i64);
            format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason)
        }
        RunError::Sink(error) => error.to_string(),
    };
    Some(cells.row(run, Status::Failed, &reason))
}

/// Problems of a scene in one line, without their location in the generated text.
pub(super) fn problem_messages(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}
