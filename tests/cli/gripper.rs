//! Grippers on the command line: run, log, page, sweep, capture and hold.

use std::fs;

use serde_json::Value;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, directory, json, path_text, phalanx, run_json, stdout, succeed,
    write,
};

const GRIPPER: &str = "scenes/gripper/offset.toml";
const HOLD: &str = "scenes/gripper/hold.toml";

#[test]
fn logs_are_verified_compared_and_recognised_when_truncated() {
    let dir = directory("cli_gripper_log");
    let logs = ["analytic", "engine"].map(|model| {
        let log = dir.join(format!("{model}.mcap")).display().to_string();
        let run = run_json(&["run", GRIPPER, "--model", model, "--log", &log, "--json"]);
        assert_eq!((run["kind"].as_str(), run["grasp"]["fate"].as_str()), (Some("gripper"), Some("held")));
        let verified = run_json(&["replay", &log, "--verify", "--json"]);
        assert_eq!(verified["verification"]["same"], Value::Bool(true), "{verified:?}");
        let bytes = fs::read(&log).expect("the log");
        let truncated = dir.join(format!("{model}-cut.mcap"));
        fs::write(&truncated, &bytes[..bytes.len() / 2]).expect("written");
        let half = json(&phalanx(&["replay", path_text(&truncated), "--json"]));
        assert!(half["fingers"]["left"]["q21_rad"].is_number() && half["grasp"].is_null(), "{half:?}");
        log
    });
    let comparison = run_json(&["replay", &logs[0], "--against", &logs[1], "--json"]);
    let differences = comparison["apart"].as_array().expect("differences").iter();
    let quantities: Vec<&str> = differences.filter_map(|entry| entry["quantity"].as_str()).collect();
    assert_eq!(quantities.len(), 7, "{quantities:?}");
    assert!(quantities.contains(&"left_q22_rad") && quantities.contains(&"object_centre_m"), "{quantities:?}");
}

/// Fingers around an object with a radius of 4 mm overlap.
#[test]
fn overlapping_links_are_a_warning_in_every_output() {
    let dir = directory("cli_gripper_warnings");
    let scene = write(
        &dir,
        "small.toml",
        "kind = \"gripper\"\nduration = \"6 ms\"\npalm_width = \"31 mm\"\n\
         lengths = { l11 = \"15 mm\", l21 = \"24.43 mm\", l22 = \"7.5 mm\", t22 = \"12.86 mm\", phi22 = \"120 deg\" }\n\
         object = { radius = \"4 mm\", height = \"20 mm\" }\nmotor.torque = \"480 N*mm\"\nspring.torque = \"132.6 N*mm\"\n",
    );
    let log = dir.join("run.mcap").display().to_string();
    let page = dir.join("run.html").display().to_string();
    let run = run_json(&["run", &scene, "--log", &log, "--plot", &page, "--json"]);
    let warning = run["warnings"][0].as_str().expect("a warning");
    assert_contains(warning, &["t22 of the right finger overlaps t22 of the left finger by up to 5.000 mm"]);
    assert_eq!(run_json(&["replay", &log, "--json"])["warnings"], run["warnings"]);
    for text in [phalanx(&["run", &scene]), phalanx(&["replay", &log])].map(|output| stdout(&output).to_string()) {
        assert_contains(&text, &[&format!("Warning: {warning}")]);
    }
    let page = fs::read_to_string(page).expect("the page");
    assert!(page.contains("overlaps t22 of the left finger"), "the page has the warning");
}

#[test]
fn summaries_and_pages_name_fingers_and_object() {
    let dir = directory("cli_gripper_page");
    let page = dir.join("run.html").display().to_string();
    let parts = [
        "right finger",
        "left finger",
        "object",
        "left proximal",
        "table",
        "right limit",
        "held",
        "centres the object",
    ];
    assert_contains(&succeed(&["run", GRIPPER, "--all", "--plot", &page]), &parts);
    let html = fs::read_to_string(&page).expect("the page");
    assert_contains(&html, &["right_l21", "left_l22", "\"table\"", "left distal"]);
    // Without friction the disc is ejected.
    let ejected = succeed(&["run", "scenes/hard/gripper-no-friction.toml"]);
    assert_contains(
        &ejected,
        &[
            "ejected at 34.00 ms: out of the reach of both fingers at 33.9991 ms",
            "the object left the reach of both fingers at 33.99",
        ],
    );
}

