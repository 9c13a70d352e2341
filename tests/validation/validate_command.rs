//! The command `phalanx validate`: output, files and exit status.

use std::collections::BTreeSet;
use std::fs;
use std::process::Output;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, assert_status, directory, json, path_text, stderr, stdout, variant,
};
use mcap::{MessageStream, Summary};
use serde_json::{Value, json};

/// Runs a quick validation and asserts its exit status.
#[track_caller]
fn validate(scene: &str, arguments: &[&str], status: i32) -> Output {
    assert_status(&[&["validate", scene, "--quick"], arguments].concat(), status, &[])
}

/// Lines of the bounds that fail.
fn failed_bounds(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.ends_with("FAIL")).collect()
}

#[test]
fn the_anchor_case_is_within_its_bounds() {
    let output = validate(EXPERIMENT_95, &["--json"], 0);
    assert_eq!(stderr(&output), "", "no progress output without a terminal");
    let report = json(&output);
    assert_eq!(json!([report["scene"], report["passed"], report["ensemble_runs"]]), json!(["experiment-95", true, 5]));
    let verdict = report["verdict"].as_array().expect("a list");
    for check in verdict {
        assert_eq!(check["passed"], true, "{check}");
        assert!(check["measured"].as_f64().expect("a figure") <= check["limit"].as_f64().expect("a figure"));
    }
    let bounds: Vec<&str> = verdict.iter().map(|check| check["bound"].as_str().expect("a name")).collect();
    let expected = "angle_rad contact_time_s final_force impulse loop_gap_m class stability_time_s reference \
                    analytic_invariants engine_invariants";
    assert_eq!(bounds.join(" "), expected);
    for joint in ["q11", "q21", "q22"] {
        for key in ["max_rad", "max_at_s", "rms_rad", "end_rad", "rate_rms_rad_s"] {
            assert!(report["differences"]["joints"][joint][key].is_number(), "{joint} {key}");
        }
    }
    for contact in ["proximal", "distal"] {
        for key in ["first_touch_s", "impulse", "final_force"] {
            assert!(report["differences"][contact][key].is_number(), "{contact} {key}");
        }
        for model in ["analytic", "engine"] {
            assert_eq!(report[model]["contacts"][contact]["touchdowns"], 1);
        }
    }
    assert_eq!(report["impacts"].as_array().expect("a list").len(), 2);
    // Without a ladder, no other settings run and nothing is timed.
    let engine = &report["engine"];
    assert_eq!(json!([report["files"], report["settings"], report["ladder_time_s"]]), json!([null, [], null]));
    assert!(engine["steps"].as_u64().is_some_and(|steps| steps > 500) && engine["wall_s"].is_null());
    let [class, time] = [0, 1].map(|k| &report["criteria"][k]);
    assert_eq!(json!([class["criterion"], class["analytic"], class["engine"]]), json!(["class", "stable", "stable"]));
    assert_eq!(json!([time["criterion"], time["limit"]]), json!(["stability_time_s", 1e-5]));
    assert!((time["analytic"].as_f64().expect("a time") - 6.883746e-3).abs() < 1e-8, "{time}");
}

#[test]
fn the_verdict_precedes_the_ladder_and_does_not_depend_on_it() {
    let [verdict, ladder] = [&[][..], &["--ladder"]].map(|arguments| validate(EXPERIMENT_95, arguments, 0));
    let (verdict, ladder) = (stdout(&verdict), stdout(&ladder));
    assert!(verdict.starts_with("experiment-95: engine against analytic model: within all bounds\n"), "{verdict}");
    assert_contains(verdict, &["time to stability, ms  6.8837463"]);
    let rest = ladder.strip_prefix(verdict).unwrap_or_else(|| panic!("{verdict}\n{ladder}"));
    assert!(rest.starts_with("\nspeed against error") && !verdict.contains("speed against error"), "{rest}");
}

