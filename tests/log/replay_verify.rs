//! `phalanx replay --verify`: compares a log with a new simulation and reports the first difference.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, json, path_in, path_text, signal, start, stderr,
    stdout, succeed, variant, write, write_bytes,
};
use crate::support::replay::{
    DISC_SCENE, FINGER_SCENE, LogEdits, MessageEdit, edit_log, interrupted_log, log, one_ulp_up,
};
use phalanx::trace::Model;
use serde_json::Value;

/// Verifies a log; asserts the exit status, and that standard error contains each of `parts`.
#[track_caller]
fn verify(log: &Path, status: i32, parts: &[&str]) -> Output {
    assert_status(&["replay", path_text(log), "--verify", "--json"], status, parts)
}

/// Verification report of a log; checks the exit status.
fn verified(log: &Path, status: i32) -> Value {
    json(&verify(log, status, &[]))["verification"].clone()
}

/// Parses a number of an object exactly; the JSON parser rounds.
fn parse_exact_number(text: &str, object: &str, key: &str) -> f64 {
    let object = text.split(&format!("\"{object}\": {{")).nth(1).expect("an object");
    let value = object.split(&format!("\"{key}\": ")).nth(1).expect("a key");
    value.split([',', '\n']).next().expect("a value").parse().expect("a number")
}

#[test]
fn recorded_settings_reproduce_the_same_bytes() {
    let directory = directory("verify_overrides");
    let rapier = variant(&directory, "rapier.toml", "[engine]\nlaw = \"rapier\"\nfriction = 0.3\nrestitution = 0.1");
    let rates =
        variant(&directory, "rates.toml", "[log]\nnumeric_rate = \"3.7 kHz\"\n[integrator]\nmethod = \"radau5\"");
    let budget = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40\n[engine]\nmax_steps = 40");
    let engine = ["--model", "engine"];
    let runs: &[(&str, &[&str], i32)] = &[
        (FINGER_SCENE, &[], 0),
        (FINGER_SCENE, &["--preset", "reference"], 0),
        (FINGER_SCENE, &["--rtol", "3.7e-6", "--duration", "7.1 ms"], 0),
        (FINGER_SCENE, &["--numeric-rate", "13.7 kHz", "--picture-rate", "0.7 kHz"], 0),
        (FINGER_SCENE, &["--model", "engine", "--numeric-rate", "900 Hz", "--picture-rate", "0 Hz"], 0),
        (FINGER_SCENE, &engine, 0),
        (FINGER_SCENE, &["--model", "engine", "--step", "33 us"], 0),
        (FINGER_SCENE, &["--model", "engine", "--tolerance", "0.37 um", "--duration", "9 ms"], 0),
        (&rapier, &["--model", "engine", "--step", "50 us"], 0),
        (&rates, &[], 0),
        (&budget, &[], 3),
        (&budget, &engine, 3),
        ("scenes/free-swing.toml", &[], 0),
        ("scenes/torsional-spring.toml", &engine, 0),
        (DISC_SCENE, &[], 0),
        (DISC_SCENE, &["--preset", "reference", "--duration", "8 ms"], 0),
        (DISC_SCENE, &["--model", "engine", "--tolerance", "0.01 um", "--numeric-rate", "33 kHz"], 0),
        ("scenes/laws/rolling.toml", &["--model", "engine", "--step", "30 us"], 0),
        ("scenes/laws/two-free.toml", &["--rtol", "1e-7"], 0),
    ];
    for (scene, args, status) in runs {
        let log = directory.join("run.mcap");
        assert_status(&[&["run", scene, "--log", path_text(&log)], *args].concat(), *status, &[]);
        let output = verify(&log, 0, &[]);
        assert_eq!(stderr(&output), "", "{scene} {args:?}");
        let report = json(&output);
        let verification = &report["verification"];
        let states = ["same", "complete"].map(|key| &verification[key]);
        assert_eq!(states, [true, true], "{scene} {args:?}");
        assert_eq!(verification["samples_compared"], report["samples"], "{scene} {args:?}");
        assert!(report["samples"].as_u64() > Some(5), "{scene} {args:?}");
        assert_eq!(verification["first_difference"], Value::Null);
        assert_eq!(verification["samples_not_compared"], 0);
    }
    assert_contains(&succeed(&["replay", &path_in(&directory, "run.mcap"), "--verify"]), &["VERIFIED: "]);
}

