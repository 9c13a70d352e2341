//! One finger with stiction, in both models.

use phalanx::scene::{Construction, Scene, Stepping};
use phalanx::trace::FingerContact;

use crate::support::runs::{max_angle_error, run_dense_reference, run_engine};
use crate::support::stiction::load_with_stiction;

/// With default settings the models agree as closely as without bristles, and more closely at a finer tolerance.
#[test]
fn both_models_agree_and_the_difference_falls_with_the_tolerance() {
    for name in ["experiment-95", "long-fingers", "soft-start", "hard/friction-2", "hard/limit-hammered"] {
        let scene = load_with_stiction(name);
        let (expected_outcome, reference) = run_dense_reference(&scene);
        let (outcome, run) = run_engine(&scene);
        let difference = max_angle_error(&run, &reference);
        assert!(difference < 2e-5, "{name}: {difference:.1e} rad");
        for contact in [FingerContact::Proximal, FingerContact::Distal] {
            let (actual, expected) =
                (outcome.last.finger_contact(contact), expected_outcome.last.finger_contact(contact));
            let (force_scale, distance) = (expected.normal_n.abs().max(1.0), |a: f64, b: f64| (a - b).abs());
            assert!(
                distance(actual.normal_n, expected.normal_n) < 1e-3 * force_scale,
                "{name} {contact:?}: {actual:?} {expected:?}"
            );
            assert!(
                distance(actual.tangential_n, expected.tangential_n) < 1e-3 * force_scale,
                "{name} {contact:?}: {actual:?} {expected:?}"
            );
        }
        let energies = [&outcome, &expected_outcome].map(|outcome| outcome.last.energy());
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{name}: {energies:?}");
        assert!((energies[0].elastic_j - energies[1].elastic_j).abs() < 5e-7, "{name}: {energies:?}");
        let stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
        let mut fine = scene.clone();
        fine.engine.stepping = stepping;
        let fine_difference = max_angle_error(&run_engine(&fine).1, &reference);
        println!("{name}: {difference:.1e}, {fine_difference:.1e}");
        assert!(
            fine_difference < 2e-6 && fine_difference < 0.4 * difference,
            "{name}: {fine_difference:.1e} at 1e-9 m, {difference:.1e} at 1e-7 m"
        );
    }
}

/// Stiction works with reduced coordinates too, with first-order accuracy.
#[test]
fn reduced_coordinates_support_stiction() {
    let mut scene = load_with_stiction("experiment-95");
    let (_, reference) = run_dense_reference(&scene);
    scene.engine.construction = Construction::Reduced;
    let difference = [2e-6, 1e-6].map(|step_s| {
        scene.engine.stepping = Stepping::Fixed { step_s };
        max_angle_error(&run_engine(&Scene { ..scene.clone() }).1, &reference)
    });
    assert!(difference[1] < 2e-3 && difference[1] < 0.7 * difference[0], "{difference:?}");
}
