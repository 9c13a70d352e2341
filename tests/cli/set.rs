//! `--set` and `extends`: scenes composed of several texts.

use std::fs;
use std::path::Path;

use phalanx::scene;
use serde_json::Value;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, directory, json, phalanx, run_json, stderr, stdout, succeed, write,
};

/// Writes experiment-95 without its name, so that scenes are named after their files.
fn write_unnamed_scene(directory: &Path) -> String {
    let text = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let text: Vec<&str> = text.lines().filter(|line| !line.starts_with("name =")).collect();
    write(directory, "anchor.toml", &text.join("\n"))
}

fn final_state(args: &[&str]) -> Value {
    run_json(&[&["run"], args, &["--json", "--no-check"]].concat())["final"].clone()
}

#[test]
fn set_fields_equal_fields_in_a_file() {
    let dir = directory("cli_set_run");
    let text = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let changed = text.replace("mu_static = 0.8", "mu_static = 0.6");
    assert_ne!(changed, text);
    let changed_file = write(&dir, "inside.toml", &format!("{changed}\n[initial]\nqd11 = \"3 rad/s\"\n"));
    let set = ["--set", "contact.friction.mu_static=0.6", "--set", "initial.qd11=3 rad/s"];
    for model in ["analytic", "engine"] {
        let by_flag = final_state(&[&[EXPERIMENT_95, "--model", model][..], &set].concat());
        assert_eq!(by_flag, final_state(&[&changed_file, "--model", model]));
        assert_ne!(by_flag, final_state(&[EXPERIMENT_95, "--model", model]));
    }
    // The last value applies.
    let repeated = final_state(&[&[EXPERIMENT_95, "--set", "contact.friction.mu_static=9"][..], &set].concat());
    assert_eq!(repeated, final_state(&[&changed_file]));
}

#[test]
fn every_scene_command_accepts_set() {
    let dir = directory("cli_set_commands");
    let run_text = |args: &[&str]| {
        let output = phalanx(args);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {}", stderr(&output));
        stdout(&output).to_string()
    };
    for (args, field) in [
        (&["statics", EXPERIMENT_95][..], "motor.torque=400 N*mm"),
        (&["size", EXPERIMENT_95], "material.density=2000 kg/m^3"),
        (&["scene", "show", EXPERIMENT_95], "duration=7 ms"),
        (&["scene", "check", EXPERIMENT_95], "duration=7 ms"),
        (&["scene", "show", EXPERIMENT_95, "--resolved"], "duration=7 ms"),
        (
            &["thesis", "volume", EXPERIMENT_95, "--base", "15.5 mm", "--resolution", "3"],
            "material.density=4000 kg/m^3",
        ),
        (&["thesis", "stability", EXPERIMENT_95, "--quick", "--json"], "duration=3 ms"),
        (&["thesis", "step-size", "--quick", "--json"], "duration=7 ms"),
        (&["validate", "scenes/free-swing.toml", "--quick", "--json"], "duration=3 ms"),
    ] {
        let with_set = [args, &["--set", field]].concat();
        assert_ne!(run_text(args), run_text(&with_set), "{args:?}");
    }
    let figure = dir.join("letters.svg").display().to_string();
    run_text(&["scene", "show", EXPERIMENT_95, "--plot", &figure, "--set", "design.phi22=90 deg"]);
    assert_ne!(fs::read_to_string(&figure).expect("drawn"), {
        run_text(&["scene", "show", EXPERIMENT_95, "--plot", &figure]);
        fs::read_to_string(&figure).expect("drawn")
    });
    assert_rejected(&["thesis", "volume", "--set", "duration=7 ms"], &["none is given"]);
}

