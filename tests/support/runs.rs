//! What the tests of model and integrator share: the anchor scene, integrator settings, a collecting sink, random numbers.

pub use super::collect::Collect;
use super::held;
pub use super::random::Random;
use phalanx::gripper::{Assembly, Bodies, Body, Finger, Lengths};
use phalanx::scene::{self, Integrator, Preset, Scene};
use phalanx::trace::{Model, Outcome, RunError, Site, between};

/// Design 95 with the sizing of its experiment, from the shipped scene.
pub fn anchor() -> Scene {
    scene::load("scenes/experiment-95.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The shipped settings of everyday runs.
pub fn engineering() -> Integrator {
    Integrator::preset(Preset::Engineering)
}

/// The shipped settings of reference runs.
pub fn reference() -> Integrator {
    Integrator::preset(Preset::Reference)
}

/// Runs a scene to its end, or to its failure. All runs of this module are held to the invariants at every sample.
#[track_caller]
pub fn run(scene: &Scene) -> (Result<Outcome, RunError>, Collect) {
    let mut log = Collect::default();
    let result = held::run(Model::Analytic, scene, &mut log);
    (result, log)
}

/// Runs a scene that must get to its end.
#[track_caller]
pub fn complete(scene: &Scene) -> (Outcome, Collect) {
    let (result, log) = run(scene);
    (result.unwrap_or_else(|error| panic!("{}: {error}", scene.name)), log)
}

/// Runs the engine model of a scene, which must get to its end.
#[track_caller]
pub fn engine(scene: &Scene) -> (Outcome, Collect) {
    let mut log = Collect::default();
    let result = held::run(Model::Engine, scene, &mut log);
    (result.unwrap_or_else(|error| panic!("{}: {error}", scene.name)), log)
}

/// The analytic model at its reference settings, sampled densely enough to interpolate to 1e-10 rad.
#[track_caller]
pub fn dense_reference(scene: &Scene) -> (Outcome, Collect) {
    let mut scene = Scene { integrator: reference(), ..scene.clone() };
    scene.log.numeric_hz = 1e6;
    complete(&scene)
}

/// Largest difference of q11, q21 and q22 from a dense reference, over all samples of a run.
pub fn worst_angle(run: &Collect, reference: &Collect) -> f64 {
    let mut worst: f64 = 0.0;
    for sample in &run.samples {
        let after = reference.samples.partition_point(|s| s.time_s < sample.time_s);
        let after = after.clamp(1, reference.samples.len() - 1);
        let wanted = between(&reference.samples[after - 1], &reference.samples[after], sample.time_s);
        let found = [
            sample.finger().q11_rad - wanted.finger().q11_rad,
            sample.finger().q21_rad - wanted.finger().q21_rad,
            sample.finger().q22_rad - wanted.finger().q22_rad,
        ];
        worst = found.iter().fold(worst, |most, d| most.max(d.abs()));
    }
    worst
}

/// Normal impulse of a site from its first touch-down to so long after it.
pub fn impact_impulse(run: &Collect, site: Site, window_s: f64) -> f64 {
    let touch = run.first_touch(site as usize).expect("a touch-down");
    let at = |t: f64| {
        let after = run.samples.partition_point(|s| s.time_s < t).clamp(1, run.samples.len() - 1);
        let sample = between(&run.samples[after - 1], &run.samples[after], t);
        match site {
            Site::Proximal => sample.contact(Site::Proximal).impulse_n_s,
            Site::Distal => sample.contact(Site::Distal).impulse_n_s,
            Site::Limit => sample.contact(Site::Limit).impulse_n_s,
        }
    };
    at(touch + window_s) - at(touch)
}

impl Random {
    /// A body whose centre of mass lies off its link.
    pub fn body(&mut self) -> Body {
        Body {
            mass_kg: self.within(1e-3, 20e-3),
            com_m: [self.within(-5e-3, 25e-3), self.within(-10e-3, 10e-3)],
            inertia_kg_m2: self.within(1e-8, 2e-6),
        }
    }

    /// A finger of any proportions, with bodies of any outline.
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

/// |got − want| ≤ tolerance.
#[track_caller]
pub fn assert_near(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: got {got:e}, want {want:e} ± {tolerance:e}");
}
