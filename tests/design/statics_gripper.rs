//! `phalanx statics` for a gripper: output, plot and rejected input.

use serde_json::{Value, json};

use crate::support::cli::{assert_contains, assert_rejected, directory, succeed, succeed_json};
use crate::support::statics::{assert_units, number};

const GRIPPER: &str = "scenes/gripper/design-95.toml";
const CYCLE: &str = "scenes/gripper/cycle.toml";

fn statics(args: &[&str]) -> Value {
    succeed_json(&[&["statics"], args].concat())
}

fn count(list: &Value) -> usize {
    list.as_array().map_or(0, Vec::len)
}

fn contact_names(document: &Value) -> Vec<&str> {
    let contacts = document["contacts"].as_array().expect("contacts").iter();
    contacts.map(|contact| contact["place"].as_str().expect("a name")).collect()
}

/// Whether two limits agree; both may be infinite.
fn agree(a: f64, b: f64, relative: f64) -> bool {
    a == b || (a - b).abs() < relative * (1.0 + b.abs())
}

fn directions(document: &Value) -> &Vec<Value> {
    document["holds"][0]["accelerations"].as_array().expect("directions")
}

/// Maps a limit to a number: infinite if unlimited, negative if nothing is balanced.
fn limit(balance: &Value) -> f64 {
    match balance["balanced"].as_str().expect("a text") {
        "any" => f64::INFINITY,
        "nothing" => -1.0,
        _ => number(&balance["acceleration_m_s2"]),
    }
}

fn limits(document: &Value, drive_mode: &str) -> Vec<f64> {
    directions(document).iter().map(|direction| limit(&direction[drive_mode])).collect()
}

/// Returns the residual of the force and moment balance of the object for one direction: contact forces, weight and inertia.
fn balance_residual(document: &Value, direction: &Value, balance: &Value) -> [f64; 3] {
    let pair = |value: &Value| [number(&value[0]), number(&value[1])];
    let (mass, gravity) = (number(&document["posture"]["mass_kg"]), pair(&document["posture"]["gravity_m_s2"]));
    let (a, along) = (number(&balance["acceleration_m_s2"]), pair(&direction["direction"]));
    let centre = [number(&document["posture"]["x_m"]), number(&document["posture"]["y_m"])];
    let mut sum = [0, 1].map(|i| mass * (gravity[i] - a * along[i]));
    let mut moment = 0.0;
    for force in balance["forces"].as_array().expect("forces") {
        let Some(normal_n) = force["normal_n"].as_f64() else { continue };
        let contacts = document["contacts"].as_array().expect("contacts");
        let contact = contacts.iter().find(|contact| contact["place"] == force["place"]).expect("a contact");
        let ([nx, ny], point) = (pair(&contact["normal"]), pair(&contact["point_m"]));
        let mirror = if contact["place"].as_str().expect("a name").starts_with("left") { -1.0 } else { 1.0 };
        let friction = -mirror * number(&force["tangential_n"]);
        let on_object = [nx * normal_n + ny * friction, ny * normal_n - nx * friction];
        assert!(normal_n >= 0.0 && friction.abs() <= number(&contact["mu_static"]) * normal_n + 1e-9, "{force}");
        (0..2).for_each(|i| sum[i] += on_object[i]);
        moment += (point[0] - centre[0]) * on_object[1] - (point[1] - centre[1]) * on_object[0];
    }
    [sum[0], sum[1], moment / 0.02]
}

