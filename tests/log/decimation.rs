//! Decimation of samples: time grid, every step of an impact, extremes.

use phalanx::criteria::RunCriteriaTracker;
use phalanx::scene;
use phalanx::trace::{
    ContactSample, Decimated, Event, EventKind, Model, OffGrid, RequiredData, Sample, Sink, SinkError, run,
};
use phalanx::validate::Recording;

pub fn decimated_run(scene: &scene::Scene, model: Model) -> (phalanx::trace::Outcome, Recording) {
    let mut sink = Decimated::new(scene.log.numeric_hz, Recording::default());
    let outcome = run(model, scene, &mut sink).expect("a run");
    sink.end().expect("decimated");
    (outcome, sink.sink)
}

/// A sample with a force on the proximal phalanx.
fn sample_with_force(time_s: f64, normal_n: f64) -> Sample {
    let proximal = ContactSample { gap_m: -1e-9 * normal_n, normal_n, ..ContactSample::default() };
    Sample::of(time_s, &[], &[], &[proximal])
}

/// Keeps the times of the samples.
struct Times(Vec<f64>);

impl Sink for Times {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.0.push(sample.time_s);
        Ok(())
    }
}

fn retained_times(samples: &[Sample], numeric_hz: f64) -> Vec<f64> {
    let mut decimated = Decimated::new(numeric_hz, Times(Vec::new()));
    samples.iter().for_each(|sample| decimated.sample(sample).expect("decimated"));
    decimated.end().expect("decimated");
    decimated.sink.0
}

#[test]
fn without_forces_the_grid_and_one_other_sample_per_interval_are_retained() {
    let samples: Vec<Sample> = (0..=100).map(|k| sample_with_force(f64::from(k) * 0.125, 0.0)).collect();
    let retained = retained_times(&samples, 1.0);
    let expected = (1..=12).map(f64::from).flat_map(|t| [t, t + 0.125]);
    assert_eq!(retained, [0.0].into_iter().chain(expected).chain([12.5]).collect::<Vec<_>>());
}

/// The other samples are the same whether there are samples on the grid or not.
#[test]
fn the_grid_has_no_effect_on_other_samples() {
    let times = || (1..=300).map(|k| f64::from(k) * 0.037);
    let force = |t: f64| 20.0 * (1.0 - (t - 5.0).powi(2)).max(0.0) + (t - 8.0).max(0.0);
    let retained = |has_grid: bool| {
        let mut all: Vec<f64> = times().chain((1..=11).map(f64::from).filter(|_| has_grid)).collect();
        all.sort_by(f64::total_cmp);
        let mut decimated = Decimated::new(1.0, OffGrid::new(1.0, Times(Vec::new())));
        for t in [0.0].into_iter().chain(all) {
            decimated.sample(&sample_with_force(t, force(t))).expect("decimated");
        }
        decimated.end().expect("decimated");
        decimated.sink.sink.0
    };
    assert_eq!(retained(true), retained(false));
    assert!(retained(true).len() > 60 && !retained(true).contains(&3.0));
}

/// Criteria of a run do not depend on whether it is logged.
#[test]
fn the_grid_has_no_effect_on_criteria() {
    struct Evaluated(OffGrid<RunCriteriaTracker>, bool);
    impl Sink for Evaluated {
        fn required_data(&self) -> RequiredData {
            RequiredData { grid: self.1, ..self.0.required_data() }
        }

        fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
            self.0.sample(sample)
        }

        fn event(&mut self, event: &Event) -> Result<(), SinkError> {
            self.0.event(event)
        }
    }
    for name in ["experiment-95", "soft-start", "gripper/cycle-fast", "laws/two-free"] {
        let scene = scene::load_any(format!("scenes/{name}.toml")).expect("a scene");
        let models = if name.contains("cycle") { &[Model::Analytic][..] } else { &[Model::Analytic, Model::Engine] };
        for model in models {
            let [without, with] = [false, true].map(|has_grid| {
                let numeric_hz = scene.log.numeric_hz;
                let tracker = OffGrid::new(numeric_hz, RunCriteriaTracker::for_scene(&scene));
                let mut sink = Decimated::new(numeric_hz, Evaluated(tracker, has_grid));
                run(*model, &scene, &mut sink).expect("a run");
                sink.end().and_then(|()| sink.sink.0.end()).expect("decimated");
                sink.sink.0.sink.finish(true)
            });
            assert_eq!(without, with, "{name} {}", model.name());
        }
    }
}

