//! `phalanx run`: printed output and logs.

use std::collections::BTreeMap;
use std::fs;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_status, directory, json, path_in, path_text, phalanx, stderr, succeed,
    succeed_json, variant,
};
use foxglove::Decode;
use mcap::{MessageStream, Summary};
use serde_json::{Value, json};

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"));
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

/// Asserts the values at paths (JSON pointers) of a document.
#[track_caller]
fn assert_values<const N: usize>(document: &Value, expected: [(&str, Value); N]) {
    for (path, value) in expected {
        assert_eq!(document.pointer(path), Some(&value), "{path}");
    }
}

#[track_caller]
fn assert_positive(document: &Value, paths: &[&str]) {
    for path in paths {
        assert!(document.pointer(path).and_then(Value::as_f64).is_some_and(|value| value > 0.0), "{path}");
    }
}

/// Settings in the metadata of a log.
fn settings(log: &str) -> BTreeMap<String, String> {
    let bytes = fs::read(log).expect("a log");
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("readable").metadata
}

#[test]
fn experiment_95_as_json_and_as_summary() {
    let output = phalanx(&["run", EXPERIMENT_95, "--json"]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""), "no progress without a terminal");
    let run = json(&output);
    assert_values(
        &run,
        [
            ("/scene", json!("experiment-95")),
            ("/model", json!("analytic")),
            ("/duration_s", json!(0.02)),
            ("/completed", json!(true)),
            ("/contacts/proximal/touchdowns", json!(1)),
            ("/criteria/rebound_percent", json!(0.0)),
            ("/criteria/class", json!("stable")),
        ],
    );
    assert!(run["steps"].as_u64().expect("a count") > 20);
    assert_positive(&run, &["/wall_s"]);
    // Expected values: an independent high-accuracy integration (1-model §1.8).
    assert_near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 1e-6);
    assert_near(&run["final"]["q21_rad"], 65.019991f64.to_radians(), 1e-6);
    for (name, first_s, normal_n) in [("proximal", 4.501315e-3, 23.6092), ("distal", 6.883746e-3, 8.2573)] {
        assert_near(&run["contacts"][name]["first_s"], first_s, 1e-7);
        assert_near(&run["contacts"][name]["final_normal_n"], normal_n, 2e-3);
    }
    assert_near(&run["criteria"]["tts_s"], 6.883746e-3, 1e-6);
    let parts = ["experiment-95", "analytic", "2.0887", "65.0199", "4.501315", "6.883746", "23.609", "8.257", "stable"];
    assert_contains(&succeed(&["run", EXPERIMENT_95]), &parts);
}

