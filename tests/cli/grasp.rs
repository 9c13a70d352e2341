//! `phalanx run` and `replay` of a hand with an object: the answer comes first.

use crate::support::cli::{assert_contains, directory, path_in, succeed, succeed_json, write};
use serde_json::Value;

const PINCH: &str = "scenes/real/2f85-pinch.toml";
const LIFT: &str = "scenes/real/2f85-lift.toml";

#[test]
fn a_run_begins_with_the_answer_and_fits_on_a_screen() {
    for scene in [PINCH, LIFT] {
        let text = succeed(&["run", scene]);
        let first = text.lines().next().expect("a line");
        assert!(first.starts_with("held since "), "{first}");
        assert_contains(&text, &["friction used", "balances", "--points", "pad/object.skin"]);
        let count = text.lines().count();
        assert!(count <= 40, "{count} lines:\n{text}");
        // Points are listed on request only.
        assert!(!text.contains("skin[0]") && succeed(&["run", scene, "--points"]).contains("skin[0]"));
        let all = succeed(&["run", scene, "--all"]);
        assert!(all.contains("left_spring_link") && !text.contains("left_spring_link"), "{all}");
    }
}

#[test]
fn the_document_of_a_grasp_has_all_figures() {
    let run = succeed_json(&["run", LIFT, "--no-check"]);
    let grasp = &run["grasp"];
    for (key, expected) in [("fate", "held"), ("object", "object")] {
        assert_eq!(grasp[key], expected);
    }
    for key in ["grasped_s", "held_since_s", "tts_s", "grip_n", "friction_used", "q1"] {
        assert!(grasp[key].as_f64().is_some_and(|value| value >= 0.0), "{key}: {}", grasp[key]);
    }
    assert!(grasp["slip"]["displacement_m"].is_f64() && grasp["slip"]["rotation_rad"].is_f64());
    assert!(grasp["margin"]["driven"]["acceleration_m_s2"].as_f64().is_some_and(|margin| margin > 0.0), "{grasp}");
    let pairs = grasp["pairs"].as_object().expect("pairs");
    let pads = pairs.iter().filter(|(_, pair)| pair["role"] == "hand" && pair["normal_n"].as_f64() > Some(1.0));
    assert_eq!(pads.count(), 2, "{pairs:?}");
    assert!(grasp["actuators"].as_object().is_some_and(|all| !all.is_empty()));
    let states = grasp["states"].as_array().expect("states");
    assert_eq!(states.last().map(|state| &state[1]), Some(&Value::from("gripped")));
}

#[test]
fn a_log_has_the_same_answer() {
    let directory = directory("grasp-log");
    let log = path_in(&directory, "run.mcap");
    let run = succeed_json(&["run", PINCH, "--no-check", "--log", &log]);
    let replay = succeed_json(&["replay", &log]);
    assert_eq!(run["grasp"], replay["grasp"]);
    let text = succeed(&["replay", &log]);
    assert_eq!(text.lines().next(), run["grasp"]["answer"].as_str());
}

/// Scene of an anchor.
fn anchor(index: usize) -> String {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: Value = serde_json::from_str(&text).expect("valid JSON");
    anchors["cases"][index]["scene"].as_str().expect("a scene").to_string()
}

#[test]
fn pairs_that_never_touched_are_named_in_one_line() {
    let directory = directory("grasp-carried");
    let path = write(&directory, "carried.toml", &anchor(6));
    let text = succeed(&["run", &path, "--no-check"]);
    assert!(text.starts_with("carried since "), "{text}");
    assert_contains(&text, &["1 face presses with ", "never touched: left.pad/object.skin, right.pad/object.skin"]);
}

#[test]
fn an_object_that_leaves_after_its_release_ends_the_run() {
    let directory = directory("grasp-released");
    let scene = format!("{}\n[grasp]\nrelease = \"50 ms\"\n", anchor(2));
    let (path, log) = (write(&directory, "released.toml", &scene), path_in(&directory, "run.mcap"));
    let run = succeed_json(&["run", &path, "--no-check", "--log", &log]);
    // The fate is that at the release; the brake opens 10 ms later, and the object falls.
    let grasp = &run["grasp"];
    assert_eq!((&grasp["fate"], &grasp["escaped_s"]), (&Value::from("held"), &Value::Null));
    let left_s = grasp["left_s"].as_f64().expect("a time");
    assert!((left_s - 0.1619129580902287).abs() < 1e-6, "{left_s}");
    let text = succeed(&["run", &path, "--no-check"]);
    assert_contains(
        &text,
        &["object: object, base: ground", "the object left the hand at 161.9", "which ends the run"],
    );
    let text = succeed(&["replay", &log]);
    assert_contains(&text, &["held since ", "the object left the hand at 161.9"]);
    assert_eq!(succeed_json(&["replay", &log])["grasp"], run["grasp"]);
}

#[test]
fn a_hand_without_contacts_has_a_reason() {
    let directory = directory("grasp-nothing");
    let scene = anchor(0);
    let (scene, _) = scene.split_once("[[contacts]]").expect("contacts");
    let path = write(&directory, "without.toml", scene);
    assert!(!succeed(&["run", &path, "--no-check"]).contains("no grasp"));
    let path = write(&directory, "section.toml", &format!("{scene}[grasp]\n"));
    let text = succeed(&["run", &path, "--no-check"]);
    assert_contains(&text, &["no grasp: there is no contact pair of a hand", "in [[contacts]]"]);
}

#[test]
fn several_objects_are_named_instead_of_a_fate() {
    let directory = directory("grasp-objects");
    let scene = anchor(0);
    let other = "[bodies.ball]\nmass = \"10 g\"\ninertia = \"100 g*mm^2\"\nstart = { at = [\"0 mm\", \"90 mm\"] }\n\
                 [bodies.ball.outlines.skin]\ntype = \"disc\"\nradius = \"5 mm\"\n\
                 [[contacts]]\nbetween = [\"ball\", \"cube\"]\nlaw = \"pad\"\n";
    let scene = format!("{}{other}", scene.replace("object", "cube"));
    let path = write(&directory, "two.toml", &scene);
    let text = succeed(&["run", &path, "--no-check"]);
    assert_contains(&text, &["no grasp: `ball` and `cube` have contacts and no joints", "`object` in [grasp]"]);
    let path = write(&directory, "named.toml", &format!("{scene}[grasp]\nobject = \"cube\"\n"));
    assert!(succeed(&["run", &path, "--no-check"]).starts_with("held since 2.8"));
}
