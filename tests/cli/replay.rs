//! `phalanx replay`: gives the same figures from the log as the summary of the run.

use std::fs;
use std::path::Path;

use crate::support::cli::{EXPERIMENT_95, directory, json, phalanx, stderr, stdout, variant, write};
use serde_json::Value;

/// Runs experiment-95 with a log; returns its report.
fn write_log(log: &Path, more: &[&str]) -> Value {
    let output =
        phalanx(&[&["run", EXPERIMENT_95, "--json", "--log", log.to_str().expect("UTF-8 path")], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    json(&output)
}

fn replay(log: &Path) -> std::process::Output {
    phalanx(&["replay", log.to_str().expect("UTF-8 path"), "--json"])
}

#[test]
fn replay_report_equals_run_report() {
    let directory = directory("cli_replay");
    for model in ["analytic", "engine"] {
        let log = directory.join(format!("{model}.mcap"));
        let run = write_log(&log, &["--model", model]);
        let output = replay(&log);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert_eq!(stderr(&output), "");
        let actual = json(&output);
        for key in ["scene", "model", "duration_s", "end_s", "completed", "final", "energy", "criteria"] {
            assert_eq!(actual[key], run[key], "{model} {key}");
        }
        for key in ["integrator", "engine"] {
            assert_eq!(actual[key], run[key], "{model} {key}");
        }
        assert_eq!((&actual["kind"], &actual["log_numeric_hz"]), (&"finger".into(), &1e4.into()));
        assert_eq!(actual["settings"]["scene_file"], "experiment-95.toml");
        assert_eq!(actual["verification"], Value::Null);
        assert_eq!(actual["whole"], true);
        assert_eq!(actual["losses"], Value::Array(Vec::new()));
        assert_eq!(actual["error"], Value::Null);
        assert!(actual["events"].as_u64() >= run["work"]["events"].as_u64());
        assert!(actual["samples"].as_u64().expect("a count") > 201);
        for name in ["proximal", "distal"] {
            let (actual, run) = (&actual["contacts"][name], &run["contacts"][name]);
            for key in [
                "first_s",
                "touchdowns",
                "final_normal_n",
                "final_tangential_n",
                "peak_normal_n",
                "max_penetration_m",
                "impulse_n_s",
            ] {
                assert_eq!(actual[key], run[key], "{model} {name} {key}");
            }
        }
        assert_eq!(actual["contacts"]["limit"], run["contacts"]["limit"], "{model}");
        let output = phalanx(&["replay", log.to_str().expect("UTF-8 path")]);
        let text = stdout(&output);
        let settings =
            if model == "engine" { "maximal construction" } else { "rodas5p (rtol 1e-5, engineering preset)" };
        for part in ["experiment-95: ", model, "completed, 20 ms", "2.0887", "4.5013", "stable", settings] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
    }
}

#[test]
fn truncated_log_is_summarised_with_status_1() {
    let directory = directory("cli_replay_cut");
    let complete = directory.join("whole.mcap");
    let scene = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"100 kHz\"");
    let output = phalanx(&["run", &scene, "--log", complete.to_str().expect("UTF-8 path")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let bytes = fs::read(&complete).expect("the log");
    let log = directory.join("cut.mcap");
    fs::write(&log, &bytes[..bytes.len() / 2]).expect("written");
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("truncated") && stderr(&output).contains("cut.mcap"), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(
        (&report["whole"], &report["completed"], &report["criteria"]),
        (&false.into(), &Value::Null, &Value::Null)
    );
    assert_eq!(report["losses"].as_array().expect("a list").len(), 1);
    let end_s = report["end_s"].as_f64().expect("a time");
    assert!(end_s > 0.004 && end_s < 0.02, "{end_s}");
    let output = phalanx(&["replay", log.to_str().expect("UTF-8 path")]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("NOT COMPLETE: the log reaches") && stdout(&output).contains("LOST: "));

    let mut damaged = bytes.clone();
    damaged[bytes.len() / 3] ^= 0x10;
    fs::write(&log, damaged).expect("written");
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stderr(&output).contains("damaged at byte"), "{}", stderr(&output));
    assert!(json(&output)["losses"][0]["what"].as_str().is_some_and(|what| what.contains("mcap recover")));
}

#[test]
fn log_of_incomplete_run_is_complete() {
    let directory = directory("cli_replay_budget");
    let scene = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40");
    let log = directory.join("run.mcap");
    let output = phalanx(&["run", &scene, "--log", log.to_str().expect("UTF-8 path")]);
    assert_eq!(output.status.code(), Some(3));
    let output = replay(&log);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!((&report["completed"], &report["whole"]), (&false.into(), &true.into()));
    assert!(report["error"]["reason"].as_str().expect("a reason").contains("budget of 40"), "{report}");
    assert_eq!(report["criteria"], Value::Null);
}

#[test]
fn non_logs_are_bad_input() {
    let directory = directory("cli_replay_bad");
    let assert_rejected = |path: &Path, parts: &[&str]| {
        let output = replay(path);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
        assert!(stderr(&output).starts_with("error: "), "{}", stderr(&output));
        for part in parts {
            assert!(stderr(&output).contains(part), "no {part} in {}", stderr(&output));
        }
    };
    assert_rejected(&directory.join("no.mcap"), &["there is no log", "no.mcap", "check the path"]);
    assert_rejected(&directory, &["is a directory"]);
    assert_rejected(Path::new(EXPERIMENT_95), &["not an MCAP file", EXPERIMENT_95]);
    write(&directory, "left.mcap.partial", "");
    assert_rejected(&directory.join("left.mcap"), &["left.mcap.partial", "the log of an unfinished run"]);
    assert_rejected(&directory.join("left.mcap.partial"), &["not an MCAP file"]);
}

/// Column names and rows of a table.
fn table(text: &str) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().expect("names").split(',').map(String::from).collect();
    let cell = |text: &str| (!text.is_empty()).then(|| text.parse().expect("a number"));
    let rows: Vec<Vec<_>> = lines.map(|line| line.split(',').map(cell).collect()).collect();
    assert!(rows.iter().all(|row| row.len() == names.len()));
    (names, rows)
}

#[test]
fn replay_report_of_discs_equals_run_report() {
    let directory = directory("cli_replay_discs");
    for (scene, model, pair) in [
        ("scenes/laws/impact.toml", "analytic", "hammer-anvil"),
        ("scenes/laws/impact.toml", "engine", "hammer-anvil"),
        ("scenes/laws/rolling.toml", "analytic", ""),
        ("scenes/laws/two-free.toml", "engine", ""),
    ] {
        let log = directory.join("run.mcap");
        let name = log.to_str().expect("UTF-8 path");
        let output = phalanx(&["run", scene, "--model", model, "--json", "--log", name]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let run = json(&output);
        let output = replay(&log);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        let contact = json(&output);
        for key in
            ["scene", "kind", "model", "duration_s", "end_s", "completed", "discs", "energy", "integrator", "engine"]
        {
            assert_eq!(contact[key], run[key], "{scene} {model} {key}");
        }
        assert_eq!((&contact["final"], &contact["criteria"]), (&Value::Null, &Value::Null));
        for (name, expected) in run["contacts"].as_object().expect("pairs") {
            let contact = &contact["contacts"][name];
            for (key, expected) in expected.as_object().expect("figures") {
                let figures = [&contact[key], expected].map(Value::as_f64);
                match (key.as_str(), figures) {
                    // At rest both vary by rounding errors, and the run evaluates them only at steps.
                    ("peak_normal_n" | "max_penetration_m", [Some(contact), Some(expected)]) => {
                        assert!((contact - expected).abs() <= 1e-12 * expected, "{scene} {model} {name} {key}");
                    }
                    _ => assert_eq!(&contact[key], expected, "{scene} {model} {name} {key}"),
                }
            }
        }
        let text = phalanx(&["replay", name]);
        assert!(stdout(&text).contains(pair) && stdout(&text).contains("restitution"), "{}", stdout(&text));
    }
}

/// A number after writing and parsing as JSON. The written number is exact, but this parser may be off by the last bit.
fn read_back(value: f64) -> f64 {
    let text = serde_json::to_string(&value).expect("a number");
    serde_json::from_str(&text).expect("a number")
}

#[test]
fn every_sample_is_a_line_of_the_table() {
    let directory = directory("cli_replay_csv");
    for (scene, columns, ends) in [
        (EXPERIMENT_95, 42, [("q11_rad", "/final/q11_rad"), ("distal_normal_n", "/contacts/distal/final_normal_n")]),
        ("scenes/free-swing.toml", 42, [("q21_rad", "/final/q21_rad"), ("kinetic_j", "/energy/kinetic_j")]),
        (
            "scenes/laws/impact.toml",
            30,
            [("hammer_x_m", "/discs/hammer/x_m"), ("hammer-anvil_impulse_n_s", "/contacts/hammer-anvil/impulse_n_s")],
        ),
    ] {
        let (log, csv) = (directory.join("run.mcap"), directory.join("run.csv"));
        let names = [&log, &csv].map(|path| path.to_str().expect("UTF-8 path"));
        let (run_csv, page) = (directory.join("of-run.csv"), directory.join("page.html"));
        let run_csv = run_csv.to_str().expect("UTF-8 path");
        let output = phalanx(&["run", scene, "--log", names[0], "--csv", run_csv]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stdout(&output).contains(&format!("\nsamples: {run_csv}\n")), "{}", stdout(&output));
        let html = page.to_str().expect("UTF-8 path");
        let output = phalanx(&["replay", names[0], "--csv", names[1], "--html", html, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = json(&output);
        assert_eq!((&report["csv"], &report["page"]), (&names[1].into(), &html.into()));
        assert!(page.exists());
        let text = fs::read_to_string(&csv).expect("the table");
        assert_eq!(fs::read_to_string(run_csv).expect("the table of the run"), text, "{scene}");
        let output = phalanx(&["run", scene, "--csv", "-"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), text.as_str()), "{scene}");
        let (headers, rows) = table(&text);
        assert_eq!((headers.len(), rows.len() as u64), (columns, report["samples"].as_u64().expect("a count")));
        assert!(rows.is_sorted_by(|a, b| a[0] <= b[0]));
        for (column, pointer) in ends {
            let column = headers.iter().position(|header| header == column).unwrap_or_else(|| panic!("no {column}"));
            assert_eq!(
                rows[rows.len() - 1][column].map(read_back),
                report.pointer(pointer).and_then(Value::as_f64),
                "{column}"
            );
        }
        if scene.contains("free-swing") {
            let column = headers.iter().position(|header| header == "proximal_gap_m").expect("a column");
            assert!(
                rows.iter().all(|row| row[column..column + 10] == [None; 10]),
                "no contact columns without an object"
            );
        }
        let output = phalanx(&["replay", names[0], "--csv", "-"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), text.as_str()));
        let output = phalanx(&["replay", names[0], "--csv", "-", "--json"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("--csv the name of a file"), "{}", stderr(&output));
        let output = phalanx(&["replay", names[0], "--csv", names[0]]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("the log itself"), "{}", stderr(&output));
        assert!(fs::read(&log).expect("readable").len() > 1000);
        // A damaged log gives its readable part and status 1.
        let bytes = fs::read(&log).expect("the log");
        fs::write(&log, &bytes[..bytes.len() - 10]).expect("written");
        let output = phalanx(&["replay", names[0], "--csv", names[1]]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert_eq!(fs::read_to_string(&csv).expect("the table"), text);
        let output = phalanx(&["replay", EXPERIMENT_95, "--csv", names[1]]);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(fs::read_to_string(&csv).expect("an unchanged table"), text);
    }
}

/// Figure of this name in a report on two logs.
fn figure<'a>(report: &'a Value, name: &str) -> &'a Value {
    let all = report["figures"].as_array().expect("figures");
    all.iter().find(|figure| figure["figure"] == name).unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn compares_two_logs() {
    let directory = directory("cli_replay_against");
    let path_in = |name: &str| directory.join(name).to_str().expect("UTF-8 path").to_string();
    let run_and_log = |scene: &str, name: &str, extra_args: &[&str]| {
        let log = path_in(name);
        let output = phalanx(&[&["run", scene, "--json", "--log", &log], extra_args].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (log, json(&output))
    };
    let discs = "scenes/laws/impact.toml";
    for (scene, name, quantity, largest) in [
        (EXPERIMENT_95, "contacts.distal.first_s", "q22_rad", 2e-5),
        (discs, "contacts.hammer-anvil.first_s", "hammer_centre_m", 1e-6),
    ] {
        let (analytic, first) = run_and_log(scene, "analytic.mcap", &[]);
        let (engine, second) = run_and_log(scene, "engine.mcap", &["--model", "engine"]);
        let out = path_in("comparison");
        let output = phalanx(&["replay", &analytic, "--against", &engine, "--out", &out, "--json"]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        let report = json(&output);
        assert_eq!(report["labels"], serde_json::json!(["analytic", "engine"]));
        assert_eq!(report["notes"], serde_json::json!([]));
        let pointer = format!("/{}", name.replace('.', "/"));
        let [a, b] = [&first, &second].map(|run| run.pointer(&pointer).and_then(Value::as_f64).expect("a time"));
        let difference = figure(&report, name);
        assert_eq!(difference["values"], serde_json::json!([a, b]));
        assert!((difference["difference"].as_f64().expect("a number") - (b - a)).abs() < 1e-20);
        let differences = report["apart"].as_array().expect("a list");
        let differences = differences.iter().find(|difference| difference["quantity"] == quantity).expect("a quantity");
        let max = differences["max"].as_f64().expect("a number");
        assert!(max > 1e-12 && max < largest, "{max}");
        for file in ["report.txt", "report.json", "overlay.svg", "difference.svg"] {
            assert!(fs::metadata(Path::new(&out).join(file)).expect(file).len() > 500, "{file}");
        }
        let text = fs::read_to_string(Path::new(&out).join("report.txt")).expect("the report");
        assert_eq!(
            stdout(&phalanx(&["replay", &analytic, "--against", &engine])).lines().count() + 3,
            text.lines().count()
        );
        // A log does not differ from itself.
        let same = json(&phalanx(&["replay", &engine, "--against", &engine, "--json"]));
        assert_eq!(same["labels"], serde_json::json!(["first", "second"]));
        assert!(same["figures"].as_array().expect("figures").iter().all(|figure| figure["difference"] == 0.0));
        assert!(same["apart"].as_array().expect("a list").iter().all(|difference| difference["max"] == 0.0));
    }
    // The second scenes have no object, another duration or another kind.
    let (closing, _) = run_and_log(EXPERIMENT_95, "closing.mcap", &[]);
    let (swing, _) = run_and_log("scenes/free-swing.toml", "swing.mcap", &["--duration", "12 ms"]);
    let report = json(&phalanx(&["replay", &closing, "--against", &swing, "--json"]));
    let notes = report["notes"].to_string();
    for part in ["two variants", "closing.mcap ends at 20 ms, swing.mcap at 12 ms", "only closing.mcap has an object"] {
        assert!(notes.contains(part), "no {part} in {notes}");
    }
    assert_eq!(report["compared_to_s"], 0.012);
    assert_eq!(figure(&report, "contacts.proximal.first_s")["values"][1], Value::Null);
    let (rolling, _) = run_and_log("scenes/laws/rolling.toml", "rolling.mcap", &[]);
    let (impact, _) = run_and_log(discs, "impact.mcap", &[]);
    let output = phalanx(&["replay", &rolling, "--against", &impact, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(
        json(&output)["notes"].to_string().contains("only impact.mcap has the disc anvil, hammer"),
        "{}",
        stdout(&output)
    );
    let output = phalanx(&["replay", &closing, "--against", &impact]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("two logs of one kind"), "{}", stderr(&output));
    // A lost part of one log is reported with status 1.
    let bytes = fs::read(&closing).expect("the log");
    fs::write(&closing, &bytes[..bytes.len() - 5]).expect("written");
    let output = phalanx(&["replay", &swing, "--against", &closing, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(json(&output)["notes"].to_string().contains("a part of closing.mcap is lost"));
}

#[test]
fn writes_page_of_one_log_and_of_two() {
    let directory = directory("cli_replay_html");
    let path_in = |name: &str| directory.join(name).to_str().expect("UTF-8 path").to_string();
    for scene in [EXPERIMENT_95, "scenes/laws/impact.toml"] {
        let [analytic, engine] = ["analytic", "engine"].map(|model| {
            let log = path_in(&format!("{model}.mcap"));
            let output = phalanx(&["run", scene, "--model", model, "--log", &log]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            log
        });
        let target = path_in("run.html");
        let summary = phalanx(&["replay", &analytic]);
        let output = phalanx(&["replay", &analytic, "--html", &target]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        assert!(!stdout(&summary).contains("page:") && stdout(&output).contains(&format!("\npage: {target}\n")));
        assert_eq!(stdout(&output).replace(&format!("page: {target}\n"), ""), stdout(&summary));
        let single_log_page = fs::read_to_string(&target).expect("the page");
        assert!(
            single_log_page.starts_with("<!doctype html>") || single_log_page.starts_with("<!DOCTYPE html>"),
            "{}",
            &single_log_page[..40]
        );
        let out = path_in("comparison");
        let output = phalanx(&["replay", &analytic, "--against", &engine, "--html", &target, "--out", &out]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        assert!(stdout(&output).contains(&format!("\npage: {target}\n")), "{}", stdout(&output));
        let two_log_page = fs::read_to_string(&target).expect("the page");
        assert!(
            two_log_page.len() > single_log_page.len() + 10_000,
            "{} and {}",
            single_log_page.len(),
            two_log_page.len()
        );
        assert!(two_log_page.contains("Side by side") && !single_log_page.contains("Side by side"));
        assert_eq!(fs::read_to_string(Path::new(&out).join("page.html")).expect("the page"), two_log_page);
        // The page must not replace the log, and its directory must exist.
        for (target, part) in [(analytic.clone(), "the log itself"), (path_in("nowhere/run.html"), "cannot write")] {
            let output = phalanx(&["replay", &analytic, "--html", &target]);
            assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
            assert!(stderr(&output).contains(part), "{}", stderr(&output));
        }
    }
}
