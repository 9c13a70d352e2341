//! One run of a scene, kept as its path on an even grid.

use std::time::{Duration, Instant};

use phalanx::check::{pushed, units};
use phalanx::scene::{Integrator, Method, Preset, Scene, Stepping};
use phalanx::trace::{Event, Model, RunError, Sample, Sink, SinkError, run};
use phalanx::validate::turned;

/// Points at which runs are compared.
const POINTS: f64 = 100.0;
/// Wall time after which a run counts as one that hangs.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// How a scene is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// The analytic model at the everyday preset.
    Default,
    Reference,
    /// Rodas5P at the reference preset's tolerances, as far as it gets by itself: another family of methods.
    Second,
    /// The engine at its defaults.
    Engine,
    /// The engine at a tolerance so many times its default.
    EngineAt(f64),
    /// The everyday preset at another rtol.
    Rtol(f64),
}

/// A run: coordinates over the grid, and what it cost.
#[derive(Clone, Debug, Default)]
pub struct Run {
    pub times: Vec<f64>,
    pub path: Vec<Vec<f64>>,
    /// Where it ended, and why if that was not its end.
    pub end_s: f64,
    pub failure: Option<String>,
    pub wall: Duration,
    pub steps: u64,
    pub events: u64,
    /// Every event in words.
    pub story: Vec<String>,
}

/// Keeps the points of a grid.
struct Keep {
    interval_s: f64,
    times: Vec<f64>,
    path: Vec<Vec<f64>>,
    story: Vec<String>,
    /// What coordinates are divided by.
    units: Vec<f64>,
    deadline: Instant,
}

impl Keep {
    fn new(duration_s: f64, units: Vec<f64>) -> Self {
        let deadline = Instant::now() + PATIENCE;
        Self {
            interval_s: duration_s / POINTS,
            times: Vec::new(),
            path: Vec::new(),
            story: Vec::new(),
            units,
            deadline,
        }
    }

    fn take(&mut self, time_s: f64, values: impl FnOnce() -> Vec<f64>) {
        let next = self.times.len() as f64 * self.interval_s;
        if (time_s - next).abs() <= 1e-9 * self.interval_s {
            self.times.push(time_s);
            self.path.push(values());
        }
    }
}

impl Sink for Keep {
    fn sample(&mut self, s: &Sample) -> Result<(), SinkError> {
        // Readings of passive angles jump by a turn.
        let before = self.path.last().cloned();
        let angles = s.fingers.iter().enumerate().flat_map(|(index, finger)| {
            let before =
                before.as_ref().and_then(|before| before.get(3 * index + 2)).copied().unwrap_or(finger.q22_rad);
            [finger.q11_rad, finger.q21_rad, before + turned(finger.q22_rad - before)]
        });
        let centres = s.bodies.iter().flat_map(|disc| disc.centre_m);
        let units = self.units.clone();
        self.take(s.time_s, || angles.chain(centres).zip(units).map(|(value, unit)| value / unit).collect());
        Ok(())
    }

    fn event(&mut self, e: &Event) -> Result<(), SinkError> {
        self.story.push(format!("{:.9} s contact {} {:?}", e.time_s, e.contact, e.kind));
        Ok(())
    }

    fn proceed(&self) -> bool {
        Instant::now() < self.deadline
    }
}

/// Runs a scene in one setting; `push`: relative change of what drives it.
pub fn record(scene: &Scene, setting: Setting, push: f64) -> Run {
    let start = Instant::now();
    let mut scene = pushed(scene, push);
    let mut run = run_in(&mut scene, setting);
    run.wall = start.elapsed();
    run
}

fn model(setting: Setting) -> Model {
    match setting {
        Setting::Engine | Setting::EngineAt(_) => Model::Engine,
        _ => Model::Analytic,
    }
}

fn integrator(setting: Setting, own: &Integrator) -> Integrator {
    let everyday = Integrator::preset(Preset::Engineering);
    let reference = Integrator::preset(Preset::Reference);
    match setting {
        Setting::Reference => reference,
        Setting::Second => Integrator {
            method: Method::Rodas5p,
            rtol: 1e-9,
            atol_angle_rad: 1e-13,
            atol_rate_rad_s: 1e-8,
            ..reference
        },
        Setting::Rtol(rtol) => everyday.with_rtol(rtol),
        // As the scene is run when nothing is said.
        _ => *own,
    }
}

fn stepping(setting: Setting, own: Stepping) -> Stepping {
    match (setting, own) {
        (Setting::EngineAt(factor), Stepping::Adaptive { tolerance_m, max_step_s }) => {
            Stepping::Adaptive { tolerance_m: factor * tolerance_m, max_step_s }
        }
        (_, own) => own,
    }
}

fn run_in(scene: &mut Scene, setting: Setting) -> Run {
    scene.integrator = integrator(setting, &scene.integrator);
    scene.engine.stepping = stepping(setting, scene.engine.stepping);
    scene.log.numeric_hz = POINTS / scene.duration_s;
    let mut keep = Keep::new(scene.duration_s, units(&scene.system));
    let result = run(model(setting), &*scene, &mut keep);
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, so_far }) => (*so_far, Some(failure.reason.to_string())),
        Err(RunError::Sink(error)) => panic!("{error}"),
    };
    Run {
        end_s: outcome.ejected_s.unwrap_or(outcome.last.time_s),
        failure,
        steps: outcome.work.steps,
        events: outcome.work.events,
        times: keep.times,
        path: keep.path,
        story: keep.story,
        ..Run::default()
    }
}

/// Largest difference of any coordinate along the path both have, and whether they end at the same time in the same way.
pub fn difference(a: &Run, b: &Run) -> f64 {
    let mut largest: f64 = 0.0;
    for (p, q) in a.path.iter().zip(&b.path) {
        for (x, y) in p.iter().zip(q) {
            largest = largest.max((x - y).abs());
        }
    }
    if largest.is_nan() { f64::INFINITY } else { largest }
}

/// Whether both end in the same way.
pub fn same_end(a: &Run, b: &Run) -> bool {
    a.failure.is_some() == b.failure.is_some() && (a.end_s - b.end_s).abs() <= 1e-5 * a.end_s.max(b.end_s)
}
