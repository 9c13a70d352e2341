//! `phalanx statics` for a gripper: output, plot and rejected input.

use serde_json::Value;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};

const GRIPPER: &str = "scenes/gripper/design-95.toml";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn statics(args: &[&str]) -> Value {
    let arguments: Vec<&str> = [&["statics"], args, &["--json"]].concat();
    let output = phalanx(&arguments);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    json(&output)
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
    assert_eq!((posture["source"].as_str(), posture["fate"].as_str()), (Some("run"), Some("held")));
    assert!((number(&posture["time_s"]) - 0.02).abs() < 1e-12);
    // 6-gripper §6.12, case a.
    assert!((number(&posture["right"]["q21_rad"]) - 1.145120659).abs() < 1e-5, "{posture}");
    assert!((number(&posture["y_m"]) - 20.29229617e-3).abs() < 1e-7, "{posture}");
    let contacts = document["contacts"].as_array().expect("contacts");
    let names: Vec<&str> = contacts.iter().filter_map(|contact| contact["place"].as_str()).collect();
    assert_eq!(names, ["right_proximal", "right_distal", "left_proximal", "left_distal"]);
    // Both fingers have equal normal and friction forces.
    for (contact, [normal_n, tangential_n]) in contacts.iter().zip([[20.46, 4.490], [8.690, -0.1446]].repeat(2)) {
        assert!((number(&contact["normal_n"]) - normal_n).abs() < 5e-3 && number(&contact["gap_m"]) < 0.0, "{contact}");
        assert!((number(&contact["tangential_n"]) - tangential_n).abs() < 5e-3, "{contact}");
    }
    // The report of the run agrees.
    let run = json(&phalanx(&["run", GRIPPER, "--json"]));
    let [single_command, in_run] = [&document["holds"][0], &run["grasp"]].map(|entry| entry["force_closure"].clone());
    for key in ["q1_l1", "q1_linf"] {
        assert!((number(&single_command[key]) - number(&in_run[key])).abs() < 1e-9, "{single_command} {in_run}");
    }
    let closure = &document["form_closure"][0];
    assert_eq!(
        (closure["blocked"].as_str(), &closure["closure"]["closed"]),
        (Some("outputs"), &run["grasp"]["form_closed"])
    );
    assert_eq!(document["form_closure"].as_array().map(Vec::len), Some(1));

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
            let limiting = ["slips", "leaves", "brakes_slip"].map(|key| balance[key].as_array().map_or(0, Vec::len));
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
            let (right_limit, left_limit) = (right[index], left[(36 - index) % 24]);
            // Both runs agree within the accuracy of a run.
            assert!(
                right_limit == left_limit || (right_limit - left_limit).abs() < 1e-3 * (1.0 + right_limit.abs()),
                "{drive_mode} {index}: {right_limit} {left_limit}"
            );
        }
    }
}

#[test]
fn postures_can_be_geometric_or_given() {
    let geometric = statics(&[GRIPPER, "--posture", "geometric"]);
    assert_eq!(geometric["contacts"].as_array().map(Vec::len), Some(5));
    assert!(geometric["posture"]["time_s"].is_null() && geometric["contacts"][0]["normal_n"].is_null());
    // The five contacts form-close the object with both driven links blocked.
    assert_eq!(geometric["form_closure"][0]["closure"]["closed"], Value::Bool(true));
    let right = &geometric["posture"]["right"];
    let (q11, q21) = (number(&right["q11_rad"]), number(&right["q21_rad"]));
    let given_posture = statics(&[GRIPPER, "--posture", &format!("q11={q11} rad, q21={q21} rad")]);
    assert_eq!(given_posture["posture"]["source"], "given");
    let contact_names = |document: &Value| -> Vec<String> {
        let contacts = document["contacts"].as_array().expect("contacts").iter();
        contacts.map(|contact| contact["place"].as_str().expect("a name").to_string()).collect()
    };
    assert_eq!(contact_names(&given_posture), contact_names(&geometric));
    for drive_mode in ["blocked", "at_torque"] {
        for (given_posture, geometric) in
            limits(&given_posture, drive_mode).into_iter().zip(limits(&geometric, drive_mode))
        {
            assert!(
                given_posture == geometric || (given_posture - geometric).abs() < 1e-6 * (1.0 + geometric.abs()),
                "{drive_mode}"
            );
        }
    }
    // One finger is rotated away, which changes the contacts.
    let rotated = format!("q11={q11} rad, q21={q21} rad, q11_l={} rad, q21_l={} rad", q11 - 0.05, q21 - 0.05);
    assert_eq!(contact_names(&statics(&[GRIPPER, "--posture", &rotated])), ["right_proximal", "right_distal", "palm"]);
}

