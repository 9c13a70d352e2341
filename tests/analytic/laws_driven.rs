//! The scalar laws by themselves: what driven discs meet is the law's closed form (thesis Appendix B.1.2, Figs. B.7–B.9).

use crate::support::laws::{
    BOTH, FRICTION, THESIS, at_steps, complete, disc, driven, on_plane, scene, spring, stepped,
};
use phalanx::law::NormalLaw;
use phalanx::scene::{DiscMotion, Scene};
use phalanx::trace::EventKind;

/// Rounding of positions of 0.1 m, in a few operations.
const POSITION_ROUNDING: f64 = 1e-16;

/// A disc driven at 1 m/s by 2 cm into a fixed one.
fn pressed(normal: NormalLaw) -> Scene {
    let discs = vec![
        disc("anvil", 0.1, [0.1, 0.0], DiscMotion::Fixed),
        disc("hammer", 0.1, [-0.105, 0.0], driven([1.0, 0.0], [0.0; 2])),
    ];
    scene(discs, normal, None, 25e-3)
}

/// Thesis Fig. B.7: no damper, up to 2 cm.
#[test]
fn a_spring_alone_is_k_delta_to_the_e() {
    for (k, e) in [(1e8, 2.2), (1e6, 1.5), (3e5, 1.0)] {
        for model in BOTH {
            let (outcome, log) = complete(model, &at_steps(model, pressed(spring(k, e))));
            let mut deepest: f64 = 0.0;
            for sample in &log.samples {
                let contact = &sample.contacts[0];
                let delta = (sample.time_s - 5e-3).max(0.0);
                deepest = deepest.max(delta);
                let closed = k * delta.powf(e);
                let rounding = k * e * delta.powf(e - 1.0) * POSITION_ROUNDING;
                let error = (contact.normal_n - closed).abs();
                assert!(
                    error <= 1e-12 * closed + rounding + 1e-12,
                    "{}, e = {e}, δ = {delta:e}: {} instead of {closed}",
                    model.name(),
                    contact.normal_n
                );
                assert_eq!((contact.tangential_n, contact.slip_m_s), (0.0, 0.0));
                // On the hammer, back along its way.
                assert!((contact.normal[0] + 1.0).abs() < 1e-15 && contact.normal[1] == 0.0);
            }
            assert!((deepest - 0.02).abs() < 1e-12);
            let summary = &outcome.contacts[0];
            assert!((summary.first_s.unwrap() - 5e-3).abs() < 1e-12, "{:?}", summary.first_s);
            assert!((summary.peak_normal_n / (k * 0.02f64.powf(e)) - 1.0).abs() < 1e-12);
            assert!((summary.max_penetration_m - 0.02).abs() < 1e-14);
            let impulse = k * 0.02f64.powf(e + 1.0) / (e + 1.0);
            assert!((summary.impulse_n_s / impulse - 1.0).abs() < 1e-5, "{} {impulse}", summary.impulse_n_s);
            // The drive pays for what the spring takes up.
            let energy = &outcome.last.energy;
            assert!((energy.motor_work_j / impulse - 1.0).abs() < 1e-5, "{energy:?} {impulse}");
            assert!(energy.balance_j.abs() < 1e-12 * impulse, "{energy:?}");
        }
    }
}

/// Thesis Fig. B.8: no spring; c grows over the first δ_max as a smooth step.
#[test]
fn a_damper_alone_is_c_of_delta_times_the_rate() {
    for transition_m in [1e-3, 1e-5] {
        let normal = NormalLaw { stiffness_n_per_m_e: 0.0, transition_m, ..THESIS };
        // Twenty steps within the transition, in either model.
        let step_s = transition_m / 20.0;
        let mut scene = stepped(&pressed(normal), step_s);
        scene.duration_s = 5e-3 + 3.0 * transition_m;
        scene.log.numeric_hz = 1.0 / step_s;
        for model in BOTH {
            let (outcome, log) = complete(model, &at_steps(model, scene.clone()));
            let mut within = 0;
            for sample in &log.samples {
                let contact = &sample.contacts[0];
                let delta = (sample.time_s - 5e-3).max(0.0);
                let s = (delta / transition_m).min(1.0);
                within += u32::from(s > 0.0 && s < 1.0);
                let closed = 1e6 * s * s * (3.0 - 2.0 * s);
                let rounding = 1e6 * 6.0 * s * POSITION_ROUNDING / transition_m;
                let error = (contact.normal_n - closed).abs();
                assert!(
                    error <= 1e-12 * closed + rounding,
                    "{}, δ = {delta:e}: {} instead of {closed}",
                    model.name(),
                    contact.normal_n
                );
            }
            assert!(within > 10, "{}: {within} samples within the transition", model.name());
            assert!((outcome.contacts[0].peak_normal_n / 1e6 - 1.0).abs() < 1e-12);
        }
    }
}

