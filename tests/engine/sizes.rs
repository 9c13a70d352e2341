//! Design 95 over a range of sizes, torques, motors and brakes: a run is accurate, or it fails with a reason.

use crate::support::runs::{assert_below, finger_difference};
use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Outcome, RunError};

/// Scene text of design 95 at a scale, as a finger or a gripper, with a spring torque in N·mm and a motor section.
fn scene_text(kind: &str, scale: f64, spring: f64, duration_s: f64, motor: &str) -> String {
    let mm = |length: f64| format!("\"{:e} mm\"", length * scale);
    format!(
        "kind = \"{kind}\"\nduration = \"{duration_s:e} s\"\nhalf_width = {}\n[design]\nbase = {}\nl21_fraction = 1.0\nphi22 = \"120 deg\"\n\
         arm_ratio = 0.5\nl11 = {}\n[object]\nradius = {}\n[spring]\ntorque = \"{spring:e} N*mm\"\n[motor]\n{motor}",
        mm(2.5),
        mm(15.5),
        mm(15.0),
        mm(20.0),
    )
}

/// Scene text with bodies of a depth of 40 mm at the scale, and with torques in N·mm.
fn scaled_text(kind: &str, scale: f64, motor: f64, spring: f64, duration_s: f64, more: &str) -> String {
    let motor = format!("torque = \"{motor:e} N*mm\"\n[material]\ndepth = \"{:e} mm\"\n{more}", 40.0 * scale);
    scene_text(kind, scale, spring, duration_s, &motor)
}

