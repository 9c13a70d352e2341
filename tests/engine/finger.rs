//! The engine model of one finger against the analytic model: design 95 with default settings, coarse fixed steps and
//! rapier's contact model; stiction; stability; order of convergence; and repeatability.

use crate::support::checked_run;
use crate::support::cli::directory;
use crate::support::runs::{
    CollectSink, PHALANGES, assert_below, assert_near, assert_relative, experiment_95, experiment_95_with,
    impact_impulse, load, load_with_stiction, max_angle_error, run_dense_reference, run_engine,
};
use phalanx::log::{self, RunInfo};
use phalanx::scene::{Profile, Response, Scene, Stepping};
use phalanx::trace::{Model, Sample};

/// Experiment 95 with perturbations of its torque in the ninth digit, which show the scatter of the errors.
fn perturbed_scenes() -> [Scene; 5] {
    [0.0, 1.0, 2.0, 3.0, 4.0].map(|i| {
        let torque_n_m = 0.480 * (1.0 + 1e-9 * i);
        experiment_95_with(|scene| scene.finger_mut().motor.actuation = Profile::Constant { value: torque_n_m })
    })
}

/// The documented accuracy of the default settings, for all perturbed scenes.
#[test]
fn default_settings_agree_with_the_analytic_model_over_the_whole_closing() {
    for scene in perturbed_scenes() {
        let (expected_outcome, reference) = run_dense_reference(&scene);
        let (outcome, run) = run_engine(&scene);
        assert_near(max_angle_error(&run, &reference), 0.0, 2e-5, "largest angle difference");
        for contact in PHALANGES {
            let (actual, expected) = (outcome.finger_contact(contact), expected_outcome.finger_contact(contact));
            assert_eq!(actual.touchdowns, expected.touchdowns);
            assert_near(actual.first_s.unwrap(), expected.first_s.unwrap(), 0.5e-6, "first contact");
            let [impulse, expected] = [&run, &reference].map(|run| impact_impulse(run, contact, 20e-6));
            assert_relative(impulse, expected, 5e-3, "impulse of the impact");
            let [force, expected] =
                [&outcome, &expected_outcome].map(|outcome| outcome.last.finger_contact(contact).normal_n);
            assert_relative(force, expected, 1e-4, "final normal force");
        }
        assert!(outcome.loop_gap_m <= 1e-7, "loop gap {:e}", outcome.loop_gap_m);
    }
}

/// The engine matches the reference values of experiment 95 (1-model §1.8).
#[test]
fn default_settings_match_the_reference_values() {
    let (outcome, _) = run_engine(&experiment_95());
    for (contact, first_s) in PHALANGES.into_iter().zip([4.501315e-3, 6.883746e-3]) {
        assert_near(outcome.finger_contact(contact).first_s.unwrap(), first_s, 2e-8, "first contact");
    }
    assert_near(outcome.last.finger(0).q11_rad.to_degrees(), 2.088778, 2e-5, "q11");
    assert_near(outcome.last.finger(0).q21_rad.to_degrees(), 65.019991, 2e-5, "q21");
}

/// Asserts that a run ends near the posture of the analytic model, with first contacts at nearly the same times.
#[track_caller]
fn assert_ends_near_reference(scene: &Scene, angle_rad: f64, contact_s: f64) -> phalanx::trace::Outcome {
    let (expected, _) = run_dense_reference(scene);
    let (outcome, _) = run_engine(scene);
    for contact in PHALANGES {
        let [first_s, expected_s] = [&outcome, &expected].map(|run| run.finger_contact(contact).first_s.unwrap());
        assert_near(first_s, expected_s, contact_s, "first contact");
    }
    assert_near(outcome.last.finger(0).q11_rad, expected.last.finger(0).q11_rad, angle_rad, "q11");
    assert_near(outcome.last.finger(0).q21_rad, expected.last.finger(0).q21_rad, angle_rad, "q21");
    outcome
}

/// With steps of 1e-4 s the engine is as accurate as tuned rigid-contact engines: contact times within one step, the
/// final posture within 3e-4 rad.
#[test]
fn a_step_of_0_1_ms_is_as_accurate_as_rigid_contact() {
    for mut scene in perturbed_scenes() {
        scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
        assert_eq!(assert_ends_near_reference(&scene, 3e-4, 1e-4).work.steps, 200);
    }
}

/// With rapier's rigid contact model the finger closes to nearly the same posture.
#[test]
fn rapier_contact_model_ends_near_the_same_posture() {
    let mut scene = with_fixed_step(experiment_95(), 1e-5);
    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    scene.engine.iterations = 50;
    let outcome = assert_ends_near_reference(&scene, 5e-4, 2e-5);
    for contact in PHALANGES {
        assert!(
            outcome.finger_contact(contact).impulse_n_s > 0.0 && outcome.last.finger_contact(contact).normal_n > 1.0
        );
    }
}

