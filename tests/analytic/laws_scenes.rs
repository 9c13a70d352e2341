//! The shipped scenes of discs: loading, `show`, the values in their comments in both models, `validate`, and the
//! commands.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;

use crate::support::cli::{
    assert_contains, assert_rejected, assert_status, directory, path_in, path_text, run_json, stdout, succeed, write,
};
use crate::support::laws::BOTH_MODELS;
use crate::support::runs::{assert_near, assert_relative, engineering_settings, run_model};
use mcap::{MessageStream, Summary};
use phalanx::criteria::Rebounds;
use phalanx::invariants::Finding;
use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Event, Model, Outcome, Sample, Schema, Sink, SinkError};
use phalanx::validate::{
    check_bounds, check_invariants, compare, compared_scene, record, reference_scene, sampled_scene,
};

/// Names of all shipped scenes of discs.
fn names() -> Vec<String> {
    let files = fs::read_dir("scenes/laws").expect("scenes/laws").map(|entry| entry.expect("entry").path());
    let names: Vec<_> = files.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    assert_eq!(names.len(), 15, "{names:?}");
    names
}

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/laws/{name}.toml")).unwrap_or_else(|e| panic!("{e}"))
}

fn load_reference(name: &str) -> Scene {
    let mut scene = load(name);
    scene.apply_preset(Preset::Reference);
    scene
}

#[derive(Default)]
struct RunObserver {
    rebounds: Rebounds,
    first_sample: Option<Sample>,
    /// Largest friction force, and the slip at it.
    friction: (f64, f64),
}

impl Sink for RunObserver {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.first_sample.get_or_insert_with(|| sample.clone());
        for contact in sample.contacts() {
            // The engine reports the mean force of a step, in which slow slip may reverse.
            let opposes_slip = contact.tangential_n * contact.slip_m_s <= 0.0 || contact.slip_m_s.abs() < 1e-3;
            assert!(opposes_slip, "friction does not oppose slip: {contact:?}");
            if contact.tangential_n.abs() > self.friction.0 {
                self.friction = (contact.tangential_n.abs(), contact.slip_m_s.abs());
            }
        }
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.rebounds.event(event)
    }
}

fn run(model: Model, name: &str) -> (Outcome, RunObserver) {
    let scene = load_reference(name);
    let rebounds = Rebounds::for_mechanism(scene.mechanism.as_ref().expect("discs")).expect("no joints");
    let mut observer = RunObserver { rebounds, ..RunObserver::default() };
    let outcome =
        crate::support::checked_run::run(model, &scene, &mut observer).unwrap_or_else(|e| panic!("{name}: {e}"));
    (outcome, observer)
}

