//! One call that runs and logs: the log is that of the command line, says how the run ended, and verifies, whatever was
//! changed in memory.

use std::fs;
use std::path::Path;

use phalanx::log::{LogError, LoggedRunError, read_any_file, run_into, run_to};
use phalanx::scene::{Actuation, Scene, load, load_any};
use phalanx::shape::{Shape, reach};
use phalanx::trace::{Model, RunError, Site};

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use crate::support::replay::{DISCS, FINGER};

fn finger() -> Scene {
    load(FINGER).expect("a scene")
}

fn discs() -> Scene {
    load_any(DISCS).expect("a scene")
}

/// The log that the command writes of a scene of the name that a scene in memory has.
fn of_the_command(directory: &Path, scene: &str, model: Model) -> Vec<u8> {
    let (file, log) = (directory.join("scene.toml"), directory.join("command.mcap"));
    fs::copy(scene, &file).expect("copied");
    let [file, log] = [file, log].map(|path| path.to_str().expect("text").to_string());
    let output = phalanx(&["run", &file, "--model", model.name(), "--log", &log]);
    assert!(output.status.success(), "{}", stderr(&output));
    fs::read(log).expect("the log")
}

/// A log verifies, and nothing in it or of it is missing.
fn is_complete(log: &Path) {
    let log = log.to_str().expect("text");
    let output = phalanx(&["replay", log, "--verify", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let found = &json(&output)["verification"];
    assert_eq!((&found["same"], &found["complete"]), (&true.into(), &true.into()), "{found:#}");
    let text = phalanx(&["replay", log]);
    assert!(stdout(&text).contains("\ncompleted, "), "{}", stdout(&text));
    assert!(!stdout(&text).contains("NOT COMPLETE"), "{}", stdout(&text));
}

#[test]
fn it_writes_the_log_of_the_command() {
    let directory = directory("run_to_command");
    for model in [Model::Analytic, Model::Engine] {
        let path = directory.join("library.mcap");
        run_to(&finger(), model, &path).expect("a run");
        assert!(fs::read(&path).expect("a log") == of_the_command(&directory, FINGER, model), "{model:?}");
        is_complete(&path);
        run_to(&discs(), model, &path).expect("a run");
        assert!(fs::read(&path).expect("a log") == of_the_command(&directory, DISCS, model), "{model:?}");
        is_complete(&path);
    }
    let left = fs::read_dir(&directory).expect("a directory").map(|entry| entry.expect("an entry").file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().ends_with(".partial")));
}

#[test]
fn a_scene_that_was_changed_is_logged_whole_and_verifies() {
    let directory = directory("run_to_changed");
    let path = directory.join("changed.mcap");
    let changes: [fn(&mut Scene); 4] = [
        |scene| scene.finger_mut().motor.actuation = Actuation::Ramp { torque_n_m: 0.7, rise_s: 1.3e-3 },
        |scene| scene.finger_mut().contact.distal.normal.exponent = 1.5,
        |scene| (scene.system.gravity_m_s2, scene.duration_s) = ([1.0 / 3.0, -9.0], 7.1e-3),
        |scene| scene.system.discs.clear(),
    ];
    for change in changes {
        let mut scene = finger();
        change(&mut scene);
        for model in [Model::Analytic, Model::Engine] {
            let run = run_to(&scene, model, &path).expect("a run");
            is_complete(&path);
            assert_eq!(run.criteria.is_some(), scene.object().is_some());
            assert_eq!(run.outcome.site(Site::Distal).first_s.is_some(), scene.object().is_some());
            assert!(run.check.is_some(), "a short run is checked");
        }
    }
    let mut scene = discs();
    scene.system.discs[0].shape = Shape::Disc { radius_m: 1.03 * reach(&scene.system.discs[0].shape) };
    scene.system.discs[1].name = "thrown".to_string();
    scene.duration_s = 13.3e-3;
    let run = run_to(&scene, Model::Analytic, &path).expect("a run");
    assert!(run.rebounds[0].restitution().is_some_and(|kept| kept < 1.0), "{:?}", run.rebounds);
    is_complete(&path);
}

#[test]
fn into_bytes_it_writes_the_same() {
    let directory = directory("run_to_bytes");
    let path = directory.join("run.mcap");
    let (scene, model) = (finger(), Model::Analytic);
    let run = run_to(&scene, model, &path).expect("a run");
    let (same, bytes) = run_into(&scene, model, Vec::new()).expect("a run");
    assert_eq!(same, run);
    assert!(bytes == fs::read(&path).expect("a log"));
}

#[test]
fn a_run_that_stops_is_an_error_and_its_log_says_why() {
    let directory = directory("run_to_stopped");
    let path = directory.join("stopped.mcap");
    let mut scene = finger();
    scene.integrator.max_steps = 40;
    let error = run_to(&scene, Model::Analytic, &path).expect_err("40 steps are not enough");
    let LoggedRunError::Run(RunError::Simulation { failure, so_far }) = error else { panic!("{error}") };
    assert_eq!(so_far.work.steps, 40);
    let reading = read_any_file(&path, &mut ()).expect("a log");
    let ended = reading.ended.expect("an end");
    assert_eq!(ended.stopped, Some(failure.reason.to_string()));
    // Verification knows that it stops, and finds the same stop.
    let output = phalanx(&["replay", path.to_str().expect("text"), "--verify", "--json"]);
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn what_is_no_log_is_left_alone() {
    let directory = directory("run_to_refused");
    let path = directory.join("thesis.tex");
    fs::write(&path, "years of work").expect("written");
    let error = run_to(&finger(), Model::Analytic, &path).expect_err("refused");
    assert!(matches!(error, LoggedRunError::Log(LogError::NotALog { .. })), "{error}");
    assert_eq!(fs::read_to_string(&path).expect("still there"), "years of work");
    let error = run_to(&finger(), Model::Analytic, directory.join("not/there.mcap")).expect_err("refused");
    assert!(error.to_string().contains("mkdir -p"), "{error}");
}
