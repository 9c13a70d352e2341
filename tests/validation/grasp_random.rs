//! Random grasps of six linkages: both models give the same fate, unless the fate is at a boundary.

use crate::support::random::Random;
use phalanx::criteria::{Fate, ObjectTracker};
use phalanx::mechanism::PrescribedMotion;
use phalanx::scene::{Scene, load_any, parse_any};
use phalanx::trace::{Model, run};
use std::collections::BTreeMap;

/// Two jaws, a wedge, three jaws, a linkage with couplers, jaws on a lift, and fingers with cables.
fn templates() -> Vec<Scene> {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    let anchor = |index: usize| {
        let text = anchors["cases"][index]["scene"].as_str().expect("a scene");
        parse_any(text, "anchor.toml").unwrap_or_else(|error| panic!("{error}"))
    };
    let shipped = |name: &str| {
        let path = format!("scenes/real/{name}.toml");
        load_any(path).unwrap_or_else(|error| panic!("{error}"))
    };
    vec![anchor(0), anchor(5), anchor(8), shipped("2f85-pinch"), shipped("franka-lift"), shipped("t42-grasp")]
}

/// Factors of the mass of the object, of all friction, and of all efforts, and the offset of the start.
#[derive(Clone, Copy, Debug)]
struct Change {
    mass: f64,
    friction: f64,
    effort: f64,
    offset_m: [f64; 2],
}

fn changed(scene: &Scene, change: &Change) -> Scene {
    let mut scene = scene.clone();
    let object = scene.grasp_roles().expect("a grasp").object;
    let mechanism = scene.mechanism.as_mut().expect("a mechanism");
    let body = &mut mechanism.bodies[object];
    assert!(!matches!(body.motion, Some(PrescribedMotion::Palm(_))));
    (body.mass_kg, body.inertia_kg_m2) = (body.mass_kg * change.mass, body.inertia_kg_m2 * change.mass);
    (0..2).for_each(|axis| body.pose[axis] += change.offset_m[axis]);
    for pair in &mut mechanism.contacts {
        if let Some(friction) = &mut pair.law.friction {
            friction.mu_static *= change.friction;
            friction.mu_dynamic *= change.friction;
        }
    }
    for actuator in &mut mechanism.actuators {
        if matches!(actuator.command, phalanx::mechanism::Command::Effort(_)) {
            let profile = actuator.command.profile_mut();
            *profile = profile.scaled(change.effort);
        }
        actuator.limit = actuator.limit.map(|limit| limit * change.effort);
    }
    scene
}

/// Fate of a run; `None` if it is not completed.
fn fate(model: Model, scene: &Scene) -> Option<Fate> {
    let mut tracker = ObjectTracker::for_scene(scene)?;
    run(model, scene, &mut tracker).ok()?;
    tracker.criteria().map(|found| found.fate)
}

/// A fate is at a boundary if a change of the friction by this part leads to another one.
const BOUNDARY: f64 = 2e-3;

fn compare(count: usize, seed: u64) {
    let templates = templates();
    let mut random = Random::for_seed(seed);
    let (mut fates, mut boundary): (BTreeMap<&str, usize>, usize) = Default::default();
    for case in 0..count {
        let template = &templates[case % templates.len()];
        let change = Change {
            mass: random.log_within(0.3, 10.0),
            friction: random.log_within(0.1, 1.5),
            effort: random.log_within(0.2, 1.5),
            offset_m: [random.within(-1e-4, 1e-4), random.within(0.0, 1e-4)],
        };
        let scene = changed(template, &change);
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| fate(model, &scene));
        let (Some(analytic), Some(engine)) = (analytic, engine) else { continue };
        *fates.entry(analytic.name()).or_default() += 1;
        if analytic.name() != engine.name() {
            let beside = |factor: f64| Change { friction: change.friction * factor, ..change };
            let names = [1.0 - BOUNDARY, 1.0 + BOUNDARY]
                .map(|factor| fate(Model::Analytic, &changed(template, &beside(factor))).map(Fate::name));
            let is_boundary = names.iter().any(|name| *name == Some(engine.name()));
            assert!(is_boundary, "{case} {}: {analytic:?}, {engine:?}: {change:?}", template.name);
            boundary += 1;
        }
    }
    println!("{fates:?}, {boundary} at a boundary");
    let completed: usize = fates.values().sum();
    assert!(completed * 10 >= count * 9 && boundary * 20 <= count, "{fates:?}, {boundary} of {count} at a boundary");
    assert!(fates.len() > 1, "{fates:?}");
}

#[test]
fn both_models_give_the_same_fates() {
    compare(24, 5902);
}

#[test]
#[ignore = "takes minutes"]
fn both_models_give_the_same_300_fates() {
    compare(300, 5903);
}