#[test]
fn set_errors_equal_file_errors() {
    for (field, parts) in [
        ("contact.friction.mu_sttic=1", ["unknown key `mu_sttic`", "did you mean `mu_static`?"]),
        ("design.base=12", ["`design.base` is a bare number", "--set:1:15"]),
        ("motor.torque=480 Nmm", ["unknown unit `Nmm`", "did you mean N*mm?"]),
        ("contact.friction.mu_static=-1", ["must be at least 0", "contact.friction.mu_static = -1"]),
        ("spring.type=torsional", ["`spring.stiffness` is missing", "--set:1:1"]),
        ("motor=1", ["must be a table", "[motor]"]),
        ("gravity=9.81", ["`gravity` is a bare number", "write x and y: [\"0 m/s^2\", \"9.81 m/s^2\"]"]),
        ("object.centre[2]=1 mm", ["`object.centre` has 2 entries", "there is no `object.centre[2]`"]),
        ("bodies.l11.com[0]=1 mm", ["one element of `bodies.l11.com`", "give the whole pair"]),
        ("t32=9 mm", ["two phalanges", "not supported by phalanx"]),
        ("object.shape=box", ["every object is a disc", "give its radius"]),
        ("ground_pivot=[\"0 mm\", \"1 mm\"]", ["one ground joint", "not supported by phalanx"]),
        ("motor.profile=position", ["no controller", "profile = \"ramp\", \"reversal\" or \"table\""]),
        ("contact.law=hunt-crossley", ["depth^exponent with a damper", "contact.friction.law = \"regularised\""]),
        ("mu_static", ["there is no `=`", "contact.friction.mu_static=0.6"]),
        ("a b=1", ["`a b` is not a field", "separated by points"]),
    ] {
        assert_rejected(&["run", EXPERIMENT_95, "--set", field], &parts);
    }
}

#[test]
fn set_removes_fields_without_effect() {
    let set = |file: &str, fields: &[&str]| {
        let fields: Vec<_> =
            fields.iter().map(|field| scene::parse_setting("--set", field).expect("a field")).collect();
        scene::load_any_with(file, &fields)
    };
    let dir = directory("cli_set_off");
    let bristle = "[contact.friction]\nmu_static = 0.8\nlaw = \"bristle\"\nbristle_relaxation = \"2 ms\"\n";
    let extending = write(&dir, "own.toml", &format!("extends = \"{}\"\n{bristle}", lift()));
    let disabling_fields = ["motor.brake=none", "table.present=false", "contact.friction.law=regularised"];
    let without_sections = set(&extending, &disabling_fields).expect("a scene without them");
    assert!(without_sections.finger().motor.brake.is_none() && without_sections.hand.table.is_none());
    assert!(!without_sections.finger().contact.distal.friction.expect("friction").has_state());
    // Fields without effect in the file itself are still errors.
    let without_motor =
        write(&dir, "wrong.toml", "extends = \"own.toml\"\n[motor]\nbrake = \"none\"\nbrake_torque = \"1 N*m\"\n");
    for fields in [&[][..], &disabling_fields] {
        let error = set(&without_motor, fields).expect_err("no effect").to_string();
        assert!(error.contains("`motor.brake_torque` has no effect") && error.contains("wrong.toml:4"), "{error}");
    }
}

#[test]
fn one_element_of_a_pair_is_set_and_swept() {
    let final_state_with = |field: &str| final_state(&[EXPERIMENT_95, "--set", "duration=3 ms", "--set", field]);
    assert_eq!(final_state_with("object.centre[0]=-14 mm"), final_state_with("object.centre=[\"-14 mm\", \"20 mm\"]"));
    assert_eq!(final_state_with("gravity[0]=1 g"), final_state_with("gravity=[\"9.81 m/s^2\", \"9.81 m/s^2\"]"));
    let shown = succeed(&["scene", "show", EXPERIMENT_95, "--set", "object.centre[1]=21 mm"]);
    assert_contains(&shown, &["\n\"centre[1]\" = \"21 mm\"\n"]);
    let dir = directory("cli_set_element");
    let unnamed_scene = write_unnamed_scene(&dir);
    let study = format!(
        "scene = \"{unnamed_scene}\"\nset.duration = \"3 ms\"\n[[axes]]\nfield = \"object.centre[0]\"\nvalues = [\"-14 mm\", \"-15 mm\"]\n"
    );
    let (study, csv) = (write(&dir, "study.toml", &study), dir.join("results.csv").display().to_string());
    succeed(&["sweep", &study, "--out", &csv]);
    // The distance of the contact from its joint depends on the position of the object.
    let results = fs::read_to_string(&csv).expect("results");
    assert_contains(&results, &["object.centre[0]_m", "14.9588 mm", "13.5352 mm"]);
}

