//! The shipped scenes of discs load, come back from `show`, do what their comments say in both models, and validate; and
//! the commands take them.

use std::collections::BTreeMap;
use std::fs;

use crate::support::cli::{directory, json, phalanx, stderr, stdout};
use mcap::{MessageStream, Summary};
use phalanx::criteria::Rebounds;
use phalanx::invariants::Finding;
use phalanx::scene::{self, Preset, Scene};
use phalanx::trace::{Event, Model, Outcome, Sample, Sink, SinkError};
use phalanx::validate::{compare, compared, invariants, record, reference, sampled, verdicts};

const BOTH: [Model; 2] = [Model::Analytic, Model::Engine];
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
struct Listener {
    rebounds: Rebounds,
    first: Option<Sample>,
    /// Largest friction force, and the slip at it.
    friction: (f64, f64),
}

impl Sink for Listener {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.first.get_or_insert_with(|| sample.clone());
        for contact in &sample.contacts {
            // The engine's force is the mean of a step, in which slow slip may turn round.
            let against = contact.tangential_n * contact.slip_m_s <= 0.0 || contact.slip_m_s.abs() < 1e-3;
            assert!(against, "friction is against the slip: {contact:?}");
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

fn run(model: Model, name: &str) -> (Outcome, Listener) {
    let mut scene = load(name);
    scene.integrate_by(Preset::Reference);
    let pairs = scene.system.pairs().len();
    let mut listener = Listener { rebounds: Rebounds::new(pairs), ..Listener::default() };
    let outcome = crate::support::held::run(model, &scene, &mut listener).unwrap_or_else(|e| panic!("{name}: {e}"));
    (outcome, listener)
}

#[track_caller]
fn near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} instead of {expected}");
}

#[test]
fn all_say_what_they_are_and_come_back_bit_for_bit() {
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
        let back = scene::parse_any(&text, "shown.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert_eq!(Scene { source: scene.source.clone(), ..back }, scene);
    }
}

