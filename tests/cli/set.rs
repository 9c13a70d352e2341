//! `--set` and `extends`: a scene from several texts.

use std::fs;
use std::path::Path;

use phalanx::scene;
use serde_json::Value;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, write};

/// The shipped scene without its name, so that files are named by themselves.
fn anchor(directory: &Path) -> String {
    let text = fs::read_to_string(ANCHOR).expect("the anchor scene");
    let text: Vec<&str> = text.lines().filter(|line| !line.starts_with("name =")).collect();
    write(directory, "anchor.toml", &text.join("\n"))
}

fn finals(args: &[&str]) -> Value {
    let output = phalanx(&[&["run"], args, &["--json", "--no-check"]].concat());
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    json(&output)["final"].clone()
}

#[test]
fn what_is_set_is_what_a_file_would_say() {
    let dir = directory("cli_set_run");
    let text = fs::read_to_string(ANCHOR).expect("the anchor scene");
    let rough = text.replace("mu_static = 0.8", "mu_static = 0.6");
    assert_ne!(rough, text);
    let inside = write(&dir, "inside.toml", &format!("{rough}\n[initial]\nqd11 = \"3 rad/s\"\n"));
    let set = ["--set", "contact.friction.mu_static=0.6", "--set", "initial.qd11=3 rad/s"];
    for model in ["analytic", "engine"] {
        let by_flag = finals(&[&[ANCHOR, "--model", model][..], &set].concat());
        assert_eq!(by_flag, finals(&[&inside, "--model", model]));
        assert_ne!(by_flag, finals(&[ANCHOR, "--model", model]));
    }
    // The last one counts.
    let twice = finals(&[&[ANCHOR, "--set", "contact.friction.mu_static=9"][..], &set].concat());
    assert_eq!(twice, finals(&[&inside]));
}

#[test]
fn every_command_that_takes_a_scene_takes_fields() {
    let dir = directory("cli_set_commands");
    let tables = |args: &[&str]| {
        let output = phalanx(args);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{args:?}: {}", stderr(&output));
        stdout(&output).to_string()
    };
    for (args, field) in [
        (&["statics", ANCHOR][..], "motor.torque=400 N*mm"),
        (&["size", ANCHOR], "material.density=2000 kg/m^3"),
        (&["scene", "show", ANCHOR], "duration=7 ms"),
        (&["scene", "check", ANCHOR], "duration=7 ms"),
        (&["scene", "show", ANCHOR, "--resolved"], "duration=7 ms"),
        (&["volume", ANCHOR, "--base", "15.5 mm", "--resolution", "3"], "material.density=4000 kg/m^3"),
        (&["study", "stability", ANCHOR, "--quick", "--json"], "duration=3 ms"),
        (&["study", "step-size", "--quick", "--json"], "duration=7 ms"),
        (&["validate", "scenes/free-swing.toml", "--quick", "--json"], "duration=3 ms"),
    ] {
        let with = [args, &["--set", field]].concat();
        assert_ne!(tables(args), tables(&with), "{args:?}");
    }
    let figure = dir.join("letters.svg").display().to_string();
    tables(&["scene", "show", ANCHOR, "--figure", &figure, "--set", "design.phi22=90 deg"]);
    assert_ne!(fs::read_to_string(&figure).expect("drawn"), {
        tables(&["scene", "show", ANCHOR, "--figure", &figure]);
        fs::read_to_string(&figure).expect("drawn")
    });
    let without = phalanx(&["volume", "--set", "duration=7 ms"]);
    assert_eq!(without.status.code(), Some(2));
    assert!(stderr(&without).contains("none is given"), "{}", stderr(&without));
}