#[test]
fn move_accepts_peak_acceleration_in_g() {
    let lift = lift();
    let fast_move =
        ["--set", "duration=2 ms", "--set", "moves.lift.start=0 ms", "--set", "moves.lift.acceleration=1000 g"];
    let run = |extra_args: &[&str]| phalanx(&[&["run", &lift, "--no-check"], &fast_move[..], extra_args].concat());
    assert!(stdout(&run(&[])).contains("accelerates by up to 9810 m/s² (1000 g)"), "{}", stdout(&run(&[])));
    let peak = json(&run(&["--json"]))["palm_peak_acceleration_m_s2"].as_f64().expect("a peak");
    assert!((peak / 9810.0 - 1.0).abs() < 1e-7, "{peak}");
    for (fields, message) in [
        (&["moves.lift.time=4 ms"][..], "`moves.lift.acceleration` has no effect with `time`"),
        (&["moves.lift.y=0 mm", "moves.lift.angle=9 deg"], "without a distance x or y"),
    ] {
        let extra_args: Vec<&str> = fields.iter().flat_map(|field| ["--set", field]).collect();
        assert!(stderr(&run(&extra_args)).contains(message), "{}", stderr(&run(&extra_args)));
    }
}

fn lift() -> String {
    fs::canonicalize("scenes/gripper/lift.toml").expect("a shipped scene").display().to_string()
}

#[test]
fn extending_scene_contains_only_differences() {
    let dir = directory("cli_extends");
    write_unnamed_scene(&dir);
    fs::create_dir_all(dir.join("variants")).expect("a directory");
    let extending =
        write(&dir, "variants/rough.toml", "extends = \"../anchor.toml\"\n[contact.friction]\nmu_static = 0.6\n");
    let soft = write(
        &dir,
        "soft.toml",
        "extends = \"variants/rough.toml\"\n[spring]\ntype = \"torsional\"\nstiffness = \"100 N*mm/rad\"\npreload = \"90 deg\"\n",
    );
    assert_eq!(final_state(&[&extending]), final_state(&[EXPERIMENT_95, "--set", "contact.friction.mu_static=0.6"]));
    let extended = scene::load_any(&soft).expect("a scene");
    assert_eq!(extended.name, "soft");
    assert_eq!(extended.finger().contact.proximal.friction.expect("friction").mu_static, 0.6);
    // The shown scene and the scene in a log do not need the extended files.
    let shown = succeed(&["scene", "show", &soft]);
    assert!(!shown.contains("extends"), "{shown}");
    let standalone = write(&dir, "alone.toml", &shown);
    assert_eq!(final_state(&[&standalone]), final_state(&[&soft]));
    let log = dir.join("soft.mcap").display().to_string();
    succeed(&["run", &soft, "--log", &log]);
    succeed(&["replay", &log, "--verify"]);
    // The scene of this study extends another one.
    let study = write(
        &dir,
        "study.toml",
        "scene = \"variants/rough.toml\"\n[[axes]]\nfield = \"motor.torque\"\nvalues = [\"480 N*mm\", \"500 N*mm\"]\n",
    );
    let csv = dir.join("results.csv").display().to_string();
    succeed(&["sweep", &study, "--out", &csv]);
}

#[test]
fn errors_name_the_file_of_the_field() {
    let dir = directory("cli_extends_wrong");
    let base = write(&dir, "base.toml", "[design]\nbase = \"15 mn\"\n");
    let extending = write(&dir, "own.toml", "extends = \"base.toml\"\n[motr]\ntorque = \"1 N*m\"\n");
    let ring = write(&dir, "ring.toml", "extends = \"gnir.toml\"\n");
    write(&dir, "gnir.toml", "extends = \"ring.toml\"\n");
    let missing_base = write(&dir, "lost.toml", "# nothing\nextends = \"nowhere.toml\"\n");
    let invalid_extends = write(&dir, "number.toml", "extends = 3\n");
    for (file, parts) in [
        (&extending, &["base.toml:2:8", "own.toml:2:2", "did you mean `motor`", "unknown unit"][..]),
        (&ring, &["extends itself", "leads back to an earlier scene"]),
        (&missing_base, &["cannot read the scene", "nowhere.toml", "lost.toml:2:11", "relative to the directory"]),
        (&invalid_extends, &["extends", "number.toml:1:11"]),
    ] {
        assert_rejected(&["scene", "check", file], parts);
    }
    assert!(!stderr(&phalanx(&["scene", "check", &base])).contains("own.toml"));
    let text = scene::parse_any("extends = \"base.toml\"\n", "text.toml").expect_err("not a file").to_string();
    assert!(text.contains("not read from a file"), "{text}");
}

