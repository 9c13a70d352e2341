//! Order of convergence of the engine model, from runs at deterministic step counts.

use crate::support::runs::{anchor, dense_reference, engine, worst_angle};
use phalanx::scene::{self, Construction, Scene, Stepping};

/// The anchor without object and limit, before the tip has swung too far: motor, spring, gravity and joints only.
fn free() -> Scene {
    let mut scene = Scene { duration_s: 3e-3, ..anchor() };
    scene.system.discs.clear();
    scene.finger_mut().limit = None;
    scene
}

/// Errors at steps that halve, with the number of steps each took.
fn errors(scene: &Scene, construction: Construction, coarsest_s: f64) -> Vec<(u64, f64)> {
    let (_, reference) = dense_reference(scene);
    (0..4)
        .map(|halvings| {
            let mut scene = scene.clone();
            scene.engine.construction = construction;
            scene.engine.stepping = Stepping::Fixed { step_s: coarsest_s / f64::from(1 << halvings) };
            let (outcome, run) = engine(&scene);
            (outcome.work.steps, worst_angle(&run, &reference))
        })
        .collect()
}

fn slopes(errors: &[(u64, f64)]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0].1 / pair[1].1).log2()).collect()
}

#[test]
fn free_motion_in_maximal_coordinates_is_second_order() {
    let errors = errors(&free(), Construction::Maximal, 4e-5);
    assert_eq!(errors.iter().map(|e| e.0).collect::<Vec<_>>(), [75, 150, 300, 600]);
    for slope in slopes(&errors) {
        assert!(slope >= 1.9, "slopes {:?} of {errors:?}", slopes(&errors));
    }
    assert!(errors[3].1 < 5e-7, "error {:e} at 5e-6 s", errors[3].1);
}

/// A pressing joint limit is a stiff, plastic contact; it must not cost the order.
#[test]
fn motion_against_the_joint_limit_is_second_order() {
    let mut scene = Scene { duration_s: 4e-3, ..anchor() };
    scene.system.discs.clear();
    let errors = errors(&scene, Construction::Maximal, 4e-5);
    for slope in slopes(&errors) {
        assert!(slope >= 1.8, "slopes {:?} of {errors:?}", slopes(&errors));
    }
}

/// Rebounds that friction brakes and nothing else: slip must turn with its contact, and the law act on it in the middle of a
/// step. Single slopes swing, for touches fall anywhere within a step; the mean one does not.
#[test]
fn undamped_contact_with_friction_is_second_order() {
    let mut scene = scene::load("scenes/hard/damper-none.toml").unwrap_or_else(|error| panic!("{error}"));
    (scene.duration_s, scene.bounds.until_s) = (9e-3, 9e-3);
    let errors = errors(&scene, Construction::Maximal, 1e-5);
    let slope = (errors[0].1 / errors[3].1).log2() / 3.0;
    assert!(slope >= 1.8, "slopes {:?} of {errors:?}", slopes(&errors));
    assert!(errors[3].1 < 2e-6, "error {:e} at 1.25e-6 s", errors[3].1);
}

/// A tip that slides over the object and on over its own end, pressed on by a stiff damper: the normal impulses that a step
/// misses must drag their friction along. First order without that, and forty times as far off.
#[test]
fn sliding_on_a_stiff_contact_stays_close() {
    let mut scene = scene::load("scenes/hard/end-cap.toml").unwrap_or_else(|error| panic!("{error}"));
    (scene.duration_s, scene.bounds.until_s) = (9e-3, 9e-3);
    let errors = errors(&scene, Construction::Maximal, 1e-5);
    assert!(errors[0].1 < 4e-4 && errors[3].1 < 4e-5, "{errors:?}");
}

/// rapier's multibody integrates its joint rates with semi-implicit Euler: one order less, which the documentation says.
#[test]
fn reduced_coordinates_are_first_order() {
    let errors = errors(&free(), Construction::Reduced, 2e-5);
    for slope in slopes(&errors) {
        assert!((0.9..1.3).contains(&slope), "slopes {:?} of {errors:?}", slopes(&errors));
    }
}

/// Step sizes that change from step to step keep the second order: errors fall with the tolerance, which goes with dt².
#[test]
fn adaptive_steps_converge_with_their_tolerance() {
    let (_, reference) = dense_reference(&free());
    let error = |tolerance_m: f64| {
        let mut scene = free();
        scene.engine.stepping = Stepping::Adaptive { tolerance_m, max_step_s: 1e-4 };
        let (outcome, run) = engine(&scene);
        (outcome.work.steps, worst_angle(&run, &reference))
    };
    let (coarse, fine) = (error(1e-8), error(1e-10));
    assert!(fine.0 > 8 * coarse.0, "{coarse:?} {fine:?}");
    let slope = (coarse.1 / fine.1).ln() / (fine.0 as f64 / coarse.0 as f64).ln();
    assert!(slope > 1.6, "slope {slope}: {coarse:?} {fine:?}");
}