#[test]
fn default_posture_is_the_end_of_a_run() {
    let document = statics(&[GRIPPER]);
    let posture = &document["posture"];
    assert_eq!((&posture["source"], &posture["fate"]), (&json!("run"), &json!("held")));
    assert!((number(&posture["time_s"]) - 0.02).abs() < 1e-12);
    // 6-gripper §6.12, case a.
    assert!((number(&posture["right"]["q21_rad"]) - 1.145120659).abs() < 1e-5, "{posture}");
    assert!((number(&posture["y_m"]) - 20.29229617e-3).abs() < 1e-7, "{posture}");
    assert_eq!(contact_names(&document), ["right_proximal", "right_distal", "left_proximal", "left_distal"]);
    // Both fingers have equal normal and friction forces.
    let contacts = document["contacts"].as_array().expect("contacts");
    for (contact, [normal_n, tangential_n]) in contacts.iter().zip([[20.46, 4.490], [8.690, -0.1446]].repeat(2)) {
        assert!((number(&contact["normal_n"]) - normal_n).abs() < 5e-3 && number(&contact["gap_m"]) < 0.0, "{contact}");
        assert!((number(&contact["tangential_n"]) - tangential_n).abs() < 5e-3, "{contact}");
    }
    // The report of the run agrees.
    let run = succeed_json(&["run", GRIPPER]);
    for key in ["q1_l1", "q1_linf"] {
        let both = [&document["holds"][0], &run["grasp"]].map(|entry| number(&entry["force_closure"][key]));
        assert!((both[0] - both[1]).abs() < 1e-9, "{key}: {both:?}");
    }
    let closure = &document["form_closure"][0];
    assert_eq!((count(&document["form_closure"]), &closure["blocked"]), (1, &json!("outputs")));
    assert_eq!(closure["closure"]["closed"], run["grasp"]["form_closed"]);

    assert_eq!(directions(&document).len(), 24);
    let mut limited = 0;
    for direction in directions(&document) {
        for drive_mode in ["blocked", "at_torque"] {
            let balance = &direction[drive_mode];
            if balance["balanced"] != "up to" {
                continue;
            }
            limited += 1;
            let residual = balance_residual(&document, direction, balance);
            assert!(residual.iter().all(|component| component.abs() < 1e-8), "{residual:?} of {direction}");
            let limiting = ["slips", "leaves", "brakes_slip"].map(|key| count(&balance[key]));
            assert!(limiting.iter().sum::<usize>() > 0 && number(&balance["gap"]) < 1e-9, "{balance}");
        }
        assert!(limit(&direction["blocked"]) >= limit(&direction["at_torque"]) * (1.0 - 1e-9), "{direction}");
    }
    assert!(limited >= 24, "{limited}");
}

#[test]
fn mirrored_grippers_have_mirrored_limits() {
    let [right, left] =
        ["scenes/gripper/offset.toml", "scenes/gripper/offset-left.toml"].map(|scene| statics(&[scene]));
    for drive_mode in ["blocked", "at_torque"] {
        let (right, left) = (limits(&right, drive_mode), limits(&left, drive_mode));
        for index in 0..24 {
            // Both runs agree within the accuracy of a run.
            let (right, left) = (right[index], left[(36 - index) % 24]);
            assert!(agree(left, right, 1e-3), "{drive_mode} {index}: {right} {left}");
        }
    }
}

#[test]
fn postures_can_be_geometric_or_given() {
    let geometric = statics(&[GRIPPER, "--posture", "geometric"]);
    assert_eq!(count(&geometric["contacts"]), 5);
    assert!(geometric["posture"]["time_s"].is_null() && geometric["contacts"][0]["normal_n"].is_null());
    // The five contacts form-close the object with both driven links blocked.
    assert_eq!(geometric["form_closure"][0]["closure"]["closed"], true);
    let right = &geometric["posture"]["right"];
    let (q11, q21) = (number(&right["q11_rad"]), number(&right["q21_rad"]));
    let given = statics(&[GRIPPER, "--posture", &format!("q11={q11} rad, q21={q21} rad")]);
    assert_eq!(given["posture"]["source"], "given");
    assert_eq!(contact_names(&given), contact_names(&geometric));
    for drive_mode in ["blocked", "at_torque"] {
        let mut both = limits(&given, drive_mode).into_iter().zip(limits(&geometric, drive_mode));
        assert!(both.all(|(given, geometric)| agree(given, geometric, 1e-6)), "{drive_mode}");
    }
    // One finger is rotated away, which changes the contacts.
    let rotated = format!("q11={q11} rad, q21={q21} rad, q11_l={} rad, q21_l={} rad", q11 - 0.05, q21 - 0.05);
    assert_eq!(contact_names(&statics(&[GRIPPER, "--posture", &rotated])), ["right_proximal", "right_distal", "palm"]);
}