/// A linkage with parameters.
const LINKAGE: &str = "kind = \"mechanism\"\nduration = \"2 ms\"\n[parameters]\ncrank = \"40 mm\"\nhalf = \"= crank / 2\"\n[bodies.crank]\nmass = \"5 g\"\n\
    inertia = \"= 5 g * crank^2 / 12\"\ncom = [\"= half\", \"0 mm\"]\n[joints.pin]\nbodies = [\"ground\", \"crank\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
    start = \"0 deg\"\nstart_rate = \"10 rad/s\"\n[actuators.motor]\njoint = \"pin\"\ntimes = [\"0 ms\", \"1 ms\", \"2 ms\"]\n\
    torques = [\"0 N*mm\", \"= 1 N * half\", \"0 N*mm\"]\n";

#[test]
fn parameters_and_entries_of_lists_are_set() {
    let dir = directory("cli_set_parameters");
    let file = write(&dir, "linkage.toml", LINKAGE);
    let changed = write(&dir, "changed.toml", &LINKAGE.replace("40 mm", "42 mm"));
    let state = |args: &[&str]| run_json(&[&["run"], args, &["--json", "--no-check"]].concat())["joints"].clone();
    let plain = state(&[&file]);
    let by_flag = state(&[&file, "--set", "parameters.crank=42 mm"]);
    assert_eq!(by_flag, state(&[&changed]));
    assert_eq!(by_flag, state(&[&file, "--set", "parameters.crank== half * 2", "--set", "parameters.half=21 mm"]));
    assert_ne!(by_flag, plain);
    let torque = state(&[&file, "--set", "actuators.motor.torques[1]=25 N*mm"]);
    assert_eq!(torque, state(&[&file, "--set", "actuators.motor.torques=[\"0 N*mm\", \"25 N*mm\", \"0 N*mm\"]"]));
    assert_ne!(torque, plain);
    for (field, words) in [
        ("parameters.crnk=1 mm", ["unknown parameter `crnk`", "did you mean `crank`?"]),
        ("parameters.half== crank + 1", ["`parameters.half`: `crank` is a length, but `1` is a number", "--set:1:22"]),
        ("parameters.crank== half", ["in a circle: crank → half → crank", "give one of them a value"]),
        ("actuators.motor.torques[3]=1 N*m", ["`actuators.motor.torques` has 3 entries", "no such entry"]),
        (
            "actuators.motor.torques[-1]=1 N*m",
            ["`actuators.motor.torques[-1]` is not a field", "entries of lists in brackets"],
        ),
    ] {
        assert_rejected(&["run", &file, "--set", field], &words);
    }
    // The log has the text with its parameters, and is verified from it.
    let log = dir.join("linkage.mcap").display().to_string();
    succeed(&["run", &file, "--set", "parameters.crank=42 mm", "--log", &log]);
    succeed(&["replay", &log, "--verify"]);
    let shown = succeed(&["scene", "show", &file]);
    assert_contains(
        &shown,
        &[
            "half = \"= crank / 2\"  # 20 mm",
            "torques = [\"0 N*mm\", \"= 1 N * half\", \"0 N*mm\"]  # [0 N*mm, 20 N*mm, 0 N*mm]",
        ],
    );
    let again = write(&dir, "again.toml", &shown);
    assert_eq!(state(&[&again]), plain);
    assert_contains(&succeed(&["scene", "show", &file, "--resolved"]), &["com = [\"20 mm\", \"0 m\"]", "\"20 N*mm\""]);
}