#[test]
fn finds_a_difference_of_one_ulp() {
    let directory = directory("verify_ulp");
    for (scene, model, topic, quantity, field) in [
        (FINGER_SCENE, Model::Analytic, "/joint/q21", "q21_rad", 2),
        (FINGER_SCENE, Model::Engine, "/energy", "balance_j", 8),
        (DISC_SCENE, Model::Analytic, "/body/hammer", "hammer_vx_m_s", 5),
        (DISC_SCENE, Model::Engine, "/contact/hammer-anvil", "hammer-anvil_gap_m", 2),
    ] {
        let bytes = log(scene, model, 1e4);
        let (original, count) = (write_bytes(&directory, "whole.mcap", &bytes), 77);
        let change = |message_topic: &str, number: u64, data: &[u8]| match message_topic == topic && number == count {
            true => MessageEdit::Change(one_ulp_up(data, field)),
            false => MessageEdit::Keep,
        };
        let modified = edit_log(&bytes, &LogEdits { message: &change, ..LogEdits::default() });
        assert_eq!(verified(&original, 0)["same"], true);
        let modified = write_bytes(&directory, "planted.mcap", &modified);
        let output = verify(&modified, 1, &[quantity]);
        let verification = &json(&output)["verification"];
        let counts = ["differing", "only_in_log", "only_in_new_run"].map(|key| &verification[format!("samples_{key}")]);
        assert_eq!((counts, &verification["same"]), ([&1.into(), &0.into(), &0.into()], &false.into()));
        assert_eq!(verification["first_difference"]["quantity"], quantity);
        let [log, rerun, absolute, time_s] = ["log", "new_run", "absolute", "time_s"]
            .map(|key| parse_exact_number(stdout(&output), "first_difference", key));
        assert_eq!(log, rerun.next_up());
        assert_eq!(absolute, (log - rerun).abs());
        // The reported time is the time of the modified message, as in the table of samples.
        let table = succeed(&["replay", path_text(&original), "--csv", "-"]);
        let row = table.lines().nth(1 + count as usize).expect("a row");
        assert_eq!(row.split(',').next().expect("a time").parse(), Ok(time_s));
        assert_eq!(verification["quantities"].as_array().expect("a list").len(), 1);
        assert_eq!(verification["quantities"][0]["samples"], 1);
        let text = assert_status(&["replay", path_text(&modified), "--verify"], 1, &[]);
        assert_contains(stdout(&text), &["DIFFERENT: ", "1 of ", "first difference at ", quantity, "  new run  "]);
    }
}

