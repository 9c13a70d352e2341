//! The engine model of design 95 against the analytic model, with default settings and with coarse fixed steps.

use crate::support::runs::{
    assert_near, experiment_95, impact_impulse, max_angle_error, run_dense_reference, run_engine,
};
use phalanx::scene::{Actuation, Response, Scene, Stepping};
use phalanx::trace::FingerContact;

/// Experiment 95 with perturbations of its torque in the ninth digit, which show the scatter of the errors.
fn perturbed_scenes() -> Vec<Scene> {
    (0..5)
        .map(|i| {
            let torque_n_m = 0.480 * (1.0 + 1e-9 * f64::from(i));
            let mut scene = experiment_95();
            scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m };
            scene
        })
        .collect()
}

/// The documented accuracy of the default settings, for all perturbed scenes.
#[test]
fn default_settings_agree_with_the_analytic_model_over_the_whole_closing() {
    for scene in perturbed_scenes() {
        let (expected_outcome, reference) = run_dense_reference(&scene);
        let (outcome, run) = run_engine(&scene);
        let angle = max_angle_error(&run, &reference);
        assert!(angle <= 2e-5, "largest angle difference {angle:e}");
        for contact in [FingerContact::Proximal, FingerContact::Distal] {
            let (actual, expected) = (outcome.finger_contact(contact), expected_outcome.finger_contact(contact));
            assert_eq!(actual.touchdowns, expected.touchdowns);
            assert_near(actual.first_s.unwrap(), expected.first_s.unwrap(), 0.5e-6, "first contact");
            let (impulse, expected) =
                (impact_impulse(&run, contact, 20e-6), impact_impulse(&reference, contact, 20e-6));
            assert_near(impulse, expected, 5e-3 * expected, "impulse of the impact");
        }
        for (actual, expected) in [
            (
                outcome.last.finger_contact(FingerContact::Proximal).normal_n,
                expected_outcome.last.finger_contact(FingerContact::Proximal).normal_n,
            ),
            (
                outcome.last.finger_contact(FingerContact::Distal).normal_n,
                expected_outcome.last.finger_contact(FingerContact::Distal).normal_n,
            ),
        ] {
            assert_near(actual, expected, 1e-4 * expected, "final normal force");
        }
        assert!(outcome.loop_gap_m <= 1e-7, "loop gap {:e}", outcome.loop_gap_m);
    }
}

/// The engine matches the reference values of experiment 95 (1-model §1.8).
#[test]
fn default_settings_match_the_reference_values() {
    let (outcome, _) = run_engine(&experiment_95());
    assert_near(outcome.finger_contact(FingerContact::Proximal).first_s.unwrap(), 4.501315e-3, 2e-8, "first contact");
    assert_near(outcome.finger_contact(FingerContact::Distal).first_s.unwrap(), 6.883746e-3, 2e-8, "second contact");
    assert_near(outcome.last.finger(0).q11_rad.to_degrees(), 2.088778, 2e-5, "q11");
    assert_near(outcome.last.finger(0).q21_rad.to_degrees(), 65.019991, 2e-5, "q21");
}

/// With steps of 1e-4 s the engine is as accurate as tuned rigid-contact engines: contact times within one step, the
/// final posture within 3e-4 rad.
#[test]
fn a_step_of_0_1_ms_is_as_accurate_as_rigid_contact() {
    for mut scene in perturbed_scenes() {
        scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
        let (expected_outcome, _) = run_dense_reference(&scene);
        let (outcome, _) = run_engine(&scene);
        assert_eq!(outcome.work.steps, 200);
        for contact in [FingerContact::Proximal, FingerContact::Distal] {
            let (actual, expected) = (
                outcome.finger_contact(contact).first_s.unwrap(),
                expected_outcome.finger_contact(contact).first_s.unwrap(),
            );
            assert_near(actual, expected, 1e-4, "first contact");
        }
        assert_near(outcome.last.finger(0).q11_rad, expected_outcome.last.finger(0).q11_rad, 3e-4, "q11");
        assert_near(outcome.last.finger(0).q21_rad, expected_outcome.last.finger(0).q21_rad, 3e-4, "q21");
    }
}

/// With rapier's rigid contact model the finger closes to nearly the same posture.
#[test]
fn rapier_contact_model_ends_near_the_same_posture() {
    let mut scene = experiment_95();
    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    scene.engine.iterations = 50;
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-5 };
    let (expected_outcome, _) = run_dense_reference(&scene);
    let (outcome, _) = run_engine(&scene);
    assert_near(outcome.last.finger(0).q11_rad, expected_outcome.last.finger(0).q11_rad, 5e-4, "q11");
    assert_near(outcome.last.finger(0).q21_rad, expected_outcome.last.finger(0).q21_rad, 5e-4, "q21");
    for contact in [FingerContact::Proximal, FingerContact::Distal] {
        let (actual, expected) = (
            outcome.finger_contact(contact).first_s.unwrap(),
            expected_outcome.finger_contact(contact).first_s.unwrap(),
        );
        assert_near(actual, expected, 2e-5, "first contact");
        assert!(outcome.finger_contact(contact).impulse_n_s > 0.0);
    }
    assert!(
        outcome.last.finger_contact(FingerContact::Proximal).normal_n > 1.0
            && outcome.last.finger_contact(FingerContact::Distal).normal_n > 1.0
    );
}

/// In a run of five times the duration the contacts creep as in the analytic model, without drift.
#[test]
fn creep_of_the_grasp_matches_the_analytic_model() {
    for max_step_s in [6e-5, 1e-4] {
        let mut scene = Scene { duration_s: 0.1, ..experiment_95() };
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-7, max_step_s };
        let (expected_outcome, reference) = run_dense_reference(&scene);
        let (outcome, run) = run_engine(&scene);
        assert!(max_angle_error(&run, &reference) < 1e-5);
        for (actual, expected) in [
            (
                outcome.last.finger_contact(FingerContact::Proximal),
                expected_outcome.last.finger_contact(FingerContact::Proximal),
            ),
            (
                outcome.last.finger_contact(FingerContact::Distal),
                expected_outcome.last.finger_contact(FingerContact::Distal),
            ),
        ] {
            assert_near(actual.normal_n, expected.normal_n, 2e-6 * expected.normal_n, "normal force");
            assert_near(actual.gap_m, expected.gap_m, 1e-3 * expected.gap_m.abs(), "penetration");
        }
    }
}