fn try_run(model: Model, text: &str) -> Result<Outcome, RunError> {
    let scene = parse_any(text, "design-95.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    trace::run(model, &scene, &mut ())
}

fn run_both(text: &str) -> [Outcome; 2] {
    [Model::Analytic, Model::Engine].map(|model| try_run(model, text).unwrap_or_else(|error| panic!("{error}\n{text}")))
}

/// Asserts that both runs end at the same angles.
#[track_caller]
fn assert_same_angles([a, b]: [&Outcome; 2], tolerance_rad: f64, text: &str) {
    for (a, b) in a.last.fingers().zip(b.last.fingers()) {
        assert_below(finger_difference(&a, &b), tolerance_rad, text);
    }
}

/// Largest magnitude of all energies, J.
fn largest_energy_j(outcome: &Outcome) -> f64 {
    let e = &outcome.last.energy();
    let energies = [e.kinetic_j, e.gravity_j, e.spring_j, e.elastic_j, e.dissipated_j, e.motor_work_j];
    energies.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Asserts that both models complete with the same angles and balanced energies, with a loop gap below a thousandth of
/// the shortest link. Torques scale with the fifth power of the size, which keeps the duration; a larger torque shortens
/// it with the square root.
#[track_caller]
fn assert_models_agree_at_scale(kind: &str, scale: f64, torque_factor: f64) {
    let torque = |n_mm: f64| n_mm * scale * scale * scale * scale * scale * torque_factor;
    let duration_s = 0.02 / torque_factor.sqrt();
    let text = scaled_text(kind, scale, torque(480.0), torque(132.6), duration_s, "");
    let outcomes = run_both(&text);
    assert_same_angles(outcomes.each_ref(), 1e-4, &text);
    for outcome in &outcomes {
        assert_below(outcome.last.energy().balance_j.abs(), 1e-3 * largest_energy_j(outcome), &text);
    }
    let link_m = parse_any(&text, "scaled.toml").unwrap().hand.fingers[0].linkage.lengths.l22_m;
    assert_below(outcomes[1].loop_gap_m, 1e-3 * link_m, &text);
}

#[test]
fn both_models_agree_at_all_sizes() {
    for scale in [1e-2, 0.1, 1.0, 10.0] {
        for torque_factor in [1.0, 1e2, 1e4] {
            assert_models_agree_at_scale("finger", scale, torque_factor);
        }
    }
    assert_models_agree_at_scale("finger", 1e-3, 1e4);
    assert_models_agree_at_scale("finger", 100.0, 1e-2);
    for (scale, torque_factor) in [(1e-3, 1e4), (1e-2, 1e4), (1e-2, 1e2), (0.1, 1e4), (1.0, 1e4)] {
        assert_models_agree_at_scale("gripper", scale, torque_factor);
    }
}

/// The full-size spring on a gripper of a hundredth of the size, against the limit, which balances 1e14 rad/s².
/// Regression: joints opened by 3 mm in the first step, and 1e10 J were created.
#[test]
fn a_spring_far_too_strong_against_the_limit_is_accurate() {
    let text = scene_text("gripper", 1e-2, 132.6, 1e-4, "torque = \"0 N*mm\"\n");
    let [analytic, engine] = run_both(&text);
    assert_same_angles([&analytic, &engine], 1e-4, &text);
    assert!(engine.loop_gap_m < 1e-8 && engine.ejected_s.is_none(), "{:e} m", engine.loop_gap_m);
}

/// With springs and motors over eight decades, a run is accurate or fails with a reason.
#[test]
fn completed_runs_are_accurate_over_eight_decades_of_torque() {
    for scale in [1e-2, 1.0] {
        for spring in [1e-4, 1.0, 1e4] {
            for motor in [1e-4, 1e4] {
                let few_steps = "[engine]\nmax_steps = 3000\n[integrator]\nmax_steps = 3000\n";
                let text = scaled_text("finger", scale, motor, spring, 1e-4 * scale, few_steps);
                let results = [Model::Analytic, Model::Engine].map(|model| try_run(model, &text));
                for result in &results {
                    match result {
                        Ok(outcome) => {
                            let balance_j = outcome.last.energy().balance_j.abs();
                            assert!(balance_j <= 0.5 * largest_energy_j(outcome), "{balance_j:e} J\n{text}");
                        }
                        Err(error) => assert!(!error.to_string().is_empty()),
                    }
                }
                if let [Ok(analytic), Ok(engine)] = &results {
                    assert_same_angles([analytic, engine], 1e-3, &text);
                }
            }
        }
    }
}

/// A run whose fixed steps open the joints fails. The error gives the time, the fault and the remedy.
#[test]
fn a_run_that_opens_its_joints_fails_with_a_reason() {
    let text = scaled_text("gripper", 1e-2, 0.0, 132.6, 1e-3, "[engine]\nstepping = \"fixed\"\nstep = \"1 us\"\n");
    let Err(RunError::Simulation { failure, partial_outcome }) = try_run(Model::Engine, &text) else {
        panic!("a run with open joints completed")
    };
    let reason = failure.to_string();
    assert!(failure.time_s < 1e-3 && partial_outcome.ejected_s.is_none(), "{reason}");
    assert!(reason.contains("a joint is open by") || reason.contains("of energy were created"), "{reason}");
    assert!(reason.contains("after a step of 1.0e-6 s") && reason.contains("`max_step`"), "{reason}");
}

/// Asserts that both models agree in their angles, and in motor work and losses relative to the largest energy.
#[track_caller]
fn assert_motors_agree(text: &str) {
    let [analytic, engine] = run_both(text);
    assert_same_angles([&analytic, &engine], 2e-5, text);
    let (actual, expected) = (&engine.last.energy(), &analytic.last.energy());
    let energies_j =
        [expected.kinetic_j, expected.gravity_j, expected.spring_j, expected.dissipated_j, expected.motor_work_j];
    let allowed_j = 1e-3 * energies_j.into_iter().map(f64::abs).fold(0.0, f64::max);
    assert_below((actual.motor_work_j - expected.motor_work_j).abs(), allowed_j, text);
    assert_below((actual.dissipated_j - expected.dissipated_j).abs(), allowed_j, text);
    assert_below(actual.balance_j.abs(), allowed_j, text);
}

/// Motors with a no-load speed, and brakes: impulse and work are accurate at any step size. At 1e8 N·mm and 0.1 rad/s
/// the motor reaches its speed within 1e-11 s.
#[test]
fn motor_work_is_accurate_if_steps_exceed_the_relaxation_time() {
    let assert_agree = |duration_s: f64, motor: &str| {
        assert_motors_agree(&scene_text("gripper", 1.0, 132.6, duration_s, motor));
    };
    for torque in [1.0, 1e2, 1e4, 1e6, 1e8] {
        for speed in [0.1, 1.0, 10.0] {
            assert_agree(10e-3, &format!("torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n"));
        }
    }
    for torque in [1e2, 1e5] {
        for speed in [1.0, 100.0] {
            for profile in
                ["profile = \"reversal\"\nreverse_at = \"0.5 ms\"\n", "profile = \"ramp\"\nrise = \"2 ms\"\n"]
            {
                let motor = format!("{profile}torque = \"{torque:e} N*mm\"\nno_load_speed = \"{speed} rad/s\"\n");
                assert_agree(5e-3, &motor);
            }
        }
    }
    // A brake engages within a step.
    for torque in [1e-3, 1.0, 1e3] {
        for law in ["regularised", "bristle"] {
            let motor = format!(
                "torque = \"480 N*mm\"\nno_load_speed = \"10 rad/s\"\nbrake = \"two-way\"\nbrake_torque = \"{torque:e} N*m\"\nbrake_at = \"3 ms\"\n\
                 brake_law = \"{law}\"\n"
            );
            assert_agree(10e-3, &motor);
        }
    }
    // One motor drives both fingers.
    for torque in [1e2, 1e5, 1e8] {
        let motor = format!("torque = \"{torque:e} N*mm\"\nno_load_speed = \"5 rad/s\"\ninertia = \"1e-7 kg*m^2\"\n");
        assert_agree(8e-3, &format!("{motor}[differential]\n"));
    }
}

/// Regression: random scenes whose work was wrong by 10 % to a factor of 64.
#[test]
fn motor_work_of_random_scenes_agrees_with_the_analytic_model() {
    assert_motors_agree(include_str!("motors/reversal.toml"));
    assert_motors_agree(include_str!("motors/constant.toml"));
    assert_motors_agree(include_str!("motors/brake.toml"));
}
