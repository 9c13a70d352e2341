//! `phalanx replay --verify`: a log is what simulating its scene with its settings gives, or the first difference is named.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::support::cli::{directory, json, phalanx, stderr, stdout, variant, write};
use crate::support::replay::{Changes, DISCS, FINGER, Fate, changed, interrupted, log, one_ulp_up};
use phalanx::trace::Model;
use serde_json::Value;

fn verify(log: &Path) -> Output {
    phalanx(&["replay", log.to_str().expect("text"), "--verify", "--json"])
}

fn keep(directory: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

/// The verification of a log that must end with a status.
fn verified(log: &Path, status: i32) -> Value {
    let output = verify(log);
    assert_eq!(output.status.code(), Some(status), "{}", stderr(&output));
    json(&output)["verification"].clone()
}

/// The number under a key of an object, to the last bit: the reader of JSON rounds.
fn exactly(text: &str, object: &str, key: &str) -> f64 {
    let object = text.split(&format!("\"{object}\": {{")).nth(1).expect("an object");
    let value = object.split(&format!("\"{key}\": ")).nth(1).expect("a key");
    value.split([',', '\n']).next().expect("a value").parse().expect("a number")
}

#[test]
fn every_override_is_recorded_and_the_same_bytes_come_again() {
    let directory = directory("verify_overrides");
    let rapier = variant(&directory, "rapier.toml", "[engine]\nlaw = \"rapier\"\nfriction = 0.3\nrestitution = 0.1");
    let rates =
        variant(&directory, "rates.toml", "[log]\nnumeric_rate = \"3.7 kHz\"\n[integrator]\nmethod = \"radau5\"");
    let budget = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40\n[engine]\nmax_steps = 40");
    let engine = ["--model", "engine"];
    let runs: &[(&str, &[&str], i32)] = &[
        (FINGER, &[], 0),
        (FINGER, &["--preset", "reference"], 0),
        (FINGER, &["--rtol", "3.7e-6", "--duration", "7.1 ms"], 0),
        (FINGER, &["--numeric-rate", "13.7 kHz", "--picture-rate", "0.7 kHz"], 0),
        (FINGER, &["--model", "engine", "--numeric-rate", "900 Hz", "--picture-rate", "0 Hz"], 0),
        (FINGER, &engine, 0),
        (FINGER, &["--model", "engine", "--step", "33 us"], 0),
        (FINGER, &["--model", "engine", "--tolerance", "0.37 um", "--duration", "9 ms"], 0),
        (FINGER, &["--model", "engine", "--construction", "reduced", "--step", "50 us"], 0),
        (&rapier, &["--model", "engine", "--step", "50 us"], 0),
        (&rates, &[], 0),
        (&budget, &[], 3),
        (&budget, &engine, 3),
        ("scenes/free-swing.toml", &[], 0),
        ("scenes/torsional-spring.toml", &engine, 0),
        (DISCS, &[], 0),
        (DISCS, &["--preset", "reference", "--duration", "8 ms"], 0),
        (DISCS, &["--model", "engine", "--tolerance", "0.01 um", "--numeric-rate", "33 kHz"], 0),
        ("scenes/laws/rolling.toml", &["--model", "engine", "--step", "30 us"], 0),
        ("scenes/laws/two-free.toml", &["--rtol", "1e-7"], 0),
    ];
    for (scene, args, status) in runs {
        let log = directory.join("run.mcap");
        let output = phalanx(&[&["run", scene, "--log", log.to_str().expect("text")], *args].concat());
        assert_eq!(output.status.code(), Some(*status), "{scene} {args:?}: {}", stderr(&output));
        let output = verify(&log);
        assert_eq!(output.status.code(), Some(0), "{scene} {args:?}: {}", stderr(&output));
        assert_eq!(stderr(&output), "");
        let report = json(&output);
        let found = &report["verification"];
        assert_eq!((&found["same"], &found["complete"]), (&true.into(), &true.into()), "{scene} {args:?}");
        assert_eq!(found["messages_compared"], report["messages"], "{scene} {args:?}");
        assert!(report["messages"].as_u64() > Some(20), "{scene} {args:?}");
        assert_eq!(found["first_difference"], Value::Null);
        assert_eq!(found["messages_not_compared"], 0);
    }
    let output = phalanx(&["replay", directory.join("run.mcap").to_str().expect("text"), "--verify"]);
    assert!(stdout(&output).contains("VERIFIED: "), "{}", stdout(&output));
}

#[test]
fn one_unit_in_the_last_place_is_found_where_it_is() {
    let directory = directory("verify_ulp");
    for (scene, model, topic, name, field) in [
        (FINGER, Model::Analytic, "/state", "q21_rad", 3),
        (FINGER, Model::Engine, "/energy", "balance_j", 8),
        (DISCS, Model::Analytic, "/disc/hammer", "vx_m_s", 5),
        (DISCS, Model::Engine, "/contact/hammer-anvil", "gap_m", 2),
    ] {
        let bytes = log(scene, model, 1e4);
        let (whole, count) = (keep(&directory, "whole.mcap", &bytes), 77);
        let planted = changed(
            &bytes,
            &Changes {
                message: &|on, number, data| match on == topic && number == count {
                    true => Fate::Change(one_ulp_up(data, field)),
                    false => Fate::Keep,
                },
                ..Changes::default()
            },
        );
        assert_eq!(verified(&whole, 0)["same"], true);
        let planted = keep(&directory, "planted.mcap", &planted);
        let output = verify(&planted);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains(topic) && stderr(&output).contains(name), "{}", stderr(&output));
        let found = &json(&output)["verification"];
        assert_eq!((&found["messages_differing"], &found["same"]), (&1.into(), &false.into()));
        assert_eq!((&found["messages_only_in_log"], &found["messages_only_in_new_run"]), (&0.into(), &0.into()));
        let first = &found["first_difference"];
        assert_eq!((&first["channel"], &first["field"]), (&topic.into(), &name.into()));
        let [log, again, absolute, time_s] =
            ["log", "new_run", "absolute", "time_s"].map(|key| exactly(stdout(&output), "first_difference", key));
        assert_eq!(log, again.next_up());
        assert_eq!(absolute, (log - again).abs());
        // The time of that very message, as its column of samples has it.
        let table = phalanx(&["replay", whole.to_str().expect("text"), "--csv", "-"]);
        let row = stdout(&table).lines().nth(1 + count as usize).expect("a row");
        assert_eq!(row.split(',').next().expect("a time").parse(), Ok(time_s));
        assert_eq!(found["fields"].as_array().expect("a list").len(), 1);
        assert_eq!(found["fields"][0]["messages"], 1);
        let text = phalanx(&["replay", planted.to_str().expect("text"), "--verify"]);
        for part in ["DIFFERENT: ", "1 of ", "first difference at ", topic, name, "  new run  "] {
            assert!(stdout(&text).contains(part), "no {part} in\n{}", stdout(&text));
        }
    }
}

