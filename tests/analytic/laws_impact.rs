//! A free disc on a fixed one, head on: both models against closed forms, and against an ODE solved here.

use std::f64::consts::PI;

use crate::support::laws::{complete, gamma, impact, relative, spring, stepped};
use phalanx::law::NormalLaw;
use phalanx::scene::Scene;
use phalanx::trace::{EventKind, Model};

/// What an impact of 1 kg comes down to.
#[derive(Clone, Copy, Debug)]
struct Figures {
    contact_time_s: f64,
    restitution: f64,
    peak_n: f64,
    depth_m: f64,
    lost_j: f64,
}

fn figures(model: Model, scene: &Scene, speed: f64) -> Figures {
    let (outcome, log) = complete(model, scene);
    let summary = &outcome.contacts[0];
    assert_eq!(summary.touchdowns, 1, "{}", model.name());
    let touch = log.time(0, EventKind::TouchDown);
    assert!((touch - 1e-3).abs() < 1e-12, "{}: {touch:e}", model.name());
    let back = outcome.last.bodies[1].velocity_m_s;
    assert_eq!((back[1], outcome.last.bodies[1].spin_rad_s), (0.0, 0.0));
    Figures {
        contact_time_s: log.time(0, EventKind::LiftOff) - touch,
        restitution: -back[0] / speed,
        peak_n: summary.peak_normal_n,
        depth_m: summary.max_penetration_m,
        lost_j: outcome.last.energy.dissipated_j,
    }
}

/// Largest relative difference of contact time, restitution, peak force and depth.
fn worst(got: &Figures, want: &Figures) -> f64 {
    let pairs = [
        (got.contact_time_s, want.contact_time_s),
        (got.restitution, want.restitution),
        (got.peak_n, want.peak_n),
        (got.depth_m, want.depth_m),
    ];
    pairs.into_iter().map(|(got, want)| relative(got, want)).fold(0.0, f64::max)
}

/// F = k δᵉ: depth from m v²/2 = k δᵉ⁺¹/(e + 1), time 2 (δ/v) ∫₀¹ dx/√(1 − xᵉ⁺¹).
fn elastic(law: &NormalLaw, speed: f64) -> Figures {
    let (k, e) = (law.stiffness_n_per_m_e, law.exponent);
    let depth_m = ((e + 1.0) * speed * speed / (2.0 * k)).powf(1.0 / (e + 1.0));
    let share = 1.0 / (e + 1.0);
    Figures {
        contact_time_s: 2.0 * depth_m / speed * PI.sqrt() * gamma(1.0 + share) / gamma(0.5 + share),
        restitution: 1.0,
        peak_n: k * depth_m.powf(e),
        depth_m,
        lost_j: 0.0,
    }
}

const ELASTIC: [(f64, f64, f64); 3] = [(1e8, 2.2, 1.0), (2e7, 1.5, 0.5), (1e6, 1.0, 2.0)];

#[test]
fn the_analytic_model_gives_an_elastic_impact_back() {
    for (k, e, speed) in ELASTIC {
        let law = spring(k, e);
        let got = figures(Model::Analytic, &impact(law, speed, 20e-3), speed);
        let error = worst(&got, &elastic(&law, speed));
        println!("e = {e}: {error:.1e}, lost {:.1e} J", got.lost_j);
        assert!(error < 1e-9, "e = {e}: {error:.1e}: {got:?} {:?}", elastic(&law, speed));
        assert!(got.lost_j.abs() < 1e-9 * speed * speed, "{got:?}");
    }
}

/// k = 0: v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) up to δ_max, and on from there by c_max/m (δ − δ_max).
fn damped(law: &NormalLaw, speed: f64, delta: f64) -> f64 {
    let (c, full) = (law.damping_max_n_s_per_m, law.transition_m);
    let within = |delta: f64| c * (delta.powi(3) / full.powi(2) - delta.powi(4) / (2.0 * full.powi(3)));
    speed - within(delta.min(full)) - c * (delta - full).max(0.0)
}

