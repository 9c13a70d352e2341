//! `phalanx statics` of a gripper: what it prints, draws and refuses.

use serde_json::Value;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};

const GRIPPER: &str = "scenes/gripper/design-95.toml";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn found(args: &[&str]) -> Value {
    let all: Vec<&str> = [&["statics"], args, &["--json"]].concat();
    let output = phalanx(&all);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    json(&output)
}

fn directions(of: &Value) -> &Vec<Value> {
    of["holds"][0]["accelerations"].as_array().expect("directions")
}

/// Infinite where there is no limit, negative where nothing is balanced.
fn reach(of: &Value) -> f64 {
    match of["balanced"].as_str().expect("a word") {
        "any" => f64::INFINITY,
        "nothing" => -1.0,
        _ => number(&of["acceleration_m_s2"]),
    }
}

fn reaches(of: &Value, driven: &str) -> Vec<f64> {
    directions(of).iter().map(|direction| reach(&direction[driven])).collect()
}

/// Forces on the object of the contacts of a direction, with its weight and its inertia, and their moments about its centre.
fn left_over(of: &Value, direction: &Value, balance: &Value) -> [f64; 3] {
    let pair = |value: &Value| [number(&value[0]), number(&value[1])];
    let (mass, gravity) = (number(&of["posture"]["mass_kg"]), pair(&of["posture"]["gravity_m_s2"]));
    let (a, along) = (number(&balance["acceleration_m_s2"]), pair(&direction["direction"]));
    let centre = [number(&of["posture"]["x_m"]), number(&of["posture"]["y_m"])];
    let mut sum = [0, 1].map(|i| mass * (gravity[i] - a * along[i]));
    let mut moment = 0.0;
    for force in balance["forces"].as_array().expect("forces") {
        let Some(normal_n) = force["normal_n"].as_f64() else { continue };
        let contacts = of["contacts"].as_array().expect("contacts");
        let contact = contacts.iter().find(|contact| contact["place"] == force["place"]).expect("a contact");
        let ([nx, ny], point) = (pair(&contact["normal"]), pair(&contact["point_m"]));
        let mirror = if contact["place"].as_str().expect("a name").starts_with("left") { -1.0 } else { 1.0 };
        let friction = -mirror * number(&force["tangential_n"]);
        let on = [nx * normal_n + ny * friction, ny * normal_n - nx * friction];
        assert!(normal_n >= 0.0 && friction.abs() <= number(&contact["mu_static"]) * normal_n + 1e-9, "{force}");
        (0..2).for_each(|i| sum[i] += on[i]);
        moment += (point[0] - centre[0]) * on[1] - (point[1] - centre[1]) * on[0];
    }
    [sum[0], sum[1], moment / 0.02]
}

#[test]
fn the_end_of_a_run_is_looked_at() {
    let of = found(&[GRIPPER]);
    let posture = &of["posture"];
    assert_eq!((posture["source"].as_str(), posture["fate"].as_str()), (Some("run"), Some("held")));
    assert!((number(&posture["time_s"]) - 0.02).abs() < 1e-12);
    // 6-gripper §6.12, case a.
    assert!((number(&posture["right"]["q21_rad"]) - 1.145120659).abs() < 1e-5, "{posture}");
    assert!((number(&posture["y_m"]) - 20.29229617e-3).abs() < 1e-7, "{posture}");
    let contacts = of["contacts"].as_array().expect("contacts");
    let places: Vec<&str> = contacts.iter().filter_map(|contact| contact["place"].as_str()).collect();
    assert_eq!(places, ["right_proximal", "right_distal", "left_proximal", "left_distal"]);
    // Both fingers press alike, and their friction points along them alike.
    for (contact, [normal_n, tangential_n]) in contacts.iter().zip([[20.46, 4.490], [8.690, -0.1446]].repeat(2)) {
        assert!((number(&contact["normal_n"]) - normal_n).abs() < 5e-3 && number(&contact["gap_m"]) < 0.0, "{contact}");
        assert!((number(&contact["tangential_n"]) - tangential_n).abs() < 5e-3, "{contact}");
    }
    // What the run says of it too.
    let run = json(&phalanx(&["run", GRIPPER, "--json"]));
    let [here, there] = [&of["holds"][0], &run["grasp"]].map(|of| of["force_closure"].clone());
    for key in ["q1_l1", "q1_linf"] {
        assert!((number(&here[key]) - number(&there[key])).abs() < 1e-9, "{here} {there}");
    }
    let closure = &of["form_closure"][0];
    assert_eq!(
        (closure["blocked"].as_str(), &closure["closure"]["closed"]),
        (Some("outputs"), &run["grasp"]["form_closed"])
    );
    assert_eq!(of["form_closure"].as_array().map(Vec::len), Some(1));

    assert_eq!(directions(&of).len(), 24);
    let mut limited = 0;
    for direction in directions(&of) {
        for driven in ["blocked", "at_torque"] {
            let balance = &direction[driven];
            if balance["balanced"] != "up to" {
                continue;
            }
            limited += 1;
            let rest = left_over(&of, direction, balance);
            assert!(rest.iter().all(|part| part.abs() < 1e-8), "{rest:?} of {direction}");
            let gives = ["slips", "leaves", "brakes_slip"].map(|key| balance[key].as_array().map_or(0, Vec::len));
            assert!(gives.iter().sum::<usize>() > 0 && number(&balance["gap"]) < 1e-9, "{balance}");
        }
        assert!(reach(&direction["blocked"]) >= reach(&direction["at_torque"]) * (1.0 - 1e-9), "{direction}");
    }
    assert!(limited >= 24, "{limited}");
}

