//! Hands beyond the kinds of scene files, built in code and run in both models.

use phalanx::law::ContactLaw;
use phalanx::scene::{Axis, HalfPlane, Hand, Move, ObjectMotion, PalmMotion, Scene, load_any};
use phalanx::shape::max_radius;
use phalanx::trace::{Model, Outcome, Schema};

use crate::support::laws::{THESIS_FRICTION, THESIS_NORMAL, sampled_at_steps};
use crate::support::runs::{assert_below, engineering_settings, run_engine, run_to_end, with_reference_settings};

const FINGER: &str = "scenes/experiment-95.toml";
const GRIPPER: &str = "scenes/gripper/design-95.toml";

const LAW: ContactLaw = ContactLaw { normal: THESIS_NORMAL, friction: Some(THESIS_FRICTION) };

fn load(path: &str) -> Scene {
    load_any(path).unwrap_or_else(|error| panic!("{error}"))
}

/// A finger that pushes a free object along its palm.
fn finger_pushing_object() -> Scene {
    let mut scene = load(FINGER);
    scene.hand.grasped_mut().motion =
        ObjectMotion::Free { mass_kg: 0.05, inertia_kg_m2: 1e-5, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 };
    scene.hand.palm = Some(HalfPlane { level_m: 0.0, contact: Some(LAW) });
    scene.hand.gravity_m_s2 = [0.0, -9.81];
    scene.duration_s = 0.01;
    scene
}

/// A finger with the motor of a gripper.
fn driven_finger() -> Scene {
    let mut scene = load(FINGER);
    scene.hand.fingers[0].motor.no_load_speed_rad_s = Some(600.0);
    scene
}

/// Two fingers that close up to their stops, without an object.
fn gripper_without_object() -> Scene {
    let mut scene = load(GRIPPER);
    scene.hand.object = None;
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
        ("no object", gripper_without_object()),
        ("moving palm, no object", with_moving_palm(gripper_without_object())),
        ("driven finger", driven_finger()),
        ("finger pushing an object", finger_pushing_object()),
    ]
}

/// Largest difference between two final states: finger angles in rad, the position of the object in its radii.
fn max_difference(hand: &Hand, first: &Outcome, second: &Outcome) -> f64 {
    assert_eq!(first.last.counts().bodies, second.last.counts().bodies);
    let radius_m = hand.object.as_ref().map_or(1.0, |object| max_radius(&object.shape));
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

/// The no-load speed of a motor slows a single finger down, and a free object moves.
#[test]
fn a_single_finger_has_the_motor_and_the_object_of_a_gripper() {
    let [plain_s, slow_s] =
        [load(FINGER), driven_finger()].map(|scene| run_to_end(&scene).0.contacts[0].first_s.expect("a contact"));
    assert!(slow_s > plain_s + 1e-5, "the no-load speed has no effect: {slow_s} {plain_s}");
    let pushing = finger_pushing_object();
    let (pushed, _) = run_to_end(&pushing);
    let travelled_m = (pushed.last.body(0).centre_m[0] - pushing.hand.grasped().centre_m[0]).abs();
    assert!(travelled_m > 1e-3, "{:?}", pushed.last.body(0));
}

fn names(scene: &Scene) -> Vec<String> {
    Schema::from_scene(scene).contacts.into_iter().map(|contact| contact.name).collect()
}

/// A moving object next to one finger also has contacts with palm and table.
#[test]
fn contacts_of_palm_and_table_follow_those_of_the_finger() {
    let mut scene = finger_pushing_object();
    assert_eq!(names(&scene).join(" "), "proximal distal object-palm limit");
    scene.hand.table = Some(HalfPlane { level_m: 0.1, contact: Some(LAW) });
    assert_eq!(names(&scene).join(" "), "proximal distal object-palm object-table limit");
    scene.hand.grasped_mut().motion = ObjectMotion::Fixed;
    assert_eq!(names(&scene).join(" "), "proximal distal limit");
}
