//! Samples, events and summaries that the recorder derives from the steps of the engine, for fingers and discs.

use phalanx::scene::Scene;
use phalanx::trace::{ContactSample, EventKind, FingerContact, Model};

use crate::support::laws::{self, BOTH_MODELS, disc, free_translation, impact_scene, mechanism, with_fixed_step};
use crate::support::runs::{assert_relative, experiment_95, load, run_engine, run_model, run_to_end};

/// A disc of 1 kg at rest on the half plane.
fn resting_disc(gravity_m_s2: f64) -> Scene {
    let discs = vec![disc("puck", 0.05, [0.0, 0.05], free_translation([0.0; 2]))];
    let mut scene = laws::scene_on_plane(discs, laws::THESIS_NORMAL, None, 1e-3);
    mechanism(&mut scene).gravity_m_s2 = [0.0, gravity_m_s2];
    scene
}

/// If surfaces are at rest in contact at the start and about to load, the run starts with a touch-down at zero approach
/// speed.
#[test]
fn a_loaded_start_at_rest_in_contact_is_a_touchdown_at_time_zero() {
    for model in BOTH_MODELS {
        for scene in [load("hard/start-in-contact"), resting_disc(-9.81)] {
            let (outcome, log) = run_model(model, &scene);
            let first = log.events[0];
            assert_eq!(
                (first.contact, first.kind),
                (FingerContact::Proximal as usize, EventKind::TouchDown),
                "{model:?}"
            );
            assert_eq!((first.time_s, first.approach_speed), (0.0, 0.0), "{model:?}");
            assert_eq!(outcome.contacts[0].touchdowns, 1, "{model:?}");
        }
        for gravity in [0.0, 9.81] {
            let (outcome, log) = laws::run_to_end(model, &resting_disc(gravity));
            assert!(log.events.is_empty() && outcome.contacts[0].first_s.is_none(), "{model:?} at {gravity} m/s²");
        }
    }
}

/// The first sample and the summary contain the contact forces before the first step.
#[test]
fn a_start_in_penetration_has_a_force_in_the_first_sample() {
    let scene = load("hard/start-in-penetration");
    let [(_, expected), (outcome, actual)] = [run_to_end(&scene), run_engine(&scene)];
    let [expected, actual] = [&expected, &actual].map(|log| log.samples[0].finger_contact(FingerContact::Proximal));
    assert!(expected.normal_n > 0.02, "{expected:?}");
    assert_relative(actual.normal_n, expected.normal_n, 1e-6, "force at the start");
    assert!(outcome.finger_contact(FingerContact::Proximal).peak_normal_n >= actual.normal_n);
}

/// At a touch-down within a step the gap is zero, its rate is the approach speed, and there is no force yet.
#[test]
fn samples_at_touchdowns_have_zero_gap_and_no_force() {
    let scenes = [
        (experiment_95(), 2),
        (with_fixed_step(&experiment_95(), 1e-4), 2),
        (load("hard/limit-hammered"), 2),
        (impact_scene(laws::THESIS_NORMAL, 1.0, 2e-3), 1),
    ];
    for (scene, at_least) in scenes {
        let (_, log) = run_engine(&scene);
        let mut checked = 0;
        for event in log.events.iter().filter(|event| event.kind == EventKind::TouchDown && event.time_s > 0.0) {
            let Some(sample) = log.samples.iter().find(|sample| sample.time_s == event.time_s) else { continue };
            let ContactSample { gap_m, gap_rate_m_s, normal_n, .. } = sample.contact(event.contact);
            let expected = (0.0, -event.approach_speed, 0.0);
            assert_eq!((gap_m, gap_rate_m_s, normal_n), expected, "{} {event:?}", scene.name);
            checked += 1;
        }
        assert!(checked >= at_least, "{}: only {checked} touch-downs within steps", scene.name);
    }
}

/// No sample exceeds the peak force or the penetration of the summary.
#[test]
fn samples_of_discs_are_within_the_extremes_of_the_summary() {
    let scene = impact_scene(laws::THESIS_NORMAL, 1.0, 4e-3);
    let fine = [1e-4, 1e-5, 1e-6].map(|step_s| with_fixed_step(&scene, step_s));
    for scene in fine.into_iter().chain([scene, impact_scene(laws::spring(1e8, 1.5), 3.0, 4e-3)]) {
        let (outcome, log) = laws::run_to_end(Model::Engine, &scene);
        let largest = |quantity: fn((f64, f64)) -> f64| {
            log.samples.iter().map(|s| quantity(s.contact(0).force_and_penetration())).fold(0.0, f64::max)
        };
        assert!(largest(|(force, _)| force) <= outcome.contacts[0].peak_normal_n, "{:?}", scene.engine.stepping);
        assert!(largest(|(_, depth)| depth) <= outcome.contacts[0].max_penetration_m, "{:?}", scene.engine.stepping);
    }
}
