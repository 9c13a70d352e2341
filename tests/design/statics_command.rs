//! `phalanx statics` for a finger: output, plot and rejected input.

use crate::support::cli::{EXPERIMENT_95, assert_contains, assert_rejected, directory, succeed, succeed_json, write};
use crate::support::statics::{assert_units, number};
use serde_json::{Value, json};

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    assert!((number(value) - expected).abs() <= tolerance, "{value} is not {expected} ± {tolerance}");
}

#[test]
fn json_of_experiment_95() {
    let report = succeed_json(&["statics", EXPERIMENT_95]);
    assert_eq!(report["scene"], "experiment-95");
    // 1-model §1.8: q11 and q21 at 20 ms; they include a penetration of 3 µm.
    assert_near(&report["final"]["q11_rad"], 2.0888f64.to_radians(), 2e-4);
    assert_near(&report["final"]["q21_rad"], 65.0200f64.to_radians(), 5e-4);
    assert_near(&report["drive"]["motor_n_m"], 0.48, 0.0);
    assert_near(&report["drive"]["spring"]["torque_n_m"], 0.1326, 1e-15);
    let forces = report["forces"].as_array().unwrap();
    assert_eq!((forces.len(), &forces[1]["mu_static"]), (2, &json!([0.8, 0.8])));
    assert_near(&forces[0]["f21_n"], 23.6, 0.1);
    assert_near(&forces[0]["f22_n"], 8.26, 0.1);
    assert_eq!((&forces[0]["palm_force_positive"], &forces[1]["palm_force_positive"]), (&json!(false), &json!(true)));
    assert_eq!(forces[1]["ejection"], "none");
    let closure = &report["form_closure"];
    assert_eq!((&closure["closed"], &closure["rank"], &closure["unknowns"]), (&json!(true), &json!(6), &json!(6)));
    assert_eq!(closure["multipliers"].as_array().unwrap().len(), 7);
    assert!(closure.get("motion").is_none() && number(&closure["residual"]) < 1e-12);
    assert!(report.get("svg").is_none());
}

#[test]
fn every_number_has_its_unit() {
    assert_units(&succeed_json(&["statics", EXPERIMENT_95]));
    assert_units(&succeed_json(&["statics", &open_grasp(&directory("statics-units"))]));
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
    let scene = open_grasp(&directory);
    let draw = |scene: &str, name: &str| {
        let picture = directory.join(name);
        let text = succeed(&["statics", scene, "--svg", picture.to_str().unwrap()]);
        (text, std::fs::read_to_string(picture).unwrap())
    };
    let (text, svg) = draw(&scene, "grasp.svg");
    assert_contains(
        &text,
        &[
            "not closed",
            "The object moves straight away from the palm at 1.00 mm/s.",
            "Both fingers: the proximal phalanx closes at",
            "Contact is lost at: palm; maintained at: right proximal phalanx, right tip, left proximal phalanx, left tip.",
            "μ_s 0: the distal phalanx would have to pull",
            "the distal phalanx pushes the object at motor torques above",
        ],
    );
    assert_contains(
        &svg,
        &[
            "open: the grasp at rest",
            "distal phalanx: would have to pull",
            "palm: would have to pull",
            "a free motion",
            "forces on the object",
            "@media(prefers-color-scheme:dark){svg:root{",
            "--panel:#1b1f26",
            "[fill=\"#FFFFFF\"]{fill:var(--panel,#FFFFFF)}",
            "[stroke=\"#0072B2\"]{stroke:var(--s0,#0072B2)}",
        ],
    );
    // The legend identifies the forces; each has its own colour, for light and dark backgrounds.
    let legend_colour = |label: &str| {
        let head = svg.split(label).next().expect("text before the label");
        let line = head.rsplit("<path").next().expect("the line next to the label");
        line.split("stroke=\"").nth(1).and_then(|rest| rest.get(..7)).expect("a colour").to_string()
    };
    let colours = ["F21, by the proximal phalanx", "F22, by the distal phalanx"].map(legend_colour);
    assert_eq!(colours, ["#0072B2", "#C75300"]);
    assert_eq!(draw(&scene, "again.svg").1, svg);
    let closed = draw(EXPERIMENT_95, "again.svg").1;
    assert!(closed.contains("form-closed") && !closed.contains("a free motion"));

    let motion = &succeed_json(&["statics", &scene])["form_closure"]["motion"];
    assert_eq!(motion["object_m_s"], json!([0.0, 0.001]));
    assert_eq!(motion["rates"].as_array().unwrap().len(), 7);
    assert!(number(&motion["fingers"][0]["motor_rad_s"]) > 0.0);
}

