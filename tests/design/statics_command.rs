//! `phalanx statics` for a finger: output, plot and rejected input.

use crate::support::cli::{EXPERIMENT_95, directory, json, phalanx, stderr, stdout, write};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    assert!((number(value) - expected).abs() <= tolerance, "{value} is not {expected} ± {tolerance}");
}

#[test]
fn json_of_experiment_95() {
    let output = phalanx(&["statics", EXPERIMENT_95, "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let report = json(&output);
    assert_eq!(report["scene"], "experiment-95");
    // 1-model §1.8: q11 and q21 at 20 ms; they include a penetration of 3 µm.
    assert_near(&report["final"]["q11_rad"], 2.0888f64.to_radians(), 2e-4);
    assert_near(&report["final"]["q21_rad"], 65.0200f64.to_radians(), 5e-4);
    assert_near(&report["drive"]["motor_n_m"], 0.48, 0.0);
    assert_near(&report["drive"]["spring"]["torque_n_m"], 0.1326, 1e-15);
    let forces = report["forces"].as_array().unwrap();
    assert_eq!(forces.len(), 2);
    assert_eq!(forces[1]["mu_static"], serde_json::json!([0.8, 0.8]));
    assert_near(&forces[0]["f21_n"], 23.6, 0.1);
    assert_near(&forces[0]["f22_n"], 8.26, 0.1);
    assert_eq!((&forces[0]["palm_force_positive"], &forces[1]["palm_force_positive"]), (&false.into(), &true.into()));
    assert_eq!(forces[1]["ejection"], "none");
    let closure = &report["form_closure"];
    assert_eq!((&closure["closed"], &closure["rank"], &closure["unknowns"]), (&true.into(), &6.into(), &6.into()));
    assert_eq!(closure["multipliers"].as_array().unwrap().len(), 7);
    assert!(closure.get("motion").is_none() && number(&closure["residual"]) < 1e-12);
    assert!(report.get("svg").is_none());
}

/// JSON keys of dimensionless numbers.
const DIMENSIONLESS: [&str; 13] = [
    "mu_static",
    "normal",
    "transmission",
    "transmission_inverse",
    "contacts",
    "motors",
    "hand",
    "object",
    "rank",
    "unknowns",
    "margin",
    "residual",
    "forces",
];
const UNITS: [&str; 6] = ["_m", "_n", "_n_m", "_rad", "_m_s", "_rad_s"];

fn check_units(key: &str, value: &Value) {
    match value {
        Value::Number(_) => assert!(
            DIMENSIONLESS.contains(&key) || UNITS.iter().any(|unit| key.ends_with(unit)),
            "the number under \"{key}\" has no unit"
        ),
        Value::Array(values) => values.iter().for_each(|value| check_units(key, value)),
        Value::Object(fields) => fields.iter().for_each(|(key, value)| check_units(key, value)),
        _ => {}
    }
}

#[test]
fn every_number_has_its_unit() {
    let directory = directory("statics-units");
    check_units("", &json(&phalanx(&["statics", EXPERIMENT_95, "--json"])));
    check_units("", &json(&phalanx(&["statics", &open_grasp(&directory), "--json"])));
}

/// Writes a scene with a finger so close that its motor squeezes the object out.
fn open_grasp(directory: &std::path::Path) -> String {
    write(
        directory,
        "open.toml",
        "[design]\nbase = \"12 mm\"\nl21_fraction = 0.5\nphi22 = \"90 deg\"\narm_ratio = 0.5\n[motor]\ntorque = \"60 \
         N*mm\"\n[spring]\ntorque = \"132.6 N*mm\"\n",
    )
}

#[test]
fn free_motion_is_described_and_drawn() {
    let directory = directory("statics-open");
    let (scene, picture) = (open_grasp(&directory), directory.join("grasp.svg"));
    let output = phalanx(&["statics", &scene, "--svg", picture.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for fragment in [
        "not closed",
        "The object moves straight away from the palm at 1.00 mm/s.",
        "Both fingers: the proximal phalanx closes at",
        "Contact is lost at: palm; maintained at: right proximal phalanx, right tip, left proximal phalanx, left tip.",
        "μ_s 0: the distal phalanx would have to pull",
        "the distal phalanx pushes the object at motor torques above",
    ] {
        assert!(text.contains(fragment), "no \"{fragment}\" in\n{text}");
    }
    let svg = std::fs::read_to_string(&picture).unwrap();
    for fragment in
        ["open: the grasp at rest", "distal phalanx: would have to pull", "palm: would have to pull", "a free motion"]
    {
        assert!(svg.contains(fragment), "no \"{fragment}\" in the picture");
    }
    // The legend identifies the forces; each has its own colour, for light and dark backgrounds.
    assert!(svg.contains("forces on the object"));
    let legend_colour = |label: &str| {
        let head = svg.split(label).next().expect("text before the label");
        let line = head.rsplit("<path").next().expect("the line next to the label");
        line.split("stroke=\"").nth(1).and_then(|rest| rest.get(..7)).expect("a colour").to_string()
    };
    let colours = ["F21, by the proximal phalanx", "F22, by the distal phalanx"].map(legend_colour);
    assert_eq!(colours, ["#0072B2", "#C75300"]);
    for rule in [
        "@media(prefers-color-scheme:dark){svg:root{",
        "--panel:#1b1f26",
        "[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}",
        "[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}",
    ] {
        assert!(svg.contains(rule), "{rule}");
    }
    let repeated = directory.join("again.svg");
    phalanx(&["statics", &scene, "--svg", repeated.to_str().unwrap()]);
    assert_eq!(svg, std::fs::read_to_string(&repeated).unwrap());
    phalanx(&["statics", EXPERIMENT_95, "--svg", repeated.to_str().unwrap()]);
    let closed = std::fs::read_to_string(&repeated).unwrap();
    assert!(closed.contains("form-closed") && !closed.contains("a free motion"));

    let report = json(&phalanx(&["statics", &scene, "--json"]));
    let motion = &report["form_closure"]["motion"];
    assert_eq!(motion["object_m_s"], serde_json::json!([0.0, 0.001]));
    assert_eq!(motion["rates"].as_array().unwrap().len(), 7);
    assert!(number(&motion["fingers"][0]["motor_rad_s"]) > 0.0);
}

#[test]
fn friction_and_motor_can_be_set() {
    let output = phalanx(&["statics", EXPERIMENT_95, "--mu-static", "0,0.4", "--motor", "0.5165 N*m", "--json"]);
    let report = json(&output);
    assert_near(&report["drive"]["motor_n_m"], 0.5165, 0.0);
    let forces = report["forces"].as_array().unwrap();
    assert_eq!(forces.iter().map(|entry| number(&entry["mu_static"][0])).collect::<Vec<_>>(), [0.0, 0.4]);
    for (arguments, fragment) in [
        (["--mu-static", "-0.5"], "0, 0.4, 0.8"),
        (["--mu-static", "much"], "expected one or more comma-separated numbers, each 0 or more"),
        (["--motor", "480"], "has no unit"),
        (["--motor", "480 mm"], "torque"),
    ] {
        let arguments: Vec<&str> = ["statics", EXPERIMENT_95].into_iter().chain(arguments).collect();
        let output = phalanx(&arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(fragment) || fragment.starts_with('0'), "{}", stderr(&output));
    }
}

#[test]
fn accepts_scenes_with_lengths_and_torsional_springs() {
    let report = json(&phalanx(&["statics", "scenes/long-fingers.toml", "--json"]));
    // Final forces stated in the comment of the scene: 13.7 N and 11.1 N.
    assert_near(&report["forces"][0]["f21_n"], 13.7, 0.1);
    assert_near(&report["forces"][0]["f22_n"], 11.1, 0.1);
    let report = json(&phalanx(&["statics", "scenes/torsional-spring.toml", "--json"]));
    assert_eq!(report["drive"]["spring"]["type"], "torsional");
    // The two scenes differ only in properties that do not affect form closure.
    assert_eq!(report["form_closure"], json(&phalanx(&["statics", EXPERIMENT_95, "--json"]))["form_closure"]);
}

#[test]
fn grasp_without_a_palm_contact_is_not_form_closed() {
    let directory = directory("statics-palm");
    let anchor = std::fs::read_to_string(EXPERIMENT_95).unwrap();
    let without_palm = write(&directory, "none.toml", &anchor.replacen("name =", "palm = false\nname =", 1));
    let text = stdout(&phalanx(&["statics", &without_palm])).to_string();
    assert!(
        text.contains("form closure of two fingers: not closed") && text.contains("the scene has no palm"),
        "{text}"
    );
    assert!(
        text.contains("4 contacts + 2 motors < 4 degrees of freedom of the fingers + 2 of the object + 1, not met"),
        "{text}"
    );

    let compact = anchor
        .replace("15.5 mm", "12 mm")
        .replace("120 deg", "100 deg")
        .replace("l21_fraction = 1.0", "l21_fraction = 0.0");
    for (height, palm, closed) in [("20.5 mm", "apart", false), ("19.9 mm", "within", true)] {
        let scene =
            write(&directory, "raised.toml", &format!("{compact}\n[object]\ncentre = [\"-12 mm\", \"{height}\"]\n"));
        let output = phalanx(&["statics", &scene, "--json"]);
        let closure = &json(&output)["form_closure"];
        assert_eq!((&closure["palm"], &closure["closed"]), (&palm.into(), &closed.into()), "{height}");
    }
    assert_eq!(json(&phalanx(&["statics", EXPERIMENT_95, "--json"]))["form_closure"]["palm"], "rests");
}

#[test]
fn rejects_scenes_without_a_grasp() {
    let directory = directory("statics-refused");
    for (scene, fragment) in [
        ("scenes/free-swing.toml", "no object"),
        ("scenes/laws/spring.toml", "scene of discs"),
        ("scenes/hard/misses.toml", "make l21 longer"),
        ("scenes/nowhere.toml", "nowhere.toml"),
    ] {
        let output = phalanx(&["statics", scene, "--svg", directory.join("x.svg").to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{scene}");
        assert!(stderr(&output).starts_with("error: ") && stderr(&output).contains(fragment), "{}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
    assert!(!directory.join("x.svg").exists());
    let output = phalanx(&["statics", EXPERIMENT_95, "--svg", directory.join("no/where.svg").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("mkdir -p"), "{}", stderr(&output));
}