#[test]
fn a_gripper_seen_in_a_mirror_bears_the_same() {
    let [right, left] = ["scenes/gripper/offset.toml", "scenes/gripper/offset-left.toml"].map(|scene| found(&[scene]));
    for driven in ["blocked", "at_torque"] {
        let (right, left) = (reaches(&right, driven), reaches(&left, driven));
        for index in 0..24 {
            let (here, there) = (right[index], left[(36 - index) % 24]);
            // Both runs end alike to what a run is off by.
            assert!(
                here == there || (here - there).abs() < 1e-3 * (1.0 + here.abs()),
                "{driven} {index}: {here} {there}"
            );
        }
    }
}

#[test]
fn postures_are_taken_as_they_are_said() {
    let geometric = found(&[GRIPPER, "--posture", "geometric"]);
    assert_eq!(geometric["contacts"].as_array().map(Vec::len), Some(5));
    assert!(geometric["posture"]["time_s"].is_null() && geometric["contacts"][0]["normal_n"].is_null());
    // All five hold the object fast: with both links blocked no acceleration is too large.
    assert_eq!(geometric["form_closure"][0]["closure"]["closed"], Value::Bool(true));
    let right = &geometric["posture"]["right"];
    let (q11, q21) = (number(&right["q11_rad"]), number(&right["q21_rad"]));
    let given = found(&[GRIPPER, "--posture", &format!("q11={q11} rad, q21={q21} rad")]);
    assert_eq!(given["posture"]["source"], "given");
    let places = |of: &Value| -> Vec<String> {
        let contacts = of["contacts"].as_array().expect("contacts").iter();
        contacts.map(|contact| contact["place"].as_str().expect("a name").to_string()).collect()
    };
    assert_eq!(places(&given), places(&geometric));
    for driven in ["blocked", "at_torque"] {
        for (given, geometric) in reaches(&given, driven).into_iter().zip(reaches(&geometric, driven)) {
            assert!(given == geometric || (given - geometric).abs() < 1e-6 * (1.0 + geometric.abs()), "{driven}");
        }
    }
    // One finger turned away as a whole: other contacts.
    let away = format!("q11={q11} rad, q21={q21} rad, q11_l={} rad, q21_l={} rad", q11 - 0.05, q21 - 0.05);
    assert_eq!(places(&found(&[GRIPPER, "--posture", &away])), ["right_proximal", "right_distal", "palm"]);
}

#[test]
fn more_friction_bears_more_and_a_time_is_asked_for() {
    const CYCLE: &str = "scenes/gripper/cycle.toml";
    // Blocked, and not lifted yet.
    let of = found(&[CYCLE, "--at", "18 ms", "--mu-static", "0.2,0.4,0.8", "--every", "30 deg"]);
    assert!((number(&of["posture"]["time_s"]) - 0.018).abs() < 1e-12, "{}", of["posture"]);
    assert_eq!((number(&of["motors"][0]["torque_n_m"]), number(&of["motors"][0]["brake_max_n_m"])), (0.48, 2.0));
    let holds = of["holds"].as_array().expect("holds");
    let all: Vec<Vec<f64>> = holds
        .iter()
        .map(|holds| {
            holds["accelerations"].as_array().expect("directions").iter().map(|d| reach(&d["blocked"])).collect()
        })
        .collect();
    assert_eq!((all.len(), all[0].len()), (3, 12));
    assert!(
        all.windows(2).all(|pair| pair[0].iter().zip(&pair[1]).all(|(less, more)| *more >= less - 1e-9)),
        "{all:?}"
    );
    let q1: Vec<f64> = holds.iter().map(|holds| number(&holds["force_closure"]["q1_l1"])).collect();
    assert!(q1[0] < q1[1] && q1[1] < q1[2], "{q1:?}");
    // At the end they have let go: that is looked at before.
    let end = found(&[CYCLE, "--every", "90 deg", "--motor", "300 N*mm"]);
    assert!((number(&end["posture"]["time_s"]) - 0.35).abs() < 1e-9, "{}", end["posture"]);
    assert_eq!(number(&end["motors"][1]["torque_n_m"]), 0.3);
    // Across it is accelerated by 7.5 × 305 mm/(200 ms)² at most, which its friction holds: more can be balanced.
    let across = found(&[CYCLE, "--at", "150 ms", "--every", "90 deg"]);
    assert!(reaches(&across, "blocked")[0] > 7.5 * 0.305 / 0.04, "{:?}", reaches(&across, "blocked"));
    // What is near but does not press is taken if that is said.
    let near = found(&[CYCLE, "--at", "150 ms", "--every", "90 deg", "--within", "0.05 mm"]);
    let count = |of: &Value| of["contacts"].as_array().map_or(0, Vec::len);
    assert!(count(&near) == 5 && count(&across) < 5, "{} {}", count(&near), count(&across));
    let both = reaches(&near, "blocked").into_iter().zip(reaches(&across, "blocked"));
    assert!(both.into_iter().all(|(near, pressing)| near >= pressing * (1.0 - 1e-9)));
}

