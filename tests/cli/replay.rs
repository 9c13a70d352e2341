//! `phalanx replay`: gives the same figures from the log as the summary of the run.

use std::fs;
use std::path::Path;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, assert_status, directory, json, path_in, path_text, run_json,
    stdout, succeed, succeed_json, succeed_silently, variant, write,
};
use serde_json::Value;

const GRIPPER: &str = "scenes/gripper/offset.toml";

/// Replays a log; asserts the exit status, and that standard error contains each of `parts`. Returns the report.
#[track_caller]
fn replay(log: &Path, status: i32, parts: &[&str]) -> Value {
    json(&assert_status(&["replay", path_text(log), "--json"], status, parts))
}

#[test]
fn replay_report_equals_run_report() {
    let directory = directory("cli_replay");
    let log = directory.join("run.mcap");
    let finger = ["experiment-95: ", "completed, 20 ms", "2.0887", "4.5013", "stable"];
    let (analytic, engine) = ("rodas5p (rtol 1e-5, engineering preset)", "2 sweeps");
    for (scene, model, parts, part) in [
        (EXPERIMENT_95, "analytic", &finger[..], analytic),
        (EXPERIMENT_95, "engine", &finger, engine),
        ("scenes/laws/impact.toml", "analytic", &["hammer-anvil"], "restitution"),
        ("scenes/laws/impact.toml", "engine", &["hammer-anvil"], "restitution"),
        ("scenes/laws/rolling.toml", "analytic", &[], "restitution"),
        ("scenes/laws/two-free.toml", "engine", &[], "restitution"),
        (GRIPPER, "analytic", &["right proximal"], "held"),
        (GRIPPER, "engine", &["left limit"], "held"),
    ] {
        let (name, label) = (path_text(&log), format!("{scene} {model}"));
        let run = run_json(&["run", scene, "--model", model, "--json", "--log", name]);
        let actual: Value = serde_json::from_str(&succeed_silently(&["replay", name, "--json"])).expect("JSON");
        let keys = "scene model duration_s end_s completed final discs fingers object grasp energy criteria warnings integrator \
                    engine";
        for key in keys.split(' ') {
            assert_eq!(actual[key], run[key], "{label} {key}");
        }
        let is_finger = scene == EXPERIMENT_95;
        let kind = if scene == GRIPPER { "gripper" } else { ["bodies", "finger"][usize::from(is_finger)] };
        assert_eq!((&actual["kind"], &actual["log_numeric_hz"]), (&kind.into(), &1e4.into()));
        assert_eq!(actual["settings"]["scene_file"], scene.rsplit('/').next().expect("a name"));
        assert_eq!((&actual["whole"], &actual["losses"]), (&true.into(), &serde_json::json!([])));
        assert_eq!((&actual["error"], &actual["verification"]), (&Value::Null, &Value::Null));
        assert!(actual["events"].as_u64() >= run["work"]["events"].as_u64());
        assert!(!is_finger || actual["samples"].as_u64() > Some(201));
        for (name, expected) in run["contacts"].as_object().expect("contacts") {
            let contact = &actual["contacts"][name];
            for (key, expected) in expected.as_object().expect("figures") {
                match (key.as_str(), [&contact[key], expected].map(Value::as_f64)) {
                    // At rest both vary by rounding errors, and the run evaluates them only at steps.
                    ("peak_normal_n" | "max_penetration_m", [Some(contact), Some(expected)]) if kind == "bodies" => {
                        assert!((contact - expected).abs() <= 1e-12 * expected, "{label} {name} {key}");
                    }
                    _ => assert_eq!(&contact[key], expected, "{label} {name} {key}"),
                }
            }
        }
        let of_model = if is_finger { vec![part, model] } else { vec![part] };
        assert_contains(&succeed(&["replay", name]), &[parts, &of_model].concat());
    }
}

