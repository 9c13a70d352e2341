//! Cables that lift off pulleys and rub on them: readings against the reference solutions, closed forms, and ends of runs.

use phalanx::analytic::mechanism::{ElementReading, MechanismMode, MechanismModel};
use phalanx::criteria::{CableEventKind, CableEvents};
use phalanx::integrator::{
    Dynamic, Method, Observer, Options, State, Step, StepTools, SwitchedMethod, Tolerances, integrate_by,
};
use phalanx::law::friction_coefficient;
use phalanx::scene::{Integrator, Preset, Scene, parse_any};
use phalanx::trace::{self, Decimated, Model, Sample};

use crate::support::mechanism_cases::{ElementValues, MechanismCase, cable_cases};
use crate::support::runs::CollectSink;

/// Checks the path elements of a case at all its samples, and finds the times of its lift-offs and returns.
struct Elements<'a> {
    model: &'a MechanismModel,
    case: &'a MechanismCase,
    next: usize,
    on: Vec<bool>,
    /// Time, and whether the cable returns.
    changes: Vec<(f64, bool)>,
}

impl Elements<'_> {
    fn read(&self, t: f64, state: &State<Dynamic>, mode: &MechanismMode) -> Vec<ElementReading> {
        let mut all = Vec::new();
        self.model.read_elements(t, (&state.q, &state.v), mode, |_, reading| all.push(reading));
        all
    }

    fn compare(&mut self, state: &State<Dynamic>, mode: &MechanismMode) {
        let (name, sample) = (&self.case.name, &self.case.samples[self.next]);
        let found = self.read(sample.time_s, state, mode);
        assert_eq!(found.len(), sample.elements.len(), "{name}");
        for (found, expected) in found.iter().zip(&sample.elements) {
            let ElementValues { is_on, wrap_rad, slip_m_s, tension_n } = *expected;
            let t = sample.time_s;
            assert_eq!(found.is_on, is_on, "{name} at {t} s: {found:?}, {expected:?}");
            if !is_on {
                assert!(found.gap >= -1e-9, "{name} at {t} s: {found:?}");
                continue;
            }
            assert!((found.turn.max(0.0) - wrap_rad).abs() < 1e-7, "{name} at {t} s: {found:?}, {expected:?}");
            let slip_error = slip_m_s.map_or(0.0, |slip_m_s| (found.slip - slip_m_s).abs());
            assert!(slip_error < 1e-6, "{name} at {t} s: {found:?}, {expected:?}");
            let largest = self.case.samples.iter().flat_map(|sample| &sample.tendons).map(|[_, tension]| *tension);
            let scale = largest.fold(0.0, f64::max);
            assert!((found.tension - tension_n).abs() < 1e-5 * scale, "{name} at {t} s: {found:?}, {expected:?}");
        }
        self.next += 1;
    }
}

impl Observer<Dynamic, MechanismMode> for Elements<'_> {
    fn step(&mut self, step: &Step<Dynamic>, mode: &MechanismMode, tools: &mut dyn StepTools<Dynamic>) -> bool {
        let on: Vec<bool> = self.read(step.t0, step.start, mode).iter().map(|element| element.is_on).collect();
        let before = std::mem::replace(&mut self.on, on.clone());
        let changed = before.iter().zip(&on).filter(|(before, now)| before != now);
        self.changes.extend(changed.map(|(_, now)| (step.t0, *now)));
        while let Some(sample) = self.case.samples.get(self.next) {
            let theta = (sample.time_s - step.t0) / step.h;
            if theta > 1.0 + 1e-9 {
                break;
            }
            let state = if theta < 1.0 { tools.resolve(theta).clone() } else { step.end.clone() };
            self.compare(&state, mode);
        }
        true
    }

    fn event(&mut self, _: f64, _: &State<Dynamic>, _: usize, _: &MechanismMode) {}
}

/// Wraps, speeds and tensions at all samples, and the times of lift-offs and returns.
#[test]
fn places_of_cables_agree_with_the_reference_solutions() {
    let tolerances = Tolerances { atol_q: 1e-14, atol_v: 1e-9, rtol_v: 1e-11 };
    for case in cable_cases() {
        let model = MechanismModel::new(&case.mechanism, (&case.start.poses, &case.start.rates)).expect("a model");
        let mut elements = Elements { model: &model, case: &case, next: 0, on: Vec::new(), changes: Vec::new() };
        let options = Options { tolerances, max_steps: 1_000_000 };
        let method: SwitchedMethod<Dynamic> = Method::new(model.sizes());
        let end = integrate_by(method, &model, &options, 0.0, model.start(), case.duration_s, &mut elements);
        end.result.unwrap_or_else(|failure| panic!("{}: {failure}", case.name));
        assert_eq!(elements.next, case.samples.len(), "{}", case.name);
        let expected: Vec<(f64, bool)> = case
            .events
            .iter()
            .filter(|(_, name, _)| name.ends_with(" wrap"))
            .map(|(time_s, _, rises)| (*time_s, *rises))
            .collect();
        assert_eq!(elements.changes.len(), expected.len(), "{}: {:?}", case.name, elements.changes);
        for (found, expected) in elements.changes.iter().zip(&expected) {
            assert!((found.0 - expected.0).abs() < 1e-8 && found.1 == expected.1, "{found:?}, {expected:?}");
        }
    }
}

