//! `phalanx select` as a command: status, files, JSON, messages.

use std::fs;
use std::path::Path;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use crate::support::select::{Made, good, results};
use phalanx::table;

/// Two that are selected and one that is not.
fn written(directory: &Path) -> String {
    let made = [
        good(1, 7e-3, [10.0, 30.0, 4.0]),
        good(2, 5e-3, [5.0, 20.0, 6.0]),
        Made { form_closed: Some(false), ..good(3, 6e-3, [1.0, 2.0, 3.0]) },
    ];
    let path = directory.join("results.parquet");
    table::write(&path, &results(&made)).expect("written");
    path.to_str().expect("plain text").to_string()
}

#[test]
fn tables_json_and_files_say_the_same() {
    let here = directory("select-files");
    let file = written(&here);
    let (out, best) = (here.join("out"), here.join("best.parquet"));
    let output = phalanx(&["select", &file, "--out", out.to_str().unwrap(), "--ranking", best.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("2 of 3 runs meet all criteria"), "{}", stdout(&output));
    for name in ["criteria.svg", "classes.svg", "static.svg", "forces.svg", "variables.svg"] {
        assert!(fs::read_to_string(out.join(name)).expect(name).starts_with("<svg"), "{name}");
    }
    let document = json(&phalanx(&["select", &file, "--json"]));
    let saved: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("selection.json")).expect("saved")).expect("JSON");
    assert_eq!(document, saved);
    assert_eq!((&document["selected"], &document["ranking"][0]["run"]), (&2.into(), &2.into()));
    // PFP 0 against 1; tts, F21 and F22 1 against 0.
    assert_eq!(document["ranking"][0]["r_wc"], 0.75);
    let ranking = table::read(&best).expect("the ranking");
    assert_eq!(ranking.integers("run").expect("runs"), [Some(2), Some(1)]);
    assert_eq!(table::read(&out.join("ranking.csv")).expect("the ranking").rows.len(), 2);
}

#[test]
fn none_left_is_status_1_and_wrong_input_status_2() {
    let here = directory("select-status");
    let file = written(&here);
    let none = phalanx(&["select", &file, "--min-pfp", "50 N"]);
    assert_eq!(none.status.code(), Some(1));
    assert!(stdout(&none).contains("\"PFP ≥ 50 N\" removed the last"), "{}", stdout(&none));
    let any = phalanx(&["select", &file, "--no-form-closed", "--min-pfp", "-1 N", "--best", "1", "--json"]);
    assert_eq!((any.status.code(), &json(&any)["selected"]), (Some(0), &3.into()));
    for (args, words) in [
        (vec!["select", "none.csv"], "none.csv"),
        (vec!["select", ANY], "Cargo.toml"),
        (vec!["select", &file, "--class", "good"], "semi-stable"),
        (vec!["select", &file, "--max-tts", "8"], "unit"),
        (vec!["select", &file, "--bound", "weight_kg <= 1"], "weight_kg"),
        (vec!["select", &file, "--weights", "pfp=0"], "all weights are 0"),
        (vec!["select", &file, "--ranking", "best.txt"], ".parquet"),
    ] {
        let output = phalanx(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(words), "{args:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
}

const ANY: &str = "Cargo.toml";
