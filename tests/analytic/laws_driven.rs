//! Contact forces on driven discs against the closed forms of the laws (thesis Appendix B.1.2, Figs. B.7–B.9).

use crate::support::laws::{
    BOTH_MODELS, THESIS_FRICTION, THESIS_NORMAL, disc, driven, run_to_end, sampled_at_steps, scene, spring,
    with_fixed_step, with_half_plane,
};
use phalanx::law::NormalLaw;
use phalanx::scene::{DiscMotion, Scene};
use phalanx::trace::EventKind;

/// Rounding error of positions of about 0.1 m after a few operations, m.
const POSITION_ROUNDING: f64 = 1e-16;

/// A disc driven at 1 m/s into a fixed one, to a penetration of 2 cm.
fn driven_contact_scene(normal: NormalLaw) -> Scene {
    let discs = vec![
        disc("anvil", 0.1, [0.1, 0.0], DiscMotion::Fixed),
        disc("hammer", 0.1, [-0.105, 0.0], driven([1.0, 0.0], [0.0; 2])),
    ];
    scene(discs, normal, None, 25e-3)
}

/// Thesis Fig. B.7: spring only, up to 2 cm.
#[test]
fn spring_force_is_k_delta_to_the_e() {
    for (k, e) in [(1e8, 2.2), (1e6, 1.5), (3e5, 1.0)] {
        for model in BOTH_MODELS {
            let (outcome, log) = run_to_end(model, &sampled_at_steps(model, driven_contact_scene(spring(k, e))));
            let mut deepest: f64 = 0.0;
            for sample in &log.samples {
                let contact = sample.contact(0);
                let delta = (sample.time_s - 5e-3).max(0.0);
                deepest = deepest.max(delta);
                let expected_n = k * delta.powf(e);
                let rounding = k * e * delta.powf(e - 1.0) * POSITION_ROUNDING;
                let error = (contact.normal_n - expected_n).abs();
                assert!(
                    error <= 1e-12 * expected_n + rounding + 1e-12,
                    "{}, e = {e}, δ = {delta:e}: {} instead of {expected_n}",
                    model.name(),
                    contact.normal_n
                );
                assert_eq!((contact.tangential_n, contact.slip_m_s), (0.0, 0.0));
                // The normal on the driven disc opposes its motion.
                assert!((contact.normal[0] + 1.0).abs() < 1e-15 && contact.normal[1] == 0.0);
            }
            assert!((deepest - 0.02).abs() < 1e-12);
            let summary = &outcome.contacts[0];
            assert!((summary.first_s.unwrap() - 5e-3).abs() < 1e-12, "{:?}", summary.first_s);
            assert!((summary.peak_normal_n / (k * 0.02f64.powf(e)) - 1.0).abs() < 1e-12);
            assert!((summary.max_penetration_m - 0.02).abs() < 1e-14);
            let impulse = k * 0.02f64.powf(e + 1.0) / (e + 1.0);
            assert!((summary.impulse_n_s / impulse - 1.0).abs() < 1e-5, "{} {impulse}", summary.impulse_n_s);
            // At 1 m/s the work of the drive equals the impulse, and the spring stores it.
            let energy = &outcome.last.energy();
            assert!((energy.motor_work_j / impulse - 1.0).abs() < 1e-5, "{energy:?} {impulse}");
            assert!(energy.balance_j.abs() < 1e-12 * impulse, "{energy:?}");
        }
    }
}

/// Thesis Fig. B.8: damper only; c rises over the first δ_max as a smooth step.
#[test]
fn damper_force_is_c_of_delta_times_the_rate() {
    for transition_m in [1e-3, 1e-5] {
        let normal = NormalLaw { stiffness_n_per_m_e: 0.0, transition_m, ..THESIS_NORMAL };
        // Both models take 20 steps within the transition.
        let step_s = transition_m / 20.0;
        let mut scene = with_fixed_step(&driven_contact_scene(normal), step_s);
        scene.duration_s = 5e-3 + 3.0 * transition_m;
        scene.log.numeric_hz = 1.0 / step_s;
        for model in BOTH_MODELS {
            let (outcome, log) = run_to_end(model, &sampled_at_steps(model, scene.clone()));
            let mut samples_in_transition = 0;
            for sample in &log.samples {
                let contact = sample.contact(0);
                let delta = (sample.time_s - 5e-3).max(0.0);
                let s = (delta / transition_m).min(1.0);
                samples_in_transition += u32::from(s > 0.0 && s < 1.0);
                let expected_n = 1e6 * s * s * (3.0 - 2.0 * s);
                let rounding = 1e6 * 6.0 * s * POSITION_ROUNDING / transition_m;
                let error = (contact.normal_n - expected_n).abs();
                assert!(
                    error <= 1e-12 * expected_n + rounding,
                    "{}, δ = {delta:e}: {} instead of {expected_n}",
                    model.name(),
                    contact.normal_n
                );
            }
            assert!(
                samples_in_transition > 10,
                "{}: {samples_in_transition} samples within the transition",
                model.name()
            );
            assert!((outcome.contacts[0].peak_normal_n / 1e6 - 1.0).abs() < 1e-12);
        }
    }
}

