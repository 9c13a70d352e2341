//! What a newcomer gets wrong is answered with what is allowed, or with the way out.

use std::fs;

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, stdout, write};

/// Refused with status 2 in a few lines that say each of `parts`.
#[track_caller]
fn refused(args: &[&str], parts: &[&str]) {
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {message}");
    for part in parts {
        assert!(message.contains(part), "{args:?}: no {part:?} in {message}");
    }
    assert!(!message.contains("'-- -"), "{message}");
    assert!(message.lines().all(|line| line.chars().count() < 300), "{message}");
}

#[test]
fn negative_numbers_are_told_the_range() {
    refused(&["run", ANCHOR, "--rtol", "-1"], &["'-1' for '--rtol", "between 0 and 1"]);
    refused(&["run", ANCHOR, "--duration", "-1 ms"], &["longer than 0", "30 ms"]);
    refused(&["run", ANCHOR, "--numeric-rate", "-1 Hz"], &["more than 0", "10 kHz"]);
    refused(&["run", ANCHOR, "--model", "engine", "--step", "-1 us"], &["longer than 0", "1 us"]);
    refused(&["statics", ANCHOR, "--mu-static", "-1"], &["'-1' for '--mu-static", "0 or more"]);
    refused(&["volume", "--mu-static", "-1"], &["`-1`", "from 0"]);
    refused(&["volume", "--base", "-1 mm"], &["more than 0", "12 mm"]);
    refused(&["volume", "--resolution", "-1"], &["`-1`", "from 1"]);
    refused(&["select", "none.csv", "--max-rebound", "-1"], &["percent from 0"]);
    refused(&["select", "none.csv", "--best", "-1"], &["from 0"]);
    refused(&["sweep", "none.toml", "--out", "x.csv", "--limit", "-1"], &["runs from 1"]);
    refused(&["reproduce", "--threads", "-1"], &["threads from 1 to 1024"]);
    refused(&["study", "stability", ANCHOR, "--stiffness", "-1"], &["above 0"]);
    // A flag is still not taken for the name of a file.
    refused(&["run", ANCHOR, "--log", "--json"], &["--log"]);
}

#[test]
fn units_and_commands_that_are_nearly_right_are_suggested() {
    refused(&["statics", ANCHOR, "--motor", "480 Nmm"], &["`Nmm`; did you mean N*mm?"]);
    let directory = directory("messages_units");
    let text = fs::read_to_string(ANCHOR).expect("the scene");
    let scene = |name: &str, from: &str, to: &str| write(&directory, name, &text.replace(from, to));
    refused(&["run", &scene("nm.toml", "480 N*mm", "0.48 Nm")], &["nm.toml:12", "did you mean N*m?", "N*mm"]);
    refused(
        &["run", &scene("far.toml", "\"15.5 mm\"", "\"1e300 mm\"")],
        &["far.toml:6", "too large", "1000 m at most"],
    );
    refused(&["rn"], &["'run'"]);
    refused(&["scene", "shw"], &["'show'"]);
}

#[test]
fn texts_that_nobody_reads_are_shortened_wherever_they_are_given() {
    let (dir, long) = (directory("messages_long"), "a".repeat(100_000));
    refused(&["run", ANCHOR, "--set", &long], &["there is no `=`"]);
    refused(&["run", ANCHOR, "--set", &format!("{long}=1")], &["unknown key"]);
    let words = format!("object.radius={}", "a ".repeat(50_000));
    for args in [["run", ANCHOR, "--set", &words], ["hold", ANCHOR, "--from", &long]] {
        assert!((10..3000).contains(&stderr(&phalanx(&args)).len()), "{}", stderr(&phalanx(&args)));
    }
    // A hundred keys are looked at, and the others cost nothing: this takes minutes where every key is compared with every other.
    let keys: String = (0..60_000).map(|key| format!("k{key} = 1\n")).collect();
    refused(&["run", &write(&dir, "keys.toml", &keys), "--set", "palm=false"], &["100 problems or more"]);
}

#[test]
fn what_would_take_for_ever_or_give_nothing_is_refused() {
    refused(&["run", ANCHOR, "--duration", "1e300s"], &["too large", "3600 s at most"]);
    refused(&["volume", "--base", "155mm", "--resolution", "2"], &["no design exists", "must be below"]);
}

#[test]
fn a_log_is_not_taken_for_a_scene() {
    let log = directory("messages_log").join("closing.mcap");
    let log = log.to_str().expect("text");
    assert_eq!(phalanx(&["run", ANCHOR, "--log", log]).status.code(), Some(0));
    let way = format!("phalanx replay {log}");
    for command in ["run", "validate", "statics", "size"] {
        refused(&[command, log], &["is the log of a run (MCAP), not a scene", &way]);
    }
}

#[test]
fn the_help_of_a_bound_is_well_formed() {
    let output = phalanx(&["select", "--help"]);
    assert!(stdout(&output).contains("--bound <BOUND>") && stdout(&output).contains("COLUMN >= VALUE"));
    for command in
        ["run", "validate", "replay", "size", "statics", "volume", "sweep", "select", "optimize", "reproduce"]
    {
        let help = phalanx(&[command, "--help"]);
        let flags = stdout(&help).lines().filter(|line| line.trim_start().starts_with("--"));
        for line in flags {
            assert_eq!(line.matches('<').count(), line.matches('>').count(), "{line}");
        }
    }
}
