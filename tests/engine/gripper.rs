//! Grippers in both models, held to each other and to an independent program.

use phalanx::criteria::{GraspCriteria, GraspTracker};
use phalanx::scene::{Axis, DiscMotion, Integrator, Move, Preset, Scene, Side, Stepping};
use phalanx::shape::reach;
use phalanx::trace::{Energy, Model, Outcome, Sample, run};

use crate::support::collect::Collect;
use crate::support::grippers::{anchor, anchors};

fn kept(model: Model, scene: &Scene) -> (Collect, Outcome) {
    let mut kept = Collect::default();
    let outcome = run(model, scene, &mut kept).unwrap_or_else(|error| panic!("{}: {error}", model.name()));
    (kept, outcome)
}

fn reference(scene: &Scene) -> Scene {
    Scene { integrator: Integrator::preset(Preset::Reference), ..scene.clone() }
}

/// Largest difference of angles, and of positions in object radii, over the grid of the log.
fn apart(scene: &Scene, a: &Collect, b: &Collect) -> f64 {
    let steps = (scene.duration_s * scene.log.numeric_hz).round() as usize;
    let radius = reach(&scene.system.grasped().shape);
    let mut most = 0.0f64;
    for k in 0..=steps {
        let time_s = k as f64 / scene.log.numeric_hz;
        let (a, b) = (a.at(time_s), b.at(time_s));
        assert!([a, b].iter().all(|sample| (sample.time_s - time_s).abs() < 1e-12), "no sample at {time_s} s");
        for (a, b) in a.fingers.iter().zip(&b.fingers) {
            let angles = [a.q11_rad - b.q11_rad, a.q21_rad - b.q21_rad, a.q12_rad - b.q12_rad, a.q22_rad - b.q22_rad];
            most = angles.iter().fold(most, |most, angle| most.max(angle.abs()));
        }
        let (a, b) = (&a.bodies[0], &b.bodies[0]);
        let off = [(a.centre_m[0] - b.centre_m[0]) / radius, (a.centre_m[1] - b.centre_m[1]) / radius];
        most = off.iter().fold(most.max((a.angle_rad - b.angle_rad).abs()), |most, off| most.max(off.abs()));
    }
    most
}

/// The same of the engine at a hundredth of its tolerance.
fn finely_apart(scene: &Scene, exact: &Collect) -> f64 {
    let mut fine = scene.clone();
    fine.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
    apart(&fine, exact, &kept(Model::Engine, &fine).0)
}

/// The offset of case c is the hardest: one finger is first by 2 ms, and what a method is off by grows ten-thousandfold.
const ENGINE: [(&str, f64); 5] = [("a", 2e-5), ("b", 6e-5), ("c", 1e-4), ("f", 4e-5), ("i", 2e-5)];

#[test]
fn both_models_agree_and_more_finely_the_better() {
    for (letter, bound) in ENGINE {
        let anchor = anchor(letter);
        let (exact, _) = kept(Model::Analytic, &reference(&anchor.scene));
        let (usual, outcome) = kept(Model::Engine, &anchor.scene);
        let off = apart(&anchor.scene, &exact, &usual);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
        assert!(outcome.loop_gap_m < 1e-7, "{}: joints open by {:.1e} m", anchor.name, outcome.loop_gap_m);
        let finer = finely_apart(&anchor.scene, &exact);
        assert!(finer < 2e-6 && finer < 0.3 * off, "{}: {finer:.1e} at 1e-9 m, {off:.1e} at 1e-7 m", anchor.name);
    }
}

#[test]
fn touches_and_impulses_are_those_of_an_independent_program() {
    for anchor in anchors() {
        for (model, time_s, part) in [(Model::Analytic, 5e-8, 1e-4), (Model::Engine, 1e-6, 5e-3)] {
            let (kept, outcome) = kept(model, &anchor.scene);
            for (place, wanted) in [0, 1, 3, 4].into_iter().zip(anchor.first_touch_s) {
                let first = kept.first_touch(place).expect("a touch");
                assert!((first - wanted).abs() < time_s, "{} {}: {place} at {first}", model.name(), anchor.name);
                assert_eq!(outcome.contacts[place].first_s, Some(first));
            }
            for (place, wanted) in [0, 1, 3, 4, 6, 7].into_iter().zip(anchor.impulse) {
                let found = outcome.contacts[place].impulse_n_s;
                let off = (found - wanted).abs() / wanted.max(0.02);
                assert!(off < part, "{} {}: impulse {place} {found}, not {wanted}", model.name(), anchor.name);
            }
        }
    }
}

