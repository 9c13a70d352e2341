//! Grasps of tests/anchors/grasp.json, in both models: fates, times and figures, judged by an independent program from samples
//! of the analytic model, and in closed form.

use phalanx::criteria::{Margin, ObjectCriteria, ObjectTracker, firmness};
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{Model, RunError, run};
use serde_json::Value;

fn anchors() -> Value {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    serde_json::from_str(&text).expect("valid JSON")
}

/// Scene of a case. An object that escapes ends its run, which needs a section `[grasp]`.
fn scene_of(case: &Value) -> Scene {
    let text = case["scene"].as_str().expect("a scene");
    let ends = !case["expect"]["escaped_s"].is_null();
    parse_any(&format!("{text}{}", if ends { "\n[grasp]\n" } else { "" }), "anchor.toml")
        .unwrap_or_else(|error| panic!("{error}"))
}

fn criteria(scene: &Scene, model: Model) -> (ObjectCriteria, f64) {
    let mut tracker = ObjectTracker::for_scene(scene).expect("a grasp");
    let outcome = match run(model, scene, &mut tracker) {
        Ok(outcome) => outcome,
        Err(RunError::Simulation { failure, .. }) => panic!("{model:?}: {failure}"),
        Err(error) => panic!("{model:?}: {error}"),
    };
    (tracker.criteria().expect("a run"), outcome.last.time_s)
}

/// Compares a figure of an anchor, which is null, a word, or a value with a tolerance; returns a message if it differs.
fn compare(name: &str, found: Option<f64>, expected: &Value) -> Option<String> {
    match (found, expected["value"].as_f64()) {
        (None, None) => None,
        (Some(found), Some(value)) => {
            let tolerance = expected["tol"].as_f64().expect("a tolerance");
            ((found - value).abs() > tolerance).then(|| format!("{name}: {found:e}, not {value:e} ± {tolerance:e}"))
        }
        (found, _) => Some(format!("{name}: {found:?}, not {expected}")),
    }
}

fn compare_margin(name: &str, found: &Margin, expected: &Value) -> Option<String> {
    match (found, expected["value"].as_f64()) {
        (Margin::Any, None) if expected["value"] == "any" => None,
        (Margin::Limited { acceleration_m_s2, directions_rad, .. }, Some(value)) => {
            let tolerance = expected["rel_tol"].as_f64().expect("a tolerance");
            let directions: Vec<f64> = directions_rad.iter().map(|angle| angle.to_degrees().round()).collect();
            let worst: Vec<f64> =
                expected["directions_deg"].as_array().expect("a list").iter().filter_map(Value::as_f64).collect();
            // Directions of equal limits in a symmetric grasp differ by rounding.
            let is_same = !directions.is_empty() && directions.iter().all(|direction| worst.contains(direction));
            let is_close = (acceleration_m_s2 - value).abs() <= tolerance * value;
            (!is_close || !is_same).then(|| format!("{name}: {acceleration_m_s2} at {directions:?}, not {expected}"))
        }
        _ => Some(format!("{name}: {found:?}, not {expected}")),
    }
}