/// In a run of five times the duration the contacts creep as in the analytic model, without drift.
#[test]
fn creep_of_the_grasp_matches_the_analytic_model() {
    for max_step_s in [6e-5, 1e-4] {
        let mut scene = Scene { duration_s: 0.1, ..experiment_95() };
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-7, max_step_s };
        let [(expected_outcome, reference), (outcome, run)] = [run_dense_reference(&scene), run_engine(&scene)];
        assert_below(max_angle_error(&run, &reference), 1e-5, "angles");
        for contact in PHALANGES {
            let [actual, expected] = [&outcome, &expected_outcome].map(|outcome| outcome.last.finger_contact(contact));
            assert_relative(actual.normal_n, expected.normal_n, 2e-6, "normal force");
            assert_relative(actual.gap_m, expected.gap_m, 1e-3, "penetration");
        }
    }
}

/// With stiction and default settings the models agree as closely as without bristles, and more closely at a finer
/// tolerance.
#[test]
fn stiction_agrees_in_both_models_and_the_difference_falls_with_the_tolerance() {
    for name in ["experiment-95", "long-fingers", "soft-start", "hard/friction-2", "hard/limit-hammered"] {
        let mut scene = load_with_stiction(name);
        let [(expected_outcome, reference), (outcome, run)] = [run_dense_reference(&scene), run_engine(&scene)];
        let difference = max_angle_error(&run, &reference);
        assert_below(difference, 2e-5, name);
        for contact in PHALANGES {
            let [actual, expected] = [&outcome, &expected_outcome].map(|outcome| outcome.last.finger_contact(contact));
            let allowed_n = 1e-3 * expected.normal_n.abs().max(1.0);
            assert_near(actual.normal_n, expected.normal_n, allowed_n, format!("{name} {contact:?}"));
            assert_near(actual.tangential_n, expected.tangential_n, allowed_n, format!("{name} {contact:?}"));
        }
        let energies = [&outcome, &expected_outcome].map(|outcome| outcome.last.energy());
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{name}: {energies:?}");
        assert!((energies[0].elastic_j - energies[1].elastic_j).abs() < 5e-7, "{name}: {energies:?}");
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
        assert_below(max_angle_error(&run_engine(&scene).1, &reference), f64::min(2e-6, 0.4 * difference), name);
    }
}

/// The engine with the thesis parameters at several fixed steps: no artificial rebound, no created energy, and the
/// invariants of every run. The geometry is constant over a step, so the tolerances are of second order in the step. The
/// run with the smallest steps, 100,000 in 10 ms, includes both impacts.
#[test]
fn runs_are_stable_at_all_steps() {
    for (step_s, energy_tolerance_j, rebound_tolerance_m) in [
        (Some(1e-4), 1e-3, 2e-5),
        (Some(1e-5), 1e-5, 2e-7),
        (Some(1e-6), 1e-7, 0.0),
        (Some(1e-7), 1e-8, 0.0),
        (None, 1e-7, 0.0),
    ] {
        let mut scene = step_s.map_or(experiment_95(), |step_s| with_fixed_step(experiment_95(), step_s));
        if step_s == Some(1e-7) {
            scene.duration_s = 10e-3;
        }
        let (outcome, run) = run_engine(&scene);
        // Largest rise of mechanical energy minus motor work above its earlier minimum.
        let mut lowest_j = f64::INFINITY;
        for e in run.samples.iter().map(Sample::energy) {
            let excess_j = e.kinetic_j + e.gravity_j + e.spring_j + e.elastic_j - e.motor_work_j;
            lowest_j = lowest_j.min(excess_j);
            assert_near(excess_j, lowest_j, energy_tolerance_j, format!("energy at steps of {step_s:?} s"));
        }
        for contact in PHALANGES {
            let contact_s = run.first_contact_s(contact as usize).expect("a touch-down");
            for sample in &run.samples {
                let values = sample.finger_contact(contact);
                // The contact law allows no rebound.
                let is_closed = sample.time_s <= contact_s || values.gap_m <= rebound_tolerance_m;
                let is_within_cone = values.tangential_n.abs() <= 0.8 * values.normal_n * (1.0 + 1e-12);
                assert!(is_closed && is_within_cone, "{contact:?} at steps of {step_s:?} s: {values:?}");
            }
        }
        let finger = outcome.last.finger(0);
        assert!(finger.qd11_rad_s.abs() < 1e-2 && finger.qd21_rad_s.abs() < 1e-2, "still moving: {finger:?}");
    }
}

/// The scene with fixed steps of the engine.
fn with_fixed_step(mut scene: Scene, step_s: f64) -> Scene {
    scene.engine.stepping = Stepping::Fixed { step_s };
    scene
}

