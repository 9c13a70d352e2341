//! Grippers on the command line: a run, its log and what is made of it, a page, a sweep, what is captured, and what is held.

use std::fs;

use serde_json::Value;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};

const GRIPPER: &str = "scenes/gripper/offset.toml";
const HOLD: &str = "scenes/gripper/hold.toml";

fn done(args: &[&str]) -> Value {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    json(&output)
}

#[test]
fn a_log_says_what_its_run_said() {
    let dir = directory("cli_gripper_log");
    for model in ["analytic", "engine"] {
        let log = dir.join(format!("{model}.mcap")).display().to_string();
        let run = done(&["run", GRIPPER, "--model", model, "--log", &log, "--json"]);
        assert_eq!((run["kind"].as_str(), run["grasp"]["fate"].as_str()), (Some("gripper"), Some("held")));
        let replay = done(&["replay", &log, "--json"]);
        for key in ["fingers", "object", "grasp", "energy", "warnings"] {
            assert_eq!(replay[key], run[key], "{model}: {key}");
        }
        for (place, contact) in run["contacts"].as_object().expect("contacts") {
            for (figure, value) in contact.as_object().expect("figures") {
                assert_eq!(replay["contacts"][place][figure], *value, "{model}: {place} {figure}");
            }
        }
        let verified = done(&["replay", &log, "--verify", "--json"]);
        assert_eq!(verified["verification"]["same"], Value::Bool(true), "{verified:?}");
        // What is there of a log that breaks off is a gripper too.
        let bytes = fs::read(&log).expect("the log");
        let cut = dir.join(format!("{model}-cut.mcap"));
        fs::write(&cut, &bytes[..bytes.len() / 2]).expect("written");
        let half = json(&phalanx(&["replay", cut.to_str().expect("text"), "--json"]));
        assert!(half["fingers"]["left"]["q21_rad"].is_number() && half["grasp"].is_null(), "{half:?}");
    }
    let logs = ["analytic", "engine"].map(|model| dir.join(format!("{model}.mcap")).display().to_string());
    let against = done(&["replay", &logs[0], "--against", &logs[1], "--json"]);
    let quantities: Vec<&str> =
        against["apart"].as_array().expect("differences").iter().filter_map(|of| of["quantity"].as_str()).collect();
    assert_eq!(quantities.len(), 7, "{quantities:?}");
    assert!(quantities.contains(&"left_q22_rad") && quantities.contains(&"object_centre_m"), "{quantities:?}");
}

/// Fingers around an object of 4 mm cross each other.
#[test]
fn links_that_pass_through_each_other_are_a_warning_everywhere() {
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
    let run = done(&["run", &scene, "--log", &log, "--html", &page, "--json"]);
    let warning = run["warnings"][0].as_str().expect("a warning");
    assert!(
        warning.starts_with("t22 of the right finger overlaps t22 of the left finger by up to 5.000 mm"),
        "{warning}"
    );
    assert_eq!(done(&["replay", &log, "--json"])["warnings"], run["warnings"]);
    for text in [phalanx(&["run", &scene]), phalanx(&["replay", &log])].map(|output| stdout(&output).to_string()) {
        assert!(text.contains(&format!("Warning: {warning}")), "{text}");
    }
    let page = fs::read_to_string(page).expect("the page");
    assert!(page.contains("overlaps t22 of the left finger"), "the page has the warning");
}

#[test]
fn samples_have_a_column_for_each_figure() {
    let dir = directory("cli_gripper_csv");
    let log = dir.join("run.mcap").display().to_string();
    done(&["run", GRIPPER, "--log", &log, "--json", "--no-check"]);
    let output = phalanx(&["replay", &log, "--csv", "-"]);
    let text = stdout(&output).to_string();
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().expect("a head").split(',').collect();
    for column in
        ["right_q11_rad", "left_qd22_rad_s", "object_x_m", "left_limit_gap_rad", "table_normal_n", "balance_j"]
    {
        assert!(columns.contains(&column), "{column}: {columns:?}");
    }
    let last: Vec<&str> = lines.last().expect("samples").split(',').collect();
    let x = columns.iter().position(|column| *column == "object_x_m").expect("a column");
    let x: f64 = last[x].parse().expect("a number");
    assert!((x - 0.5504e-3).abs() < 1e-6, "{x}");
}

