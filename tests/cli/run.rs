//! `phalanx run` as a user meets it: what it prints, what it logs.

use std::collections::BTreeMap;
use std::fs;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, variant};
use foxglove::Decode;
use mcap::{MessageStream, Summary};
use serde_json::Value;

#[track_caller]
fn near(value: &Value, expected: f64, tolerance: f64) {
    let value = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
}

#[test]
fn the_anchor_case_as_json() {
    let output = phalanx(&["run", ANCHOR, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "");
    let run = json(&output);
    assert_eq!(run["scene"], "experiment-95");
    assert_eq!(run["model"], "analytic");
    assert_eq!(run["duration_s"], 0.02);
    assert_eq!(run["completed"], true);
    assert!(run["steps"].as_u64().expect("a count") > 20);
    assert!(run["wall_s"].as_f64().expect("a time") > 0.0);
    // 1-model §1.8: an independent high-accuracy integration.
    near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 1e-6);
    near(&run["final"]["q21_rad"], 65.019991f64.to_radians(), 1e-6);
    let (proximal, distal) = (&run["contacts"]["proximal"], &run["contacts"]["distal"]);
    near(&proximal["first_s"], 4.501315e-3, 1e-7);
    near(&distal["first_s"], 6.883746e-3, 1e-7);
    near(&proximal["final_normal_n"], 23.6092, 2e-3);
    near(&distal["final_normal_n"], 8.2573, 2e-3);
    assert_eq!(proximal["touchdowns"], 1);
    let criteria = &run["criteria"];
    near(&criteria["tts_s"], 6.883746e-3, 1e-6);
    assert_eq!(criteria["rebound_percent"], 0.0);
    assert_eq!(criteria["class"], "stable");
}

