//! `phalanx statics` for a finger and for a gripper: output, plot and rejected input.

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, directory, path_in, succeed, succeed_json, write,
};
use crate::support::designs::assert_near as assert_number;
use crate::support::statics::{assert_units, number};
use phalanx::numeric::plane::{add, cross, perp, scale, sub};
use serde_json::{Value, json};
use std::path::Path;

const GRIPPER: &str = "scenes/gripper/design-95.toml";
const CYCLE: &str = "scenes/gripper/cycle.toml";
const MODES: [&str; 2] = ["blocked", "at_torque"];

fn statics(args: &[&str]) -> Value {
    succeed_json(&[&["statics"], args].concat())
}

/// Runs `phalanx statics` with a picture; returns the text and the picture.
fn draw(directory: &Path, scene: &str) -> (String, String) {
    let picture = path_in(directory, "grasp.svg");
    (succeed(&["statics", scene, "--plot", &picture]), std::fs::read_to_string(&picture).expect("a picture"))
}

#[track_caller]
fn assert_near(value: &Value, expected: f64, tolerance: f64) {
    assert_number(number(value), expected, tolerance);
}

#[test]
fn json_of_experiment_95() {
    let report = statics(&[EXPERIMENT_95]);
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
    assert_units(&statics(&[EXPERIMENT_95]));
    assert_units(&statics(&[GRIPPER, "--every", "90 deg"]));
    assert_units(&statics(&[&open_grasp(&directory("statics-units"))]));
}

/// Writes a scene with a finger so close that its motor squeezes the object out.
fn open_grasp(directory: &Path) -> String {
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
    let (text, svg) = draw(&directory, &scene);
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
    assert_eq!(draw(&directory, &scene).1, svg);
    let closed = draw(&directory, EXPERIMENT_95).1;
    assert!(closed.contains("form-closed") && !closed.contains("a free motion"));

    let motion = &statics(&[&scene])["form_closure"]["motion"];
    assert_eq!(motion["object_m_s"], json!([0.0, 0.001]));
    assert_eq!(motion["rates"].as_array().unwrap().len(), 7);
    assert!(number(&motion["fingers"][0]["motor_rad_s"]) > 0.0);
}

#[test]
fn friction_and_motor_can_be_set() {
    let report = statics(&[EXPERIMENT_95, "--mu-static", "0,0.4", "--motor", "0.5165 N*m"]);
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
    let report = statics(&["scenes/long-fingers.toml"]);
    // Final forces stated in the comment of the scene: 13.7 N and 11.1 N.
    assert_near(&report["forces"][0]["f21_n"], 13.7, 0.1);
    assert_near(&report["forces"][0]["f22_n"], 11.1, 0.1);
    let report = statics(&["scenes/torsional-spring.toml"]);
    assert_eq!(report["drive"]["spring"]["type"], "torsional");
    // The two scenes differ only in properties that do not affect form closure.
    assert_eq!(report["form_closure"], statics(&[EXPERIMENT_95])["form_closure"]);
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
        let closure = &statics(&[&write(&directory, "raised.toml", &text)])["form_closure"];
        assert_eq!((&closure["palm"], &closure["closed"]), (&json!(palm), &json!(closed)), "{height}");
    }
    assert_eq!(statics(&[EXPERIMENT_95])["form_closure"]["palm"], "rests");
}

#[test]
fn rejects_scenes_without_a_grasp() {
    let directory = directory("statics-refused");
    let (picture, missing) = (path_in(&directory, "x.svg"), path_in(&directory, "no/where.svg"));
    for (scene, picture, fragment) in [
        ("scenes/free-swing.toml", &picture, "no object"),
        ("scenes/laws/spring.toml", &picture, "has no body without joints that has contacts"),
        ("scenes/hard/misses.toml", &picture, "make l21 longer"),
        ("scenes/nowhere.toml", &picture, "nowhere.toml"),
        (EXPERIMENT_95, &missing, "mkdir -p"),
    ] {
        assert_rejected(&["statics", scene, "--plot", picture], &["error: ", fragment]);
    }
    assert!(!Path::new(&picture).exists());
}

#[track_caller]
fn list(value: &Value) -> &Vec<Value> {
    value.as_array().expect("a list")
}

fn contact_names(document: &Value) -> Vec<&str> {
    list(&document["contacts"]).iter().map(|contact| contact["place"].as_str().expect("a name")).collect()
}

/// Whether two limits agree; both may be infinite.
fn agree(a: f64, b: f64, relative: f64) -> bool {
    a == b || (a - b).abs() < relative * (1.0 + b.abs())
}