#[test]
fn counts_missing_and_differing_data_and_compares_the_rest() {
    let directory = directory("verify_missing");
    let bytes = log(FINGER_SCENE, Model::Analytic, 1e4);
    let edited = |message: &dyn Fn(&str, u64, &[u8]) -> MessageEdit| {
        let bytes = edit_log(&bytes, &LogEdits { message, ..LogEdits::default() });
        verified(&write_bytes(&directory, "edited.mcap", &bytes), 1)
    };
    let verification = edited(&|topic, number, data| match (topic, number) {
        ("/energy", 40) => MessageEdit::Drop,
        ("/contact/limit", 90) => MessageEdit::Change(one_ulp_up(data, 2)),
        ("/event", 0) => MessageEdit::Change(one_ulp_up(data, 1)),
        _ => MessageEdit::Keep,
    });
    let counts = ["samples_differing", "events_differing", "samples_only_in_log", "samples_only_in_new_run"];
    assert_eq!(counts.map(|key| verification[key].as_u64()), [2, 1, 0, 0].map(Some), "{verification:#}");
    // One sample, and all later ones, are missing; the last event is missing.
    for (from, extra) in [(100..101, 1..2), (100..10_000, 50..900)] {
        let verification = edited(&|topic, number, _| {
            let is_sample = ["/joint", "/actuator", "/contact", "/energy"].iter().any(|start| topic.starts_with(start));
            if is_sample && from.contains(&number) { MessageEdit::Drop } else { MessageEdit::Keep }
        });
        let missing = verification["samples_only_in_new_run"].as_u64().expect("a count");
        assert!(extra.contains(&missing), "{verification:#}");
        assert_eq!(verification["first_difference"]["quantity"], "(next sample)");
    }
    let verification = edited(&|topic, number, _| match (topic, number) {
        ("/event", 0) => MessageEdit::Drop,
        _ => MessageEdit::Keep,
    });
    assert!(verification["events_only_in_new_run"].as_u64() > Some(0), "{verification:#}");
}

#[test]
fn compares_an_interrupted_run_up_to_the_interrupt() {
    let directory = directory("verify_interrupted");
    for (scene, model) in [
        (FINGER_SCENE, Model::Analytic),
        (FINGER_SCENE, Model::Engine),
        (DISC_SCENE, Model::Analytic),
        (DISC_SCENE, Model::Engine),
    ] {
        let log = write_bytes(&directory, "run.mcap", &interrupted_log(scene, model, 60));
        let verification = verified(&log, 0);
        let states = ["same", "complete"].map(|key| &verification[key]);
        assert_eq!(states, [true, true], "{scene} {model:?}: {verification:#}");
        assert!(verification["samples_compared"].as_u64() > Some(50), "{verification:#}");
        // The last sample is not compared.
        assert_eq!(verification["samples_not_compared"], 1, "{scene} {model:?}");
        assert_contains(&succeed(&["replay", path_text(&log), "--verify"]), &["not compared: the last "]);
    }
}