/// Lift-offs and returns in the criteria of a run, with and without selected samples, against the reference solutions.
#[test]
fn runs_list_the_events_of_cables() {
    for case in cable_cases() {
        let expected: Vec<(f64, &str, bool)> = case
            .events
            .iter()
            .filter_map(|(time_s, name, rises)| Some((*time_s, name.strip_suffix(" wrap")?, *rises)))
            .collect();
        for (model, tolerance_s) in [(Model::Analytic, 2e-6), (Model::Engine, 2e-4)] {
            let mut scene = case.scene();
            scene.integrator = Integrator::preset(Preset::Reference);
            let Some(sink) = CableEvents::for_mechanism(&case.mechanism) else {
                assert!(expected.is_empty(), "{}", case.name);
                continue;
            };
            let mut sinks = (sink.clone(), Decimated::new(scene.log.numeric_hz, sink));
            trace::run(model, &scene, &mut sinks).unwrap_or_else(|error| panic!("{}: {error}", case.name));
            sinks.1.end().expect("no error");
            let (found, name) = (sinks.0.events(), format!("{model:?} {}", case.name));
            assert_eq!(found, sinks.1.sink.events(), "{name}");
            assert_eq!(found.len(), expected.len(), "{name}: {found:?}");
            for (found, (time_s, place, returns)) in found.iter().zip(&expected) {
                assert_eq!(
                    (found.place.as_str(), found.event == CableEventKind::Returns),
                    (*place, *returns),
                    "{name}"
                );
                assert!((found.time_s - time_s).abs() < tolerance_s, "{name}: {found:?}, not {time_s}");
            }
        }
    }
}

/// Returns a run of a case at a preset, with its samples.
fn run(case: &MechanismCase, model: Model, preset: Option<Preset>) -> CollectSink {
    let mut scene = case.scene();
    scene.log.numeric_hz = 1.0 / case.samples[1].time_s;
    preset.into_iter().for_each(|preset| scene.integrator = Integrator::preset(preset));
    let mut run = CollectSink::default();
    trace::run(model, &scene, &mut run).unwrap_or_else(|error| panic!("{}: {error}", case.name));
    run
}

fn case(name: &str) -> MechanismCase {
    cable_cases().into_iter().find(|case| case.name == name).expect("a case")
}

/// Behind a cylinder with the wrap π, the tension is exp(−μ(v) π) times the tension before it, at every speed and in both
/// models.
#[test]
fn the_tension_ratio_is_that_of_the_capstan() {
    for name in ["k_capstan_load", "k_hysteresis", "k_drum_brake"] {
        let case = case(name);
        let law = case.mechanism.tendons[0].path[1].friction.expect("friction");
        // Samples of the engine between nodes are interpolated.
        for (model, bound) in [(Model::Analytic, 1e-9), (Model::Engine, 1e-6)] {
            for sample in &run(&case, model, None).samples {
                let (place, tension_n) = (sample.cable_element(0), sample.tendon(0).tension_n);
                let expected = tension_n * (-friction_coefficient(&law, place.slip_m_s).0 * std::f64::consts::PI).exp();
                let difference = (place.tension_n - expected).abs();
                assert!(difference <= bound * tension_n.max(1.0), "{name}, {model:?}: {place:?}, {expected}");
            }
        }
    }
}

/// A pulley that is fixed to a drum brakes it with r (T2 − T1), a constant moment.
#[test]
fn a_drum_is_braked_by_the_difference_of_both_tensions() {
    let case = case("k_drum_brake");
    let moment = 0.02 * 5.0 * (1.0 - (0.15 * std::f64::consts::PI).exp());
    let acceleration = moment / 1e-4;
    for sample in &run(&case, Model::Analytic, Some(Preset::Reference)).samples {
        let t = sample.time_s;
        let expected = 40.0 * t + 0.5 * acceleration * t * t;
        assert!((sample.joint_state(0).angle_rad - expected).abs() < 1e-9, "at {t} s");
        let friction_j = -moment * expected;
        assert!((sample.energy().cable_friction_j - friction_j).abs() < 1e-9, "at {t} s: {:?}", sample.energy());
    }
}