#[test]
fn studies_vary_parameters() {
    let dir = directory("cli_set_axes");
    let text = fs::read_to_string(EXPERIMENT_95).expect("experiment-95");
    let text = text
        .replace("base = \"15.5 mm\"", "base = \"= base + 0.5 mm\"")
        .replace("mu_static = 0.8", "mu_static = \"= grip / 2\"");
    let head = "parameters.base = \"15 mm\"\nparameters.grip = 1.6\nparameters.sum = \"= base * grip\"\nparameters.area = \"= base^2\"\n";
    write(&dir, "base.toml", &format!("{head}{text}"));
    let sweep = |axes: &str| {
        let study = write(&dir, "study.toml", &format!("scene = \"base.toml\"\nset.duration = \"3 ms\"\n{axes}"));
        let csv = dir.join("results.csv").display().to_string();
        (study.clone(), phalanx(&["sweep", &study, "--out", &csv, "--force"]), csv)
    };
    let axis = |field: &str, values: &str| format!("[[axes]]\nfield = \"{field}\"\nvalues = [{values}]\n");
    let columns = |csv: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(csv).expect("results");
        let rows: Vec<Vec<String>> = text.lines().map(|line| line.split(',').map(str::to_string).collect()).collect();
        let kept = |row: &Vec<String>| {
            rows[0]
                .iter()
                .zip(row)
                .filter(|(name, _)| {
                    [
                        "run",
                        "design",
                        "parameters.base_m",
                        "parameters.grip",
                        "design.base_m",
                        "contact.friction.mu_static",
                    ]
                    .iter()
                    .all(|other| *other != name.as_str())
                })
                .map(|(_, cell)| cell.clone())
                .collect()
        };
        rows.iter().map(kept).collect()
    };
    let (_, output, csv) =
        sweep(&(axis("parameters.base", "\"15 mm\", \"16 mm\"") + &axis("parameters.grip", "1.2, 1.6")));
    assert!(output.status.success(), "{}", stderr(&output));
    let header = fs::read_to_string(&csv).expect("results");
    assert!(header.starts_with("run,design,parameters.base_m,parameters.grip,l12_m"), "{header}");
    let by_parameter = columns(&csv);
    let (_, output, csv) =
        sweep(&(axis("design.base", "\"15.5 mm\", \"16.5 mm\"") + &axis("contact.friction.mu_static", "0.6, 0.8")));
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(by_parameter, columns(&csv));
    assert_ne!(by_parameter[1], by_parameter[4]);
    // [set] replaces a parameter in every run; a range has the unit of its ends.
    let (_, output, csv) = sweep(
        &("set.parameters.grip = 1.2\n".to_string()
            + "[[axes]]\nfield = \"parameters.base\"\nfrom = \"15 mm\"\nto = \"16 mm\"\ncount = 2\n"),
    );
    assert!(output.status.success(), "{}", stderr(&output));
    let of_set = columns(&csv);
    assert_eq!((&of_set[1], &of_set[2]), (&by_parameter[1], &by_parameter[3]));
    for (axes, words) in [
        (
            axis("parameters.bse", "\"1 mm\""),
            &["unknown parameter `bse`", "did you mean `base`?", "study.toml:4:9"][..],
        ),
        (axis("parameters.base", "12"), &["`parameters.base` is a bare number", "a length", "study.toml:5:11"]),
        (
            axis("parameters.grip", "\"= base\""),
            &["`parameters.grip` is varied by values, but \"= base\" is an expression"],
        ),
        (axis("parameters.sum", "1"), &["`parameters.sum` is a bare number; expected a length"]),
        (axis("parameters.area", "1"), &["`parameters.area` is a quantity in m^2, for which there is no unit"]),
        (axis("parameters", "1"), &["`parameters` is a table of a scene"]),
        (
            axis("object centre", "1"),
            &[
                "`object centre` is not a field: write its sections and its key",
                "with the entries of lists in brackets",
            ],
        ),
        (axis("gravity[2]", "\"1 g\""), &["`gravity` has 2 entries", "no such entry"]),
        (
            "set.parameters.bse = 1\n".to_string() + &axis("palm", "true"),
            &["unknown parameter `bse`", "did you mean `base`?"],
        ),
        ("set.parameters.grip = \"= bse\"\n".to_string() + &axis("palm", "true"), &["unknown parameter `bse`"]),
    ] {
        let (study, output, _) = sweep(&axes);
        assert!(!output.status.success(), "{study}");
        assert_contains(stderr(&output), words);
    }
}
