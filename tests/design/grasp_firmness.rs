//! Firmness at the end of a run: the contacts and cables that take part.

use phalanx::criteria::{Fate, Firmness, Margin, ObjectCriteria, ObjectTracker, firmness};
use phalanx::mechanism::{OutlineId, Pose};
use phalanx::scene::{Scene, parse_any};
use phalanx::statics::{
    BalanceAtRest, ContactAtRest, DriveState, GraspKeys, LoadsAtRest, MechanismAtRest, balance_at_rest, roles,
};
use phalanx::trace::{Model, run};

use super::mechanism_grasp::CORD;

/// Two coupled jaws that hold a disc, with a wall of the ground 4 mm behind the left one.
fn walled() -> Scene {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    let scene = anchors["cases"][0]["scene"].as_str().expect("a scene");
    let wall = "[ground.outlines.wall]\ntype = \"disc\"\ncenter = [\"-34 mm\", \"0 mm\"]\nradius = \"5 mm\"\n\
                [[contacts]]\nbetween = [\"left.pad\", \"ground.wall\"]\nlaw = \"pad\"\n";
    let text = format!("{}{wall}", scene.replace("duration = \"60 ms\"", "duration = \"20 ms\""));
    parse_any(&text, "walled.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn held(scene: &Scene) -> ObjectCriteria {
    let mut tracker = ObjectTracker::for_scene(scene).expect("a grasp");
    run(Model::Analytic, scene, &mut tracker).unwrap_or_else(|_| panic!("a run"));
    let found = tracker.criteria().expect("a run");
    assert_eq!(found.fate, Fate::Held, "{}", found.reason);
    found
}

/// Firmness with a threshold of the normal force of an active contact.
fn firmness_above(scene: &Scene, found: &ObjectCriteria, loss_force_n: f64) -> Firmness {
    let mut scene = scene.clone();
    scene.thresholds.loss_force_n = loss_force_n;
    firmness(&scene, found).expect("held")
}

#[test]
fn contacts_below_the_threshold_do_not_hold() {
    let scene = walled();
    let found = held(&scene);
    assert!(firmness_above(&scene, &found, 19.0).force_closure.q1_l1 > 0.3);
    // Both pads press with 20 N.
    let none = firmness_above(&scene, &found, 21.0);
    assert_eq!(none.force_closure.q1_l1, 0.0);
    assert_eq!(none.form_closed, Some(false));
    assert!(matches!(none.driven, Margin::NotAtRest { .. }), "{none:?}");
}

#[test]
fn contacts_of_the_hand_with_listed_outlines_are_left_out() {
    let mut scene = walled();
    let found = held(&scene);
    // With a negative threshold, a contact without a force takes part as well: the wall supports the left jaw.
    let with_wall = firmness_above(&scene, &found, -1.0);
    let wall = OutlineId { body: None, outline: 0 };
    scene.grasp = Some(GraspKeys { surroundings: vec![wall], ..GraspKeys::default() });
    let listed = firmness_above(&scene, &found, -1.0);
    assert_eq!(listed, firmness_above(&scene, &found, 1e-3));
    assert_ne!(listed.driven, with_wall.driven);
    let Margin::Limited { acceleration_m_s2, .. } = listed.driven else { panic!("{listed:?}") };
    assert!((acceleration_m_s2 - 170.417).abs() < 0.1, "{acceleration_m_s2}");
}

/// Two coupled jaws that press a disc with 20 N each. In the worst directions, 60° and 120°, the object pushes one jaw back with
/// all that both press, and slides along the other one.
#[test]
fn what_fails_first_is_named() {
    let text = std::fs::read_to_string("tests/anchors/grasp.json").expect("the anchors");
    let anchors: serde_json::Value = serde_json::from_str(&text).expect("valid JSON");
    let text =
        anchors["cases"][0]["scene"].as_str().expect("a scene").replace("duration = \"60 ms\"", "duration = \"20 ms\"");
    let scene = parse_any(&text, "jaws.toml").unwrap_or_else(|error| panic!("{error}"));
    let found = held(&scene);
    let Margin::Limited { failure, directions_rad, .. } = firmness(&scene, &found).expect("held").driven else {
        panic!("limited")
    };
    let degrees: Vec<f64> = directions_rad.iter().map(|angle| angle.to_degrees().round()).collect();
    assert_eq!(degrees, [60.0, 120.0]);
    assert_eq!(
        (&failure.slipping[..], &failure.yielding[..]),
        (&["right.pad/object.skin".to_string()][..], &["grip".to_string()][..])
    );
    assert!(failure.separating.is_empty() && failure.tilting.is_empty(), "{failure:?}");
}

#[test]
fn a_blocked_cable_has_no_tension_of_its_own() {
    let scene = parse_any(CORD, "cord.toml").unwrap_or_else(|error| panic!("{error}"));
    let mechanism = scene.mechanism.as_ref().expect("a mechanism");
    let poses: Vec<Pose> = mechanism.bodies.iter().map(|body| body.pose).collect();
    let index = |name: &str| mechanism.bodies.iter().position(|body| body.name == name);
    let (object, arm) = (index("obj"), index("arm"));
    let contact = |bodies, x: f64, normal| ContactAtRest { bodies, point_m: [x, 0.0], normal: [normal, 0.0], mu: 0.5 };
    let contacts = [contact([object, arm], 0.02, -1.0), contact([object, None], -0.02, 1.0)];
    let pairs = contacts.iter().map(|contact| contact.bodies);
    let roles = roles(mechanism, (object.expect("the ball"), None), &[], pairs);
    let balance = |drives, tension_n: f64| {
        let at_rest =
            MechanismAtRest { mechanism, poses: &poses, time_s: 0.0, contacts: &contacts, drives, roles: &roles };
        let loads = LoadsAtRest { tensions_n: vec![tension_n], ..LoadsAtRest::default() };
        match balance_at_rest(&at_rest, &loads, 4).expect("a balance") {
            BalanceAtRest::Limits(limits) => {
                limits.iter().map(|limit| limit.largest.acceleration_m_s2()).collect::<Vec<_>>()
            }
            BalanceAtRest::NotAtRest { remainder } => panic!("not at rest: {remainder}"),
        }
    };
    assert_eq!(balance(DriveState::Blocked, 5.0), vec![None; 4]);
    assert_eq!(balance(DriveState::Blocked, 5.0), balance(DriveState::Blocked, 0.0));
    // At its effort it keeps its tension: friction of 2 · 0.5 · 5 N holds 50 g.
    let across = balance(DriveState::AtEffort, 5.0)[1].expect("a limit");
    assert!((across - 100.0).abs() < 1e-6, "{across}");
}