#[test]
fn every_step_of_an_impact_and_the_sample_before_it_are_retained() {
    let force = |k: i32| if (40..=45).contains(&k) { 10.0 - f64::from((k - 42).pow(2)) } else { 0.0 };
    let samples: Vec<Sample> = (0..=80).map(|k| sample_with_force(f64::from(k) / 64.0, force(k))).collect();
    let retained = retained_times(&samples, 1.0);
    for k in 39..=46 {
        assert!(retained.contains(&(f64::from(k) / 64.0)), "no {k} in {retained:?}");
    }
    assert!(!retained.contains(&(30.0 / 64.0)) && !retained.contains(&(75.0 / 64.0)), "{retained:?}");
}

#[test]
fn a_slow_maximum_between_grid_points_is_retained() {
    // The force changes by less than a tenth in one interval.
    let samples: Vec<Sample> =
        (0..=200).map(|k| f64::from(k) / 64.0).map(|t| sample_with_force(t, 100.0 - (t - 1.265_625).powi(2))).collect();
    let retained = retained_times(&samples, 1.0);
    assert_eq!(retained, [0.0, 1.0, 1.015_625, 1.265_625, 2.0, 2.265_625, 3.0, 3.125]);
}

#[test]
fn samples_around_an_event_are_retained() {
    let mut decimated = Decimated::new(1.0, Times(Vec::new()));
    for k in 0..32 {
        let time_s = f64::from(k) / 64.0;
        decimated.sample(&sample_with_force(time_s, 0.0)).expect("decimated");
        if k == 10 {
            let kind = EventKind::TouchDown;
            let event = Event { time_s, contact: 0, kind, approach_speed: 0.0, impulse: 0.0 };
            decimated.event(&event).expect("decimated");
        }
    }
    let retained = decimated.sink.0;
    assert_eq!(retained, [0.0, 10.0 / 64.0, 11.0 / 64.0]);
}

#[test]
fn retained_samples_contain_the_extremes_of_a_run() {
    let fingers = ["experiment-95", "long-fingers", "hard/damper-none", "hard/start-in-penetration"];
    for name in fingers.into_iter().chain(["laws/impact", "laws/two-free", "laws/spring"]) {
        let scene = scene::load_any(format!("scenes/{name}.toml")).expect("a scene");
        for model in [Model::Analytic, Model::Engine] {
            let (outcome, retained) = decimated_run(&scene, model);
            for (contact, expected) in outcome.contacts.iter().enumerate() {
                let largest = |value: fn(&ContactSample) -> f64| {
                    retained.samples.iter().map(|sample| value(&sample.contact(contact))).fold(0.0, f64::max)
                };
                let label = format!("{name} {} {contact} {:?}", model.name(), retained.events);
                assert_eq!(largest(|contact| contact.force_and_penetration().1), expected.max_penetration_m, "{label}");
                assert_eq!(largest(|contact| contact.force_and_penetration().0), expected.peak_normal_n, "{label}");
            }
        }
    }
}

/// All steps of both impacts of design 95 are retained; the swing in between is on the grid.
#[test]
fn steps_are_retained_within_impacts_but_not_in_between() {
    let scene = scene::load("scenes/experiment-95.toml").expect("a scene");
    for model in [Model::Analytic, Model::Engine] {
        let mut all_samples = Recording::default();
        run(model, &scene, &mut all_samples).expect("a run");
        let (_, retained) = decimated_run(&scene, model);
        assert_eq!(all_samples.events, retained.events, "{}", model.name());
        let within = |samples: &[Sample], from: f64, to: f64| -> Vec<f64> {
            samples.iter().map(|sample| sample.time_s).filter(|t| (from..to).contains(t)).collect()
        };
        for event in all_samples.events.iter().filter(|event| event.kind == EventKind::TouchDown && event.time_s > 0.0)
        {
            let (all, retained_times) = (
                within(&all_samples.samples, event.time_s, event.time_s + 2e-5),
                within(&retained.samples, event.time_s, event.time_s + 2e-5),
            );
            assert!(all.len() >= 3 && all.iter().all(|t| retained_times.contains(t)), "{} {event:?}", model.name());
        }
        let (all, retained_times) = (within(&all_samples.samples, 1e-3, 4e-3), within(&retained.samples, 1e-3, 4e-3));
        let (on_grid, others): (Vec<f64>, Vec<f64>) =
            retained_times.iter().partition(|t| (*t / 1e-4).round() * 1e-4 == **t);
        assert!((30..=31).contains(&on_grid.len()), "{} {retained_times:?} of {}", model.name(), all.len());
        assert!(others.windows(2).all(|pair| pair[1] - pair[0] >= 1e-4), "{} {others:?}", model.name());
        assert!(retained.samples.windows(2).all(|pair| pair[0].time_s <= pair[1].time_s));
    }
}
