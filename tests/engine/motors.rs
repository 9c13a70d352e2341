//! Motors with a no-load speed, and brakes: impulse and work are accurate at any step size.

use crate::support::runs::CollectSink;
use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Outcome};

fn run(model: Model, text: &str) -> Outcome {
    let scene = parse_any(text, "motor.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    trace::run(model, &scene, &mut CollectSink::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Asserts that both models agree in their angles, and in motor work and losses relative to the largest energy.
#[track_caller]
fn assert_models_agree(text: &str, relative_tolerance: f64) {
    let [analytic, engine] = [Model::Analytic, Model::Engine].map(|model| run(model, text));
    for (actual, expected) in engine.last.fingers().zip(analytic.last.fingers()) {
        let differences =
            [actual.q11_rad - expected.q11_rad, actual.q21_rad - expected.q21_rad, actual.q22_rad - expected.q22_rad];
        assert!(differences.iter().all(|differences| differences.abs() < 2e-5), "{differences:?}\n{text}");
    }
    let (actual, expected) = (&engine.last.energy(), &analytic.last.energy());
    let energies_j =
        [expected.kinetic_j, expected.gravity_j, expected.spring_j, expected.dissipated_j, expected.motor_work_j];
    let allowed_j = relative_tolerance * energies_j.iter().fold(0.0, |most: f64, j| most.max(j.abs()));
    for (actual, expected) in [
        (actual.motor_work_j, expected.motor_work_j),
        (actual.dissipated_j, expected.dissipated_j),
        (actual.balance_j, 0.0),
    ] {
        assert!(
            (actual - expected).abs() < allowed_j,
            "found {actual:e} J, expected {expected:e} ± {allowed_j:e} J\n{text}"
        );
    }
}

/// Text of a gripper scene of design 95 with the given motor section.
fn gripper_scene_text(duration_ms: f64, motor: &str) -> String {
    format!(
        "kind = \"gripper\"\nduration = \"{duration_ms} ms\"\n[design]\nbase = \"15.5 mm\"\nl21_fraction = 1.0\nphi22 = \"120 deg\"\narm_ratio = 0.5\n\
         [spring]\ntorque = \"132.6 N*mm\"\n[motor]\n{motor}"
    )
}

/// At 1e8 N·mm and 0.1 rad/s the motor reaches its speed within 1e-11 s.
#[test]
fn motor_work_is_accurate_if_steps_exceed_the_relaxation_time() {
    for torque in [1.0, 1e2, 1e4, 1e6, 1e8] {
        for speed in [0.1, 1.0, 10.0] {
            let motor = format!("torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n");
            assert_models_agree(&gripper_scene_text(10.0, &motor), 1e-3);
        }
    }
}

#[test]
fn motor_work_is_accurate_for_time_dependent_torque() {
    for torque in [1e2, 1e5] {
        for speed in [1.0, 100.0] {
            for profile in
                ["profile = \"reversal\"\nreverse_at = \"0.5 ms\"\n", "profile = \"ramp\"\nrise = \"2 ms\"\n"]
            {
                let motor = format!("{profile}torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n");
                assert_models_agree(&gripper_scene_text(5.0, &motor), 1e-3);
            }
        }
    }
}

#[test]
fn a_brake_engages_within_a_step() {
    for torque in [1e-3, 1.0, 1e3] {
        for law in ["regularised", "bristle"] {
            let motor = format!(
                "torque = \"480 N*mm\"\nno_load_speed = \"10 rad/s\"\nbrake = \"two-way\"\nbrake_torque = \"{torque:e} N*m\"\nbrake_at = \"3 ms\"\n\
                 brake_law = \"{law}\"\n"
            );
            assert_models_agree(&gripper_scene_text(10.0, &motor), 1e-3);
        }
    }
}

#[test]
fn one_motor_drives_both_fingers() {
    for torque in [1e2, 1e5, 1e8] {
        let motor = format!(
            "torque = \"{torque:e} N*mm\"\nno_load_speed = \"5 rad/s\"\ninertia = \"1e-7 kg*m^2\"\n[differential]\n"
        );
        assert_models_agree(&gripper_scene_text(8.0, &motor), 1e-3);
    }
}

/// Regression: random scenes whose work was wrong by 10 % to a factor of 64.
#[test]
fn motor_work_of_random_scenes_agrees_with_the_analytic_model() {
    assert_models_agree(include_str!("motors/reversal.toml"), 1e-3);
    assert_models_agree(include_str!("motors/constant.toml"), 1e-3);
    assert_models_agree(include_str!("motors/brake.toml"), 1e-3);
}
