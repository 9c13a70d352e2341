//! Systems of fingers and discs beyond the kinds of scene files, built in code and run in both models.

use std::collections::HashSet;

use phalanx::gripper::FingerContact;
use phalanx::law::{Bristle, ContactLaw};
use phalanx::scene::{Axis, Brake, ContactId, DiscMotion, HalfPlane, Hand, Move, PalmMotion, Scene, Side, load_any};
use phalanx::shape::{PlacedShape, max_radius};
use phalanx::trace::{Model, Outcome, RunError, Schema, run};

use crate::support::laws::{self, THESIS_FRICTION, THESIS_NORMAL, disc, sampled_at_steps};
use crate::support::runs::{
    assert_below, engineering_settings, finger_difference, run_engine, run_to_end, with_reference_settings,
};

const FINGER: &str = "scenes/experiment-95.toml";
const GRIPPER: &str = "scenes/gripper/design-95.toml";

const LAW: ContactLaw = ContactLaw { normal: THESIS_NORMAL, friction: Some(THESIS_FRICTION) };

fn load(path: &str) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

/// A free disc at rest.
fn free(mass_kg: f64, inertia_kg_m2: Option<f64>) -> DiscMotion {
    laws::free(mass_kg, inertia_kg_m2, [0.0; 2])
}

/// A finger that pushes a free object along its palm.
fn finger_pushing_object() -> Scene {
    let mut scene = load(FINGER);
    scene.hand.grasped_mut().motion = free(0.05, Some(1e-5));
    scene.hand.palm = Some(HalfPlane { level_m: 0.0, contact: Some(LAW) });
    scene.hand.gravity_m_s2 = [0.0, -9.81];
    scene.duration_s = 0.01;
    scene
}

/// The scene of [`finger_pushing_object`] with a second disc that the object is pushed against, and a wall behind it.
fn finger_pushing_two_discs() -> Scene {
    let mut scene = finger_pushing_object();
    let [x, y] = scene.hand.grasped().centre_m;
    scene.hand.discs.push(disc("ball", 0.01, [x - 0.0305, y - 0.0095], free(0.02, Some(1e-6))));
    scene.hand.discs.push(disc("wall", 0.01, [x - 0.0555, y - 0.0095], DiscMotion::Fixed));
    scene.hand.between_discs = Some(LAW);
    scene
}

/// Two fingers with two objects, one on the other.
fn gripper_with_two_objects() -> Scene {
    let mut scene = load(GRIPPER);
    scene.hand.gravity_m_s2 = [0.0, -9.81];
    let PlacedShape { shape, centre_m: [x, y], .. } = scene.hand.grasped().placed();
    let radius_m = max_radius(&shape);
    scene.hand.discs.push(disc("ball", 0.008, [x + 1e-3, y + radius_m + 0.00795], free(0.015, Some(5e-7))));
    scene.hand.between_discs = Some(LAW);
    scene.duration_s = 0.01;
    scene
}

fn with_bristles(mut scene: Scene) -> Scene {
    let bristle = Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 };
    let add_bristle =
        |law: &mut ContactLaw| law.friction.iter_mut().for_each(|friction| friction.bristle = Some(bristle));
    scene.hand.between_discs.iter_mut().for_each(add_bristle);
    scene.hand.palm.iter_mut().filter_map(|palm| palm.contact.as_mut()).for_each(add_bristle);
    scene.hand.fingers.iter_mut().flat_map(|finger| finger.contact.both_mut()).for_each(add_bristle);
    scene
}

/// The scene with bristles in which the ball slowly separates from the object while the fingers hit the object.
fn separating_bristles() -> Scene {
    let mut scene = with_bristles(gripper_with_two_objects());
    scene.hand.gravity_m_s2 = load(GRIPPER).hand.gravity_m_s2;
    scene
}

/// Two fingers around a disc with prescribed motion.
fn gripper_with_driven_disc() -> Scene {
    let mut scene = load(GRIPPER);
    scene.hand.palm = None;
    scene.hand.grasped_mut().motion =
        DiscMotion::Driven { velocity_m_s: [0.05, 0.1], acceleration_m_s2: [5.0, 8.0], spin_rad_s: 4.0 };
    scene.duration_s = 0.01;
    scene
}