/// First touches agree to a microsecond. When a contact that an impact has thrown off presses again is off by up to 8 µs (case f), how
/// long it was off, over several impacts, by up to 11 µs (case c).
#[test]
fn criteria_of_a_grasp_are_those_of_the_analytic_model() {
    for anchor in anchors() {
        let judged = |model| -> GraspCriteria {
            let mut tracker = GraspTracker::of(&anchor.scene);
            run(model, &anchor.scene, &mut tracker).expect("a run to its end");
            tracker.criteria().expect("samples")
        };
        let [exact, engine] = [Model::Analytic, Model::Engine].map(judged);
        assert_eq!(exact.fate, engine.fate, "{}", anchor.name);
        let near = |a: Option<f64>, b: Option<f64>, within: f64, what: &str| match (a, b) {
            (Some(a), Some(b)) => assert!((a - b).abs() < within, "{}: {what} {a} and {b}", anchor.name),
            _ => assert_eq!(a, b, "{}: {what}", anchor.name),
        };
        near(exact.grasped_s, engine.grasped_s, 1e-6, "grasped");
        near(exact.tts_s, engine.tts_s, 1e-5, "stable");
        near(exact.offset_ratio(), engine.offset_ratio(), 1e-3, "offset");
        let [slip, other] = [&exact, &engine].map(|found| found.slip.expect("a grasp"));
        near(Some(slip.displacement_m), Some(other.displacement_m), 1e-6, "slip");
        near(Some(slip.rotation_rad), Some(other.rotation_rad), 1e-4, "rotation");
        for (a, b) in exact.contacts.iter().zip(&engine.contacts) {
            near(a.first_touch_s, b.first_touch_s, 1e-6, &a.place.name());
            near(a.presses_since_s, b.presses_since_s, 1e-5, &a.place.name());
            near(Some(a.lost_s), Some(b.lost_s), 2e-5, &a.place.name());
        }
    }
}

/// Nothing but gravity and the contacts acts on the object: its momentum is theirs to rounding in the engine too.
#[test]
fn momentum_of_the_object_is_that_of_its_contacts() {
    let mut scene = anchor("c").scene;
    scene.log.numeric_hz = 2e5;
    let DiscMotion::Free { mass_kg, .. } = scene.system.grasped().motion else { panic!("a free object") };
    for (model, allowed) in [(Model::Analytic, 2e-3), (Model::Engine, 2e-3)] {
        let (kept, outcome) = kept(model, &scene);
        let (mut impulse, mut most) = ([0.0; 2], 0.0f64);
        for pair in kept.samples.windows(2) {
            let dt = pair[1].time_s - pair[0].time_s;
            for sample in pair {
                let push = pushed(sample);
                (0..2).for_each(|axis| {
                    impulse[axis] += 0.5 * dt * (push[axis] + mass_kg * scene.system.gravity_m_s2[axis])
                });
            }
            most = most.max(impulse[0].hypot(impulse[1]));
        }
        let v = outcome.last.bodies[0].velocity_m_s;
        let off = (impulse[0] - mass_kg * v[0]).hypot(impulse[1] - mass_kg * v[1]);
        let total: f64 = outcome.contacts.iter().map(|contact| contact.impulse_n_s).sum();
        assert!(off < allowed * total, "{}: {off:.1e} N s of {total:.2}", model.name());
        assert!(most > 1e-4, "the object has moved");
    }
}

