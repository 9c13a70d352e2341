//! Fates of objects, criteria and link overlaps of grippers do not depend on the object's size, the model or the
//! tolerance.

use crate::hard_scenes::load;
use crate::support::checked_run::record_run;
use phalanx::check::perturbed;
use phalanx::criteria::{Fate, LinkOverlap, ObjectCriteria, Obstacle};
use phalanx::scene::{Scene, parse_any};
use phalanx::trace::{Model, Outcome, Reach};

const BOTH_MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

/// Lengths of design 95 with an object that floats above the palm.
fn small_object(radius: &str, height: &str, duration: &str, more: &str) -> Scene {
    let text = format!(
        r#"
        kind = "gripper"
        duration = "{duration}"
        gravity = ["0 m/s^2", "0 m/s^2"]
        palm_width = "31 mm"
        lengths = {{ l11 = "15 mm", l21 = "24.43 mm", l22 = "7.5 mm", t22 = "12.86 mm", phi22 = "120 deg" }}
        object.radius = "{radius}"
        object.height = "{height}"
        motor = {{ torque = "480 N*mm" }}
        spring = {{ torque = "132.6 N*mm" }}
        contact.friction.mu_static = 0.8
        {more}
        "#
    );
    parse_any(&text, "fates.toml").unwrap_or_else(|error| panic!("{error}"))
}

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

fn run_with_criteria(scene: &Scene, model: Model) -> (ObjectCriteria, Outcome) {
    let run = record_run(model, scene);
    (run.run_criteria.and_then(|all| all.grasp).expect("criteria"), run.outcome)
}

#[test]
fn an_untouched_object_is_not_ejected() {
    let escaping = "object.velocity = [\"0 m/s\", \"30 m/s\"]";
    for (scene, escapes) in [
        (small_object("4 mm", "20 mm", "3 ms", ""), false),
        // An untouched object that flies away is not ejected either.
        (small_object("4 mm", "20 mm", "4 ms", escaping), true),
    ] {
        let reach = Reach::from_hand(&scene.hand).expect("a free object");
        for model in BOTH_MODELS {
            let (criteria, outcome) = run_with_criteria(&scene, model);
            assert_eq!((criteria.fate, outcome.last.time_s), (Fate::NotGrasped, scene.duration_s), "{model:?}");
            assert_eq!((outcome.ejected_s, reach.is_outside(&outcome.last.body(0))), (None, escapes), "{model:?}");
        }
    }
}

/// The object ends on the palm with four active contacts. Its displacement since the first contact is larger or smaller
/// than its radius.
#[test]
fn an_object_pulled_onto_the_palm_is_held_for_any_radius() {
    for (radius, height, radius_m) in [
        ("8 mm", "16 mm", 8e-3),
        ("8 mm", "15.9 mm", 8e-3),
        ("8 mm", "17 mm", 8e-3),
        ("7 mm", "15 mm", 7e-3),
        ("10 mm", "18 mm", 10e-3),
    ] {
        let scene = small_object(radius, height, "60 ms", "");
        for model in BOTH_MODELS {
            let (criteria, outcome) = run_with_criteria(&scene, model);
            assert_eq!(criteria.fate, Fate::Held, "{radius}, {height}, {model:?}: {criteria:?}");
            let height_m = outcome.last.body(0).centre_m[1];
            assert!((height_m - radius_m).abs() < 5e-5, "{radius}, {height}: it lies on the palm");
            assert!(criteria.tts_s.is_some_and(|tts_s| tts_s > 4e-3 && tts_s < 20e-3), "{:?}", criteria.tts_s);
        }
    }
}

/// The expected forces are those of the issue on this verdict: 29.9 N on both proximal phalanges, 6.1 N on both tips,
/// 36.9 N on the palm.
#[test]
fn the_forces_of_a_held_object_balance() {
    let (_, outcome) = run_with_criteria(&small_object("8 mm", "16 mm", "60 ms", ""), Model::Analytic);
    let forces = [0, 2, 1, 3, 4].map(|index: usize| outcome.last.contact(index).normal_n);
    for (force, expected) in forces.iter().zip([29.86, 29.86, 6.10, 6.10, 36.90]) {
        assert!((force - expected).abs() < 0.05, "{forces:?}");
    }
}