/// Two fingers that close up to their stops, without an object.
fn gripper_without_object() -> Scene {
    let mut scene = load(GRIPPER);
    scene.hand.discs.clear();
    scene.duration_s = 0.006;
    scene
}

/// The scene with a moving palm.
fn with_moving_palm(mut scene: Scene) -> Scene {
    let displacement = |axis, distance| Move { axis, distance, start_s: 1e-3, length_s: 8e-3 };
    let moves = vec![displacement(Axis::X, 2e-3), displacement(Axis::Y, -3e-3), displacement(Axis::Angle, 0.05)];
    scene.hand.palm_motion = Some(PalmMotion { moves, ..PalmMotion::default() });
    scene
}

pub fn cases() -> Vec<(&'static str, Scene)> {
    vec![
        ("pushing", finger_pushing_object()),
        ("pushing two", finger_pushing_two_discs()),
        ("two objects", gripper_with_two_objects()),
        ("bristles", with_bristles(gripper_with_two_objects())),
        ("separating bristles", separating_bristles()),
        ("driven", gripper_with_driven_disc()),
        ("no object", gripper_without_object()),
        ("moving palm", with_moving_palm(finger_pushing_object())),
        ("moving palm, no object", with_moving_palm(gripper_without_object())),
    ]
}

/// Largest difference between two final states: finger angles in rad, positions of discs in radii of the first disc.
fn max_difference(hand: &Hand, first: &Outcome, second: &Outcome) -> f64 {
    assert_eq!(first.last.counts().bodies, second.last.counts().bodies);
    let radius_m = hand.discs.first().map_or(1.0, |disc| max_radius(&disc.shape));
    let fingers = first.last.fingers().zip(second.last.fingers());
    let bodies = first.last.bodies().zip(second.last.bodies());
    let positions = bodies.flat_map(|(a, b)| [0, 1].map(|i| (a.centre_m[i] - b.centre_m[i]).abs() / radius_m));
    let angles = fingers.flat_map(|(a, b)| [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad]).map(f64::abs);
    angles.chain(positions).fold(0.0, f64::max)
}

/// Both models agree, neither violates an invariant, and only contacts dissipate energy.
#[test]
fn both_models_agree_and_energy_balances() {
    for (name, scene) in cases() {
        assert_eq!(scene.hand.unsupported(), None, "{name}");
        let (reference, log) = run_to_end(&with_reference_settings(&scene));
        let (engineering, _) = run_to_end(&Scene { integrator: engineering_settings(), ..scene.clone() });
        let (engine, _) = run_engine(&sampled_at_steps(Model::Engine, scene.clone()));
        // The engineering preset is accurate to its relative tolerance; the engine is about as accurate.
        assert_below(max_difference(&scene.hand, &reference, &engineering), 1e-5, name);
        assert_below(max_difference(&scene.hand, &reference, &engine), 3e-5, name);
        let has_contact =
            |outcome: &Outcome| outcome.contacts.iter().map(|contact| contact.first_s.is_some()).collect::<Vec<_>>();
        assert_eq!(has_contact(&reference), has_contact(&engine), "{name}: {:?}", names(&scene));

        let energies = log.samples.iter().map(|sample| sample.energy());
        let sizes = energies.flat_map(|e| [e.motor_work_j.abs(), e.dissipated_j.abs(), e.kinetic_j]);
        let energy = reference.last.energy();
        assert_below(energy.balance_j.abs(), 1e-7 * sizes.fold(0.0, f64::max), name);
        assert!(energy.dissipated_j > 0.0, "{name}: no dissipation");
    }
}