/// Force of all contacts on the object, N.
fn pushed(sample: &Sample) -> [f64; 2] {
    let mut force = [0.0; 2];
    for contact in &sample.contacts {
        // Forces are those on phalanx, palm and table; of a limit there is no normal.
        let (n, t) = (contact.normal, contact.tangent());
        (0..2).for_each(|i| force[i] -= contact.normal_n * n[i] + contact.tangential_n * t[i]);
    }
    force
}

/// What both fingers do is each other's mirror image, and both models say it with the same signs.
#[test]
fn a_symmetric_grasp_is_its_own_mirror_image_in_both_models() {
    let scene = anchor("a").scene;
    for model in [Model::Analytic, Model::Engine] {
        let last = kept(model, &scene).1.last;
        let [right, left] = Side::BOTH.map(|side| last.fingers[side as usize]);
        assert!((right.q21_rad - left.q21_rad).abs() < 1e-9 && (right.q22_rad - left.q22_rad).abs() < 1e-9);
        assert!((right.motor_torque_n_m - 0.48).abs() < 1e-12 && (left.motor_torque_n_m - 0.48).abs() < 1e-12);
        for site in 0..2 {
            let (a, b) = (&last.contacts[site], &last.contacts[3 + site]);
            assert!(a.normal_n > 1.0 && (a.normal_n - b.normal_n).abs() < 1e-4 * a.normal_n, "{}", model.name());
            assert!((a.point_m[0] + b.point_m[0]).abs() < 1e-9 && (a.normal[0] + b.normal[0]).abs() < 1e-7);
            assert!((a.tangential_n + b.tangential_n).abs() < 1e-3 * a.normal_n, "{}: friction", model.name());
        }
        assert!(last.contacts[7].gap_m.is_infinite(), "there is no table");
    }
}

#[test]
fn a_fixed_object_stays_where_it_is() {
    let mut scene = anchor("c").scene;
    scene.system.grasped_mut().motion = DiscMotion::Fixed;
    let (exact, _) = kept(Model::Analytic, &reference(&scene));
    let (engine, outcome) = kept(Model::Engine, &scene);
    let off = apart(&scene, &exact, &engine);
    // Twice as long as the closing that scenes of fingers hold to 2e-5.
    assert!(off < 5e-5, "{off:.1e}");
    assert_eq!(outcome.last.bodies[0].centre_m, scene.system.grasped().centre_m);
    assert!(outcome.contacts[0].impulse_n_s > 0.1 && outcome.contacts[6].impulse_n_s == 0.0);
}

/// The analytic model is in the frame of the palm, the engine moves its base: two formulations.
#[test]
fn a_palm_that_moves_is_the_same_in_both_models() {
    for (letter, bound) in [("d", 6e-5), ("e", 6e-5)] {
        let anchor = anchor(letter);
        let (exact, told) = kept(Model::Analytic, &reference(&anchor.scene));
        let (usual, outcome) = kept(Model::Engine, &anchor.scene);
        let off = apart(&anchor.scene, &exact, &usual);
        let energies = [&told, &outcome].map(|outcome| outcome.last.energy);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
        assert!(outcome.loop_gap_m < 1e-7, "{}: joints open by {:.1e} m", anchor.name, outcome.loop_gap_m);
        let finer = finely_apart(&anchor.scene, &exact);
        assert!(finer < 2e-6 && finer < 0.3 * off, "{}: {finer:.1e} at 1e-9 m, {off:.1e} at 1e-7 m", anchor.name);
        assert!((energies[0].motor_work_j - energies[1].motor_work_j).abs() < 1e-4, "{energies:?}");
    }
}

