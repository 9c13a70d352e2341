//! What the recorder of the engine makes of its steps, the same for fingers and discs.

use phalanx::scene::{self, Scene, Stepping};
use phalanx::trace::{ContactSample, EventKind, Model, Site};

use crate::support::laws::{self, BOTH, disc, impact, on_plane, sliding, stepped};
use crate::support::runs;

fn load(name: &str) -> Scene {
    scene::load(format!("scenes/hard/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// A disc of 1 kg that lies on the half plane, at rest.
fn lying(gravity_m_s2: f64) -> Scene {
    let discs = vec![disc("puck", 0.05, [0.0, 0.05], sliding([0.0; 2]))];
    let mut scene = on_plane(laws::scene(discs, laws::THESIS, None, 1e-3));
    scene.system.gravity_m_s2 = [0.0, gravity_m_s2];
    scene
}

/// What touches and rests at the start has met if it is about to press: that is no impact, and it is not told a step late.
#[test]
fn a_start_at_rest_on_the_object_is_a_touch_down_at_once() {
    for run in [runs::complete, runs::engine] {
        let (outcome, log) = run(&load("start-in-contact"));
        let first = log.events[0];
        assert_eq!((first.time_s, first.site(), first.kind), (0.0, Site::Proximal, EventKind::TouchDown));
        assert_eq!((first.approach_speed, outcome.site(Site::Proximal).touchdowns), (0.0, 1));
    }
    for model in BOTH {
        let (outcome, log) = laws::complete(model, &lying(-9.81));
        let first = log.events[0];
        assert_eq!((first.time_s, first.kind, first.approach_speed), (0.0, EventKind::TouchDown, 0.0), "{model:?}");
        assert_eq!(outcome.contacts[0].touchdowns, 1, "{model:?}");
        for gravity in [0.0, 9.81] {
            let (outcome, log) = laws::complete(model, &lying(gravity));
            assert!(log.events.is_empty() && outcome.contacts[0].first_s.is_none(), "{model:?} at {gravity} m/s²");
        }
    }
}

/// Forces before the first step are those of the laws: the first sample has them, and so has the summary.
#[test]
fn a_start_in_penetration_presses_from_the_first_sample_on() {
    let scene = load("start-in-penetration");
    let [(_, expected), (outcome, found)] = [runs::complete(&scene), runs::engine(&scene)];
    let [expected, found] = [&expected, &found].map(|log| log.samples[0].contact(Site::Proximal));
    assert!(expected.normal_n > 0.02, "{expected:?}");
    assert!(
        (found.normal_n / expected.normal_n - 1.0).abs() < 1e-6,
        "{} N, not {} N",
        found.normal_n,
        expected.normal_n
    );
    assert!(outcome.site(Site::Proximal).peak_normal_n >= found.normal_n);
}

/// At a touch within a step the gap is zero and closes at the approach speed, and nothing presses yet.
#[test]
fn a_touch_is_shown_where_the_gap_is_zero() {
    let met = |contact: &ContactSample, approach: f64, what: &str| {
        assert_eq!((contact.gap_m, contact.gap_rate_m_s, contact.normal_n), (0.0, -approach, 0.0), "{what}");
    };
    let coarse = Scene {
        engine: phalanx::scene::Engine { stepping: Stepping::Fixed { step_s: 1e-4 }, ..runs::anchor().engine },
        ..runs::anchor()
    };
    for scene in [runs::anchor(), coarse, load("limit-hammered")] {
        let (_, log) = runs::engine(&scene);
        let mut seen = 0;
        for event in log.events.iter().filter(|event| event.kind == EventKind::TouchDown && event.time_s > 0.0) {
            let Some(sample) = log.samples.iter().find(|sample| sample.time_s == event.time_s) else { continue };
            met(&sample.contacts[event.contact], event.approach_speed, &format!("{} {event:?}", scene.name));
            seen += 1;
        }
        assert!(seen >= 2, "{}: {seen} touches within steps", scene.name);
    }
    let (_, log) = laws::complete(Model::Engine, &impact(laws::THESIS, 1.0, 2e-3));
    let event = log.events[0];
    let sample = log.samples.iter().find(|sample| sample.time_s == event.time_s).expect("a sample at the touch");
    met(&sample.contacts[0], event.approach_speed, "discs");
}

/// Whoever has only the samples finds the extremes of the summary, to the last bit, and none beyond them.
#[test]
fn no_sample_of_discs_is_beyond_the_summary() {
    let scene = impact(laws::THESIS, 1.0, 4e-3);
    let fine = [1e-4, 1e-5, 1e-6].map(|step_s| stepped(&scene, step_s));
    for scene in fine.into_iter().chain([scene, impact(laws::spring(1e8, 1.5), 3.0, 4e-3)]) {
        let (outcome, log) = laws::complete(Model::Engine, &scene);
        let largest =
            |of: fn((f64, f64)) -> f64| log.samples.iter().map(|s| of(s.contacts[0].pressed())).fold(0.0, f64::max);
        assert!(largest(|(force, _)| force) <= outcome.contacts[0].peak_normal_n, "{:?}", scene.engine.stepping);
        assert!(largest(|(_, depth)| depth) <= outcome.contacts[0].max_penetration_m, "{:?}", scene.engine.stepping);
    }
}
