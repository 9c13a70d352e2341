//! Commands with scenes of mechanisms.

use std::fs;

use crate::support::cli::{assert_contains, assert_rejected, directory, path_in, run_json, succeed, succeed_json};
use serde_json::Value;

const FINGER: &str = "scenes/mechanisms/f85-finger.toml";
const TENDON_FINGER: &str = "scenes/mechanisms/tendon-finger.toml";

/// Each scene ends as its reference solution, which its comment states.
#[test]
fn shipped_mechanisms_end_as_documented() {
    for (name, ends) in [
        (
            "f85-finger",
            &[("/joints/driver/angle_rad", 0.583_156_860_3), ("/joints/coupler/angle_rad", -0.146_080_275_7)][..],
        ),
        ("four-bar", &[("/joints/crank/angle_rad", 26.248_510_99), ("/joints/rocker/angle_rad", 0.028_386_580_78)]),
        ("slider-crank", &[("/joints/crank/angle_rad", 28.711_176_11), ("/joints/slide/position_m", 0.072_008_478_07)]),
        ("andrews", &[("/joints/beta/angle_rad", 15.810_771_2), ("/joints/epsilon/angle_rad", 1.048_080_741)]),
    ] {
        let run = succeed_json(&["run", &format!("scenes/mechanisms/{name}.toml"), "--rtol", "1e-8"]);
        for (path, expected) in ends {
            let found = run.pointer(path).and_then(Value::as_f64).expect("a number");
            assert!((found - expected).abs() < 1e-7, "{name}: {path} is {found}, not {expected}");
        }
        assert_eq!(run["completed"], true, "{name}");
    }
    let run = succeed_json(&["run", FINGER]);
    let first_ms = |contact: &str| 1e3 * run["contacts"][contact]["first_s"].as_f64().expect("a time");
    assert!((first_ms("ground.disc/link.face") - 20.023_784_8).abs() < 1e-4);
    assert!((first_ms("ground.disc/follower.pad") - 25.060_844_3).abs() < 1e-4);
    assert_eq!(run["bodies"]["driver"]["motion"], "jointed");
    assert_eq!(run["check"]["verdict"], "sure");
}

/// The log of a run contains all samples and events, and the page its bodies and joints.
#[test]
fn mechanisms_are_logged_replayed_and_drawn() {
    let directory = directory("mechanism");
    let [log, csv, replayed, page] =
        ["run.mcap", "run.csv", "replayed.csv", "run.html"].map(|name| path_in(&directory, name));
    let scene = "scenes/mechanisms/slider-crank.toml";
    let forces = ["--set", "log.joint_forces=true"];
    succeed(&[
        "run",
        scene,
        "--set",
        "duration=20 ms",
        forces[0],
        forces[1],
        "--log",
        &log,
        "--csv",
        &csv,
        "--plot",
        &page,
    ]);
    let summary = succeed(&["replay", &log, "--csv", &replayed]);
    assert_contains(&summary, &["completed, 20 ms", "slide", "position, mm", "moment, N·m"]);
    let [written, read] = [&csv, &replayed].map(|file| fs::read_to_string(file).expect("a table"));
    assert_eq!(written, read);
    assert!(written.starts_with("time_s,crank_rad,crank_rate_rad_s,crank_force_x_n,"));
    assert_contains(&written, &["slide_position_m,slide_rate_m_s", "slider_x_m"]);
    assert_contains(&succeed(&["replay", &log, "--verify"]), &["VERIFIED"]);
    let page = fs::read_to_string(page).expect("a page");
    assert_contains(&page, &["Slider position", "Joint angle", "Torque", "\"rod\""]);
}

/// Both models of the finger agree within all bounds, and all files are written.
#[test]
fn mechanisms_are_validated() {
    let out = path_in(&directory("mechanism-validation"), "validation");
    let report =
        succeed(&["validate", FINGER, "--all", "--set", "duration=26 ms", "--ladder-time", "0.1 s", "--out", &out]);
    assert_contains(&report, &["within all bounds", "ground.disc/follower.pad first contact, ms"]);
    for file in ["report.json", "page.html", "series.csv", "difference.svg", "engine.mcap"] {
        assert!(fs::exists(format!("{out}/{file}")).expect("a readable directory"), "{file}");
    }
}

