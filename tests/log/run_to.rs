//! `run_to` and `run_into`: same log as the command line, with the end of the run; logs of modified scenes verify.

use std::fs;
use std::path::Path;

use phalanx::log::{LoggedRunError, read_file, run_into, run_to};
use phalanx::scene::{Profile, Scene, load, load_any};
use phalanx::trace::{FingerContact, Model, RunError};

use crate::support::cli::{directory, path_in, path_text, run_json, succeed};
use crate::support::replay::{DISC_SCENE, FINGER_SCENE};

fn finger() -> Scene {
    load(FINGER_SCENE).expect("a scene")
}

fn discs() -> Scene {
    load_any(DISC_SCENE).expect("a scene")
}

/// Log written by the command for a scene file named `scene.toml`, as for scenes in memory.
fn write_log_with_command(directory: &Path, scene: &str, model: Model) -> Vec<u8> {
    let [file, log] = ["scene.toml", "command.mcap"].map(|name| path_in(directory, name));
    fs::copy(scene, &file).expect("copied");
    succeed(&["run", &file, "--model", model.name(), "--log", &log]);
    fs::read(log).expect("the log")
}

/// Asserts that a log verifies and is complete.
fn assert_verifies(log: &Path) {
    let log = path_text(log);
    let verification = &run_json(&["replay", log, "--verify", "--json"])["verification"];
    assert_eq!((&verification["same"], &verification["complete"]), (&true.into(), &true.into()), "{verification:#}");
    let text = succeed(&["replay", log]);
    assert!(text.contains("\ncompleted, ") && !text.contains("NOT COMPLETE"), "{text}");
}

#[test]
fn writes_the_same_log_as_the_command() {
    let directory = directory("run_to_command");
    let path = directory.join("library.mcap");
    for (model, (file, scene)) in [Model::Analytic, Model::Engine]
        .into_iter()
        .flat_map(|model| [(FINGER_SCENE, finger()), (DISC_SCENE, discs())].map(|scene| (model, scene)))
    {
        let run = run_to(&scene, model, &path).expect("a run");
        let bytes = fs::read(&path).expect("a log");
        assert!(bytes == write_log_with_command(&directory, file, model), "{file} {model:?}");
        assert_verifies(&path);
        let (same, in_memory) = run_into(&scene, model, Vec::new()).expect("a run");
        assert!(same == run && in_memory == bytes, "{file} {model:?}");
    }
    let remaining = fs::read_dir(&directory).expect("a directory").map(|entry| entry.expect("an entry").file_name());
    assert!(remaining.into_iter().all(|name| !name.to_string_lossy().ends_with(".partial")));
}

#[test]
fn logs_of_modified_scenes_verify() {
    let directory = directory("run_to_changed");
    let path = directory.join("changed.mcap");
    let changes: [fn(&mut Scene); 4] = [
        |scene| scene.finger_mut().motor.actuation = Profile::Ramp { value: 0.7, rise_s: 1.3e-3 },
        |scene| scene.finger_mut().contact.distal.normal.exponent = 1.5,
        |scene| (scene.hand.gravity_m_s2, scene.duration_s) = ([1.0 / 3.0, -9.0], 7.1e-3),
        |scene| scene.hand.object = None,
    ];
    for change in changes {
        let mut scene = finger();
        change(&mut scene);
        for model in [Model::Analytic, Model::Engine] {
            let run = run_to(&scene, model, &path).expect("a run");
            assert_verifies(&path);
            assert_eq!(run.criteria.is_some(), scene.object().is_some());
            assert_eq!(run.outcome.finger_contact(FingerContact::Distal).first_s.is_some(), scene.object().is_some());
            assert!(run.check.is_some(), "a short run is checked");
        }
    }
    let mut scene = discs();
    let mechanism = scene.mechanism.as_mut().expect("discs");
    mechanism.bodies[0].name = "thrown".to_string();
    mechanism.bodies[0].mass_kg *= 1.03;
    mechanism.contacts[0].name = Some("thrown-anvil".to_string());
    scene.duration_s = 13.3e-3;
    let run = run_to(&scene, Model::Analytic, &path).expect("a run");
    assert!(run.rebounds[0].restitution().is_some_and(|ratio| ratio < 1.0), "{:?}", run.rebounds);
    assert_verifies(&path);
}

#[test]
fn stopped_run_is_an_error_and_its_log_contains_the_reason() {
    let directory = directory("run_to_stopped");
    let path = directory.join("stopped.mcap");
    let mut scene = finger();
    scene.integrator.max_steps = 40;
    let error = run_to(&scene, Model::Analytic, &path).expect_err("40 steps are not enough");
    let LoggedRunError::Run(RunError::Simulation { failure, partial_outcome }) = error else { panic!("{error}") };
    assert_eq!(partial_outcome.work.steps, 40);
    let reading = read_file(&path, &mut ()).expect("a log");
    let run_end = reading.run_end.expect("an end");
    assert_eq!(run_end.stopped, Some(failure.reason.to_string()));
    // The new run stops at the same step.
    succeed(&["replay", path_text(&path), "--verify", "--json"]);
}
