//! Scene files: the shipped scenes load, resolve and run as documented, and are shown as they were written; broken ones
//! are rejected with exactly the message in the text file of the same name, and damaged ones cause no panic.
//!
//! `PHALANX_BLESS=1 cargo test --test scene broken` rewrites the messages; read the diff before committing it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use phalanx::scene::{self, Scene, SceneError, load_any, parse_any, show, show_written};
use phalanx::trace::{FingerContact, Model};
use proptest::prelude::*;

use super::{DESIGN, assert_round_trip, parse};
use crate::support::checked_run::run;
use crate::support::cli::{EXPERIMENT_95, assert_status, stdout, succeed, succeed_silently};

/// Returns all scene files in a directory, with or without those below it.
fn files(directory: &Path, recursive: bool) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(directory).expect("scenes") {
        let path = entry.expect("entry").path();
        match path.is_dir() {
            true if recursive && !path.ends_with("studies") => paths.extend(files(&path, true)),
            false if path.extension().is_some_and(|extension| extension == "toml") => paths.push(path),
            _ => {}
        }
    }
    paths.sort();
    paths
}

fn load(name: &str) -> Scene {
    load_any(format!("scenes/{name}.toml")).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn anchor_has_the_lengths_masses_and_start_of_design_95() {
    // Expected values: 1-model §1.3 and §1.8.
    let anchor = load("experiment-95");
    let l = anchor.finger().linkage.lengths;
    let expected = [15e-3, 22.3628e-3, 24.4324e-3, 7.5e-3, 12.8566e-3];
    for (got, want) in [l.l11_m, l.l12_m, l.l21_m, l.l22_m, l.t22_m].into_iter().zip(expected) {
        assert!((got - want).abs() < 5e-8, "{got} {want}");
    }
    let b = anchor.finger().linkage.bodies;
    for (body, grams) in [(b.l11, 4.28), (b.l21, 6.30), (b.l12, 5.86), (b.l22, 8.21)] {
        assert!((body.mass_kg * 1e3 - grams).abs() < 5e-3, "{body:?}");
    }
    assert!((anchor.finger().initial.q11_rad.to_degrees() + 49.999).abs() < 1e-3);
    assert!((anchor.finger().initial.q21_rad.to_degrees() - 40.001).abs() < 1e-3);
}

#[test]
fn shipped_scenes_are_described_and_round_trip_exactly() {
    let mut count = 0;
    for directory in ["scenes", "scenes/gripper", "scenes/hard"] {
        for path in files(Path::new(directory), false) {
            let (stem, text) =
                (path.file_stem().expect("a name").to_string_lossy(), fs::read_to_string(&path).expect("text"));
            let is_gripper = directory != "scenes";
            if directory == "scenes/hard" && !stem.contains("gripper") {
                continue;
            }
            assert!(text.starts_with("# ") && text.contains("\n# Expect: "), "{stem}");
            let scene = load_any(&path).unwrap_or_else(|e| panic!("{e}"));
            let prefix = if is_gripper && !stem.starts_with("gripper-") { "gripper-" } else { "" };
            assert_eq!(scene.name, format!("{prefix}{stem}"));
            assert!(if is_gripper { !scene.description.is_empty() } else { scene.source == text }, "{stem}");
            assert_round_trip(&scene);
            count += 1;
        }
    }
    assert!(count >= 25, "{count}");
}

#[test]
fn every_variant_round_trips_exactly() {
    let finger = DESIGN.replace("1.0", "0.7").replace("120 deg", "110 deg");
    let motors = [
        "torque = \"-480 N*mm\"",
        "profile = \"ramp\"\ntorque = \"480 N*mm\"\nrise = \"3.3 ms\"",
        "profile = \"half-sine\"\ntorque = \"480 N*mm\"\npulse = \"1 us\"",
        "profile = \"reversal\"\ntorque = \"480 N*mm\"\nreverse_at = \"0 s\"",
        "profile = \"table\"\ntimes = [\"-1 ms\", \"0.7 ms\"]\ntorques = [\"0 N*m\", \"1 N*m\"]\ninterpolation = \"step\"",
        "profile = \"table\"\ntimes = [\"1 ms\"]\ntorques = [\"0.1 N*m\"]",
    ];
    let springs = [
        "type = \"none\"",
        "type = \"torsional\"\nstiffness = \"0.3 N*mm/deg\"\npreload = \"7 deg\"\nplacement = \"q12\"",
        "torque = \"0 N*mm\"\nplacement = \"q11+q12-(q21+q22)\"",
    ];
    let sections = [
        "[limit]\nenabled = false",
        "[contact.friction]\nmu_static = 0.3\n[contact.distal.friction]\nmu_static = 0.0",
        "[object]\nradius = \"19 mm\"\ncentre = [\"-15 mm\", \"21 mm\"]\n[integrator]\npreset = \"reference\"",
        "[engine]\nlaw = \"rapier\"\nrestitution = 0.1\nstepping = \"fixed\"\n\
         step = \"3.3 us\"\n[contact.friction]\nmu_static = 0.7",
        "[engine]\nlaw = \"rapier\"\nfriction = 0\ntolerance = \"0.07 um\"\nmax_step = \"1 s\"\n\
         iterations = 1\nmax_steps = 1\n[validate]\nangle = \"0.1 deg\"\ncontact_time = \"3 us\"\nfinal_force = 0.07\nimpulse = 1\n\
         loop_gap = \"0.3 mm\"\nuntil = \"0.7 ms\"",
        "[initial]\nqd11 = \"-3 rpm\"\nqd21 = \"12 deg/s\"\noffset = \"13.7 deg\"",
    ];
    for motor in motors {
        for spring in springs {
            for section in sections {
                let text = format!("{finger}\n[motor]\n{motor}\n[spring]\n{spring}\n{section}\n");
                assert_round_trip(&parse(&text));
            }
        }
    }
}

#[test]
fn scene_command_shows_checks_and_prints_the_schema() {
    let show = ["scene", "show", EXPERIMENT_95];
    let shown = succeed_silently(&show);
    assert_round_trip(&parse(&shown));
    // Given values are unchanged, defaults are added, and derived values are rounded.
    let lines = [
        "[design]",
        "base = \"15.5 mm\"",
        "l21_fraction = 1.0",
        "height_ratio = 0.9375",
        "# l12 = \"22.3628 mm\"",
        "offset = \"25 deg\"",
    ];
    for line in lines {
        assert!(shown.lines().any(|output| output == line), "{line}\n{shown}");
    }
    assert!(!shown.contains("e-19") && !shown.contains("\n[lengths]"), "{shown}");
    let resolved = succeed(&[&show[..], &["--resolved"]].concat());
    assert!(resolved.contains("\n[lengths]") && !resolved.contains("[design]"));
    assert_round_trip(&parse(&resolved));

    let files = ["scene", "check", "scenes/free-swing.toml", "tests/broken/unit-missing.toml"];
    let checked = assert_status(&files, 2, &["error: `design.base`: `15.5` has no unit"]);
    assert!(stdout(&checked).starts_with("scenes/free-swing.toml: valid: l11 15.00"));

    let schema = succeed(&["schema", "scene"]);
    assert!(schema.starts_with('{') && schema.ends_with("}\n"));
}

/// First contacts in ms and final normal forces in N, to the digits that the scenes state.
#[test]
fn grasps_match_their_documented_times_and_forces() {
    for (name, first_ms, normal_n) in [
        ("experiment-95", [4.50, 6.88], [23.6, 8.26]),
        ("experiment-95-bristle", [4.50, 6.88], [6.66, 9.77]),
        ("experiment-95-frictionless", [4.50, 6.88], [23.6, 8.26]),
        ("experiment-95-cad", [3.41, 5.17], [23.6, 8.24]),
        ("torsional-spring", [4.50, 6.89], [31.2, 4.8]),
        ("long-fingers", [5.62, 8.05], [13.7, 11.1]),
        ("soft-start", [6.84, 9.25], [20.5, 9.1]),
    ] {
        let outcome = run(Model::Analytic, &load(name), &mut ()).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (i, phalanx) in [FingerContact::Proximal, FingerContact::Distal].into_iter().enumerate() {
            let (summary, last) = (outcome.finger_contact(phalanx), outcome.last.finger_contact(phalanx));
            let first = summary.first_s.unwrap_or(f64::NAN) * 1e3;
            assert!((first - first_ms[i]).abs() < 0.006, "{name} {phalanx:?}: {first} ms");
            assert!((last.normal_n - normal_n[i]).abs() < 0.06, "{name} {phalanx:?}: {} N", last.normal_n);
            assert_eq!(summary.touchdowns, 1, "{name} {phalanx:?}");
        }
    }
}

#[test]
fn free_fingers_touch_nothing_and_reach_their_documented_angles() {
    for (name, expected_deg) in [("free-swing", 119.0), ("other-assembly", 102.0)] {
        let outcome = run(Model::Analytic, &load(name), &mut ()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let q21_deg = outcome.last.finger(0).q21_rad.to_degrees();
        assert!((q21_deg - expected_deg).abs() < 0.6, "{name}: {q21_deg}");
        for phalanx in [FingerContact::Proximal, FingerContact::Distal] {
            assert_eq!(outcome.finger_contact(phalanx).first_s, None, "{name} {phalanx:?}");
        }
    }
}

/// Shows a scene and asserts that the result parses to the same scene.
fn show_and_check(scene: &Scene, label: &str) -> String {
    let text = show_written(scene);
    let mut back = parse_any(&text, "other-name.toml").unwrap_or_else(|error| panic!("{label}: {error}\n{text}"));
    back.source.clone_from(&scene.source);
    // `{:?}` of different `f64` values differs.
    assert_eq!(format!("{back:?}"), format!("{scene:?}"), "{label}");
    text
}

/// Returns the lines that are not empty and not comments.
fn lines(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).collect()
}

#[test]
fn every_scene_is_shown_as_it_was_written() {
    let files = files(Path::new("scenes"), true);
    assert!(files.len() > 60, "{}", files.len());
    for file in files {
        let Ok(scene) = load_any(&file) else { panic!("{}", file.display()) };
        let label = file.display().to_string();
        let text = show_and_check(&scene, &label);
        let source = fs::read_to_string(&file).expect("the scene");
        let given_lines = lines(&source);
        for line in &given_lines {
            // Sections and values are shown as written; only trailing comments are removed.
            let line = line.split(" #").next().unwrap_or(line).trim();
            // The extended scene is included.
            let is_value = !line.contains('{') && !line.starts_with('"') && !line.ends_with('[');
            if let Some((key, value)) = line.split_once('=').filter(|_| is_value && !line.starts_with("extends")) {
                let (key, value) = (key.trim().rsplit('.').next().expect("a key"), value.trim());
                // An expression has its value as a comment.
                let is_shown = text
                    .lines()
                    .any(|shown| shown.split(" #").next().unwrap_or(shown).trim() == format!("{key} = {value}"));
                assert!(is_shown, "{label}: {line}\n{text}");
            }
        }
        assert!(lines(&text).len() > given_lines.len(), "{label}: defaults are filled in");
        for noise in ["e-16", "e-17", "e-18", "e-19", "e-20", "0000000", "9999999"] {
            let noisy_line = text
                .lines()
                .find(|line| line.contains(noise) && !source.contains(noise) && !line.contains("max_steps"));
            assert_eq!(noisy_line, None, "{label}");
        }
        // Showing the result again gives the same lines.
        let reparsed = parse_any(&text, "x.toml").expect("a scene");
        assert_eq!(lines(&show_written(&reparsed)), lines(&text), "{label}");
    }
}

#[test]
fn other_toml_notations_are_shown_as_written() {
    for text in [
        "name = \"dotted\"\ndesign.base = \"15.5 mm\"\ndesign.l21_fraction = 1\ndesign.phi22 = \"120 deg\"\ndesign.arm_ratio = 0.5\n\
         motor.torque = \"480 N*mm\"\nspring = { torque = \"132.6 N*mm\", placement = \"q22\" }\n\
         contact.proximal.friction.mu_static = 0.5 # only here\n",
        "# Sized by itself\nsizing = \"rigid\"\n\n[design]\nbase = '15.5 mm'\nl21 = \"24 mm\"\nphi22 = \"120 deg\"\narm_ratio = 0.5\n",
        "\u{feff}[lengths]\r\nl21 = \"24 mm\"\r\nl22 = \"7.5 mm\"\r\nt22 = \"13 mm\"\r\nphi22 = \"120 deg\"\r\n[object]\r\npresent = false\r\n\
         [initial]\r\nq11 = \"-40 deg\"\r\nq21 = \"50 deg\"\r\n[motor]\r\nprofile = \"table\"\r\ntimes = [\"0 ms\",\r\n  \"5 ms\"]\r\n\
         torques = [\"0 N*m\", \"1 N*m\"]\r\n[spring]\r\ntype = \"none\"\r\n[limit]\r\nenabled = false\r\n[engine]\r\nstepping = \"fixed\"\r\nstep = \"1 us\"\r\n",
    ] {
        let scene = parse_any(text, "given.toml").unwrap_or_else(|error| panic!("{error}"));
        let back = show_and_check(&scene, text);
        let (placement, sizing, step) = ("placement = \"q22\"", "sizing = \"rigid\"", "step = \"1 us\"");
        for part in [placement, "mu_static = 0.5", sizing, "'15.5 mm'", "\"5 ms\"]", step] {
            assert!(back.contains(part) || !text.contains(part), "{part}\n{back}");
        }
    }
}

#[test]
fn derived_friction_is_shown_for_its_contact() {
    // The simulated scene is written with another common section than the file has.
    let finger = "[lengths]\nbase = \"15.3 mm\"\nl21 = \"24 mm\"\nl22 = \"7.5 mm\"\nt22 = \"13 mm\"\nphi22 = \"120 deg\"\n[motor]\ntorque = \"1 N*m\"\n\
        [spring]\ntype = \"none\"\n[contact.friction]\nmu_static = 0.8\n[contact.proximal.friction]\nmu_static = 0.5\n";
    let scene = parse_any(finger, "given.toml").unwrap_or_else(|error| panic!("{error}"));
    let text = show_and_check(&scene, "finger");
    for part in
        ["# [contact.proximal.friction]\n# mu_dynamic = 0.35", "# [contact.distal.friction]\n# mu_dynamic = 0.56"]
    {
        assert!(text.contains(part) && !text.contains("# [contact.friction]"), "{part}\n{text}");
    }
    let text = show_and_check(&load("gripper/different"), "gripper");
    assert!(text.contains("# [left.contact.friction]\n# mu_dynamic = 0.0"), "{text}");
    assert!(!text.contains("# [contact.friction]"), "{text}");
}

#[test]
fn a_modified_scene_is_shown_as_modified() {
    let mut scene = load("experiment-95");
    scene.duration_s = 0.5;
    assert_eq!(show_written(&scene), show(&scene));
    show_and_check(&scene, "changed");
}

#[test]
fn every_broken_scene_is_rejected_with_its_message() {
    let update_expected = std::env::var_os("PHALANX_BLESS").is_some();
    let files = files(Path::new("tests/broken"), false);
    assert!(files.len() >= 30, "{} broken scenes", files.len());
    let (mut differing, mut messages) = (Vec::new(), BTreeSet::new());
    for file in files {
        let error = load_any(&file).map(|scene| scene.name).expect_err("is accepted");
        assert!(!error.problems().is_empty(), "{}", file.display());
        for problem in error.problems() {
            assert!(!problem.message.is_empty() && !problem.help.is_empty(), "{problem:?}");
            assert!(!problem.message.ends_with('.') && !problem.help.contains("  "), "{problem:?}");
        }
        assert!(messages.insert(error.to_string()), "{} repeats", file.display());
        let message = format!("{error}\n").replace('\\', "/");
        let expected_file = file.with_extension("txt");
        if update_expected {
            fs::write(&expected_file, message).expect("write");
        } else if fs::read_to_string(&expected_file).unwrap_or_default() != message {
            differing.push(format!("{}:\n{message}", file.display()));
        }
    }
    assert!(differing.is_empty(), "{}", differing.join("\n"));
}

#[test]
fn unreadable_files_are_rejected() {
    let message = |path: &str| scene::load(path).expect_err(path).to_string();
    assert_eq!(
        message("scenes/no-such.toml"),
        "error: cannot read scene `scenes/no-such.toml`: there is no such file; check the path"
    );
    assert_eq!(
        message("scenes"),
        "error: cannot read scene `scenes`: it is a directory; name a scene file (.toml) in it"
    );
    let path = std::env::temp_dir().join(format!("phalanx-{}-not-utf8.toml", std::process::id()));
    fs::write(&path, b"name = \"a\"\n# caf\xe9\n").expect("write");
    let error = scene::load(&path).expect_err("not UTF-8");
    let _ = fs::remove_file(&path);
    assert!(matches!(error, SceneError::NotUtf8 { line: 2, column: 6, .. }), "{error:?}");
}

/// Texts of the shipped scenes of one finger.
fn shipped_texts() -> Vec<String> {
    files(Path::new("scenes"), false).iter().map(|path| fs::read_to_string(path).expect("text")).collect()
}

/// Asserts that a text is a scene with an exact round trip, or is rejected with a message: it causes no panic.
fn assert_scene_or_message(text: &str) {
    match parse_any(text, "changed.toml") {
        Ok(scene) => assert_round_trip(&scene),
        Err(error) => assert!(error.to_string().starts_with("error: "), "{error}"),
    }
}

/// Discs of all motions with every section.
const DISCS: &str = "kind = \"bodies\"\n[discs.ball]\nradius = \"20 mm\"\ncentre = [\"1 mm\", \"25 mm\"]\nmass = \"50 g\"\n\
    [half_plane]\n[discs.hand]\nradius = \"1 mm\"\ncentre = [\"90 mm\", \"50 mm\"]\nmotion = \"driven\"\n\
    [contact.friction]\nmu_static = 0.3\n";

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_numbers_round_trip_exactly(
        torque in -1e3..1e3f64, spring in 1e-6..1e2f64, mu in 1e-3..2.0f64, exponent in 1.0..3.0f64, k in 1e-3..1e25f64,
        step in 1e-12..1.0f64, bound in 1e-12..1e3f64, until in 1e-9..=20e-3f64,
        base in 12e-3..22e-3f64, fraction in 0.0..=1.0f64, mass in 1e-9..1e3f64, name in "[^\\s]\\PC{0,20}",
    ) {
        let text = format!(
            "name = {}\n[design]\nbase = \"{base} m\"\nl21_fraction = {fraction:?}\nphi22 = \"2 rad\"\narm_ratio = 0.4\n\
             [bodies]\nl11 = {{ mass = \"{mass} kg\" }}\n[motor]\ntorque = \"{torque} N*m\"\n[spring]\n\
             torque = \"{spring:e} N*m\"\n[contact]\nstiffness_si = {k:?}\nexponent = {exponent:?}\n[contact.friction]\n\
             mu_static = {mu:?}\n[engine]\nstepping = \"fixed\"\nstep = \"{step} s\"\n[validate]\n\
             angle = \"{bound} deg\"\nimpulse = {bound:?}\nloop_gap = \"{bound} um\"\nuntil = \"{until} s\"\n",
            toml::Value::String(name)
        );
        assert_round_trip(&parse(&text));
    }

    /// Cutting, splicing and overwriting shipped scenes anywhere gives a scene or a message, never a panic.
    #[test]
    fn damaged_scenes_never_panic(
        scene_index in 0usize..100, cut in 0usize..2000, length in 0usize..40, insert in "\\PC{0,12}", other in 0usize..100,
        truncates in proptest::bool::ANY,
    ) {
        let scenes = shipped_texts();
        let mut text: Vec<char> = scenes[scene_index % scenes.len()].chars().collect();
        let at = cut % (text.len() + 1);
        let end = (at + length).min(text.len());
        text.splice(at..end, insert.chars());
        if truncates {
            text.truncate(at);
        } else if other % 4 == 0 {
            text.extend(scenes[other % scenes.len()].chars());
        }
        let text: String = text.into_iter().collect();
        assert_scene_or_message(&text);
    }

    /// Replacing any value by any other, in shipped and resolved scenes, gives a scene or an error message, never a
    /// panic.
    #[test]
    fn swapped_values_never_panic(
        scene_index in 0usize..100, shown in proptest::bool::ANY, line in 0usize..200, value in 0usize..100,
    ) {
        let values = [
            "0", "-1", "1e300", "nan", "inf", "\"\"", "\"1e-300 mm\"", "\"1e300 mm\"", "\"1e308 deg\"", "\"-0 s\"", "true",
            "[]", "{}", "[[]]", "[\"1 m\", 2]", "{ mass = 1 }", "1979-05-27T07:32:00Z", "9223372036854775808",
            "\"1e-300 N*m\"", "\"1e300 N*m\"", "\"5e-324 kg\"", "5e-324", "1.7e308", "\"1e300 kg\"",
            "[\"1e300 m\", \"1e300 m\"]", "\"driven\"", "\"fixed\"", "\"finger\"", "\"rapier\"", "[\"nan m/s\", \"0 m/s\"]",
        ];
        let mut scenes = shipped_texts();
        // Half of all cases.
        scenes.extend(vec![DISCS.to_string(); scenes.len()]);
        let text = &scenes[scene_index % scenes.len()];
        let text = if shown { show(&parse(text)) } else { text.clone() };
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        let count = lines.len();
        let target = &mut lines[line % count];
        if let Some((key, _)) = target.split_once(" = ") {
            *target = format!("{key} = {}", values[value % values.len()]);
        }
        assert_scene_or_message(&lines.join("\n"));
    }
}
