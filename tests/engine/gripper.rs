//! Grippers in both models, compared with each other and with an independent program.

use phalanx::criteria::{GraspCriteria, GraspTracker};
use phalanx::scene::{Axis, DiscMotion, Integrator, Move, Preset, Scene, Side, Stepping};
use phalanx::shape::max_radius;
use phalanx::trace::{Energy, Model, Outcome, Sample, run};

use crate::support::collect::CollectSink;
use crate::support::reference_cases::{cases_at_rest, reference_case};

fn run_collected(model: Model, scene: &Scene) -> (CollectSink, Outcome) {
    let mut log = CollectSink::default();
    let outcome = run(model, scene, &mut log).unwrap_or_else(|error| panic!("{}: {error}", model.name()));
    (log, outcome)
}

fn reference(scene: &Scene) -> Scene {
    Scene { integrator: Integrator::preset(Preset::Reference), ..scene.clone() }
}

/// Largest difference of angles (rad) and of positions (object radii) over the grid of the log.
fn max_difference(scene: &Scene, a: &CollectSink, b: &CollectSink) -> f64 {
    let steps = (scene.duration_s * scene.log.numeric_hz).round() as usize;
    let radius = max_radius(&scene.system.grasped().shape);
    let mut largest = 0.0f64;
    for k in 0..=steps {
        let time_s = k as f64 / scene.log.numeric_hz;
        let (a, b) = (a.nearest_sample(time_s), b.nearest_sample(time_s));
        assert!([a, b].iter().all(|sample| (sample.time_s - time_s).abs() < 1e-12), "no sample at {time_s} s");
        for (a, b) in a.fingers().zip(b.fingers()) {
            let angles = [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad, a.q12_rad - b.q12_rad, a.q22_rad - b.q22_rad];
            largest = angles.iter().fold(largest, |largest, angle| largest.max(angle.abs()));
        }
        let (a, b) = (a.body(0), b.body(0));
        let offsets = [(a.centre_m[0] - b.centre_m[0]) / radius, (a.centre_m[1] - b.centre_m[1]) / radius];
        largest = offsets
            .iter()
            .fold(largest.max((a.angle_rad - b.angle_rad).abs()), |largest, offset| largest.max(offset.abs()));
    }
    largest
}

/// Largest difference between the analytic log and the engine with a tolerance of 1e-9 m, a hundredth of the default.
fn max_difference_at_fine_tolerance(scene: &Scene, analytic: &CollectSink) -> f64 {
    let mut fine = scene.clone();
    fine.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
    max_difference(&fine, analytic, &run_collected(Model::Engine, &fine).0)
}

/// Bounds on the difference of the engine by case. Case c, with an offset object, is the hardest: one finger arrives 2
/// ms before the other, and errors grow by a factor of 10,000.
const ENGINE_BOUNDS: [(&str, f64); 5] = [("a", 2e-5), ("b", 6e-5), ("c", 1e-4), ("f", 4e-5), ("i", 2e-5)];

#[test]
fn both_models_agree_and_the_difference_falls_with_the_tolerance() {
    for (letter, bound) in ENGINE_BOUNDS {
        let case = reference_case(letter);
        let (analytic, _) = run_collected(Model::Analytic, &reference(&case.scene));
        let (default_run, outcome) = run_collected(Model::Engine, &case.scene);
        let difference = max_difference(&case.scene, &analytic, &default_run);
        assert!(difference < bound, "{}: {difference:.1e}", case.name);
        assert!(outcome.loop_gap_m < 1e-7, "{}: joints open by {:.1e} m", case.name, outcome.loop_gap_m);
        let fine_difference = max_difference_at_fine_tolerance(&case.scene, &analytic);
        assert!(
            fine_difference < 2e-6 && fine_difference < 0.3 * difference,
            "{}: {fine_difference:.1e} at 1e-9 m, {difference:.1e} at 1e-7 m",
            case.name
        );
    }
}

