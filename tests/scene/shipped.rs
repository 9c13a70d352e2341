//! The shipped scenes load, resolve as documented, and round-trip exactly. Damaged scenes cause no panic.

use std::fs;
use std::path::Path;

use phalanx::scene;
use proptest::prelude::*;

use super::common::{assert_round_trip, assert_scene_or_message, parse};
use crate::support::cli::{EXPERIMENT_95, assert_status, stdout, succeed, succeed_silently};

fn shipped_scenes() -> Vec<(String, String)> {
    scenes_in("scenes")
}

/// Paths and texts of the scenes in a directory.
fn scenes_in(directory: &str) -> Vec<(String, String)> {
    let mut files: Vec<_> = fs::read_dir(directory)
        .expect("scenes")
        .map(|entry| entry.expect("entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files.into_iter().map(|path| (path.display().to_string(), fs::read_to_string(&path).expect("text"))).collect()
}

#[test]
fn anchor_has_the_lengths_masses_and_start_of_design_95() {
    // Expected values: 1-model §1.3 and §1.8.
    let anchor = scene::load("scenes/experiment-95.toml").unwrap_or_else(|e| panic!("{e}"));
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
        for (file, text) in scenes_in(directory) {
            let stem = Path::new(&file).file_stem().expect("a name").to_string_lossy().into_owned();
            let is_gripper = directory != "scenes";
            if directory == "scenes/hard" && !stem.contains("gripper") {
                continue;
            }
            assert!(text.starts_with("# ") && text.contains("\n# Expect: "), "{file}");
            let scene = scene::load_any(&file).unwrap_or_else(|e| panic!("{e}"));
            let prefix = if is_gripper && !stem.starts_with("gripper-") { "gripper-" } else { "" };
            assert_eq!(scene.name, format!("{prefix}{stem}"));
            assert!(if is_gripper { !scene.description.is_empty() } else { scene.source == text }, "{file}");
            assert_round_trip(&scene);
            count += 1;
        }
    }
    assert!(count >= 25, "{count}");
}

#[test]
fn every_variant_round_trips_exactly() {
    let finger = "[design]\nbase = \"15.5 mm\"\nl21_fraction = 0.7\nphi22 = \"110 deg\"\narm_ratio = 0.5\n";
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
        "[engine]\nconstruction = \"reduced\"\nlaw = \"rapier\"\nrestitution = 0.1\nstepping = \"fixed\"\n\
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
    for line in [
        "[design]",
        "base = \"15.5 mm\"",
        "l21_fraction = 1.0",
        "height_ratio = 0.9375",
        "# l12 = \"22.3628 mm\"",
        "offset = \"25.0 deg\"",
    ] {
        let is_shown = shown.lines().any(|output| output == line);
        assert!(is_shown || line.starts_with("offset") && shown.contains("\noffset = \"25 deg\""), "{line}\n{}", shown);
    }
    assert!(!shown.contains("e-19") && !shown.contains("\n[lengths]"), "{}", shown);
    let resolved = succeed(&[&show[..], &["--resolved"]].concat());
    assert!(resolved.contains("\n[lengths]") && !resolved.contains("[design]"));
    assert_round_trip(&parse(&resolved));

    let files = ["scene", "check", "scenes/free-swing.toml", "tests/broken/unit-missing.toml"];
    let checked = assert_status(&files, 2, &["error: `design.base`: `15.5` has no unit"]);
    assert!(stdout(&checked).starts_with("scenes/free-swing.toml: valid: l11 15.00"));

    let schema = succeed(&["scene", "schema"]);
    assert!(schema.starts_with('{') && schema.ends_with("}\n"));
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
        let scenes = shipped_scenes();
        let mut text: Vec<char> = scenes[scene_index % scenes.len()].1.chars().collect();
        let at = cut % (text.len() + 1);
        let end = (at + length).min(text.len());
        text.splice(at..end, insert.chars());
        if truncates {
            text.truncate(at);
        } else if other % 4 == 0 {
            text.extend(scenes[other % scenes.len()].1.chars());
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
            "[\"1e300 m\", \"1e300 m\"]", "\"driven\"", "\"fixed\"", "\"finger\"", "\"reduced\"", "[\"nan m/s\", \"0 m/s\"]",
        ];
        let mut scenes = shipped_scenes();
        let discs = (DISCS.to_string(), DISCS.to_string());
        // Half of all cases.
        scenes.extend(vec![discs; scenes.len()]);
        let text = &scenes[scene_index % scenes.len()].1;
        let text = if shown { scene::show(&parse(text)) } else { text.clone() };
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        let count = lines.len();
        let target = &mut lines[line % count];
        if let Some((key, _)) = target.split_once(" = ") {
            *target = format!("{key} = {}", values[value % values.len()]);
        }
        assert_scene_or_message(&lines.join("\n"));
    }
}
