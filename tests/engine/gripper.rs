//! Grippers in both models, compared with each other and with an independent program.

use phalanx::criteria::{ObjectCriteria, ObjectTracker};
use phalanx::scene::{self, Axis, HandContact, Move, ObjectMotion, Scene, Stepping};
use phalanx::shape::max_radius;
use phalanx::trace::{Energy, Model, Outcome, Sample, Simulation, run};

use crate::support::laws::BOTH_MODELS;
use crate::support::reference_cases::{cases_at_rest, reference_case};
use crate::support::runs::{
    CollectSink, assert_below, assert_near, run_engine, run_model, run_to_end, with_reference_settings,
};

/// Largest difference of angles (rad) and of positions (object radii) over the grid of the log.
fn max_difference(scene: &Scene, a: &CollectSink, b: &CollectSink) -> f64 {
    let steps = (scene.duration_s * scene.log.numeric_hz).round() as usize;
    let radius = max_radius(&scene.hand.grasped().shape);
    let mut differences = Vec::new();
    for k in 0..=steps {
        let time_s = k as f64 / scene.log.numeric_hz;
        let (a, b) = (a.nearest_sample(time_s), b.nearest_sample(time_s));
        assert!([a, b].iter().all(|sample| (sample.time_s - time_s).abs() < 1e-12), "no sample at {time_s} s");
        for (a, b) in a.fingers().zip(b.fingers()) {
            differences.extend([a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad]);
            differences.extend([a.q12_rad - b.q12_rad, a.q22_rad - b.q22_rad]);
        }
        let (a, b) = (a.object(&scene.hand), b.object(&scene.hand));
        differences.extend([0, 1].map(|axis| (a.centre_m[axis] - b.centre_m[axis]) / radius));
        differences.push(a.angle_rad - b.angle_rad);
    }
    differences.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Runs of both models, the analytic one with reference settings, and their largest difference.
struct Comparison {
    scene: Scene,
    analytic: CollectSink,
    difference: f64,
    outcome: Outcome,
    /// Final energies of the analytic model and of the engine.
    energies: [Energy; 2],
}

impl Comparison {
    #[track_caller]
    fn run(scene: Scene) -> Self {
        let (analytic_outcome, analytic) = run_to_end(&with_reference_settings(&scene));
        let (outcome, engine) = run_engine(&scene);
        let difference = max_difference(&scene, &analytic, &engine);
        let energies = [&analytic_outcome, &outcome].map(|outcome| outcome.last.energy());
        Self { scene, analytic, difference, outcome, energies }
    }

    /// Asserts that the difference is below its bound, and that it falls by 0.3 and below `finest` with a tolerance of
    /// 1e-9 m, a hundredth of the default.
    #[track_caller]
    fn assert_agrees(&self, bound: f64, finest: f64) {
        let Self { scene, analytic, difference, .. } = self;
        assert_below(*difference, bound, "both models");
        let mut fine = scene.clone();
        fine.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
        let fine_difference = max_difference(&fine, analytic, &run_engine(&fine).1);
        assert_below(fine_difference, finest.min(0.3 * difference), "at a tolerance of 1e-9 m");
    }

    /// Differences of the final energies.
    fn energy_difference(&self, energy: fn(&Energy) -> f64) -> f64 {
        (energy(&self.energies[0]) - energy(&self.energies[1])).abs()
    }
}

/// Case c, with an offset object, is the hardest: one finger arrives 2 ms before the other, and errors grow by a factor
/// of 10,000. In cases d and e the palm moves; the formulations differ: the analytic model uses the palm frame, the
/// engine moves the base.
#[test]
fn both_models_agree_and_the_difference_falls_with_the_tolerance() {
    for (letter, bound) in [("a", 2e-5), ("b", 6e-5), ("c", 1e-4), ("f", 4e-5), ("i", 2e-5), ("d", 6e-5), ("e", 6e-5)] {
        let comparison = Comparison::run(reference_case(letter).scene);
        comparison.assert_agrees(bound, 2e-6);
        assert_below(comparison.outcome.loop_gap_m, 1e-7, format!("{letter}: loop gap"));
        if comparison.scene.hand.palm_motion.is_some() {
            assert_below(comparison.energy_difference(|energy| energy.motor_work_j), 1e-4, format!("{letter}: work"));
        }
    }
}

#[test]
fn contact_times_and_impulses_match_an_independent_program() {
    for case in cases_at_rest() {
        for (model, time_s, relative) in [(Model::Analytic, 5e-8, 1e-4), (Model::Engine, 1e-6, 5e-3)] {
            let (outcome, log) = run_model(model, &case.scene);
            let context = |contact: usize| format!("{model:?}, {}: contact {contact}", case.name);
            // The contacts of the reference without joint limits; those that the scene does not have are never closed.
            let surfaces = HandContact::ALL.into_iter().filter(|contact| !contact.is_stop());
            let surfaces: Vec<Option<usize>> = surfaces.map(|contact| case.scene.hand.contact_index(contact)).collect();
            for (index, expected) in surfaces.iter().flatten().copied().zip(case.first_contact_s) {
                let first_s = log.first_contact_s(index).expect("a first contact");
                assert_near(first_s, expected, time_s, context(index));
                assert_eq!(outcome.contacts[index].first_s, Some(first_s));
            }
            for (index, expected) in surfaces.into_iter().zip(case.impulse) {
                let Some(index) = index else {
                    assert_eq!(expected, 0.0, "{}", case.name);
                    continue;
                };
                assert_near(
                    outcome.contacts[index].impulse_n_s,
                    expected,
                    relative * expected.max(0.02),
                    context(index),
                );
            }
        }
    }
}

/// Times of first contact agree to 1 µs. Times at which a contact closes again after an impact differ by up to 8 µs
/// (case f), and the total duration of contact loss over several impacts by up to 11 µs (case c).
#[test]
fn grasp_criteria_match_the_analytic_model() {
    for case in cases_at_rest() {
        let evaluate = |model| -> ObjectCriteria {
            let mut tracker = ObjectTracker::for_scene(&case.scene).expect("a grasp");
            run(model, &case.scene, &mut tracker).expect("a completed run");
            tracker.criteria().expect("samples")
        };
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(evaluate);
        assert_eq!(analytic.fate, engine.fate, "{}", case.name);
        let assert_near = |a: Option<f64>, b: Option<f64>, tolerance: f64, quantity: &str| match (a, b) {
            (Some(a), Some(b)) => assert_below((a - b).abs(), tolerance, format!("{}: {quantity}", case.name)),
            _ => assert_eq!(a, b, "{}: {quantity}", case.name),
        };
        assert_near(analytic.grasped_s, engine.grasped_s, 1e-6, "grasped");
        assert_near(analytic.tts_s, engine.tts_s, 1e-5, "stable");
        assert_near(analytic.offset_ratio(), engine.offset_ratio(), 1e-3, "offset");
        let [slip, other] = [&analytic, &engine].map(|criteria| criteria.slip.expect("a grasp"));
        assert_near(Some(slip.displacement_m), Some(other.displacement_m), 1e-6, "slip");
        assert_near(Some(slip.rotation_rad), Some(other.rotation_rad), 1e-4, "rotation");
        for (a, b) in analytic.pairs.iter().zip(&engine.pairs) {
            assert_near(a.first_s, b.first_s, 1e-6, &a.name);
            assert_near(a.active_since_s, b.active_since_s, 1e-5, &a.name);
            assert_near(Some(a.lost_s), Some(b.lost_s), 2e-5, &a.name);
        }
    }
}

/// The impulse of gravity and contact forces equals the momentum of the object, up to the error of integrating the
/// samples.
#[test]
fn momentum_of_the_object_matches_its_contact_forces() {
    let mut scene = reference_case("c").scene;
    scene.log.numeric_hz = 2e5;
    let ObjectMotion::Free { mass_kg, .. } = scene.hand.grasped().motion else { panic!("the object is fixed") };
    for model in BOTH_MODELS {
        let (outcome, log) = run_model(model, &scene);
        let (mut impulse, mut most) = ([0.0; 2], 0.0f64);
        for pair in log.samples.windows(2) {
            let dt = pair[1].time_s - pair[0].time_s;
            for sample in pair {
                let push = force_on_object(sample);
                (0..2).for_each(|axis| {
                    impulse[axis] += 0.5 * dt * (push[axis] + mass_kg * scene.hand.gravity_m_s2[axis])
                });
            }
            most = most.max(impulse[0].hypot(impulse[1]));
        }
        let v = outcome.last.body(0).velocity_m_s;
        let difference = (impulse[0] - mass_kg * v[0]).hypot(impulse[1] - mass_kg * v[1]);
        let total: f64 = outcome.contacts.iter().map(|contact| contact.impulse_n_s).sum();
        assert_below(difference, 2e-3 * total, model.name());
        assert!(most > 1e-4, "the object has not moved");
    }
}

/// Force of all contacts on the object, N.
fn force_on_object(sample: &Sample) -> [f64; 2] {
    let mut force = [0.0; 2];
    for contact in sample.contacts() {
        // Samples give the forces on phalanx, palm and table. The normal of a joint limit is zero.
        let (n, t) = (contact.normal, contact.tangent());
        (0..2).for_each(|i| force[i] -= contact.normal_n * n[i] + contact.tangential_n * t[i]);
    }
    force
}

/// The fingers are mirror images of each other, with the same sign conventions in both models.
#[test]
fn a_symmetric_grasp_remains_symmetric_in_both_models() {
    // At everyday tolerances the events of both fingers are located one after the other.
    let scene = with_reference_settings(&reference_case("a").scene);
    for model in BOTH_MODELS {
        let last = run_model(model, &scene).0.last;
        let (right, left) = (last.finger(0), last.finger(1));
        assert!((right.q21_rad - left.q21_rad).abs() < 1e-9 && (right.q22_rad - left.q22_rad).abs() < 1e-9);
        assert!([0, 1].map(|motor| last.actuator(motor)) == [0.48; 2]);
        for index in 0..2 {
            let (a, b) = (last.contact(index), last.contact(2 + index));
            assert!(a.normal_n > 1.0 && (a.normal_n - b.normal_n).abs() < 1e-4 * a.normal_n, "{model:?}");
            assert!((a.point_m[0] + b.point_m[0]).abs() < 1e-9 && (a.normal[0] + b.normal[0]).abs() < 1e-7);
            assert!((a.tangential_n + b.tangential_n).abs() < 1e-3 * a.normal_n, "{model:?}: friction");
        }
        assert_eq!(scene.hand.contact_index(HandContact::Table), None, "case a has no table");
    }
}

/// A sample at a touch-down within a step contains the forces of the contacts that are loaded already. Without them, its
/// angles are 7e-5 rad off.
#[test]
fn samples_at_touch_downs_contain_the_forces_of_other_contacts() {
    let scene = Scene { duration_s: 9e-3, ..scene::load_any("scenes/gripper/cycle.toml").expect("a scene") };
    let (_, engine) = run_engine(&scene);
    let mut reference = Simulation::new(&with_reference_settings(&scene), Model::Analytic).expect("a simulation");
    for sample in &engine.samples {
        reference.advance_to(sample.time_s).expect("an advance");
        for (a, b) in reference.sample().fingers().zip(sample.fingers()) {
            let differences = [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad, a.q22_rad - b.q22_rad].map(f64::abs);
            assert!(differences.iter().all(|rad| *rad < 2e-5), "{differences:?} at {} s", sample.time_s);
        }
    }
}

/// The run is twice as long as the finger scenes, whose bound is 2e-5.
#[test]
fn a_fixed_object_does_not_move() {
    let mut scene = reference_case("c").scene;
    scene.hand.grasped_mut().motion = ObjectMotion::Fixed;
    let Comparison { scene, difference, outcome, .. } = Comparison::run(scene);
    assert_below(difference, 5e-5, "both models");
    assert_eq!(outcome.last.bodies().len(), 0, "a fixed object is a part of the ground");
    assert!(outcome.contacts[0].impulse_n_s > 0.1 && scene.hand.contact_index(HandContact::Palm).is_none());
}

/// The palm rotates. One gripper has a rotor inertia and a brake that slips; the other has a differential.
#[test]
fn a_rotating_palm_agrees_in_both_models() {
    let mut rotating = reference_case("e").scene;
    let motion = rotating.hand.palm_motion.as_mut().expect("a palm motion");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.7, start_s: 0.06, length_s: 0.04 });
    motion.vibrations[0].axis = Axis::Angle;
    motion.vibrations[0].amplitude = 2e-3;
    rotating.hand.fingers[0].motor.inertia_kg_m2 = 5e-6;
    rotating.hand.fingers[1].motor.brake.as_mut().expect("a brake").torque_n_m = 0.05;
    let mut geared = reference_case("f").scene;
    geared.hand.palm_motion = rotating.hand.palm_motion.clone();
    geared.duration_s = 0.1;
    geared.log.numeric_hz = 1e4;
    let differential = geared.hand.differential.as_mut().expect("a differential");
    differential.motor.brake = rotating.hand.fingers[0].motor.brake;
    for scene in [rotating, geared] {
        let comparison = Comparison::run(scene);
        comparison.assert_agrees(4e-5, 2e-6);
        assert!(comparison.energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{:?}", comparison.energies);
        assert_below(comparison.energy_difference(|energy| energy.kinetic_j), 2e-6, "kinetic energy");
        assert_below(comparison.energy_difference(|energy| energy.motor_work_j), 2e-5, "work");
    }
}

