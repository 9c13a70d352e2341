//! Helpers of the tests of models and integrators: experiment 95 and scenes with stiction, runs, comparisons of runs,
//! random fingers.

pub use super::random::Random;
use std::fmt::Display;

use super::checked_run;
use phalanx::gripper::{Assembly, Bodies, Body, Finger, FingerContact, Lengths};
use phalanx::integrator::{Options, Tolerances};
use phalanx::law::{Bristle, FrictionKind};
use phalanx::scene::{self, Integrator, Preset, Scene};
use phalanx::trace::{Event, EventKind, FingerState, Model, Outcome, RunError, Sample, Sink, SinkError, interpolate};

pub const PHALANGES: [FingerContact; 2] = [FingerContact::Proximal, FingerContact::Distal];

/// Loads a shipped scene of one finger.
pub fn load(name: &str) -> Scene {
    scene::load(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// The shipped scene of experiment 95: design 95 with the sizing of its experiment.
pub fn experiment_95() -> Scene {
    load("experiment-95")
}

/// Experiment 95 with a change.
pub fn experiment_95_with(change: impl FnOnce(&mut Scene)) -> Scene {
    let mut scene = experiment_95();
    change(&mut scene);
    scene
}

/// Loads a shipped scene of one finger and adds stiction to its contacts: default bristles, with the damping of the
/// normal law and a relaxation time of 1 ms.
pub fn load_with_stiction(name: &str) -> Scene {
    let mut scene = load(name);
    for law in scene.finger_mut().contact.both_mut() {
        let damping_n_s_per_m = law.normal.damping_max();
        let friction = law.friction.as_mut().expect("friction");
        friction.kind = FrictionKind::Bristle(Bristle { damping_n_s_per_m, relaxation_s: 1e-3 });
    }
    scene
}

/// The shipped `engineering` preset.
pub fn engineering_settings() -> Integrator {
    Integrator::preset(Preset::Engineering)
}

/// The shipped `reference` preset.
pub fn reference_settings() -> Integrator {
    Integrator::preset(Preset::Reference)
}

/// Tolerances and step limit of integrator settings.
pub fn options(settings: &Integrator) -> Options {
    let &Integrator { atol_angle_rad: atol_q, atol_rate_rad_s: atol_v, rtol: rtol_v, max_steps, .. } = settings;
    Options { tolerances: Tolerances { atol_q, atol_v, rtol_v }, max_steps }
}

/// The scene with the `reference` preset of the integrator.
pub fn with_reference_settings(scene: &Scene) -> Scene {
    Scene { integrator: reference_settings(), ..scene.clone() }
}

/// A sink that stores all samples and events of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CollectSink {
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
}

impl Sink for CollectSink {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

impl CollectSink {
    /// Returns the sample whose time is nearest to `t`, s.
    pub fn nearest_sample(&self, t: f64) -> &Sample {
        let distance = |s: &&Sample| (s.time_s - t).abs();
        self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("samples")
    }

    /// Time of the first event of the given kind at a contact, s.
    pub fn first_event_s(&self, contact: usize, kind: EventKind) -> Option<f64> {
        self.events.iter().find(|event| event.contact == contact && event.kind == kind).map(|event| event.time_s)
    }

    /// Time of the first event of the given kind at a contact, s; panics if there is none.
    #[track_caller]
    pub fn event_time_s(&self, contact: usize, kind: EventKind) -> f64 {
        self.first_event_s(contact, kind).unwrap_or_else(|| panic!("no {kind:?} at contact {contact}"))
    }

    /// Time of the first touch-down at a contact, s.
    pub fn first_contact_s(&self, contact: usize) -> Option<f64> {
        self.first_event_s(contact, EventKind::TouchDown)
    }
}

/// Runs the analytic model of a scene to its end or its failure. All runs of this module check the invariants at every
/// sample.
#[track_caller]
pub fn run(scene: &Scene) -> (Result<Outcome, RunError>, CollectSink) {
    let mut log = CollectSink::default();
    let result = checked_run::run(Model::Analytic, scene, &mut log);
    (result, log)
}

/// Runs a model of a scene, which must reach its end.
#[track_caller]
pub fn run_model(model: Model, scene: &Scene) -> (Outcome, CollectSink) {
    let mut log = CollectSink::default();
    let result = checked_run::run(model, scene, &mut log);
    (result.unwrap_or_else(|error| panic!("{}, {} model: {error}", scene.name, model.name())), log)
}

/// Runs the analytic model of a scene, which must reach its end.
#[track_caller]
pub fn run_to_end(scene: &Scene) -> (Outcome, CollectSink) {
    run_model(Model::Analytic, scene)
}

/// Runs the engine model of a scene, which must reach its end.
#[track_caller]
pub fn run_engine(scene: &Scene) -> (Outcome, CollectSink) {
    run_model(Model::Engine, scene)
}

/// Runs the analytic model with reference settings, sampled densely enough to interpolate to 1e-10 rad.
#[track_caller]
pub fn run_dense_reference(scene: &Scene) -> (Outcome, CollectSink) {
    let mut scene = with_reference_settings(scene);
    scene.log.numeric_hz = 1e6;
    run_to_end(&scene)
}

/// Largest difference of q11, q21 and q22 between two states, rad.
pub fn finger_difference(a: &FingerState, b: &FingerState) -> f64 {
    let differences = [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad, a.q22_rad - b.q22_rad];
    differences.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Largest difference of q11, q21 and q22 from a dense reference over all samples of a run, rad.
pub fn max_angle_error(run: &CollectSink, reference: &CollectSink) -> f64 {
    let error = |sample: &Sample| {
        let after = reference.samples.partition_point(|s| s.time_s < sample.time_s);
        let after = after.clamp(1, reference.samples.len() - 1);
        let expected = interpolate(&reference.samples[after - 1], &reference.samples[after], sample.time_s);
        finger_difference(&sample.finger(0), &expected.finger(0))
    };
    run.samples.iter().map(error).fold(0.0, f64::max)
}

/// Normal impulse of a contact within `window_s` of its first touch-down, N·s.
pub fn impact_impulse(run: &CollectSink, finger_contact: FingerContact, window_s: f64) -> f64 {
    let contact_s = run.first_contact_s(finger_contact as usize).expect("a touch-down");
    let impulse_at = |t: f64| {
        let after = run.samples.partition_point(|s| s.time_s < t).clamp(1, run.samples.len() - 1);
        let sample = interpolate(&run.samples[after - 1], &run.samples[after], t);
        sample.finger_contact(finger_contact).impulse_n_s
    };
    impulse_at(contact_s + window_s) - impulse_at(contact_s)
}

impl Random {
    /// A body whose centre of mass is off the axis of its link.
    pub fn body(&mut self) -> Body {
        Body {
            mass_kg: self.within(1e-3, 20e-3),
            com_m: [self.within(-5e-3, 25e-3), self.within(-10e-3, 10e-3)],
            inertia_kg_m2: self.within(1e-8, 2e-6),
        }
    }

    /// A finger with random lengths and bodies.
    pub fn finger(&mut self) -> Finger {
        let lengths = Lengths {
            l11_m: self.within(8e-3, 30e-3),
            l12_m: self.within(10e-3, 40e-3),
            l21_m: self.within(10e-3, 40e-3),
            l22_m: self.within(5e-3, 20e-3),
            t22_m: self.within(5e-3, 25e-3),
            phi22_rad: self.within(0.3, 2.8),
            half_width_m: self.within(1e-3, 4e-3),
        };
        let bodies = Bodies { l11: self.body(), l12: self.body(), l21: self.body(), l22: self.body() };
        let assembly = if self.within(0.0, 1.0) < 0.5 { Assembly::Reference } else { Assembly::Other };
        Finger { lengths, bodies, assembly }
    }
}

/// Asserts |actual − expected| ≤ tolerance.
#[track_caller]
pub fn assert_near(actual: f64, expected: f64, tolerance: f64, context: impl Display) {
    let is_near = (actual - expected).abs() <= tolerance;
    assert!(is_near, "{context}: found {actual:e}, expected {expected:e} ± {tolerance:e}");
}

/// Asserts |actual/expected − 1| ≤ tolerance.
#[track_caller]
pub fn assert_relative(actual: f64, expected: f64, tolerance: f64, context: impl Display) {
    let is_near = (actual / expected - 1.0).abs() <= tolerance;
    assert!(is_near, "{context}: found {actual:e}, expected {expected:e} within a fraction of {tolerance:e}");
}

/// Asserts that a measure of an error is below its bound; NaN is not.
#[track_caller]
pub fn assert_below(value: f64, bound: f64, context: impl Display) {
    assert!(value < bound, "{context}: {value:e} is not below {bound:e}");
}

/// Range of seeds of a campaign: that of the environment variable `PHALANX_SEEDS`, such as `0..500`.
pub fn seeds(default: &str) -> std::ops::Range<u64> {
    let range = std::env::var("PHALANX_SEEDS").unwrap_or_else(|_| default.to_string());
    let seeds: Vec<u64> = range.split("..").map(|end| end.parse().expect("a seed")).collect();
    seeds[0]..seeds[1]
}
