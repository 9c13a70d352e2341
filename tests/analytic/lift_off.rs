//! Cables that lift off their pulleys on arms that turn along known paths, against the geometry of tangents written anew.

use phalanx::analytic::mechanism::{MechanismMode, MechanismModel};
use phalanx::integrator::{
    Dynamic, Observer, Options, State, Step, StepTools, SwitchedMethod, Tolerances, integrate_by,
};
use phalanx::mechanism::assemble;
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{self, Model};
use std::f64::consts::{PI, TAU};

use crate::support::random::Random;
use crate::support::runs::CollectSink;

/// Samples of a path in the reference.
const SAMPLES: usize = 20_000;
/// Largest error of the time of a lift-off: of the analytic model, and of the engine, which finds it at the end of a step of
/// 50 µs.
const TOLERANCES_S: [(Model, f64); 2] = [(Model::Analytic, 1e-8), (Model::Engine, 6e-5)];
/// Wraps closer to zero than this are neither on the pulley nor off it, rad.
const GRAZING_RAD: f64 = 1e-6;
/// Largest wrap, rad. Strands may cross beyond 3π/2.
const MAX_WRAP_RAD: f64 = 1.4 * PI;
const DURATION_S: f64 = 0.1;

/// An arm that turns about the origin under a constant torque, and a cable without tension from an eyelet on the ground over
/// a pulley to an eyelet on the arm. Points are in the frame of their body.
struct Case {
    /// Angle at the start, its rate, and its acceleration.
    motion: [f64; 3],
    on_ground: [f64; 2],
    on_arm: [f64; 2],
    pulley: [f64; 2],
    is_on_arm: bool,
    radius: f64,
    /// −1 for a clockwise turn.
    side: f64,
}

fn rotated([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Distance and direction from one point to another.
fn polar(from: [f64; 2], to: [f64; 2]) -> (f64, f64) {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    (x.hypot(y), y.atan2(x))
}

impl Case {
    fn random(random: &mut Random) -> Self {
        let mut point = |least: f64| {
            let (distance, angle) = (random.within(least, 0.09), random.within(-PI, PI));
            rotated([distance, 0.0], angle)
        };
        let [on_ground, on_arm, pulley] = [point(0.02), point(0.02), point(0.0)];
        let motion = [random.within(-PI, PI), random.within(-40.0, 40.0), random.within(-2000.0, 2000.0)];
        let (side, is_on_arm) = (random.choose(&[-1.0, 1.0]), random.chance(0.5));
        Self { motion, on_ground, on_arm, pulley, is_on_arm, radius: random.within(0.002, 0.02), side }
    }

    fn angle(&self, t: f64) -> f64 {
        let [start, rate, acceleration] = self.motion;
        start + rate * t + 0.5 * acceleration * t * t
    }

    /// Directions of both strands turn by this angle; it is known up to whole turns. Not a number where an eyelet is inside
    /// the pulley.
    fn wrap(&self, t: f64) -> f64 {
        let angle = self.angle(t);
        let pulley = if self.is_on_arm { rotated(self.pulley, angle) } else { self.pulley };
        let (before, after) = (polar(self.on_ground, pulley), polar(pulley, rotated(self.on_arm, angle)));
        let first = before.1 - self.side * (self.radius / before.0).asin();
        let second = after.1 + self.side * (self.radius / after.0).asin();
        self.side * (second - first)
    }

    /// Time of the lift-off; `None` without one, and no result at all if the case is not decided: the cable is not on its
    /// pulley at the start, wraps it too far, or grazes.
    fn lift_off(&self) -> Option<Option<f64>> {
        let at = |i: usize| DURATION_S * i as f64 / SAMPLES as f64;
        let mut wrap = self.wrap(0.0).rem_euclid(TAU);
        if !(0.05..MAX_WRAP_RAD).contains(&wrap) {
            return None;
        }
        let continued = |wrap: f64, t: f64| {
            let found = self.wrap(t);
            found - TAU * ((found - wrap) / TAU).round()
        };
        for i in 1..=SAMPLES {
            let next = continued(wrap, at(i));
            // An eyelet within a millimetre of the pulley turns its strand too fast for the samples.
            if next.is_nan() || next > MAX_WRAP_RAD || (next - wrap).abs() > 0.05 {
                return None;
            }
            if next <= 0.0 {
                let (mut low, mut high) = (at(i - 1), at(i));
                for _ in 0..100 {
                    let middle = 0.5 * (low + high);
                    if continued(wrap, middle) > 0.0 { low = middle } else { high = middle }
                }
                return Some(Some(high));
            }
            if next < GRAZING_RAD {
                return None;
            }
            wrap = next;
        }
        Some(None)
    }

    fn scene(&self) -> String {
        const INERTIA: f64 = 1e-5;
        let millimetres = |[x, y]: [f64; 2]| format!("[\"{:e} mm\", \"{:e} mm\"]", x * 1e3, y * 1e3);
        let [start, rate, acceleration] = self.motion;
        let turn = if self.side < 0.0 { "cw" } else { "ccw" };
        let body = if self.is_on_arm { "arm" } else { "ground" };
        format!(
            "kind = \"mechanism\"\nduration = \"{DURATION_S} s\"\n[bodies.arm]\nmass = \"100 g\"\ninertia = \"{INERTIA:e} kg*m^2\"\n\
             [joints.j]\nbodies = [\"ground\", \"arm\"]\npoints = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\n\
             start = \"{start:e} rad\"\nstart_rate = \"{rate:e} rad/s\"\n[actuators.motor]\njoint = \"j\"\n\
             torque = \"{:e} N*m\"\n[tendons.cable]\npath = [ {{ eyelet = \"ground\", at = {} }}, \
             {{ pulley = \"{body}\", at = {}, radius = \"{:e} mm\", turn = \"{turn}\" }}, \
             {{ eyelet = \"arm\", at = {} }} ]\n[actuators.winch]\ntendon = \"cable\"\ntension = \"0 N\"\n",
            acceleration * INERTIA,
            millimetres(self.on_ground),
            millimetres(self.pulley),
            self.radius * 1e3,
            millimetres(self.on_arm),
        )
    }
}

/// Notes when the cable is off its pulley for the first time.
struct FirstOff<'a> {
    model: &'a MechanismModel,
    time_s: Option<f64>,
}

impl Observer<Dynamic, MechanismMode> for FirstOff<'_> {
    fn step(&mut self, step: &Step<Dynamic>, mode: &MechanismMode, _: &mut dyn StepTools<Dynamic>) -> bool {
        let state = (&step.start.q, &step.start.v);
        self.model.read_elements(step.t0, state, mode, |_, element| {
            if !element.is_on {
                self.time_s.get_or_insert(step.t0);
            }
        });
        self.time_s.is_none()
    }

    fn event(&mut self, _: f64, _: &State<Dynamic>, _: usize, _: &MechanismMode) {}
}