/// One move starts where another ends, except for rounding. In a step of 7e-18 s between the two, the palm speed would
/// consist of rounding errors, which created 0.3 J with a heavy object and slipping brakes.
#[test]
fn consecutive_moves_do_not_create_a_tiny_step() {
    let mut scene = reference_case("d").scene;
    let lift = Move { axis: Axis::Y, distance: -0.007, start_s: 0.02, length_s: 0.031 };
    let across = Move { axis: Axis::X, distance: 0.01, start_s: 0.051, length_s: 0.025 };
    assert_ne!(lift.start_s + lift.length_s, across.start_s);
    scene.hand.palm_motion.as_mut().expect("a palm motion").moves = vec![lift, across];
    let radius_m = max_radius(&scene.hand.grasped().shape);
    let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.hand.grasped_mut().motion else {
        panic!("the object is fixed")
    };
    (*mass_kg, *inertia_kg_m2) = (1.51, 0.5 * 1.51 * radius_m.powi(2));
    for finger in &mut scene.hand.fingers {
        finger.motor.brake.as_mut().expect("a brake").torque_n_m = 0.3194;
    }
    let comparison = Comparison::run(scene);
    assert_below(comparison.energies[1].balance_j.abs(), 3e-5, "balance of the engine");
    assert_below(comparison.difference, 6e-5, "both models");
}

/// Both models use the same stiction law. In case h, under 32 g, the distal phalanges lose contact a third of the time.
/// The elastic energy includes the bristles.
#[test]
fn stiction_agrees_in_both_models() {
    for (letter, bound, finest) in [("g", 2e-5, 2e-6), ("h", 2e-4, 3e-5)] {
        let comparison = Comparison::run(reference_case(letter).scene);
        comparison.assert_agrees(bound, finest);
        assert!(comparison.energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{:?}", comparison.energies);
        assert_below(comparison.energy_difference(|energy| energy.elastic_j), 5e-7, letter);
    }
}