#[test]
fn truncated_log_is_summarised_with_status_1() {
    let directory = directory("cli_replay_cut");
    let complete = directory.join("whole.mcap");
    let scene = variant(&directory, "fine.toml", "[log]\nnumeric_rate = \"100 kHz\"");
    succeed(&["run", &scene, "--log", path_text(&complete)]);
    let bytes = fs::read(&complete).expect("the log");
    let log = directory.join("cut.mcap");
    fs::write(&log, &bytes[..bytes.len() / 2]).expect("written");
    let report = replay(&log, 1, &["truncated", "cut.mcap"]);
    let states = [&report["whole"], &report["completed"], &report["criteria"]];
    assert_eq!(states, [&false.into(), &Value::Null, &Value::Null]);
    assert_eq!(report["losses"].as_array().expect("a list").len(), 1);
    let end_s = report["end_s"].as_f64().expect("a time");
    assert!(end_s > 0.004 && end_s < 0.02, "{end_s}");
    let output = assert_status(&["replay", path_text(&log)], 1, &[]);
    assert_contains(stdout(&output), &["NOT COMPLETE: the log reaches", "LOST: "]);

    let mut damaged = bytes.clone();
    damaged[bytes.len() / 3] ^= 0x10;
    fs::write(&log, damaged).expect("written");
    let report = replay(&log, 1, &["damaged at byte"]);
    assert!(report["losses"][0]["what"].as_str().is_some_and(|what| what.contains("mcap recover")));
}

#[test]
fn log_of_incomplete_run_is_complete() {
    let directory = directory("cli_replay_budget");
    let scene = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40");
    let log = directory.join("run.mcap");
    assert_status(&["run", &scene, "--log", path_text(&log)], 3, &[]);
    let report = replay(&log, 0, &[]);
    assert_eq!((&report["completed"], &report["whole"]), (&false.into(), &true.into()));
    assert!(report["error"]["reason"].as_str().expect("a reason").contains("budget of 40"), "{report}");
    assert_eq!(report["criteria"], Value::Null);
}