/// Within the bounds each scene sets itself, and to the same count of touch-downs.
#[test]
fn the_engine_is_within_the_bounds_of_every_scene() {
    for name in NAMES {
        let scene = compared(&load(name));
        let expected = record(Model::Analytic, &reference(&scene)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let found = record(Model::Engine, &sampled(Model::Engine, &scene)).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (model, scene, run) in
            [(Model::Analytic, reference(&scene), &expected), (Model::Engine, scene.clone(), &found)]
        {
            let broken: Vec<_> = invariants(&scene, model, run).into_iter().filter(Finding::is_broken).collect();
            assert!(broken.is_empty(), "{name}: {broken:?}");
        }
        let verdict = verdicts(&compare(&found, &expected, scene.bounds.until_s), &scene.bounds);
        assert!(verdict.passed(), "{name}: {verdict:#?}");
        for (found, expected) in found.outcome.contacts.iter().zip(&expected.outcome.contacts) {
            assert_eq!(found.touchdowns, expected.touchdowns, "{name}");
        }
    }
}

#[test]
fn driven_discs_meet_the_laws_of_their_comments() {
    for model in BOTH {
        let (spring, _) = run(model, "spring");
        near(spring.contacts[0].peak_normal_n, 18292.2, 1e-5);
        near(spring.contacts[0].impulse_n_s, 114.326, 1e-4);
        near(spring.last.energy.motor_work_j, 114.326, 1e-4);
        near(spring.last.energy.elastic_j, 114.326, 1e-4);

        let (damper, _) = run(model, "damper");
        near(damper.contacts[0].peak_normal_n, 1e4, 1e-9);
        near(damper.contacts[0].impulse_n_s, 40.0, 1e-4);
        near(damper.last.energy.dissipated_j, 40.0, 1e-4);
        assert_eq!(damper.last.energy.elastic_j, 0.0);

        let (friction, heard) = run(model, "friction");
        near(friction.contacts[0].peak_normal_n, 25.1189, 1e-5);
        near(friction.contacts[0].impulse_n_s, 2.51189, 1e-5);
        near(heard.friction.0, 0.8 * 25.1189, 1e-4);
        near(heard.friction.1, 0.1, 0.02);
        near(friction.last.contacts[0].tangential_n.abs(), 0.56 * 25.1189, 1e-5);
        near(friction.last.energy.motor_work_j, 0.227409, 1e-5);
    }
}

#[test]
fn impacts_are_those_of_their_comments() {
    for (model, relative) in [(Model::Analytic, 2e-5), (Model::Engine, 1e-3)] {
        let (impact, heard) = run(model, "impact");
        near(impact.contacts[0].first_s.expect("a touch"), 5e-3, 1e-9);
        near(impact.contacts[0].peak_normal_n, 62.105, relative);
        near(impact.contacts[0].max_penetration_m, 1.4936e-3, relative + 3e-5);
        near(heard.rebounds.pairs()[0].restitution().expect("it parts"), 0.60104, relative);
        near(impact.contacts[0].impulse_n_s, 0.16010, relative + 3e-5);
        near(impact.last.energy.dissipated_j, 31.938e-3, relative);

        let (elastic, heard) = run(model, "impact-elastic");
        near(heard.rebounds.pairs()[0].restitution().expect("it parts"), 1.0, relative);
        near(elastic.contacts[0].impulse_n_s, 0.2, relative);
        near(elastic.contacts[0].max_penetration_m, 1.78356e-3, relative);
        near(elastic.contacts[0].peak_normal_n, 89.7083, relative);
        assert!(elastic.last.energy.dissipated_j.abs() < relative * 50e-3);

        let (damped, heard) = run(model, "impact-damper");
        assert_eq!(heard.rebounds.pairs()[0].restitution(), None);
        assert!(damped.last.bodies[1].velocity_m_s[0].abs() < 1e-6);
        near(damped.contacts[0].impulse_n_s, 0.1, relative);
        near(damped.contacts[0].max_penetration_m, 1.05e-3, relative);
        near(damped.contacts[0].peak_normal_n, 95.0885, relative);
        near(damped.last.energy.dissipated_j, 50e-3, relative);
    }
}

#[test]
fn three_radii_make_no_difference() {
    let scene = load("radii");
    for (model, relative) in [(Model::Analytic, 1e-4), (Model::Engine, 2e-3)] {
        let (outcome, heard) = run(model, "radii");
        let met: Vec<usize> =
            (0..scene.system.pairs().len()).filter(|&k| outcome.contacts[k].first_s.is_some()).collect();
        let names: Vec<String> = met.iter().map(|&k| scene.system.pair_name(scene.system.pairs()[k])).collect();
        assert_eq!(names, ["large-target", "medium-target", "small-target"]);
        for &pair in &met {
            let summary = &outcome.contacts[pair];
            assert_eq!(summary.touchdowns, 1);
            near(summary.first_s.expect("a touch"), 5e-3, 1e-9);
            near(summary.peak_normal_n, 348.1, relative + 2e-4);
            near(summary.max_penetration_m, 0.4071e-3, relative + 1e-4);
            near(heard.rebounds.pairs()[pair].restitution().expect("it parts"), 0.8862, relative);
            // Equal to each other far better than right.
            let other = &outcome.contacts[met[0]];
            near(summary.peak_normal_n, other.peak_normal_n, 1e-9);
            near(summary.impulse_n_s, other.impulse_n_s, 1e-9);
        }
    }
}

#[test]
fn a_sliding_disc_comes_to_roll() {
    for model in BOTH {
        let (outcome, heard) = run(model, "rolling");
        let wheel = &outcome.last.bodies[0];
        near(wheel.velocity_m_s[0], 2.0 / 3.0, 1e-6);
        near(wheel.spin_rad_s, -40.0 / 3.0, 1e-6);
        near(heard.friction.0, 0.3 * 0.981, 1e-5);
        near(outcome.last.energy.dissipated_j, 50e-3 / 3.0, 1e-4);
        // Sliding at −0.3 g until 1/(3 × 0.3 × 9.81) s, then rolling at two thirds of the speed.
        let slid_s = 1.0 / (3.0 * 0.3 * 9.81);
        let way = slid_s - 0.5 * 0.3 * 9.81 * slid_s * slid_s + 2.0 / 3.0 * (0.2 - slid_s);
        near(wheel.centre_m[0], way, 1e-3);
    }
}

#[test]
fn two_free_discs_keep_their_momenta() {
    let scene = load("two-free");
    let masses = [0.1, 0.3];
    let inertias = masses.map(|mass| 0.5 * mass * 0.05 * 0.05);
    let momenta = |sample: &Sample| {
        let mut sums = [0.0; 3];
        for ((disc, mass), inertia) in sample.bodies.iter().zip(masses).zip(inertias) {
            let ([x, y], [vx, vy]) = (disc.centre_m, disc.velocity_m_s);
            sums[0] += mass * vx;
            sums[1] += mass * vy;
            sums[2] += mass * (x * vy - y * vx) + inertia * disc.spin_rad_s;
        }
        sums
    };
    assert_eq!([scene.system.discs[0].name.as_str(), scene.system.discs[1].name.as_str()], ["striker", "struck"]);
    for model in BOTH {
        let (outcome, heard) = run(model, "two-free");
        let [before, after] = [momenta(&heard.first.expect("a sample")), momenta(&outcome.last)];
        // Friction acts on each disc at its own surface, and these overlap: angular momentum is kept but for its moment.
        let pair = &outcome.contacts[0];
        let moment = 0.5 * pair.impulse_n_s * pair.max_penetration_m;
        for (k, (expected, tolerance)) in [(0.1, 1e-9), (0.0, 1e-9), (3e-3, moment)].into_iter().enumerate() {
            let (before, after, model) = (before[k], after[k], model.name());
            assert!((before - expected).abs() < 1e-15);
            assert!((after - expected).abs() <= tolerance, "{model}, {k}: {after} instead of {expected}");
        }
        assert!(outcome.last.bodies[1].velocity_m_s[0] > 0.3 && outcome.last.energy.dissipated_j > 0.02);
    }
}

#[test]
fn runs_are_summed_up_for_people_and_programs() {
    for model in ["analytic", "engine"] {
        let output = phalanx(&["run", "scenes/laws/impact.toml", "--model", model]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        for part in
            ["impact: ", model, "hammer-anvil", "5.000000", "restitution", "0.60", "hammer     free", "drive work"]
        {
            assert!(stdout(&output).contains(part), "no {part} in\n{}", stdout(&output));
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
fn flags_override_the_scene_and_those_of_fingers_are_refused() {
    let scene = "scenes/laws/impact.toml";
    let document = json(&phalanx(&["run", scene, "--duration", "1 ms", "--preset", "reference", "--json"]));
    assert_eq!((&document["end_s"], &document["integrator"]["preset"]), (&0.001.into(), &"reference".into()));
    let document = json(&phalanx(&["run", scene, "--model", "engine", "--step", "50 us", "--json"]));
    assert_eq!((&document["steps"], &document["engine"]["step_s"]), (&300.into(), &5e-5.into()));
    let refused = phalanx(&["run", scene, "--model", "engine", "--construction", "reduced"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("a scene of discs has none"), "{}", stderr(&refused));
    let refused = phalanx(&["run", scene, "--step", "1 us"]);
    assert_eq!(refused.status.code(), Some(2), "the analytic model has no such step");
}

#[test]
fn logs_have_every_disc_pair_and_event_and_the_scene() {
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
    assert_eq!(logs[0], logs[1], "the same run gives the same bytes");
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
    // A touch-down, a lift-off, and how it ended.
    assert_eq!((counts["/impact/striker-struck"], counts["/events"]), (2, 3));
    assert!(counts["/disc/striker"] > 150 && counts["/disc/striker"] == counts["/energy"]);
    let summary = Summary::read(&logs[0]).expect("readable").expect("there");
    assert_eq!(summary.attachment_indexes[0].name, "two-free.toml");
    let record = mcap::read::metadata(&logs[0], &summary.metadata_indexes[0]).expect("readable");
    assert_eq!((record.metadata["kind"].as_str(), record.metadata["scene"].as_str()), ("bodies", "two-free"));
}

#[test]
fn validate_reports_judges_and_leaves_its_files() {
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
fn a_bound_that_does_not_hold_ends_with_status_1() {
    let directory = directory("laws_out_of_bounds");
    let text = fs::read_to_string("scenes/laws/impact.toml").expect("text");
    let file = directory.join("tight.toml");
    fs::write(&file, format!("{text}\n[validate]\nimpulse = 1e-12\nuntil = \"7 ms\"\n")).expect("written");
    let output = phalanx(&["validate", file.to_str().expect("text"), "--quick"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(stdout(&output).contains("OUT OF BOUNDS") && stdout(&output).contains("up to 7 ms of 15 ms"));
}