#[test]
fn missing_and_additional_messages_are_counted_and_the_rest_is_paired() {
    let directory = directory("verify_missing");
    let bytes = log(FINGER, Model::Analytic, 1e4);
    let without = changed(
        &bytes,
        &Changes {
            message: &|topic, number, data| match (topic, number) {
                ("/energy", 40) => Fate::Drop,
                ("/limit", 90) => Fate::Change(one_ulp_up(data, 2)),
                _ => Fate::Keep,
            },
            ..Changes::default()
        },
    );
    let found = verified(&keep(&directory, "without.mcap", &without), 1);
    assert_eq!((&found["messages_only_in_log"], &found["messages_only_in_new_run"]), (&0.into(), &1.into()));
    assert_eq!(found["messages_differing"], 1, "{found:#}");
    let first = &found["first_difference"];
    assert_eq!(first["field"], "(which message comes next)");
    assert!(first["new_run"].as_str().expect("words").starts_with("/energy at "), "{first}");
    // A log that ends before its run does, and says that it was completed.
    let cut = changed(
        &bytes,
        &Changes {
            message: &|topic, number, _| if topic == "/state" && number > 100 { Fate::Drop } else { Fate::Keep },
            ..Changes::default()
        },
    );
    let found = verified(&keep(&directory, "cut.mcap", &cut), 1);
    assert!(found["messages_only_in_new_run"].as_u64() > Some(50));
}

#[test]
fn an_interrupted_run_is_compared_up_to_the_interrupt() {
    let directory = directory("verify_interrupted");
    for (scene, model) in
        [(FINGER, Model::Analytic), (FINGER, Model::Engine), (DISCS, Model::Analytic), (DISCS, Model::Engine)]
    {
        let log = keep(&directory, "run.mcap", &interrupted(scene, model, 60));
        let found = verified(&log, 0);
        assert_eq!((&found["same"], &found["complete"]), (&true.into(), &true.into()), "{scene} {model:?}: {found:#}");
        assert!(found["messages_compared"].as_u64() > Some(100), "{found:#}");
        // The last sample and the line that says why.
        let left = found["messages_not_compared"].as_u64().expect("a count");
        assert!((3..=12).contains(&left), "{scene} {model:?}: {left}");
        let text = phalanx(&["replay", log.to_str().expect("text"), "--verify"]);
        assert!(stdout(&text).contains("not compared: the last "), "{}", stdout(&text));
    }
}