#[test]
fn non_logs_are_bad_input() {
    let directory = directory("cli_replay_bad");
    let assert_rejected = |path: &Path, parts: &[&str]| assert_rejected(&["replay", path_text(path), "--json"], parts);
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

/// A number after writing and parsing as JSON. The written number is exact, but this parser may be off by the last bit.
fn read_back(value: f64) -> f64 {
    let text = serde_json::to_string(&value).expect("a number");
    serde_json::from_str(&text).expect("a number")
}

#[test]
fn every_sample_is_a_line_of_the_table() {
    let directory = directory("cli_replay_csv");
    for (scene, columns, ends) in [
        (EXPERIMENT_95, 55, [("q11_rad", "/final/q11_rad"), ("distal_normal_n", "/contacts/distal/final_normal_n")]),
        ("scenes/free-swing.toml", 33, [("q21_rad", "/final/q21_rad"), ("kinetic_j", "/energy/kinetic_j")]),
        (
            "scenes/laws/impact.toml",
            25,
            [("hammer_x_m", "/bodies/hammer/x_m"), ("hammer-anvil_impulse_n_s", "/contacts/hammer-anvil/impulse_n_s")],
        ),
        (GRIPPER, 130, [("left_q11_rad", "/fingers/left/q11_rad"), ("object_x_m", "/object/x_m")]),
    ] {
        let (log, csv) = (directory.join("run.mcap"), directory.join("run.csv"));
        let names = [&log, &csv].map(|path| path.to_str().expect("UTF-8 path"));
        let (run_csv, page) = (directory.join("of-run.csv"), directory.join("page.html"));
        let run_csv = run_csv.to_str().expect("UTF-8 path");
        let with_forces = ["--set", "log.joint_forces=true"];
        let output = succeed(&[&["run", scene, "--log", names[0], "--csv", run_csv], &with_forces[..]].concat());
        assert!(output.contains(&format!("\nsamples: {run_csv}\n")), "{output}");
        let html = page.to_str().expect("UTF-8 path");
        let report = run_json(&["replay", names[0], "--csv", names[1], "--plot", html, "--json"]);
        assert_eq!((&report["csv"], &report["page"]), (&names[1].into(), &html.into()));
        assert!(page.exists());
        let text = fs::read_to_string(&csv).expect("the table");
        assert_eq!(fs::read_to_string(run_csv).expect("the table of the run"), text, "{scene}");
        assert_eq!(succeed(&["run", scene, "--csv", "-"]), text, "{scene}");
        // By default a log does not contain the forces of joints.
        let (headers, rows) = table(&text);
        let default_log = directory.join("default.mcap");
        let default_log = default_log.to_str().expect("UTF-8 path");
        succeed(&["run", scene, "--log", default_log]);
        let (kept, _) = table(&succeed(&["replay", default_log, "--csv", "-"]));
        let is_kept = |name: &&String| !name.contains("_force_");
        assert!(kept.iter().eq(headers.iter().filter(is_kept)), "{kept:?}");
        assert_eq!((headers.len(), rows.len() as u64), (columns, report["samples"].as_u64().expect("a count")));
        assert!(rows.is_sorted_by(|a, b| a[0] <= b[0]));
        for (column, pointer) in ends {
            let column = headers.iter().position(|header| header == column).unwrap_or_else(|| panic!("no {column}"));
            let last = rows[rows.len() - 1][column].map(read_back);
            assert_eq!(last, report.pointer(pointer).and_then(Value::as_f64), "{column}");
        }
        if scene.contains("free-swing") {
            assert!(headers.iter().all(|header| !header.starts_with("proximal")), "contacts without an object");
        }
        assert_eq!(succeed(&["replay", names[0], "--csv", "-"]), text);
        assert_rejected(&["replay", names[0], "--csv", "-", "--json"], &["--csv the name of a file"]);
        assert_rejected(&["replay", names[0], "--csv", names[0]], &["the log itself"]);
        assert!(fs::read(&log).expect("readable").len() > 1000);
        // A damaged log gives its readable part and status 1.
        let bytes = fs::read(&log).expect("the log");
        fs::write(&log, &bytes[..bytes.len() - 10]).expect("written");
        assert_status(&["replay", names[0], "--csv", names[1]], 1, &[]);
        assert_eq!(fs::read_to_string(&csv).expect("the table"), text);
        assert_rejected(&["replay", EXPERIMENT_95, "--csv", names[1]], &[]);
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
    let path_in = |name: &str| path_in(&directory, name);
    let run_and_log = |scene: &str, name: &str, extra_args: &[&str]| {
        let log = path_in(name);
        let run = run_json(&[&["run", scene, "--json", "--log", &log], extra_args].concat());
        (log, run)
    };
    let discs = "scenes/laws/impact.toml";
    for (scene, name, quantity, largest) in [
        (EXPERIMENT_95, "contacts.distal.first_s", "q22_rad", 2e-5),
        (discs, "contacts.hammer-anvil.first_s", "hammer_centre_m", 1e-6),
    ] {
        let (analytic, first) = run_and_log(scene, "analytic.mcap", &[]);
        let (engine, second) = run_and_log(scene, "engine.mcap", &["--model", "engine"]);
        let out = path_in("comparison");
        let report = succeed_silently(&["replay", &analytic, "--against", &engine, "--out", &out, "--json"]);
        let report: Value = serde_json::from_str(&report).expect("JSON");
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
        let printed = succeed(&["replay", &analytic, "--against", &engine]);
        assert_eq!(printed.lines().count() + 3, text.lines().count());
        // A log does not differ from itself.
        let same = succeed_json(&["replay", &engine, "--against", &engine]);
        assert_eq!(same["labels"], serde_json::json!(["first", "second"]));
        assert!(same["figures"].as_array().expect("figures").iter().all(|figure| figure["difference"] == 0.0));
        assert!(same["apart"].as_array().expect("a list").iter().all(|difference| difference["max"] == 0.0));
    }
    // The second scenes have no object, another duration or another kind.
    let (closing, _) = run_and_log(EXPERIMENT_95, "closing.mcap", &[]);
    let (swing, _) = run_and_log("scenes/free-swing.toml", "swing.mcap", &["--duration", "12 ms"]);
    let report = succeed_json(&["replay", &closing, "--against", &swing]);
    let notes = report["notes"].to_string();
    assert_contains(
        &notes,
        &["two variants", "closing.mcap ends at 20 ms, swing.mcap at 12 ms", "only closing.mcap has an object"],
    );
    assert_eq!(report["compared_to_s"], 0.012);
    assert_eq!(figure(&report, "contacts.proximal.first_s")["values"][1], Value::Null);
    let (rolling, _) = run_and_log("scenes/laws/rolling.toml", "rolling.mcap", &[]);
    let (impact, _) = run_and_log(discs, "impact.mcap", &[]);
    let report = succeed_json(&["replay", &rolling, "--against", &impact]);
    assert_contains(&report["notes"].to_string(), &["only impact.mcap has the body hammer"]);
    assert_rejected(&["replay", &closing, "--against", &impact], &["two logs of one kind"]);
    // Two mechanisms without a common body; one has limits.
    let [jaws, tendons] = ["jaws", "tendon-finger"].map(|name| {
        let (log, _) =
            run_and_log(&format!("scenes/mechanisms/{name}.toml"), &format!("{name}.mcap"), &["--duration", "1 ms"]);
        log
    });
    for pair in [[&jaws, &tendons], [&tendons, &jaws]] {
        let report = succeed_json(&["replay", pair[0], "--against", pair[1]]);
        assert_contains(
            &report["notes"].to_string(),
            &["has the body distal, proximal, winch", "the contact box.skin[0]"],
        );
    }
    // A lost part of one log is reported with status 1.
    let bytes = fs::read(&closing).expect("the log");
    fs::write(&closing, &bytes[..bytes.len() - 5]).expect("written");
    let output = assert_status(&["replay", &swing, "--against", &closing, "--json"], 1, &[]);
    assert_contains(&json(&output)["notes"].to_string(), &["a part of closing.mcap is lost"]);
}

#[test]
fn writes_page_of_one_log_and_of_two() {
    let directory = directory("cli_replay_html");
    let path_in = |name: &str| path_in(&directory, name);
    for scene in [EXPERIMENT_95, "scenes/laws/impact.toml"] {
        let [analytic, engine] = ["analytic", "engine"].map(|model| {
            let log = path_in(&format!("{model}.mcap"));
            succeed(&["run", scene, "--model", model, "--log", &log]);
            log
        });
        let target = path_in("run.html");
        let summary = succeed(&["replay", &analytic]);
        let output = succeed_silently(&["replay", &analytic, "--plot", &target]);
        assert!(!summary.contains("page:") && output.contains(&format!("\npage: {target}\n")));
        assert_eq!(output.replace(&format!("page: {target}\n"), ""), summary);
        let single_log_page = fs::read_to_string(&target).expect("the page");
        assert!(single_log_page[..40].to_lowercase().starts_with("<!doctype html>"), "{}", &single_log_page[..40]);
        let out = path_in("comparison");
        let output = succeed_silently(&["replay", &analytic, "--against", &engine, "--plot", &target, "--out", &out]);
        assert_contains(&output, &[&format!("\npage: {target}\n")]);
        let two_log_page = fs::read_to_string(&target).expect("the page");
        let sizes = [single_log_page.len(), two_log_page.len()];
        assert!(sizes[1] > sizes[0] + 10_000, "{sizes:?}");
        assert!(two_log_page.contains("Side by side") && !single_log_page.contains("Side by side"));
        assert_eq!(fs::read_to_string(Path::new(&out).join("page.html")).expect("the page"), two_log_page);
        // The page must not replace the log, and its directory must exist.
        for (target, part) in
            [(analytic.clone(), "the name must end in .html"), (path_in("nowhere/run.html"), "cannot write")]
        {
            assert_rejected(&["replay", &analytic, "--plot", &target], &[part]);
        }
    }
}