/// A complete cycle, and one that loses its object.
#[test]
fn summaries_describe_the_outcome_of_a_cycle() {
    let cycle = succeed(&["run", "--no-check", "scenes/gripper/cycle.toml"]);
    assert_contains(
        &cycle,
        &[
            "held since 4.501 ms: ",
            "transport from 20.0000 ms to 350.000 ms: the object travels 3.5 µm in the hand",
            "joints with brakes rotate by up to 0.001",
            "released at 350.000 ms; the hand is clear of the object 4.12",
            "ms later; cycle time 354.12",
        ],
    );
    let dropped = succeed(&["run", "--no-check", "scenes/gripper/cycle-dropped.toml"]);
    assert_contains(
        &dropped,
        &["dropped at 100.2 ms: no longer gripped from 100.204 ms on", "ms to the end: the object travels"],
    );
    assert!(!dropped.contains("released"), "{dropped}");
}

#[test]
fn sweeps_vary_any_field_of_a_gripper() {
    let dir = directory("cli_gripper_sweep");
    let study = write(
        &dir,
        "study.toml",
        "[scene]\nkind = \"gripper\"\nsizing = \"rigid\"\npalm_width = \"34 mm\"\npositioning_error = \"3 mm\"\n\
         [scene.design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n[scene.table]\n\
         [[axes]]\nfield = \"contact.friction.mu_static\"\nvalues = [0.0, 0.8]\n\
         [[axes]]\nfield = \"object.offset\"\nvalues = [\"0 mm\", \"2 mm\", \"-2 mm\", \"5 mm\"]\n",
    );
    let out = dir.join("out.csv").display().to_string();
    let report = run_json(&["sweep", &study, "--out", &out, "--json"]);
    assert_eq!((report["runs"].as_u64(), report["by_status"]["refused"].as_u64()), (Some(8), Some(2)), "{report:?}");
    assert!(report["by_class"]["held"].as_u64() >= Some(3), "{report:?}");
    let text = fs::read_to_string(&out).expect("the table");
    let columns: Vec<&str> = text.lines().next().expect("a head").split(',').collect();
    let cell = |line: &str, name: &str| {
        let column = columns.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}: {columns:?}"));
        line.split(',').nth(column).expect("a cell").to_string()
    };
    let lines: Vec<&str> = text.lines().skip(1).collect();
    // Offsets of 2 mm to either side are mirror images.
    let ends = [5, 6].map(|run| cell(lines[run], "x_m").parse::<f64>().expect("a number"));
    assert!((ends[0] + ends[1]).abs() < 1e-7 && ends[0].abs() < 2e-3, "{ends:?}");
    assert!(cell(lines[7], "reason").contains("positioning_error"), "{}", lines[7]);
    // Filters and some fields exist only for single fingers.
    let invalid_study = write(
        &dir,
        "wrong.toml",
        "scene = \"gripper.toml\"\n[filter]\nform_closed = true\n[[axes]]\nfield = \"object.centre\"\nvalues = [[\"0 mm\", \"20 mm\"]]\n",
    );
    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    write(&dir, "gripper.toml", &format!("kind = \"gripper\"\nsizing = \"rigid\"\n{design}"));
    let parts = ["[filter] concerns the statics of one finger", "object.centre"];
    assert_rejected(&["sweep", &invalid_study, "--out", &out], &parts);
}

