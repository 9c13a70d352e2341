//! Stability map of the reference scene, and step-size study of the shipped scene (thesis Fig. B.3).

use phalanx_core::scene::{self, Scene};
use phalanx_parallel::{ComputeError, Monitor};
use phalanx_show::format::ToReport;
use phalanx_thesis::stability::{Cell, Grid, Stability, Verdict, stability};
use phalanx_thesis::step_size::{Formulation, step_size};
use serde_json::Value;

fn experiment() -> Scene {
    scene::parse(include_str!("../../../scenes/experiment-95.toml"), "experiment-95.toml").expect("a scene")
}

fn grid(steps_s: &[f64], stiffness: &[f64], damping: &[f64]) -> Grid {
    Grid { steps_s: steps_s.to_vec(), stiffness_factors: stiffness.to_vec(), damping_factors: damping.to_vec() }
}

fn map_of(scene: &Scene, grid: &Grid) -> Stability {
    stability(scene, grid, 1e-3, &Monitor::silent(&|| true)).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn reference_scene_has_known_verdicts() {
    let study = map_of(&experiment(), &grid(&[1e-3, 1e-4, 1e-5], &[1.0], &[1.0]));
    let verdicts: Vec<Verdict> = study.cells.iter().map(|cell| cell.verdict).collect();
    assert_eq!(verdicts, [Verdict::Inaccurate, Verdict::Accurate, Verdict::Accurate]);
    let [long, standard, short] = [0, 1, 2].map(|index: usize| study.cells[index].angle_error_rad.expect("an error"));
    assert!(long > 1e-2 && long < 1.0 && short < 3e-4 && short < standard, "{long} {standard} {short}");
    assert!(study.cells.iter().map(|cell| cell.steps).eq([20, 200, 2000]));
    assert!(study.cells.iter().all(|cell| cell.energy_created < 0.1 && cell.reason.is_none() && cell.loop_gap_m > 0.0));
    let reference = study.reference(0, 0);
    assert_eq!((reference.touchdowns, &reference.reason), ([1, 1], &None));
    assert!(reference.sensitivity_rad.is_some_and(|rad| rad > 0.0 && rad < 1e-7));
}

/// With 20 steps per run, a phalanx penetrates deep into the object within one step. A contact spring of a hundred times the stiffness
/// then stores more energy than the motor has supplied.
#[test]
fn long_step_with_a_stiff_contact_fails() {
    let study = map_of(&experiment(), &grid(&[1e-3, 3e-4], &[1e2], &[1.0]));
    let [long, short] = &study.cells[..] else { panic!("two cells") };
    assert_eq!((long.verdict, short.verdict), (Verdict::Failed, Verdict::Inaccurate));
    assert!(long.energy_created > 0.1 && long.reason.as_ref().is_some_and(|reason| reason.contains("energy created")));
    assert!(short.energy_created < 0.1 && short.reason.is_none());
}

/// Each pair of factors has its own reference, and factors of 1 leave the scene unchanged.
#[test]
fn factors_scale_the_contact_law() {
    let study = map_of(&experiment(), &grid(&[1e-5], &[1e-2, 1.0], &[0.0, 1.0]));
    let factors = study.references.iter().map(|reference| (reference.stiffness_factor, reference.damping_factor));
    assert!(factors.eq([(1e-2, 0.0), (1.0, 0.0), (1e-2, 1.0), (1.0, 1.0)]));
    // The finger bounces without damping.
    assert!(study.reference(1, 0).touchdowns[0] > 1 && study.reference(1, 1).touchdowns[0] == 1);
    let mut scene = experiment();
    for contact in scene.finger_mut().contact.both_mut() {
        contact.normal.stiffness_n_per_m_e *= 1e-2;
    }
    let soft = map_of(&scene, &grid(&[1e-5], &[1.0], &[1.0]));
    assert_eq!(soft.cells[0].angle_error_rad, study.cell(0, 0, 1).angle_error_rad);
    assert_ne!(soft.cells[0].angle_error_rad, study.cell(0, 1, 1).angle_error_rad);
}

/// Maps are reproducible except for wall times, and all formats agree.
#[test]
fn report_json_csv_and_plot_agree() {
    let grid = grid(&[1e-3, 1e-4], &[1.0, 1e2], &[0.0, 1.0]);
    let without_times = |study: &Stability| {
        let mut study = study.clone();
        study.wall_s = 0.0;
        study.cells.iter_mut().for_each(|cell| cell.wall_s = 0.0);
        study.references.iter_mut().for_each(|reference| reference.wall_s = 0.0);
        study
    };
    let study = map_of(&experiment(), &grid);
    assert_eq!(without_times(&study), without_times(&map_of(&experiment(), &grid)));

    let document: Value = serde_json::from_str(&study.json()).expect("JSON");
    let cells = document["cells"].as_array().expect("a list");
    let (csv, text, picture) = (study.csv(), study.report().to_string(), study.picture());
    let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.splitn(13, ',').collect()).collect();
    assert_eq!((cells.len(), lines.len()), (8, 9));
    for (cell, line) in cells.iter().zip(&lines[1..]) {
        for (key, value) in lines[0].iter().zip(line) {
            match &cell[key] {
                Value::Null => assert_eq!(*value, "", "{key}"),
                Value::String(text) => assert_eq!(value.trim_matches('"'), text, "{key}"),
                // The JSON parser may be wrong in the last bit of a number.
                number => {
                    let (csv, json) = (value.parse::<f64>().expect("a number"), number.as_f64().expect("a number"));
                    assert!((csv - json).abs() <= 2.0 * f64::EPSILON * json.abs(), "{key}: {csv:e} {json:e}");
                }
            }
        }
        let rounded = format!("{:.1e}", cell["angle_error_rad"].as_f64().expect("a number"));
        assert!(picture.contains(&rounded.replace('-', "−")), "{rounded}");
        let in_text = match cell["verdict"].as_str() {
            Some("accurate") => format!(" {rounded}"),
            Some("inaccurate") => format!("({rounded})"),
            _ => cell["reason"].as_str().expect("a reason").to_string(),
        };
        assert!(text.contains(&in_text), "{in_text} in\n{text}");
    }
    let [accurate, inaccurate, failed] = ["accurate", "inaccurate", "failed"]
        .map(|verdict| cells.iter().filter(|cell| cell["verdict"] == verdict).count());
    let counts =
        format!("8 cells: {accurate} stable, accurate, {inaccurate} stable, inaccurate, {failed} failed, 0 not");
    assert!(text.contains(&counts), "{counts} in\n{text}");
}