#[test]
fn commands_for_fingers_refuse_mechanisms() {
    assert_rejected(&["statics", FINGER], &["no body without joints that has contacts", "--object"]);
    let message = assert_rejected(&["size", FINGER], &[]);
    assert!(message.contains("mechanism") || message.contains("not a gripper"), "{message}");
    for command in ["capture", "hold"] {
        assert_rejected(&[command, FINGER], &["has no grasp", "[[contacts]]"]);
    }
    assert_rejected(&["scene", "show", FINGER, "--plot", "finger.svg"], &["is a scene without five-bar finger", "run"]);
    let check = succeed(&["scene", "check", FINGER]);
    assert_contains(&check, &["4 bodies, 5 joints, 2 degrees of freedom, 1 actuator, 2 contacts"]);
}

/// The page contains the scene with all layers; the module is not read.
#[test]
fn the_explorer_opens_scenes_of_every_kind() {
    let directory = directory("mechanism_explorer");
    let module = path_in(&directory, "module.wasm.gz");
    fs::write(&module, [0x1f, 0x8b]).expect("a written file");
    let page = path_in(&directory, "page.html");
    for (scene, part) in [
        (FINGER, "[joints.coupler]"),
        ("scenes/mechanisms/gripper-box.toml", "[object.outline]"),
        ("scenes/laws/impact.toml", "kind = \\\"bodies\\\""),
        ("scenes/real/2f85-lift.toml", "right_follower"),
    ] {
        succeed(&["explore", "--module", &module, scene, "-o", &page]);
        let text = fs::read_to_string(&page).expect("a page");
        let (_, start) = text.split_once("\"start\":").expect("the first scene");
        assert!(start.contains(part), "{scene}");
    }
}

#[test]
fn new_mechanisms_are_shipped_scenes() {
    for (kind, content, shipped) in [
        ("mechanism", "a finger with a loop", FINGER),
        ("two-pivot", "a gripper whose fingers have two pivots", "scenes/mechanisms/two-pivot.toml"),
        ("tendon", "a hand whose fingers are closed by tendons", "scenes/mechanisms/tendon-hand.toml"),
        ("jaw", "two jaws on sliders", "scenes/mechanisms/jaws.toml"),
    ] {
        let file = path_in(&directory("new-mechanism"), &format!("{kind}.toml"));
        assert_contains(
            &succeed(&["new", &file, "--kind", kind]),
            &[content, "run", "schema scene > ", "scene.schema.json"],
        );
        let (directive, text) = ("#:schema ./scene.schema.json\n", fs::read_to_string(shipped).expect("a scene"));
        assert_eq!(fs::read_to_string(file).expect("a scene"), format!("{directive}{text}"));
    }
}

/// Both models of a finger with a tendon agree, and its tension is in reports, tables, logs and pages.
#[test]
fn tendons_are_reported_logged_and_drawn() {
    let directory = directory("tendon");
    let [log, csv, replayed, page] =
        ["run.mcap", "run.csv", "replayed.csv", "run.html"].map(|name| path_in(&directory, name));
    let files = ["--log", &log, "--csv", &csv, "--plot", &page, "--set", "log.joint_forces=true"];
    let run = succeed_json(&[&["run", TENDON_FINGER][..], &files].concat());
    let engine = succeed_json(&["run", TENDON_FINGER, "--model", "engine"]);
    for (path, allowed) in [("/joints/base/angle_rad", 1e-4), ("/tendons/flexor/tension_n", 0.1)] {
        let [found, other] = [&run, &engine].map(|run| run.pointer(path).and_then(Value::as_f64).expect("a number"));
        assert!((found - other).abs() < allowed, "{path}: {found}, {other}");
    }
    assert_contains(&succeed(&["replay", &log, "--csv", &replayed]), &["flexor", "tension, N"]);
    let written = fs::read_to_string(csv).expect("a table");
    assert_contains(&written, &["flexor_length_m,flexor_rate_m_s,flexor_tension_n"]);
    assert_eq!(written, fs::read_to_string(replayed).expect("a table"));
    assert_contains(&fs::read_to_string(page).expect("a page"), &["Tendon tension"]);
    assert_contains(&succeed(&["scene", "check", TENDON_FINGER]), &["1 actuator"]);
}

