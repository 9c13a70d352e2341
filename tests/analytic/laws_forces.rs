//! Contact forces on driven discs against the closed forms of the laws (thesis Appendix B.1.2, Figs. B.7–B.9). Head-on
//! impacts of a free disc on a fixed one: both models against closed forms and against a Runge–Kutta solution.

use crate::support::laws::{
    BOTH_MODELS, THESIS_FRICTION, THESIS_NORMAL, disc, driven, impact_scene, relative_error, run_to_end,
    sampled_at_steps, scene, scene_on_plane, spring, with_fixed_step,
};
use crate::support::runs::{assert_below, assert_near, assert_relative};
use phalanx::law::NormalLaw;
use phalanx::scene::{DiscMotion, Scene};
use phalanx::trace::{EventKind, Model};

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
                assert_near(contact.normal_n, expected_n, 1e-12 * expected_n + rounding + 1e-12, model.name());
                assert_eq!((contact.tangential_n, contact.slip_m_s), (0.0, 0.0));
                // The normal on the driven disc opposes its motion.
                assert!((contact.normal[0] + 1.0).abs() < 1e-15 && contact.normal[1] == 0.0);
            }
            assert_near(deepest, 0.02, 1e-12, "deepest sample");
            let summary = &outcome.contacts[0];
            assert_near(summary.first_s.expect("a contact"), 5e-3, 1e-12, "first contact");
            assert_relative(summary.peak_normal_n, k * 0.02f64.powf(e), 1e-12, "peak force");
            assert_near(summary.max_penetration_m, 0.02, 1e-14, "penetration");
            // At 1 m/s the work of the drive equals the impulse, and the spring stores it.
            let (impulse, energy) = (k * 0.02f64.powf(e + 1.0) / (e + 1.0), &outcome.last.energy());
            assert_relative(summary.impulse_n_s, impulse, 1e-5, "impulse");
            assert_relative(energy.motor_work_j, impulse, 1e-5, "work");
            assert_near(energy.balance_j, 0.0, 1e-12 * impulse, "balance");
        }
    }
}

/// Thesis Fig. B.8: damper only; c rises over the first δ_max as a smooth step.
#[test]
fn damper_force_is_c_of_delta_times_the_rate() {
    for transition_m in [1e-3, 1e-5] {
        let normal = NormalLaw::step(0.0, THESIS_NORMAL.exponent, THESIS_NORMAL.damping_max(), transition_m);
        // Both models take 20 steps within the transition.
        let step_s = transition_m / 20.0;
        let mut scene = with_fixed_step(&driven_contact_scene(normal), step_s);
        scene.duration_s = 5e-3 + 3.0 * transition_m;
        scene.log.numeric_hz = 1.0 / step_s;
        for model in BOTH_MODELS {
            let (outcome, log) = run_to_end(model, &sampled_at_steps(model, scene.clone()));
            let mut samples_in_transition = 0;
            for sample in &log.samples {
                let s = ((sample.time_s - 5e-3).max(0.0) / transition_m).min(1.0);
                samples_in_transition += u32::from(s > 0.0 && s < 1.0);
                let expected_n = 1e6 * s * s * (3.0 - 2.0 * s);
                let rounding = 1e6 * 6.0 * s * POSITION_ROUNDING / transition_m;
                assert_near(sample.contact(0).normal_n, expected_n, 1e-12 * expected_n + rounding, model.name());
            }
            assert!(samples_in_transition > 10, "{model:?}: {samples_in_transition} samples within the transition");
            assert_relative(outcome.contacts[0].peak_normal_n, 1e6, 1e-12, "peak force");
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
    let mut scene = scene_on_plane(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 0.1);
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
            assert_near(contact.slip_m_s, v, 1e-14, format!("{model:?}: slip"));
            assert_relative(contact.normal_n, normal, 1e-10, format!("{model:?}: normal force"));
            let context = format!("{model:?}: friction at {v} m/s");
            assert_near(contact.tangential_n, -mu * contact.normal_n, 1e-12 * normal, context);
        }
        assert_near(lowest, -0.3, 1e-12, "lowest slip");
        assert_eq!(highest, 0.3);
        assert!(log.events.iter().all(|event| event.kind == EventKind::TouchDown && event.time_s == 0.0));
    }
}

