//! Step budgets end a run with what it has come to, whichever model runs and wherever its effort goes.

use crate::support::cli::{directory, json, phalanx, stderr, variant};
use phalanx::integrator::{Failure, Reason};
use phalanx::trace::{Model, RunError};
use phalanx::{log, scene};

#[test]
fn the_engine_says_when_its_steps_are_used_up_and_keeps_its_log() {
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
    assert!(reading.is_whole());
    assert_eq!(reading.last_s, run["end_s"].as_f64());
    assert!(reading.ended.and_then(|ended| ended.stopped).is_some_and(|reason| reason.contains("budget of 50")));
}

/// A surface that rings through each of a few long steps.
#[test]
fn contact_substeps_count_too() {
    let directory = directory("budget_substeps");
    let ringing = "[contact]\ndamping = \"0.001 N*s/m\"\n[engine]\nstepping = \"fixed\"\nstep = \"1 ms\"";
    let text = std::fs::read_to_string(crate::support::cli::ANCHOR).expect("the anchor scene");
    let text = text.replace("[contact.friction]", &format!("{ringing}\n[contact.friction]"));
    let path = crate::support::cli::write(&directory, "ringing.toml", &text);
    let mut scene = scene::load(&path).expect("a scene");
    let free =
        crate::support::held::run(Model::Engine, &scene, &mut ()).map(|outcome| outcome.work).unwrap_or_else(|error| {
            match error {
                RunError::Simulation { so_far, .. } => so_far.work,
                error => panic!("{error}"),
            }
        });
    assert!(free.contact_substeps > 20 * free.steps, "{free:?}");
    // Not so near to all of them that the last step alone goes beyond.
    scene.engine.max_steps = free.contact_substeps / 20;
    assert!(scene.engine.max_steps > free.steps, "{free:?}");
    match crate::support::held::run(Model::Engine, &scene, &mut ()) {
        Err(RunError::Simulation {
            failure: Failure { reason: Reason::SubstepBudget { budget, steps }, .. },
            so_far,
        }) => {
            assert_eq!(budget, 10 * scene.engine.max_steps);
            assert!(so_far.work.steps == steps && so_far.work.contact_substeps >= budget);
        }
        other => panic!("{other:?}"),
    }
}