#[test]
fn log_contains_run_and_scene_and_is_reproducible() {
    let directory = directory("cli_run_log");
    let logs = ["a.mcap", "b.mcap"].map(|name| {
        let path = directory.join(name).display().to_string();
        assert_eq!(succeed_json(&["run", EXPERIMENT_95, "--log", &path])["log"], path);
        fs::read(path).expect("a log")
    });
    assert_eq!(logs[0], logs[1]);
    let summary = Summary::read(&logs[0]).expect("readable").expect("indexed");
    let attachment = mcap::read::attachment(&logs[0], &summary.attachment_indexes[0]).expect("readable");
    assert_eq!(attachment.name, "experiment-95.toml");
    assert_eq!(attachment.data.as_ref(), fs::read(EXPERIMENT_95).expect("the scene"));

    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut last = 0;
    for message in MessageStream::new(&logs[0]).expect("readable") {
        let message = message.expect("readable to the end");
        assert!(message.log_time >= last);
        last = message.log_time;
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    assert_eq!(last, 20_000_000);
    // A grid of 0.1 ms and the steps of the impacts.
    let states = counts["/joint/q11"];
    assert!(states > 201 && counts["/events"] >= 3, "{states}");
    for topic in ["/contact/proximal", "/contact/distal", "/contact/limit", "/joint/q22", "/actuator/motor", "/energy"]
    {
        assert_eq!(counts[topic], states, "{topic}");
    }
    // Each event is a message and a line; other lines are about the grasp and the end of the run.
    assert!(counts["/event"] >= 2 && counts["/events"] > counts["/event"], "{counts:?}");
}

#[test]
fn command_line_overrides_are_recorded_in_the_log() {
    let log = &path_in(&directory("cli_run_overrides"), "run.mcap");
    let run = succeed_json(&["run", EXPERIMENT_95, "--duration", "5 ms", "--preset", "reference", "--log", log]);
    assert_values(
        &run,
        [
            ("/duration_s", json!(0.005)),
            ("/end_s", json!(0.005)),
            ("/integrator/preset", json!("reference")),
            ("/integrator/method", json!("radau5")),
            ("/contacts/distal/first_s", Value::Null),
            ("/criteria/tts_s", Value::Null),
            ("/criteria/class", json!("unstable")),
        ],
    );
    let settings = settings(log);
    assert_eq!((&*settings["duration_s"], &*settings["integrator_preset"]), ("0.005", "reference"));
    assert_eq!(succeed_json(&["run", EXPERIMENT_95, "--rtol", "1e-3"])["integrator"]["rtol"], 1e-3);
}

#[test]
fn engine_runs_experiment_95() {
    let log = &path_in(&directory("cli_run_engine"), "run.mcap");
    let run = succeed_json(&["run", EXPERIMENT_95, "--model", "engine", "--log", log]);
    assert_values(
        &run,
        [
            ("/model", json!("engine")),
            ("/integrator", Value::Null),
            ("/engine/law", json!("scene")),
            ("/engine/stepping", json!("adaptive")),
            ("/engine/step_s", Value::Null),
            ("/criteria/class", json!("stable")),
        ],
    );
    let settings_keys = ["/engine/tolerance_m", "/engine/max_step_s", "/engine/iterations", "/engine/max_steps"];
    assert_positive(&run, &settings_keys);
    assert_positive(&run, &["/work/contact_substeps", "/work/newton_iterations"]);
    assert_near(&run["loop_gap_m"], 0.0, 1e-7);
    // Expected values: an independent high-accuracy integration (1-model §1.8).
    assert_near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 2e-5);
    assert_near(&run["contacts"]["distal"]["first_s"], 6.883746e-3, 5e-7);

    let settings = settings(log);
    assert_eq!(&*settings["model"], "engine");
    let tolerance_m = run["engine"]["tolerance_m"].as_f64().expect("a length");
    assert_eq!(settings["engine_tolerance_m"], format!("{tolerance_m:?}"));
    assert!(!settings.contains_key("integrator_preset"));
}

#[test]
fn the_engine_takes_its_settings_from_the_command_line() {
    let engine = ["run", EXPERIMENT_95, "--model", "engine"];
    let run = succeed_json(&[&engine[..], &["--step", "20 us"]].concat());
    assert_values(
        &run,
        [("/engine/stepping", json!("fixed")), ("/engine/tolerance_m", Value::Null), ("/steps", json!(1000))],
    );
    assert_near(&run["engine"]["step_s"], 20e-6, 1e-20);
    let text = succeed(&[&engine[..], &["--tolerance", "1 um"]].concat());
    assert_contains(&text, &["engine model, joints within 1.00e-6 m per step", "2 sweeps", "joints open by at most"]);
}

#[test]
fn a_free_swing_has_no_contacts_and_no_criteria() {
    let directory = directory("cli_run_swing");
    let scene = variant(&directory, "swing.toml", "[object]\npresent = false\n[limit]\nenabled = false");
    let log = path_in(&directory, "swing.mcap");
    let run = succeed_json(&["run", &scene, "--duration", "3 ms", "--log", &log]);
    assert_eq!(run["criteria"], Value::Null);
    assert_eq!(run["contacts"], json!({}));
    let bytes = fs::read(&log).expect("a log");
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    let mut topics: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    topics.sort_unstable();
    assert_eq!(
        topics,
        [
            "/actuator/motor",
            "/energy",
            "/event",
            "/events",
            "/joint/loop",
            "/joint/q11",
            "/joint/q12",
            "/joint/q21",
            "/joint/q22",
            "/scene",
            "/tf",
            "/tf_static"
        ]
    );
}