#[test]
fn contact_times_and_impulses_match_an_independent_program() {
    for case in cases_at_rest() {
        for (model, time_s, relative_tolerance) in [(Model::Analytic, 5e-8, 1e-4), (Model::Engine, 1e-6, 5e-3)] {
            let (log, outcome) = run_collected(model, &case.scene);
            for (index, expected) in [0, 1, 3, 4].into_iter().zip(case.first_contact_s) {
                let first = log.first_contact_s(index).expect("a first contact");
                assert!(
                    (first - expected).abs() < time_s,
                    "{} {}: contact {index} at {first} s",
                    model.name(),
                    case.name
                );
                assert_eq!(outcome.contacts[index].first_s, Some(first));
            }
            for (index, expected) in [0, 1, 3, 4, 6, 7].into_iter().zip(case.impulse) {
                let actual = outcome.contacts[index].impulse_n_s;
                let difference = (actual - expected).abs() / expected.max(0.02);
                assert!(
                    difference < relative_tolerance,
                    "{} {}: contact {index}: impulse {actual}, expected {expected}",
                    model.name(),
                    case.name
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
        let evaluate = |model| -> GraspCriteria {
            let mut tracker = GraspTracker::for_scene(&case.scene);
            run(model, &case.scene, &mut tracker).expect("a completed run");
            tracker.criteria().expect("samples")
        };
        let [analytic, engine] = [Model::Analytic, Model::Engine].map(evaluate);
        assert_eq!(analytic.fate, engine.fate, "{}", case.name);
        let assert_near = |a: Option<f64>, b: Option<f64>, tolerance: f64, quantity: &str| match (a, b) {
            (Some(a), Some(b)) => assert!((a - b).abs() < tolerance, "{}: {quantity}: {a} and {b}", case.name),
            _ => assert_eq!(a, b, "{}: {quantity}", case.name),
        };
        assert_near(analytic.grasped_s, engine.grasped_s, 1e-6, "grasped");
        assert_near(analytic.tts_s, engine.tts_s, 1e-5, "stable");
        assert_near(analytic.offset_ratio(), engine.offset_ratio(), 1e-3, "offset");
        let [slip, other] = [&analytic, &engine].map(|criteria| criteria.slip.expect("a grasp"));
        assert_near(Some(slip.displacement_m), Some(other.displacement_m), 1e-6, "slip");
        assert_near(Some(slip.rotation_rad), Some(other.rotation_rad), 1e-4, "rotation");
        for (a, b) in analytic.contacts.iter().zip(&engine.contacts) {
            assert_near(a.first_contact_s, b.first_contact_s, 1e-6, &a.id.name());
            assert_near(a.active_since_s, b.active_since_s, 1e-5, &a.id.name());
            assert_near(Some(a.lost_s), Some(b.lost_s), 2e-5, &a.id.name());
        }
    }
}

/// The impulse of gravity and contact forces equals the momentum of the object, up to the error of integrating the
/// samples.
#[test]
fn momentum_of_the_object_matches_its_contact_forces() {
    let mut scene = reference_case("c").scene;
    scene.log.numeric_hz = 2e5;
    let DiscMotion::Free { mass_kg, .. } = scene.system.grasped().motion else { panic!("the object is fixed") };
    for (model, allowed) in [(Model::Analytic, 2e-3), (Model::Engine, 2e-3)] {
        let (log, outcome) = run_collected(model, &scene);
        let (mut impulse, mut most) = ([0.0; 2], 0.0f64);
        for pair in log.samples.windows(2) {
            let dt = pair[1].time_s - pair[0].time_s;
            for sample in pair {
                let push = force_on_object(sample);
                (0..2).for_each(|axis| {
                    impulse[axis] += 0.5 * dt * (push[axis] + mass_kg * scene.system.gravity_m_s2[axis])
                });
            }
            most = most.max(impulse[0].hypot(impulse[1]));
        }
        let v = outcome.last.body(0).velocity_m_s;
        let difference = (impulse[0] - mass_kg * v[0]).hypot(impulse[1] - mass_kg * v[1]);
        let total: f64 = outcome.contacts.iter().map(|contact| contact.impulse_n_s).sum();
        assert!(difference < allowed * total, "{}: {difference:.1e} N s of {total:.2}", model.name());
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
    let scene = reference_case("a").scene;
    for model in [Model::Analytic, Model::Engine] {
        let last = run_collected(model, &scene).1.last;
        let [right, left] = Side::BOTH.map(|side| last.finger(side as usize));
        assert!((right.q21_rad - left.q21_rad).abs() < 1e-9 && (right.q22_rad - left.q22_rad).abs() < 1e-9);
        assert!((right.motor_torque_n_m - 0.48).abs() < 1e-12 && (left.motor_torque_n_m - 0.48).abs() < 1e-12);
        for index in 0..2 {
            let (a, b) = (last.contact(index), last.contact(3 + index));
            assert!(a.normal_n > 1.0 && (a.normal_n - b.normal_n).abs() < 1e-4 * a.normal_n, "{}", model.name());
            assert!((a.point_m[0] + b.point_m[0]).abs() < 1e-9 && (a.normal[0] + b.normal[0]).abs() < 1e-7);
            assert!((a.tangential_n + b.tangential_n).abs() < 1e-3 * a.normal_n, "{}: friction", model.name());
        }
        assert!(last.contact(7).gap_m.is_infinite(), "case a has no table");
    }
}

#[test]
fn a_fixed_object_does_not_move() {
    let mut scene = reference_case("c").scene;
    scene.system.grasped_mut().motion = DiscMotion::Fixed;
    let (analytic, _) = run_collected(Model::Analytic, &reference(&scene));
    let (engine, outcome) = run_collected(Model::Engine, &scene);
    let difference = max_difference(&scene, &analytic, &engine);
    // The run is twice as long as the finger scenes, whose bound is 2e-5.
    assert!(difference < 5e-5, "{difference:.1e}");
    assert_eq!(outcome.last.body(0).centre_m, scene.system.grasped().centre_m);
    assert!(outcome.contacts[0].impulse_n_s > 0.1 && outcome.contacts[6].impulse_n_s == 0.0);
}

/// The formulations differ: the analytic model uses the palm frame, the engine moves the base.
#[test]
fn a_translating_palm_agrees_in_both_models() {
    for (letter, bound) in [("d", 6e-5), ("e", 6e-5)] {
        let case = reference_case(letter);
        let (analytic, analytic_outcome) = run_collected(Model::Analytic, &reference(&case.scene));
        let (default_run, outcome) = run_collected(Model::Engine, &case.scene);
        let difference = max_difference(&case.scene, &analytic, &default_run);
        let energies = [&analytic_outcome, &outcome].map(|outcome| outcome.last.energy());
        assert!(difference < bound, "{}: {difference:.1e}", case.name);
        assert!(outcome.loop_gap_m < 1e-7, "{}: joints open by {:.1e} m", case.name, outcome.loop_gap_m);
        let fine_difference = max_difference_at_fine_tolerance(&case.scene, &analytic);
        assert!(
            fine_difference < 2e-6 && fine_difference < 0.3 * difference,
            "{}: {fine_difference:.1e} at 1e-9 m, {difference:.1e} at 1e-7 m",
            case.name
        );
        assert!((energies[0].motor_work_j - energies[1].motor_work_j).abs() < 1e-4, "{energies:?}");
    }
}

/// The palm rotates. One gripper has a rotor inertia and a brake that slips; the other has a differential.
#[test]
fn a_rotating_palm_agrees_in_both_models() {
    let mut rotating = reference_case("e").scene;
    let motion = rotating.system.palm_motion.as_mut().expect("a palm motion");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.7, start_s: 0.06, length_s: 0.04 });
    motion.vibrations[0].axis = Axis::Angle;
    motion.vibrations[0].amplitude = 2e-3;
    rotating.system.fingers[0].motor.inertia_kg_m2 = 5e-6;
    rotating.system.fingers[1].motor.brake.as_mut().expect("a brake").torque_n_m = 0.05;
    let mut geared = reference_case("f").scene;
    geared.system.palm_motion = rotating.system.palm_motion.clone();
    geared.duration_s = 0.1;
    geared.log.numeric_hz = 1e4;
    let differential = geared.system.differential.as_mut().expect("a differential");
    differential.motor.brake = rotating.system.fingers[0].motor.brake;
    for (scene, bound) in [(rotating, 4e-5), (geared, 4e-5)] {
        let (analytic, analytic_outcome) = run_collected(Model::Analytic, &reference(&scene));
        let (default_run, outcome) = run_collected(Model::Engine, &scene);
        let difference = max_difference(&scene, &analytic, &default_run);
        let energies = [&analytic_outcome, &outcome].map(|outcome| outcome.last.energy());
        assert!(difference < bound, "{difference:.1e}");
        let fine_difference = max_difference_at_fine_tolerance(&scene, &analytic);
        assert!(
            fine_difference < 2e-6 && fine_difference < 0.3 * difference,
            "{fine_difference:.1e} at 1e-9 m, {difference:.1e} at 1e-7 m"
        );
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{energies:?}");
        let [kinetic, work] = [|energy: &Energy| energy.kinetic_j, |energy: &Energy| energy.motor_work_j]
            .map(|of| (of(&energies[0]) - of(&energies[1])).abs());
        assert!(kinetic < 2e-6 && work < 2e-5, "{energies:?}");
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
    scene.system.palm_motion.as_mut().expect("a palm motion").moves = vec![lift, across];
    let radius_m = max_radius(&scene.system.grasped().shape);
    let DiscMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.system.grasped_mut().motion else {
        panic!("the object is fixed")
    };
    (*mass_kg, *inertia_kg_m2) = (1.51, Some(0.5 * 1.51 * radius_m.powi(2)));
    for finger in &mut scene.system.fingers {
        finger.motor.brake.as_mut().expect("a brake").torque_n_m = 0.3194;
    }
    let (analytic, _) = run_collected(Model::Analytic, &reference(&scene));
    let (default_run, outcome) = run_collected(Model::Engine, &scene);
    assert!(outcome.last.energy().balance_j.abs() < 3e-5, "{:?}", outcome.last.energy());
    let difference = max_difference(&scene, &analytic, &default_run);
    assert!(difference < 6e-5, "{difference:.1e}");
}

/// Both models use the same stiction law. In case h, under 32 g, the distal phalanges lose contact a third of the time.
#[test]
fn stiction_agrees_in_both_models() {
    for (letter, bound, finest) in [("g", 2e-5, 2e-6), ("h", 2e-4, 3e-5)] {
        let case = reference_case(letter);
        let (analytic, analytic_outcome) = run_collected(Model::Analytic, &reference(&case.scene));
        let (default_run, outcome) = run_collected(Model::Engine, &case.scene);
        let difference = max_difference(&case.scene, &analytic, &default_run);
        let energies = [&analytic_outcome, &outcome].map(|outcome| outcome.last.energy());
        assert!(difference < bound, "{}: {difference:.1e}", case.name);
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{energies:?}");
        assert!((energies[0].elastic_j - energies[1].elastic_j).abs() < 5e-7, "energy of the bristles: {energies:?}");
        let fine_difference = max_difference_at_fine_tolerance(&case.scene, &analytic);
        assert!(
            fine_difference < finest && fine_difference < 0.3 * difference,
            "{}: {fine_difference:.1e} at 1e-9 m, {difference:.1e} at 1e-7 m",
            case.name
        );
    }
}