/// A disc that rotates without translation slips at −ω r along the tangent. Friction opposes the slip: it acts along the
/// tangent, which is −x.
#[test]
fn spin_causes_slip() {
    let motion = DiscMotion::Driven { velocity_m_s: [0.0; 2], acceleration_m_s2: [0.0; 2], spin_rad_s: 1.5 };
    let discs = vec![disc("wheel", 0.1, [0.0, 0.1 - 1e-5], motion)];
    let scene = scene_on_plane(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 10e-3);
    for model in BOTH_MODELS {
        let last = run_to_end(model, &sampled_at_steps(model, scene.clone())).0.last;
        let contact = last.contact(0);
        assert_near(contact.slip_m_s, -0.15, 1e-14, model.name());
        assert_near(contact.tangential_n / contact.normal_n, 0.68, 1e-12, model.name());
        assert_near(last.body(0).angle_rad, 0.015, 1e-13, model.name());
        assert_relative(last.energy().motor_work_j, contact.tangential_n * 0.15 * 10e-3, 1e-6, model.name());
    }
}

/// Results of an impact of 1 kg.
#[derive(Clone, Copy)]
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
    assert_eq!(summary.touchdowns, 1, "{model:?}");
    let contact_start_s = log.event_time_s(0, EventKind::TouchDown);
    assert_near(contact_start_s, 1e-3, 1e-12, model.name());
    let final_velocity = outcome.last.body(0).velocity_m_s;
    assert_eq!((final_velocity[1], outcome.last.body(0).spin_rad_s), (0.0, 0.0));
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

/// ∫₀¹ dx/√(1 − xᵖ) by Simpson's rule in u = √(1 − x), in which the integrand is smooth.
fn inverse_root_integral(p: f64) -> f64 {
    let f = |u: f64| if u == 0.0 { 2.0 / p.sqrt() } else { 2.0 * u / (-(p * (-u * u).ln_1p()).exp_m1()).sqrt() };
    let intervals = 20_000;
    let at = |i: u32, x: f64| f((f64::from(i) + x) / f64::from(intervals));
    let sum: f64 = (0..intervals).map(|i| at(i, 0.0) + 4.0 * at(i, 0.5) + at(i, 1.0)).sum();
    sum / (6.0 * f64::from(intervals))
}

/// Closed form for F = k δᵉ: depth from m v²/2 = k δᵉ⁺¹/(e + 1), contact time 2 (δ/v) ∫₀¹ dx/√(1 − xᵉ⁺¹).
fn elastic_impact(law: &NormalLaw, speed: f64) -> ImpactResult {
    let (k, e) = (law.stiffness_n_per_m_e, law.exponent);
    let depth_m = ((e + 1.0) * speed * speed / (2.0 * k)).powf(1.0 / (e + 1.0));
    ImpactResult {
        contact_time_s: 2.0 * depth_m / speed * inverse_root_integral(e + 1.0),
        restitution: 1.0,
        peak_n: k * depth_m.powf(e),
        depth_m,
        lost_j: 0.0,
    }
}

const ELASTIC_CASES: [(f64, f64, f64); 3] = [(1e8, 2.2, 1.0), (2e7, 1.5, 0.5), (1e6, 1.0, 2.0)];

/// Speed at a depth for k = 0: v(δ) = v₀ − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) up to δ_max; beyond, c_max/m (δ −
/// δ_max) less.
fn damped_speed(law: &NormalLaw, speed: f64, delta: f64) -> f64 {
    let (c, transition_end) = (law.damping_max(), law.depth_scale_m());
    let velocity_loss =
        |delta: f64| c * (delta.powi(3) / transition_end.powi(2) - delta.powi(4) / (2.0 * transition_end.powi(3)));
    speed - velocity_loss(delta.min(transition_end)) - c * (delta - transition_end).max(0.0)
}

#[test]
fn the_analytic_model_matches_the_closed_form_of_a_damper() {
    // The disc stops within the transition, and far beyond it.
    for (c, speed) in [(1e6, 1.0), (1e3, 1.0)] {
        let law = NormalLaw::step(0.0, 2.2, c, 1e-5);
        let (outcome, log) = run_to_end(Model::Analytic, &impact_scene(law, speed, 20e-3));
        let mut contact_samples = 0;
        for sample in &log.samples {
            let contact = sample.contact(0);
            let (delta, rate) = (-contact.gap_m, -contact.gap_rate_m_s);
            if delta > 0.0 {
                contact_samples += 1;
                assert_below((rate - damped_speed(&law, speed, delta)).abs(), 1e-9 * speed, format!("δ = {delta:e}"));
            }
        }
        assert!(contact_samples > 20);
        let loss_j = 0.5 * speed * speed;
        assert!(relative_error(outcome.last.energy().dissipated_j, loss_j) < 1e-9);
        assert!(outcome.last.energy().balance_j.abs() < 1e-10 * loss_j, "{:?}", outcome.last.energy());
    }
}

