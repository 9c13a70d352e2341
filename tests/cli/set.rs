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
