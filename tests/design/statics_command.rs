//! `phalanx statics`: what it prints, draws and refuses.

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[track_caller]
fn near(value: &Value, want: f64, tolerance: f64) {
    assert!((number(value) - want).abs() <= tolerance, "{value} is not {want} ± {tolerance}");
}

#[test]
fn the_anchor_as_json() {
    let output = phalanx(&["statics", ANCHOR, "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let found = json(&output);
    assert_eq!(found["scene"], "experiment-95");
    // 1-model §1.8: q11 and q21 at 20 ms, 3 µm of penetration beyond the geometry.
    near(&found["final"]["q11_rad"], 2.0888f64.to_radians(), 2e-4);
    near(&found["final"]["q21_rad"], 65.0200f64.to_radians(), 5e-4);
    near(&found["drive"]["motor_n_m"], 0.48, 0.0);
    near(&found["drive"]["spring"]["torque_n_m"], 0.1326, 1e-15);
    let forces = found["forces"].as_array().unwrap();
    assert_eq!(forces.len(), 2);
    assert_eq!(forces[1]["mu_static"], serde_json::json!([0.8, 0.8]));
    near(&forces[0]["f21_n"], 23.6, 0.1);
    near(&forces[0]["f22_n"], 8.26, 0.1);
    assert_eq!((&forces[0]["palm_force_positive"], &forces[1]["palm_force_positive"]), (&false.into(), &true.into()));
    assert_eq!(forces[1]["ejection"], "none");
    let closure = &found["form_closure"];
    assert_eq!((&closure["closed"], &closure["rank"], &closure["unknowns"]), (&true.into(), &6.into(), &6.into()));
    assert_eq!(closure["multipliers"].as_array().unwrap().len(), 7);
    assert!(closure.get("motion").is_none() && number(&closure["residual"]) < 1e-12);
    assert!(found.get("svg").is_none());
}

/// Names a number in JSON may have without a unit: it has none.
const BARE: [&str; 13] = [
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
            BARE.contains(&key) || UNITS.iter().any(|unit| key.ends_with(unit)),
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
    check_units("", &json(&phalanx(&["statics", ANCHOR, "--json"])));
    check_units("", &json(&phalanx(&["statics", &open(&directory), "--json"])));
}

/// A finger that stands near: its motor would squeeze the object out.
fn open(directory: &std::path::Path) -> String {
    write(
        directory,
        "open.toml",
        "[design]\nbase = \"12 mm\"\nl21_fraction = 0.5\nphi22 = \"90 deg\"\narm_ratio = 0.5\n[motor]\ntorque = \"60 \
         N*mm\"\n[spring]\ntorque = \"132.6 N*mm\"\n",
    )
}

#[test]
fn a_motion_that_is_free_is_said_in_words_and_drawn() {
    let directory = directory("statics-open");
    let (scene, picture) = (open(&directory), directory.join("grasp.svg"));
    let output = phalanx(&["statics", &scene, "--svg", picture.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for part in [
        "not closed",
        "The object moves straight away from the palm at 1.00 mm/s.",
        "Both fingers: the proximal phalanx closes at",
        "Contact is lost at: palm; kept at: right proximal phalanx, right tip, left proximal phalanx, left tip.",
        "μ_s 0: the distal phalanx would have to pull",
        "the distal phalanx pushes from a motor torque of",
    ] {
        assert!(text.contains(part), "no \"{part}\" in\n{text}");
    }
    let svg = std::fs::read_to_string(&picture).unwrap();
    for part in
        ["open: the grasp at rest", "distal phalanx: would have to pull", "palm: would have to pull", "a free motion"]
    {
        assert!(svg.contains(part), "no \"{part}\" in the picture");
    }
    // Two balanced grasps draw differently, the same one alike.
    // Whose force on whom, each in a colour of its own, on light and dark grounds.
    assert!(svg.contains("forces on the object"));
    let legend = |part: &str| {
        let before = svg.split(part).next().expect("what is before");
        let line = before.rsplit("<path").next().expect("the line beside it");
        line.split("stroke=\"").nth(1).and_then(|rest| rest.get(..7)).expect("a colour").to_string()
    };
    let colours = ["F21, by the proximal phalanx", "F22, by the distal phalanx"].map(legend);
    assert_eq!(colours, ["#0072B2", "#C75300"]);
    for rule in [
        "@media(prefers-color-scheme:dark){svg:root{",
        "--panel:#1b1f26",
        "[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}",
        "[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}",
    ] {
        assert!(svg.contains(rule), "{rule}");
    }
    let again = directory.join("again.svg");
    phalanx(&["statics", &scene, "--svg", again.to_str().unwrap()]);
    assert_eq!(svg, std::fs::read_to_string(&again).unwrap());
    phalanx(&["statics", ANCHOR, "--svg", again.to_str().unwrap()]);
    let closed = std::fs::read_to_string(&again).unwrap();
    assert!(closed.contains("form-closed") && !closed.contains("a free motion"));

    let found = json(&phalanx(&["statics", &scene, "--json"]));
    let motion = &found["form_closure"]["motion"];
    assert_eq!(motion["object_m_s"], serde_json::json!([0.0, 0.001]));
    assert_eq!(motion["rates"].as_array().unwrap().len(), 7);
    assert!(number(&motion["fingers"][0]["motor_rad_s"]) > 0.0);
}

#[test]
fn friction_and_motor_may_be_given() {
    let output = phalanx(&["statics", ANCHOR, "--mu-static", "0,0.4", "--motor", "0.5165 N*m", "--json"]);
    let found = json(&output);
    near(&found["drive"]["motor_n_m"], 0.5165, 0.0);
    let forces = found["forces"].as_array().unwrap();
    assert_eq!(forces.iter().map(|of| number(&of["mu_static"][0])).collect::<Vec<_>>(), [0.0, 0.4]);
    for (arguments, part) in [
        (["--mu-static", "-0.5"], "0, 0.4, 0.8"),
        (["--mu-static", "much"], "expected a number, 0 or more"),
        (["--motor", "480"], "has no unit"),
        (["--motor", "480 mm"], "torque"),
    ] {
        let arguments: Vec<&str> = ["statics", ANCHOR].into_iter().chain(arguments).collect();
        let output = phalanx(&arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(part) || part.starts_with('0'), "{}", stderr(&output));
    }
}

#[test]
fn lengths_and_springs_of_any_kind_will_do() {
    let found = json(&phalanx(&["statics", "scenes/long-fingers.toml", "--json"]));
    // The comment of that scene: 13.7 N and 11.1 N in the end.
    near(&found["forces"][0]["f21_n"], 13.7, 0.1);
    near(&found["forces"][0]["f22_n"], 11.1, 0.1);
    let found = json(&phalanx(&["statics", "scenes/torsional-spring.toml", "--json"]));
    assert_eq!(found["drive"]["spring"]["type"], "torsional");
    // Two scenes that differ in nothing that form closure knows of.
    assert_eq!(found["form_closure"], json(&phalanx(&["statics", ANCHOR, "--json"]))["form_closure"]);
}

#[test]
fn without_a_palm_under_the_object_no_grasp_is_closed() {
    let directory = directory("statics-palm");
    let anchor = std::fs::read_to_string(ANCHOR).unwrap();
    let none = write(&directory, "none.toml", &anchor.replacen("name =", "palm = false\nname =", 1));
    let text = stdout(&phalanx(&["statics", &none])).to_string();
    assert!(
        text.contains("form closure of two fingers: not closed") && text.contains("the scene has no palm"),
        "{text}"
    );
    assert!(
        text.contains("4 contacts + 2 motors < 4 freedoms of the fingers + 2 of the object + 1, not met"),
        "{text}"
    );

    let near = anchor
        .replace("15.5 mm", "12 mm")
        .replace("120 deg", "100 deg")
        .replace("l21_fraction = 1.0", "l21_fraction = 0.0");
    for (height, word, closed) in [("20.5 mm", "apart", false), ("19.9 mm", "within", true)] {
        let scene =
            write(&directory, "raised.toml", &format!("{near}\n[object]\ncentre = [\"-12 mm\", \"{height}\"]\n"));
        let output = phalanx(&["statics", &scene, "--json"]);
        let closure = &json(&output)["form_closure"];
        assert_eq!((&closure["palm"], &closure["closed"]), (&word.into(), &closed.into()), "{height}");
    }
    assert_eq!(json(&phalanx(&["statics", ANCHOR, "--json"]))["form_closure"]["palm"], "rests");
}

#[test]
fn what_has_no_grasp_is_refused() {
    let directory = directory("statics-refused");
    for (scene, part) in [
        ("scenes/free-swing.toml", "no object"),
        ("scenes/laws/spring.toml", "scene of discs"),
        ("scenes/hard/misses.toml", "make l21 longer"),
        ("scenes/nowhere.toml", "nowhere.toml"),
    ] {
        let output = phalanx(&["statics", scene, "--svg", directory.join("x.svg").to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2), "{scene}");
        assert!(stderr(&output).starts_with("error: ") && stderr(&output).contains(part), "{}", stderr(&output));
        assert!(stdout(&output).is_empty());
    }
    assert!(!directory.join("x.svg").exists());
    let output = phalanx(&["statics", ANCHOR, "--svg", directory.join("no/where.svg").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("mkdir -p"), "{}", stderr(&output));
}
