//! An exhausted step budget ends a run of either model with the results up to that time.

use crate::support::cli::{directory, json, phalanx, stderr, variant};
use phalanx::integrator::{Failure, Reason};
use phalanx::trace::{Model, RunError};
use phalanx::{log, scene};

#[test]
fn an_exhausted_step_budget_is_reported_and_the_log_is_complete() {
    let directory = directory("budget_engine");
    let scene = variant(&directory, "budget.toml", "[engine]\nmax_steps = 50");
    let path = directory.join("run.mcap");
    let output = phalanx(&["run", &scene, "--model", "engine", "--json", "--log", path.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let run = json(&output);
    assert_eq!((&run["steps"], &run["completed"]), (&50.into(), &false.into()));
    let message = stderr(&output);
    assert!(message.contains("of 20 ms") && message.contains("budget of 50 steps"), "{message}");
    assert!(message.contains("`max_steps`") && message.contains("run.mcap"), "{message}");
    let reading = log::read_file(&path, &mut ()).expect("a log");
    assert!(reading.is_complete());
    assert_eq!(reading.last_s, run["end_s"].as_f64());
    assert!(reading.run_end.and_then(|ended| ended.stopped).is_some_and(|reason| reason.contains("budget of 50")));
}

/// The contact oscillates within each of a few long steps.
#[test]
fn contact_substeps_count_against_the_budget() {
    let directory = directory("budget_substeps");
    let ringing = "[contact]\ndamping = \"0.001 N*s/m\"\n[engine]\nstepping = \"fixed\"\nstep = \"1 ms\"";
    let text = std::fs::read_to_string(crate::support::cli::EXPERIMENT_95).expect("the anchor scene");
    let text = text.replace("[contact.friction]", &format!("{ringing}\n[contact.friction]"));
    let path = crate::support::cli::write(&directory, "ringing.toml", &text);
    let mut scene = scene::load(&path).expect("a scene");
    let unlimited_work = crate::support::checked_run::run(Model::Engine, &scene, &mut ())
        .map(|outcome| outcome.work)
        .unwrap_or_else(|error| match error {
            RunError::Simulation { partial_outcome, .. } => partial_outcome.work,
            error => panic!("{error}"),
        });
    assert!(unlimited_work.contact_substeps > 20 * unlimited_work.steps, "{unlimited_work:?}");
    // Small enough that the budget is exhausted before the last step.
    scene.engine.max_steps = unlimited_work.contact_substeps / 20;
    assert!(scene.engine.max_steps > unlimited_work.steps, "{unlimited_work:?}");
    match crate::support::checked_run::run(Model::Engine, &scene, &mut ()) {
        Err(RunError::Simulation {
            failure: Failure { reason: Reason::SubstepBudget { budget, steps }, .. },
            partial_outcome,
        }) => {
            assert_eq!(budget, 10 * scene.engine.max_steps);
            assert!(partial_outcome.work.steps == steps && partial_outcome.work.contact_substeps >= budget);
        }
        other => panic!("{other:?}"),
    }
}
