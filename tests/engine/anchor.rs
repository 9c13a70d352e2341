//! The engine model of design 95 against the analytic one, at its default settings and at coarse fixed steps.

use crate::support::runs::{anchor, assert_near, dense_reference, engine, impact_impulse, worst_angle};
use phalanx::scene::{Actuation, Response, Scene, Stepping};
use phalanx::trace::Site;

/// The anchor with its torque changed in the ninth digit: what a method owes to luck shows as scatter.
fn ensemble() -> Vec<Scene> {
    (0..5)
        .map(|i| {
            let torque_n_m = 0.480 * (1.0 + 1e-9 * f64::from(i));
            let mut scene = anchor();
            scene.finger_mut().motor.actuation = Actuation::Constant { torque_n_m };
            scene
        })
        .collect()
}

/// The figures the project promises for its defaults, worst of the ensemble.
#[test]
fn defaults_follow_the_analytic_model_along_the_whole_closing() {
    for scene in ensemble() {
        let (expected, reference) = dense_reference(&scene);
        let (outcome, run) = engine(&scene);
        let angle = worst_angle(&run, &reference);
        assert!(angle <= 2e-5, "largest angle difference {angle:e}");
        for site in [Site::Proximal, Site::Distal] {
            let (found, wanted) = (outcome.site(site), expected.site(site));
            assert_eq!(found.touchdowns, wanted.touchdowns);
            assert_near(found.first_s.unwrap(), wanted.first_s.unwrap(), 0.5e-6, "first touch");
            let (p, wanted) = (impact_impulse(&run, site, 20e-6), impact_impulse(&reference, site, 20e-6));
            assert_near(p, wanted, 5e-3 * wanted, "impulse of the impact");
        }
        for (found, wanted) in [
            (outcome.last.contact(Site::Proximal).normal_n, expected.last.contact(Site::Proximal).normal_n),
            (outcome.last.contact(Site::Distal).normal_n, expected.last.contact(Site::Distal).normal_n),
        ] {
            assert_near(found, wanted, 1e-4 * wanted, "final normal force");
        }
        assert!(outcome.loop_gap_m <= 1e-7, "loop gap {:e}", outcome.loop_gap_m);
    }
}

/// The anchor's printed digits (1-model §1.8), from the engine.
#[test]
fn anchor_digits_come_out_of_the_engine_too() {
    let (outcome, _) = engine(&anchor());
    assert_near(outcome.site(Site::Proximal).first_s.unwrap(), 4.501315e-3, 2e-8, "first contact");
    assert_near(outcome.site(Site::Distal).first_s.unwrap(), 6.883746e-3, 2e-8, "second contact");
    assert_near(outcome.last.finger().q11_rad.to_degrees(), 2.088778, 2e-5, "q11");
    assert_near(outcome.last.finger().q21_rad.to_degrees(), 65.019991, 2e-5, "q21");
}

/// At 1e-4 s the engine is what tuned rigid-contact engines are: contact within one step, the final pose within 3e-4 rad.
#[test]
fn a_step_of_a_tenth_of_a_millisecond_is_no_worse_than_rigid_contact() {
    for mut scene in ensemble() {
        scene.engine.stepping = Stepping::Fixed { step_s: 1e-4 };
        let (expected, _) = dense_reference(&scene);
        let (outcome, _) = engine(&scene);
        assert_eq!(outcome.work.steps, 200);
        for site in [Site::Proximal, Site::Distal] {
            let (found, wanted) = (outcome.site(site).first_s.unwrap(), expected.site(site).first_s.unwrap());
            assert_near(found, wanted, 1e-4, "first touch");
        }
        assert_near(outcome.last.finger().q11_rad, expected.last.finger().q11_rad, 3e-4, "q11");
        assert_near(outcome.last.finger().q21_rad, expected.last.finger().q21_rad, 3e-4, "q21");
    }
}

/// rapier's own contact closes the finger too, rigidly: what the laws add is the forces and the last micrometres.
#[test]
fn rapiers_own_contact_ends_near_the_same_pose() {
    let mut scene = anchor();
    scene.engine.response = Response::Rapier { friction: 0.8, restitution: 0.0 };
    scene.engine.iterations = 50;
    scene.engine.stepping = Stepping::Fixed { step_s: 1e-5 };
    let (expected, _) = dense_reference(&scene);
    let (outcome, _) = engine(&scene);
    assert_near(outcome.last.finger().q11_rad, expected.last.finger().q11_rad, 5e-4, "q11");
    assert_near(outcome.last.finger().q21_rad, expected.last.finger().q21_rad, 5e-4, "q21");
    for site in [Site::Proximal, Site::Distal] {
        let (found, wanted) = (outcome.site(site).first_s.unwrap(), expected.site(site).first_s.unwrap());
        assert_near(found, wanted, 2e-5, "first touch");
        assert!(outcome.site(site).impulse_n_s > 0.0);
    }
    assert!(outcome.last.contact(Site::Proximal).normal_n > 1.0 && outcome.last.contact(Site::Distal).normal_n > 1.0);
}

/// Held for five times as long, the contacts creep as the reference says: nothing drifts off at any step size.
#[test]
fn a_hold_creeps_as_the_reference_does() {
    for max_step_s in [6e-5, 1e-4] {
        let mut scene = Scene { duration_s: 0.1, ..anchor() };
        scene.engine.stepping = Stepping::Adaptive { tolerance_m: 1e-7, max_step_s };
        let (expected, reference) = dense_reference(&scene);
        let (outcome, run) = engine(&scene);
        assert!(worst_angle(&run, &reference) < 1e-5);
        for (found, wanted) in [
            (outcome.last.contact(Site::Proximal), expected.last.contact(Site::Proximal)),
            (outcome.last.contact(Site::Distal), expected.last.contact(Site::Distal)),
        ] {
            assert_near(found.normal_n, wanted.normal_n, 2e-6 * wanted.normal_n, "normal force");
            assert_near(found.gap_m, wanted.gap_m, 1e-3 * wanted.gap_m.abs(), "penetration");
        }
    }
}