/// Time of the lift-off in the analytic model: that of its event.
fn lift_off_in_analytic_model(scene: &Scene) -> Result<Option<f64>, String> {
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    let start = assemble(mechanism).map_err(|error| error.to_string())?;
    let model = MechanismModel::new(mechanism, (&start.poses, &start.rates)).map_err(|error| error.to_string())?;
    let mut first = FirstOff { model: &model, time_s: None };
    let tolerances = Tolerances { atol_q: 3e-11, atol_v: 3e-7, rtol_v: 3e-7 };
    let options = Options { tolerances, max_steps: 1_000_000 };
    let method = SwitchedMethod::rodas(model.sizes());
    let end = integrate_by(method, &model, &options, 0.0, model.start(), scene.duration_s, &mut first);
    match (first.time_s, end.result) {
        (Some(time_s), _) => Ok(Some(time_s)),
        (None, result) => result.map(|_| None).map_err(|failure| failure.to_string()),
    }
}

/// Time of the lift-off in the engine: that of the first sample without the cable on its pulley.
fn lift_off_in_engine(scene: &Scene) -> Result<Option<f64>, String> {
    let mut scene = scene.clone();
    scene.log.numeric_hz = 1e5;
    let mut run = CollectSink::default();
    // What follows the lift-off does not matter here.
    let result = trace::run(Model::Engine, &scene, &mut run);
    let off = run.samples.iter().find(|sample| sample.cable_element(0).on < 0.5).map(|sample| sample.time_s);
    match (off, result) {
        (Some(time_s), _) => Ok(Some(time_s)),
        (None, result) => result.map(|_| None).map_err(|error| error.to_string()),
    }
}

/// Compares the first lift-off of a run with the expected one; `None` if they agree.
fn disagreement(model: Model, tolerance_s: f64, case: &Case, expected: Option<f64>) -> Option<String> {
    let scene = parse_any(&case.scene(), "case.toml").unwrap_or_else(|error| panic!("{error}\n{}", case.scene()));
    let found = match model {
        Model::Analytic => lift_off_in_analytic_model(&scene),
        Model::Engine => lift_off_in_engine(&scene),
    };
    let agrees = match (expected, &found) {
        (None, Ok(None)) => true,
        (Some(expected), Ok(Some(found))) => (found - expected).abs() <= tolerance_s,
        _ => false,
    };
    (!agrees).then(|| format!("{model:?}: expected {expected:?}, found {found:?}\n{}", case.scene()))
}

fn compare(seed: u64, count: usize) {
    let mut random = Random::for_seed(seed);
    let decided = std::iter::from_fn(|| {
        let case = Case::random(&mut random);
        Some(case.lift_off().map(|expected| (case, expected)))
    });
    let cases: Vec<(Case, Option<f64>)> = decided.flatten().take(count).collect();
    let lifted = cases.iter().filter(|(_, expected)| expected.is_some()).count();
    let failures: Vec<String> = cases
        .iter()
        .flat_map(|(case, expected)| {
            TOLERANCES_S
                .into_iter()
                .filter_map(|(model, tolerance_s)| disagreement(model, tolerance_s, case, *expected))
        })
        .collect();
    assert!(failures.is_empty(), "{} of {count}: {}", failures.len(), failures[..failures.len().min(3)].join("\n"));
    assert!((count / 4..count).contains(&lifted), "{lifted} of {count} cables lift off");
}

#[test]
fn random_cables_lift_off_when_their_closed_forms_do() {
    compare(57_100, 300);
}
