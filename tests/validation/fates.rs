//! Fates of objects, criteria and link overlaps of grippers do not depend on the object's size, the model or the
//! tolerance.

use phalanx::check::perturbed;
use phalanx::criteria::{Fate, GraspCriteria, GraspTracker, LinkOverlap, Obstacle, RunCriteriaTracker};
use phalanx::scene::{Integrator, Scene, load_any, parse_any};
use phalanx::trace::{Model, Outcome, Reach, run};

/// Lengths of design 95 with an object of 4 mm that floats 20 mm above the palm.
const SMALL_OBJECT: &str = r#"
    kind = "gripper"
    duration = "20 ms"
    gravity = ["0 m/s^2", "0 m/s^2"]
    palm_width = "31 mm"
    lengths = { l11 = "15 mm", l21 = "24.43 mm", l22 = "7.5 mm", t22 = "12.86 mm", phi22 = "120 deg" }
    object = { radius = "4 mm", height = "20 mm" }
    motor = { torque = "480 N*mm" }
    spring = { torque = "132.6 N*mm" }
    contact.friction.mu_static = 0.8
"#;

/// A light, fast object that rebounds from the palm and flies past almost motionless fingers.
const BOUNCING_OBJECT: &str = r#"
    kind = "gripper"
    duration = "87 ms"
    object = { offset = "0.7527592321908503 mm", velocity = ["0.16640905165186215 m/s", "-0.7707155287499461 m/s"], spin = "-50.7 rad/s", mass = "2.5347 g" }
    spring = { type = "none" }

    [design]
    base = "11.850601414146787 mm"
    l21_fraction = 0.21519327003609845
    phi22 = "113.24648160080889 deg"
    arm_ratio = 0.8859670201230538
    l11 = "15.38621877736244 mm"

    [motor]
    torque = "10.742866152387919 N*mm"
    no_load_speed = "0.31969667004871494 rad/s"

    [contact]
    stiffness_si = 258567.75100058335
    exponent = 1.0
    damping = "0 N*s/m"
    transition = "1e-8 m"
"#;

