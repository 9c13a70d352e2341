//! The map of stability on the anchor: known verdicts, files that agree with one another, refusals.

use std::fs;

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, variant, write};
use phalanx::report::stability::stability_csv;
use phalanx::scene;
use phalanx::study::stability::{Grid, Stability, StudyError, Verdict, stability};
use phalanx::wording::Reported;
use serde_json::Value;

fn grid(steps_s: &[f64], stiffness: &[f64], damping: &[f64]) -> Grid {
    Grid { steps_s: steps_s.to_vec(), stiffness_factors: stiffness.to_vec(), damping_factors: damping.to_vec() }
}

fn map(grid: &Grid) -> Stability {
    let scene = scene::load(ANCHOR).unwrap_or_else(|error| panic!("{error}"));
    stability(&scene, grid, 1e-3, &mut |_, _, _| {}, &|| true).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn verdicts_of_the_anchor() {
    let study = map(&grid(&[1e-3, 1e-4, 1e-5], &[1.0], &[1.0]));
    let [long, usual, short] = &study.cells[..] else { panic!("three cells") };
    assert_eq!(
        (long.verdict, usual.verdict, short.verdict),
        (Verdict::Inaccurate, Verdict::Accurate, Verdict::Accurate)
    );
    let error = |cell: &phalanx::study::stability::Cell| cell.angle_error_rad.expect("an error");
    assert!(error(long) > 1e-2 && error(long) < 1.0, "{}", error(long));
    assert!(error(short) < 3e-4 && error(short) < error(usual), "{}", error(short));
    assert_eq!((long.steps, usual.steps, short.steps), (20, 200, 2000));
    assert!(study.cells.iter().all(|cell| cell.energy_created < 0.1 && cell.reason.is_none() && cell.loop_gap_m > 0.0));
    let reference = study.reference(0, 0);
    assert_eq!((reference.touchdowns, &reference.reason), ([1, 1], &None));
    assert!(reference.sensitivity_rad.is_some_and(|rad| rad > 0.0 && rad < 1e-7));
}

/// At 20 steps a run a phalanx ends a step far inside the object; a spring a hundred times as stiff then holds more energy
/// there than the motor ever gave.
#[test]
fn a_long_step_into_a_stiff_contact_fails() {
    let study = map(&grid(&[1e-3, 3e-4], &[1e2], &[1.0]));
    let [long, short] = &study.cells[..] else { panic!("two cells") };
    assert_eq!((long.verdict, short.verdict), (Verdict::Failed, Verdict::Inaccurate));
    assert!(long.energy_created > 0.1 && long.reason.as_ref().is_some_and(|reason| reason.contains("energy created")));
    assert!(short.energy_created < 0.1 && short.reason.is_none());
}

/// Each pair of factors has a reference of its own, and the scene's own factors are those of the scene.
#[test]
fn factors_change_the_contact() {
    let study = map(&grid(&[1e-5], &[1e-2, 1.0], &[0.0, 1.0]));
    assert_eq!(study.references.iter().map(|of| of.stiffness_factor).collect::<Vec<_>>(), [1e-2, 1.0, 1e-2, 1.0]);
    assert_eq!(study.references.iter().map(|of| of.damping_factor).collect::<Vec<_>>(), [0.0, 0.0, 1.0, 1.0]);
    // Without a damper the finger bounces.
    assert!(study.reference(1, 0).touchdowns[0] > 1 && study.reference(1, 1).touchdowns[0] == 1);
    let mut scene = scene::load(ANCHOR).expect("the anchor");
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= 1e-2;
    }
    let one = grid(&[1e-5], &[1.0], &[1.0]);
    let soft = stability(&scene, &one, 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(soft.cells[0].angle_error_rad, study.cell(0, 0, 1).angle_error_rad);
    assert_ne!(soft.cells[0].angle_error_rad, study.cell(0, 1, 1).angle_error_rad);
}

#[test]
fn maps_repeat_apart_from_wall_times() {
    let grid = grid(&[1e-3, 1e-4], &[1.0, 1e2], &[0.0, 1.0]);
    let timeless = || {
        let mut study = map(&grid);
        study.wall_s = 0.0;
        study.cells.iter_mut().for_each(|cell| cell.wall_s = 0.0);
        study.references.iter_mut().for_each(|of| of.wall_s = 0.0);
        study
    };
    assert_eq!(timeless(), timeless());
}

#[test]
fn tables_json_csv_and_picture_say_the_same() {
    let study = map(&grid(&[1e-3, 1e-4], &[1.0, 1e2], &[0.0, 1.0]));
    let document: Value = serde_json::from_str(&study.json()).expect("JSON");
    let cells = document["cells"].as_array().expect("a list");
    let csv = stability_csv(&study);
    let lines: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.splitn(13, ',').collect()).collect();
    let text = study.report().to_string();
    let picture = phalanx::plot::stability(&study);
    assert_eq!((cells.len(), lines.len()), (8, 8));
    for (cell, line) in cells.iter().zip(&lines) {
        let number = |key: &str| cell[key].as_f64().unwrap_or_else(|| panic!("{key} of {cell}"));
        for (column, key) in [
            (0, "step_s"),
            (1, "stiffness_factor"),
            (2, "damping_factor"),
            (4, "angle_error_rad"),
            (5, "energy_created_j"),
            (6, "energy_created"),
            (7, "energy_balance"),
            (8, "loop_gap_m"),
            (9, "steps"),
            (10, "contact_substeps"),
            (11, "wall_s"),
        ] {
            // The reader of JSON, as it is set up here, may miss the last bit of a number.
            let (csv, json) = (line[column].parse::<f64>().expect("a number"), number(key));
            assert!((csv - json).abs() <= 2.0 * f64::EPSILON * json.abs(), "{key}: {csv:e} {json:e}");
        }
        assert_eq!(cell["verdict"], line[3]);
        let short = format!("{:.1e}", number("angle_error_rad"));
        assert!(picture.contains(&short.replace('-', "−")), "{short}");
        match line[3] {
            "accurate" => assert!(text.contains(&format!(" {short}")), "{short} in\n{text}"),
            "inaccurate" => assert!(text.contains(&format!("({short})")), "{short} in\n{text}"),
            "failed" => assert!(text.contains(cell["reason"].as_str().expect("a reason"))),
            other => panic!("{other} of {cell}"),
        }
    }
    let count = |verdict: &str| cells.iter().filter(|cell| cell["verdict"] == verdict).count();
    let [accurate, inaccurate, failed] = ["accurate", "inaccurate", "failed"].map(count);
    let counts =
        format!("8 cells: {accurate} stable, accurate, {inaccurate} stable, inaccurate, {failed} failed, 0 not");
    assert!(text.contains(&counts), "{counts} in\n{text}");
}