#[test]
fn the_anchor_case_as_a_summary() {
    let output = phalanx(&["run", ANCHOR]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), "", "no progress where there is no terminal");
    let text = stdout(&output);
    for part in ["experiment-95", "analytic", "2.0887", "65.0199", "4.501315", "6.883746", "23.609", "8.257", "stable"]
    {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn the_log_holds_the_run_and_its_scene_and_is_the_same_every_time() {
    let directory = directory("cli_run_log");
    let logs: Vec<Vec<u8>> = ["a.mcap", "b.mcap"]
        .iter()
        .map(|name| {
            let path = directory.join(name);
            let output = phalanx(&["run", ANCHOR, "--json", "--log", path.to_str().expect("text")]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            assert_eq!(json(&output)["log"], path.to_str().expect("text"));
            fs::read(path).expect("a log")
        })
        .collect();
    assert_eq!(logs[0], logs[1]);

    let summary = Summary::read(&logs[0]).expect("readable").expect("indexed");
    let attachment = mcap::read::attachment(&logs[0], &summary.attachment_indexes[0]).expect("readable");
    assert_eq!(attachment.name, "experiment-95.toml");
    assert_eq!(attachment.data.as_ref(), fs::read(ANCHOR).expect("the scene"));

    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut last = 0;
    for message in MessageStream::new(&logs[0]).expect("readable") {
        let message = message.expect("readable to the end");
        assert!(message.log_time >= last);
        last = message.log_time;
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    assert_eq!(last, 20_000_000);
    // A grid of 0.1 ms, and the steps of the impacts besides.
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
fn the_command_line_overrides_the_scene_and_the_log_says_so() {
    let path = directory("cli_run_overrides").join("run.mcap");
    let log = path.to_str().expect("text");
    let output = phalanx(&["run", ANCHOR, "--json", "--duration", "5 ms", "--preset", "reference", "--log", log]);
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

    let output = phalanx(&["run", ANCHOR, "--json", "--rtol", "1e-3"]);
    assert_eq!(json(&output)["integrator"]["rtol"], 1e-3);
}

#[test]
fn the_engine_runs_the_anchor_case_too() {
    let path = directory("cli_run_engine").join("run.mcap");
    let log = path.to_str().expect("text");
    let output = phalanx(&["run", ANCHOR, "--model", "engine", "--json", "--log", log]);
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
    near(&run["loop_gap_m"], 0.0, 1e-7);
    assert!(run["work"]["contact_substeps"].as_u64().expect("a count") > 0);
    assert!(run["work"]["newton_iterations"].as_u64().expect("a count") > 0);
    // 1-model §1.8: an independent high-accuracy integration.
    near(&run["final"]["q11_rad"], 2.088778f64.to_radians(), 2e-5);
    near(&run["contacts"]["distal"]["first_s"], 6.883746e-3, 5e-7);
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
        phalanx(&["run", ANCHOR, "--model", "engine", "--json", "--construction", "reduced", "--step", "20 us"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    let engine = &run["engine"];
    assert_eq!(engine["construction"], "reduced");
    assert_eq!(engine["stepping"], "fixed");
    near(&engine["step_s"], 20e-6, 1e-20);
    assert_eq!(engine["tolerance_m"], Value::Null);
    assert_eq!(run["steps"], 1000);

    let output = phalanx(&["run", ANCHOR, "--model", "engine", "--tolerance", "1 um"]);
    let text = stdout(&output);
    assert!(text.contains("engine model, maximal construction") && text.contains("1.00e-6 m a step"), "{text}");
    assert!(text.contains("joints open by at most"), "{text}");
}

#[test]
fn a_free_swing_has_no_contacts_and_no_criteria() {
    let directory = directory("cli_run_swing");
    let scene = variant(&directory, "swing.toml", "[object]\npresent = false\n[limit]\nenabled = false");
    let log = directory.join("swing.mcap");
    let output = phalanx(&["run", &scene, "--json", "--duration", "3 ms", "--log", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let run = json(&output);
    assert_eq!(run["criteria"], Value::Null);
    for site in ["proximal", "distal"] {
        let contact = &run["contacts"][site];
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
        let output = phalanx(&["run", path.to_str().expect("text"), "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}: {}", path.display(), stderr(&output));
        assert_eq!(json(&output)["completed"], true, "{}", path.display());
        scenes += 1;
    }
    assert!(scenes > 0);
}

#[test]
fn the_log_says_when_the_grasp_holds_and_how_it_ended() {
    let directory = directory("cli_run_grasp");
    let log = directory.join("run.mcap");
    let path = log.to_str().expect("text");
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
        let found = lines(&["run", ANCHOR, "--model", model]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("both phalanges hold the object from 6.8837"), "{found:?}");
        assert!(found[1].starts_with("stable: both phalanges press in position from 6.88 ms on"), "{found:?}");
        assert!(found[1].ends_with("without a rebound"), "{found:?}");
    }
    let found = lines(&["run", ANCHOR, "--duration", "6 ms"]);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].starts_with("unstable: q11 ends ") && found[0].contains("at most 0.2°"), "{found:?}");
}

/// The reason stands in the summary, in JSON, in the log's replay and on the page, in the same words.
#[test]
fn a_class_gives_its_reason_in_every_output() {
    let reason = "q21 ends 0.249° from the grasp; at most 0.2° count as in position";
    let here = directory("run-class-reason");
    let (log, page) = (here.join("run.mcap"), here.join("run.html"));
    let (log, page) = (log.to_str().expect("plain text"), page.to_str().expect("plain text"));
    let set = ["--set", "contact.damping=1e4 N*s/m", "--no-check"];
    let run = phalanx(&[&["run", ANCHOR, "--log", log, "--html", page][..], &set].concat());
    assert_eq!(run.status.code(), Some(0), "{}", stderr(&run));
    let line = format!("unstable: {reason}");
    assert!(stdout(&run).lines().any(|of| of == line), "{}", stdout(&run));
    assert!(fs::read_to_string(page).expect("a page").contains(&line));
    assert!(stdout(&phalanx(&["replay", log])).lines().any(|of| of == line));
    for document in
        [json(&phalanx(&[&["run", ANCHOR, "--json"][..], &set].concat())), json(&phalanx(&["replay", log, "--json"]))]
    {
        assert_eq!(document["criteria"]["class"], "unstable");
        assert_eq!(document["criteria"]["class_reason"], reason);
    }
}

#[test]
fn a_finger_that_cannot_grasp_has_no_class_and_says_why() {
    let run = phalanx(&["run", "scenes/hard/misses.toml", "--no-check"]);
    let why = "the finger cannot grasp this object: the proximal phalanx misses the object: it is 24.4324 mm long";
    assert!(stdout(&run).contains(&format!("no class: {why}")), "{}", stdout(&run));
    let document = json(&phalanx(&["run", "scenes/hard/misses.toml", "--no-check", "--json"]));
    assert_eq!(document["criteria"], Value::Null);
    assert!(document["no_criteria"].as_str().is_some_and(|said| said.starts_with(why)), "{document}");
    // A run that is not completed has no class either.
    let broken = phalanx(&["run", "scenes/hard/through-the-fold.toml", "--no-check", "--json"]);
    assert_eq!(broken.status.code(), Some(3));
    let document = json(&broken);
    assert_eq!((&document["criteria"], &document["no_criteria"]), (&Value::Null, &"the run was not completed".into()));
    assert_eq!(json(&phalanx(&["run", ANCHOR, "--no-check", "--json"]))["no_criteria"], Value::Null);
}