/// A cable that leaves its pulley goes on along the straight line between its neighbours, in both models: formerly the run
/// ended there.
#[test]
fn a_cable_that_lifts_off_goes_on() {
    let scene = fs::read_to_string(TENDON_FINGER).expect("a scene");
    // The cable comes from below, and is straight when the finger has closed by 13 degrees.
    let moved = scene.replace("[\"45 mm\", \"-8 mm\"]", "[\"-15 mm\", \"-40 mm\"]");
    let file = path_in(&directory("lifts-off"), "scene.toml");
    fs::write(&file, moved).expect("a file");
    for model in ["analytic", "engine"] {
        let csv = path_in(&directory("lifts-off-samples"), &format!("{model}.csv"));
        succeed(&["run", &file, "--model", model, "--csv", &csv]);
        let table = fs::read_to_string(csv).expect("a table");
        let column = |name: &str| -> Vec<f64> {
            let index = table.lines().next().and_then(|head| head.split(',').position(|column| column == name));
            let value = |row: &str| row.split(',').nth(index.expect("a column")).and_then(|value| value.parse().ok());
            table.lines().skip(1).map(|row| value(row).expect("a number")).collect()
        };
        // It leaves the pulley after 25 ms, and is back before the end.
        let on = column("flexor[1]_on");
        assert!(on[0] == 1.0 && on.contains(&0.0) && on.last() == Some(&1.0), "{model}: {on:?}");
        let gap_m = column("flexor[1]_gap_m").into_iter().fold(0.0, f64::max);
        assert!((gap_m - 2.55e-3).abs() < 0.1e-3, "{model}: {gap_m}");
    }
}

/// The analytic model has no limit of actuators: formerly it took eight.
#[test]
fn a_mechanism_with_nine_motors_runs() {
    let mut text = "kind = \"mechanism\"\nduration = \"1 ms\"\n".to_string();
    for i in 0..9 {
        text += &format!(
            "[bodies.b{i}]\nmass = \"10 g\"\ninertia = \"1 kg*mm^2\"\ncom = [\"10 mm\", \"0 mm\"]\n\
             guess = {{ at = [\"{i} mm\", \"0 mm\"], angle = \"0 deg\" }}\n[joints.j{i}]\ntype = \"revolute\"\n\
             bodies = [\"ground\", \"b{i}\"]\npoints = [[\"{i} mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0 rad\"\n\
             [actuators.m{i}]\njoint = \"j{i}\"\ntorque = \"1 N*mm\"\n"
        );
    }
    let file = path_in(&directory("many-motors"), "nine.toml");
    fs::write(&file, text).expect("a scene");
    let summary = succeed(&["run", &file]);
    assert_contains(&summary, &["analytic model"]);
}

/// A run and its log list the lift-offs and returns of cables.
#[test]
fn runs_and_logs_list_the_events_of_cables() {
    let scene = "scenes/mechanisms/tendon-hand.toml";
    let log = path_in(&directory("cable-events"), "hand.mcap");
    let run = run_json(&["run", scene, "--json", "--log", &log]);
    let events = run["cable_events"].as_array().expect("events");
    let count = |event: &str| events.iter().filter(|found| found["event"] == event).count();
    assert_eq!([count("leaves"), count("returns")], [4, 4], "{events:?}");
    assert_eq!(run["cable_events"], run_json(&["replay", &log, "--json"])["cable_events"]);
    for text in [succeed(&["run", scene]), succeed(&["replay", &log])] {
        assert_contains(&text, &["right_flexor[1]  leaves the pulley", "left_flexor[2]   returns"]);
    }
    // A cable that stays on its pulleys has none.
    assert!(run_json(&["run", TENDON_FINGER, "--json"]).get("cable_events").is_none());
}

