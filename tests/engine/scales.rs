//! Design 95 over sizes and drives: a run is right, or it fails with its reason.

use crate::support::runs::Collect;
use phalanx::scene::parse_any;
use phalanx::trace::{self, Model, Outcome, RunError};

/// Design 95 at a scale, as a finger or a gripper, with torques in N·mm.
fn text(kind: &str, scale: f64, motor: f64, spring: f64, duration_s: f64, more: &str) -> String {
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

fn run(model: Model, text: &str) -> Result<Outcome, RunError> {
    let scene = parse_any(text, "scaled.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    trace::run(model, &scene, &mut Collect::default())
}

fn angles(outcome: &Outcome) -> Vec<f64> {
    outcome.last.fingers.iter().flat_map(|finger| [finger.q11_rad, finger.q21_rad, finger.q22_rad]).collect()
}

/// Energies of the largest size, J.
fn throughput_j(outcome: &Outcome) -> f64 {
    let e = &outcome.last.energy;
    [e.kinetic_j, e.gravity_j, e.spring_j, e.elastic_j, e.dissipated_j, e.motor_work_j]
        .iter()
        .fold(0.0, |a, b| a.max(b.abs()))
}

/// Both models get to the end, at the same angles, and energies balance.
#[track_caller]
fn agrees(text: &str) {
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| run(model, text).unwrap_or_else(|e| panic!("{e}\n{text}")));
    for (found, wanted) in angles(&engine).into_iter().zip(angles(&analytic)) {
        assert!((found - wanted).abs() < 1e-4, "{found} instead of {wanted}\n{text}");
    }
    for outcome in [&analytic, &engine] {
        let (balance_j, most_j) = (outcome.last.energy.balance_j, throughput_j(outcome));
        assert!(balance_j.abs() < 1e-3 * most_j, "{balance_j:e} of {most_j:e} J\n{text}");
    }
    // A thousandth of the shortest link.
    let scene = parse_any(text, "scaled.toml").unwrap();
    let link_m = scene.system.fingers[0].linkage.lengths.l22_m;
    assert!(engine.loop_gap_m < 1e-3 * link_m, "{:e} m of {link_m:e} m\n{text}", engine.loop_gap_m);
}

/// Torques go with the fifth power of the size, so that times stay: what is stronger is faster by the root.
#[test]
fn a_finger_of_any_size_closes_as_the_analytic_model_says() {
    for scale in [1e-2, 0.1, 1.0, 10.0] {
        for stronger in [1.0, 1e2, 1e4] {
            let torque = |n_mm: f64| n_mm * scale * scale * scale * scale * scale * stronger;
            agrees(&text("finger", scale, torque(480.0), torque(132.6), 0.02 / f64::sqrt(stronger), ""));
        }
    }
    agrees(&text("finger", 1e-3, 480e-11, 132.6e-11, 2e-4, ""));
    agrees(&text("finger", 100.0, 480e8, 132.6e8, 0.2, ""));
}

#[test]
fn a_gripper_of_any_size_closes_as_the_analytic_model_says() {
    for (scale, stronger) in [(1e-3, 1e4), (1e-2, 1e4), (1e-2, 1e2), (0.1, 1e4), (1.0, 1e4)] {
        let torque = |n_mm: f64| n_mm * scale * scale * scale * scale * scale * stronger;
        agrees(&text("gripper", scale, torque(480.0), torque(132.6), 0.02 / f64::sqrt(stronger), ""));
    }
}

/// The spring of the full size in a hundredth of it, against the stop: of 1e14 rad/s² the stop leaves nothing. (Joints opened by 3 mm in
/// the first step, and 1e10 J came from nowhere.)
#[test]
fn a_spring_far_too_strong_presses_against_the_stop() {
    let text = text("gripper", 1e-2, 0.0, 132.6, 1e-4, "").replace("[material]\ndepth = \"4e-1 mm\"\n", "");
    assert!(!text.contains("material"));
    let [analytic, engine] =
        [Model::Analytic, Model::Engine].map(|model| run(model, &text).unwrap_or_else(|e| panic!("{e}")));
    for (found, wanted) in angles(&engine).into_iter().zip(angles(&analytic)) {
        assert!((found - wanted).abs() < 1e-4, "{found} instead of {wanted}");
    }
    assert!(engine.loop_gap_m < 1e-8 && engine.ejected_s.is_none(), "{:e} m", engine.loop_gap_m);
}

/// Springs and motors over eight decades: right, or refused with a reason.
#[test]
fn no_run_is_absurd_without_saying_so() {
    for scale in [1e-2, 1.0] {
        for spring in [1e-4, 1.0, 1e4] {
            for motor in [1e-4, 1e4] {
                let more = "[engine]\nmax_steps = 3000\n[integrator]\nmax_steps = 3000\n";
                let text = text("finger", scale, motor, spring, 1e-4 * scale, more);
                let results = [Model::Analytic, Model::Engine].map(|model| run(model, &text));
                for result in &results {
                    match result {
                        Ok(outcome) => {
                            let (balance_j, most_j) = (outcome.last.energy.balance_j, throughput_j(outcome));
                            assert!(balance_j.abs() <= 0.5 * most_j, "{balance_j:e} of {most_j:e} J\n{text}");
                        }
                        Err(error) => assert!(!error.to_string().is_empty()),
                    }
                }
                if let [Ok(analytic), Ok(engine)] = &results {
                    for (found, wanted) in angles(engine).into_iter().zip(angles(analytic)) {
                        assert!((found - wanted).abs() < 1e-3, "{found} instead of {wanted}\n{text}");
                    }
                }
            }
        }
    }
}

/// Steps of a given length that tear the joints end the run, and say at what time, what opened, and what to do.
#[test]
fn a_run_that_tears_its_joints_fails_with_its_reason() {
    let text = text("gripper", 1e-2, 0.0, 132.6, 1e-3, "[engine]\nstepping = \"fixed\"\nstep = \"1 us\"\n");
    let Err(RunError::Simulation { failure, so_far }) = run(Model::Engine, &text) else {
        panic!("a torn run got to its end")
    };
    let reason = failure.to_string();
    assert!(failure.time_s < 1e-3 && so_far.ejected_s.is_none(), "{reason}");
    assert!(reason.contains("a joint is open by") || reason.contains("came from nowhere"), "{reason}");
    assert!(reason.contains("after a step of 1.0e-6 s") && reason.contains("`max_step`"), "{reason}");
}