/// The work of the friction of cables is that of the reference solutions, and both models balance their energy.
#[test]
fn the_work_of_friction_agrees_in_both_models() {
    for case in cable_cases() {
        for (model, bound) in [(Model::Analytic, 1e-6), (Model::Engine, 1e-3)] {
            let found = run(&case, model, None);
            for expected in &case.samples {
                let is_at = |sample: &&Sample| (sample.time_s - expected.time_s).abs() < 1e-9;
                let energy = found.samples.iter().rfind(is_at).expect("a sample").energy();
                let work = -expected.energies["cable_friction_work"];
                let scale =
                    case.samples.iter().map(|sample| sample.energies["actuator_work"].abs()).fold(1e-4, f64::max);
                let (name, t) = (&case.name, expected.time_s);
                let difference = (energy.cable_friction_j - work).abs();
                assert!(difference < bound * scale, "{name}, {model:?} at {t} s: {energy:?}, {work}");
                assert!(energy.balance_j.abs() < bound * scale, "{name}, {model:?} at {t} s: {energy:?}");
            }
        }
    }
}

/// A finger whose cable passes a ring between two eyelets, all on its own body, `offset` millimetres beside their line.
fn ring(offset: f64, friction: &str) -> Scene {
    let text = format!(
        "kind = \"mechanism\"\nduration = \"100 ms\"\ngravity = [\"0 m/s^2\", \"-9.81 m/s^2\"]\n[bodies.finger]\nmass = \"50 g\"\n\
         inertia = \"2e-5 kg*m^2\"\ncom = [\"30 mm\", \"0 mm\"]\n[joints.q]\nbodies = [\"ground\", \"finger\"]\n\
         points = [[\"0 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"0.3 rad\"\nstart_rate = \"20 rad/s\"\n\
         [tendons.t]\n{friction}\npath = [\n{{ eyelet = \"ground\", at = [\"-40 mm\", \"13 mm\"] }},\n\
         {{ eyelet = \"finger\", at = [\"10 mm\", \"9 mm\"] }},\n\
         {{ pulley = \"finger\", at = [\"30 mm\", \"{} mm\"], radius = \"3 mm\", turn = \"ccw\" }},\n\
         {{ eyelet = \"finger\", at = [\"50 mm\", \"9 mm\"] }} ]\n[actuators.pull]\ntendon = \"t\"\ntension = \"2 N\"\n",
        12.0 + offset
    );
    parse_any(&text, "ring.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// A ring that is tangent to the line of its neighbours on the same body has a wrap of 0 up to rounding for ever. It is neither
/// lifted off again and again, nor does it change the motion.
#[test]
fn a_ring_tangent_to_the_line_of_its_neighbours_causes_no_events() {
    let friction = "friction = { mu_static = 0.2 }";
    let steps = |offset: f64, friction: &str| {
        let scene = ring(offset, friction);
        let outcome = trace::run(Model::Analytic, &scene, &mut ()).unwrap_or_else(|error| panic!("{error}"));
        (outcome.work.steps, outcome.last.joint_state(0).angle_rad)
    };
    for friction in ["", friction] {
        let (free, angle) = steps(-1.0, friction);
        for offset in [0.0, 1e-12, -1e-12] {
            let (tangent, tangent_angle) = steps(offset, friction);
            assert!(tangent < free + free / 4 + 20, "{tangent} steps, {free} without the ring");
            assert!((tangent_angle - angle).abs() < 1e-6, "{tangent_angle}, {angle}");
        }
    }
}

/// The end of a cable swings round a pulley that the cable has left, and pulls the cable to its back: the run ends with the
/// names of tendon and pulley, in both models.
#[test]
fn a_cable_that_comes_round_the_back_of_a_pulley_ends_the_run() {
    let text = "kind = \"mechanism\"\nduration = \"200 ms\"\n[bodies.arm]\nmass = \"50 g\"\ninertia = \"2e-5 kg*m^2\"\n\
         guess = { at = [\"50 mm\", \"0 mm\"] }\n[joints.q]\nbodies = [\"ground\", \"arm\"]\n\
         points = [[\"50 mm\", \"0 mm\"], [\"0 mm\", \"0 mm\"]]\nstart = \"-63 deg\"\nstart_rate = \"-30 rad/s\"\n\
         [tendons.t]\npath = [\n{ eyelet = \"ground\", at = [\"0 mm\", \"0 mm\"] },\n\
         { pulley = \"ground\", at = [\"50 mm\", \"0 mm\"], radius = \"3 mm\", turn = \"ccw\" },\n\
         { eyelet = \"arm\", at = [\"22 mm\", \"0 mm\"] } ]\n[actuators.pull]\ntendon = \"t\"\ntension = \"0 N\"\n";
    let scene = parse_any(text, "back.toml").unwrap_or_else(|error| panic!("{error}"));
    for model in [Model::Analytic, Model::Engine] {
        let mut run = CollectSink::default();
        let result = trace::run(model, &scene, &mut run);
        let error = result.expect_err("an end").to_string();
        assert!(
            error.contains("tendon t came round the back") && error.contains("place 2 of its path"),
            "{model:?}: {error}"
        );
    }
}