#[test]
fn what_cannot_be_set_is_told_as_in_a_file() {
    for (field, words) in [
        ("contact.friction.mu_sttic=1", ["unknown key `mu_sttic`", "did you mean `mu_static`?"]),
        ("design.base=12", ["`design.base` is a bare number", "--set:1:15"]),
        ("motor.torque=480 Nmm", ["unknown unit `Nmm`", "did you mean N*mm?"]),
        ("contact.friction.mu_static=-1", ["must be at least 0", "contact.friction.mu_static = -1"]),
        ("spring.type=torsional", ["`spring.stiffness` is missing", "--set:1:1"]),
        ("motor=1", ["must be a table", "[motor]"]),
        ("gravity=9.81", ["`gravity` is a bare number", "write x and y: [\"0 m/s^2\", \"9.81 m/s^2\"]"]),
        ("object.centre[2]=1 mm", ["unknown key `centre[2]` in [object]", "did you mean `centre`?"]),
        ("bodies.l11.com[0]=1 mm", ["one element of `bodies.l11.com`", "give the whole pair"]),
        ("t32=9 mm", ["two phalanges", "phalanx does not have this"]),
        ("object.shape=box", ["every object is a disc", "give its radius"]),
        ("ground_pivot=[\"0 mm\", \"1 mm\"]", ["one ground joint", "phalanx does not have this"]),
        ("motor.profile=position", ["no controller", "profile = \"ramp\", \"reversal\" or \"table\""]),
        ("contact.law=hunt-crossley", ["depth^exponent with a damper", "contact.friction.law = \"regularised\""]),
        ("mu_static", ["there is no `=`", "contact.friction.mu_static=0.6"]),
        ("a b=1", ["`a b` is no field", "points between"]),
    ] {
        let output = phalanx(&["run", ANCHOR, "--set", field]);
        assert_eq!(output.status.code(), Some(2), "{field}");
        for word in words {
            assert!(stderr(&output).contains(word), "{field}: {word}\n{}", stderr(&output));
        }
    }
}

#[test]
fn what_is_set_takes_along_what_has_no_effect_beside_it() {
    let set = |file: &str, fields: &[&str]| {
        let fields: Vec<_> = fields.iter().map(|field| scene::setting("--set", field).expect("a field")).collect();
        scene::load_any_with(file, &fields)
    };
    let dir = directory("cli_set_off");
    let bristle = "[contact.friction]\nmu_static = 0.8\nlaw = \"bristle\"\nbristle_relaxation = \"2 ms\"\n";
    let own = write(&dir, "own.toml", &format!("extends = \"{}\"\n{bristle}", lift()));
    let off = ["motor.brake=none", "table.present=false", "contact.friction.law=regularised"];
    let plain = set(&own, &off).expect("a scene without them");
    assert!(plain.finger().motor.brake.is_none() && plain.system.table.is_none());
    assert!(plain.finger().contact.distal.friction.expect("friction").bristle.is_none());
    // What a file itself leaves without effect is still wrong.
    let wrong =
        write(&dir, "wrong.toml", "extends = \"own.toml\"\n[motor]\nbrake = \"none\"\nbrake_torque = \"1 N*m\"\n");
    for fields in [&[][..], &off] {
        let error = set(&wrong, fields).expect_err("no effect").to_string();
        assert!(error.contains("`motor.brake_torque` has no effect") && error.contains("wrong.toml:4"), "{error}");
    }
}

#[test]
fn one_element_of_a_pair_is_set_and_swept() {
    let moved = |field: &str| finals(&[ANCHOR, "--set", "duration=3 ms", "--set", field]);
    assert_eq!(moved("object.centre[0]=-14 mm"), moved("object.centre=[\"-14 mm\", \"20 mm\"]"));
    assert_eq!(moved("gravity[0]=1 g"), moved("gravity=[\"9.81 m/s^2\", \"9.81 m/s^2\"]"));
    let shown = phalanx(&["scene", "show", ANCHOR, "--set", "object.centre[1]=21 mm"]);
    assert!(stdout(&shown).contains("\n\"centre[1]\" = \"21 mm\"\n"), "{}", stdout(&shown));
    let dir = directory("cli_set_element");
    let anchor = anchor(&dir);
    let study = format!(
        "scene = \"{anchor}\"\nset.duration = \"3 ms\"\n[[axes]]\nfield = \"object.centre[0]\"\nvalues = [\"-14 mm\", \"-15 mm\"]\n"
    );
    let (study, csv) = (write(&dir, "study.toml", &study), dir.join("results.csv").display().to_string());
    let swept = phalanx(&["sweep", &study, "--out", &csv]);
    assert_eq!(swept.status.code(), Some(0), "{}", stderr(&swept));
    // How far the contact is from its joint, by the object's place.
    let results = fs::read_to_string(&csv).expect("results");
    assert!(["object.centre[0]_m", "14.9588 mm", "13.5352 mm"].iter().all(|part| results.contains(part)), "{results}");
}

