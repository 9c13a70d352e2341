//! One run of a scene, recorded as its path on a uniform grid.

use std::time::{Duration, Instant};

use phalanx::check::{perturbed, units};
use phalanx::integrator::Reason;
use phalanx::scene::{Integrator, Method, Preset, Scene, Stepping};
use phalanx::trace::{ContactSummary, Event, Model, RunError, Sample, Sink, SinkError, run};

/// Number of grid intervals at which runs are compared.
const POINTS: f64 = 100.0;
/// Wall time after which a run is aborted.
pub const MAX_WALL_TIME: Duration = Duration::from_secs(60);

/// Configuration of a run of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// The analytic model with the settings of the scene, by default the engineering preset.
    Default,
    /// The analytic model with the reference preset.
    Reference,
    /// Rodas5P at nearly the tolerances of the reference preset: another family of methods.
    SecondMethod,
    /// The engine with the settings of the scene.
    Engine,
    /// The engine with its tolerance multiplied by a factor.
    EngineTolerance(f64),
    /// The engineering preset with another relative tolerance.
    Rtol(f64),
}

/// A run: coordinates on the grid, and work.
#[derive(Clone, Debug, Default)]
pub struct Run {
    pub times: Vec<f64>,
    pub path: Vec<Vec<f64>>,
    /// End time, and the reason for a premature end.
    pub end_s: f64,
    pub failure: Option<Reason>,
    pub contacts: Vec<ContactSummary>,
    pub wall_time: Duration,
    pub steps: u64,
    pub events: u64,
    /// Descriptions of all events.
    pub event_log: Vec<String>,
}

/// A sink that records the points of a uniform grid.
struct PathRecorder {
    interval_s: f64,
    times: Vec<f64>,
    path: Vec<Vec<f64>>,
    event_log: Vec<String>,
    /// Units that coordinates are divided by.
    units: Vec<f64>,
    deadline: Instant,
}

impl PathRecorder {
    fn new(scene: &Scene) -> Self {
        let deadline = Instant::now() + MAX_WALL_TIME;
        // Those of the joints of a mechanism come first. Its path consists of the poses of its bodies.
        let joints = scene.mechanism.as_ref().map_or(0, |mechanism| mechanism.joints.len());
        let units = units(scene).split_off(joints);
        Self {
            interval_s: scene.duration_s / POINTS,
            times: Vec::new(),
            path: Vec::new(),
            event_log: Vec::new(),
            units,
            deadline,
        }
    }

    fn record_point(&mut self, time_s: f64, values: impl FnOnce() -> Vec<f64>) {
        let next = self.times.len() as f64 * self.interval_s;
        if (time_s - next).abs() <= 1e-9 * self.interval_s {
            self.times.push(time_s);
            self.path.push(values());
        }
    }
}

impl Sink for PathRecorder {
    fn sample(&mut self, s: &Sample) -> Result<(), SinkError> {
        let angles = s.fingers().flat_map(|finger| [finger.q11_rad, finger.q21_rad, finger.q22_rad]);
        let centres = s.bodies().flat_map(|body| body.centre_m);
        let coordinates = angles.chain(centres).chain(s.bodies().map(|body| body.angle_rad));
        let units = self.units.clone();
        self.record_point(s.time_s, || coordinates.zip(units).map(|(value, unit)| value / unit).collect());
        Ok(())
    }

    fn event(&mut self, e: &Event) -> Result<(), SinkError> {
        self.event_log.push(format!("{:.9} s contact {} {:?}", e.time_s, e.contact, e.kind));
        Ok(())
    }

    fn should_continue(&self) -> bool {
        Instant::now() < self.deadline
    }
}

/// Runs a scene with one setting; `perturbation` is a relative change of its drives.
pub fn record(scene: &Scene, setting: Setting, perturbation: f64) -> Run {
    let start = Instant::now();
    let mut scene = perturbed(scene, perturbation);
    let mut run = simulate(&mut scene, setting);
    run.wall_time = start.elapsed();
    run
}

/// Returns the model of a setting; gives the scene its integrator and steps. Other settings keep those of the scene.
fn apply(setting: Setting, scene: &mut Scene) -> Model {
    let reference = Integrator::preset(Preset::Reference);
    match setting {
        Setting::Reference => scene.integrator = reference,
        Setting::SecondMethod => {
            scene.integrator = Integrator {
                method: Method::Rodas5p,
                rtol: 1e-9,
                atol_angle_rad: 1e-13,
                atol_rate_rad_s: 1e-8,
                ..reference
            };
        }
        Setting::Rtol(rtol) => scene.integrator = Integrator::preset(Preset::Engineering).with_rtol(rtol),
        Setting::EngineTolerance(factor) => {
            if let Stepping::Adaptive { tolerance_m, .. } = &mut scene.engine.stepping {
                *tolerance_m *= factor;
            }
            return Model::Engine;
        }
        Setting::Engine => return Model::Engine,
        Setting::Default => {}
    }
    Model::Analytic
}

fn simulate(scene: &mut Scene, setting: Setting) -> Run {
    let model = apply(setting, scene);
    scene.log.numeric_hz = POINTS / scene.duration_s;
    let mut recorder = PathRecorder::new(scene);
    let result = run(model, &*scene, &mut recorder);
    let (outcome, failure) = match result {
        Ok(outcome) => (outcome, None),
        Err(RunError::Simulation { failure, partial_outcome }) => (*partial_outcome, Some(failure.reason)),
        Err(RunError::Sink(error)) => panic!("{error}"),
    };
    Run {
        end_s: outcome.ejected_s.unwrap_or(outcome.last.time_s),
        failure,
        contacts: outcome.contacts,
        steps: outcome.work.steps,
        events: outcome.work.events,
        times: recorder.times,
        path: recorder.path,
        event_log: recorder.event_log,
        ..Run::default()
    }
}

/// Returns the largest difference of any coordinate along the common part of two paths.
pub fn difference(a: &Run, b: &Run) -> f64 {
    let mut largest: f64 = 0.0;
    for (p, q) in a.path.iter().zip(&b.path) {
        for (x, y) in p.iter().zip(q) {
            largest = largest.max((x - y).abs());
        }
    }
    if largest.is_nan() { f64::INFINITY } else { largest }
}

/// Returns whether two runs end at the same time in the same way.
pub fn have_same_end(a: &Run, b: &Run) -> bool {
    a.failure.is_some() == b.failure.is_some() && (a.end_s - b.end_s).abs() <= 1e-5 * a.end_s.max(b.end_s)
}

/// Returns the largest relative difference of peak forces, of those above a twentieth of the largest one.
pub fn peak_difference(run: &Run, reference: &Run) -> f64 {
    let largest = reference.contacts.iter().map(|contact| contact.peak_normal_n).fold(0.0, f64::max);
    let pairs = run.contacts.iter().zip(&reference.contacts).map(|(a, b)| (a.peak_normal_n, b.peak_normal_n));
    pairs.filter(|(_, peak)| *peak > 0.05 * largest).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}
