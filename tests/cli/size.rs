//! `phalanx size`: its tables, its JSON, its files, its refusals.

use std::fs;

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, write};
use serde_json::Value;

fn done(args: &[&str]) -> String {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    crate::support::cli::stdout(&output).to_string()
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&done(args)).unwrap()
}

fn refused(args: &[&str], parts: &[&str]) {
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(message.contains(part), "{args:?}: {part:?} is not in {message}");
    }
}

#[test]
fn the_table_says_both_sizings_and_what_the_scene_has() {
    let text = done(&["size", ANCHOR]);
    for line in ["516.60            117.72    <-", "440.88            117.72", "480.00            132.60"] {
        assert!(text.contains(line), "{line}\n{text}");
    }
    for place in ["q21-q11", "q12", "q22", "q11+q12-(q21+q22)"] {
        assert!(text.lines().any(|line| line.starts_with(place)), "{place}\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
}

#[test]
fn the_json_has_the_chosen_rule_and_agrees_with_a_scene_that_sizes_itself() {
    let report = json(&["size", ANCHOR, "--rule", "whole", "--json"]);
    assert_eq!(report["rule"], "whole");
    assert_eq!(report["motor_n_m"], report["whole"]["motor_n_m"]);
    assert_eq!(report["given"]["motor_n_m"], 0.48);
    assert!(report["convergence_relative"].as_f64().unwrap() < 1e-6);

    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    let scene = write(&directory("size-scene"), "sized.toml", &format!("sizing = \"whole\"\n{design}"));
    let sized = json(&["size", &scene, "--json"]);
    assert_eq!(sized["given"], report["whole"]);
    let torsional = json(&["size", "scenes/torsional-spring.toml", "--json"]);
    assert_eq!(torsional["spring_types"][1]["preload_rad"], 110f64.to_radians(), "the scene's own");
    // Faster takes more, about as the square of the time.
    let fast = json(&["size", ANCHOR, "--closing-time", "5 ms", "--json"]);
    let ratio = fast["motor_n_m"].as_f64().unwrap() / report["rigid"]["motor_n_m"].as_f64().unwrap();
    assert!((3.9..4.1).contains(&ratio), "{ratio}");
}

#[test]
fn files_are_written_whole() {
    let out = directory("size-files");
    done(&["size", ANCHOR, "--out", out.to_str().unwrap()]);
    let read = |file: &str| fs::read_to_string(out.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    for picture in ["trajectory.svg", "springs.svg", "spring-types.svg"] {
        let svg = read(picture);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{picture}");
        assert!(!svg.contains("NaN"), "{picture}");
    }
    let csv = read("size.csv");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() > 400);
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    assert_eq!(serde_json::from_str::<Value>(&read("size.json")).unwrap()["rule"], "rigid");
    assert_eq!(read("size.txt"), done(&["size", ANCHOR]));
}

#[test]
fn what_cannot_be_sized_is_refused() {
    refused(&["size", "scenes/free-swing.toml"], &["no object to close on"]);
    refused(&["size", "scenes/other-assembly.toml"], &["no object"]);
    refused(&["size", "scenes/laws/spring.toml"], &["kind \"finger\""]);
    refused(&["size", ANCHOR, "--closing-time", "0 ms"], &["--closing-time", "takes some time"]);
    refused(&["size", ANCHOR, "--preload=-1 deg"], &["--preload", "more than 0"]);
    refused(&["size", ANCHOR, "--out", "Cargo.toml/x"], &["cannot make the directory"]);
}
