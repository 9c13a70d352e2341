//! Helpers of the tests of models and integrators: the scene of experiment 95, integrator settings, runs, random
//! fingers.

use super::checked_run;
pub use super::collect::CollectSink;
pub use super::random::Random;
use phalanx::gripper::{Assembly, Bodies, Body, Finger, Lengths};
use phalanx::scene::{self, Integrator, Preset, Scene};
use phalanx::trace::{FingerContact, Model, Outcome, RunError, interpolate};

/// The shipped scene of experiment 95: design 95 with the sizing of its experiment.
pub fn experiment_95() -> Scene {
    scene::load("scenes/experiment-95.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The shipped `engineering` preset.
pub fn engineering_settings() -> Integrator {
    Integrator::preset(Preset::Engineering)
}

/// The shipped `reference` preset.
pub fn reference_settings() -> Integrator {
    Integrator::preset(Preset::Reference)
}

/// Runs a scene to its end or its failure. All runs of this module check the invariants at every sample.
#[track_caller]
pub fn run(scene: &Scene) -> (Result<Outcome, RunError>, CollectSink) {
    let mut log = CollectSink::default();
    let result = checked_run::run(Model::Analytic, scene, &mut log);
    (result, log)
}

/// Runs a scene, which must reach its end.
#[track_caller]
pub fn run_to_end(scene: &Scene) -> (Outcome, CollectSink) {
    let (result, log) = run(scene);
    (result.unwrap_or_else(|error| panic!("{}: {error}", scene.name)), log)
}

/// Runs the engine model of a scene, which must reach its end.
#[track_caller]
pub fn run_engine(scene: &Scene) -> (Outcome, CollectSink) {
    let mut log = CollectSink::default();
    let result = checked_run::run(Model::Engine, scene, &mut log);
    (result.unwrap_or_else(|error| panic!("{}: {error}", scene.name)), log)
}

/// Runs the analytic model with reference settings, sampled densely enough to interpolate to 1e-10 rad.
#[track_caller]
pub fn run_dense_reference(scene: &Scene) -> (Outcome, CollectSink) {
    let mut scene = Scene { integrator: reference_settings(), ..scene.clone() };
    scene.log.numeric_hz = 1e6;
    run_to_end(&scene)
}

/// Largest difference of q11, q21 and q22 from a dense reference over all samples of a run, rad.
pub fn max_angle_error(run: &CollectSink, reference: &CollectSink) -> f64 {
    let mut max_error: f64 = 0.0;
    for sample in &run.samples {
        let after = reference.samples.partition_point(|s| s.time_s < sample.time_s);
        let after = after.clamp(1, reference.samples.len() - 1);
        let expected = interpolate(&reference.samples[after - 1], &reference.samples[after], sample.time_s);
        let differences = [
            sample.finger(0).q11_rad - expected.finger(0).q11_rad,
            sample.finger(0).q21_rad - expected.finger(0).q21_rad,
            sample.finger(0).q22_rad - expected.finger(0).q22_rad,
        ];
        max_error = differences.iter().fold(max_error, |largest, d| largest.max(d.abs()));
    }
    max_error
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

/// Asserts |found − expected| ≤ tolerance.
#[track_caller]
pub fn assert_near(actual: f64, expected: f64, tolerance: f64, quantity: &str) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{quantity}: found {actual:e}, expected {expected:e} ± {tolerance:e}"
    );
}