#[test]
fn summaries_and_pages_name_fingers_and_object() {
    let dir = directory("cli_gripper_page");
    let page = dir.join("run.html").display().to_string();
    let output = phalanx(&["run", GRIPPER, "--html", &page]);
    let text = stdout(&output).to_string();
    for part in
        ["right finger", "left finger", "object", "left proximal", "table", "right limit", "held", "centres the object"]
    {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let html = fs::read_to_string(&page).expect("the page");
    for part in ["right_l21", "left_l22", "\"table\"", "left distal"] {
        assert!(html.contains(part), "{part}");
    }
    // Without friction the disc is thrown out.
    let text = stdout(&phalanx(&["run", "scenes/hard/gripper-no-friction.toml"])).to_string();
    assert!(text.contains("EJECTED: the object left the reach of both fingers at 33.99"), "{text}");
}

/// A cycle from end to end, one that loses its object, and one that ends before its fingers let go.
#[test]
fn summaries_say_what_became_of_a_cycle() {
    let told = |args: &[&str]| {
        let output = phalanx(&[&["run", "--no-check"], args].concat());
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
        stdout(&output).to_string()
    };
    let cycle = told(&["scenes/gripper/cycle.toml"]);
    for line in [
        "Carried from 20.000000 ms to 350.000000 ms: slip in the hand 3.4",
        "Blocked driven links turn by up to 0.001",
        "Let go, and clear of the object 4.12",
        "ms later: a cycle of 354.12",
    ] {
        assert!(cycle.contains(line), "{line}: {cycle}");
    }
    let dropped = told(&["scenes/gripper/cycle-dropped.toml"]);
    assert!(dropped.contains("Dropped: no longer held from 123.883"), "{dropped}");
    assert!(dropped.contains("ms to the end: slip in the hand") && !dropped.contains("Let go"), "{dropped}");
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
    let report = done(&["sweep", &study, "--out", &out, "--json"]);
    assert_eq!((report["runs"].as_u64(), report["by_status"]["refused"].as_u64()), (Some(8), Some(2)), "{report:?}");
    assert!(report["by_class"]["held"].as_u64() >= Some(3), "{report:?}");
    let text = fs::read_to_string(&out).expect("the table");
    let columns: Vec<&str> = text.lines().next().expect("a head").split(',').collect();
    let cell = |line: &str, name: &str| {
        let at = columns.iter().position(|column| *column == name).unwrap_or_else(|| panic!("{name}: {columns:?}"));
        line.split(',').nth(at).expect("a cell").to_string()
    };
    let lines: Vec<&str> = text.lines().skip(1).collect();
    // 2 mm to either side are mirror images.
    let ends = [5, 6].map(|run| cell(lines[run], "x_m").parse::<f64>().expect("a number"));
    assert!((ends[0] + ends[1]).abs() < 1e-7 && ends[0].abs() < 2e-3, "{ends:?}");
    assert!(cell(lines[7], "reason").contains("positioning_error"), "{}", lines[7]);
    // A filter speaks of one finger; so do fields of one.
    let wrong = write(
        &dir,
        "wrong.toml",
        "scene = \"gripper.toml\"\n[filter]\nform_closed = true\n[[axes]]\nfield = \"object.centre\"\nvalues = [[\"0 mm\", \"20 mm\"]]\n",
    );
    let design = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n";
    write(&dir, "gripper.toml", &format!("kind = \"gripper\"\nsizing = \"rigid\"\n{design}"));
    let output = phalanx(&["sweep", &wrong, "--out", &out]);
    let said = stderr(&output).to_string();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("[filter] is about the statics of one finger") && said.contains("object.centre"), "{said}");
}