/// A MuJoCo model has the bodies, joints, loops, contacts and actuators of the scene.
#[test]
fn scenes_are_exported_for_mujoco() {
    let directory = directory("mujoco");
    let model = path_in(&directory, "model.xml");
    for (scene, bodies, joints, loops, pairs, actuators) in [
        (FINGER, 4, 4, 1, 2, 1),
        ("scenes/mechanisms/jaws.toml", 3, 5, 0, 3, 2),
        // The five-bar, and the constant torque of its spring.
        ("scenes/experiment-95.toml", 4, 4, 1, 2, 2),
    ] {
        let printed = succeed(&["scene", "export", scene, "--mjcf", &model]);
        assert_contains(&printed, &["own soft constraints"]);
        let xml = fs::read_to_string(&model).expect("the model");
        let found = ["<body name", "<joint name", "<connect", "<pair geom1", "<general name"]
            .map(|tag| xml.matches(tag).count());
        let motors = xml.matches("<motor name").count();
        assert_eq!(
            [found[0], found[1], found[2], found[3], found[4] + motors],
            [bodies, joints, loops, pairs, actuators],
            "{scene}: {xml}"
        );
    }
    fs::write(&model, "not a model").expect("a file");
    assert_rejected(&["scene", "export", FINGER, "--mjcf", &model], &["is not a model written by phalanx"]);
}

/// A limit bounds the command of a motor, before its torque changes with the speed: u − |u| q̇/ω₀ at the largest u.
#[test]
fn a_limit_bounds_the_control_signal_of_a_motor_in_mujoco() {
    let directory = directory("mujoco-limit");
    let [scene, model] = ["motor.toml", "model.xml"].map(|name| path_in(&directory, name));
    let text = "kind = \"mechanism\"\nduration = \"1 ms\"\n[bodies.arm]\nmass = \"1 kg\"\ninertia = \"1 kg*m^2\"\n[joints.q]\n\
                bodies = [\"ground\", \"arm\"]\npoints = [[\"0 m\", \"0 m\"], [\"0 m\", \"0 m\"]]\n[actuators.motor]\njoint = \"q\"\n\
                torque = \"5 N*m\"\nlimit = \"2 N*m\"\nno_load_speed = \"4 rad/s\"\n";
    fs::write(&scene, text).expect("a scene");
    succeed(&["scene", "export", &scene, "--mjcf", &model]);
    let xml = fs::read_to_string(&model).expect("the model");
    assert_contains(&xml, &["biasprm=\"0 0 -0.5\" ctrlrange=\"-2 2\""]);
}

/// Each scene of a real gripper ends as its comment states: positions, angles and times of the first touch.
#[test]
fn real_grippers_end_as_documented() {
    for (name, ends) in [
        (
            "2f85-encompass",
            &[
                ("/bodies/object/x_m", 0.000_175),
                ("/bodies/object/y_m", 0.102_449),
                ("/contacts/object.skin~1right_spring_link.face/first_s", 0.030_464),
            ][..],
        ),
        ("2f85-lift", &[("/bodies/object/y_m", 0.089_467), ("/joints/lift/position_m", 0.049_905)]),
        ("franka-lift", &[("/bodies/object/x_m", -0.000_017), ("/bodies/object/y_m", 0.088_130)]),
        (
            "t42-grasp",
            &[
                ("/bodies/object/x_m", 0.000_036),
                ("/bodies/object/y_m", 0.035_242),
                ("/contacts/object.skin~1ground.palm/first_s", 0.112_628),
            ],
        ),
        (
            "robotiq-3f-finger",
            &[
                ("/contacts/ground.object~1proximal.pad/first_s", 0.039_210),
                ("/contacts/ground.object~1middle.pad/first_s", 0.111_454),
                ("/contacts/ground.object~1distal.pad/first_s", 0.130_217),
            ],
        ),
        ("barrett-grasp", &[("/bodies/object/x_m", 0.000_036), ("/bodies/object/y_m", 0.114_342)]),
        ("dp-flex-finger", &[("/joints/distal/angle_rad", 0.657_815), ("/joints/flexion/angle_rad", 0.105_949)]),
    ] {
        let run = succeed_json(&["run", "--no-check", &format!("scenes/real/{name}.toml")]);
        assert_eq!(run["completed"], true, "{name}");
        for (path, expected) in ends {
            let found = run.pointer(path).and_then(Value::as_f64).expect("a number");
            assert!((found - expected).abs() < 1e-6, "{name}: {path} is {found}, not {expected}");
        }
    }
}