/// The same with a signal that comes when it likes.
#[cfg(unix)]
#[test]
fn a_run_that_a_signal_ends_verifies_up_to_there() {
    let directory = directory("verify_signal");
    let scene = variant(&directory, "hold.toml", "[log]\nnumeric_rate = \"1 MHz\"");
    let (log, partial) = (directory.join("run.mcap"), directory.join("run.mcap.partial"));
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_phalanx"));
    let mut run = command.args(["run", &scene, "--duration", "9 s", "--log"]).arg(&log).spawn().expect("started");
    let patience = std::time::Instant::now() + std::time::Duration::from_secs(20);
    while fs::metadata(&partial).map_or(0, |found| found.len()) < 200_000 {
        assert!(std::time::Instant::now() < patience, "the log does not grow");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(kill.expect("kill is there").success());
    assert_eq!(run.wait().expect("ends").code(), Some(3));
    let found = verified(&log, 0);
    assert_eq!(found["same"], true, "{found:#}");
    assert!(found["messages_compared"].as_u64() > Some(1000), "{found:#}");
}

#[test]
fn a_prefix_that_agrees_is_not_the_whole() {
    let directory = directory("verify_prefix");
    for scene in [FINGER, DISCS] {
        let bytes = log(scene, Model::Engine, 3e5);
        let log = keep(&directory, "cut.mcap", &bytes[..2 * bytes.len() / 3]);
        let output = verify(&log);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(stderr(&output).contains("only a part of the run could be compared"), "{}", stderr(&output));
        let found = &json(&output)["verification"];
        assert_eq!((&found["same"], &found["complete"]), (&true.into(), &false.into()), "{found:#}");
        assert!(found["messages_compared"].as_u64() > Some(1000));
    }
}

#[test]
fn another_version_is_compared_all_the_same() {
    let directory = directory("verify_version");
    let bytes = log(FINGER, Model::Analytic, 1e4);
    let older = Changes {
        metadata: &|entries| {
            entries.insert("phalanx_version".to_string(), "0.0.9".to_string());
        },
        ..Changes::default()
    };
    let path = keep(&directory, "older.mcap", &changed(&bytes, &older));
    let found = verified(&path, 0);
    assert_eq!((&found["same"], &found["phalanx_version_log"]), (&true.into(), &"0.0.9".into()));
    let text = phalanx(&["replay", path.to_str().expect("text"), "--verify"]);
    assert!(stdout(&text).contains("the log is of phalanx 0.0.9, this is phalanx"), "{}", stdout(&text));
}

#[test]
fn what_cannot_be_simulated_again_is_bad_input() {
    let directory = directory("verify_refused");
    let bytes = log(FINGER, Model::Analytic, 1e4);
    let refused = |changes: &Changes<'_>, parts: &[&str]| {
        let path = keep(&directory, "refused.mcap", &changed(&bytes, changes));
        let output = verify(&path);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
        for part in parts {
            assert!(stderr(&output).contains(part), "no {part} in {}", stderr(&output));
        }
        // The summary is still there, though a run that is called completed cannot have been endless.
        let status = if parts[0] == "duration_s" { 1 } else { 0 };
        assert_eq!(phalanx(&["replay", path.to_str().expect("text")]).status.code(), Some(status));
    };
    type Entries = std::collections::BTreeMap<String, String>;
    let set = |key: &'static str, value: &'static str| {
        move |entries: &mut Entries| {
            entries.insert(key.to_string(), value.to_string());
        }
    };
    let with =
        |metadata: &dyn Fn(&mut Entries), parts: &[&str]| refused(&Changes { metadata, ..Changes::default() }, parts);
    with(&set("integrator_zeal", "11"), &["integrator_zeal", "does not know"]);
    with(&set("integrator_rtol", "lots"), &["integrator_rtol", "lots", "a number between 0 and 1"]);
    with(&set("duration_s", "inf"), &["duration_s", "a number above 0"]);
    with(&set("duration_s", "1e50"), &["duration_s", "a number above 0, and 3600 at most"]);
    with(&set("integrator_max_step_s", "1e9"), &["integrator_max_step_s"]);
    with(&set("log_numeric_hz", "1e11"), &["log_numeric_hz", "more than the 1e7"]);
    with(&set("integrator_method", "euler"), &["\"rodas5p\" or \"radau5\""]);
    with(&set("model", "wooden"), &["\"analytic\" or \"engine\""]);
    with(&|entries| drop(entries.remove("duration_s")), &["does not record `duration_s`"]);
    refused(&Changes { scene: &|_| None, ..Changes::default() }, &["no scene in the log"]);
    let other = fs::read_to_string(DISCS).expect("a scene");
    refused(&Changes { scene: &|_| Some(other.clone()), ..Changes::default() }, &["of another kind"]);
    let broken = |text: &str| Some(text.replace("[motor]", "[mortar]"));
    refused(&Changes { scene: &broken, ..Changes::default() }, &["cannot be read by this phalanx", "mortar"]);
}

#[test]
fn options_that_exclude_each_other_say_so() {
    let directory = directory("verify_options");
    let log = write(&directory, "run.mcap", "");
    let output = phalanx(&["replay", &log, "--verify", "--recover", "b.mcap"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("cannot be used with"), "{}", stderr(&output));
}
