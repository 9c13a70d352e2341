//! `phalanx replay` as a user meets it: the same figures as the run's own summary, from the log alone.

use std::fs;
use std::path::Path;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, variant, write};
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
        for key in ["integrator", "engine"] {
            assert_eq!(found[key], run[key], "{model} {key}");
        }
        assert_eq!((&found["kind"], &found["log_numeric_hz"]), (&"finger".into(), &1e4.into()));
        assert_eq!(found["settings"]["scene_file"], "experiment-95.toml");
        assert_eq!((&found["recovered"], &found["verification"]), (&Value::Null, &Value::Null));
        assert_eq!(found["whole"], true);
        assert_eq!(found["losses"], Value::Array(Vec::new()));
        assert_eq!(found["error"], Value::Null);
        assert!(found["events"].as_u64() >= run["work"]["events"].as_u64());
        assert!(found["samples"].as_u64().expect("a count") > 201);
        for site in ["proximal", "distal"] {
            let (found, run) = (&found["contacts"][site], &run["contacts"][site]);
            for key in [
                "first_s",
                "touchdowns",
                "final_normal_n",
                "final_tangential_n",
                "peak_normal_n",
                "max_penetration_m",
                "impulse_n_s",
            ] {
                assert_eq!(found[key], run[key], "{model} {site} {key}");
            }
        }
        assert_eq!(found["contacts"]["limit"], run["contacts"]["limit"], "{model}");
        let output = phalanx(&["replay", log.to_str().expect("text")]);
        let text = stdout(&output);
        let settings =
            if model == "engine" { "maximal construction" } else { "rodas5p (rtol 1e-5, engineering preset)" };
        for part in ["experiment-95: ", model, "completed, 20 ms", "2.0887", "4.5013", "stable", settings] {
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

/// Everything that a table has, by the names of its columns.
fn table(text: &str) -> (Vec<String>, Vec<Vec<Option<f64>>>) {
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().expect("names").split(',').map(String::from).collect();
    let cell = |text: &str| (!text.is_empty()).then(|| text.parse().expect("a number"));
    let rows: Vec<Vec<_>> = lines.map(|line| line.split(',').map(cell).collect()).collect();
    assert!(rows.iter().all(|row| row.len() == names.len()));
    (names, rows)
}

#[test]
fn a_log_of_discs_says_what_its_run_said() {
    let directory = directory("cli_replay_discs");
    for (scene, model, pair) in [
        ("scenes/laws/impact.toml", "analytic", "hammer-anvil"),
        ("scenes/laws/impact.toml", "engine", "hammer-anvil"),
        ("scenes/laws/rolling.toml", "analytic", ""),
        ("scenes/laws/two-free.toml", "engine", ""),
    ] {
        let log = directory.join("run.mcap");
        let name = log.to_str().expect("text");
        let output = phalanx(&["run", scene, "--model", model, "--json", "--log", name]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let run = json(&output);
        let output = replay(&log);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        let found = json(&output);
        for key in
            ["scene", "kind", "model", "duration_s", "end_s", "completed", "discs", "energy", "integrator", "engine"]
        {
            assert_eq!(found[key], run[key], "{scene} {model} {key}");
        }
        assert_eq!((&found["final"], &found["criteria"]), (&Value::Null, &Value::Null));
        for (name, expected) in run["contacts"].as_object().expect("pairs") {
            let found = &found["contacts"][name];
            for (key, expected) in expected.as_object().expect("figures") {
                let figures = [&found[key], expected].map(Value::as_f64);
                match (key.as_str(), figures) {
                    // At rest both go up and down by rounding, and the run looks at steps only.
                    ("peak_normal_n" | "max_penetration_m", [Some(found), Some(expected)]) => {
                        assert!((found - expected).abs() <= 1e-12 * expected, "{scene} {model} {name} {key}");
                    }
                    _ => assert_eq!(&found[key], expected, "{scene} {model} {name} {key}"),
                }
            }
        }
        let text = phalanx(&["replay", name]);
        assert!(stdout(&text).contains(pair) && stdout(&text).contains("restitution"), "{}", stdout(&text));
    }
}

/// A number as the reader of JSON here gives it back: it may be off by the last bit, though what was written is exact.
fn read_back(value: f64) -> f64 {
    let text = serde_json::to_string(&value).expect("a number");
    serde_json::from_str(&text).expect("a number")
}

#[test]
fn every_sample_is_a_line_of_the_table() {
    let directory = directory("cli_replay_csv");
    for (scene, columns, ends) in [
        (ANCHOR, 42, [("q11_rad", "/final/q11_rad"), ("distal_normal_n", "/contacts/distal/final_normal_n")]),
        ("scenes/free-swing.toml", 42, [("q21_rad", "/final/q21_rad"), ("kinetic_j", "/energy/kinetic_j")]),
        (
            "scenes/laws/impact.toml",
            30,
            [("hammer_x_m", "/discs/hammer/x_m"), ("hammer-anvil_impulse_n_s", "/contacts/hammer-anvil/impulse_n_s")],
        ),
    ] {
        let (log, csv) = (directory.join("run.mcap"), directory.join("run.csv"));
        let names = [&log, &csv].map(|path| path.to_str().expect("text"));
        let (of_run, page) = (directory.join("of-run.csv"), directory.join("page.html"));
        let of_run = of_run.to_str().expect("text");
        let output = phalanx(&["run", scene, "--log", names[0], "--csv", of_run]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        assert!(stdout(&output).contains(&format!("\nsamples: {of_run}\n")), "{}", stdout(&output));
        let html = page.to_str().expect("text");
        let output = phalanx(&["replay", names[0], "--csv", names[1], "--html", html, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report = json(&output);
        assert_eq!((&report["csv"], &report["page"]), (&names[1].into(), &html.into()));
        assert!(page.exists());
        let text = fs::read_to_string(&csv).expect("the table");
        assert_eq!(fs::read_to_string(of_run).expect("the table of the run"), text, "{scene}");
        let output = phalanx(&["run", scene, "--csv", "-"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), text.as_str()), "{scene}");
        let (heads, rows) = table(&text);
        assert_eq!((heads.len(), rows.len() as u64), (columns, report["samples"].as_u64().expect("a count")));
        assert!(rows.is_sorted_by(|a, b| a[0] <= b[0]));
        for (column, pointer) in ends {
            let place = heads.iter().position(|head| head == column).unwrap_or_else(|| panic!("no {column}"));
            assert_eq!(
                rows[rows.len() - 1][place].map(read_back),
                report.pointer(pointer).and_then(Value::as_f64),
                "{column}"
            );
        }
        if scene.contains("free-swing") {
            let place = heads.iter().position(|head| head == "proximal_gap_m").expect("a column");
            assert!(rows.iter().all(|row| row[place..place + 10] == [None; 10]), "nothing to touch");
        }
        let output = phalanx(&["replay", names[0], "--csv", "-"]);
        assert_eq!((output.status.code(), stdout(&output)), (Some(0), text.as_str()));
        let output = phalanx(&["replay", names[0], "--csv", "-", "--json"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("--csv the name of a file"), "{}", stderr(&output));
        let output = phalanx(&["replay", names[0], "--csv", names[0]]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("the log itself"), "{}", stderr(&output));
        assert!(fs::read(&log).expect("still there").len() > 1000);
        // A damaged log: its good part, and status 1.
        let bytes = fs::read(&log).expect("the log");
        fs::write(&log, &bytes[..bytes.len() - 10]).expect("written");
        let output = phalanx(&["replay", names[0], "--csv", names[1]]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert_eq!(fs::read_to_string(&csv).expect("the table"), text);
        let output = phalanx(&["replay", ANCHOR, "--csv", names[1]]);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(fs::read_to_string(&csv).expect("as it was"), text);
    }
}

/// The figure of a name in a report of two logs.
fn figure<'a>(report: &'a Value, name: &str) -> &'a Value {
    let all = report["figures"].as_array().expect("figures");
    all.iter().find(|figure| figure["figure"] == name).unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn two_logs_side_by_side() {
    let directory = directory("cli_replay_against");
    let place = |name: &str| directory.join(name).to_str().expect("text").to_string();
    let made = |scene: &str, name: &str, more: &[&str]| {
        let log = place(name);
        let output = phalanx(&[&["run", scene, "--json", "--log", &log], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (log, json(&output))
    };
    let discs = "scenes/laws/impact.toml";
    for (scene, name, quantity, largest) in [
        (ANCHOR, "contacts.distal.first_s", "q22_rad", 2e-5),
        (discs, "contacts.hammer-anvil.first_s", "hammer_centre_m", 1e-6),
    ] {
        let (analytic, first) = made(scene, "analytic.mcap", &[]);
        let (engine, second) = made(scene, "engine.mcap", &["--model", "engine"]);
        let out = place("comparison");
        let output = phalanx(&["replay", &analytic, "--against", &engine, "--out", &out, "--json"]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        let report = json(&output);
        assert_eq!(report["labels"], serde_json::json!(["analytic", "engine"]));
        assert_eq!(report["notes"], serde_json::json!([]));
        let pointer = format!("/{}", name.replace('.', "/"));
        let [a, b] = [&first, &second].map(|run| run.pointer(&pointer).and_then(Value::as_f64).expect("a time"));
        let found = figure(&report, name);
        assert_eq!(found["values"], serde_json::json!([a, b]));
        assert!((found["difference"].as_f64().expect("a number") - (b - a)).abs() < 1e-20);
        let apart = report["apart"].as_array().expect("a list");
        let apart = apart.iter().find(|found| found["quantity"] == quantity).expect("a quantity");
        let max = apart["max"].as_f64().expect("a number");
        assert!(max > 1e-12 && max < largest, "{max}");
        for file in ["report.txt", "report.json", "overlay.svg", "difference.svg"] {
            assert!(fs::metadata(Path::new(&out).join(file)).expect(file).len() > 500, "{file}");
        }
        let text = fs::read_to_string(Path::new(&out).join("report.txt")).expect("the report");
        assert_eq!(
            stdout(&phalanx(&["replay", &analytic, "--against", &engine])).lines().count() + 1,
            text.lines().count()
        );
        // A log against itself differs in nothing.
        let same = json(&phalanx(&["replay", &engine, "--against", &engine, "--json"]));
        assert_eq!(same["labels"], serde_json::json!(["first", "second"]));
        assert!(same["figures"].as_array().expect("figures").iter().all(|figure| figure["difference"] == 0.0));
        assert!(same["apart"].as_array().expect("a list").iter().all(|found| found["max"] == 0.0));
    }
    // Variants: without an object, of another length, of another kind.
    let (closing, _) = made(ANCHOR, "closing.mcap", &[]);
    let (swing, _) = made("scenes/free-swing.toml", "swing.mcap", &["--duration", "12 ms"]);
    let report = json(&phalanx(&["replay", &closing, "--against", &swing, "--json"]));
    let notes = report["notes"].to_string();
    for part in ["two variants", "closing.mcap goes to 20 ms, swing.mcap to 12 ms", "only closing.mcap has an object"] {
        assert!(notes.contains(part), "no {part} in {notes}");
    }
    assert_eq!(report["compared_to_s"], 0.012);
    assert_eq!(figure(&report, "contacts.proximal.first_s")["values"][1], Value::Null);
    let (rolling, _) = made("scenes/laws/rolling.toml", "rolling.mcap", &[]);
    let (impact, _) = made(discs, "impact.mcap", &[]);
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
    // A part of one is lost: said, and status 1.
    let bytes = fs::read(&closing).expect("the log");
    fs::write(&closing, &bytes[..bytes.len() - 5]).expect("written");
    let output = phalanx(&["replay", &swing, "--against", &closing, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(json(&output)["notes"].to_string().contains("a part of closing.mcap is lost"));
}

#[test]
fn a_page_of_one_log_and_of_two() {
    let directory = directory("cli_replay_html");
    let place = |name: &str| directory.join(name).to_str().expect("text").to_string();
    for scene in [ANCHOR, "scenes/laws/impact.toml"] {
        let [analytic, engine] = ["analytic", "engine"].map(|model| {
            let log = place(&format!("{model}.mcap"));
            let output = phalanx(&["run", scene, "--model", model, "--log", &log]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            log
        });
        let target = place("run.html");
        let summary = phalanx(&["replay", &analytic]);
        let output = phalanx(&["replay", &analytic, "--html", &target]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        assert!(!stdout(&summary).contains("page:") && stdout(&output).contains(&format!("\npage: {target}\n")));
        assert_eq!(stdout(&output).replace(&format!("page: {target}\n"), ""), stdout(&summary));
        let one = fs::read_to_string(&target).expect("the page");
        assert!(one.starts_with("<!doctype html>") || one.starts_with("<!DOCTYPE html>"), "{}", &one[..40]);
        let out = place("comparison");
        let output = phalanx(&["replay", &analytic, "--against", &engine, "--html", &target, "--out", &out]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
        assert!(stdout(&output).contains(&format!("\npage: {target}\n")), "{}", stdout(&output));
        let two = fs::read_to_string(&target).expect("the page");
        assert!(two.len() > one.len() + 10_000, "{} and {}", one.len(), two.len());
        assert!(two.contains("Side by side") && !one.contains("Side by side"));
        assert_eq!(fs::read_to_string(Path::new(&out).join("page.html")).expect("the page"), two);
        // The log must not be lost to a slip of the hand, and a page needs somewhere to go.
        for (target, part) in [(analytic.clone(), "the log itself"), (place("nowhere/run.html"), "cannot write")] {
            let output = phalanx(&["replay", &analytic, "--html", &target]);
            assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
            assert!(stderr(&output).contains(part), "{}", stderr(&output));
        }
    }
}
