//! Statics compared with the end of simulations: equal forces up to penetration and weight.

use phalanx::fivebar::dynamics::{Dynamics, inverse_dynamics};
use phalanx::fivebar::kinematics::reference_gamma;
use phalanx::grasp::finger::{Grasp, GraspOverrides, grasp};
use phalanx::gripper::{FinalPosture, Posture, joint_positions};
use phalanx::numeric::plane::{dot, sub};
use phalanx::scene::{self, Scene};
use phalanx::statics::{Equilibrium, drive_loads, equilibrium, palm_force};
use phalanx::trace::{self, FingerContact, FingerState, Sample};
use std::f64::consts::FRAC_PI_2;

fn load(file: &str) -> Scene {
    scene::load(file).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the last sample of a run.
fn simulate(scene: &Scene) -> Sample {
    trace::run_analytic(scene, &mut ()).unwrap_or_else(|error| panic!("{error}")).last
}

fn forces(last: &Sample) -> [f64; 2] {
    [FingerContact::Proximal, FingerContact::Distal].map(|contact| last.finger_contact(contact).normal_n)
}

fn static_grasp(scene: &Scene) -> Grasp {
    grasp(scene, &GraspOverrides { mu_static: vec![0.0], motor_n_m: None }).unwrap()
}

/// Returns the final posture of the simulation, with both phalanges penetrating the object by a few micrometres.
fn penetrated_posture(scene: &Scene, last: &Sample) -> FinalPosture {
    let lengths = &scene.finger().linkage.lengths;
    let FingerState { q11_rad, q21_rad, q12_rad, q22_rad, .. } = last.finger(0);
    let posture = Posture { q11_rad, q21_rad, q12_rad, q22_rad };
    let joints = joint_positions(lengths, &posture);
    let centre = scene.object().unwrap().centre_m;
    let along = |from: [f64; 2], to: [f64; 2]| {
        let phalanx = sub(to, from);
        dot(phalanx, sub(centre, from)) / phalanx[0].hypot(phalanx[1])
    };
    FinalPosture {
        posture,
        l_c21_m: along([0.0; 2], joints.a22_m),
        l_c22_m: along(joints.a22_m, joints.tip_m),
        phi_c_rad: q21_rad + q22_rad + lengths.phi22_rad - FRAC_PI_2,
    }
}

/// Returns the forces that balance motor, spring and weight without friction.
fn balance(scene: &Scene, end: &FinalPosture) -> Equilibrium {
    let finger = scene.finger();
    let dynamics = Dynamics::new(&finger.linkage, reference_gamma(&finger.linkage.lengths), scene.hand.gravity_m_s2);
    let weight = inverse_dynamics(&dynamics, [end.posture.q11_rad, end.posture.q21_rad], [0.0; 2], [0.0; 2]);
    let motor_n_m = finger.motor.actuation.at(scene.duration_s).0;
    let drive = drive_loads(&finger.linkage, end, motor_n_m, finger.spring.as_ref()).unwrap();
    equilibrium(&finger.linkage, end, sub(drive, weight), 0.0).unwrap()
}

#[track_caller]
fn assert_near(actual: [f64; 2], expected: Equilibrium, relative: f64) {
    for (actual, expected) in actual.into_iter().zip([expected.f21_n, expected.f22_n]) {
        let error = actual / expected - 1.0;
        assert!(error.abs() <= relative, "{actual} is not {expected} to {relative:e}: {error:e}");
    }
}

#[test]
fn forces_at_the_end_of_a_simulation_are_in_balance() {
    for (file, relative) in [
        ("scenes/experiment-95-frictionless.toml", 1e-5),
        ("scenes/torsional-spring.toml", 2e-3),
        // The regularised friction has decayed to a few hundredths of a newton.
        ("scenes/experiment-95.toml", 2e-3),
        ("scenes/long-fingers.toml", 2e-3),
    ] {
        let scene = load(file);
        let last = simulate(&scene);
        assert_near(forces(&last), balance(&scene, &penetrated_posture(&scene, &last)), relative);
    }
}

#[test]
fn design_95_at_rest_differs_from_its_simulation_only_by_penetration_and_weight() {
    let scene = load("scenes/experiment-95-frictionless.toml");
    let last = simulate(&scene);
    let Grasp { end, forces: at_rest, .. } = static_grasp(&scene);
    let at_rest = at_rest[0].equilibrium;
    // Penetration of 4 µm on levers of 12 mm, and the weight of the links, which (2.31) neglects.
    let penetrated = penetrated_posture(&scene, &last);
    assert!((penetrated.posture.q21_rad - end.posture.q21_rad).abs() < 4e-4);
    let weightless = weightless(&scene);
    assert_near([at_rest.f21_n, at_rest.f22_n], balance(&weightless, &end), 1e-12);
    assert_near([at_rest.f21_n, at_rest.f22_n], balance(&weightless, &penetrated), 3e-3);
    assert_near(forces(&last), at_rest, 1e-2);
}

#[test]
fn simulated_palm_force_matches_its_definition() {
    // 1-model §1.8, by an independent integration: 23.6092 N and 8.2573 N; PFP 17.3 N (the thesis prints 16.3).
    let scene = load("scenes/experiment-95.toml");
    let [f21, f22] = forces(&simulate(&scene));
    assert!((f21 - 23.6092).abs() < 2e-3 && (f22 - 8.2573).abs() < 2e-3, "{f21} {f22}");
    assert!((palm_force(&static_grasp(&scene).end, f21, f22, 0.8) - 17.26).abs() < 0.01);
}

/// Returns the scene without gravity.
fn weightless(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.hand.gravity_m_s2 = [0.0; 2];
    scene
}

#[test]
fn stiffer_contacts_reduce_the_difference() {
    let soft = weightless(&load("scenes/experiment-95-frictionless.toml"));
    let mut stiffer = soft.clone();
    for law in stiffer.finger_mut().contact.both_mut().map(|law| &mut law.normal) {
        law.stiffness_n_per_m_e *= 10.0;
        *law = law.with_damping_max(law.damping_max() * 10.0);
    }
    let static_forces = static_grasp(&soft).forces[0].equilibrium;
    let deviation = |scene: &Scene| {
        let [f21, f22] = forces(&simulate(scene));
        (f21 / static_forces.f21_n - 1.0).abs().max((f22 / static_forces.f22_n - 1.0).abs())
    };
    let (soft, stiffer) = (deviation(&soft), deviation(&stiffer));
    assert!(stiffer < 0.5 * soft, "{soft:e} {stiffer:e}");
}