fn directions(document: &Value) -> &Vec<Value> {
    list(&document["holds"][0]["accelerations"])
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
    let posture = &document["posture"];
    let inertia = scale(pair(&direction["direction"]), -number(&balance["acceleration_m_s2"]));
    let mut sum = scale(add(pair(&posture["gravity_m_s2"]), inertia), number(&posture["mass_kg"]));
    let mut moment = 0.0;
    for force in list(&balance["forces"]) {
        let Some(normal_n) = force["normal_n"].as_f64() else { continue };
        let mut contacts = list(&document["contacts"]).iter();
        let contact = contacts.find(|contact| contact["place"] == force["place"]).expect("a contact");
        let normal = pair(&contact["normal"]);
        let mirror = if contact["place"].as_str().expect("a name").starts_with("left") { 1.0 } else { -1.0 };
        let friction = mirror * number(&force["tangential_n"]);
        let on_object = sub(scale(normal, normal_n), scale(perp(normal), friction));
        assert!(normal_n >= 0.0 && friction.abs() <= number(&contact["mu_static"]) * normal_n + 1e-9, "{force}");
        sum = add(sum, on_object);
        let arm = sub(pair(&contact["point_m"]), [number(&posture["x_m"]), number(&posture["y_m"])]);
        moment += cross(arm, on_object);
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
    for (contact, [normal_n, tangential_n]) in
        list(&document["contacts"]).iter().zip([[20.46, 4.490], [8.690, -0.1446]].repeat(2))
    {
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
    assert_eq!((list(&document["form_closure"]).len(), &closure["blocked"]), (1, &json!("outputs")));
    assert_eq!(closure["closure"]["closed"], run["grasp"]["form_closed"]);

    assert_eq!(directions(&document).len(), 24);
    let mut limited = 0;
    for direction in directions(&document) {
        for drive_mode in MODES {
            let balance = &direction[drive_mode];
            if balance["balanced"] != "up to" {
                continue;
            }
            limited += 1;
            let residual = balance_residual(&document, direction, balance);
            assert!(residual.iter().all(|component| component.abs() < 1e-8), "{residual:?} of {direction}");
            let limiting = ["slips", "leaves", "brakes_slip"].map(|key| list(&balance[key]).len());
            assert!(limiting.iter().sum::<usize>() > 0 && number(&balance["gap"]) < 1e-8, "{balance}");
        }
        assert!(limit(&direction["blocked"]) >= limit(&direction["at_torque"]) * (1.0 - 1e-9), "{direction}");
    }
    assert!(limited >= 24, "{limited}");
}

#[test]
fn mirrored_grippers_have_mirrored_limits() {
    let [right, left] =
        ["scenes/gripper/offset.toml", "scenes/gripper/offset-left.toml"].map(|scene| statics(&[scene]));
    for drive_mode in MODES {
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
    assert_eq!(list(&geometric["contacts"]).len(), 5);
    assert!(geometric["posture"]["time_s"].is_null() && geometric["contacts"][0]["normal_n"].is_null());
    // The five contacts form-close the object with both driven links blocked.
    assert_eq!(geometric["form_closure"][0]["closure"]["closed"], true);
    let right = &geometric["posture"]["right"];
    let (q11, q21) = (number(&right["q11_rad"]), number(&right["q21_rad"]));
    let given = statics(&[GRIPPER, "--posture", &format!("q11={q11} rad, q21={q21} rad")]);
    assert_eq!(given["posture"]["source"], "given");
    assert_eq!(contact_names(&given), contact_names(&geometric));
    for drive_mode in MODES {
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
    let holds = list(&document["holds"]);
    let blocked = |case: &Value| -> Vec<f64> {
        list(&case["accelerations"]).iter().map(|direction| limit(&direction["blocked"])).collect()
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
    assert!(list(&near["contacts"]).len() == 5 && list(&transfer["contacts"]).len() < 5);
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
    assert_eq!((list(&document["motors"]).len(), &document["motors"][0]["motor"]), (1, &json!("input")));
    assert!(document["motors"][0]["brake_max_n_m"].is_null());
}

#[test]
fn table_and_plot_show_the_limiting_contacts() {
    let directory = directory("statics-gripper");
    let (text, svg) = draw(&directory, CYCLE);
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
    assert_eq!(draw(&directory, CYCLE).1, svg, "the plot is reproducible");
}

#[test]
fn rejects_invalid_options_of_grippers() {
    for (args, message) in [
        (&[GRIPPER, "--at", "21 ms"][..], "ends at 20.000000 ms"),
        (&[GRIPPER, "--at", "0 ms"], "more than 0"),
        (&[GRIPPER, "--within", "0 mm"], "more than 0"),
        (
            &[GRIPPER, "--at", "1 ms"],
            "the object of \"gripper-design-95\" has no contacts at 1.000000 ms of its run, where its fate is \"carried\"",
        ),
        (&[GRIPPER, "--at", "1 ms", "--posture", "geometric"], "remove one of them"),
        (&[GRIPPER, "--posture", "geometric", "--within", "1 mm"], "remove --within"),
        (&[GRIPPER, "--posture", "q11=2 deg"], "q21_r is missing"),
        (&[GRIPPER, "--posture", "q11_r=1 deg, q21=1 deg"], "q11_l is missing"),
        (&[GRIPPER, "--posture", ""], "q11_r is missing"),
        (&[GRIPPER, "--posture", "q12=1 deg"], "not one of q11"),
        (&[GRIPPER, "--posture", "x_r=1 mm"], "not one of q11"),
        (&[GRIPPER, "--posture", "closed"], "has no `=`"),
        (&[GRIPPER, "--posture", "q11=1"], "no unit"),
        (&[GRIPPER, "--posture", "q11=2 deg, q21=75 deg"], "penetrates the object by"),
        (&[GRIPPER, "--posture", "q11=-40 deg, q21=50 deg, y=25 mm"], "has no contacts in this posture"),
        (&[GRIPPER, "--posture", "q11=170 deg, q21=5 deg"], "the loop cannot close"),
        (&[GRIPPER, "--every", "7 deg"], "divide a full turn"),
        (&[GRIPPER, "--every", "0 deg"], "divide a full turn"),
        (&[GRIPPER, "--every", "-15 deg"], "divide a full turn"),
        (&[GRIPPER, "--every", "200 deg"], "divide a full turn"),
        (&[GRIPPER, "--every", "0.1 deg"], "divide a full turn"),
        (&["scenes/gripper/fixed.toml"], "is fixed, so it needs no grasp"),
        (&["scenes/experiment-95.toml", "--at", "1 ms"], "--at needs a gripper"),
        (&["scenes/laws/radii.toml"], "name the held body with --object"),
    ] {
        assert_rejected(&[&["statics"], args].concat(), &[message]);
    }
}
