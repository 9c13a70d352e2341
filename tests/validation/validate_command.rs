//! The command `phalanx validate`: output, files and exit status.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, assert_rejected, directory, json, phalanx, stderr, stdout, variant};
use mcap::{MessageStream, Summary};
use serde_json::Value;

fn validate(scene: &str, arguments: &[&str]) -> std::process::Output {
    phalanx(&[&["validate", scene, "--quick"], arguments].concat())
}

#[test]
fn the_anchor_case_is_within_its_bounds() {
    let output = validate(EXPERIMENT_95, &["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}\n{}", stdout(&output), stderr(&output));
    assert_eq!(stderr(&output), "", "no progress output without a terminal");
    let report = json(&output);
    assert_eq!(report["scene"], "experiment-95");
    assert_eq!(report["passed"], true);
    assert_eq!(report["ensemble_runs"], 5);
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
    assert_eq!(report["files"], Value::Null);
    // Without a ladder, no other settings run and nothing is timed.
    assert_eq!((&report["settings"], &report["ladder_time_s"]), (&Value::Array(Vec::new()), &Value::Null));
    assert!(
        report["engine"]["steps"].as_u64().is_some_and(|steps| steps > 500) && report["engine"]["wall_s"].is_null()
    );
    let [class, time] = [0, 1].map(|k| &report["criteria"][k]);
    assert_eq!(
        (&class["criterion"], &class["analytic"], &class["engine"]),
        (&"class".into(), &"stable".into(), &"stable".into())
    );
    assert_eq!((&time["criterion"], &time["limit"]), (&"stability_time_s".into(), &1e-5.into()));
    assert!((time["analytic"].as_f64().expect("a time") - 6.883746e-3).abs() < 1e-8, "{time}");
}

#[test]
fn the_verdict_precedes_the_ladder_and_does_not_depend_on_it() {
    let without_ladder = validate(EXPERIMENT_95, &[]);
    let ladder = validate(EXPERIMENT_95, &["--ladder"]);
    let (without_ladder, ladder) = (stdout(&without_ladder), stdout(&ladder));
    assert!(
        without_ladder.starts_with("experiment-95: engine against analytic model: within all bounds\n"),
        "{without_ladder}"
    );
    assert!(
        without_ladder.contains("time to stability, ms  6.8837463") && !without_ladder.contains("speed against error"),
        "{without_ladder}"
    );
    let rest = ladder.strip_prefix(without_ladder).unwrap_or_else(|| panic!("{without_ladder}\n{ladder}"));
    assert!(rest.starts_with("\nspeed against error"), "{rest}");
}

#[test]
fn a_ladder_respects_its_time_limit_and_names_omitted_settings() {
    let report = json(&validate(EXPERIMENT_95, &["--json", "--ladder-time", "1 us"]));
    assert_eq!((&report["ladder_time_s"], &report["passed"]), (&1e-6.into(), &true.into()));
    for setting in report["settings"].as_array().expect("a list") {
        // The two compared settings are always timed.
        let is_compared = setting["own"] == true || setting["reference"] == true;
        assert_eq!(setting["status"], if is_compared { "done" } else { "no_time" }, "{setting}");
        assert_eq!(setting["reason"].is_null(), is_compared, "{setting}");
    }
    let text = validate(EXPERIMENT_95, &["--ladder-time", "1 us"]);
    assert!(
        stdout(&text).contains("engine, fixed steps, dt 1e-4 s: omitted, beyond the time limit of the ladder"),
        "{}",
        stdout(&text)
    );
    assert_rejected(&["validate", EXPERIMENT_95, "--ladder-time", "0 s"], &["longer than 0"]);
}

#[test]
fn a_ladder_reports_speed_and_error_of_every_setting() {
    let report = json(&validate(EXPERIMENT_95, &["--json", "--ladder-time", "600 s"]));
    let settings = report["settings"].as_array().expect("a list");
    let family = |name: &str| settings.iter().filter(|setting| setting["family"] == name).count();
    assert_eq!(family("engine, adaptive steps"), 4);
    assert_eq!(family("engine, fixed steps"), 2, "short steps are omitted");
    assert_eq!(family("engine, reduced coordinates"), 0);
    assert_eq!(family("engine, native contact"), 2);
    assert_eq!(family("analytic"), 7);
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
    // Below the error of the engine, and above the error estimate of the reference.
    let scene = variant(&directory("validate_bounds"), "tight.toml", "[validate]\nangle = \"1e-9 rad\"\n");
    let output = validate(&scene, &["--ladder"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.contains("OUT OF BOUNDS"), "{text}");
    let failed: Vec<&str> = text.lines().filter(|line| line.ends_with("FAIL")).collect();
    assert!(failed.len() == 1 && failed[0].starts_with("angle_rad"), "{text}");
    assert!(text.contains("speed against error") && text.contains("omitted by --quick"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 130), "{text}");
}

#[test]
fn a_bound_below_the_reference_error_fails_the_reference_check() {
    let scene = variant(&directory("validate_reference"), "finest.toml", "[validate]\nangle = \"1e-12 rad\"\n");
    let output = validate(&scene, &[]);
    let text = stdout(&output);
    let failed: Vec<&str> = text.lines().filter(|line| line.ends_with("FAIL")).collect();
    assert!(failed.len() == 2 && failed[0].starts_with("angle_rad") && failed[1].starts_with("reference"), "{text}");
    assert!(text.contains("Neither model can be trusted"), "{text}");
}

#[test]
fn a_failed_validation_names_the_model_to_trust_and_a_setting_that_passes() {
    let coarse = ["--set", "engine.tolerance=1e-4 m"];
    let failed = validate(EXPERIMENT_95, &coarse);
    assert_eq!(failed.status.code(), Some(1), "{}", stderr(&failed));
    let text = stdout(&failed);
    assert!(text.contains("Trust the analytic model: its two integration methods agree to "), "{text}");
    let report = json(&validate(EXPERIMENT_95, &[&coarse[..], &["--json"]].concat()));
    assert_eq!(report["trusted"], "analytic");
    assert!(report["reference_error"].as_f64().is_some_and(|error| error < 1e-8), "{}", report["reference_error"]);
    let finer = report["finer"].as_array().and_then(|all| all.last()).expect("a setting");
    let setting = finer["setting"].as_str().expect("text");
    assert!(finer["passed"] == true && text.contains(&format!("The engine passes with [engine] {setting}.")), "{text}");
    let set = format!("engine.{}", setting.replace(" = ", "=").replace('"', ""));
    assert_eq!(validate(EXPERIMENT_95, &["--set", &set]).status.code(), Some(0), "{set}");
}

#[test]
fn an_incomplete_run_exits_with_status_3() {
    let directory = directory("validate_budget");
    for (section, model) in [("[engine]\nmax_steps = 20", "engine"), ("[integrator]\nmax_steps = 20", "analytic")] {
        let scene = variant(&directory, "budget.toml", section);
        let output = validate(&scene, &["--json"]);
        assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
        assert_eq!(stdout(&output), "");
        let message = stderr(&output);
        assert!(message.contains(&format!("the {model} model stopped at")) && message.contains("20"), "{message}");
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
    let output = validate(EXPERIMENT_95, &["--json", "--out", out.to_str().expect("text")]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report = json(&output);
    assert_eq!(report["directory"], out.to_str().expect("text"));
    let named: Vec<&str> = report["files"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
    let mut written: Vec<String> = fs::read_dir(&out)
        .expect("made")
        .map(|entry| entry.expect("read").file_name().into_string().expect("text"))
        .collect();
    written.sort();
    let mut sorted = named.clone();
    sorted.sort_unstable();
    assert_eq!(written, sorted);
    let report = fs::read_to_string(out.join("report.json")).expect("a report");
    assert_eq!(report.replacen("\n  \"generator\": \"phalanx\",", "", 1), stdout(&output));
    assert!(fs::read_to_string(out.join("report.txt")).expect("a report").contains("within all bounds"));

    for name in ["speed-error.svg", "overlay.svg", "difference.svg"] {
        let picture = fs::read_to_string(out.join(name)).expect("a picture");
        let picture = roxmltree::Document::parse(&picture).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(picture.root_element().has_tag_name(("http://www.w3.org/2000/svg", "svg")), "{name}");
        assert!(picture.descendants().any(|element| element.tag_name().name() == "text"), "{name}");
    }
    let page = fs::read_to_string(out.join("page.html")).expect("a page");
    for part in [
        "<title>experiment-95</title>",
        "Summary: analytic",
        "Summary: engine",
        "Speed against error",
        "within all bounds",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
    assert!(!page.contains(out.to_str().expect("text")), "a page contains no local paths");
    let table = fs::read_to_string(out.join("series.csv")).expect("a table");
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
        let output = validate("scenes/free-swing.toml", &["--out", out.to_str().expect("text")]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        out
    });
    for file in ["series.csv", "overlay.svg", "difference.svg", "analytic.mcap", "engine.mcap"] {
        let [a, b] = [0, 1].map(|run| fs::read(runs[run].join(file)).expect("written"));
        assert!(a == b, "{file}");
    }
}