/// Thesis Fig. B.9: a disc at constant penetration along the half plane, its slip through the whole friction curve.
#[test]
fn friction_is_mu_of_v_times_the_normal_force() {
    let start = [0.0, 0.1 - 1e-5];
    // x of the disc decreases at first: slip along the tangent (−1, 0) goes from 0.3 m/s to −0.3 m/s.
    let discs = vec![disc("slider", 0.1, start, driven([-0.3, 0.0], [6.0, 0.0]))];
    let mut scene = on_plane(scene(discs, THESIS, Some(FRICTION), 0.1));
    scene.log.numeric_hz = 2e4;
    let normal = 1e8 * 1e-5f64.powf(2.2);
    for model in BOTH {
        let (_, log) = complete(model, &at_steps(model, scene.clone()));
        let (mut lowest, mut highest) = (0.0f64, 0.0f64);
        for sample in &log.samples {
            let contact = &sample.contacts[0];
            let v = 0.3 - 6.0 * sample.time_s;
            (lowest, highest) = (lowest.min(v), highest.max(v));
            // The law as thesis (2.35) with errata 8 has it, written anew.
            let step = |x: f64| 3.0 * x * x - 2.0 * x * x * x;
            let mu = match v.abs() {
                speed if speed < 0.1 => 0.8 * (2.0 * step((v + 0.1) / 0.2) - 1.0),
                speed if speed < 0.2 => v.signum() * (0.8 - 0.24 * step((speed - 0.1) / 0.1)),
                _ => v.signum() * 0.56,
            };
            let closed = -mu * contact.normal_n;
            assert!((contact.slip_m_s - v).abs() < 1e-14, "{}: slip {} {v}", model.name(), contact.slip_m_s);
            assert!((contact.normal_n / normal - 1.0).abs() < 1e-10, "{}: {}", model.name(), contact.normal_n);
            assert!(
                (contact.tangential_n - closed).abs() <= 1e-12 * normal,
                "{} at {v} m/s: {} instead of {closed}",
                model.name(),
                contact.tangential_n
            );
        }
        assert!(lowest == -0.3 || (lowest + 0.3).abs() < 1e-12);
        assert_eq!(highest, 0.3);
        assert!(log.events.iter().all(|event| event.kind == EventKind::TouchDown && event.time_s == 0.0));
    }
}

/// A disc that turns on the spot slips by its spin: −ω r along the tangent.
#[test]
fn spin_slips_like_motion() {
    let motion = DiscMotion::Driven { velocity_m_s: [0.0; 2], acceleration_m_s2: [0.0; 2], spin_rad_s: 1.5 };
    let discs = vec![disc("wheel", 0.1, [0.0, 0.1 - 1e-5], motion)];
    let scene = on_plane(scene(discs, THESIS, Some(FRICTION), 10e-3));
    for model in BOTH {
        let (outcome, _) = complete(model, &at_steps(model, scene.clone()));
        let contact = &outcome.last.contacts[0];
        assert!((contact.slip_m_s + 0.15).abs() < 1e-14, "{}: {}", model.name(), contact.slip_m_s);
        // Friction drives the surface back against its slip: along +tangent, which is −x.
        assert!((contact.tangential_n / contact.normal_n - 0.68).abs() < 1e-12);
        assert!((outcome.last.bodies[0].angle_rad - 0.015).abs() < 1e-13);
        let work = contact.tangential_n * 0.15 * 10e-3;
        assert!((outcome.last.energy.motor_work_j / work - 1.0).abs() < 1e-6, "{}", model.name());
    }
}
