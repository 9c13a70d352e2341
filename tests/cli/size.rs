//! `phalanx size`: tables, JSON, files and errors.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, directory, phalanx, stderr, write};
use serde_json::Value;

fn run_ok(args: &[&str]) -> String {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    crate::support::cli::stdout(&output).to_string()
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&run_ok(args)).unwrap()
}

fn assert_rejected(args: &[&str], parts: &[&str]) {
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(message.contains(part), "{args:?}: {part:?} is not in {message}");
    }
}

#[test]
fn table_compares_both_sizings_with_the_scene() {
    let text = run_ok(&["size", EXPERIMENT_95]);
    for line in ["516.60            117.72    <-", "440.88            117.72", "480.00            132.60"] {
        assert!(text.contains(line), "{line}\n{text}");
    }
    for row in ["q21-q11", "q12", "q22", "q11+q12-(q21+q22)"] {
        assert!(text.lines().any(|line| line.starts_with(row)), "{row}\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
}

#[test]
fn json_agrees_with_self_sizing_scene() {
    let report = json(&["size", EXPERIMENT_95, "--rule", "whole", "--json"]);
    assert_eq!(report["rule"], "whole");
    assert_eq!(report["motor_n_m"], report["whole"]["motor_n_m"]);
    assert_eq!(report["given"]["motor_n_m"], 0.48);
    assert!(report["convergence_relative"].as_f64().unwrap() < 1e-6);

    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    let scene = write(&directory("size-scene"), "sized.toml", &format!("sizing = \"whole\"\n{design}"));
    let sizing = json(&["size", &scene, "--json"]);
    assert_eq!(sizing["given"], report["whole"]);
    let torsional = json(&["size", "scenes/torsional-spring.toml", "--json"]);
    assert_eq!(torsional["spring_types"][1]["preload_rad"], 110f64.to_radians(), "preload of the scene");
    // The torque is about inversely proportional to the square of the closing time.
    let fast_sizing = json(&["size", EXPERIMENT_95, "--closing-time", "5 ms", "--json"]);
    let ratio = fast_sizing["motor_n_m"].as_f64().unwrap() / report["rigid"]["motor_n_m"].as_f64().unwrap();
    assert!((3.9..4.1).contains(&ratio), "{ratio}");
}

#[test]
fn files_are_complete() {
    let out = directory("size-files");
    run_ok(&["size", EXPERIMENT_95, "--out", out.to_str().unwrap()]);
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
    assert_eq!(read("size.txt"), format!("Report by phalanx\n\n{}", run_ok(&["size", EXPERIMENT_95])));
}

#[test]
fn unsizable_scenes_are_rejected() {
    assert_rejected(&["size", "scenes/free-swing.toml"], &["has no object"]);
    assert_rejected(&["size", "scenes/other-assembly.toml"], &["no object"]);
    assert_rejected(&["size", "scenes/laws/spring.toml"], &["kind \"finger\""]);
    assert_rejected(&["size", EXPERIMENT_95, "--closing-time", "0 ms"], &["--closing-time", "more than 0"]);
    assert_rejected(&["size", EXPERIMENT_95, "--preload=-1 deg"], &["--preload", "more than 0"]);
    assert_rejected(&["size", EXPERIMENT_95, "--out", "Cargo.toml/x"], &["cannot create the directory"]);
}
