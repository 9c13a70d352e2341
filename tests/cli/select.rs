//! `phalanx select`: status, files, JSON and messages.

use std::fs;
use std::path::Path;

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, path_text, stdout, succeed, succeed_json,
};
use crate::support::sweep_results::{results_table, successful_run};
use phalanx::table;

/// Writes results with two selected runs and one rejected run.
fn write_results(directory: &Path) -> String {
    let runs = [
        successful_run(1, 7e-3, [10.0, 30.0, 4.0]),
        successful_run(2, 5e-3, [5.0, 20.0, 6.0]),
        successful_run(3, 6e-3, [1.0, 2.0, 3.0]).with("form_closed", false),
    ];
    let path = directory.join("results.parquet");
    table::write(&path, &results_table(&runs)).expect("written");
    path_text(&path).to_string()
}

#[test]
fn tables_json_and_files_agree() {
    let directory = directory("select-files");
    let file = write_results(&directory);
    let (out, best) = (directory.join("out"), directory.join("best.parquet"));
    let output = succeed(&["select", &file, "--out", path_text(&out), "--ranking", path_text(&best)]);
    assert_contains(&output, &["2 of 3 runs meet all criteria"]);
    for name in ["criteria.svg", "classes.svg", "static.svg", "forces.svg", "variables.svg"] {
        assert!(fs::read_to_string(out.join(name)).expect(name).starts_with("<svg"), "{name}");
    }
    let document = succeed_json(&["select", &file]);
    let mut saved: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("selection.json")).expect("readable")).expect("JSON");
    assert_eq!(saved.as_object_mut().expect("an object").remove("generator"), Some("phalanx".into()));
    assert_eq!(document, saved);
    assert_eq!((&document["selected"], &document["ranking"][0]["run"]), (&2.into(), &2.into()));
    // Scaled values of both runs: PFP 0 and 1; tts, F21 and F22 1 and 0.
    assert_eq!(document["ranking"][0]["r_wc"], 0.75);
    let ranking = table::read(&best).expect("the ranking");
    assert_eq!(ranking.integers("run").expect("runs"), [Some(2), Some(1)]);
    assert_eq!(table::read(&out.join("ranking.csv")).expect("the ranking").rows.len(), 2);
}

#[test]
fn empty_selection_is_status_1_and_bad_input_status_2() {
    let directory = directory("select-status");
    let file = write_results(&directory);
    let empty_selection = assert_status(&["select", &file, "--min-pfp", "50 N"], 1, &[]);
    assert_contains(stdout(&empty_selection), &["\"PFP ≥ 50 N\" removed the last"]);
    let any = succeed_json(&["select", &file, "--no-form-closed", "--min-pfp", "-1 N", "--best", "1"]);
    assert_eq!(any["selected"], 3);
    for (args, message) in [
        (vec!["select", "none.csv"], "none.csv"),
        (vec!["select", "Cargo.toml"], "Cargo.toml"),
        (vec!["select", &file, "--class", "good"], "semi-stable"),
        (vec!["select", &file, "--max-tts", "8"], "unit"),
        (vec!["select", &file, "--max-tts", "0 s"], "more than 0"),
        (vec!["select", &file, "--bound", "weight_kg <= 1"], "weight_kg"),
        (vec!["select", &file, "--weights", "pfp=0"], "all weights are 0"),
        (vec!["select", &file, "--ranking", "best.txt"], ".parquet"),
    ] {
        assert_rejected(&args, &[message]);
    }
}
