//! `phalanx replay` as a user meets it: the same figures as the run's own summary, from the log alone.

mod cli_support;

use std::fs;
use std::path::Path;

use cli_support::{ANCHOR, directory, json, phalanx, stderr, stdout, variant, write};
use serde_json::Value;

/// Runs the anchor case into a log; returns its report.
fn logged(log: &Path, more: &[&str]) -> Value {
    let output = phalanx(&[&["run", ANCHOR, "--json", "--log", log.to_str().expect("text")], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    json(&output)
}

fn replay(log: &Path) -> std::process::Output {
    phalanx(&["replay", log.to_str().expect("text"), "--json"])
}

#[test]
fn a_log_says_what_its_run_said() {
    let directory = directory("cli_replay");
    for model in ["analytic", "engine"] {
        let log = directory.join(format!("{model}.mcap"));
        let run = logged(&log, &["--model", model]);
        let output = replay(&log);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stderr(&output), "");
        let found = json(&output);
        for key in ["scene", "model", "duration_s", "end_s", "completed", "final", "energy", "criteria"] {
            assert_eq!(found[key], run[key], "{model} {key}");
        }
        assert_eq!(found["whole"], true);
        assert_eq!(found["losses"], Value::Array(Vec::new()));
        assert_eq!(found["error"], Value::Null);
        assert!(found["events"].as_u64() >= run["work"]["events"].as_u64());
        assert!(found["samples"].as_u64().expect("a count") > 201);
        for site in ["proximal", "distal"] {
            let (found, run) = (&found["contacts"][site], &run["contacts"][site]);
            for key in ["first_s", "touchdowns", "final_normal_n", "final_tangential_n"] {
                assert_eq!(found[key], run[key], "{model} {site} {key}");
            }
            let ratio = |key: &str| found[key].as_f64().expect("a figure") / run[key].as_f64().expect("a figure");
            assert!((ratio("impulse_n_s") - 1.0).abs() < 1e-9, "{model} {site}");
            // Samples see no more of a peak than there is, and most of it: impacts are logged at every step.
            assert!(ratio("peak_normal_n") < 1.0 + 1e-12, "{model} {site} {}", ratio("peak_normal_n"));
            assert!(model == "engine" || ratio("peak_normal_n") > 0.5, "{site} {}", ratio("peak_normal_n"));
        }
        let output = phalanx(&["replay", log.to_str().expect("text")]);
        let text = stdout(&output);
        for part in ["experiment-95: ", model, "completed, 20 ms", "2.0887", "4.5013", "stable", "peaks and depths"] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
    }
}

#[test]
fn a_truncated_log_is_summarised_up_to_there_with_status_1() {
    let directory = directory("cli_replay_cut");
    let whole = directory.join("whole.mcap");
    let scene = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"100 kHz\"");
    let output = phalanx(&["run", &scene, "--log", whole.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let bytes = fs::read(&whole).expect("the log");
    let log = directory.join("cut.mcap");
    fs::write(&log, &bytes[..bytes.len() / 2]).expect("written");
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("truncated") && stderr(&output).contains("cut.mcap"), "{}", stderr(&output));
    let found = json(&output);
    assert_eq!((&found["whole"], &found["completed"], &found["criteria"]), (&false.into(), &Value::Null, &Value::Null));
    assert_eq!(found["losses"].as_array().expect("a list").len(), 1);
    let end_s = found["end_s"].as_f64().expect("a time");
    assert!(end_s > 0.004 && end_s < 0.02, "{end_s}");
    let output = phalanx(&["replay", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("NOT COMPLETE: the log reaches") && stdout(&output).contains("LOST: "));

    let mut damaged = bytes.clone();
    damaged[bytes.len() / 3] ^= 0x10;
    fs::write(&log, damaged).expect("written");
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("damaged at byte"), "{}", stderr(&output));
    assert!(json(&output)["losses"][0]["readable_behind"].as_u64().expect("a count") > 1000);
}

#[test]
fn a_run_that_broke_off_is_a_whole_log() {
    let directory = directory("cli_replay_budget");
    let scene = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40");
    let log = directory.join("run.mcap");
    let output = phalanx(&["run", &scene, "--log", log.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(3));
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let found = json(&output);
    assert_eq!((&found["completed"], &found["whole"]), (&false.into(), &true.into()));
    assert!(found["error"]["reason"].as_str().expect("a reason").contains("budget of 40"), "{found}");
    assert_eq!(found["criteria"], Value::Null);
}

#[test]
fn what_is_no_log_is_bad_input() {
    let directory = directory("cli_replay_bad");
    let refused = |path: &Path, parts: &[&str]| {
        let output = replay(path);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
        assert!(stderr(&output).starts_with("error: "), "{}", stderr(&output));
        for part in parts {
            assert!(stderr(&output).contains(part), "no {part} in {}", stderr(&output));
        }
    };
    refused(&directory.join("no.mcap"), &["there is no log", "no.mcap", "check the path"]);
    refused(&directory, &["is a directory"]);
    refused(Path::new(ANCHOR), &["not an MCAP file", ANCHOR]);
    write(&directory, "left.mcap.partial", "");
    refused(&directory.join("left.mcap"), &["left.mcap.partial", "has not finished"]);
    refused(&directory.join("left.mcap.partial"), &["not an MCAP file"]);
}