#[test]
fn a_ladder_respects_its_time_limit_and_names_omitted_settings() {
    let report = json(&validate(EXPERIMENT_95, &["--json", "--ladder-time", "1 us"], 0));
    assert_eq!(json!([report["ladder_time_s"], report["passed"]]), json!([1e-6, true]));
    for setting in report["settings"].as_array().expect("a list") {
        // The two compared settings are always timed.
        let is_compared = setting["own"] == true || setting["reference"] == true;
        assert_eq!(setting["status"], if is_compared { "done" } else { "no_time" }, "{setting}");
        assert_eq!(setting["reason"].is_null(), is_compared, "{setting}");
    }
    let text = validate(EXPERIMENT_95, &["--ladder-time", "1 us"], 0);
    let omitted = "engine, fixed steps, dt 1e-4 s: omitted, beyond the time limit of the ladder";
    assert_contains(stdout(&text), &[omitted]);
    assert_rejected(&["validate", EXPERIMENT_95, "--ladder-time", "0 s"], &["longer than 0"]);
}

#[test]
fn a_ladder_reports_speed_and_error_of_every_setting() {
    let report = json(&validate(EXPERIMENT_95, &["--json", "--ladder-time", "600 s"], 0));
    let settings = report["settings"].as_array().expect("a list");
    let family = |name: &str| settings.iter().filter(|setting| setting["family"] == name).count();
    for (name, count) in [
        ("engine, adaptive steps", 4),
        // Short steps are omitted.
        ("engine, fixed steps", 2),
        ("engine, native contact", 2),
        ("analytic", 7),
    ] {
        assert_eq!(family(name), count, "{name}");
    }
    assert_eq!(settings.iter().filter(|setting| setting["own"] == true).count(), 1);
    for setting in settings {
        assert_eq!(setting["status"], "done", "{setting}");
        for key in ["steps", "wall_s", "real_time_factor", "analytic_factor"] {
            assert!(setting[key].as_f64().expect("a figure") > 0.0, "{key} of {setting}");
        }
        assert_eq!(setting["angle_max_rad"].is_null(), setting["reference"] == true, "{setting}");
    }
    // A tighter tolerance gives a smaller error.
    let errors: Vec<f64> = settings
        .iter()
        .filter(|setting| setting["family"] == "analytic" && setting["reference"] == false)
        .map(|setting| setting["angle_max_rad"].as_f64().expect("a figure"))
        .take(5)
        .collect();
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    assert!(errors[4] < 1e-8, "{errors:?}");
}

#[test]
fn bounds_decide_the_exit_status() {
    let directory = directory("validate_bounds");
    // Below the error of the engine, and above the error estimate of the reference.
    let scene = variant(&directory, "tight.toml", "[validate]\nangle = \"1e-9 rad\"\n");
    let output = validate(&scene, &["--ladder"], 1);
    let text = stdout(&output);
    assert_contains(text, &["OUT OF BOUNDS", "speed against error", "omitted by --quick"]);
    let [failed] = failed_bounds(text)[..] else { panic!("{text}") };
    assert!(failed.starts_with("angle_rad"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 130), "{text}");
    // A bound below the error of the reference fails that check, too.
    let scene = variant(&directory, "finest.toml", "[validate]\nangle = \"1e-12 rad\"\n");
    let output = validate(&scene, &[], 1);
    let text = stdout(&output);
    let [angle, reference] = failed_bounds(text)[..] else { panic!("{text}") };
    assert!(angle.starts_with("angle_rad") && reference.starts_with("reference"), "{text}");
    assert_contains(text, &["Neither model can be trusted"]);
}

#[test]
fn a_failed_validation_names_the_model_to_trust_and_a_setting_that_passes() {
    let coarse = ["--set", "engine.tolerance=1e-2 m", "--set", "engine.max_step=0.5 ms"];
    let failed = validate(EXPERIMENT_95, &coarse, 1);
    assert_contains(stdout(&failed), &["Trust the analytic model: its two integration methods agree to "]);
    let report = json(&validate(EXPERIMENT_95, &[&coarse[..], &["--json"]].concat(), 1));
    assert_eq!(report["trusted"], "analytic");
    assert!(report["reference_error"].as_f64().is_some_and(|error| error < 1e-8), "{}", report["reference_error"]);
    let finer = report["finer"].as_array().and_then(|all| all.last()).expect("a setting");
    let setting = finer["setting"].as_str().expect("text");
    assert_eq!(finer["passed"], true);
    assert_contains(stdout(&failed), &[&format!("The engine passes with [engine] {setting}.")]);
    let settings = setting.split(", ").map(|each| format!("engine.{}", each.replace(" = ", "=").replace('"', "")));
    let finer: Vec<String> = settings.flat_map(|each| ["--set".to_string(), each]).collect();
    validate(EXPERIMENT_95, &finer.iter().map(String::as_str).collect::<Vec<_>>(), 0);
}

