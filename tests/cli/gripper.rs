//! Grippers on the command line: a run, its log and what is made of it, a page, a sweep, and what is captured.

use std::fs;

use serde_json::Value;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};

const GRIPPER: &str = "scenes/gripper/offset.toml";

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
        for key in ["fingers", "object", "grasp", "energy"] {
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
    assert!(text.contains("EJECTED: the object was thrown out of the gripper at 34.8"), "{text}");
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
