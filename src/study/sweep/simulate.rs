//! What runs of fingers and of grippers share: the simulation, its check, and the row of one that does not end.

use super::Study;
use super::row::{Cells, Row, Status};
use crate::check::check;
use crate::scene::{Scene, SceneError};
use crate::trace::While;
use crate::trace::{self, Outcome, RunError, Sink};

/// Why there is nothing to judge although the run is complete.
pub(super) const NO_SAMPLES: &str = "the run has no duration, so there is nothing to judge";

/// Simulates a scene and says in its row what `closing` finds in the sink and the outcome; checks it if the study asks for
/// that. `closing` returns why figures of a verdict are missing, which is the row's reason: no row lacks both. `None` if it was
/// told to stop.
pub(super) fn simulated<S: Sink>(
    study: &Study,
    run: u64,
    scene: &Scene,
    mut cells: Cells,
    mut sink: S,
    go_on: &(dyn Fn() -> bool + Sync),
    closing: impl FnOnce(&mut Cells, &S, &Outcome) -> Option<String>,
) -> Option<Row> {
    let outcome = match trace::run(study.model, scene, &mut While { sink: &mut sink, go_on }) {
        Ok(outcome) => outcome,
        Err(error) => return unfinished(cells, run, error),
    };
    let reason = closing(&mut cells, &sink, &outcome);
    cells.set("steps", outcome.work.steps as i64);
    if study.checked {
        let check = check(study.model, scene, go_on);
        cells.set("check", check.verdict.name());
        cells.set("check_error_rad", check.errors.path);
    }
    // A check that was broken off is not one.
    go_on().then(|| cells.row(run, Status::Completed, &reason.unwrap_or_default()))
}

/// The row of a run that did not get to its end.
fn unfinished(mut cells: Cells, run: u64, error: RunError) -> Option<Row> {
    if error.is_stop() {
        return None;
    }
    let reason = match error {
        RunError::Simulation { failure, so_far } => {
            cells.set("steps", so_far.work.steps as i64);
            format!("at {:.6} ms: {}", failure.time_s * 1e3, failure.reason)
        }
        RunError::Sink(error) => error.to_string(),
    };
    Some(cells.row(run, Status::Failed, &reason))
}

/// What is wrong with a scene, in one line: its place would be one in a text that nobody wrote.
pub(super) fn refusal(error: &SceneError) -> String {
    let messages: Vec<&str> = error.problems().iter().map(|problem| problem.message.as_str()).collect();
    if messages.is_empty() { error.to_string() } else { messages.join("; ") }
}