/// A distant disc has no effect, although with it another kernel simulates the finger, and a larger one the gripper.
#[test]
fn a_distant_disc_has_no_effect() {
    for (path, motion) in [(FINGER, DiscMotion::Fixed), (GRIPPER, free(0.01, Some(1e-6)))] {
        let scene = with_reference_settings(&load(path));
        let mut with_distant_disc = scene.clone();
        with_distant_disc.hand.discs.push(disc("far", 0.01, [0.5, 0.4], motion));
        with_distant_disc.hand.between_discs = Some(LAW);
        let [(expected, _), (actual, _)] = [&scene, &with_distant_disc].map(run_to_end);
        for (a, b) in expected.last.fingers().zip(actual.last.fingers()) {
            assert_below(finger_difference(&a, &b), 1e-9, path);
        }
        for (a, b) in expected.contacts.iter().zip(&actual.contacts) {
            assert_below((a.impulse_n_s - b.impulse_n_s).abs(), 1e-7 * a.impulse_n_s.max(1e-3), path);
        }
        assert!(expected.contacts.iter().filter(|contact| contact.impulse_n_s > 0.0).count() >= 2, "{path}");
    }
}

/// The kernel for one finger does not support brake, rotor inertia and no-load speed; the general kernel handles them.
#[test]
fn one_finger_supports_brake_rotor_inertia_and_no_load_speed() {
    let mut scene = with_reference_settings(&load(FINGER));
    let (plain, _) = run_to_end(&scene);
    let motor = &mut scene.hand.fingers[0].motor;
    motor.inertia_kg_m2 = 2e-6;
    motor.no_load_speed_rad_s = Some(600.0);
    motor.brake = Some(Brake { start_s: 0.004, ..brake() });
    let [(analytic, _), (engine, _)] = [run_to_end(&scene), run_engine(&scene)];
    assert_below(max_difference(&scene.hand, &analytic, &engine), 1e-3, "both models");
    assert!(max_difference(&scene.hand, &analytic, &plain) > 0.05, "the motor settings have no effect");
}

fn brake() -> Brake {
    let scene = load("scenes/gripper/lift.toml");
    let brakes = scene.hand.fingers.iter().filter_map(|finger| finger.motor.brake);
    brakes.chain(scene.hand.differential.and_then(|input| input.motor.brake)).next().expect("a brake")
}

fn names(scene: &Scene) -> Vec<String> {
    Schema::from_scene(scene).contacts.into_iter().map(|contact| contact.name).collect()
}

#[test]
fn contacts_have_unique_names() {
    assert_eq!(
        names(&finger_pushing_two_discs()).join(" "),
        "proximal distal limit ball-proximal ball-distal wall-proximal wall-distal object-ball object-wall object-palm \
         ball-wall ball-palm"
    );
    assert_eq!(
        names(&gripper_with_two_objects()).join(" "),
        "right_proximal right_distal right_limit left_proximal left_distal left_limit palm table ball-right_proximal \
         ball-right_distal ball-left_proximal ball-left_distal object-ball ball-palm"
    );
    for (name, scene) in cases() {
        let names = names(&scene);
        assert_eq!(names.iter().collect::<HashSet<_>>().len(), names.len(), "{name}");
    }
}

/// A system beyond the capacity of the analytic model is rejected; the message names the limit and the engine.
#[test]
fn too_many_bodies_are_rejected() {
    let mut scene = gripper_with_two_objects();
    for index in 0..3 {
        scene.hand.discs.push(disc(&format!("far{index}"), 0.01, [0.5 + 0.1 * index as f64, 0.4], free(0.01, None)));
    }
    let Err(RunError::Simulation { failure, .. }) = run(Model::Analytic, &scene, &mut ()) else {
        panic!("the run completed")
    };
    let reason = failure.reason.to_string();
    assert!(reason.contains("19 coordinates") && reason.contains("up to 14") && reason.contains("engine"), "{reason}");
    scene.duration_s = 1e-3;
    assert!(run(Model::Engine, &scene, &mut ()).is_ok());
}

/// The contacts that a scene file can name come first: those of the fingers, palm and table with the object.
#[test]
fn gripper_contacts_come_first() {
    let hand = gripper_with_two_objects().hand;
    let contact_ids = hand.contact_ids();
    for contact in hand.gripper_contacts() {
        assert_eq!(contact_ids[contact.index()], contact.contact_id(0));
    }
    let first_other = contact_ids[hand.gripper_contacts().len()];
    assert_eq!(first_other, ContactId::Phalanx(Side::Right, FingerContact::Proximal, 1));
}