#[test]
fn a_differential_is_asked_with_its_outputs_and_its_input_blocked() {
    let of = found(&["scenes/gripper/seesaw.toml", "--every", "45 deg"]);
    let [outputs, input] = [0, 1].map(|index| &of["form_closure"][index]);
    assert_eq!((outputs["blocked"].as_str(), input["blocked"].as_str()), (Some("outputs"), Some("input")));
    assert_eq!(
        (&input["closure"]["closed"], &input["closure"]["necessary"]["motors"]),
        (&Value::Bool(false), &1.into())
    );
    assert_eq!(outputs["closure"]["necessary"]["motors"], 2);
    assert_eq!((of["motors"].as_array().map(Vec::len), of["motors"][0]["motor"].as_str()), (Some(1), Some("input")));
    assert!(of["motors"][0]["brake_max_n_m"].is_null());
}

#[test]
fn every_number_has_its_unit() {
    const BARE: [&str; 17] = [
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
                BARE.contains(&key) || key == "time_s" || UNITS.iter().any(|unit| key.ends_with(unit)),
                "the number under \"{key}\" has no unit"
            ),
            Value::Array(values) => values.iter().for_each(|value| check(key, value)),
            Value::Object(fields) => fields.iter().for_each(|(key, value)| check(key, value)),
            _ => {}
        }
    }
    check("", &found(&[GRIPPER, "--every", "90 deg"]));
}

#[test]
fn tables_and_pictures_say_what_gives_way() {
    let directory = directory("statics-gripper");
    let picture = directory.join("polar.svg");
    let output = phalanx(&["statics", "scenes/gripper/cycle.toml", "--svg", picture.to_str().expect("text")]);
    let text = stdout(&output);
    for part in [
        "posture at 350 ms of the run, held",
        "a brake that holds 2000 N·mm",
        "R21 right proximal",
        "form closure, both driven links blocked",
        "force closure with friction of the scene: closed",
        "largest acceleration of the palm that contact forces can balance",
        "270°",
        "slip ",
        "picture: ",
    ] {
        assert!(text.contains(part), "no \"{part}\" in\n{text}");
    }
    let svg = std::fs::read_to_string(&picture).expect("a picture");
    for part in [
        "motors blocked",
        "motors at their torque",
        "down, out of the palm",
        ">palm</text>",
        " g</text>",
        "prefers-color-scheme:dark",
    ] {
        assert!(svg.contains(part), "no \"{part}\" in the picture");
    }
    let again = directory.join("again.svg");
    phalanx(&["statics", "scenes/gripper/cycle.toml", "--svg", again.to_str().expect("text")]);
    assert_eq!(std::fs::read_to_string(&again).expect("a picture"), svg, "the same figures give the same bytes");
}

#[test]
fn what_cannot_be_asked_is_refused() {
    for (args, message) in [
        (&[GRIPPER, "--at", "21 ms"][..], "ends at 20.000000 ms"),
        (
            &[GRIPPER, "--at", "1 ms"],
            "nothing touches the object of \"gripper-design-95\" at 1.000000 ms of its run, where it is not grasped",
        ),
        (&[GRIPPER, "--at", "1 ms", "--posture", "geometric"], "take one of them out"),
        (&[GRIPPER, "--posture", "geometric", "--within", "1 mm"], "take out --within"),
        (&[GRIPPER, "--posture", "q11=2 deg"], "no q21_r"),
        (&[GRIPPER, "--posture", "q11=2 deg, q21=75 deg"], "deep in the object"),
        (&[GRIPPER, "--posture", "q11=-40 deg, q21=50 deg, y=25 mm"], "nothing touches the object"),
        (&[GRIPPER, "--posture", "q11=170 deg, q21=5 deg"], "the loop cannot close"),
        (&[GRIPPER, "--every", "7 deg"], "makes a turn"),
        (&["scenes/gripper/fixed.toml"], "is fixed, so nothing need hold it"),
        (&["scenes/experiment-95.toml", "--at", "1 ms"], "--at is for a gripper"),
        (&["scenes/laws/radii.toml"], "the grasp of a finger or a gripper"),
    ] {
        let output = phalanx(&[&["statics"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        let text = stderr(&output).replace('\n', " ");
        assert!(text.contains(message), "{args:?}: {text}");
    }
}
