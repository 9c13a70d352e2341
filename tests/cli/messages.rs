//! Errors of new users are answered with the allowed values or with advice.

use std::fs;

use crate::support::cli::{self, EXPERIMENT_95, directory, phalanx, stderr, stdout, write};

/// Asserts that a command is rejected with a message of short lines.
#[track_caller]
fn assert_rejected(args: &[&str], parts: &[&str]) {
    cli::assert_rejected(args, parts);
    let output = phalanx(args);
    assert!(stderr(&output).lines().all(|line| line.chars().count() < 300), "{}", stderr(&output));
    assert!(!stderr(&output).contains("'-- -"), "{}", stderr(&output));
}

#[test]
fn errors_for_negative_numbers_name_the_range() {
    assert_rejected(&["run", EXPERIMENT_95, "--rtol", "-1"], &["'-1' for '--rtol", "between 0 and 1"]);
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "-1 ms"], &["longer than 0", "30 ms"]);
    assert_rejected(&["run", EXPERIMENT_95, "--numeric-rate", "-1 Hz"], &["more than 0", "10 kHz"]);
    assert_rejected(&["run", EXPERIMENT_95, "--model", "engine", "--step", "-1 us"], &["longer than 0", "1 us"]);
    assert_rejected(&["statics", EXPERIMENT_95, "--mu-static", "-1"], &["'-1' for '--mu-static", "0 or more"]);
    assert_rejected(&["volume", "--mu-static", "-1"], &["`-1`", "0 or more"]);
    assert_rejected(&["volume", "--base", "-1 mm"], &["more than 0", "12 mm"]);
    assert_rejected(&["volume", "--resolution", "-1"], &["`-1`", "1 or more"]);
    assert_rejected(&["select", "none.csv", "--max-rebound", "-1"], &["percentage of 0 or more"]);
    assert_rejected(&["select", "none.csv", "--best", "-1"], &["0 or more"]);
    assert_rejected(&["sweep", "none.toml", "--out", "x.csv", "--limit", "-1"], &["1 or more"]);
    assert_rejected(&["reproduce", "--threads", "-1"], &["threads from 1 to 1024"]);
    assert_rejected(&["study", "stability", EXPERIMENT_95, "--stiffness", "-1"], &["above 0"]);
    // A flag is not accepted as the name of a file.
    assert_rejected(&["run", EXPERIMENT_95, "--log", "--json"], &["--log"]);
}

#[test]
fn mistyped_units_and_commands_get_suggestions() {
    assert_rejected(&["statics", EXPERIMENT_95, "--motor", "480 Nmm"], &["`Nmm` (did you mean N*mm?)"]);
    let directory = directory("messages_units");
    let text = fs::read_to_string(EXPERIMENT_95).expect("the scene");
    let scene = |name: &str, from: &str, to: &str| write(&directory, name, &text.replace(from, to));
    assert_rejected(&["run", &scene("nm.toml", "480 N*mm", "0.48 Nm")], &["nm.toml:12", "did you mean N*m?", "N*mm"]);
    assert_rejected(
        &["run", &scene("far.toml", "\"15.5 mm\"", "\"1e300 mm\"")],
        &["far.toml:6", "too large", "1000 m at most"],
    );
    assert_rejected(&["rn"], &["'run'"]);
    assert_rejected(&["scene", "shw"], &["'show'"]);
}

#[test]
fn long_texts_are_shortened_in_messages() {
    let (dir, long) = (directory("messages_long"), "a".repeat(100_000));
    assert_rejected(&["run", EXPERIMENT_95, "--set", &long], &["there is no `=`"]);
    assert_rejected(&["run", EXPERIMENT_95, "--set", &format!("{long}=1")], &["unknown key"]);
    let long_field = format!("object.radius={}", "a ".repeat(50_000));
    for args in [["run", EXPERIMENT_95, "--set", &long_field], ["hold", EXPERIMENT_95, "--from", &long]] {
        assert!((10..3000).contains(&stderr(&phalanx(&args)).len()), "{}", stderr(&phalanx(&args)));
    }
    // Only a hundred keys are examined. Comparing every key with every other would take minutes.
    let keys: String = (0..60_000).map(|key| format!("k{key} = 1\n")).collect();
    assert_rejected(&["run", &write(&dir, "keys.toml", &keys), "--set", "palm=false"], &["100 problems or more"]);
}

#[test]
fn endless_and_empty_requests_are_rejected() {
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "1e300s"], &["too large", "3600 s at most"]);
    assert_rejected(&["volume", "--base", "155mm", "--resolution", "2"], &["no design exists", "must be below"]);
}

#[test]
fn log_given_as_scene_is_rejected() {
    let log = &cli::path_in(&directory("messages_log"), "closing.mcap");
    cli::succeed(&["run", EXPERIMENT_95, "--log", log]);
    let suggestion = format!("phalanx replay {log}");
    for command in ["run", "validate", "statics", "size"] {
        assert_rejected(&[command, log], &["is the log of a run (MCAP), not a scene", &suggestion]);
    }
}

#[test]
fn help_of_value_names_is_well_formed() {
    let output = phalanx(&["select", "--help"]);
    assert!(stdout(&output).contains("--bound <BOUND>") && stdout(&output).contains("COLUMN >= VALUE"));
    for command in ["run", "validate", "replay", "size", "statics", "volume", "sweep", "select", "reproduce"] {
        let help = phalanx(&[command, "--help"]);
        let flags = stdout(&help).lines().filter(|line| line.trim_start().starts_with("--"));
        for line in flags {
            assert_eq!(line.matches('<').count(), line.matches('>').count(), "{line}");
        }
    }
}
