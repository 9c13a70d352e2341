//! One finger whose friction holds, in both models.

use phalanx::scene::{Construction, Scene, Stepping};
use phalanx::trace::Site;

use crate::support::runs::{dense_reference, engine, worst_angle};
use crate::support::scenes::holding;

/// At the default both are as near to each other as without bristles, and the nearer the finer it is.
#[test]
fn both_models_agree_and_more_finely_the_better() {
    for name in ["experiment-95", "long-fingers", "soft-start", "hard/friction-2", "hard/limit-hammered"] {
        let scene = holding(name);
        let (expected, reference) = dense_reference(&scene);
        let (outcome, run) = engine(&scene);
        let off = worst_angle(&run, &reference);
        assert!(off < 2e-5, "{name}: {off:.1e} rad");
        for site in [Site::Proximal, Site::Distal] {
            let (found, wanted) = (outcome.last.contact(site), expected.last.contact(site));
            let (most, near) = (wanted.normal_n.abs().max(1.0), |a: f64, b: f64| (a - b).abs());
            assert!(near(found.normal_n, wanted.normal_n) < 1e-3 * most, "{name} {site:?}: {found:?} {wanted:?}");
            assert!(
                near(found.tangential_n, wanted.tangential_n) < 1e-3 * most,
                "{name} {site:?}: {found:?} {wanted:?}"
            );
        }
        let energies = [&outcome, &expected].map(|outcome| outcome.last.energy);
        assert!(energies.iter().all(|energy| energy.balance_j.abs() < 3e-5), "{name}: {energies:?}");
        assert!((energies[0].elastic_j - energies[1].elastic_j).abs() < 5e-7, "{name}: {energies:?}");
        let stepping = Stepping::Adaptive { tolerance_m: 1e-9, max_step_s: 6e-5 };
        let mut fine = scene.clone();
        fine.engine.stepping = stepping;
        let finer = worst_angle(&engine(&fine).1, &reference);
        println!("{name}: {off:.1e}, {finer:.1e}");
        assert!(finer < 2e-6 && finer < 0.4 * off, "{name}: {finer:.1e} at 1e-9 m, {off:.1e} at 1e-7 m");
    }
}

/// Joint coordinates instead of pins: first order, and the same law.
#[test]
fn joint_coordinates_hold_as_well() {
    let mut scene = holding("experiment-95");
    let (_, reference) = dense_reference(&scene);
    scene.engine.construction = Construction::Reduced;
    let off = [2e-6, 1e-6].map(|step_s| {
        scene.engine.stepping = Stepping::Fixed { step_s };
        worst_angle(&engine(&Scene { ..scene.clone() }).1, &reference)
    });
    assert!(off[1] < 2e-3 && off[1] < 0.7 * off[0], "{off:?}");
}