#[test]
fn what_is_captured_is_a_table_and_a_picture() {
    let dir = directory("cli_gripper_capture");
    let out = dir.join("capture").display().to_string();
    let args = ["capture", GRIPPER, "--to", "3.5 mm", "--places", "5", "--out", &out, "--json"];
    let report = done(&args);
    assert_eq!((report["captured_from_m"].as_f64(), report["captured_to_m"].as_f64()), (Some(-3.5e-3), Some(3.5e-3)));
    let places = report["places"].as_array().expect("places");
    assert_eq!(places.len(), 5);
    let end = |index: usize| places[index]["x_m"].as_f64().expect("a place");
    assert!((end(0) + end(4)).abs() < 1e-7 && (end(4) - 0.5504e-3).abs() < 1e-6 && end(2).abs() < 1e-9);
    for file in ["capture.json", "capture.csv", "capture.svg", "capture.txt"] {
        assert!(fs::metadata(format!("{out}/{file}")).expect(file).len() > 300, "{file}");
    }
    let text = fs::read_to_string(format!("{out}/capture.txt")).expect("text");
    assert!(
        text.contains("Captured: from −3.500 mm (as far as was asked) to +3.500 mm (as far as was asked)."),
        "{text}"
    );
    // Without friction and table nothing is held for long: not even in the middle.
    let slippery = ["--set", "contact.friction.mu_static=0", "--set", "duration=60 ms"];
    let alone = ["capture", "scenes/gripper/design-95.toml", "--to", "0.1 mm", "--places", "3", "--json"];
    let report = done(&[&alone[..], &slippery].concat());
    assert!(report["captured_from_m"].is_null() && report["places"][1]["fate"] == "ejected", "{report:?}");
    for (args, said) in [
        (vec!["capture", ANCHOR], "is no gripper"),
        (vec!["capture", GRIPPER, "--to", "9 mm"], "ground joint"),
        (vec!["capture", GRIPPER, "--places", "4"], "odd number"),
    ] {
        let output = phalanx(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(stderr(&output).contains(said), "{args:?}: {}", stderr(&output));
    }
}

/// The study's runs are runs like any other: the scene with the same move says the same.
#[test]
fn what_is_held_is_what_a_run_with_the_same_move_says() {
    let dir = directory("cli_gripper_hold");
    let out = dir.join("hold").display().to_string();
    let svg = dir.join("polar.svg").display().to_string();
    let scan = ["--scan", "4", "--from", "5 m/s^2", "--to", "1280 m/s^2", "--tol", "0.1"];
    let args = [&["hold", HOLD, "--directions", "4", "--out", &out, "--svg", &svg, "--json"][..], &scan].concat();
    let report = done(&args);
    let loads = report["loads"].as_array().expect("loads");
    assert_eq!((loads.len(), report["begins"].as_str()), (4, Some("at rest")));
    let begins_s = report["begins_s"].as_f64().expect("a time");
    let out_of_the_palm = &loads[1];
    assert!((out_of_the_palm["direction_rad"].as_f64().expect("an angle") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    for (limit, key, held) in
        [("slips", "held_m_s2", true), ("slips", "failed_m_s2", false), ("drops", "failed_m_s2", false)]
    {
        let peak = &out_of_the_palm[limit][key];
        let runs = out_of_the_palm["runs"].as_array().expect("runs");
        let run = runs.iter().find(|run| run["peak_m_s2"] == *peak).expect("it was tried");
        let set = [
            format!("moves.push.y={} m", run["distance_m"]),
            format!("moves.push.start={begins_s} s"),
            "moves.push.time=40 ms".to_string(),
            format!("duration={} s", begins_s + 70e-3),
        ];
        let set: Vec<&str> = set.iter().flat_map(|field| ["--set", field.as_str()]).collect();
        let alone = done(&[&["run", HOLD, "--no-check", "--json"][..], &set].concat());
        assert_eq!(alone["grasp"]["fate"], run["fate"], "{limit} {key}");
        let slip = |of: &Value| of["displacement_m"].as_f64().expect("a slip");
        let (alone, studied) = (slip(&alone["grasp"]["cycle"]["carried"]), slip(&run["slip"]));
        assert!((alone - studied).abs() < 0.02 * studied, "{limit} {key}: {alone} {studied}");
        assert_eq!(studied <= 0.5e-3, held, "{limit} {key}: {studied}");
    }
    assert_eq!(out_of_the_palm["slips"]["ended_by"].as_str(), Some("slip"));
    for file in ["hold.json", "hold.csv", "hold.svg", "hold.txt"] {
        assert!(fs::metadata(format!("{out}/{file}")).expect(file).len() > 300, "{file}");
    }
    assert_eq!(fs::read(&svg).expect("the picture"), fs::read(format!("{out}/hold.svg")).expect("the picture"));
    let text = fs::read_to_string(format!("{out}/hold.txt")).expect("text");
    for part in [
        "+y (out of the palm)",
        "where the object is at rest",
        "palm): the object slips less than 0.500 mm up to ",
        "Least: ",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let lines = fs::read_to_string(format!("{out}/hold.csv")).expect("text").lines().count();
    assert_eq!(report["runs"].as_u64(), Some(lines as u64 - 1));
}

#[test]
fn vibrations_and_moves_have_their_own_figures() {
    let dir = directory("cli_gripper_shaken");
    let svg = dir.join("shaken.svg").display().to_string();
    let few = ["--scan", "3", "--from", "10 m/s^2", "--to", "40 m/s^2", "--tol", "0.2", "--json"];
    let shaken = [
        "hold",
        "scenes/gripper/hold.toml",
        "--along",
        "y,angle",
        "--svg",
        &svg,
        "--vibration",
        "100 Hz, 200 Hz, 400 Hz",
    ];
    let report = done(&[&shaken[..], &few].concat());
    let loads = report["loads"].as_array().expect("loads");
    assert_eq!(loads.len(), 6);
    let (along, about) = (&loads[0]["runs"][0], &loads[3]["runs"][0]);
    let amplitude_m = along["peak_m_s2"].as_f64().expect("a peak") / (200.0 * std::f64::consts::PI).powi(2);
    assert!((along["amplitude_m"].as_f64().expect("an amplitude") - amplitude_m).abs() < 1e-12);
    // The object's centre is 20 mm from the middle of the palm.
    assert!((about["amplitude_rad"].as_f64().expect("an amplitude") - amplitude_m / 0.02).abs() < 1e-9);
    assert!(about["amplitude_m"].is_null() && loads[3]["quasi_static"].is_null());
    assert!(fs::read_to_string(&svg).expect("the picture").contains("frequency, Hz"));
    let report = done(&[&["hold", "scenes/gripper/cycle.toml", "--move"][..], &few].concat());
    let run = &report["loads"][0]["runs"][0];
    assert_eq!((report["begins"].as_str(), run["fate"].as_str()), (Some("own move"), Some("held")));
    let own_s = 0.32 * (0.305 * 3.36 * 5f64.sqrt() / 0.04 / 10.0).sqrt();
    assert!((run["time_s"].as_f64().expect("a time") - own_s).abs() < 1e-5 * own_s, "{run:?}");
    for (args, said) in [
        (vec!["hold", ANCHOR], "is no gripper"),
        (vec!["hold", GRIPPER], "lies on a table"),
        (vec!["hold", GRIPPER, "--from", "9 m/s^2", "--to", "3 m/s^2"], "the first must be smaller"),
        (vec!["hold", GRIPPER, "--move", "--directions", "4"], "cannot be used with"),
        (vec!["hold", GRIPPER, "--along", "x"], "--vibration"),
        (vec!["hold", GRIPPER, "--vibration", "50 Hz", "--along", "x,x"], "an axis twice"),
        (vec!["hold", GRIPPER, "--slip", "0 mm"], "more than 0"),
        (vec!["hold", HOLD, "--vibration", "1e-300 Hz"], "a run may take 3600 s; give a higher frequency"),
        (vec!["hold", HOLD, "--move", "--from", "1e-300 m/s^2"], "a larger --from"),
    ] {
        let output = phalanx(&args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(stderr(&output).contains(said), "{args:?}: {}", stderr(&output));
    }
    let low = phalanx(&["hold", HOLD, "--directions", "2", "--scan", "2", "--to", "2 m/s^2"]);
    for part in
        ["up to 2.000 m/s² (0.204 g, over 0.426 mm), the largest tried, and is held", "2 loads of 2", "raise --to."]
    {
        assert!(stdout(&low).contains(part), "{part}\n{}", stdout(&low));
    }
}