/// The friction of the worm drives of a hand comes to rest at the same angle in both models.
#[test]
fn joint_friction_sticks_alike_in_both_models() {
    let [analytic, engine] = ["analytic", "engine"].map(|model| {
        let run = succeed_json(&["run", "--no-check", "--model", model, "scenes/real/barrett-grasp.toml"]);
        run.pointer("/bodies/left_distal/angle_rad").and_then(Value::as_f64).expect("an angle")
    });
    assert!((analytic - engine).abs() < 1e-6, "{analytic} and {engine}");
}

/// The gripper in scenes/real holds a cube of 100 g at 5 g in both models, and its table of many columns is replaced.
#[test]
fn a_real_gripper_holds_a_cube_without_creep() {
    let csv = path_in(&directory("real-gripper"), "run.csv");
    for gravity in ["[\"0 m/s^2\", \"49.05 m/s^2\"]", "[\"-49.05 m/s^2\", \"0 m/s^2\"]"] {
        for (model, end, creep_m_s) in [("analytic", "1 s", 1e-12), ("engine", "150 ms", 1e-6)] {
            let settings = [format!("duration={end}"), format!("gravity={gravity}")];
            let sets = settings.iter().flat_map(|setting| ["--set", setting.as_str()]);
            let scene = "scenes/real/2f85-hold.toml";
            let args = ["run", scene, "--no-check", "--model", model, "--csv", csv.as_str()].into_iter().chain(sets);
            succeed(&args.collect::<Vec<_>>());
            let text = fs::read_to_string(&csv).expect("a table");
            let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
            let column = |name: &str| rows[0].iter().position(|column| *column == name).expect("a column");
            let at = |row: &[&str], name: &str| row[column(name)].parse::<f64>().expect("a number");
            let last = rows.last().expect("rows");
            let middle = &rows[rows.len() / 2];
            let duration_s = at(last, "time_s") - at(middle, "time_s");
            for position in ["object_x_m", "object_y_m"] {
                let creep = (at(last, position) - at(middle, position)) / duration_s;
                assert!(creep.abs() < creep_m_s, "{model}, {gravity}: {position} creeps at {creep} m/s");
            }
        }
    }
}

/// A map of offsets along two axes, and its files; sizes that do not fit the axes.
#[test]
fn capture_maps_offsets_of_the_object() {
    const BOX: &str = "scenes/mechanisms/gripper-box.toml";
    let out = directory("cli_mechanism_capture").join("capture").display().to_string();
    let sizes = ["--along", "x,angle", "--to", "1 mm, 5 deg", "--places", "3"];
    let report = run_json(&[&["capture", BOX, "--out", &out, "--json"][..], &sizes].concat());
    assert_eq!((&report["along"][1], report["places"].as_array().map(Vec::len)), (&Value::from("angle"), Some(9)));
    assert!(report["places"][4]["fate"] == "held" && report["places"][4]["offset_x_m"] == 0.0, "{report:?}");
    let csv = fs::read_to_string(format!("{out}/capture.csv")).expect("a table");
    assert!(csv.starts_with("offset_x_m,offset_y_m,offset_angle_rad,fate,") && csv.lines().count() == 10, "{csv}");
    let text = fs::read_to_string(format!("{out}/capture.txt")).expect("a report");
    assert_contains(&text, &["x ±1.000 mm, angle ±5.000 deg", "angle deg \\ x mm"]);
    let picture = fs::read_to_string(format!("{out}/capture.svg")).expect("a picture");
    assert_contains(&picture, &["x at the start, mm", "angle at the start, deg", "held"]);
    for (args, message) in [
        (&["capture", BOX, "--to", "5 deg"][..], "a length for x and y"),
        (&["capture", BOX, "--along", "x,angle", "--to", "1 mm"], "--to does not fit offsets along x,angle"),
        (&["capture", BOX, "--along", "x,y,angle"], "one or two of x, y and angle"),
        (&["capture", "scenes/gripper/offset.toml", "--along", "y"], "remove --along"),
    ] {
        assert_rejected(args, &[message]);
    }
}