/// Like the previous test, with a signal at an arbitrary time.
#[cfg(unix)]
#[test]
fn verifies_a_run_ended_by_a_signal() {
    let directory = directory("verify_signal");
    let scene = variant(&directory, "hold.toml", "[log]\nnumeric_rate = \"1 MHz\"");
    let (log, partial) = (directory.join("run.mcap"), directory.join("run.mcap.partial"));
    let mut run = start(&["run", &scene, "--duration", "9 s", "--log", path_text(&log)]);
    let deadline = std::time::Instant::now() + std::time::Duration::from_secs(20);
    while fs::metadata(&partial).map_or(0, |metadata| metadata.len()) < 200_000 {
        assert!(std::time::Instant::now() < deadline, "the log does not grow");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    signal(&run, "INT");
    assert_eq!(run.wait().expect("ends").code(), Some(3));
    let verification = verified(&log, 0);
    assert_eq!(verification["same"], true, "{verification:#}");
    assert!(verification["samples_compared"].as_u64() > Some(200), "{verification:#}");
}

#[test]
fn matching_prefix_is_not_a_complete_comparison() {
    let directory = directory("verify_prefix");
    for scene in [FINGER_SCENE, DISC_SCENE] {
        let bytes = log(scene, Model::Engine, 3e5);
        let log = write_bytes(&directory, "cut.mcap", &bytes[..2 * bytes.len() / 3]);
        let verification = &json(&verify(&log, 1, &["only part of the run could be compared"]))["verification"];
        let states = ["same", "complete"].map(|key| &verification[key]);
        assert_eq!(states, [true, false], "{verification:#}");
        assert!(verification["samples_compared"].as_u64() > Some(200));
    }
}

#[test]
fn compares_logs_of_other_versions() {
    let directory = directory("verify_version");
    let bytes = log(FINGER_SCENE, Model::Analytic, 1e4);
    let older = LogEdits {
        metadata: &|entries| {
            entries.insert("phalanx_version".to_string(), "0.0.9".to_string());
        },
        ..LogEdits::default()
    };
    let path = write_bytes(&directory, "older.mcap", &edit_log(&bytes, &older));
    let verification = verified(&path, 0);
    assert_eq!((&verification["same"], &verification["phalanx_version_log"]), (&true.into(), &"0.0.9".into()));
    let parts = ["the log was written by phalanx 0.0.9; this is phalanx"];
    assert_contains(&succeed(&["replay", path_text(&path), "--verify"]), &parts);
}

#[test]
fn rejects_logs_that_cannot_be_simulated_again() {
    let directory = directory("verify_refused");
    let bytes = log(FINGER_SCENE, Model::Analytic, 1e4);
    let changes_scene = |changes: &LogEdits<'_>| (changes.scene)("[motor]").as_deref() != Some("[motor]");
    let assert_edit_rejected = |changes: &LogEdits<'_>, parts: &[&str]| {
        let path = write_bytes(&directory, "refused.mcap", &edit_log(&bytes, changes));
        assert_rejected(&["replay", path_text(&path), "--verify", "--json"], parts);
        // The summary is still printed; an invalid duration contradicts a completed run, and a scene that cannot be used is
        // lost.
        let is_scene_lost = changes_scene(changes);
        let status = i32::from(parts[0] == "duration_s" || is_scene_lost);
        let text = assert_status(&["replay", path_text(&path)], status, if is_scene_lost { &["scene"] } else { &[] });
        assert_eq!(stdout(&text).contains("LOST: "), is_scene_lost);
    };
    type Entries = std::collections::BTreeMap<String, String>;
    let set_entry = |key: &'static str, value: &'static str| {
        move |entries: &mut Entries| {
            entries.insert(key.to_string(), value.to_string());
        }
    };
    let reject_metadata = |metadata: &dyn Fn(&mut Entries), parts: &[&str]| {
        assert_edit_rejected(&LogEdits { metadata, ..LogEdits::default() }, parts)
    };
    reject_metadata(&set_entry("integrator_zeal", "11"), &["integrator_zeal", "does not know"]);
    reject_metadata(&set_entry("integrator_rtol", "lots"), &["integrator_rtol", "lots", "a number between 0 and 1"]);
    reject_metadata(&set_entry("duration_s", "inf"), &["duration_s", "a number above 0"]);
    reject_metadata(&set_entry("duration_s", "1e50"), &["duration_s", "a number above 0, and 3600 at most"]);
    reject_metadata(&set_entry("integrator_max_step_s", "1e9"), &["integrator_max_step_s"]);
    reject_metadata(&set_entry("log_numeric_hz", "1e11"), &["log_numeric_hz", "more than the limit of 1e7"]);
    reject_metadata(&set_entry("integrator_method", "euler"), &["\"rodas5p\" or \"radau5\""]);
    reject_metadata(&set_entry("model", "wooden"), &["\"analytic\" or \"engine\""]);
    reject_metadata(&|entries| drop(entries.remove("duration_s")), &["does not record `duration_s`"]);
    let reject_scene = |scene: &dyn Fn(&str) -> Option<String>, parts: &[&str]| {
        assert_edit_rejected(&LogEdits { scene, ..LogEdits::default() }, parts)
    };
    reject_scene(&|_| None, &["the part of the log with its scene is lost"]);
    let other = fs::read_to_string(DISC_SCENE).expect("a scene");
    reject_scene(&|_| Some(other.clone()), &["differs from the kind in its metadata"]);
    let broken = |text: &str| Some(text.replace("[motor]", "[mortar]"));
    reject_scene(&broken, &["cannot be read by this version of phalanx", "mortar"]);
}

#[test]
fn rejects_conflicting_options() {
    let log = write(&directory("verify_options"), "run.mcap", "");
    assert_rejected(&["replay", &log, "--verify", "--against", "b.mcap"], &["cannot be used with"]);
}
