//! Step-size study on its shipped scene (thesis Fig. B.3).

use phalanx::format::ToReport;
use phalanx::report::step_size::step_size_csv;
use phalanx::scene;
use phalanx::study::step_size::{Formulation, StepSize, step_size};

fn study() -> StepSize {
    let scene = scene::load_any("scenes/laws/step-size.toml").unwrap_or_else(|error| panic!("{error}"));
    step_size(&scene, true, &mut |_, _, _| {}, &|| true).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn contact_laws_converge_and_rigid_contact_does_not() {
    let study = study();
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
    assert!(
        rows_of(Formulation::Analytic).next_back().is_some_and(|row| row.curve_max_error < 1e-6 && row.steps < 200)
    );

    let json: serde_json::Value = serde_json::from_str(&study.json()).expect("JSON");
    assert_eq!(json["rows"].as_array().map(Vec::len), Some(study.rows.len()));
    assert!(json["rows"][0]["step_s"].as_f64().is_some() && json["peak_n"].as_f64().is_some());
    assert_eq!(step_size_csv(&study).lines().count(), study.rows.len() + 1);
    assert!(study.report().to_string().contains("never"));
}

#[test]
fn rejects_scenes_without_a_rebound() {
    let text = "kind = \"bodies\"\n[discs.ball]\nradius = \"1 mm\"\ncentre = [\"0 mm\", \"9 mm\"]\nmass = \"1 g\"\n";
    let scene = scene::parse_any(text, "still.toml").expect("a scene");
    let error = step_size(&scene, true, &mut |_, _, _| {}, &|| true).expect_err("no contact");
    assert!(error.to_string().contains("rebounds"), "{error}");
}