#[test]
fn the_analytic_model_stops_in_a_damper_where_the_closed_form_says() {
    // Stopped within the transition, and far beyond it.
    for (c, speed) in [(1e6, 1.0), (1e3, 1.0)] {
        let law = NormalLaw { stiffness_n_per_m_e: 0.0, exponent: 2.2, damping_max_n_s_per_m: c, transition_m: 1e-5 };
        let (outcome, log) = complete(Model::Analytic, &impact(law, speed, 20e-3));
        let mut inside = 0;
        for sample in &log.samples {
            let contact = &sample.contacts[0];
            let (delta, rate) = (-contact.gap_m, -contact.gap_rate_m_s);
            if delta > 0.0 {
                inside += 1;
                let closed = damped(&law, speed, delta);
                assert!((rate - closed).abs() < 1e-9 * speed, "δ = {delta:e}: {rate} {closed}");
            }
        }
        assert!(inside > 20);
        let lost = 0.5 * speed * speed;
        assert!(relative(outcome.last.energy.dissipated_j, lost) < 1e-9);
        assert!(outcome.last.energy.balance_j.abs() < 1e-10 * lost, "{:?}", outcome.last.energy);
    }
}

const BOTH_PARTS: NormalLaw =
    NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 200.0, transition_m: 1e-4 };

/// Spring and damper on 1 kg by classical Runge–Kutta of fixed step, with the transition's end and the lift-off landed on by
/// bisection; written without the library's laws.
fn by_runge_kutta(law: &NormalLaw, speed: f64, h: f64) -> Figures {
    let &NormalLaw { stiffness_n_per_m_e: k, exponent: e, damping_max_n_s_per_m: c, transition_m } = law;
    let force = |[delta, rate]: [f64; 2]| {
        let s = (delta / transition_m).min(1.0);
        k * delta.max(0.0).powf(e) + c * s * s * (3.0 - 2.0 * s) * rate
    };
    let slope = |y: [f64; 2]| [y[1], -force(y)];
    let step = |y: [f64; 2], h: f64| {
        let plus = |a: [f64; 2], f: f64| [y[0] + f * a[0], y[1] + f * a[1]];
        let k1 = slope(y);
        let k2 = slope(plus(k1, 0.5 * h));
        let k3 = slope(plus(k2, 0.5 * h));
        let k4 = slope(plus(k3, h));
        [0, 1].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    };
    let (mut y, mut t) = ([0.0, speed], 0.0);
    let (mut peak_n, mut depth_m): (f64, f64) = (0.0, 0.0);
    // What ends each piece: δ rises to δ_max, falls back to it, and the force ends (in whichever piece).
    loop {
        let deep = y[0] > transition_m || (y[0] == transition_m && y[1] > 0.0);
        let ends = |y: [f64; 2]| {
            let beyond = if deep { y[0] - transition_m } else { transition_m - y[0] };
            if y[1] < 0.0 { beyond.min(force(y) / k) } else { beyond }
        };
        let mut behind = y;
        loop {
            let next = step(y, h);
            if ends(next) < 0.0 {
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if ends(step(y, middle)) < 0.0 { high = middle } else { low = middle }
                }
                (y, t) = (step(y, high), t + high);
                break;
            }
            if y[1] > 0.0 && next[1] <= 0.0 {
                // The depth, where the rate is zero.
                let (mut low, mut high) = (0.0, h);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if step(y, middle)[1] < 0.0 { high = middle } else { low = middle }
                }
                depth_m = step(y, low)[0];
            }
            // The largest force within two steps whose middle is higher than both ends.
            if force(y) >= force(behind) && force(y) > force(next) {
                let (mut low, mut high) = (0.0, 2.0 * h);
                for _ in 0..80 {
                    let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if force(step(behind, left)) < force(step(behind, right)) { low = left } else { high = right }
                }
                peak_n = peak_n.max(force(step(behind, low)));
            }
            (behind, y, t) = (y, next, t + h);
        }
        if y[1] < 0.0 && force(y) <= 1e-6 {
            let restitution = -y[1] / speed;
            let lost_j = 0.5 * speed * speed * (1.0 - restitution * restitution);
            return Figures { contact_time_s: t, restitution, peak_n, depth_m, lost_j };
        }
        y[0] = transition_m;
    }
}

