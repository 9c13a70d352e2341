//! Fates of objects, criteria and overlaps of grippers: what decides them does not depend on the object's size, on the model or on the
//! tolerance.

use phalanx::check::pushed;
use phalanx::criteria::{Fate, GraspCriteria, GraspTracker, Judge, LinkOverlap, Obstacle};
use phalanx::scene::{Integrator, Scene, load_any, parse_any};
use phalanx::trace::{Model, Outcome, Reach, run};

/// Lengths of design 95 with an object of 4 mm that floats 20 mm above the palm.
const SMALL: &str = r#"
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

/// A light object that starts fast, bounces off the palm, and flies past fingers that hardly move.
const BOUNCED: &str = r#"
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

/// A shipped gripper.
fn load(name: &str) -> Scene {
    load_any(format!("scenes/gripper/{name}.toml")).unwrap_or_else(|error| panic!("{error}"))
}

fn judged(scene: &Scene, model: Model) -> (GraspCriteria, Outcome) {
    let mut tracker = GraspTracker::of(scene);
    let outcome = run(model, scene, &mut tracker).unwrap_or_else(|error| panic!("{model:?}: {error}"));
    (tracker.criteria().expect("samples"), outcome)
}

#[test]
fn an_object_that_nothing_has_touched_is_not_ejected() {
    for model in [Model::Analytic, Model::Engine] {
        let scene = scene(SMALL, &[("20 ms", "3 ms")]);
        let (found, outcome) = judged(&scene, model);
        assert_eq!((found.fate, outcome.ejected_s, outcome.last.time_s), (Fate::NotGrasped, None, 3e-3), "{model:?}");
    }
    // Nor one that flies away by itself.
    let flies = ("height = \"20 mm\"", "height = \"20 mm\", velocity = [\"0 m/s\", \"30 m/s\"]");
    for model in [Model::Analytic, Model::Engine] {
        let scene = scene(SMALL, &[flies, ("20 ms", "4 ms")]);
        let (found, outcome) = judged(&scene, model);
        let reach = Reach::of(&scene.system).expect("a free object");
        assert!(reach.is_outside(&outcome.last.bodies[0]), "{model:?}");
        assert_eq!((found.fate, outcome.last.time_s), (Fate::NotGrasped, 4e-3), "{model:?}");
    }
}

/// The object ends on the palm, pressed by all four phalanges: drawn from where it was first touched by more than its radius or by less.
#[test]
fn an_object_that_is_drawn_onto_the_palm_is_held_whatever_its_radius() {
    for (radius, height) in
        [("8 mm", "16 mm"), ("8 mm", "15.9 mm"), ("8 mm", "17 mm"), ("7 mm", "15 mm"), ("10 mm", "18 mm")]
    {
        let radius_m: f64 = radius.trim_end_matches(" mm").parse::<f64>().expect("a number") * 1e-3;
        let (radius, height) = (format!("radius = \"{radius}\""), format!("height = \"{height}\""));
        let changes = [("radius = \"4 mm\"", &*radius), ("height = \"20 mm\"", &*height), ("20 ms", "60 ms")];
        let scene = scene(SMALL, &changes);
        for model in [Model::Analytic, Model::Engine] {
            let (found, outcome) = judged(&scene, model);
            assert_eq!(found.fate, Fate::Held, "{radius}, {height}, {model:?}: {found:?}");
            assert!(
                (outcome.last.bodies[0].centre_m[1] - radius_m).abs() < 5e-5,
                "{radius}, {height}: it lies on the palm"
            );
            assert!(found.tts_s.is_some_and(|tts_s| tts_s > 4e-3 && tts_s < 20e-3), "{:?}", found.tts_s);
        }
    }
}

/// The forces that the issue of this verdict states: 29.9 N on both proximal phalanges, 6.1 N on both tips, 36.9 N on the palm.
#[test]
fn the_forces_of_a_held_object_balance() {
    let scene = scene(
        SMALL,
        &[("radius = \"4 mm\"", "radius = \"8 mm\""), ("height = \"20 mm\"", "height = \"16 mm\""), ("20 ms", "60 ms")],
    );
    let (_, outcome) = judged(&scene, Model::Analytic);
    let forces: Vec<f64> = [0, 3, 1, 4, 6].map(|index: usize| outcome.last.contacts[index].normal_n).to_vec();
    for (force, wanted) in forces.iter().zip([29.86, 29.86, 6.10, 6.10, 36.90]) {
        assert!((force - wanted).abs() < 0.05, "{forces:?}");
    }
}

