//! Head-on impacts of a free disc on a fixed one: both models against closed forms and against a Runge–Kutta solution.

use std::f64::consts::PI;

use crate::support::laws::{gamma_function, impact_scene, relative_error, run_to_end, spring, with_fixed_step};
use phalanx::law::NormalLaw;
use phalanx::scene::Scene;
use phalanx::trace::{EventKind, Model};

/// Results of an impact of 1 kg.
#[derive(Clone, Copy, Debug)]
struct ImpactResult {
    contact_time_s: f64,
    restitution: f64,
    peak_n: f64,
    depth_m: f64,
    lost_j: f64,
}

fn simulated_impact(model: Model, scene: &Scene, speed: f64) -> ImpactResult {
    let (outcome, log) = run_to_end(model, scene);
    let summary = &outcome.contacts[0];
    assert_eq!(summary.touchdowns, 1, "{}", model.name());
    let contact_start_s = log.event_time_s(0, EventKind::TouchDown);
    assert!((contact_start_s - 1e-3).abs() < 1e-12, "{}: {contact_start_s:e}", model.name());
    let final_velocity = outcome.last.body(1).velocity_m_s;
    assert_eq!((final_velocity[1], outcome.last.body(1).spin_rad_s), (0.0, 0.0));
    ImpactResult {
        contact_time_s: log.event_time_s(0, EventKind::LiftOff) - contact_start_s,
        restitution: -final_velocity[0] / speed,
        peak_n: summary.peak_normal_n,
        depth_m: summary.max_penetration_m,
        lost_j: outcome.last.energy().dissipated_j,
    }
}

/// Largest relative difference of contact time, restitution, peak force and depth.
fn max_relative_error(actual: &ImpactResult, expected: &ImpactResult) -> f64 {
    let pairs = [
        (actual.contact_time_s, expected.contact_time_s),
        (actual.restitution, expected.restitution),
        (actual.peak_n, expected.peak_n),
        (actual.depth_m, expected.depth_m),
    ];
    pairs.into_iter().map(|(actual, expected)| relative_error(actual, expected)).fold(0.0, f64::max)
}

/// Closed form for F = k δᵉ: depth from m v²/2 = k δᵉ⁺¹/(e + 1), contact time 2 (δ/v) ∫₀¹ dx/√(1 − xᵉ⁺¹).
fn elastic_impact(law: &NormalLaw, speed: f64) -> ImpactResult {
    let (k, e) = (law.stiffness_n_per_m_e, law.exponent);
    let depth_m = ((e + 1.0) * speed * speed / (2.0 * k)).powf(1.0 / (e + 1.0));
    let inverse_order = 1.0 / (e + 1.0);
    ImpactResult {
        contact_time_s: 2.0 * depth_m / speed * PI.sqrt() * gamma_function(1.0 + inverse_order)
            / gamma_function(0.5 + inverse_order),
        restitution: 1.0,
        peak_n: k * depth_m.powf(e),
        depth_m,
        lost_j: 0.0,
    }
}

const ELASTIC_CASES: [(f64, f64, f64); 3] = [(1e8, 2.2, 1.0), (2e7, 1.5, 0.5), (1e6, 1.0, 2.0)];

#[test]
fn the_analytic_model_matches_elastic_impacts() {
    for (k, e, speed) in ELASTIC_CASES {
        let law = spring(k, e);
        let actual = simulated_impact(Model::Analytic, &impact_scene(law, speed, 20e-3), speed);
        let error = max_relative_error(&actual, &elastic_impact(&law, speed));
        println!("e = {e}: {error:.1e}, lost {:.1e} J", actual.lost_j);
        assert!(error < 1e-9, "e = {e}: {error:.1e}: {actual:?} {:?}", elastic_impact(&law, speed));
        assert!(actual.lost_j.abs() < 1e-9 * speed * speed, "{actual:?}");
    }
}

/// Speed at a depth for k = 0: v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) up to δ_max; beyond, c_max/m (δ −
/// δ_max) less.
fn damped_speed(law: &NormalLaw, speed: f64, delta: f64) -> f64 {
    let (c, transition_end) = (law.damping_max_n_s_per_m, law.transition_m);
    let velocity_loss =
        |delta: f64| c * (delta.powi(3) / transition_end.powi(2) - delta.powi(4) / (2.0 * transition_end.powi(3)));
    speed - velocity_loss(delta.min(transition_end)) - c * (delta - transition_end).max(0.0)
}