/// Neither an incomplete reference nor a step budget that is too small is a failure.
#[test]
fn cells_without_a_comparison_are_not_judged() {
    let (mut short_reference, mut short_run) = (experiment(), experiment());
    short_reference.integrator.max_steps = 10;
    short_run.engine.max_steps = 10;
    let reason = |cell: &Cell| cell.reason.clone().unwrap_or_default();
    for (scene, message) in [(short_reference, "the reference could not be completed"), (short_run, "budget")] {
        let study = map_of(&scene, &grid(&[1e-4], &[1.0], &[1.0]));
        assert_eq!(study.cells[0].verdict, Verdict::NotJudged);
        assert!(reason(&study.cells[0]).contains(message), "{:?}", study.cells[0]);
        assert!(study.report().to_string().contains("budget of 10 steps"));
    }
}

#[test]
fn map_can_be_interrupted() {
    let result = stability(&experiment(), &Grid::standard(false), 1e-3, &Monitor::silent(&|| false));
    assert!(matches!(result, Err(ComputeError::Stopped { total: 128, .. })), "{result:?}");
}

#[test]
fn contact_laws_converge_and_rigid_contact_does_not() {
    let scene = scene::parse_any(include_str!("../../../scenes/laws/step-size.toml"), "step-size.toml");
    let study = step_size(&scene.expect("a scene"), true, &Monitor::silent(&|| true)).expect("a study");
    let rows_of = |formulation| study.rows.iter().filter(move |row| row.formulation == formulation);
    let laws: Vec<_> = rows_of(Formulation::EngineLaws).collect();
    assert_eq!(laws.len(), 5);
    assert!(laws.windows(2).all(|pair| pair[1].curve_rms_error < pair[0].curve_rms_error));
    assert!(laws[4].curve_max_error < 1e-3 && laws[4].peak_error < 1e-5 && laws[4].restitution_error < 1e-4);
    // The impulse divided by the step grows without bound as the step shrinks.
    let rigid: Vec<_> = rows_of(Formulation::EngineRapier).collect();
    assert!(rigid.windows(2).all(|pair| pair[1].peak_error > pair[0].peak_error) && rigid[4].peak_error > 100.0);
    assert!(rigid.iter().all(|row| row.restitution_error < 1e-9));
    for crossing in &study.crossings {
        let step_fraction = crossing.step_fraction;
        match crossing.formulation {
            Formulation::EngineRapier => assert_eq!(step_fraction, None, "{crossing:?}"),
            Formulation::EngineLaws if crossing.error < 1e-3 => {}
            _ => assert!(step_fraction.is_some_and(|fraction| fraction > 1e-4 && fraction < 1.0), "{crossing:?}"),
        }
    }
    let finest = rows_of(Formulation::Analytic).next_back();
    assert!(finest.is_some_and(|row| row.curve_max_error < 1e-6 && row.steps < 200));

    let json: Value = serde_json::from_str(&study.json()).expect("JSON");
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(study.rows.len()));
    assert!(json["rows"][0]["step_s"].as_f64().is_some() && json["peak_n"].as_f64().is_some());
    assert_eq!(study.csv().lines().count(), study.rows.len() + 1);
    assert!(study.report().to_string().contains("never"));
}

#[test]
fn rejects_scenes_without_a_rebound() {
    let text = "kind = \"bodies\"\n[discs.ball]\nradius = \"1 mm\"\ncentre = [\"0 mm\", \"9 mm\"]\nmass = \"1 g\"\n";
    let scene = scene::parse_any(text, "still.toml").expect("a scene");
    let error = step_size(&scene, true, &Monitor::silent(&|| true)).expect_err("no contact");
    assert!(matches!(&error, ComputeError::Unsuitable(text) if text.contains("rebounds")), "{error}");
}
