//! Order of convergence of the engine model, from runs with fixed numbers of steps.

use crate::support::runs::{experiment_95, max_angle_error, run_dense_reference, run_engine};
use phalanx::scene::{self, Construction, Scene, Stepping};

/// Experiment 95 without object and limit, for the first 3 ms of motion: only motor, spring, gravity and joints act.
fn free_motion() -> Scene {
    let mut scene = Scene { duration_s: 3e-3, ..experiment_95() };
    scene.system.discs.clear();
    scene.finger_mut().limit = None;
    scene
}

/// Numbers of steps and errors at four step sizes, each half of the one before.
fn errors(scene: &Scene, construction: Construction, coarsest_s: f64) -> Vec<(u64, f64)> {
    let (_, reference) = run_dense_reference(scene);
    (0..4)
        .map(|halvings| {
            let mut scene = scene.clone();
            scene.engine.construction = construction;
            scene.engine.stepping = Stepping::Fixed { step_s: coarsest_s / f64::from(1 << halvings) };
            let (outcome, run) = run_engine(&scene);
            (outcome.work.steps, max_angle_error(&run, &reference))
        })
        .collect()
}

fn observed_orders(errors: &[(u64, f64)]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0].1 / pair[1].1).log2()).collect()
}

#[test]
fn free_motion_in_maximal_coordinates_is_second_order() {
    let errors = errors(&free_motion(), Construction::Maximal, 4e-5);
    assert_eq!(errors.iter().map(|e| e.0).collect::<Vec<_>>(), [75, 150, 300, 600]);
    for order in observed_orders(&errors) {
        assert!(order >= 1.9, "slopes {:?} of {errors:?}", observed_orders(&errors));
    }
    assert!(errors[3].1 < 5e-7, "error {:e} at 5e-6 s", errors[3].1);
}

/// An active joint limit is a stiff, plastic contact; it must not reduce the order.
#[test]
fn motion_against_the_joint_limit_is_second_order() {
    let mut scene = Scene { duration_s: 4e-3, ..experiment_95() };
    scene.system.discs.clear();
    let errors = errors(&scene, Construction::Maximal, 4e-5);
    for order in observed_orders(&errors) {
        assert!(order >= 1.8, "slopes {:?} of {errors:?}", observed_orders(&errors));
    }
}

/// Rebounds that only friction damps. Second order requires that slip turns with the contact and that the law acts in
/// the middle of the step. Single observed orders vary, because contacts close anywhere within a step; the mean does
/// not.
#[test]
fn undamped_contact_with_friction_is_second_order() {
    let mut scene = scene::load("scenes/hard/damper-none.toml").unwrap_or_else(|error| panic!("{error}"));
    (scene.duration_s, scene.bounds.until_s) = (9e-3, 9e-3);
    let errors = errors(&scene, Construction::Maximal, 1e-5);
    let order = (errors[0].1 / errors[3].1).log2() / 3.0;
    assert!(order >= 1.8, "slopes {:?} of {errors:?}", observed_orders(&errors));
    assert!(errors[3].1 < 2e-6, "error {:e} at 1.25e-6 s", errors[3].1);
}

/// A distal phalanx slides over the object up to its own end under a stiff damper. The corrections of the normal
/// impulses must include their friction; without it the method is of first order and errors are forty times as large.
#[test]
fn sliding_on_a_stiff_contact_is_accurate() {
    let mut scene = scene::load("scenes/hard/end-cap.toml").unwrap_or_else(|error| panic!("{error}"));
    (scene.duration_s, scene.bounds.until_s) = (9e-3, 9e-3);
    let errors = errors(&scene, Construction::Maximal, 1e-5);
    assert!(errors[0].1 < 4e-4 && errors[3].1 < 4e-5, "{errors:?}");
}

/// rapier's multibody integrates joint rates by semi-implicit Euler, so it is of first order, as documented.
#[test]
fn reduced_coordinates_are_first_order() {
    let errors = errors(&free_motion(), Construction::Reduced, 2e-5);
    for order in observed_orders(&errors) {
        assert!((0.9..1.3).contains(&order), "slopes {:?} of {errors:?}", observed_orders(&errors));
    }
}

/// Adaptive steps keep the second order: errors fall with the tolerance, which is proportional to dt².
#[test]
fn adaptive_steps_converge_with_their_tolerance() {
    let (_, reference) = run_dense_reference(&free_motion());
    let error = |tolerance_m: f64| {
        let mut scene = free_motion();
        scene.engine.stepping = Stepping::Adaptive { tolerance_m, max_step_s: 1e-4 };
        let (outcome, run) = run_engine(&scene);
        (outcome.work.steps, max_angle_error(&run, &reference))
    };
    let (coarse, fine) = (error(1e-8), error(1e-10));
    assert!(fine.0 > 8 * coarse.0, "{coarse:?} {fine:?}");
    let order = (coarse.1 / fine.1).ln() / (fine.0 as f64 / coarse.0 as f64).ln();
    assert!(order > 1.6, "slope {order}: {coarse:?} {fine:?}");
}