#[test]
fn capture_writes_table_and_picture() {
    let dir = directory("cli_gripper_capture");
    let out = dir.join("capture").display().to_string();
    let args = ["capture", GRIPPER, "--to", "3.5 mm", "--places", "5", "--out", &out, "--json"];
    let report = run_json(&args);
    assert_eq!((report["captured_from_m"].as_f64(), report["captured_to_m"].as_f64()), (Some(-3.5e-3), Some(3.5e-3)));
    let places = report["places"].as_array().expect("places");
    assert_eq!(places.len(), 5);
    let final_x = |index: usize| places[index]["x_m"].as_f64().expect("a place");
    assert!((final_x(0) + final_x(4)).abs() < 1e-7 && (final_x(4) - 0.5504e-3).abs() < 1e-6 && final_x(2).abs() < 1e-9);
    for file in ["capture.json", "capture.csv", "capture.svg", "capture.txt"] {
        assert!(fs::metadata(format!("{out}/{file}")).expect(file).len() > 300, "{file}");
    }
    let text = fs::read_to_string(format!("{out}/capture.txt")).expect("UTF-8 text");
    assert_contains(&text, &["Captured: from −3.500 mm (the requested limit) to +3.500 mm (the requested limit)."]);
    // Without friction and table the object is lost even in the middle.
    let slippery = ["--set", "contact.friction.mu_static=0", "--set", "duration=60 ms"];
    let capture_args = ["capture", "scenes/gripper/design-95.toml", "--to", "0.1 mm", "--places", "3", "--json"];
    let report = run_json(&[&capture_args[..], &slippery].concat());
    assert!(report["captured_from_m"].is_null() && report["places"][1]["fate"] == "ejected", "{report:?}");
    for (args, message) in [
        (vec!["capture", EXPERIMENT_95], "is not a gripper"),
        (vec!["capture", GRIPPER, "--to", "9 mm"], "ground joint"),
        (vec!["capture", GRIPPER, "--places", "4"], "odd number"),
    ] {
        assert_rejected(&args, &[message]);
    }
}