/// Experiment 95 without object and limit, for the first 3 ms of motion: only motor, spring, gravity and joints act.
fn free_motion() -> Scene {
    experiment_95_with(|scene| {
        scene.duration_s = 3e-3;
        scene.hand.object = None;
        scene.finger_mut().limit = None;
    })
}

/// Errors of the engine at four step sizes, each half of the one before, and the observed orders of convergence.
fn errors_and_orders(scene: Scene, coarsest_s: f64) -> ([f64; 4], [f64; 3]) {
    let (_, reference) = run_dense_reference(&scene);
    let errors = [1.0, 0.5, 0.25, 0.125].map(|factor| {
        let scene = with_fixed_step(scene.clone(), factor * coarsest_s);
        let (outcome, run) = run_engine(&scene);
        assert_eq!(outcome.work.steps, (scene.duration_s / (factor * coarsest_s)).round() as u64);
        max_angle_error(&run, &reference)
    });
    (errors, [0, 1, 2].map(|i| (errors[i] / errors[i + 1]).log2()))
}

/// An active joint limit is a stiff, plastic contact; it must not reduce the order.
#[test]
fn free_motion_is_third_order() {
    let (errors, orders) = errors_and_orders(free_motion(), 2e-4);
    assert!(orders.iter().all(|order| *order >= 2.95), "{orders:?}");
    assert!(errors[3] < 1e-7, "{errors:?}");
    let against_limit = experiment_95_with(|scene| {
        scene.duration_s = 4e-3;
        scene.hand.object = None;
    });
    // The error of the finest steps is close to that of the reference.
    let (errors, orders) = errors_and_orders(against_limit, 1e-4);
    assert!(orders.iter().all(|order| *order >= 2.7), "{orders:?}");
    assert!(errors[3] < 1e-9, "{errors:?}");
}

fn hard_scene(name: &str) -> Scene {
    let mut scene = load(name);
    (scene.duration_s, scene.bounds.until_s) = (9e-3, 9e-3);
    scene
}

/// Rebounds that only friction damps. Second order requires that slip turns with the contact and that the law acts in
/// the middle of the step. Single observed orders vary, because contacts close anywhere within a step; the mean does
/// not.
#[test]
fn undamped_contact_with_friction_is_second_order() {
    let (errors, orders) = errors_and_orders(hard_scene("hard/damper-none"), 1e-5);
    assert!(orders.iter().sum::<f64>() / 3.0 >= 1.8, "{orders:?}");
    assert!(errors[3] < 2e-6, "{errors:?}");
}

/// A distal phalanx slides over the object up to its own end under a stiff damper. The corrections of the normal
/// impulses must include their friction; without it the method is of first order and errors are forty times as large.
#[test]
fn sliding_on_a_stiff_contact_is_accurate() {
    let (errors, _) = errors_and_orders(hard_scene("hard/end-cap"), 1e-5);
    assert!(errors[0] < 4e-4 && errors[3] < 4e-5, "{errors:?}");
}

/// Adaptive steps keep the order until the error is close to that of the reference; the tolerance is proportional to dt².
#[test]
fn adaptive_steps_converge_with_their_tolerance() {
    let mut scene = free_motion();
    let (_, reference) = run_dense_reference(&scene);
    let [coarse, fine] = [1e-8, 1e-10].map(|tolerance_m| {
        scene.engine.stepping = Stepping::Adaptive { tolerance_m, max_step_s: 1e-4 };
        let (outcome, run) = run_engine(&scene);
        (outcome.work.steps, max_angle_error(&run, &reference))
    });
    assert!(fine.0 > 8 * coarse.0, "{coarse:?} {fine:?}");
    let order = (coarse.1 / fine.1).ln() / (fine.0 as f64 / coarse.0 as f64).ln();
    assert!(order > 1.6, "slope {order}: {coarse:?} {fine:?}");
}

#[test]
fn two_runs_write_identical_logs() {
    let (scene, directory) = (experiment_95(), directory("engine_repeats"));
    let [first, second] = ["first.mcap", "second.mcap"].map(|name| {
        let info = RunInfo { scene: &scene, scene_file: "experiment-95.toml", model: "engine" };
        let mut writer = log::create(&directory.join(name), &info).expect("a log");
        checked_run::run(Model::Engine, &scene, &mut writer).expect("a run");
        writer.commit().expect("a finished log");
        std::fs::read(directory.join(name)).expect("the log")
    });
    assert!(first.len() > 10_000);
    assert!(first == second, "the logs differ");
}

#[test]
fn the_log_rate_does_not_change_the_run() {
    let (default_outcome, _) = run_engine(&experiment_95());
    let (fine_outcome, CollectSink { samples, .. }) =
        run_engine(&experiment_95_with(|scene| scene.log.numeric_hz = 333e3));
    assert_eq!(default_outcome, fine_outcome);
    assert!(samples.len() > 6000);
    assert!(samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s), "samples out of order");
}
