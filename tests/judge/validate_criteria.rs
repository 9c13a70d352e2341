//! `validate` compares what both runs are judged by: where they disagree, the verdict is no.

use phalanx::check;
use phalanx::criteria::{Class, Fate, Judged};
use phalanx::scene::{self, Scene};
use phalanx::trace::Model;
use phalanx::validate::{
    Check, Criterion, Recording, Value, checks, criteria, record, reference, sampled, unjudged, validate,
};

/// Both runs of a scene.
fn runs(file: &str) -> (Scene, [Recording; 2]) {
    let scene = scene::load_any(file).unwrap_or_else(|error| panic!("{error}"));
    let analytic = record(Model::Analytic, &reference(&scene)).expect("runs");
    let engine = record(Model::Engine, &sampled(Model::Engine, &scene)).expect("runs");
    (scene, [analytic, engine])
}

/// The bounds that fail once the engine's run is judged otherwise.
fn broken(scene: &Scene, [analytic, engine]: &[Recording; 2], change: impl FnOnce(&mut Judged)) -> Vec<&'static str> {
    let mut engine = engine.clone();
    change(engine.judged.as_mut().expect("judged"));
    let checks = checks(&criteria(scene, analytic, &engine));
    checks.iter().filter(|check| !check.passed()).map(|check| check.bound).collect()
}

#[test]
fn class_and_time_to_stability_of_a_finger() {
    let (scene, runs) = runs("scenes/experiment-95.toml");
    assert_eq!(broken(&scene, &runs, |_| {}), [""; 0]);
    let finger = |change: fn(&mut phalanx::criteria::Criteria)| {
        broken(&scene, &runs, |judged| change(judged.criteria.as_mut().expect("a finger")))
    };
    assert_eq!(finger(|found| found.class = Class::SemiStable), ["class"]);
    assert_eq!(finger(|found| found.tts_s = found.tts_s.map(|tts_s| tts_s + 9e-6)), [""; 0]);
    assert_eq!(finger(|found| found.tts_s = found.tts_s.map(|tts_s| tts_s + 11e-6)), ["stability_time_s"]);
    assert_eq!(finger(|found| found.tts_s = None), ["stability_time_s"]);
}

#[test]
fn fate_closure_and_losses_of_a_gripper() {
    let (scene, runs) = runs("scenes/gripper/hold.toml");
    assert_eq!(broken(&scene, &runs, |_| {}), [""; 0]);
    let grasp = |change: fn(&mut phalanx::criteria::GraspCriteria)| {
        broken(&scene, &runs, |judged| change(judged.grasp.as_mut().expect("a gripper")))
    };
    // Dropped in one model, and held for good from 85.57 instead of 7.3 ms on: both were "within all bounds".
    assert_eq!(grasp(|found| found.fate = Fate::Dropped { since_s: 0.05 }), ["fate"]);
    assert_eq!(grasp(|found| found.tts_s = Some(85.57e-3)), ["stability_time_s"]);
    assert_eq!(grasp(|found| found.contacts[0].times_lost += 1), [""; 0]);
    assert_eq!(grasp(|found| found.contacts[0].times_lost += 3), ["contacts_lost"]);
    assert_eq!(grasp(|found| found.contacts[4].lost_s += 0.021 * 60e-3), ["lost_time"]);
    // Another last sample: nothing presses, so nothing is closed.
    let mut open = runs[1].clone();
    open.outcome.last.contacts.iter_mut().for_each(|contact| contact.normal_n = 0.0);
    let checks = checks(&criteria(&scene, &runs[0], &open));
    let failed: Vec<&str> = checks.iter().filter(|check| !check.passed()).map(|check| check.bound).collect();
    assert_eq!(failed, ["form_closed"]);
}

#[test]
fn restitution_of_every_pair_that_has_one() {
    let (scene, runs) = runs("scenes/laws/radii.toml");
    let found = criteria(&scene, &runs[0], &runs[1]);
    let names: Vec<&str> = found.iter().map(|found| found.of.as_str()).collect();
    assert_eq!(names, ["large-target", "medium-target", "small-target"]);
    for Criterion { bound, analytic, difference, .. } in &found {
        assert_eq!(*bound, "restitution");
        let Value::Figure(Some(restitution)) = analytic else { panic!("{analytic:?}") };
        assert!((restitution - 0.8862).abs() < 1e-4 && *difference < 1e-4, "{restitution}, {difference}");
    }
    assert_eq!(broken(&scene, &runs, |_| {}), [""; 0]);
    let faster = |judged: &mut Judged| {
        let pair = judged.rebounds.iter_mut().find(|pair| pair.separation_m_s.is_some()).expect("an impact");
        pair.separation_m_s = pair.separation_m_s.map(|speed| 0.98 * speed);
    };
    assert_eq!(broken(&scene, &runs, faster), ["restitution"]);
    // One model has none.
    let none = |judged: &mut Judged| judged.rebounds.iter_mut().for_each(|pair| pair.separation_m_s = None);
    assert_eq!(broken(&scene, &runs, none), ["restitution"]);
}

#[test]
fn where_two_right_runs_may_differ_criteria_are_shown_and_not_judged() {
    let sure = |verdict: check::Verdict| check::Check {
        verdict,
        errors: check::Errors::default(),
        sensitivity: 0.0,
        bar: 1.0,
        bar_of: String::new(),
        motion: None,
        energy_bar: 1.0,
        against: String::new(),
        reason: None,
    };
    let (mut scene, _) = runs("scenes/experiment-95.toml");
    assert_eq!(unjudged(&scene, &sure(check::Verdict::Sure)), None);
    assert_eq!(unjudged(&scene, &sure(check::Verdict::Chaotic)), Some("the outcome is chaotic"));
    scene.bounds.until_s = 0.5 * scene.duration_s;
    assert_eq!(unjudged(&scene, &sure(check::Verdict::Sure)), Some("the runs are not compared to their end"));
    let found = validate(&scene, &|| true).expect("a validation");
    let is_criterion = |check: &&Check| ["class", "stability_time_s"].contains(&check.bound);
    assert!(found.unjudged.is_some() && found.criteria.len() == 2);
    assert_eq!(found.verdict.checks.iter().find(is_criterion), None);
}
