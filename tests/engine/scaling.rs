//! Design 95 over a range of sizes and torques: a run is accurate, or it fails with a reason.

use crate::support::runs::CollectSink;
use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Outcome, RunError};

/// Scene text of design 95 at a scale, as a finger or a gripper, with torques in N·mm.
fn scene_text(kind: &str, scale: f64, motor: f64, spring: f64, duration_s: f64, more: &str) -> String {
    let mm = |length: f64| format!("\"{:e} mm\"", length * scale);
    format!(
        "kind = \"{kind}\"\nduration = \"{duration_s:e} s\"\nhalf_width = {}\n[design]\nbase = {}\nl21_fraction = 1.0\nphi22 = \"120 deg\"\n\
         arm_ratio = 0.5\nl11 = {}\n[object]\nradius = {}\n[material]\ndepth = {}\n[motor]\ntorque = \"{motor:e} N*mm\"\n[spring]\n\
         torque = \"{spring:e} N*mm\"\n{more}",
        mm(2.5),
        mm(15.5),
        mm(15.0),
        mm(20.0),
        mm(40.0)
    )
}

fn run(model: Model, scene_text: &str) -> Result<Outcome, RunError> {
    let scene = parse_any(scene_text, "scaled.toml").unwrap_or_else(|error| panic!("{error}\n{scene_text}"));
    trace::run(model, &scene, &mut CollectSink::default())
}

fn angles(outcome: &Outcome) -> Vec<f64> {
    outcome.last.fingers().flat_map(|finger| [finger.q11_rad, finger.q21_rad, finger.q22_rad]).collect()
}

/// Largest magnitude of all energies, J.
fn largest_energy_j(outcome: &Outcome) -> f64 {
    let e = &outcome.last.energy();
    [e.kinetic_j, e.gravity_j, e.spring_j, e.elastic_j, e.dissipated_j, e.motor_work_j]
        .iter()
        .fold(0.0, |a, b| a.max(b.abs()))
}

/// Asserts that both models complete with the same angles and balanced energies.
#[track_caller]
fn assert_models_agree(text: &str) {
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| run(model, text).unwrap_or_else(|e| panic!("{e}\n{text}")));
    for (actual, expected) in angles(&engine).into_iter().zip(angles(&analytic)) {
        assert!((actual - expected).abs() < 1e-4, "found {actual}, expected {expected}\n{text}");
    }
    for outcome in [&analytic, &engine] {
        let (balance_j, scale_j) = (outcome.last.energy().balance_j, largest_energy_j(outcome));
        assert!(balance_j.abs() < 1e-3 * scale_j, "{balance_j:e} of {scale_j:e} J\n{text}");
    }
    // The loop gap is below a thousandth of the shortest link.
    let scene = parse_any(text, "scaled.toml").unwrap();
    let link_m = scene.system.fingers[0].linkage.lengths.l22_m;
    assert!(engine.loop_gap_m < 1e-3 * link_m, "{:e} m of {link_m:e} m\n{text}", engine.loop_gap_m);
}

/// Torques scale with the fifth power of the size, which keeps the duration; a larger torque shortens it with the
/// square root.
#[test]
fn both_models_agree_for_fingers_of_all_sizes() {
    for scale in [1e-2, 0.1, 1.0, 10.0] {
        for torque_factor in [1.0, 1e2, 1e4] {
            let torque = |n_mm: f64| n_mm * scale * scale * scale * scale * scale * torque_factor;
            assert_models_agree(&scene_text(
                "finger",
                scale,
                torque(480.0),
                torque(132.6),
                0.02 / f64::sqrt(torque_factor),
                "",
            ));
        }
    }
    assert_models_agree(&scene_text("finger", 1e-3, 480e-11, 132.6e-11, 2e-4, ""));
    assert_models_agree(&scene_text("finger", 100.0, 480e8, 132.6e8, 0.2, ""));
}

#[test]
fn both_models_agree_for_grippers_of_all_sizes() {
    for (scale, torque_factor) in [(1e-3, 1e4), (1e-2, 1e4), (1e-2, 1e2), (0.1, 1e4), (1.0, 1e4)] {
        let torque = |n_mm: f64| n_mm * scale * scale * scale * scale * scale * torque_factor;
        assert_models_agree(&scene_text(
            "gripper",
            scale,
            torque(480.0),
            torque(132.6),
            0.02 / f64::sqrt(torque_factor),
            "",
        ));
    }
}

/// The full-size spring on a gripper of a hundredth of the size, against the limit, which balances 1e14 rad/s².
/// Regression: joints opened by 3 mm in the first step, and 1e10 J were created.
#[test]
fn a_spring_far_too_strong_against_the_limit_is_accurate() {
    let text = scene_text("gripper", 1e-2, 0.0, 132.6, 1e-4, "").replace("[material]\ndepth = \"4e-1 mm\"\n", "");
    assert!(!text.contains("material"));
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| run(model, &text).unwrap_or_else(|e| panic!("{e}")));
    for (actual, expected) in angles(&engine).into_iter().zip(angles(&analytic)) {
        assert!((actual - expected).abs() < 1e-4, "found {actual}, expected {expected}");
    }
    assert!(engine.loop_gap_m < 1e-8 && engine.ejected_s.is_none(), "{:e} m", engine.loop_gap_m);
}

/// With springs and motors over eight decades, a run is accurate or fails with a reason.
#[test]
fn completed_runs_are_accurate_over_eight_decades_of_torque() {
    for scale in [1e-2, 1.0] {
        for spring in [1e-4, 1.0, 1e4] {
            for motor in [1e-4, 1e4] {
                let higher_limits = "[engine]\nmax_steps = 3000\n[integrator]\nmax_steps = 3000\n";
                let text = scene_text("finger", scale, motor, spring, 1e-4 * scale, higher_limits);
                let results = [Model::Analytic, Model::Engine].map(|model| run(model, &text));
                for result in &results {
                    match result {
                        Ok(outcome) => {
                            let (balance_j, scale_j) = (outcome.last.energy().balance_j, largest_energy_j(outcome));
                            assert!(balance_j.abs() <= 0.5 * scale_j, "{balance_j:e} of {scale_j:e} J\n{text}");
                        }
                        Err(error) => assert!(!error.to_string().is_empty()),
                    }
                }
                if let [Ok(analytic), Ok(engine)] = &results {
                    for (actual, expected) in angles(engine).into_iter().zip(angles(analytic)) {
                        assert!((actual - expected).abs() < 1e-3, "found {actual}, expected {expected}\n{text}");
                    }
                }
            }
        }
    }
}

/// A run whose fixed steps open the joints fails. The error gives the time, the fault and the remedy.
#[test]
fn a_run_that_opens_its_joints_fails_with_a_reason() {
    let text = scene_text("gripper", 1e-2, 0.0, 132.6, 1e-3, "[engine]\nstepping = \"fixed\"\nstep = \"1 us\"\n");
    let Err(RunError::Simulation { failure, partial_outcome }) = run(Model::Engine, &text) else {
        panic!("a run with open joints completed")
    };
    let reason = failure.to_string();
    assert!(failure.time_s < 1e-3 && partial_outcome.ejected_s.is_none(), "{reason}");
    assert!(reason.contains("a joint is open by") || reason.contains("of energy were created"), "{reason}");
    assert!(reason.contains("after a step of 1.0e-6 s") && reason.contains("`max_step`"), "{reason}");
}