#[test]
fn a_run_ends_at_the_ejection_for_any_tolerance() {
    let scene = parse_any(BOUNCING_OBJECT, "fates.toml").unwrap_or_else(|error| panic!("{error}"));
    let reach = Reach::from_hand(&scene.hand).expect("a free object");
    // The run ends with the object on the boundary of the reach.
    let end_s = |model: Model, scene: &Scene| {
        let (criteria, outcome) = run_with_criteria(scene, model);
        let end_s = outcome.ejected_s.expect("an ejection");
        assert_eq!((criteria.fate, outcome.last.time_s), (Fate::Ejected { at_s: end_s }, end_s));
        let (clearance_m, rate_m_s) = reach.clearance(&outcome.last.body(0));
        assert!(clearance_m.abs() < 1e-9 && rate_m_s > 0.0, "{clearance_m} m from the boundary, at {rate_m_s} m/s");
        end_s
    };
    let ends = [1e-4, 3e-6, 1e-8].map(|rtol| {
        let mut finer = scene.clone();
        finer.integrator.rtol = rtol;
        end_s(Model::Analytic, &finer)
    });
    assert!(ends.iter().all(|end_s| (end_s - ends[2]).abs() < 2e-7), "{ends:?}");
    let engine_s = end_s(Model::Engine, &scene);
    assert!((engine_s - ends[2]).abs() < 2e-6, "{engine_s} and {ends:?}");
}

#[test]
fn a_torque_change_of_1e_7_leaves_the_criteria_of_a_smooth_grasp_unchanged() {
    for name in ["design-95", "table", "hold", "bought", "seesaw", "offset"] {
        let scene = load(&format!("gripper/{name}"));
        let [original, changed] =
            [scene.clone(), perturbed(&scene, 1e-7)].map(|scene| run_with_criteria(&scene, Model::Analytic).0);
        assert_eq!((original.fate, changed.fate), (Fate::Held, Fate::Held), "{name}");
        let [original_s, changed_s] = [&original, &changed].map(|criteria| criteria.tts_s.expect("a stable grasp"));
        assert!((original_s - changed_s).abs() < 1e-6, "{name}: {original_s} and {changed_s}");
        let losses = |criteria: &ObjectCriteria| criteria.pairs.iter().map(|pair| pair.times_lost).collect();
        let [original, changed]: [Vec<_>; 2] = [losses(&original), losses(&changed)];
        assert_eq!(original, changed, "{name}");
    }
}

#[test]
fn overlapping_links_are_reported() {
    let overlaps = |scene: &Scene, model: Model| -> Vec<LinkOverlap> {
        record_run(model, scene).run_criteria.expect("criteria").overlaps
    };
    let fingers = small_object("4 mm", "20 mm", "6 ms", "");
    // The table overlaps the tips from the start on.
    let table = small_object("4 mm", "20 mm", "6 ms", "table.level = \"30 mm\"");
    for model in BOTH_MODELS {
        let all = overlaps(&fingers, model);
        let [tips] = &all[..] else { panic!("{model:?}: {all:?}") };
        assert!(matches!(tips.obstacle, Obstacle::Link((_, "t22"))) && tips.link.1 == "t22", "{tips:?}");
        // The object is 8 mm thick and the links 5 mm, so they overlap next to it.
        assert!((tips.depth_m - 5e-3).abs() < 1e-4 && tips.from_s > 4e-3 && tips.from_s < 5e-3, "{tips:?}");
        let all = overlaps(&table, model);
        let with_table: Vec<_> = all.iter().filter(|overlap| overlap.obstacle == Obstacle::Table).collect();
        let is_deep_at_start = |overlap: &&LinkOverlap| overlap.from_s == 0.0 && overlap.depth_m > 5e-3;
        assert!(with_table.len() == 2 && with_table.iter().all(is_deep_at_start), "{all:?}");
    }
    // In this gripper the links touch only the object.
    assert_eq!(overlaps(&load("gripper/design-95"), Model::Analytic), []);
}