#[test]
fn friction_and_motor_can_be_set() {
    let report = succeed_json(&["statics", EXPERIMENT_95, "--mu-static", "0,0.4", "--motor", "0.5165 N*m"]);
    assert_near(&report["drive"]["motor_n_m"], 0.5165, 0.0);
    let friction = report["forces"].as_array().unwrap().iter().map(|forces| number(&forces["mu_static"][0]));
    assert_eq!(friction.collect::<Vec<_>>(), [0.0, 0.4]);
    for (arguments, fragments) in [
        (&["--mu-static", "-0.5"], &[][..]),
        (&["--mu-static", "much"], &["expected one or more comma-separated numbers, each 0 or more"]),
        (&["--motor", "480"], &["has no unit"]),
        (&["--motor", "480 mm"], &["torque"]),
    ] {
        assert_rejected(&[&["statics", EXPERIMENT_95], &arguments[..]].concat(), fragments);
    }
}

#[test]
fn accepts_scenes_with_lengths_and_torsional_springs() {
    let report = succeed_json(&["statics", "scenes/long-fingers.toml"]);
    // Final forces stated in the comment of the scene: 13.7 N and 11.1 N.
    assert_near(&report["forces"][0]["f21_n"], 13.7, 0.1);
    assert_near(&report["forces"][0]["f22_n"], 11.1, 0.1);
    let report = succeed_json(&["statics", "scenes/torsional-spring.toml"]);
    assert_eq!(report["drive"]["spring"]["type"], "torsional");
    // The two scenes differ only in properties that do not affect form closure.
    assert_eq!(report["form_closure"], succeed_json(&["statics", EXPERIMENT_95])["form_closure"]);
}

#[test]
fn grasp_without_a_palm_contact_is_not_form_closed() {
    let directory = directory("statics-palm");
    let anchor = std::fs::read_to_string(EXPERIMENT_95).unwrap();
    let without_palm = write(&directory, "none.toml", &anchor.replacen("name =", "palm = false\nname =", 1));
    assert_contains(
        &succeed(&["statics", &without_palm]),
        &[
            "form closure of two fingers: not closed",
            "the scene has no palm",
            "4 contacts + 2 motors < 4 degrees of freedom of the fingers + 2 of the object + 1, not met",
        ],
    );
    let compact = anchor
        .replace("15.5 mm", "12 mm")
        .replace("120 deg", "100 deg")
        .replace("l21_fraction = 1.0", "l21_fraction = 0.0");
    for (height, palm, closed) in [("20.5 mm", "apart", false), ("19.9 mm", "within", true)] {
        let text = format!("{compact}\n[object]\ncentre = [\"-12 mm\", \"{height}\"]\n");
        let closure = &succeed_json(&["statics", &write(&directory, "raised.toml", &text)])["form_closure"];
        assert_eq!((&closure["palm"], &closure["closed"]), (&json!(palm), &json!(closed)), "{height}");
    }
    assert_eq!(succeed_json(&["statics", EXPERIMENT_95])["form_closure"]["palm"], "rests");
}

#[test]
fn rejects_scenes_without_a_grasp() {
    let directory = directory("statics-refused");
    let picture = directory.join("x.svg");
    let missing = directory.join("no/where.svg");
    for (scene, picture, fragment) in [
        ("scenes/free-swing.toml", &picture, "no object"),
        ("scenes/laws/spring.toml", &picture, "scene of discs"),
        ("scenes/hard/misses.toml", &picture, "make l21 longer"),
        ("scenes/nowhere.toml", &picture, "nowhere.toml"),
        (EXPERIMENT_95, &missing, "mkdir -p"),
    ] {
        assert_rejected(&["statics", scene, "--svg", picture.to_str().unwrap()], &["error: ", fragment]);
    }
    assert!(!picture.exists());
}
