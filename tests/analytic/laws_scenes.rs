//! The shipped scenes of discs: loading, `show`, the values in their comments in both models, `validate`, and the
//! commands.

use std::collections::BTreeMap;
use std::fs;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use mcap::{MessageStream, Summary};
use phalanx::criteria::Rebounds;
use phalanx::invariants::Finding;
use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Event, Model, Outcome, Sample, Sink, SinkError};
use phalanx::validate::{
    check_bounds, check_invariants, compare, compared_scene, record, reference_scene, sampled_scene,
};

const BOTH_MODELS: [Model; 2] = [Model::Analytic, Model::Engine];
const NAMES: [&str; 15] = [
    "bristle-holds",
    "bristle-jams",
    "bristle-rolls",
    "bristle-slides",
    "bristle-stick-slip",
    "damper",
    "friction",
    "impact",
    "impact-damper",
    "impact-elastic",
    "radii",
    "rolling",
    "spring",
    "step-size",
    "two-free",
];

fn load(name: &str) -> Scene {
    scene::load_any(format!("scenes/laws/{name}.toml")).unwrap_or_else(|e| panic!("{e}"))
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
    let mut scene = load(name);
    scene.apply_preset(Preset::Reference);
    let pairs = scene.system.pairs().len();
    let mut observer = RunObserver { rebounds: Rebounds::new(pairs), ..RunObserver::default() };
    let outcome =
        crate::support::checked_run::run(model, &scene, &mut observer).unwrap_or_else(|e| panic!("{name}: {e}"));
    (outcome, observer)
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, relative: f64) {
    assert!((actual - expected).abs() <= relative * expected.abs(), "{actual} instead of {expected}");
}