/// A run of the study gives the same result as a single run of the scene with the same move.
#[test]
fn hold_agrees_with_runs_of_the_same_move() {
    let dir = directory("cli_gripper_hold");
    let out = dir.join("hold").display().to_string();
    let svg = dir.join("polar.svg").display().to_string();
    let scan = ["--scan", "4", "--from", "5 m/s^2", "--to", "1280 m/s^2", "--tol", "0.1"];
    let args = [&["hold", HOLD, "--directions", "4", "--out", &out, "--plot", &svg, "--json"][..], &scan].concat();
    let report = run_json(&args);
    let loads = report["loads"].as_array().expect("loads");
    assert_eq!((loads.len(), report["begins"].as_str()), (4, Some("at rest")));
    let start_s = report["begins_s"].as_f64().expect("a time");
    let out_of_the_palm = &loads[1];
    assert!((out_of_the_palm["direction_rad"].as_f64().expect("an angle") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    for (limit, key, is_held) in
        [("slips", "held_m_s2", true), ("slips", "failed_m_s2", false), ("drops", "failed_m_s2", false)]
    {
        let peak = &out_of_the_palm[limit][key];
        let runs = out_of_the_palm["runs"].as_array().expect("runs");
        let run = runs.iter().find(|run| run["peak_m_s2"] == *peak).expect("a run at this peak");
        let set = [
            format!("moves.push.y={} m", run["distance_m"]),
            format!("moves.push.start={start_s} s"),
            "moves.push.time=40 ms".to_string(),
            format!("duration={} s", start_s + 70e-3),
        ];
        let set: Vec<&str> = set.iter().flat_map(|field| ["--set", field.as_str()]).collect();
        let single_run = run_json(&[&["run", HOLD, "--no-check", "--json"][..], &set].concat());
        assert_eq!(single_run["grasp"]["fate"], run["fate"], "{limit} {key}");
        let slip = |report: &Value| report["displacement_m"].as_f64().expect("a slip");
        let (single_run, study_slip) = (slip(&single_run["grasp"]["cycle"]["carried"]), slip(&run["slip"]));
        assert!((single_run - study_slip).abs() < 0.02 * study_slip, "{limit} {key}: {single_run} {study_slip}");
        assert_eq!(study_slip <= 0.5e-3, is_held, "{limit} {key}: {study_slip}");
    }
    assert_eq!(out_of_the_palm["slips"]["ended_by"].as_str(), Some("slip"));
    for file in ["hold.json", "hold.csv", "hold.svg", "hold.txt"] {
        assert!(fs::metadata(format!("{out}/{file}")).expect(file).len() > 300, "{file}");
    }
    assert_eq!(fs::read(&svg).expect("the picture"), fs::read(format!("{out}/hold.svg")).expect("the picture"));
    let text = fs::read_to_string(format!("{out}/hold.txt")).expect("UTF-8 text");
    assert_contains(
        &text,
        &[
            "+y (out of the palm)",
            "when the object is at rest",
            "palm): the object slips less than 0.500 mm up to ",
            "Smallest limit: ",
        ],
    );
    let lines = fs::read_to_string(format!("{out}/hold.csv")).expect("UTF-8 text").lines().count();
    assert_eq!(report["runs"].as_u64(), Some(lines as u64 - 1));
}

#[test]
fn vibrations_and_moves_report_their_figures() {
    let dir = directory("cli_gripper_shaken");
    let svg = dir.join("vibration.svg").display().to_string();
    let coarse_scan = ["--scan", "3", "--from", "10 m/s^2", "--to", "40 m/s^2", "--tol", "0.2", "--json"];
    let vibration = ["--along", "y,angle", "--vibration", "100 Hz, 200 Hz, 400 Hz", "--plot", &svg];
    let report = run_json(&[&["hold", HOLD][..], &vibration, &coarse_scan].concat());
    let loads = report["loads"].as_array().expect("loads");
    assert_eq!(loads.len(), 6);
    let (translation, rotation) = (&loads[0]["runs"][0], &loads[3]["runs"][0]);
    let amplitude_m = translation["peak_m_s2"].as_f64().expect("a peak") / (200.0 * std::f64::consts::PI).powi(2);
    assert!((translation["amplitude_m"].as_f64().expect("an amplitude") - amplitude_m).abs() < 1e-12);
    // The object's centre is 20 mm from the middle of the palm.
    assert!((rotation["amplitude_rad"].as_f64().expect("an amplitude") - amplitude_m / 0.02).abs() < 1e-9);
    assert!(rotation["amplitude_m"].is_null() && loads[3]["quasi_static"].is_null());
    assert!(fs::read_to_string(&svg).expect("the picture").contains("frequency, Hz"));
    let report = run_json(&[&["hold", "scenes/gripper/cycle.toml", "--move"][..], &coarse_scan].concat());
    let run = &report["loads"][0]["runs"][0];
    assert_eq!((report["begins"].as_str(), run["fate"].as_str()), (Some("own move"), Some("held")));
    let expected_s = 0.32 * (0.305 * 3.36 * 5f64.sqrt() / 0.04 / 10.0).sqrt();
    assert!((run["time_s"].as_f64().expect("a time") - expected_s).abs() < 1e-5 * expected_s, "{run:?}");
    for (args, message) in [
        (vec!["hold", EXPERIMENT_95], "is not a gripper"),
        (vec!["hold", GRIPPER], "lies on a table"),
        (vec!["hold", GRIPPER, "--from", "9 m/s^2", "--to", "3 m/s^2"], "--from must be smaller"),
        (vec!["hold", GRIPPER, "--move", "--directions", "4"], "cannot be used with"),
        (vec!["hold", GRIPPER, "--along", "x"], "--vibration"),
        (vec!["hold", GRIPPER, "--vibration", "50 Hz", "--along", "x,x"], "an axis twice"),
        (vec!["hold", GRIPPER, "--slip", "0 mm"], "more than 0"),
        (vec!["hold", GRIPPER, "--directions", "0"], "from 1 to 360"),
        (vec!["hold", GRIPPER, "--scan", "1"], "from 2 to 1000"),
        (vec!["hold", GRIPPER, "--tol", "1"], "below 1"),
        (vec!["hold", GRIPPER, "--vibration", "50 Hz,50 Hz"], "given twice"),
        (vec!["hold", HOLD, "--vibration", "1e-300 Hz"], "more than the 3600 s allowed; set a higher frequency"),
        (vec!["hold", HOLD, "--move", "--from", "1e-300 m/s^2"], "a larger --from"),
    ] {
        assert_rejected(&args, &[message]);
    }
    let parts =
        ["up to 2.000 m/s² (0.204 g, over 0.426 mm), the largest load, and is held", "2 loads of 2", "raise --to."];
    assert_contains(&succeed(&["hold", HOLD, "--directions", "2", "--scan", "2", "--to", "2 m/s^2"]), &parts);
}