#[test]
fn the_analytic_model_agrees_with_another_method_on_spring_and_damper() {
    for speed in [0.5, 2.0] {
        let reference = by_runge_kutta(&BOTH_PARTS, speed, 2e-7);
        let finer = by_runge_kutta(&BOTH_PARTS, speed, 1e-7);
        assert!(worst(&reference, &finer) < 1e-10, "{reference:?} {finer:?}");
        let got = figures(Model::Analytic, &impact(BOTH_PARTS, speed, 30e-3), speed);
        let error = worst(&got, &finer);
        println!("{speed} m/s: {error:.1e} {finer:?}");
        assert!(error < 1e-9, "{error:.1e}: {got:?} {finer:?}");
        assert!(relative(got.lost_j, finer.lost_j) < 1e-9);
    }
}

/// The engine at its defaults, and with fixed steps that become shorter: second order. Its contact times are those of its
/// steps.
#[test]
fn the_engine_converges_to_the_same_impacts() {
    let mut cases: Vec<(NormalLaw, f64, Figures)> =
        ELASTIC.iter().map(|(k, e, speed)| (spring(*k, *e), *speed, elastic(&spring(*k, *e), *speed))).collect();
    cases.push((BOTH_PARTS, 1.0, by_runge_kutta(&BOTH_PARTS, 1.0, 1e-7)));
    for (law, speed, wanted) in cases {
        let scene = impact(law, speed, 20e-3);
        let error = |scene: &Scene, step: f64| {
            let got = figures(Model::Engine, scene, speed);
            let late = (got.contact_time_s - wanted.contact_time_s).abs();
            assert!(late <= step, "contact time is off by {late:e} s at steps of {step:e} s");
            let energy = 0.5 * speed * speed;
            [
                relative(got.restitution, wanted.restitution),
                relative(got.peak_n, wanted.peak_n),
                relative(got.depth_m, wanted.depth_m),
                (got.lost_j - wanted.lost_j).abs() / energy,
            ]
            .into_iter()
            .fold(0.0, f64::max)
        };
        let default = error(&scene, 6e-5);
        let [coarse, middle, fine] = [1e-4, 1e-5, 1e-6].map(|step| error(&stepped(&scene, step), step));
        println!(
            "e = {}, c = {}: default {default:.1e}, fixed {coarse:.1e} {middle:.1e} {fine:.1e}",
            law.exponent, law.damping_max_n_s_per_m
        );
        assert!(default < 5e-4 && coarse < 2e-3, "{default:e} {coarse:e}");
        assert!(middle < 1e-5 && fine < 2e-7, "{middle:e} {fine:e}");
    }
}

/// A stiff damper: stopped in microseconds, far within one step.
#[test]
fn the_engine_stops_in_a_damper() {
    let law = NormalLaw { stiffness_n_per_m_e: 0.0, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };
    let scene = impact(law, 1.0, 20e-3);
    let closed = |depth: f64| damped(&law, 1.0, depth).abs();
    for (scene, bound) in [(scene.clone(), 2e-3), (stepped(&scene, 1e-5), 2e-3), (stepped(&scene, 1e-7), 2e-3)] {
        let (outcome, _) = complete(Model::Engine, &scene);
        let left = closed(outcome.contacts[0].max_penetration_m);
        println!("{left:.1e} {:.1e}", relative(outcome.contacts[0].impulse_n_s, 1.0));
        assert!(left < bound, "{left:e} of the speed is left at the depth it stops at");
        assert!(relative(outcome.contacts[0].impulse_n_s, 1.0) < bound);
        assert!(relative(outcome.last.energy.dissipated_j, 0.5) < bound, "{:?}", outcome.last.energy);
    }
}