#[test]
fn the_analytic_model_matches_the_closed_form_of_a_damper() {
    // The disc stops within the transition, and far beyond it.
    for (c, speed) in [(1e6, 1.0), (1e3, 1.0)] {
        let law = NormalLaw { stiffness_n_per_m_e: 0.0, exponent: 2.2, damping_max_n_s_per_m: c, transition_m: 1e-5 };
        let (outcome, log) = run_to_end(Model::Analytic, &impact_scene(law, speed, 20e-3));
        let mut contact_samples = 0;
        for sample in &log.samples {
            let contact = sample.contact(0);
            let (delta, rate) = (-contact.gap_m, -contact.gap_rate_m_s);
            if delta > 0.0 {
                contact_samples += 1;
                let expected_rate = damped_speed(&law, speed, delta);
                assert!((rate - expected_rate).abs() < 1e-9 * speed, "δ = {delta:e}: {rate} {expected_rate}");
            }
        }
        assert!(contact_samples > 20);
        let loss_j = 0.5 * speed * speed;
        assert!(relative_error(outcome.last.energy().dissipated_j, loss_j) < 1e-9);
        assert!(outcome.last.energy().balance_j.abs() < 1e-10 * loss_j, "{:?}", outcome.last.energy());
    }
}

const SPRING_AND_DAMPER: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 200.0, transition_m: 1e-4 };

/// Impact of 1 kg on spring and damper by the classical Runge–Kutta method with fixed step. Bisection locates the end
/// of the transition and the lift-off. The laws are implemented independently of the library.
fn impact_by_runge_kutta(law: &NormalLaw, speed: f64, h: f64) -> ImpactResult {
    let &NormalLaw { stiffness_n_per_m_e: k, exponent: e, damping_max_n_s_per_m: c, transition_m } = law;
    let force = |[delta, rate]: [f64; 2]| {
        let s = (delta / transition_m).min(1.0);
        k * delta.max(0.0).powf(e) + c * s * s * (3.0 - 2.0 * s) * rate
    };
    let slope = |y: [f64; 2]| [y[1], -force(y)];
    let step = |y: [f64; 2], h: f64| {
        let add_scaled = |a: [f64; 2], f: f64| [y[0] + f * a[0], y[1] + f * a[1]];
        let k1 = slope(y);
        let k2 = slope(add_scaled(k1, 0.5 * h));
        let k3 = slope(add_scaled(k2, 0.5 * h));
        let k4 = slope(add_scaled(k3, h));
        [0, 1].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    };
    let (mut y, mut t) = ([0.0, speed], 0.0);
    let (mut peak_n, mut depth_m): (f64, f64) = (0.0, 0.0);
    // A segment ends where δ rises to δ_max, where it falls back to δ_max, and where the force vanishes.
    loop {
        let is_beyond_transition = y[0] > transition_m || (y[0] == transition_m && y[1] > 0.0);
        let segment_end = |y: [f64; 2]| {
            let distance_to_transition = if is_beyond_transition { y[0] - transition_m } else { transition_m - y[0] };
            if y[1] < 0.0 { distance_to_transition.min(force(y) / k) } else { distance_to_transition }
        };
        let mut previous = y;
        loop {
            let next = step(y, h);
            if segment_end(next) < 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if segment_end(step(y, middle)) < 0.0 { high = middle } else { low = middle }
                }
                (y, t) = (step(y, high), t + high);
                break;
            }
            if y[1] > 0.0 && next[1] <= 0.0 {
                // The largest depth is where the rate is zero.
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if step(y, middle)[1] < 0.0 { high = middle } else { low = middle }
                }
                depth_m = step(y, low)[0];
            }
            // A force peak lies within two steps if the force between them is larger than at both ends.
            if force(y) >= force(previous) && force(y) > force(next) {
                let (mut low, mut high) = (0.0, 2.0 * h);
                for _ in 0..80 {
                    let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if force(step(previous, left)) < force(step(previous, right)) { low = left } else { high = right }
                }
                peak_n = peak_n.max(force(step(previous, low)));
            }
            (previous, y, t) = (y, next, t + h);
        }
        if y[1] < 0.0 && force(y) <= 1e-6 {
            let restitution = -y[1] / speed;
            let lost_j = 0.5 * speed * speed * (1.0 - restitution * restitution);
            return ImpactResult { contact_time_s: t, restitution, peak_n, depth_m, lost_j };
        }
        y[0] = transition_m;
    }
}