#[test]
fn limits_increase_with_friction_and_a_time_can_be_set() {
    // The motors are blocked and the object is not lifted yet.
    let document = statics(&[CYCLE, "--at", "18 ms", "--mu-static", "0.2,0.4,0.8", "--every", "30 deg"]);
    let time_s = |document: &Value| number(&document["posture"]["time_s"]);
    assert!((time_s(&document) - 0.018).abs() < 1e-12, "{}", document["posture"]);
    let motor = &document["motors"][0];
    assert_eq!((number(&motor["torque_n_m"]), number(&motor["brake_max_n_m"])), (0.48, 2.0));
    let holds = document["holds"].as_array().expect("holds");
    let blocked = |case: &Value| -> Vec<f64> {
        case["accelerations"].as_array().expect("directions").iter().map(|d| limit(&d["blocked"])).collect()
    };
    let all: Vec<Vec<f64>> = holds.iter().map(blocked).collect();
    assert_eq!((all.len(), all[0].len()), (3, 12));
    let increases = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).all(|(lower, upper)| *upper >= lower - 1e-9);
    assert!(all.windows(2).all(increases), "{all:?}");
    let q1: Vec<f64> = holds.iter().map(|holds| number(&holds["force_closure"]["q1_l1"])).collect();
    assert!(q1[0] < q1[1] && q1[1] < q1[2], "{q1:?}");
    // The fingers have released at the end; the default is the time before.
    let end = statics(&[CYCLE, "--every", "90 deg", "--motor", "300 N*mm"]);
    assert!((time_s(&end) - 0.35).abs() < 1e-9, "{}", end["posture"]);
    assert_eq!(number(&end["motors"][1]["torque_n_m"]), 0.3);
    // The transfer accelerates by at most 7.5 × 305 mm/(200 ms)², which friction holds; a larger acceleration can be balanced.
    let transfer = statics(&[CYCLE, "--at", "150 ms", "--every", "90 deg"]);
    assert!(limits(&transfer, "blocked")[0] > 7.5 * 0.305 / 0.04, "{:?}", limits(&transfer, "blocked"));
    // --within includes contacts that are close but not loaded.
    let near = statics(&[CYCLE, "--at", "150 ms", "--every", "90 deg", "--within", "0.05 mm"]);
    assert!(count(&near["contacts"]) == 5 && count(&transfer["contacts"]) < 5);
    let mut both = limits(&near, "blocked").into_iter().zip(limits(&transfer, "blocked"));
    assert!(both.all(|(near, loaded)| near >= loaded * (1.0 - 1e-9)));
}

#[test]
fn differential_reports_form_closure_with_blocked_outputs_and_input() {
    let document = statics(&["scenes/gripper/seesaw.toml", "--every", "45 deg"]);
    for (index, blocked, motors) in [(0, "outputs", 2), (1, "input", 1)] {
        let closure = &document["form_closure"][index];
        assert_eq!(closure["blocked"], blocked);
        assert_eq!(closure["closure"]["necessary"]["motors"], motors);
    }
    assert_eq!(document["form_closure"][1]["closure"]["closed"], false);
    assert_eq!((count(&document["motors"]), &document["motors"][0]["motor"]), (1, &json!("input")));
    assert!(document["motors"][0]["brake_max_n_m"].is_null());
}

#[test]
fn every_number_has_its_unit() {
    assert_units(&statics(&[GRIPPER, "--every", "90 deg"]));
}

#[test]
fn table_and_plot_show_the_limiting_contacts() {
    let directory = directory("statics-gripper");
    let draw = |name: &str| {
        let picture = directory.join(name);
        let text = succeed(&["statics", CYCLE, "--svg", picture.to_str().expect("text")]);
        (text, std::fs::read_to_string(picture).expect("a picture"))
    };
    let (text, svg) = draw("polar.svg");
    assert_contains(
        &text,
        &[
            "posture at 350 ms of the run; object held",
            "a brake that holds 2000 N·mm",
            "R21 right proximal",
            "form closure, both driven links blocked",
            "force closure with friction of the scene: closed",
            "largest acceleration of the palm that contact forces can balance",
            "270°",
            "slip ",
            "picture: ",
        ],
    );
    let labels = ["motors blocked", "motors at their torque", "down, out of the palm", ">palm</text>", " g</text>"];
    assert_contains(&svg, &[&labels[..], &["prefers-color-scheme:dark"]].concat());
    assert_eq!(draw("again.svg").1, svg, "the plot is reproducible");
}

#[test]
fn rejects_invalid_options() {
    for (args, message) in [
        (&[GRIPPER, "--at", "21 ms"][..], "ends at 20.000000 ms"),
        (
            &[GRIPPER, "--at", "1 ms"],
            "the object of \"gripper-design-95\" has no contacts at 1.000000 ms of its run, where its fate is \"not grasped\"",
        ),
        (&[GRIPPER, "--at", "1 ms", "--posture", "geometric"], "remove one of them"),
        (&[GRIPPER, "--posture", "geometric", "--within", "1 mm"], "remove --within"),
        (&[GRIPPER, "--posture", "q11=2 deg"], "q21_r is missing"),
        (&[GRIPPER, "--posture", "q11=2 deg, q21=75 deg"], "penetrates the object by"),
        (&[GRIPPER, "--posture", "q11=-40 deg, q21=50 deg, y=25 mm"], "has no contacts in this posture"),
        (&[GRIPPER, "--posture", "q11=170 deg, q21=5 deg"], "the loop cannot close"),
        (&[GRIPPER, "--every", "7 deg"], "divide a full turn"),
        (&["scenes/gripper/fixed.toml"], "is fixed, so it needs no grasp"),
        (&["scenes/experiment-95.toml", "--at", "1 ms"], "--at needs a gripper"),
        (&["scenes/laws/radii.toml"], "the grasp of a finger or a gripper"),
    ] {
        assert_rejected(&[&["statics"], args].concat(), &[message]);
    }
}