#[test]
fn scenes_have_expectations_and_round_trip_through_show() {
    for name in names() {
        let scene = load(&name);
        assert_eq!(scene.name, name);
        assert!(scene.source.starts_with("# ") && scene.source.contains("\n# Expect: "), "{name}");
        let text = scene::show(&scene);
        let parsed = scene::parse_any(&text, "shown.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(Scene { source: scene.source.clone(), ..parsed }, scene);
    }
}

/// The engine is within the bounds of each scene and has the same number of touch-downs as the analytic model.
#[test]
fn the_engine_satisfies_the_bounds_of_every_scene() {
    for name in names() {
        let scene = compared_scene(&load(&name));
        let expected = record(Model::Analytic, &reference_scene(&scene)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let actual =
            record(Model::Engine, &sampled_scene(Model::Engine, &scene)).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (model, scene, run) in
            [(Model::Analytic, reference_scene(&scene), &expected), (Model::Engine, scene.clone(), &actual)]
        {
            let violations: Vec<_> =
                check_invariants(&scene, model, run).into_iter().filter(Finding::is_violated).collect();
            assert!(violations.is_empty(), "{name}: {violations:?}");
        }
        let verdict = check_bounds(&compare(&actual, &expected, scene.bounds.until_s), &scene.bounds);
        assert!(verdict.passed(), "{name}: {verdict:#?}");
        for (actual, expected) in actual.outcome.contacts.iter().zip(&expected.outcome.contacts) {
            assert_eq!(actual.touchdowns, expected.touchdowns, "{name}");
        }
    }
}

#[test]
fn driven_discs_give_the_values_in_their_comments() {
    for model in BOTH_MODELS {
        let (spring, _) = run(model, "spring");
        assert_relative(spring.contacts[0].peak_normal_n, 18292.2, 1e-5, "spring: peak");
        assert_relative(spring.contacts[0].impulse_n_s, 114.326, 1e-4, "spring: impulse");
        assert_relative(spring.last.energy().motor_work_j, 114.326, 1e-4, "spring: work");
        assert_relative(spring.last.energy().elastic_j, 114.326, 1e-4, "spring: energy");

        let (damper, _) = run(model, "damper");
        assert_relative(damper.contacts[0].peak_normal_n, 1e4, 1e-9, "damper: peak");
        assert_relative(damper.contacts[0].impulse_n_s, 40.0, 1e-4, "damper: impulse");
        assert_relative(damper.last.energy().dissipated_j, 40.0, 1e-4, "damper: energy");
        assert_eq!(damper.last.energy().elastic_j, 0.0);

        let (friction, observer) = run(model, "friction");
        assert_relative(friction.contacts[0].peak_normal_n, 25.1189, 1e-5, "friction: peak");
        assert_relative(friction.contacts[0].impulse_n_s, 2.51189, 1e-5, "friction: impulse");
        assert_relative(observer.friction.0, 0.8 * 25.1189, 1e-4, "friction: largest force");
        assert_relative(observer.friction.1, 0.1, 0.02, "friction: slip at the largest force");
        assert_relative(friction.last.contact(0).tangential_n.abs(), 0.56 * 25.1189, 1e-5, "friction: final force");
        assert_relative(friction.last.energy().motor_work_j, 0.227409, 1e-5, "friction: work");
    }
}

#[test]
fn impacts_give_the_values_in_their_comments() {
    for (model, relative) in [(Model::Analytic, 2e-5), (Model::Engine, 1e-3)] {
        for (name, values, tolerances, restitution, dissipated_j) in [
            ("impact", [62.105, 1.4936e-3, 0.16010], [0.0, 3e-5, 3e-5], Some(0.60104), 31.938e-3),
            ("impact-elastic", [89.7083, 1.78356e-3, 0.2], [0.0; 3], Some(1.0), 0.0),
            ("impact-damper", [95.0885, 1.05e-3, 0.1], [0.0; 3], None, 50e-3),
        ] {
            let (outcome, observer) = run(model, name);
            let contact = &outcome.contacts[0];
            let actual = [contact.peak_normal_n, contact.max_penetration_m, contact.impulse_n_s];
            for ((actual, expected), more) in actual.into_iter().zip(values).zip(tolerances) {
                assert_relative(actual, expected, relative + more, format!("{name}, {model:?}"));
            }
            let actual_restitution = observer.rebounds.pairs()[0].restitution();
            assert_eq!(actual_restitution.is_some(), restitution.is_some(), "{name}, {model:?}");
            if let (Some(actual), Some(expected)) = (actual_restitution, restitution) {
                assert_relative(actual, expected, relative, format!("{name}, {model:?}: restitution"));
                assert_relative(contact.first_s.expect("a contact"), 5e-3, 1e-9, format!("{name}: first contact"));
            } else {
                assert!(outcome.last.body(1).velocity_m_s[0].abs() < 1e-6, "{name}: the damper stops the disc");
            }
            // Losses are relative to the initial energy of 50 mJ if there are none.
            let scale_j = if dissipated_j == 0.0 { 50e-3 } else { dissipated_j };
            assert_near(outcome.last.energy().dissipated_j, dissipated_j, relative * scale_j, name);
        }
    }
}

/// Thesis Figs. B.4–B.6: discs of equal mass with radii of 0.05, 5 and 10 cm hit a disc of 10 cm at the same speed. Force
/// over time does not depend on the radius, to rounding in both models. The steps of the engine are common to all three
/// discs.
#[test]
fn impacts_do_not_depend_on_the_radius() {
    let scene = load_reference("radii");
    for (model, relative) in [(Model::Analytic, 1e-4), (Model::Engine, 2e-3)] {
        let (outcome, observer) = run(model, "radii");
        let pairs: Vec<usize> =
            (0..outcome.contacts.len()).filter(|&k| outcome.contacts[k].first_s.is_some()).collect();
        let contacts = Schema::from_scene(&scene).contacts;
        let names: Vec<&str> = pairs.iter().map(|&k| contacts[k].name.as_str()).collect();
        assert_eq!(names, ["large-target", "medium-target", "small-target"]);
        for &pair in &pairs {
            let summary = &outcome.contacts[pair];
            assert_eq!(summary.touchdowns, 1);
            assert_relative(summary.first_s.expect("a contact"), 5e-3, 1e-9, "first contact");
            assert_relative(summary.peak_normal_n, 348.1, relative + 2e-4, "peak");
            assert_relative(summary.max_penetration_m, 0.4071e-3, relative + 1e-4, "penetration");
            let restitution = observer.rebounds.pairs()[pair].restitution().expect("a separation");
            assert_relative(restitution, 0.8862, relative, "restitution");
            // The pairs agree with each other more closely than with the closed form.
            let other = &outcome.contacts[pairs[0]];
            assert_relative(summary.peak_normal_n, other.peak_normal_n, 1e-9, "other pair");
            assert_relative(summary.impulse_n_s, other.impulse_n_s, 1e-9, "other pair");
        }
        let (_, log) = run_model(model, &scene);
        let peak = outcome.contacts[pairs[0]].peak_normal_n;
        let forces = log.samples.iter().map(|sample| [0, 1, 2].map(|k: usize| sample.contact(pairs[k]).normal_n));
        let mut active_samples = 0;
        for [first, second, third] in forces {
            active_samples += u32::from(first > 0.1 * peak);
            assert_near(second, first, 1e-9 * peak, format!("{model:?}: other pair"));
            assert_near(third, first, 1e-9 * peak, format!("{model:?}: other pair"));
        }
        assert!(active_samples > 10, "{model:?}: {active_samples}");
    }
    // The engineering preset is close to the reference, with fewer steps.
    let [fine, coarse] = [scene.integrator, engineering_settings()]
        .map(|integrator| run_model(Model::Analytic, &Scene { integrator, ..scene.clone() }).0);
    for (a, b) in fine.last.bodies().zip(coarse.last.bodies()) {
        let is_near = |axis: usize| (a.centre_m[axis] - b.centre_m[axis]).abs() < 1e-7;
        assert!(is_near(0) && is_near(1), "{a:?} {b:?}");
    }
    assert!(coarse.work.steps < fine.work.steps);
}

#[test]
fn a_sliding_disc_ends_up_rolling() {
    // Sliding at −0.3 g until 1/(3 × 0.3 × 9.81) s, then rolling at two thirds of the speed.
    let sliding_s = 1.0 / (3.0 * 0.3 * 9.81);
    let distance = sliding_s - 0.5 * 0.3 * 9.81 * sliding_s * sliding_s + 2.0 / 3.0 * (0.2 - sliding_s);
    for model in BOTH_MODELS {
        let (outcome, observer) = run(model, "rolling");
        let wheel = outcome.last.body(0);
        assert_relative(wheel.velocity_m_s[0], 2.0 / 3.0, 1e-6, "speed");
        assert_relative(wheel.spin_rad_s, -40.0 / 3.0, 1e-6, "spin");
        assert_relative(observer.friction.0, 0.3 * 0.981, 1e-5, "largest friction");
        assert_relative(outcome.last.energy().dissipated_j, 50e-3 / 3.0, 1e-4, "dissipated energy");
        assert_relative(wheel.centre_m[0], distance, 1e-3, "distance");
    }
}

/// Friction acts on each disc at its own surface. The surfaces overlap, so angular momentum is conserved only up to the
/// moment of friction about the overlap.
#[test]
fn two_free_discs_conserve_momentum() {
    let scene = load("two-free");
    let names: Vec<&str> = scene.mechanism.iter().flat_map(|of| &of.bodies).map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["striker", "struck"]);
    let momenta = |sample: &Sample| {
        let mut sums = [0.0; 3];
        for (disc, mass) in sample.bodies().zip([0.1, 0.3]) {
            let ([x, y], [vx, vy]) = (disc.centre_m, disc.velocity_m_s);
            sums[0] += mass * vx;
            sums[1] += mass * vy;
            sums[2] += mass * (x * vy - y * vx) + 0.5 * mass * 0.05 * 0.05 * disc.spin_rad_s;
        }
        sums
    };
    for model in BOTH_MODELS {
        let (outcome, observer) = run(model, "two-free");
        let [before, after] = [momenta(&observer.first_sample.expect("a sample")), momenta(&outcome.last)];
        let moment = 0.5 * outcome.contacts[0].impulse_n_s * outcome.contacts[0].max_penetration_m;
        for (k, (expected, tolerance)) in [(0.1, 1e-9), (0.0, 1e-9), (3e-3, moment)].into_iter().enumerate() {
            assert!((before[k] - expected).abs() < 1e-15);
            assert_near(after[k], expected, tolerance, format!("{model:?}: component {k}"));
        }
        assert!(outcome.last.body(1).velocity_m_s[0] > 0.3 && outcome.last.energy().dissipated_j > 0.02);
    }
}

const IMPACT: &str = "scenes/laws/impact.toml";

#[test]
fn run_reports_text_and_json() {
    for model in ["analytic", "engine"] {
        let text = succeed(&["run", IMPACT, "--model", model]);
        let parts = ["impact: ", model, "hammer-anvil", "5.000000", "restitution", "0.60"];
        assert_contains(&text, &[&parts[..], &["hammer    free", "drive work"]].concat());
        let document = run_json(&["run", IMPACT, "--model", model, "--json"]);
        assert_eq!((&document["kind"], &document["model"]), (&"bodies".into(), &model.into()));
        let pair = &document["contacts"]["hammer-anvil"];
        for key in ["first_s", "peak_normal_n", "max_penetration_m", "impulse_n_s", "restitution", "final_normal_n"] {
            assert!(pair[key].is_number(), "{key}");
        }
        assert_eq!(pair["touchdowns"], 1);
        assert_eq!(document["bodies"]["hammer"]["motion"], "free");
        assert!(document["bodies"]["hammer"]["vx_m_s"].as_f64().expect("a speed") < -0.6);
        assert!(document["energy"]["dissipated_j"].is_number() && document["error"].is_null());
        assert_eq!(document["engine"].is_null(), model == "analytic");
    }
}

#[test]
fn flags_override_the_scene_and_finger_flags_are_rejected() {
    let document = run_json(&["run", IMPACT, "--duration", "1 ms", "--preset", "reference", "--json"]);
    assert_eq!((&document["end_s"], &document["integrator"]["preset"]), (&0.001.into(), &"reference".into()));
    let document = run_json(&["run", IMPACT, "--model", "engine", "--step", "50 us", "--json"]);
    assert_eq!((&document["steps"], &document["engine"]["step_s"]), (&300.into(), &5e-5.into()));
    // The analytic model has no fixed step.
    assert_rejected(&["run", IMPACT, "--step", "1 us"], &[]);
}

#[test]
fn logs_contain_discs_pairs_events_and_scene() {
    let directory = directory("laws_log");
    let [log, other] = ["a.mcap", "b.mcap"].map(|name| {
        let path = path_in(&directory, name);
        succeed(&["run", "scenes/laws/two-free.toml", "--log", &path]);
        fs::read(path).expect("a log")
    });
    assert!(log == other, "the logs differ");
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for message in MessageStream::new(&log).expect("a log") {
        let message = message.expect("readable");
        assert_eq!(message.channel.message_encoding, "protobuf");
        assert!(message.channel.schema.as_ref().is_some_and(|schema| !schema.data.is_empty()));
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    assert_eq!(
        counts.keys().map(String::as_str).collect::<Vec<_>>().join(" "),
        "/body/striker /body/struck /contact/striker-struck /energy /event /events /forces /scene /tf /tf_static"
    );
    // Touch-down, lift-off, and the end of the run.
    assert_eq!((counts["/event"], counts["/events"]), (2, 3));
    assert!(counts["/body/striker"] > 150 && counts["/body/striker"] == counts["/energy"]);
    let summary = Summary::read(&log).expect("readable").expect("indexed");
    assert_eq!(summary.attachment_indexes[0].name, "two-free.toml");
    let record = mcap::read::metadata(&log, &summary.metadata_indexes[0]).expect("readable");
    assert_eq!((record.metadata["kind"].as_str(), record.metadata["scene"].as_str()), ("bodies", "two-free"));
}

#[test]
fn validate_writes_report_and_files() {
    let directory = directory("laws_validate");
    let report = run_json(&["validate", IMPACT, "--quick", "--json", "--out", path_text(&directory)]);
    assert_eq!((&report["kind"], &report["passed"]), (&"bodies".into(), &true.into()));
    let bounds: Vec<_> = report["verdict"].as_array().expect("a list").iter().map(|c| c["bound"].as_str()).collect();
    assert_eq!(bounds[..5], ["angle_rad", "position_m", "contact_time_s", "impulse", "peak_force"].map(Some));
    assert!(report["differences"]["bodies"]["hammer"]["max_m"].as_f64().expect("a figure") > 0.0);
    assert!(report["differences"]["contacts"]["hammer-anvil"]["impulse"].is_number());
    let settings = report["settings"].as_array().expect("a list");
    // On a loaded machine the time limit of the ladder omits its slowest settings.
    let may_be = |setting: &Value| ["done", "no_time"].map(Value::from).contains(&setting["status"]);
    assert!(settings.iter().all(may_be), "{settings:?}");
    assert!(settings.iter().filter(|setting| setting["status"] == "done").count() >= 5, "{settings:?}");
    assert!(settings.iter().any(|setting| setting["own"] == true && setting["position_max_m"].is_number()));
    let read = |name: &str| fs::read_to_string(directory.join(name)).expect("text");
    for file in report["files"].as_array().expect("a list") {
        let path = directory.join(file.as_str().expect("a name"));
        assert!(fs::metadata(path).expect("written").len() > 100, "{file}");
    }
    assert!(read("series.csv").starts_with("time_s,hammer_x_m_analytic,hammer_x_m_engine,"));
    assert!(read("overlay.svg").contains("normal force, N"));
}

#[test]
fn validate_exits_with_1_if_a_bound_is_exceeded() {
    let text = fs::read_to_string(IMPACT).expect("text");
    let tight = format!("{text}\n[validate]\nimpulse = 1e-12\nuntil = \"7 ms\"\n");
    let file = write(&directory("laws_out_of_bounds"), "tight.toml", &tight);
    let output = assert_status(&["validate", &file, "--quick"], 1, &[]);
    assert_contains(stdout(&output), &["OUT OF BOUNDS", "up to 7 ms of 15 ms"]);
}