#[test]
fn a_move_is_given_by_its_peak_acceleration_in_g() {
    let lift = lift();
    let fast = ["--set", "duration=2 ms", "--set", "moves.lift.start=0 ms", "--set", "moves.lift.acceleration=1000 g"];
    let run = |more: &[&str]| phalanx(&[&["run", &lift, "--no-check"], &fast[..], more].concat());
    assert!(stdout(&run(&[])).contains("accelerates by up to 9810 m/s² (1000 g)"), "{}", stdout(&run(&[])));
    let peak = json(&run(&["--json"]))["palm_peak_acceleration_m_s2"].as_f64().expect("a peak");
    assert!((peak / 9810.0 - 1.0).abs() < 1e-7, "{peak}");
    for (fields, words) in [
        (&["moves.lift.time=4 ms"][..], "`moves.lift.acceleration` has no effect beside `time`"),
        (&["moves.lift.y=0 mm", "moves.lift.angle=9 deg"], "without a way along x or y"),
    ] {
        let more: Vec<&str> = fields.iter().flat_map(|field| ["--set", field]).collect();
        assert!(stderr(&run(&more)).contains(words), "{}", stderr(&run(&more)));
    }
}

fn lift() -> String {
    fs::canonicalize("scenes/gripper/lift.toml").expect("a shipped scene").display().to_string()
}

#[test]
fn a_scene_says_only_what_differs_from_the_one_it_extends() {
    let dir = directory("cli_extends");
    anchor(&dir);
    fs::create_dir_all(dir.join("variants")).expect("a directory");
    let rough =
        write(&dir, "variants/rough.toml", "extends = \"../anchor.toml\"\n[contact.friction]\nmu_static = 0.6\n");
    let soft = write(
        &dir,
        "soft.toml",
        "extends = \"variants/rough.toml\"\n[spring]\ntype = \"torsional\"\nstiffness = \"100 N*mm/rad\"\npreload = \"90 deg\"\n",
    );
    assert_eq!(finals(&[&rough]), finals(&[ANCHOR, "--set", "contact.friction.mu_static=0.6"]));
    let found = scene::load_any(&soft).expect("a scene");
    assert_eq!(found.name, "soft");
    assert_eq!(found.finger().contact.proximal.friction.expect("friction").mu_static, 0.6);
    // What is shown, and what a log has, stands by itself.
    let shown = phalanx(&["scene", "show", &soft]);
    assert!(!stdout(&shown).contains("extends"), "{}", stdout(&shown));
    let alone = write(&dir, "alone.toml", stdout(&shown));
    assert_eq!(finals(&[&alone]), finals(&[&soft]));
    let log = dir.join("soft.mcap").display().to_string();
    assert_eq!(phalanx(&["run", &soft, "--log", &log]).status.code(), Some(0));
    let verified = phalanx(&["replay", &log, "--verify"]);
    assert_eq!(verified.status.code(), Some(0), "{}{}", stdout(&verified), stderr(&verified));
    // A study of it.
    let study = write(
        &dir,
        "study.toml",
        "scene = \"variants/rough.toml\"\n[[axes]]\nfield = \"motor.torque\"\nvalues = [\"480 N*mm\", \"500 N*mm\"]\n",
    );
    let csv = dir.join("results.csv").display().to_string();
    let swept = phalanx(&["sweep", &study, "--out", &csv]);
    assert_eq!(swept.status.code(), Some(0), "{}", stderr(&swept));
}

#[test]
fn what_is_wrong_is_told_of_the_file_it_stands_in() {
    let dir = directory("cli_extends_wrong");
    let base = write(&dir, "base.toml", "[design]\nbase = \"15 mn\"\n");
    let own = write(&dir, "own.toml", "extends = \"base.toml\"\n[motr]\ntorque = \"1 N*m\"\n");
    let ring = write(&dir, "ring.toml", "extends = \"gnir.toml\"\n");
    write(&dir, "gnir.toml", "extends = \"ring.toml\"\n");
    let lost = write(&dir, "lost.toml", "# nothing\nextends = \"nowhere.toml\"\n");
    let number = write(&dir, "number.toml", "extends = 3\n");
    for (file, words) in [
        (&own, &["base.toml:2:8", "own.toml:2:2", "did you mean `motor`", "unknown unit"][..]),
        (&ring, &["extends itself", "comes back to a scene before it"]),
        (&lost, &["cannot read the scene", "nowhere.toml", "lost.toml:2:11", "seen from the directory"]),
        (&number, &["extends", "number.toml:1:11"]),
    ] {
        let output = phalanx(&["scene", "check", file]);
        assert_eq!(output.status.code(), Some(2), "{file}");
        for word in words {
            assert!(stderr(&output).contains(word), "{file}: {word}\n{}", stderr(&output));
        }
    }
    assert!(!stderr(&phalanx(&["scene", "check", &base])).contains("own.toml"));
    let text =
        scene::parse_any("extends = \"base.toml\"\n", "text.toml").expect_err("no file to look from").to_string();
    assert!(text.contains("read by itself"), "{text}");
}