const SPRING_AND_DAMPER: NormalLaw = NormalLaw::step(1e8, 2.2, 200.0, 1e-4);

/// Impact of 1 kg on spring and damper by the classical Runge–Kutta method with fixed step. Bisection locates the end
/// of the transition and the lift-off. The laws are implemented independently of the library.
fn impact_by_runge_kutta(law: &NormalLaw, speed: f64, h: f64) -> ImpactResult {
    let (k, e, c, transition_m) = (law.stiffness_n_per_m_e, law.exponent, law.damping_max(), law.depth_scale_m());
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
    // Length of a step within `h` after which `is_past` becomes true, just before and just after.
    let bisect = |is_past: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, h);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_past(middle) { high = middle } else { low = middle }
        }
        (low, high)
    };
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
                let (_, high) = bisect(&|middle| segment_end(step(y, middle)) < 0.0);
                (y, t) = (step(y, high), t + high);
                break;
            }
            if y[1] > 0.0 && next[1] <= 0.0 {
                // The largest depth is where the rate is zero.
                depth_m = step(y, bisect(&|middle| step(y, middle)[1] < 0.0).0)[0];
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

/// Elastic impacts against closed forms, and impacts with a damper against Runge–Kutta: the analytic model, the engine
/// with default settings, and the engine with fixed steps, where it is of second order. Contact times of the engine are
/// accurate to one step.
#[test]
fn both_models_match_the_expected_impacts() {
    let damped_impact = |speed| {
        let [coarse, fine] = [2e-7, 1e-7].map(|h| impact_by_runge_kutta(&SPRING_AND_DAMPER, speed, h));
        assert_below(max_relative_error(&coarse, &fine), 1e-10, "Runge–Kutta with half the step");
        (SPRING_AND_DAMPER, speed, fine)
    };
    let elastic_impacts =
        ELASTIC_CASES.map(|(k, e, speed)| (spring(k, e), speed, elastic_impact(&spring(k, e), speed)));
    for (law, speed, expected) in elastic_impacts.into_iter().chain([0.5, 1.0, 2.0].map(damped_impact)) {
        let context = format!("e = {}, c = {}, {speed} m/s", law.exponent, law.damping_max());
        let lost_error_j = |actual: &ImpactResult| (actual.lost_j - expected.lost_j).abs();
        let scene = impact_scene(law, speed, 30e-3);
        let analytic = simulated_impact(Model::Analytic, &scene, speed);
        assert_below(max_relative_error(&analytic, &expected), 1e-9, &context);
        let lost_scale_j = if expected.lost_j == 0.0 { speed * speed } else { expected.lost_j };
        assert_below(lost_error_j(&analytic), 1e-9 * lost_scale_j, format!("{context}: lost energy"));
        if law == SPRING_AND_DAMPER && speed != 1.0 {
            continue;
        }
        let engine_error = |scene: &Scene, step: f64| {
            let actual = simulated_impact(Model::Engine, scene, speed);
            assert_near(
                actual.contact_time_s,
                expected.contact_time_s,
                step,
                format!("{context}, steps of {step:e} s"),
            );
            let without_time = ImpactResult { contact_time_s: expected.contact_time_s, ..actual };
            max_relative_error(&without_time, &expected).max(lost_error_j(&actual) / (0.5 * speed * speed))
        };
        assert_below(engine_error(&scene, 6e-5), 5e-4, format!("{context}, default steps"));
        for (step_s, bound) in [(1e-4, 2e-3), (1e-5, 1e-5), (1e-6, 2e-7)] {
            let error = engine_error(&with_fixed_step(&scene, step_s), step_s);
            assert_below(error, bound, format!("{context}, steps of {step_s:e} s"));
        }
    }
}

/// A stiff damper stops the disc in microseconds, much less than a step.
#[test]
fn the_engine_matches_the_closed_form_of_a_damper() {
    let law = NormalLaw::step(0.0, 2.2, 1e6, 1e-5);
    let scene = impact_scene(law, 1.0, 20e-3);
    for scene in [scene.clone(), with_fixed_step(&scene, 1e-5), with_fixed_step(&scene, 1e-7)] {
        let (outcome, _) = run_to_end(Model::Engine, &scene);
        let (contact, stepping) = (&outcome.contacts[0], format!("{:?}", scene.engine.stepping));
        // The closed-form speed at the final depth.
        assert_below(damped_speed(&law, 1.0, contact.max_penetration_m).abs(), 2e-3, &stepping);
        assert_below(relative_error(contact.impulse_n_s, 1.0), 2e-3, &stepping);
        assert_below(relative_error(outcome.last.energy().dissipated_j, 0.5), 2e-3, &stepping);
    }
}
