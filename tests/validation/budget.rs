//! An exhausted step budget ends a run of either model with the results up to that time.

use crate::hard_scenes::load;
use crate::support::checked_run::run;
use crate::support::cli::{assert_contains, assert_status, directory, json, path_in, stderr, variant};
use phalanx::integrator::{Failure, Reason};
use phalanx::log;
use phalanx::scene::Stepping;
use phalanx::trace::{Model, RunError};

#[test]
fn an_exhausted_step_budget_is_reported_and_the_log_is_complete() {
    let directory = directory("budget_engine");
    let scene = variant(&directory, "budget.toml", "[engine]\nmax_steps = 50");
    let path = path_in(&directory, "run.mcap");
    let output = assert_status(&["run", &scene, "--model", "engine", "--json", "--log", &path], 3, &[]);
    let run = json(&output);
    assert_eq!((&run["steps"], &run["completed"]), (&50.into(), &false.into()));
    assert_contains(stderr(&output), &["of 20 ms", "budget of 50 steps", "`max_steps`", "run.mcap"]);
    let reading = log::read_file(path.as_ref(), &mut ()).expect("a log");
    assert!(reading.is_complete());
    assert_eq!(reading.last_s, run["end_s"].as_f64());
    assert!(reading.run_end.and_then(|ended| ended.stopped).is_some_and(|reason| reason.contains("budget of 50")));
}

/// The contact oscillates within each of a few long steps.
#[test]
fn contact_substeps_count_against_the_budget() {
    let mut scene = load("experiment-95");
    for law in scene.finger_mut().contact.both_mut() {
        law.normal = law.normal.with_damping_max(1e-3);
    }
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-3 };
    let unlimited_work = match run(Model::Engine, &scene, &mut ()) {
        Ok(outcome) => outcome.work,
        Err(RunError::Simulation { partial_outcome, .. }) => partial_outcome.work,
        Err(error) => panic!("{error}"),
    };
    assert!(unlimited_work.contact_substeps > 20 * unlimited_work.steps, "{unlimited_work:?}");
    // Small enough that the budget is exhausted before the last step.
    scene.engine.max_steps = unlimited_work.contact_substeps / 20;
    assert!(scene.engine.max_steps > unlimited_work.steps, "{unlimited_work:?}");
    match run(Model::Engine, &scene, &mut ()) {
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