#[test]
fn a_reference_without_an_end_is_said_and_not_judged() {
    let mut scene = scene::load(ANCHOR).expect("the anchor");
    scene.integrator.max_steps = 10;
    let study = stability(&scene, &grid(&[1e-4], &[1.0], &[1.0]), 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(study.cells[0].verdict, Verdict::NotJudged);
    assert!(study.references[0].reason.as_ref().is_some_and(|reason| reason.contains("budget of 10 steps")));
    assert!(study.report().to_string().contains("the reference could not be completed"));
    // Too small a budget of the engine is no failure either.
    let mut scene = scene::load(ANCHOR).expect("the anchor");
    scene.engine.max_steps = 10;
    let study = stability(&scene, &grid(&[1e-4], &[1.0], &[1.0]), 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(study.cells[0].verdict, Verdict::NotJudged);
    assert!(study.cells[0].reason.as_ref().is_some_and(|reason| reason.contains("budget")), "{:?}", study.cells[0]);
}

#[test]
fn it_stops_when_it_is_told_to() {
    let scene = scene::load(ANCHOR).expect("the anchor");
    let result = stability(&scene, &Grid::usual(false), 1e-3, &mut |_, _, _| {}, &|| false);
    assert!(matches!(result, Err(StudyError::Stopped { total: 128, .. })), "{result:?}");
}

#[test]
fn the_command_writes_its_files() {
    let out = directory("study_stability");
    let path = out.to_str().expect("text");
    let args =
        ["study", "stability", ANCHOR, "--steps", "100 us,1 ms", "--stiffness", "1", "--damping", "1", "--out", path];
    let output = phalanx(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stdout(&output), fs::read_to_string(out.join("table.txt")).expect("a table"));
    let document: Value =
        serde_json::from_str(&fs::read_to_string(out.join("stability.json")).expect("JSON")).expect("JSON");
    assert_eq!(document["grid"]["steps_s"], serde_json::json!([1e-3, 1e-4]));
    assert_eq!(fs::read_to_string(out.join("stability.csv")).expect("CSV").lines().count(), 3);
    assert!(fs::read_to_string(out.join("stability.svg")).expect("SVG").starts_with("<svg"));
    // A bound of one's own moves the border.
    let strict = json(&phalanx(&[&args[..9], &["--accurate", "1e-6 rad", "--json"]].concat()));
    assert_eq!(strict["cells"][1]["verdict"], "inaccurate");
    assert_eq!(document["cells"][1]["verdict"], "accurate");
}

#[test]
fn what_cannot_be_mapped_is_refused() {
    let directory = directory("study_stability_refused");
    let discs = "scenes/laws/step-size.toml";
    let rigid = variant(&directory, "rigid.toml", "[engine]\nlaw = \"rapier\"\nstepping = \"fixed\"\nstep = \"10 us\"");
    let anchor = fs::read_to_string(ANCHOR).expect("the anchor");
    let undamped = write(
        &directory,
        "undamped.toml",
        &anchor.replace("[contact.friction]", "[contact]\nstiffness_si = 0\nexponent = 2.2\n[contact.friction]"),
    );
    let cases: [(&[&str], &str); 13] = [
        (&[discs], "scene of discs"),
        (&["scenes/gripper/design-95.toml"], "scene of a gripper"),
        (&["scenes/free-swing.toml"], "nothing can touch"),
        (&[&rigid], "rapier's own contact"),
        (&[&undamped, "--damping", "0"], "one of them above 0"),
        (&[ANCHOR, "--steps", "1e-3"], "no unit"),
        (&[ANCHOR, "--steps", "20 ms"], "not shorter than the run"),
        (&[ANCHOR, "--steps", "1e-300 s"], "takes more than 10000000 steps; give longer steps"),
        (&[ANCHOR, "--stiffness", "0,1"], "above 0"),
        (&[ANCHOR, "--stiffness", "1e301"], "must be finite"),
        (&[ANCHOR, "--damping=-1"], "from 0"),
        (&[ANCHOR, "--damping", "1,1"], "twice"),
        (&[ANCHOR, "--accurate", "0 rad"], "more than 0"),
    ];
    for (args, message) in cases {
        let output = phalanx(&[&["study", "stability"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stdout(&output));
        let flat = stderr(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(message), "{args:?}: {flat}");
    }
}