#[test]
fn every_shipped_scene_runs_to_its_end() {
    let entries = fs::read_dir("scenes").expect("the scenes").map(|entry| entry.expect("readable").path());
    let scenes: Vec<_> = entries.filter(|path| !path.is_dir()).collect();
    assert!(!scenes.is_empty());
    for path in scenes {
        assert_eq!(succeed_json(&["run", path_text(&path)])["completed"], true, "{}", path.display());
    }
}

#[test]
fn log_events_record_grasp_and_outcome() {
    let log = path_in(&directory("cli_run_grasp"), "run.mcap");
    let lines = |arguments: &[&str]| -> Vec<String> {
        succeed(&[&["run", EXPERIMENT_95, "--log", &log], arguments].concat());
        let bytes = fs::read(&log).expect("a log");
        let messages = MessageStream::new(&bytes).expect("a log").map(|message| message.expect("readable"));
        let lines = messages.filter(|message| message.channel.topic == "/events");
        let lines = lines.map(|message| foxglove::messages::Log::decode(&message.data[..]).expect("a line"));
        lines.filter(|line| line.name == "grasp").map(|line| line.message).collect()
    };
    for model in ["analytic", "engine"] {
        let lines = lines(&["--model", model]);
        let [grasp, verdict] = &lines[..] else { panic!("{lines:?}") };
        assert!(grasp.starts_with("both phalanges hold the object from 6.8837"), "{grasp}");
        assert!(verdict.starts_with("stable: in position with both contacts active from 6.88 ms on"), "{verdict}");
        assert!(verdict.ends_with("without a rebound"), "{verdict}");
    }
    let lines = lines(&["--duration", "6 ms"]);
    let [verdict] = &lines[..] else { panic!("{lines:?}") };
    assert!(verdict.starts_with("unstable: q11 ends ") && verdict.contains("at most 0.2°"), "{verdict}");
}

/// The summary, the JSON document, the replay of the log and the page contain the same reason.
#[test]
fn every_output_contains_the_reason_of_the_class() {
    let reason = "q21 ends 0.249° from the grasp; at most 0.2° count as in position";
    let directory = directory("run-class-reason");
    let [log, page] = ["run.mcap", "run.html"].map(|name| directory.join(name).display().to_string());
    let run = ["run", EXPERIMENT_95, "--set", "contact.damping=1e4 N*s/m", "--no-check"];
    let summary = succeed(&[&run[..], &["--log", &log, "--plot", &page]].concat());
    let line = format!("unstable: {reason}");
    for text in [summary, succeed(&["replay", &log])] {
        assert!(text.lines().any(|text| text == line), "{text}");
    }
    assert!(fs::read_to_string(page).expect("a page").contains(&line));
    for document in [succeed_json(&run), succeed_json(&["replay", &log])] {
        assert_values(&document, [("/criteria/class", json!("unstable")), ("/criteria/class_reason", json!(reason))]);
    }
}

#[test]
fn finger_without_grasp_reports_why_it_has_no_class() {
    let misses = ["run", "scenes/hard/misses.toml", "--no-check"];
    let reason = "the finger cannot grasp this object: the proximal phalanx misses the object: it is 24.4324 mm long";
    assert_contains(&succeed(&misses), &[&format!("no class: {reason}")]);
    let document = succeed_json(&misses);
    assert_eq!(document["criteria"], Value::Null);
    assert!(document["no_criteria"].as_str().is_some_and(|message| message.starts_with(reason)), "{document}");
    // An incomplete run has no class either.
    let broken = assert_status(&["run", "scenes/hard/through-the-fold.toml", "--no-check", "--json"], 3, &[]);
    let no_criteria = ("/no_criteria", json!("the run was not completed"));
    assert_values(&json(&broken), [("/criteria", Value::Null), no_criteria]);
    assert_eq!(succeed_json(&["run", EXPERIMENT_95, "--no-check"])["no_criteria"], Value::Null);
}