fn scene(text: &str, changes: &[(&str, &str)]) -> Scene {
    let changed = changes.iter().fold(text.to_string(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    parse_any(&changed, "fates.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Loads a shipped gripper.
fn load(name: &str) -> Scene {
    load_any(format!("scenes/gripper/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn run_with_criteria(scene: &Scene, model: Model) -> (GraspCriteria, Outcome) {
    let mut tracker = GraspTracker::for_scene(scene);
    let outcome = run(model, scene, &mut tracker).unwrap_or_else(|error| panic!("{model:?}: {error}"));
    (tracker.criteria().expect("samples"), outcome)
}

#[test]
fn an_untouched_object_is_not_ejected() {
    for model in [Model::Analytic, Model::Engine] {
        let scene = scene(SMALL_OBJECT, &[("20 ms", "3 ms")]);
        let (criteria, outcome) = run_with_criteria(&scene, model);
        assert_eq!(
            (criteria.fate, outcome.ejected_s, outcome.last.time_s),
            (Fate::NotGrasped, None, 3e-3),
            "{model:?}"
        );
    }
    // An untouched object that flies away is not ejected either.
    let escaping = ("height = \"20 mm\"", "height = \"20 mm\", velocity = [\"0 m/s\", \"30 m/s\"]");
    for model in [Model::Analytic, Model::Engine] {
        let scene = scene(SMALL_OBJECT, &[escaping, ("20 ms", "4 ms")]);
        let (criteria, outcome) = run_with_criteria(&scene, model);
        let reach = Reach::from_system(&scene.system).expect("a free object");
        assert!(reach.is_outside(&outcome.last.body(0)), "{model:?}");
        assert_eq!((criteria.fate, outcome.last.time_s), (Fate::NotGrasped, 4e-3), "{model:?}");
    }
}

/// The object ends on the palm with four active contacts. Its displacement since the first contact is larger or smaller
/// than its radius.
#[test]
fn an_object_pulled_onto_the_palm_is_held_for_any_radius() {
    for (radius, height) in
        [("8 mm", "16 mm"), ("8 mm", "15.9 mm"), ("8 mm", "17 mm"), ("7 mm", "15 mm"), ("10 mm", "18 mm")]
    {
        let radius_m: f64 = radius.trim_end_matches(" mm").parse::<f64>().expect("a number") * 1e-3;
        let (radius, height) = (format!("radius = \"{radius}\""), format!("height = \"{height}\""));
        let changes = [("radius = \"4 mm\"", &*radius), ("height = \"20 mm\"", &*height), ("20 ms", "60 ms")];
        let scene = scene(SMALL_OBJECT, &changes);
        for model in [Model::Analytic, Model::Engine] {
            let (criteria, outcome) = run_with_criteria(&scene, model);
            assert_eq!(criteria.fate, Fate::Held, "{radius}, {height}, {model:?}: {criteria:?}");
            assert!(
                (outcome.last.body(0).centre_m[1] - radius_m).abs() < 5e-5,
                "{radius}, {height}: it lies on the palm"
            );
            assert!(criteria.tts_s.is_some_and(|tts_s| tts_s > 4e-3 && tts_s < 20e-3), "{:?}", criteria.tts_s);
        }
    }
}

/// The expected forces are those of the issue on this verdict: 29.9 N on both proximal phalanges, 6.1 N on both tips,
/// 36.9 N on the palm.
#[test]
fn the_forces_of_a_held_object_balance() {
    let scene = scene(
        SMALL_OBJECT,
        &[("radius = \"4 mm\"", "radius = \"8 mm\""), ("height = \"20 mm\"", "height = \"16 mm\""), ("20 ms", "60 ms")],
    );
    let (_, outcome) = run_with_criteria(&scene, Model::Analytic);
    let forces: Vec<f64> = [0, 3, 1, 4, 6].map(|index: usize| outcome.last.contact(index).normal_n).to_vec();
    for (force, expected) in forces.iter().zip([29.86, 29.86, 6.10, 6.10, 36.90]) {
        assert!((force - expected).abs() < 0.05, "{forces:?}");
    }
}

#[test]
fn a_run_ends_at_the_ejection_for_any_tolerance() {
    let scene = scene(BOUNCING_OBJECT, &[]);
    let reach = Reach::from_system(&scene.system).expect("a free object");
    let ends: Vec<f64> = [1e-4, 3e-6, 1e-8]
        .map(|rtol| {
            let finer = Scene { integrator: Integrator { rtol, ..scene.integrator }, ..scene.clone() };
            let (criteria, outcome) = run_with_criteria(&finer, Model::Analytic);
            assert_ends_at_ejection(&reach, &criteria, &outcome)
        })
        .into();
    assert!(ends.iter().all(|end_s| (end_s - ends[2]).abs() < 2e-7), "{ends:?}");
    let (criteria, outcome) = run_with_criteria(&scene, Model::Engine);
    let engine_s = assert_ends_at_ejection(&reach, &criteria, &outcome);
    assert!((engine_s - ends[2]).abs() < 2e-6, "{engine_s} and {ends:?}");
}

/// Asserts that a run ends at the ejection, with the object on the boundary of the reach. Returns the end, s.
fn assert_ends_at_ejection(reach: &Reach, criteria: &GraspCriteria, outcome: &Outcome) -> f64 {
    let end_s = outcome.ejected_s.expect("an ejection");
    assert_eq!((criteria.fate, outcome.last.time_s), (Fate::Ejected { at_s: end_s }, end_s));
    let (clearance_m, rate_m_s) = reach.clearance(&outcome.last.body(0));
    assert!(clearance_m.abs() < 1e-9 && rate_m_s > 0.0, "{clearance_m} m from the boundary, at {rate_m_s} m/s");
    end_s
}

const SMOOTH_GRASPS: [&str; 6] = ["design-95", "table", "hold", "bought", "seesaw", "offset"];

#[test]
fn a_torque_change_of_1e_7_leaves_the_criteria_of_a_smooth_grasp_unchanged() {
    for name in SMOOTH_GRASPS {
        let scene = load(name);
        let [(original, _), (changed, _)] =
            [scene.clone(), perturbed(&scene, 1e-7)].map(|scene| run_with_criteria(&scene, Model::Analytic));
        assert_eq!((original.fate, changed.fate), (Fate::Held, Fate::Held), "{name}");
        let [original_s, changed_s] = [&original, &changed].map(|criteria| criteria.tts_s.expect("a stable grasp"));
        assert!((original_s - changed_s).abs() < 1e-6, "{name}: {original_s} and {changed_s}");
        let loss_counts =
            |criteria: &GraspCriteria| criteria.contacts.iter().map(|contact| contact.times_lost).collect::<Vec<_>>();
        assert_eq!(loss_counts(&original), loss_counts(&changed), "{name}");
    }
}

fn overlaps(scene: &Scene, model: Model) -> Vec<LinkOverlap> {
    let mut tracker = RunCriteriaTracker::for_scene(scene);
    run(model, scene, &mut tracker).expect("a run to its end");
    tracker.finish(true).overlaps
}

#[test]
fn overlapping_links_are_reported() {
    let fingers = scene(SMALL_OBJECT, &[("20 ms", "6 ms")]);
    // The table overlaps the tips from the start on.
    let table = scene(&format!("{SMALL_OBJECT}\ntable.level = \"30 mm\""), &[("20 ms", "6 ms")]);
    for model in [Model::Analytic, Model::Engine] {
        let finger_overlaps = overlaps(&fingers, model);
        let [tips] = &finger_overlaps[..] else { panic!("{model:?}: {finger_overlaps:?}") };
        assert!(matches!(tips.obstacle, Obstacle::Link((_, "t22"))) && tips.link.1 == "t22", "{tips:?}");
        // The object is 8 mm thick and the links 5 mm, so they overlap next to it.
        assert!((tips.depth_m - 5e-3).abs() < 1e-4 && tips.from_s > 4e-3 && tips.from_s < 5e-3, "{tips:?}");
        let finger_overlaps = overlaps(&table, model);
        let with_table: Vec<_> = finger_overlaps.iter().filter(|overlap| overlap.obstacle == Obstacle::Table).collect();
        assert_eq!(with_table.len(), 2, "{finger_overlaps:?}");
        assert!(
            with_table.iter().all(|overlap| overlap.from_s == 0.0 && overlap.depth_m > 5e-3),
            "{finger_overlaps:?}"
        );
    }
    // In this gripper the links touch only the object.
    assert_eq!(overlaps(&load("design-95"), Model::Analytic), []);
}
