//! Stability map of the reference scene: known verdicts, consistent output files, rejected scenes.

use std::fs;

use crate::support::cli::{EXPERIMENT_95, directory, json, phalanx, stderr, stdout, variant, write};
use phalanx::format::ToReport;
use phalanx::report::stability::stability_csv;
use phalanx::scene;
use phalanx::study::stability::{Grid, Stability, StudyError, Verdict, stability};
use serde_json::Value;

fn grid(steps_s: &[f64], stiffness: &[f64], damping: &[f64]) -> Grid {
    Grid { steps_s: steps_s.to_vec(), stiffness_factors: stiffness.to_vec(), damping_factors: damping.to_vec() }
}

fn map(grid: &Grid) -> Stability {
    let scene = scene::load(EXPERIMENT_95).unwrap_or_else(|error| panic!("{error}"));
    stability(&scene, grid, 1e-3, &mut |_, _, _| {}, &|| true).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn reference_scene_has_known_verdicts() {
    let study = map(&grid(&[1e-3, 1e-4, 1e-5], &[1.0], &[1.0]));
    let [long, standard, short] = &study.cells[..] else { panic!("three cells") };
    assert_eq!(
        (long.verdict, standard.verdict, short.verdict),
        (Verdict::Inaccurate, Verdict::Accurate, Verdict::Accurate)
    );
    let error = |cell: &phalanx::study::stability::Cell| cell.angle_error_rad.expect("an error");
    assert!(error(long) > 1e-2 && error(long) < 1.0, "{}", error(long));
    assert!(error(short) < 3e-4 && error(short) < error(standard), "{}", error(short));
    assert_eq!((long.steps, standard.steps, short.steps), (20, 200, 2000));
    assert!(study.cells.iter().all(|cell| cell.energy_created < 0.1 && cell.reason.is_none() && cell.loop_gap_m > 0.0));
    let reference = study.reference(0, 0);
    assert_eq!((reference.touchdowns, &reference.reason), ([1, 1], &None));
    assert!(reference.sensitivity_rad.is_some_and(|rad| rad > 0.0 && rad < 1e-7));
}

/// With 20 steps per run, a phalanx penetrates deep into the object within one step. A contact spring of a hundred times the stiffness
/// then stores more energy than the motor has supplied.
#[test]
fn long_step_with_a_stiff_contact_fails() {
    let study = map(&grid(&[1e-3, 3e-4], &[1e2], &[1.0]));
    let [long, short] = &study.cells[..] else { panic!("two cells") };
    assert_eq!((long.verdict, short.verdict), (Verdict::Failed, Verdict::Inaccurate));
    assert!(long.energy_created > 0.1 && long.reason.as_ref().is_some_and(|reason| reason.contains("energy created")));
    assert!(short.energy_created < 0.1 && short.reason.is_none());
}

/// Each pair of factors has its own reference, and factors of 1 leave the scene unchanged.
#[test]
fn factors_scale_the_contact_law() {
    let study = map(&grid(&[1e-5], &[1e-2, 1.0], &[0.0, 1.0]));
    assert_eq!(
        study.references.iter().map(|reference| reference.stiffness_factor).collect::<Vec<_>>(),
        [1e-2, 1.0, 1e-2, 1.0]
    );
    assert_eq!(
        study.references.iter().map(|reference| reference.damping_factor).collect::<Vec<_>>(),
        [0.0, 0.0, 1.0, 1.0]
    );
    // The finger bounces without damping.
    assert!(study.reference(1, 0).touchdowns[0] > 1 && study.reference(1, 1).touchdowns[0] == 1);
    let mut scene = scene::load(EXPERIMENT_95).expect("the reference scene");
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= 1e-2;
    }
    let single = grid(&[1e-5], &[1.0], &[1.0]);
    let soft = stability(&scene, &single, 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(soft.cells[0].angle_error_rad, study.cell(0, 0, 1).angle_error_rad);
    assert_ne!(soft.cells[0].angle_error_rad, study.cell(0, 1, 1).angle_error_rad);
}

#[test]
fn maps_are_reproducible_except_for_wall_times() {
    let grid = grid(&[1e-3, 1e-4], &[1.0, 1e2], &[0.0, 1.0]);
    let map_without_times = || {
        let mut study = map(&grid);
        study.wall_s = 0.0;
        study.cells.iter_mut().for_each(|cell| cell.wall_s = 0.0);
        study.references.iter_mut().for_each(|reference| reference.wall_s = 0.0);
        study
    };
    assert_eq!(map_without_times(), map_without_times());
}

#[test]
fn report_json_csv_and_plot_agree() {
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
            // The JSON parser may be wrong in the last bit of a number.
            let (csv, json) = (line[column].parse::<f64>().expect("a number"), number(key));
            assert!((csv - json).abs() <= 2.0 * f64::EPSILON * json.abs(), "{key}: {csv:e} {json:e}");
        }
        assert_eq!(cell["verdict"], line[3]);
        let rounded = format!("{:.1e}", number("angle_error_rad"));
        assert!(picture.contains(&rounded.replace('-', "−")), "{rounded}");
        match line[3] {
            "accurate" => assert!(text.contains(&format!(" {rounded}")), "{rounded} in\n{text}"),
            "inaccurate" => assert!(text.contains(&format!("({rounded})")), "{rounded} in\n{text}"),
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
fn cells_with_an_incomplete_reference_are_not_judged() {
    let mut scene = scene::load(EXPERIMENT_95).expect("the reference scene");
    scene.integrator.max_steps = 10;
    let study = stability(&scene, &grid(&[1e-4], &[1.0], &[1.0]), 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(study.cells[0].verdict, Verdict::NotJudged);
    assert!(study.references[0].reason.as_ref().is_some_and(|reason| reason.contains("budget of 10 steps")));
    assert!(study.report().to_string().contains("the reference could not be completed"));
    // A step budget of the engine that is too small is not a failure either.
    let mut scene = scene::load(EXPERIMENT_95).expect("the reference scene");
    scene.engine.max_steps = 10;
    let study = stability(&scene, &grid(&[1e-4], &[1.0], &[1.0]), 1e-3, &mut |_, _, _| {}, &|| true).expect("a map");
    assert_eq!(study.cells[0].verdict, Verdict::NotJudged);
    assert!(study.cells[0].reason.as_ref().is_some_and(|reason| reason.contains("budget")), "{:?}", study.cells[0]);
}

#[test]
fn study_can_be_interrupted() {
    let scene = scene::load(EXPERIMENT_95).expect("the reference scene");
    let result = stability(&scene, &Grid::standard(false), 1e-3, &mut |_, _, _| {}, &|| false);
    assert!(matches!(result, Err(StudyError::Stopped { total: 128, .. })), "{result:?}");
}

#[test]
fn command_writes_its_files() {
    let out = directory("study_stability");
    let path = out.to_str().expect("text");
    let args = [
        "study",
        "stability",
        EXPERIMENT_95,
        "--steps",
        "100 us,1 ms",
        "--stiffness",
        "1",
        "--damping",
        "1",
        "--out",
        path,
    ];
    let output = phalanx(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(fs::read_to_string(out.join("table.txt")).expect("a table").ends_with(stdout(&output)));
    let document: Value =
        serde_json::from_str(&fs::read_to_string(out.join("stability.json")).expect("JSON")).expect("JSON");
    assert_eq!(document["grid"]["steps_s"], serde_json::json!([1e-3, 1e-4]));
    assert_eq!(fs::read_to_string(out.join("stability.csv")).expect("CSV").lines().count(), 3);
    assert!(fs::read_to_string(out.join("stability.svg")).expect("SVG").starts_with("<svg"));
    // A stricter bound changes the verdict.
    let strict = json(&phalanx(&[&args[..9], &["--accurate", "1e-6 rad", "--json"]].concat()));
    assert_eq!(strict["cells"][1]["verdict"], "inaccurate");
    assert_eq!(document["cells"][1]["verdict"], "accurate");
}

#[test]
fn rejects_unsuitable_scenes_and_grids() {
    let directory = directory("study_stability_refused");
    let discs = "scenes/laws/step-size.toml";
    let rigid = variant(&directory, "rigid.toml", "[engine]\nlaw = \"rapier\"\nstepping = \"fixed\"\nstep = \"10 us\"");
    let anchor = fs::read_to_string(EXPERIMENT_95).expect("the reference scene");
    let undamped = write(
        &directory,
        "undamped.toml",
        &anchor.replace("[contact.friction]", "[contact]\nstiffness_si = 0\nexponent = 2.2\n[contact.friction]"),
    );
    let cases: [(&[&str], &str); 13] = [
        (&[discs], "scene of discs"),
        (&["scenes/gripper/design-95.toml"], "scene of a gripper"),
        (&["scenes/free-swing.toml"], "has no contacts"),
        (&[&rigid], "rapier's own contact"),
        (&[&undamped, "--damping", "0"], "one of them above 0"),
        (&[EXPERIMENT_95, "--steps", "1e-3"], "no unit"),
        (&[EXPERIMENT_95, "--steps", "20 ms"], "not shorter than the run"),
        (&[EXPERIMENT_95, "--steps", "1e-300 s"], "takes more than 10000000 steps; use longer steps"),
        (&[EXPERIMENT_95, "--stiffness", "0,1"], "above 0"),
        (&[EXPERIMENT_95, "--stiffness", "1e301"], "must be finite"),
        (&[EXPERIMENT_95, "--damping=-1"], "0 or more"),
        (&[EXPERIMENT_95, "--damping", "1,1"], "twice"),
        (&[EXPERIMENT_95, "--accurate", "0 rad"], "more than 0"),
    ];
    for (args, message) in cases {
        let output = phalanx(&[&["study", "stability"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stdout(&output));
        let flat = stderr(&output).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(message), "{args:?}: {flat}");
    }
}
