//! `phalanx run`: printed output and logs.

use std::collections::BTreeMap;
use std::fs;

use crate::support::cli::{EXPERIMENT_95, directory, json, phalanx, stderr, stdout, variant};
use foxglove::Decode;
use mcap::{MessageStream, Summary};
use serde_json::Value;

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"));
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

#[test]
fn experiment_95_as_json() {
    let output = phalanx(&["run", EXPERIMENT_95, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
    let run = json(&output);
    assert_eq!(run["scene"], "experiment-95");
    assert_eq!(run["model"], "analytic");
    assert_eq!(run["duration_s"], 0.02);
    assert_eq!(run["completed"], true);
    assert!(run["steps"].as_u64().expect("a count") > 20);
    assert!(run["wall_s"].as_f64().expect("a time") > 0.0);
    // Expected values: an independent high-accuracy integration (1-model §1.8).
    assert_near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 1e-6);
    assert_near(&run["final"]["q21_rad"], 65.019991f64.to_radians(), 1e-6);
    let (proximal, distal) = (&run["contacts"]["proximal"], &run["contacts"]["distal"]);
    assert_near(&proximal["first_s"], 4.501315e-3, 1e-7);
    assert_near(&distal["first_s"], 6.883746e-3, 1e-7);
    assert_near(&proximal["final_normal_n"], 23.6092, 2e-3);
    assert_near(&distal["final_normal_n"], 8.2573, 2e-3);
    assert_eq!(proximal["touchdowns"], 1);
    let criteria = &run["criteria"];
    assert_near(&criteria["tts_s"], 6.883746e-3, 1e-6);
    assert_eq!(criteria["rebound_percent"], 0.0);
    assert_eq!(criteria["class"], "stable");
}

#[test]
fn experiment_95_as_summary() {
    let output = phalanx(&["run", EXPERIMENT_95]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "", "no progress without a terminal");
    let text = stdout(&output);
    for part in ["experiment-95", "analytic", "2.0887", "65.0199", "4.501315", "6.883746", "23.609", "8.257", "stable"]
    {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn log_contains_run_and_scene_and_is_reproducible() {
    let directory = directory("cli_run_log");
    let logs: Vec<Vec<u8>> = ["a.mcap", "b.mcap"]
        .iter()
        .map(|name| {
            let path = directory.join(name);
            let output = phalanx(&["run", EXPERIMENT_95, "--json", "--log", path.to_str().expect("UTF-8 path")]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            assert_eq!(json(&output)["log"], path.to_str().expect("UTF-8 path"));
            fs::read(path).expect("a log")
        })
        .collect();
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
    let states = counts["/state"];
    assert!(states > 201, "{states}");
    for topic in ["/contact/proximal", "/contact/distal", "/limit", "/energy"] {
        assert_eq!(counts[topic], states, "{topic}");
    }
    assert_eq!(counts["/impact/proximal"], 1);
    assert_eq!(counts["/impact/distal"], 1);
    assert!(counts["/events"] >= 3);
}

#[test]
fn command_line_overrides_are_recorded_in_the_log() {
    let path = directory("cli_run_overrides").join("run.mcap");
    let log = path.to_str().expect("UTF-8 path");
    let output =
        phalanx(&["run", EXPERIMENT_95, "--json", "--duration", "5 ms", "--preset", "reference", "--log", log]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    assert_eq!(run["duration_s"], 0.005);
    assert_eq!(run["end_s"], 0.005);
    assert_eq!(run["integrator"]["preset"], "reference");
    assert_eq!(run["integrator"]["method"], "radau5");
    assert_eq!(run["contacts"]["distal"]["first_s"], Value::Null);
    assert_eq!(run["criteria"]["tts_s"], Value::Null);
    assert_eq!(run["criteria"]["class"], "unstable");

    let bytes = fs::read(&path).expect("a log");
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    let settings = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("readable").metadata;
    assert_eq!(settings["duration_s"], "0.005");
    assert_eq!(settings["integrator_preset"], "reference");

    let output = phalanx(&["run", EXPERIMENT_95, "--json", "--rtol", "1e-3"]);
    assert_eq!(json(&output)["integrator"]["rtol"], 1e-3);
}

#[test]
fn engine_runs_experiment_95() {
    let path = directory("cli_run_engine").join("run.mcap");
    let log = path.to_str().expect("UTF-8 path");
    let output = phalanx(&["run", EXPERIMENT_95, "--model", "engine", "--json", "--log", log]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    assert_eq!(run["model"], "engine");
    assert_eq!(run["integrator"], Value::Null);
    let engine = &run["engine"];
    assert_eq!(engine["construction"], "maximal");
    assert_eq!(engine["law"], "scene");
    assert_eq!(engine["stepping"], "adaptive");
    assert_eq!(engine["step_s"], Value::Null);
    for key in ["tolerance_m", "max_step_s", "iterations", "max_steps"] {
        assert!(engine[key].is_number(), "{key}");
    }
    assert_near(&run["loop_gap_m"], 0.0, 1e-7);
    assert!(run["work"]["contact_substeps"].as_u64().expect("a count") > 0);
    assert!(run["work"]["newton_iterations"].as_u64().expect("a count") > 0);
    // Expected values: an independent high-accuracy integration (1-model §1.8).
    assert_near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 2e-5);
    assert_near(&run["contacts"]["distal"]["first_s"], 6.883746e-3, 5e-7);
    assert_eq!(run["criteria"]["class"], "stable");

    let bytes = fs::read(&path).expect("a log");
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    let settings = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("readable").metadata;
    assert_eq!(settings["model"], "engine");
    assert_eq!(settings["engine_construction"], "maximal");
    assert_eq!(settings["engine_tolerance_m"], format!("{:?}", engine["tolerance_m"].as_f64().expect("a length")));
    assert!(!settings.contains_key("integrator_preset"));
}

#[test]
fn the_engine_takes_its_settings_from_the_command_line() {
    let output =
        phalanx(&["run", EXPERIMENT_95, "--model", "engine", "--json", "--construction", "reduced", "--step", "20 us"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    let engine = &run["engine"];
    assert_eq!(engine["construction"], "reduced");
    assert_eq!(engine["stepping"], "fixed");
    assert_near(&engine["step_s"], 20e-6, 1e-20);
    assert_eq!(engine["tolerance_m"], Value::Null);
    assert_eq!(run["steps"], 1000);

    let output = phalanx(&["run", EXPERIMENT_95, "--model", "engine", "--tolerance", "1 um"]);
    let text = stdout(&output);
    assert!(text.contains("engine model, maximal construction") && text.contains("1.00e-6 m per step"), "{text}");
    assert!(text.contains("joints open by at most"), "{text}");
}

#[test]
fn a_free_swing_has_no_contacts_and_no_criteria() {
    let directory = directory("cli_run_swing");
    let scene = variant(&directory, "swing.toml", "[object]\npresent = false\n[limit]\nenabled = false");
    let log = directory.join("swing.mcap");
    let output = phalanx(&["run", &scene, "--json", "--duration", "3 ms", "--log", log.to_str().expect("UTF-8 path")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    assert_eq!(run["criteria"], Value::Null);
    for name in ["proximal", "distal"] {
        let contact = &run["contacts"][name];
        assert_eq!(contact["first_s"], Value::Null);
        assert_eq!(contact["touchdowns"], 0);
        assert_eq!(contact["final_normal_n"], 0.0);
    }
    let bytes = fs::read(&log).expect("a log");
    let summary = Summary::read(&bytes).expect("readable").expect("indexed");
    let mut topics: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    topics.sort_unstable();
    assert_eq!(topics, ["/energy", "/events", "/scene", "/state", "/tf", "/tf_static"]);
}

#[test]
fn every_shipped_scene_runs_to_its_end() {
    let mut scenes = 0;
    for entry in fs::read_dir("scenes").expect("the scenes") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            continue;
        }
        let output = phalanx(&["run", path.to_str().expect("UTF-8 path"), "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}: {}", path.display(), stderr(&output));
        assert_eq!(json(&output)["completed"], true, "{}", path.display());
        scenes += 1;
    }
    assert!(scenes > 0);
}

#[test]
fn log_events_record_grasp_and_outcome() {
    let directory = directory("cli_run_grasp");
    let log = directory.join("run.mcap");
    let path = log.to_str().expect("UTF-8 path");
    let lines = |arguments: &[&str]| -> Vec<String> {
        let output = phalanx(&[arguments, &["--log", path]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let bytes = fs::read(&log).expect("a log");
        let messages = MessageStream::new(&bytes).expect("a log").map(|message| message.expect("readable"));
        let lines = messages.filter(|message| message.channel.topic == "/events");
        let lines = lines.map(|message| foxglove::messages::Log::decode(&message.data[..]).expect("a line"));
        lines.filter(|line| line.name == "grasp").map(|line| line.message).collect()
    };
    for model in ["analytic", "engine"] {
        let verdict_lines = lines(&["run", EXPERIMENT_95, "--model", model]);
        assert_eq!(verdict_lines.len(), 2, "{verdict_lines:?}");
        assert!(verdict_lines[0].starts_with("both phalanges hold the object from 6.8837"), "{verdict_lines:?}");
        assert!(
            verdict_lines[1].starts_with("stable: in position with both contacts active from 6.88 ms on"),
            "{verdict_lines:?}"
        );
        assert!(verdict_lines[1].ends_with("without a rebound"), "{verdict_lines:?}");
    }
    let verdict_lines = lines(&["run", EXPERIMENT_95, "--duration", "6 ms"]);
    assert_eq!(verdict_lines.len(), 1, "{verdict_lines:?}");
    assert!(
        verdict_lines[0].starts_with("unstable: q11 ends ") && verdict_lines[0].contains("at most 0.2°"),
        "{verdict_lines:?}"
    );
}

/// The summary, the JSON document, the replay of the log and the page contain the same reason.
#[test]
fn every_output_contains_the_reason_of_the_class() {
    let reason = "q21 ends 0.249° from the grasp; at most 0.2° count as in position";
    let directory = directory("run-class-reason");
    let (log, page) = (directory.join("run.mcap"), directory.join("run.html"));
    let (log, page) = (log.to_str().expect("UTF-8 path"), page.to_str().expect("UTF-8 path"));
    let set = ["--set", "contact.damping=1e4 N*s/m", "--no-check"];
    let run = phalanx(&[&["run", EXPERIMENT_95, "--log", log, "--html", page][..], &set].concat());
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let line = format!("unstable: {reason}");
    assert!(stdout(&run).lines().any(|text| text == line), "{}", stdout(&run));
    assert!(fs::read_to_string(page).expect("a page").contains(&line));
    assert!(stdout(&phalanx(&["replay", log])).lines().any(|text| text == line));
    for document in [
        json(&phalanx(&[&["run", EXPERIMENT_95, "--json"][..], &set].concat())),
        json(&phalanx(&["replay", log, "--json"])),
    ] {
        assert_eq!(document["criteria"]["class"], "unstable");
        assert_eq!(document["criteria"]["class_reason"], reason);
    }
}

#[test]
fn finger_without_grasp_reports_why_it_has_no_class() {
    let run = phalanx(&["run", "scenes/hard/misses.toml", "--no-check"]);
    let reason = "the finger cannot grasp this object: the proximal phalanx misses the object: it is 24.4324 mm long";
    assert!(stdout(&run).contains(&format!("no class: {reason}")), "{}", stdout(&run));
    let document = json(&phalanx(&["run", "scenes/hard/misses.toml", "--no-check", "--json"]));
    assert_eq!(document["criteria"], Value::Null);
    assert!(document["no_criteria"].as_str().is_some_and(|message| message.starts_with(reason)), "{document}");
    // An incomplete run has no class either.
    let broken = phalanx(&["run", "scenes/hard/through-the-fold.toml", "--no-check", "--json"]);
    assert_eq!(broken.status.code(), Some(3));
    let document = json(&broken);
    assert_eq!((&document["criteria"], &document["no_criteria"]), (&Value::Null, &"the run was not completed".into()));
    assert_eq!(json(&phalanx(&["run", EXPERIMENT_95, "--no-check", "--json"]))["no_criteria"], Value::Null);
}