#[test]
fn a_run_ends_where_its_object_is_ejected_whatever_the_tolerance() {
    let scene = scene(BOUNCED, &[]);
    let reach = Reach::of(&scene.system).expect("a free object");
    let ends: Vec<f64> = [1e-4, 3e-6, 1e-8]
        .map(|rtol| {
            let finer = Scene { integrator: Integrator { rtol, ..scene.integrator }, ..scene.clone() };
            let (found, outcome) = judged(&finer, Model::Analytic);
            check_end(&reach, &found, &outcome)
        })
        .into();
    assert!(ends.iter().all(|end_s| (end_s - ends[2]).abs() < 2e-7), "{ends:?}");
    let (found, outcome) = judged(&scene, Model::Engine);
    let engine_s = check_end(&reach, &found, &outcome);
    assert!((engine_s - ends[2]).abs() < 2e-6, "{engine_s} and {ends:?}");
}

/// The end of a run is the instant of its ejection, and the object is on the boundary then. Returns the instant.
fn check_end(reach: &Reach, found: &GraspCriteria, outcome: &Outcome) -> f64 {
    let end_s = outcome.ejected_s.expect("an ejection");
    assert_eq!((found.fate, outcome.last.time_s), (Fate::Ejected { at_s: end_s }, end_s));
    let (clearance_m, rate_m_s) = reach.clearance(&outcome.last.bodies[0]);
    assert!(clearance_m.abs() < 1e-9 && rate_m_s > 0.0, "{clearance_m} m off the boundary, at {rate_m_s} m/s");
    end_s
}

const SMOOTH: [&str; 6] = ["design-95", "table", "hold", "bought", "seesaw", "offset"];

#[test]
fn a_change_of_1e_7_of_the_torque_moves_no_criterion_of_a_smooth_grasp() {
    for name in SMOOTH {
        let scene = load(name);
        let [(as_it_is, _), (changed, _)] =
            [scene.clone(), pushed(&scene, 1e-7)].map(|scene| judged(&scene, Model::Analytic));
        assert_eq!((as_it_is.fate, changed.fate), (Fate::Held, Fate::Held), "{name}");
        let [one, other] = [&as_it_is, &changed].map(|found| found.tts_s.expect("a stable grasp"));
        assert!((one - other).abs() < 1e-6, "{name}: {one} and {other}");
        let lost = |found: &GraspCriteria| found.contacts.iter().map(|contact| contact.times_lost).collect::<Vec<_>>();
        assert_eq!(lost(&as_it_is), lost(&changed), "{name}");
    }
}

fn overlaps(scene: &Scene, model: Model) -> Vec<LinkOverlap> {
    let mut judge = Judge::of(scene);
    run(model, scene, &mut judge).expect("a run to its end");
    judge.judged(true).overlaps
}

#[test]
fn links_that_pass_through_something_are_reported() {
    let fingers = scene(SMALL, &[("20 ms", "6 ms")]);
    // The table is below the tips from the start on.
    let table = scene(&format!("{SMALL}\ntable.level = \"30 mm\""), &[("20 ms", "6 ms")]);
    for model in [Model::Analytic, Model::Engine] {
        let found = overlaps(&fingers, model);
        let [tips] = &found[..] else { panic!("{model:?}: {found:?}") };
        assert!(matches!(tips.obstacle, Obstacle::Link((_, "t22"))) && tips.link.1 == "t22", "{tips:?}");
        // The object is 8 mm thick, and the links 5 mm: they meet beside it, and cross.
        assert!((tips.depth_m - 5e-3).abs() < 1e-4 && tips.from_s > 4e-3 && tips.from_s < 5e-3, "{tips:?}");
        let found = overlaps(&table, model);
        let with_table: Vec<_> = found.iter().filter(|overlap| overlap.obstacle == Obstacle::Table).collect();
        assert_eq!(with_table.len(), 2, "{found:?}");
        assert!(with_table.iter().all(|overlap| overlap.from_s == 0.0 && overlap.depth_m > 5e-3), "{found:?}");
    }
    // A gripper whose links touch nothing but the object.
    assert_eq!(overlaps(&load("design-95"), Model::Analytic), []);
}