/// Returns everything in which a run differs from its anchor.
fn differences(case: &Value, model: Model) -> Vec<String> {
    let expected = &case["expect"];
    let scene = scene_of(case);
    let (found, end_s) = criteria(&scene, model);
    let mut all = Vec::new();
    let mut words = |name: &str, found: &str, expected: &Value| {
        if Some(found) != expected.as_str() {
            all.push(format!("{name}: {found}, not {expected}"));
        }
    };
    words("fate", found.fate.name(), &expected["fate"]);
    words("state at the end", found.end_state().name(), &expected["state_end"]);
    words("object", &found.object, &expected["object"]);
    words("base", &found.base, &expected["base"]);
    all.extend(
        [
            compare("grasped_s", found.grasped_s, &expected["grasped_s"]),
            compare("held_since_s", found.held_since_s, &expected["held_since_s"]),
            compare("tts_s", found.tts_s, &expected["tts_s"]),
            compare("until_s", found.until_s, &expected["until_s"]),
            compare("escaped_s", found.escaped_s, &expected["escaped_s"]),
            compare("end_s", Some(end_s), &expected["end_s"]),
            compare("slip_m", found.slip.map(|slip| slip.displacement_m), &expected["slip_m"]),
            compare("slip_rad", found.slip.map(|slip| slip.rotation_rad), &expected["slip_rad"]),
            compare("creep_m_s", found.creep_m_s, &expected["creep_m_s"]),
        ]
        .into_iter()
        .flatten(),
    );
    let lost = u64::from(found.contacts_lost());
    if Some(lost) != expected["contacts_lost"].as_u64() {
        all.push(format!("contacts lost: {lost}, not {}", expected["contacts_lost"]));
    }
    all.extend(different_pairs(&found, expected));
    let firmness = firmness(&scene, &found);
    match (&firmness, expected["q1"]["value"].as_f64()) {
        (None, None) => {}
        (Some(firmness), Some(_)) => {
            all.extend(compare_margin("margin_driven", &firmness.driven, &expected["margin_driven"]));
            all.extend(compare_margin("margin_blocked", &firmness.blocked, &expected["margin_blocked"]));
            all.extend(compare("q1", Some(firmness.force_closure.q1_l1), &expected["q1"]));
            if firmness.form_closed != expected["form_closed"].as_bool() {
                all.push(format!("form_closed: {:?}", firmness.form_closed));
            }
        }
        _ => all.push(format!("firmness: {firmness:?}")),
    }
    all
}

fn different_pairs(found: &ObjectCriteria, expected: &Value) -> Vec<String> {
    let mut all = Vec::new();
    let untouched = expected["never_touched"].as_array().expect("a list");
    let expected = expected["pairs"].as_object().expect("pairs");
    for pair in &found.pairs {
        let name = pair.name.as_str();
        let Some(anchor) = expected.get(name) else {
            if pair.first_s.is_some() || !untouched.contains(&Value::from(name)) {
                all.push(format!("{name}: touched"));
            }
            continue;
        };
        let figure = |key: &str, found: Option<f64>, tolerance: f64| {
            let close = match (found, anchor[key].as_f64()) {
                (Some(found), Some(value)) => (found - value).abs() <= tolerance,
                (None, None) => true,
                _ => false,
            };
            (!close).then(|| format!("{name} {key}: {found:?}, not {}", anchor[key]))
        };
        all.extend(figure("first_s", pair.first_s, 2e-6));
        let role = if pair.is_hand { "hand" } else { "surroundings" };
        if anchor["role"] != role || anchor["active"] != pair.active_since_s.is_some() {
            all.push(format!("{name}: {role}, active since {:?}, not {anchor}", pair.active_since_s));
        }
        if anchor["lost"] != pair.times_lost {
            all.push(format!("{name}: lost {} times, not {}", pair.times_lost, anchor["lost"]));
        }
        if let Some(normal_n) = anchor["normal_n"].as_f64() {
            let friction_n = anchor["friction_n"].as_f64().expect("a friction");
            all.extend(figure("normal_n", Some(pair.normal_n), 1e-3 * normal_n));
            all.extend(figure("friction_n", Some(pair.friction_n), (0.01 * friction_n.abs()).max(5e-3)));
            all.extend(figure("use_sum", pair.friction_used, 0.01));
            let centre_m = pair.pressure_centre_m.unwrap_or([f64::NAN; 2]);
            for axis in 0..2 {
                let value = anchor["cop_object_m"][axis].as_f64().expect("a centre of pressure");
                if (centre_m[axis] - value).abs() > 2e-5 || centre_m[axis].is_nan() {
                    all.push(format!("{name} centre of pressure: {centre_m:?}, not {}", anchor["cop_object_m"]));
                }
            }
        }
    }
    all
}

fn check(model: Model) {
    let anchors = anchors();
    let cases = anchors["cases"].as_array().expect("a list");
    assert_eq!(cases.len(), 12);
    let mut all = Vec::new();
    for case in cases {
        let id = case["id"].as_str().expect("a name");
        all.extend(differences(case, model).into_iter().map(|difference| format!("{id}: {difference}")));
    }
    assert!(all.is_empty(), "{model:?}:\n{}", all.join("\n"));
}

#[test]
fn grasps_of_the_analytic_model_are_judged_like_the_anchors() {
    check(Model::Analytic);
}

#[test]
fn grasps_of_the_engine_are_judged_like_the_anchors() {
    check(Model::Engine);
}
