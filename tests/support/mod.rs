//! What the tests of model and integrator share: the anchor scene, integrator settings, a collecting sink, random numbers.
#![allow(dead_code)]

use phalanx::gripper::{Assembly, Bodies, Body, Finger, Lengths};
use phalanx::scene::{self, Integrator, Method, Preset, Scene};
use phalanx::trace::{Event, EventKind, Outcome, RunError, Sample, Sink, SinkError, Site, run_analytic};

/// Design 95 with the sizing of its experiment, from the shipped scene.
pub fn anchor() -> Scene {
    scene::load("scenes/experiment-95.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The settings of everyday runs, spelt out: the tests hold for these numbers, whatever a preset becomes.
pub fn engineering() -> Integrator {
    Integrator {
        preset: Preset::Engineering,
        method: Method::Rodas5p,
        rtol: 1e-5,
        atol_angle_rad: 1e-9,
        atol_rate_rad_s: 1e-4,
        max_steps: 10_000_000,
    }
}

/// The settings of reference runs, spelt out.
pub fn reference() -> Integrator {
    Integrator {
        preset: Preset::Reference,
        method: Method::RadauIIa5,
        rtol: 1e-11,
        atol_angle_rad: 1e-13,
        atol_rate_rad_s: 1e-9,
        max_steps: 10_000_000,
    }
}

/// Keeps a whole run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Collect {
    pub samples: Vec<Sample>,
    pub events: Vec<Event>,
}

impl Sink for Collect {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples.push(*sample);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

impl Collect {
    /// The sample nearest to `t`.
    pub fn at(&self, t: f64) -> &Sample {
        let distance = |s: &&Sample| (s.time_s - t).abs();
        self.samples.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("samples")
    }

    /// Time of the first touch-down at a site.
    pub fn first_touch(&self, site: Site) -> Option<f64> {
        self.events.iter().find(|e| e.site == site && e.kind == EventKind::TouchDown).map(|e| e.time_s)
    }
}

/// Runs a scene to its end, or to its failure.
pub fn run(scene: &Scene) -> (Result<Outcome, RunError>, Collect) {
    let mut log = Collect::default();
    let result = run_analytic(scene, &mut log);
    (result, log)
}

/// Runs a scene that must get to its end.
#[track_caller]
pub fn complete(scene: &Scene) -> (Outcome, Collect) {
    let (result, log) = run(scene);
    (result.unwrap_or_else(|error| panic!("{}: {error}", scene.name)), log)
}

/// Reproducible random numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    /// Uniform in `low`…`high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let unit = ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }

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