#[test]
fn an_incomplete_run_exits_with_status_3() {
    let directory = directory("validate_budget");
    for (section, model) in [("engine", "engine"), ("integrator", "analytic")] {
        let scene = variant(&directory, "budget.toml", &format!("[{section}]\nmax_steps = 20"));
        let output = validate(&scene, &["--json"], 3);
        assert_eq!(stdout(&output), "");
        assert_contains(stderr(&output), &[&format!("the {model} model stopped at"), "20"]);
    }
}

#[test]
fn invalid_input_exits_with_status_2() {
    assert_rejected(&["validate", "no/such/scene.toml"], &["no/such/scene.toml"]);
    let scene = variant(&directory("validate_rejected"), "mine.toml", "");
    assert_rejected(&["validate", &scene, "--out", &scene], &["the scene itself"]);
    assert!(fs::read_to_string(&scene).expect("still there").contains("experiment-95"));
}

#[test]
fn all_output_files_are_written() {
    let out = directory("validate_out").join("new").join("results");
    let output = validate(EXPERIMENT_95, &["--json", "--out", path_text(&out)], 0);
    let report = json(&output);
    assert_eq!(report["directory"], path_text(&out));
    let named: BTreeSet<&str> = report["files"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    let written: BTreeSet<String> = fs::read_dir(&out)
        .expect("made")
        .map(|entry| entry.expect("read").file_name().into_string().expect("text"))
        .collect();
    assert!(written.iter().eq(&named), "{written:?} {named:?}");
    let read = |name: &str| fs::read_to_string(out.join(name)).expect("written");
    assert_eq!(read("report.json").replacen("\n  \"generator\": \"phalanx\",", "", 1), stdout(&output));
    assert_contains(&read("report.txt"), &["within all bounds"]);

    for name in ["speed-error.svg", "overlay.svg", "difference.svg"] {
        let picture = read(name);
        let picture = roxmltree::Document::parse(&picture).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(picture.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")), "{name}");
        assert!(picture.descendants().any(|element| element.tag_name().name() == "text"), "{name}");
    }
    let page = read("page.html");
    let summaries = ["Summary: analytic", "Summary: engine", "Speed against error", "within all bounds"];
    assert_contains(&page, &[&["<title>experiment-95</title>"], &summaries[..]].concat());
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    assert!(!page.contains(path_text(&out)), "a page contains no local paths");
    let table = read("series.csv");
    let mut lines = table.lines();
    let head = lines.next().expect("a head");
    assert!(head.starts_with("time_s,q11_rad_analytic,q11_rad_engine,"), "{head}");
    assert_eq!(lines.clone().count(), 201, "20 ms at 10 kHz");
    assert!(lines.all(|line| line.split(',').count() == head.split(',').count()));
    assert!(table.lines().last().expect("rows").starts_with("0.02,"));
    for model in ["analytic", "engine"] {
        let bytes = fs::read(out.join(format!("{model}.mcap"))).expect("a log");
        assert!(MessageStream::new(&bytes).expect("readable").all(|message| message.is_ok()));
        let summary = Summary::read(&bytes).expect("readable").expect("indexed");
        let settings = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).expect("readable").metadata;
        assert_eq!(settings["model"], model);
    }
}

#[test]
fn output_files_are_reproducible() {
    let directory = directory("validate_same");
    let runs = ["a", "b"].map(|name| {
        let out = directory.join(name);
        validate("scenes/free-swing.toml", &["--out", path_text(&out)], 0);
        out
    });
    for file in ["series.csv", "overlay.svg", "difference.svg", "analytic.mcap", "engine.mcap"] {
        let [a, b] = [0, 1].map(|run| fs::read(runs[run].join(file)).expect("written"));
        assert!(a == b, "{file}");
    }
}