#[test]
fn scenes_have_expectations_and_round_trip_through_show() {
    let mut files: Vec<String> = fs::read_dir("scenes/laws")
        .expect("scenes/laws")
        .map(|entry| entry.expect("entry").path().file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    files.sort();
    assert_eq!(files, NAMES);
    for name in NAMES {
        let scene = load(name);
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
    for name in NAMES {
        let scene = compared_scene(&load(name));
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
        assert_near(spring.contacts[0].peak_normal_n, 18292.2, 1e-5);
        assert_near(spring.contacts[0].impulse_n_s, 114.326, 1e-4);
        assert_near(spring.last.energy().motor_work_j, 114.326, 1e-4);
        assert_near(spring.last.energy().elastic_j, 114.326, 1e-4);

        let (damper, _) = run(model, "damper");
        assert_near(damper.contacts[0].peak_normal_n, 1e4, 1e-9);
        assert_near(damper.contacts[0].impulse_n_s, 40.0, 1e-4);
        assert_near(damper.last.energy().dissipated_j, 40.0, 1e-4);
        assert_eq!(damper.last.energy().elastic_j, 0.0);

        let (friction, observer) = run(model, "friction");
        assert_near(friction.contacts[0].peak_normal_n, 25.1189, 1e-5);
        assert_near(friction.contacts[0].impulse_n_s, 2.51189, 1e-5);
        assert_near(observer.friction.0, 0.8 * 25.1189, 1e-4);
        assert_near(observer.friction.1, 0.1, 0.02);
        assert_near(friction.last.contact(0).tangential_n.abs(), 0.56 * 25.1189, 1e-5);
        assert_near(friction.last.energy().motor_work_j, 0.227409, 1e-5);
    }
}

#[test]
fn impacts_give_the_values_in_their_comments() {
    for (model, relative) in [(Model::Analytic, 2e-5), (Model::Engine, 1e-3)] {
        let (impact, observer) = run(model, "impact");
        assert_near(impact.contacts[0].first_s.expect("a contact"), 5e-3, 1e-9);
        assert_near(impact.contacts[0].peak_normal_n, 62.105, relative);
        assert_near(impact.contacts[0].max_penetration_m, 1.4936e-3, relative + 3e-5);
        assert_near(observer.rebounds.pairs()[0].restitution().expect("a separation"), 0.60104, relative);
        assert_near(impact.contacts[0].impulse_n_s, 0.16010, relative + 3e-5);
        assert_near(impact.last.energy().dissipated_j, 31.938e-3, relative);

        let (elastic, observer) = run(model, "impact-elastic");
        assert_near(observer.rebounds.pairs()[0].restitution().expect("a separation"), 1.0, relative);
        assert_near(elastic.contacts[0].impulse_n_s, 0.2, relative);
        assert_near(elastic.contacts[0].max_penetration_m, 1.78356e-3, relative);
        assert_near(elastic.contacts[0].peak_normal_n, 89.7083, relative);
        assert!(elastic.last.energy().dissipated_j.abs() < relative * 50e-3);

        let (damped, observer) = run(model, "impact-damper");
        assert_eq!(observer.rebounds.pairs()[0].restitution(), None);
        assert!(damped.last.body(1).velocity_m_s[0].abs() < 1e-6);
        assert_near(damped.contacts[0].impulse_n_s, 0.1, relative);
        assert_near(damped.contacts[0].max_penetration_m, 1.05e-3, relative);
        assert_near(damped.contacts[0].peak_normal_n, 95.0885, relative);
        assert_near(damped.last.energy().dissipated_j, 50e-3, relative);
    }
}

#[test]
fn impacts_do_not_depend_on_the_radius() {
    let scene = load("radii");
    for (model, relative) in [(Model::Analytic, 1e-4), (Model::Engine, 2e-3)] {
        let (outcome, observer) = run(model, "radii");
        let pairs_in_contact: Vec<usize> =
            (0..scene.system.pairs().len()).filter(|&k| outcome.contacts[k].first_s.is_some()).collect();
        let names: Vec<String> =
            pairs_in_contact.iter().map(|&k| scene.system.contact_name(scene.system.pairs()[k])).collect();
        assert_eq!(names, ["large-target", "medium-target", "small-target"]);
        for &pair in &pairs_in_contact {
            let summary = &outcome.contacts[pair];
            assert_eq!(summary.touchdowns, 1);
            assert_near(summary.first_s.expect("a contact"), 5e-3, 1e-9);
            assert_near(summary.peak_normal_n, 348.1, relative + 2e-4);
            assert_near(summary.max_penetration_m, 0.4071e-3, relative + 1e-4);
            assert_near(observer.rebounds.pairs()[pair].restitution().expect("a separation"), 0.8862, relative);
            // The pairs agree with each other more closely than with the closed form.
            let other = &outcome.contacts[pairs_in_contact[0]];
            assert_near(summary.peak_normal_n, other.peak_normal_n, 1e-9);
            assert_near(summary.impulse_n_s, other.impulse_n_s, 1e-9);
        }
    }
}

#[test]
fn a_sliding_disc_ends_up_rolling() {
    for model in BOTH_MODELS {
        let (outcome, observer) = run(model, "rolling");
        let wheel = outcome.last.body(0);
        assert_near(wheel.velocity_m_s[0], 2.0 / 3.0, 1e-6);
        assert_near(wheel.spin_rad_s, -40.0 / 3.0, 1e-6);
        assert_near(observer.friction.0, 0.3 * 0.981, 1e-5);
        assert_near(outcome.last.energy().dissipated_j, 50e-3 / 3.0, 1e-4);
        // Sliding at −0.3 g until 1/(3 × 0.3 × 9.81) s, then rolling at two thirds of the speed.
        let sliding_time_s = 1.0 / (3.0 * 0.3 * 9.81);
        let distance =
            sliding_time_s - 0.5 * 0.3 * 9.81 * sliding_time_s * sliding_time_s + 2.0 / 3.0 * (0.2 - sliding_time_s);
        assert_near(wheel.centre_m[0], distance, 1e-3);
    }
}

#[test]
fn two_free_discs_conserve_momentum() {
    let scene = load("two-free");
    let masses = [0.1, 0.3];
    let inertias = masses.map(|mass| 0.5 * mass * 0.05 * 0.05);
    let momenta = |sample: &Sample| {
        let mut sums = [0.0; 3];
        for ((disc, mass), inertia) in sample.bodies().zip(masses).zip(inertias) {
            let ([x, y], [vx, vy]) = (disc.centre_m, disc.velocity_m_s);
            sums[0] += mass * vx;
            sums[1] += mass * vy;
            sums[2] += mass * (x * vy - y * vx) + inertia * disc.spin_rad_s;
        }
        sums
    };
    assert_eq!([scene.system.discs[0].name.as_str(), scene.system.discs[1].name.as_str()], ["striker", "struck"]);
    for model in BOTH_MODELS {
        let (outcome, observer) = run(model, "two-free");
        let [before, after] = [momenta(&observer.first_sample.expect("a sample")), momenta(&outcome.last)];
        // Friction acts on each disc at its own surface. The surfaces overlap, so angular momentum is conserved only up
        // to the moment of friction about the overlap.
        let pair = &outcome.contacts[0];
        let moment = 0.5 * pair.impulse_n_s * pair.max_penetration_m;
        for (k, (expected, tolerance)) in [(0.1, 1e-9), (0.0, 1e-9), (3e-3, moment)].into_iter().enumerate() {
            let (before, after, model) = (before[k], after[k], model.name());
            assert!((before - expected).abs() < 1e-15);
            assert!((after - expected).abs() <= tolerance, "{model}, {k}: {after} instead of {expected}");
        }
        assert!(outcome.last.body(1).velocity_m_s[0] > 0.3 && outcome.last.energy().dissipated_j > 0.02);
    }
}

#[test]
fn run_reports_text_and_json() {
    for model in ["analytic", "engine"] {
        let output = phalanx(&["run", "scenes/laws/impact.toml", "--model", model]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        for expected_text in
            ["impact: ", model, "hammer-anvil", "5.000000", "restitution", "0.60", "hammer    free", "drive work"]
        {
            assert!(stdout(&output).contains(expected_text), "no {expected_text} in\n{}", stdout(&output));
        }
        let document = json(&phalanx(&["run", "scenes/laws/impact.toml", "--model", model, "--json"]));
        assert_eq!((&document["kind"], &document["model"]), (&"bodies".into(), &model.into()));
        let pair = &document["contacts"]["hammer-anvil"];
        for key in ["first_s", "peak_normal_n", "max_penetration_m", "impulse_n_s", "restitution", "final_normal_n"] {
            assert!(pair[key].is_number(), "{key}");
        }
        assert_eq!(pair["touchdowns"], 1);
        assert_eq!(document["discs"]["anvil"]["motion"], "fixed");
        assert!(document["discs"]["hammer"]["vx_m_s"].as_f64().expect("a speed") < -0.6);
        assert!(document["energy"]["dissipated_j"].is_number() && document["error"].is_null());
        assert_eq!(document["engine"].is_null(), model == "analytic");
    }
}

#[test]
fn flags_override_the_scene_and_finger_flags_are_rejected() {
    let scene = "scenes/laws/impact.toml";
    let document = json(&phalanx(&["run", scene, "--duration", "1 ms", "--preset", "reference", "--json"]));
    assert_eq!((&document["end_s"], &document["integrator"]["preset"]), (&0.001.into(), &"reference".into()));
    let document = json(&phalanx(&["run", scene, "--model", "engine", "--step", "50 us", "--json"]));
    assert_eq!((&document["steps"], &document["engine"]["step_s"]), (&300.into(), &5e-5.into()));
    let rejected = phalanx(&["run", scene, "--model", "engine", "--construction", "reduced"]);
    assert_eq!(rejected.status.code(), Some(2));
    assert!(stderr(&rejected).contains("a scene of discs has no joints"), "{}", stderr(&rejected));
    let rejected = phalanx(&["run", scene, "--step", "1 us"]);
    assert_eq!(rejected.status.code(), Some(2), "the analytic model has no fixed step");
}

#[test]
fn logs_contain_discs_pairs_events_and_scene() {
    let directory = directory("laws_log");
    let logs: Vec<Vec<u8>> = ["a.mcap", "b.mcap"]
        .iter()
        .map(|name| {
            let path = directory.join(name);
            let output = phalanx(&["run", "scenes/laws/two-free.toml", "--log", path.to_str().expect("text")]);
            assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
            fs::read(path).expect("a log")
        })
        .collect();
    assert_eq!(logs[0], logs[1], "the logs differ");
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for message in MessageStream::new(&logs[0]).expect("a log") {
        let message = message.expect("readable");
        assert_eq!(message.channel.message_encoding, "protobuf");
        assert!(message.channel.schema.as_ref().is_some_and(|schema| !schema.data.is_empty()));
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    let topics: Vec<&str> = counts.keys().map(String::as_str).collect();
    let pair = "striker-struck";
    let expected = [
        &format!("/contact/{pair}"),
        "/disc/striker",
        "/disc/struck",
        "/energy",
        "/events",
        "/forces",
        &format!("/impact/{pair}"),
        "/scene",
        "/tf",
        "/tf_static",
    ];
    assert_eq!(topics, expected);
    // Touch-down, lift-off, and the end of the run.
    assert_eq!((counts["/impact/striker-struck"], counts["/events"]), (2, 3));
    assert!(counts["/disc/striker"] > 150 && counts["/disc/striker"] == counts["/energy"]);
    let summary = Summary::read(&logs[0]).expect("readable").expect("indexed");
    assert_eq!(summary.attachment_indexes[0].name, "two-free.toml");
    let record = mcap::read::metadata(&logs[0], &summary.metadata_indexes[0]).expect("readable");
    assert_eq!((record.metadata["kind"].as_str(), record.metadata["scene"].as_str()), ("bodies", "two-free"));
}

#[test]
fn validate_writes_report_and_files() {
    let directory = directory("laws_validate");
    let out = directory.to_str().expect("text");
    let output = phalanx(&["validate", "scenes/laws/impact.toml", "--quick", "--json", "--out", out]);
    assert_eq!(output.status.code(), Some(0), "{}\n{}", stdout(&output), stderr(&output));
    let report = json(&output);
    assert_eq!((&report["kind"], &report["passed"]), (&"bodies".into(), &true.into()));
    let bounds: Vec<&str> =
        report["verdict"].as_array().expect("a list").iter().map(|c| c["bound"].as_str().expect("a name")).collect();
    assert_eq!(bounds[..4], ["position_m", "contact_time_s", "impulse", "peak_force"]);
    assert!(report["differences"]["discs"]["hammer"]["max_m"].as_f64().expect("a figure") > 0.0);
    assert!(report["differences"]["pairs"]["hammer-anvil"]["impulse"].is_number());
    let settings = report["settings"].as_array().expect("a list");
    assert!(settings.iter().all(|setting| setting["status"] == "done"), "{settings:?}");
    assert!(settings.iter().any(|setting| setting["own"] == true && setting["position_max_m"].is_number()));
    for file in report["files"].as_array().expect("a list") {
        let path = directory.join(file.as_str().expect("a name"));
        assert!(fs::metadata(&path).expect("written").len() > 100, "{}", path.display());
    }
    let series = fs::read_to_string(directory.join("series.csv")).expect("text");
    assert!(
        series.starts_with("time_s,anvil_x_m_analytic,anvil_x_m_engine,"),
        "{}",
        series.lines().next().unwrap_or("")
    );
    assert!(fs::read_to_string(directory.join("overlay.svg")).expect("text").contains("normal force, N"));
}

#[test]
fn validate_exits_with_1_if_a_bound_is_exceeded() {
    let directory = directory("laws_out_of_bounds");
    let text = fs::read_to_string("scenes/laws/impact.toml").expect("text");
    let file = directory.join("tight.toml");
    fs::write(&file, format!("{text}\n[validate]\nimpulse = 1e-12\nuntil = \"7 ms\"\n")).expect("written");
    let output = phalanx(&["validate", file.to_str().expect("text"), "--quick"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stdout(&output).contains("OUT OF BOUNDS") && stdout(&output).contains("up to 7 ms of 15 ms"));
}