#[test]
fn the_analytic_model_matches_runge_kutta_for_spring_and_damper() {
    for speed in [0.5, 2.0] {
        let reference = impact_by_runge_kutta(&SPRING_AND_DAMPER, speed, 2e-7);
        let expected = impact_by_runge_kutta(&SPRING_AND_DAMPER, speed, 1e-7);
        assert!(max_relative_error(&reference, &expected) < 1e-10, "{reference:?} {expected:?}");
        let actual = simulated_impact(Model::Analytic, &impact_scene(SPRING_AND_DAMPER, speed, 30e-3), speed);
        let error = max_relative_error(&actual, &expected);
        println!("{speed} m/s: error {error:.1e}, expected {expected:?}");
        assert!(error < 1e-9, "{error:.1e}: {actual:?} {expected:?}");
        assert!(relative_error(actual.lost_j, expected.lost_j) < 1e-9);
    }
}

/// The engine with default settings, and with fixed steps, where it is of second order. Contact times are accurate to
/// one step.
#[test]
fn the_engine_converges_to_the_expected_impacts() {
    let mut cases: Vec<(NormalLaw, f64, ImpactResult)> = ELASTIC_CASES
        .iter()
        .map(|(k, e, speed)| (spring(*k, *e), *speed, elastic_impact(&spring(*k, *e), *speed)))
        .collect();
    cases.push((SPRING_AND_DAMPER, 1.0, impact_by_runge_kutta(&SPRING_AND_DAMPER, 1.0, 1e-7)));
    for (law, speed, expected) in cases {
        let scene = impact_scene(law, speed, 20e-3);
        let error = |scene: &Scene, step: f64| {
            let actual = simulated_impact(Model::Engine, scene, speed);
            let time_error = (actual.contact_time_s - expected.contact_time_s).abs();
            assert!(time_error <= step, "contact time error {time_error:e} s at steps of {step:e} s");
            let energy = 0.5 * speed * speed;
            [
                relative_error(actual.restitution, expected.restitution),
                relative_error(actual.peak_n, expected.peak_n),
                relative_error(actual.depth_m, expected.depth_m),
                (actual.lost_j - expected.lost_j).abs() / energy,
            ]
            .into_iter()
            .fold(0.0, f64::max)
        };
        let default = error(&scene, 6e-5);
        let [coarse, middle, fine] = [1e-4, 1e-5, 1e-6].map(|step| error(&with_fixed_step(&scene, step), step));
        println!(
            "e = {}, c = {}: default {default:.1e}, fixed {coarse:.1e} {middle:.1e} {fine:.1e}",
            law.exponent, law.damping_max_n_s_per_m
        );
        assert!(default < 5e-4 && coarse < 2e-3, "{default:e} {coarse:e}");
        assert!(middle < 1e-5 && fine < 2e-7, "{middle:e} {fine:e}");
    }
}

/// A stiff damper stops the disc in microseconds, much less than a step.
#[test]
fn the_engine_matches_the_closed_form_of_a_damper() {
    let law = NormalLaw { stiffness_n_per_m_e: 0.0, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };
    let scene = impact_scene(law, 1.0, 20e-3);
    let remaining_speed = |depth: f64| damped_speed(&law, 1.0, depth).abs();
    for (scene, bound) in
        [(scene.clone(), 2e-3), (with_fixed_step(&scene, 1e-5), 2e-3), (with_fixed_step(&scene, 1e-7), 2e-3)]
    {
        let (outcome, _) = run_to_end(Model::Engine, &scene);
        let final_speed = remaining_speed(outcome.contacts[0].max_penetration_m);
        println!("{final_speed:.1e} {:.1e}", relative_error(outcome.contacts[0].impulse_n_s, 1.0));
        assert!(final_speed < bound, "{final_speed:e} m/s is the closed-form speed at the final depth");
        assert!(relative_error(outcome.contacts[0].impulse_n_s, 1.0) < bound);
        assert!(relative_error(outcome.last.energy().dissipated_j, 0.5) < bound, "{:?}", outcome.last.energy());
    }
}