/// Thesis Fig. B.9: a disc moves along the half plane at constant penetration; its slip covers the whole friction
/// curve.
#[test]
fn friction_force_is_mu_of_v_times_the_normal_force() {
    let start = [0.0, 0.1 - 1e-5];
    // x of the disc decreases at first, so slip along the tangent (−1, 0) falls from 0.3 m/s to −0.3 m/s.
    let discs = vec![disc("slider", 0.1, start, driven([-0.3, 0.0], [6.0, 0.0]))];
    let mut scene = with_half_plane(scene(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 0.1));
    scene.log.numeric_hz = 2e4;
    let normal = 1e8 * 1e-5f64.powf(2.2);
    for model in BOTH_MODELS {
        let (_, log) = run_to_end(model, &sampled_at_steps(model, scene.clone()));
        let (mut lowest, mut highest) = (0.0f64, 0.0f64);
        for sample in &log.samples {
            let contact = sample.contact(0);
            let v = 0.3 - 6.0 * sample.time_s;
            (lowest, highest) = (lowest.min(v), highest.max(v));
            // The law of thesis (2.35) with errata 8, implemented independently.
            let step = |x: f64| 3.0 * x * x - 2.0 * x * x * x;
            let mu = match v.abs() {
                speed if speed < 0.1 => 0.8 * (2.0 * step((v + 0.1) / 0.2) - 1.0),
                speed if speed < 0.2 => v.signum() * (0.8 - 0.24 * step((speed - 0.1) / 0.1)),
                _ => v.signum() * 0.56,
            };
            let expected_n = -mu * contact.normal_n;
            assert!((contact.slip_m_s - v).abs() < 1e-14, "{}: slip {} {v}", model.name(), contact.slip_m_s);
            assert!((contact.normal_n / normal - 1.0).abs() < 1e-10, "{}: {}", model.name(), contact.normal_n);
            assert!(
                (contact.tangential_n - expected_n).abs() <= 1e-12 * normal,
                "{} at {v} m/s: {} instead of {expected_n}",
                model.name(),
                contact.tangential_n
            );
        }
        assert!(lowest == -0.3 || (lowest + 0.3).abs() < 1e-12);
        assert_eq!(highest, 0.3);
        assert!(log.events.iter().all(|event| event.kind == EventKind::TouchDown && event.time_s == 0.0));
    }
}

/// A disc that rotates without translation slips at −ω r along the tangent.
#[test]
fn spin_causes_slip() {
    let motion = DiscMotion::Driven { velocity_m_s: [0.0; 2], acceleration_m_s2: [0.0; 2], spin_rad_s: 1.5 };
    let discs = vec![disc("wheel", 0.1, [0.0, 0.1 - 1e-5], motion)];
    let scene = with_half_plane(scene(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 10e-3));
    for model in BOTH_MODELS {
        let (outcome, _) = run_to_end(model, &sampled_at_steps(model, scene.clone()));
        let contact = outcome.last.contact(0);
        assert!((contact.slip_m_s + 0.15).abs() < 1e-14, "{}: {}", model.name(), contact.slip_m_s);
        // Friction opposes the slip: it acts along the tangent, which is −x.
        assert!((contact.tangential_n / contact.normal_n - 0.68).abs() < 1e-12);
        assert!((outcome.last.body(0).angle_rad - 0.015).abs() < 1e-13);
        let work = contact.tangential_n * 0.15 * 10e-3;
        assert!((outcome.last.energy().motor_work_j / work - 1.0).abs() < 1e-6, "{}", model.name());
    }
}
