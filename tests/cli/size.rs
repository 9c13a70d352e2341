//! `phalanx size`: tables, JSON, files and errors.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, assert_contains, assert_rejected, directory, succeed, succeed_json, write};
use serde_json::Value;

#[test]
fn table_compares_both_sizings_with_the_scene() {
    let text = succeed(&["size", EXPERIMENT_95]);
    assert_contains(&text, &["516.60            117.72  <-", "440.88            117.72", "480.00            132.60"]);
    for row in ["q21-q11", "q12", "q22", "q11+q12-(q21+q22)"] {
        assert!(text.lines().any(|line| line.starts_with(row)), "{row}\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
}

#[test]
fn json_agrees_with_self_sizing_scene() {
    let report = succeed_json(&["size", EXPERIMENT_95, "--rule", "whole"]);
    assert_eq!(report["rule"], "whole");
    assert_eq!(report["motor_n_m"], report["whole"]["motor_n_m"]);
    assert_eq!(report["given"]["motor_n_m"], 0.48);
    assert!(report["convergence_relative"].as_f64().unwrap() < 1e-6);

    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    let scene = write(&directory("size-scene"), "sized.toml", &format!("sizing = \"whole\"\n{design}"));
    assert_eq!(succeed_json(&["size", &scene])["given"], report["whole"]);
    let torsional = succeed_json(&["size", "scenes/torsional-spring.toml"]);
    assert_eq!(torsional["spring_types"][1]["preload_rad"], 110f64.to_radians(), "preload of the scene");
    // The torque is about inversely proportional to the square of the closing time.
    let fast_sizing = succeed_json(&["size", EXPERIMENT_95, "--closing-time", "5 ms"]);
    let ratio = fast_sizing["motor_n_m"].as_f64().unwrap() / report["rigid"]["motor_n_m"].as_f64().unwrap();
    assert!((3.9..4.1).contains(&ratio), "{ratio}");
}

#[test]
fn files_are_complete() {
    let out = directory("size-files");
    succeed(&["size", EXPERIMENT_95, "--out", out.to_str().unwrap()]);
    let read = |file: &str| fs::read_to_string(out.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    for svg in ["trajectory.svg", "springs.svg", "spring-types.svg"].map(read) {
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>") && !svg.contains("NaN"), "{svg}");
    }
    let csv = read("size.csv");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() > 400 && csv.lines().all(|line| line.split(',').count() == columns));
    assert_eq!(serde_json::from_str::<Value>(&read("size.json")).unwrap()["rule"], "rigid");
    assert_eq!(read("size.txt"), format!("Report by phalanx\n\n{}", succeed(&["size", EXPERIMENT_95])));
}

#[test]
fn unsizable_scenes_are_rejected() {
    for (args, parts) in [
        (&["scenes/free-swing.toml"][..], &["has no object"][..]),
        (&["scenes/other-assembly.toml"], &["no object"]),
        (&["scenes/laws/spring.toml"], &["kind \"finger\""]),
        (&[EXPERIMENT_95, "--closing-time", "0 ms"], &["--closing-time", "more than 0"]),
        (&[EXPERIMENT_95, "--preload=-1 deg"], &["--preload", "more than 0"]),
        (&[EXPERIMENT_95, "--out", "Cargo.toml/x"], &["cannot create the directory"]),
    ] {
        assert_rejected(&[&["size"], args].concat(), parts);
    }
}