#[test]
fn limits_increase_with_friction_and_a_time_can_be_set() {
    const CYCLE: &str = "scenes/gripper/cycle.toml";
    // The motors are blocked and the object is not lifted yet.
    let document = statics(&[CYCLE, "--at", "18 ms", "--mu-static", "0.2,0.4,0.8", "--every", "30 deg"]);
    assert!((number(&document["posture"]["time_s"]) - 0.018).abs() < 1e-12, "{}", document["posture"]);
    assert_eq!(
        (number(&document["motors"][0]["torque_n_m"]), number(&document["motors"][0]["brake_max_n_m"])),
        (0.48, 2.0)
    );
    let holds = document["holds"].as_array().expect("holds");
    let all: Vec<Vec<f64>> = holds
        .iter()
        .map(|holds| {
            holds["accelerations"].as_array().expect("directions").iter().map(|d| limit(&d["blocked"])).collect()
        })
        .collect();
    assert_eq!((all.len(), all[0].len()), (3, 12));
    assert!(
        all.windows(2).all(|pair| pair[0].iter().zip(&pair[1]).all(|(lower, upper)| *upper >= lower - 1e-9)),
        "{all:?}"
    );
    let q1: Vec<f64> = holds.iter().map(|holds| number(&holds["force_closure"]["q1_l1"])).collect();
    assert!(q1[0] < q1[1] && q1[1] < q1[2], "{q1:?}");
    // The fingers have released at the end; the default is the time before.
    let end = statics(&[CYCLE, "--every", "90 deg", "--motor", "300 N*mm"]);
    assert!((number(&end["posture"]["time_s"]) - 0.35).abs() < 1e-9, "{}", end["posture"]);
    assert_eq!(number(&end["motors"][1]["torque_n_m"]), 0.3);
    // The transfer accelerates by at most 7.5 × 305 mm/(200 ms)², which friction holds; a larger acceleration can be balanced.
    let transfer = statics(&[CYCLE, "--at", "150 ms", "--every", "90 deg"]);
    assert!(limits(&transfer, "blocked")[0] > 7.5 * 0.305 / 0.04, "{:?}", limits(&transfer, "blocked"));
    // --within includes contacts that are close but not loaded.
    let near = statics(&[CYCLE, "--at", "150 ms", "--every", "90 deg", "--within", "0.05 mm"]);
    let count = |document: &Value| document["contacts"].as_array().map_or(0, Vec::len);
    assert!(count(&near) == 5 && count(&transfer) < 5, "{} {}", count(&near), count(&transfer));
    let both = limits(&near, "blocked").into_iter().zip(limits(&transfer, "blocked"));
    assert!(both.into_iter().all(|(near, loaded)| near >= loaded * (1.0 - 1e-9)));
}

#[test]
fn differential_reports_form_closure_with_blocked_outputs_and_input() {
    let document = statics(&["scenes/gripper/seesaw.toml", "--every", "45 deg"]);
    let [outputs, input] = [0, 1].map(|index| &document["form_closure"][index]);
    assert_eq!((outputs["blocked"].as_str(), input["blocked"].as_str()), (Some("outputs"), Some("input")));
    assert_eq!(
        (&input["closure"]["closed"], &input["closure"]["necessary"]["motors"]),
        (&Value::Bool(false), &1.into())
    );
    assert_eq!(outputs["closure"]["necessary"]["motors"], 2);
    assert_eq!(
        (document["motors"].as_array().map(Vec::len), document["motors"][0]["motor"].as_str()),
        (Some(1), Some("input"))
    );
    assert!(document["motors"][0]["brake_max_n_m"].is_null());
}

#[test]
fn every_number_has_its_unit() {
    const DIMENSIONLESS: [&str; 17] = [
        "mu_static",
        "normal",
        "direction",
        "contacts",
        "motors",
        "hand",
        "object",
        "rank",
        "unknowns",
        "margin",
        "residual",
        "gap",
        "q1_l1",
        "q1_linf",
        "weakest",
        "met",
        "closed",
    ];
    const UNITS: [&str; 8] = ["_m", "_n", "_n_m", "_rad", "_m_s", "_rad_s", "_m_s2", "_kg"];
    fn check(key: &str, value: &Value) {
        match value {
            Value::Number(_) => assert!(
                DIMENSIONLESS.contains(&key) || key == "time_s" || UNITS.iter().any(|unit| key.ends_with(unit)),
                "the number under \"{key}\" has no unit"
            ),
            Value::Array(values) => values.iter().for_each(|value| check(key, value)),
            Value::Object(fields) => fields.iter().for_each(|(key, value)| check(key, value)),
            _ => {}
        }
    }
    check("", &statics(&[GRIPPER, "--every", "90 deg"]));
}

#[test]
fn table_and_plot_show_the_limiting_contacts() {
    let directory = directory("statics-gripper");
    let picture = directory.join("polar.svg");
    let output = phalanx(&["statics", "scenes/gripper/cycle.toml", "--svg", picture.to_str().expect("text")]);
    let text = stdout(&output);
    for fragment in [
        "posture at 350 ms of the run; object held",
        "a brake that holds 2000 N·mm",
        "R21 right proximal",
        "form closure, both driven links blocked",
        "force closure with friction of the scene: closed",
        "largest acceleration of the palm that contact forces can balance",
        "270°",
        "slip ",
        "picture: ",
    ] {
        assert!(text.contains(fragment), "no \"{fragment}\" in\n{text}");
    }
    let svg = std::fs::read_to_string(&picture).expect("a picture");
    for fragment in [
        "motors blocked",
        "motors at their torque",
        "down, out of the palm",
        ">palm</text>",
        " g</text>",
        "prefers-color-scheme:dark",
    ] {
        assert!(svg.contains(fragment), "no \"{fragment}\" in the picture");
    }
    let repeated = directory.join("again.svg");
    phalanx(&["statics", "scenes/gripper/cycle.toml", "--svg", repeated.to_str().expect("text")]);
    assert_eq!(std::fs::read_to_string(&repeated).expect("a picture"), svg, "the plot is reproducible");
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
        let output = phalanx(&[&["statics"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        let text = stderr(&output).replace('\n', " ");
        assert!(text.contains(message), "{args:?}: {text}");
    }
}