/// A study of a mechanism writes its table and its map; another picture is not replaced by a study without a map.
#[test]
fn sweeps_of_mechanisms_write_tables_and_maps() {
    let directory = directory("sweep-mechanism");
    let [study, out, plot] = ["study.toml", "out.csv", "map.svg"].map(|name| path_in(&directory, name));
    let scene = fs::canonicalize("scenes/mechanisms/two-pivot.toml").expect("a shipped scene");
    let text = format!(
        "scene = \"{}\"\nset.duration = \"100 ms\"\n[[axes]]\nfield = \"bodies.object.mass\"\nvalues = [\"20 g\", \"60 g\"]\n[[axes]]\nfield = \
         \"laws.rubber.friction.mu_static\"\nvalues = [0.3, 0.6]\n[results]\ncolumns = [\"fate\", \"grip_n\"]\n",
        scene.display()
    );
    fs::write(&study, &text).expect("a file");
    let report = succeed(&["sweep", &study, "--out", &out, "--plot", &plot]);
    assert_contains(&report, &["completed  4", "\nheld"]);
    let table = fs::read_to_string(&out).expect("a table");
    assert!(
        table.starts_with(
            "run,design,bodies.object.mass_kg,laws.rubber.friction.mu_static,status,reason,fate,grip_n,steps,"
        ),
        "{table}"
    );
    let picture = fs::read_to_string(&plot).expect("a picture");
    assert_contains(&picture, &["<svg", ">held<", ">mu_static<"]);
    // Nothing is run again, and the map is the same.
    succeed(&["sweep", &study, "--out", &out, "--plot", &plot]);
    assert_eq!(fs::read_to_string(&plot).expect("a picture"), picture);
    fs::write(&study, text.replace("[\"20 g\", \"60 g\"]", "[\"20 g\"]")).expect("a file");
    assert_rejected(
        &["sweep", &study, "--out", &path_in(&directory, "one.csv"), "--plot", &plot],
        &["--plot: a map needs two axes"],
    );
    assert_eq!(fs::read_to_string(&plot).expect("a picture"), picture);
}

#[test]
fn new_writes_shipped_scenes_by_name() {
    let directory = directory("new-from");
    assert_contains(
        &succeed(&["new", "--list"]),
        &["real/2f85-lift", "gripper/cycle", "Pick and place with design 95"],
    );
    let file = path_in(&directory, "lift.toml");
    assert_contains(&succeed(&["new", &file, "--from", "2f85-lift"]), &["the shipped scene real/2f85-lift"]);
    let [written, shipped] =
        [&file[..], "scenes/real/2f85-lift.toml"].map(|path| fs::read_to_string(path).expect("a scene"));
    assert!(written.starts_with("#:schema "), "{written}");
    assert_eq!(written.lines().nth(1), shipped.lines().next());
    // A scene that extends others is written as a single file.
    let file = path_in(&directory, "dropped.toml");
    succeed(&["new", &file, "--from", "gripper/cycle-dropped"]);
    assert!(!fs::read_to_string(&file).expect("a scene").contains("extends"));
    assert_contains(&succeed(&["scene", "check", &file]), &["valid"]);
    assert_rejected(
        &["new", &path_in(&directory, "none.toml"), "--from", "2f85-lft"],
        &["did you mean real/2f85-lift?", "--list"],
    );
    let file = path_in(&directory, "gripper.toml");
    succeed(&["new", &file, "--kind", "gripper"]);
    assert_contains(&succeed(&["run", &file, "--no-check"]), &["held since"]);
}

#[test]
fn scenes_are_shown_as_mechanisms() {
    let directory = directory("as-mechanism");
    let file = path_in(&directory, "linkage.toml");
    fs::write(&file, succeed(&["scene", "show", "scenes/gripper/hold.toml", "--as-mechanism"])).expect("a file");
    assert_contains(&succeed(&["scene", "check", &file]), &["9 bodies, 10 joints"]);
    assert_contains(&succeed(&["run", &file, "--no-check"]), &["held since"]);
    assert_rejected(
        &["scene", "show", "scenes/laws/bristle-holds.toml", "--as-mechanism"],
        &["`block` does not rotate", "rotates = true"],
    );
}
