//! What is kept of a run: the grid, impacts step by step, and the extremes.

use phalanx::scene;
use phalanx::trace::{ContactSample, EventKind, Model, Sample, SinkError, Site, Thin, Thinned, run};
use phalanx::validate::Recording;

fn thinned(scene: &scene::Scene, model: Model) -> (phalanx::trace::Outcome, Recording) {
    let mut sink = Thinned::new(scene.log.numeric_hz, Recording::default());
    let outcome = run(model, scene, &mut sink).expect("a run");
    sink.end().expect("kept");
    (outcome, sink.sink)
}

/// A sample with a force on the proximal phalanx.
fn pressed(time_s: f64, normal_n: f64) -> Sample {
    let proximal = ContactSample { gap_m: -1e-9 * normal_n, normal_n, ..ContactSample::default() };
    Sample { time_s, contacts: vec![proximal], ..Sample::default() }
}

fn keep(kept: &mut Vec<f64>, sample: &Sample) -> Result<(), SinkError> {
    kept.push(sample.time_s);
    Ok(())
}

fn kept_of(samples: &[Sample], numeric_hz: f64) -> Vec<f64> {
    let mut thin = Thin::new(numeric_hz);
    let mut kept = Vec::new();
    for sample in samples {
        thin.sample(sample, |sample| keep(&mut kept, sample)).expect("kept");
    }
    thin.flush(|sample| keep(&mut kept, sample)).expect("kept");
    kept
}

#[test]
fn of_a_run_without_forces_the_grid_is_kept() {
    let samples: Vec<Sample> = (0..=100).map(|k| pressed(f64::from(k) * 0.125, 0.0)).collect();
    let kept = kept_of(&samples, 1.0);
    assert_eq!(kept, (0..=12).map(f64::from).chain([12.5]).collect::<Vec<_>>());
}

#[test]
fn an_impact_is_kept_step_by_step_and_from_the_sample_before_it() {
    let force = |k: i32| if (40..=45).contains(&k) { 10.0 - f64::from((k - 42).pow(2)) } else { 0.0 };
    let samples: Vec<Sample> = (0..=80).map(|k| pressed(f64::from(k) / 64.0, force(k))).collect();
    let kept = kept_of(&samples, 1.0);
    for k in 39..=46 {
        assert!(kept.contains(&(f64::from(k) / 64.0)), "no {k} in {kept:?}");
    }
    assert!(!kept.contains(&(30.0 / 64.0)) && !kept.contains(&(75.0 / 64.0)), "{kept:?}");
}

#[test]
fn a_slow_maximum_off_the_grid_is_kept() {
    // It changes by less than a tenth of itself in an interval.
    let samples: Vec<Sample> =
        (0..=200).map(|k| f64::from(k) / 64.0).map(|t| pressed(t, 100.0 - (t - 1.265_625).powi(2))).collect();
    let kept = kept_of(&samples, 1.0);
    assert_eq!(kept, [0.0, 1.0, 1.265_625, 2.0, 3.0, 3.125]);
}

#[test]
fn the_samples_around_an_event_are_kept() {
    let mut thin = Thin::new(1.0);
    let mut kept = Vec::new();
    for k in 0..32 {
        let sample = pressed(f64::from(k) / 64.0, 0.0);
        thin.sample(&sample, |sample| keep(&mut kept, sample)).expect("kept");
        if k == 10 {
            thin.event(|sample| keep(&mut kept, sample)).expect("kept");
        }
    }
    assert_eq!(kept, [0.0, 10.0 / 64.0, 11.0 / 64.0]);
}

#[test]
fn the_largest_values_of_the_samples_are_those_of_the_run() {
    for name in ["experiment-95", "long-fingers", "hard/damper-none", "hard/start-in-penetration"] {
        let scene = scene::load(format!("scenes/{name}.toml")).expect("a scene");
        for model in [Model::Analytic, Model::Engine] {
            let (outcome, kept) = thinned(&scene, model);
            for site in Site::ALL {
                let (mut force, mut depth) = (0.0f64, 0.0f64);
                for sample in &kept.samples {
                    let (f, d) = sample.contact(site).pressed();
                    (force, depth) = (force.max(f), depth.max(d));
                }
                let found = outcome.site(site);
                let what = format!("{name} {} {}", model.name(), site.name());
                assert_eq!(depth, found.max_penetration_m, "{what} {:?}", kept.events);
                assert_eq!(force, found.peak_normal_n, "{what}");
            }
        }
    }
}

#[test]
fn discs_too() {
    for name in ["impact", "two-free", "spring"] {
        let scene = scene::load_any(format!("scenes/laws/{name}.toml")).expect("a scene");
        for model in [Model::Analytic, Model::Engine] {
            let mut sink = Thinned::new(scene.log.numeric_hz, Recording::default());
            let outcome = run(model, &scene, &mut sink).expect("a run");
            sink.end().expect("kept");
            for (pair, found) in outcome.contacts.iter().enumerate() {
                let largest = |of: fn(&ContactSample) -> f64| {
                    sink.sink.samples.iter().map(|sample| of(&sample.contacts[pair])).fold(0.0, f64::max)
                };
                let what = format!("{name} {}", model.name());
                assert_eq!(largest(|contact| -contact.gap_m), found.max_penetration_m, "{what}");
                assert_eq!(largest(|contact| contact.normal_n), found.peak_normal_n, "{what}");
            }
        }
    }
}

/// "Impacts are logged at every step of the integrator": of both impacts of design 95 nothing is lost, and of the swing between
/// them the grid is enough.
#[test]
fn impacts_keep_their_steps_and_the_swing_does_not() {
    let scene = scene::load("scenes/experiment-95.toml").expect("a scene");
    for model in [Model::Analytic, Model::Engine] {
        let mut whole = Recording::default();
        run(model, &scene, &mut whole).expect("a run");
        let (_, kept) = thinned(&scene, model);
        assert_eq!(whole.events, kept.events, "{}", model.name());
        let within = |samples: &[Sample], from: f64, to: f64| -> Vec<f64> {
            samples.iter().map(|sample| sample.time_s).filter(|t| (from..to).contains(t)).collect()
        };
        for event in whole.events.iter().filter(|event| event.kind == EventKind::TouchDown && event.time_s > 0.0) {
            let (all, some) = (
                within(&whole.samples, event.time_s, event.time_s + 2e-5),
                within(&kept.samples, event.time_s, event.time_s + 2e-5),
            );
            assert!(all.len() >= 3 && all.iter().all(|t| some.contains(t)), "{} {event:?}", model.name());
        }
        let (all, some) = (within(&whole.samples, 1e-3, 4e-3), within(&kept.samples, 1e-3, 4e-3));
        assert!(some.len() >= 30 && some.len() <= 34, "{} {} of {}", model.name(), some.len(), all.len());
        assert!(kept.samples.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
    }
}