/// It turns, with rotors and a differential that do not feel it, and what holds one of the motors gives way.
#[test]
fn a_palm_that_turns_is_the_same_in_both_models() {
    let mut turned = anchor("e").scene;
    let motion = turned.system.palm_motion.as_mut().expect("it moves");
    motion.moves.push(Move { axis: Axis::Angle, distance: 0.7, start_s: 0.06, length_s: 0.04 });
    motion.vibrations[0].axis = Axis::Angle;
    motion.vibrations[0].amplitude = 2e-3;
    turned.system.fingers[0].motor.inertia_kg_m2 = 5e-6;
    turned.system.fingers[1].motor.brake.as_mut().expect("a brake").torque_n_m = 0.05;
    let mut geared = anchor("f").scene;
    geared.system.palm_motion = turned.system.palm_motion.clone();
    geared.duration_s = 0.1;
    geared.log.numeric_hz = 1e4;
    let differential = geared.system.differential.as_mut().expect("a differential");
    differential.motor.brake = turned.system.fingers[0].motor.brake;
    for (scene, bound) in [(turned, 4e-5), (geared, 4e-5)] {
        let (exact, told) = kept(Model::Analytic, &reference(&scene));
        let (usual, outcome) = kept(Model::Engine, &scene);
        let off = apart(&scene, &exact, &usual);
        let energies = [&told, &outcome].map(|outcome| outcome.last.energy);
        assert!(off < bound, "{off:.1e}");
        let finer = finely_apart(&scene, &exact);
        assert!(finer < 2e-6 && finer < 0.3 * off, "{finer:.1e} at 1e-9 m, {off:.1e} at 1e-7 m");
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{energies:?}");
        let [kinetic, given] = [|energy: &Energy| energy.kinetic_j, |energy: &Energy| energy.motor_work_j]
            .map(|of| (of(&energies[0]) - of(&energies[1])).abs());
        assert!(kinetic < 2e-6 && given < 2e-5, "{energies:?}");
    }
}

/// A move that begins where another ends, in last digits not quite. In a step of 7e-18 s from one to the other the palm has a speed of
/// rounding: a heavy object under brakes that slip made 0.3 J of it.
#[test]
fn moves_that_follow_each_other_make_no_step_of_their_own() {
    let mut scene = anchor("d").scene;
    let lift = Move { axis: Axis::Y, distance: -0.007, start_s: 0.02, length_s: 0.031 };
    let across = Move { axis: Axis::X, distance: 0.01, start_s: 0.051, length_s: 0.025 };
    assert_ne!(lift.start_s + lift.length_s, across.start_s);
    scene.system.palm_motion.as_mut().expect("it moves").moves = vec![lift, across];
    let radius_m = reach(&scene.system.grasped().shape);
    let DiscMotion::Free { mass_kg, inertia_kg_m2, .. } = &mut scene.system.grasped_mut().motion else {
        panic!("it is free")
    };
    (*mass_kg, *inertia_kg_m2) = (1.51, Some(0.5 * 1.51 * radius_m.powi(2)));
    for finger in &mut scene.system.fingers {
        finger.motor.brake.as_mut().expect("a brake").torque_n_m = 0.3194;
    }
    let (exact, _) = kept(Model::Analytic, &reference(&scene));
    let (usual, outcome) = kept(Model::Engine, &scene);
    assert!(outcome.last.energy.balance_j.abs() < 3e-5, "{:?}", outcome.last.energy);
    let off = apart(&scene, &exact, &usual);
    assert!(off < 6e-5, "{off:.1e}");
}

/// Friction that holds: the same law in both models. In case h tips lose their contact a third of the time, under 32 g.
#[test]
fn what_bristles_hold_is_the_same_in_both_models() {
    for (letter, bound, finest) in [("g", 2e-5, 2e-6), ("h", 2e-4, 3e-5)] {
        let anchor = anchor(letter);
        let (exact, told) = kept(Model::Analytic, &reference(&anchor.scene));
        let (usual, outcome) = kept(Model::Engine, &anchor.scene);
        let off = apart(&anchor.scene, &exact, &usual);
        let energies = [&told, &outcome].map(|outcome| outcome.last.energy);
        assert!(off < bound, "{}: {off:.1e}", anchor.name);
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{energies:?}");
        assert!((energies[0].elastic_j - energies[1].elastic_j).abs() < 5e-7, "what bristles store: {energies:?}");
        let finer = finely_apart(&anchor.scene, &exact);
        assert!(finer < finest && finer < 0.3 * off, "{}: {finer:.1e} at 1e-9 m, {off:.1e} at 1e-7 m", anchor.name);
    }
}
