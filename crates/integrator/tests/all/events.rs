//! Events: their location is accurate, none is missed, and simultaneous events are handled. Impacts of one mass on a wall
//! against closed forms.

use crate::wall::{
    Branch, OBJECT, Obstacle, PointMass, Wall, free_fall, free_flight, mass_at, plate, run, run_from, tight,
};
use phalanx_integrator::{Options, Tolerances};
use phalanx_mechanics::law::{NormalLaw, elastic_energy};

const ELASTIC: NormalLaw = OBJECT.with_damping_max(0.0);

/// Loose tolerances: event location must not depend on small steps.
fn loose() -> Options {
    Options { tolerances: Tolerances { atol_q: 1e-7, atol_v: 1e-3, rtol_v: 1e-3 }, ..tight() }
}

/// A fall onto a plate: t = √(2h/g). An oscillation x = a cos ωt against a plate at a/2: t = π/(3ω).
#[test]
fn contact_times_are_exact() {
    type Field = fn(f64, f64, f64) -> [f64; 4];
    let oscillation: Field = |_, x, _| [-1e4 * x, 0.0, -1e4, 0.0];
    let options = Options { tolerances: Tolerances { atol_q: 1e-16, atol_v: 1e-14, rtol_v: 1e-14 }, ..tight() };
    for i in 1..=40 {
        let start = 1e-3 * f64::from(i);
        for (field, wall_position, time) in [
            (free_fall as Field, 0.0, (2.0 * start / 9.81).sqrt()),
            (oscillation, 0.5 * start, std::f64::consts::PI / 300.0),
        ] {
            let system = PointMass::new(field, [plate(wall_position, 1.0, OBJECT, 1e-16)]);
            for (name, _, log) in run_from(&system, options, [start, 0.0], time + 1e-6) {
                let contact_times = log.contact_times(0);
                assert!((contact_times[0] - time).abs() < 1e-14, "{name}: {contact_times:?} {time}");
            }
        }
    }
}

/// Events are located within the requested tolerance, also if the root search hits the zero of the gap exactly.
#[test]
fn events_are_located_within_their_tolerance() {
    let damped_fall = |_: f64, x: f64, v: f64| [-9.81 - 3.0 * v - 40.0 * x, 0.0, -40.0, -3.0];
    let system = PointMass::new(damped_fall, [plate(0.0, 1.0, OBJECT, 1e-10)]);
    for i in 0..400 {
        let height = 1e-3 + 1e-4 * f64::from(i);
        for options in [tight(), loose()] {
            for (name, _, log) in run_from(&system, options, [height, -0.5], 0.12) {
                let time = log.contact_times(0)[0];
                let end_state = log.steps.iter().find(|s| s.0 == time).expect("a step that ends on the contact");
                assert!(end_state.1.abs() <= 1e-10, "{name}: contact at a gap of {:e} m", end_state.1);
            }
        }
    }
}

/// An obstacle as thin as 1 µm, hit at 5 m/s with steps of milliseconds, at any position within the step.
#[test]
fn thin_obstacles_are_not_missed() {
    for half in [1e-4, 1e-5, 1e-6] {
        for i in 0..200 {
            let wall_position = 1e-3 + 0.4e-3 * f64::from(i);
            let obstacle = Obstacle::Window { position: wall_position, half };
            // Ten times the stiffness that would stop 0.02 kg at 5 m/s in the middle of the obstacle.
            let stiffness_n_per_m_e = 10.0 * 0.25 * 3.2 / half.powf(3.2);
            let law = NormalLaw { stiffness_n_per_m_e, ..ELASTIC };
            let system = PointMass::new(free_flight, [Wall { obstacle, law, location_tolerance_m: 1e-12 }]);
            for (name, end, log) in run_from(&system, loose(), [0.0, 5.0], 0.03) {
                let contact_times = log.contact_times(0);
                assert_eq!(contact_times.len(), 1, "{name}: obstacle of half width {half:e} m at {wall_position} m");
                assert!((contact_times[0] - (wall_position - half) / 5.0).abs() < 1e-12, "{name}: {contact_times:?}");
                assert!((end.state.v[0] + 5.0).abs() < 0.5, "{name}: passed through with {}", end.state.v[0]);
            }
        }
    }
}

/// x = g (t − t0)²/2 grazes the wall at t0 and must not be disturbed. A slightly lower path must not gain energy.
#[test]
fn grazing_contact_does_not_disturb_a_mass() {
    let system = PointMass::new(|_, _, _| [10.0, 0.0, 0.0, 0.0], [plate(0.0, 1.0, OBJECT, 1e-10)]);
    for t0 in [1e-2, 3e-2, 0.1] {
        for (below, free) in [(0.0, true), (-1e-12, true), (1e-9, false)] {
            let start = [5.0 * t0 * t0 - below, -10.0 * t0];
            for (name, end, log) in run_from(&system, tight(), start, 2.0 * t0) {
                let (x, v) = (end.state.q[0], end.state.v[0]);
                let contact_times = log.contact_times(0).len();
                assert!(x.is_finite() && v.is_finite());
                if free {
                    assert!((v - 10.0 * t0).abs() < 1e-6 * t0, "{name}: {v} {contact_times}");
                } else {
                    assert!(contact_times >= 1, "{name}: contact not detected");
                    // The wall does not pull, and returns no more energy than it absorbed.
                    let [before, after] = [start, [x, v]].map(|[x, v]| 0.5 * v * v - 10.0 * x);
                    assert!(after <= before + 1e-13, "{name}: {before:e} {after:e}");
                    assert!(log.steps.iter().all(|s| s.1 > -1.01e-9), "{name}: deeper than the free path");
                }
            }
        }
    }
}

/// Two walls at the same position act as one wall of twice the stiffness and damping, and both report their contact.
#[test]
fn two_contacts_may_begin_simultaneously() {
    let doubled_law = NormalLaw {
        stiffness_n_per_m_e: 2.0 * OBJECT.stiffness_n_per_m_e,
        ..OBJECT.with_damping_max(2.0 * OBJECT.damping_max())
    };
    let single_wall = PointMass::new(free_fall, [plate(0.0, 1.0, doubled_law, 1e-10)]);
    let double_wall = PointMass::new(free_fall, [plate(0.0, 1.0, OBJECT, 1e-10); 2]);
    let single = run_from(&single_wall, tight(), [0.01, -1.0], 0.02);
    let double = run_from(&double_wall, tight(), [0.01, -1.0], 0.02);
    for ((name, a, _), (_, b, log)) in single.into_iter().zip(double) {
        let (first, second) = (log.contact_times(0)[0], log.contact_times(1)[0]);
        assert!((first - second).abs() < 1e-10, "{name}: {first} {second}");
        let (dx, dv) = (a.state.q[0] - b.state.q[0], a.state.v[0] - b.state.v[0]);
        assert!(dx.abs() < 1e-10 && dv.abs() < 1e-8, "{name}: {dx:e} {dv:e}");
        assert!((a.state.z[0] - b.state.z[0]).abs() < 1e-9);
    }
}

/// Alternating contacts with opposite walls.
#[test]
fn a_mass_bounces_between_two_elastic_walls_without_loss() {
    let law = NormalLaw { stiffness_n_per_m_e: 1e14, ..ELASTIC };
    let walls = [plate(0.0, 1.0, law, 1e-12), plate(1e-3, -1.0, law, 1e-12)];
    for (name, end, log) in run_from(&PointMass::new(free_flight, walls), tight(), [5e-4, 1.0], 80e-3) {
        let counts = [0, 1].map(|wall| log.contact_times(wall).len());
        assert!(counts[0] > 30 && counts[0].abs_diff(counts[1]) <= 1, "{name}: {counts:?}");
        assert!(log.events.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert!(log.events.iter().all(|e| e.2 != Branch::Clamped));
        assert!((end.state.v[0].abs() - 1.0).abs() < 1e-8, "{name}: {}", end.state.v[0]);
    }
}

/// An acceleration that jumps from +3 to −5 m/s²: a step ends exactly on the discontinuity, and the motion consists of
/// two parabolas.
#[test]
fn steps_end_exactly_on_discontinuities() {
    let discontinuity = 0.0123;
    let steps = |t: f64, _: f64, _: f64| [if t < discontinuity { 3.0 } else { -5.0 }, 0.0, 0.0, 0.0];
    let walls = [plate(-1.0, 1.0, OBJECT, 1e-10)];
    let system = PointMass { discontinuities: vec![discontinuity], ..PointMass::new(steps, walls) };
    for options in [tight(), loose()] {
        for (name, end, log) in run_from(&system, options, [0.01, 0.1], 0.05) {
            assert!(log.steps.iter().any(|s| s.0 == discontinuity), "{name}: no step ends on the discontinuity");
            let (v1, rest) = (0.1 + 3.0 * discontinuity, 0.05 - discontinuity);
            let x1 = 0.01 + 0.1 * discontinuity + 1.5 * discontinuity * discontinuity;
            let (x, v) = (x1 + v1 * rest - 2.5 * rest * rest, v1 - 5.0 * rest);
            let off = [end.state.q[0] - x, end.state.v[0] - v];
            assert!(off[0].abs() < 1e-15 && off[1].abs() < 1e-14, "{name}: {off:?}");
            assert_eq!(end.time_s, 0.05);
        }
    }
}

/// A spring and damper with a linear force.
fn linear_law(transition_m: f64) -> NormalLaw {
    NormalLaw::step(returning_force::STIFFNESS, 1.0, returning_force::DAMPING, transition_m)
}

/// A soft contact whose free motion is a cubic in time: with κ = k/c and the time τ relative to the force maximum, δ =
/// δ₀ (1 − κτ + κ²τ²/2) + ετ − (2β + κ³δ₀) τ³/6, so that (k δ + c δ̇)/c = ε (1 + κτ) − βτ² − κ (2β + κ³δ₀) τ³/6. The
/// force is positive only while |τ| < √(ε/β), to a few parts in a thousand. Steps of any size are exact.
mod returning_force {
    pub const STIFFNESS: f64 = 1e4;
    pub const DAMPING: f64 = 20.0;
    const KAPPA: f64 = STIFFNESS / DAMPING;
    const DEPTH: f64 = 1e-4;
    const BETA: f64 = 2.5e5;
    const JERK: f64 = 2.0 * BETA + KAPPA * KAPPA * KAPPA * DEPTH;
    pub const FORCE_MAXIMUM_S: f64 = 2e-4;

    /// Acceleration and its derivatives.
    pub fn forcing(t: f64, _: f64, _: f64) -> [f64; 4] {
        [-KAPPA * KAPPA * DEPTH + JERK * (t - FORCE_MAXIMUM_S), JERK, 0.0, 0.0]
    }

    /// Position x = −δ at time `t`, and its rate.
    pub fn start(t: f64, half: f64) -> [f64; 2] {
        let (tau, rise) = (t - FORCE_MAXIMUM_S, BETA * half * half);
        let depth = DEPTH * (1.0 - KAPPA * tau + 0.5 * (KAPPA * tau).powi(2)) + rise * tau - JERK * tau.powi(3) / 6.0;
        let rate = -KAPPA * DEPTH * (1.0 - KAPPA * tau) + rise - 0.5 * JERK * tau * tau;
        [-depth, -rate]
    }
}

/// A released contact becomes active again for a few microseconds at any position within a step of 0.3 ms: the
/// beginning and end are located, and a run with tiny steps finds the same events.
#[test]
fn forces_that_return_for_microseconds_within_a_step_are_detected() {
    const MAXIMUM_S: f64 = returning_force::FORCE_MAXIMUM_S;
    let system = PointMass::new(returning_force::forcing, [plate(0.0, 1.0, linear_law(1e-6), 1e-12)]);
    let discontinuities = (-2000..4000).map(|i| 1e-7 * f64::from(i)).collect();
    let with_tiny_steps = PointMass { discontinuities, ..PointMass::new(returning_force::forcing, system.walls) };
    let mut thetas = Vec::new();
    for half in [5e-6, 2e-6, 5e-7] {
        // Steps grow from 10 ns by a factor of eight: the step that contains the force maximum begins 47 µs after the
        // start and is 328 µs long.
        for i in 0..80 {
            let t0 = -1.72e-4 + 4e-6 * f64::from(i);
            let [x, v] = returning_force::start(t0, half);
            for (system, options) in [(&system, tight()), (&system, loose()), (&with_tiny_steps, tight())] {
                if !system.discontinuities.is_empty() && i % 20 > 0 {
                    continue;
                }
                for (name, end, log) in run(system, options, (t0, mass_at(x, v)), 4e-4) {
                    let mut step_ends = log.steps.iter().rev().map(|step| step.0);
                    let before = step_ends.find(|t| *t < MAXIMUM_S - 2.0 * half);
                    let theta = (MAXIMUM_S - before.unwrap_or(t0)) / 3.28e-4;
                    thetas.push(theta);
                    let context = format!("{name}: half {half:e} at {theta} of a step: {:?}", log.events);
                    assert_eq!(log.branches(), [Branch::Active, Branch::Released], "{context}");
                    assert_eq!(end.counters.events, 2);
                    for (event, time) in log.events.iter().zip([MAXIMUM_S - half, MAXIMUM_S + half]) {
                        assert!((event.0 - time).abs() < 0.01 * half, "{context}");
                    }
                }
            }
        }
    }
    let interior = thetas.iter().filter(|theta| **theta > 0.05 && **theta < 0.95).count();
    assert!(2 * interior > thetas.len(), "the steps are too short for a test: {interior} of {}", thetas.len());
}

/// A linear spring with a damper that fades with the square of the depth: a rebounding mass is released at a large
/// depth, and the contact is active again over the last (k/3c) δ_max²/v before separation.
#[test]
fn forces_that_return_just_before_separation_are_detected() {
    use returning_force::{DAMPING, STIFFNESS};
    for transition_m in [1e-4, 1e-5, 1e-6] {
        let system = PointMass::new(free_flight, [plate(0.0, 1.0, linear_law(transition_m), 1e-12)]);
        let discontinuities = (0..5000).map(|i| 2e-6 * f64::from(i)).collect();
        let with_tiny_steps = PointMass { discontinuities, ..PointMass::new(free_flight, system.walls) };
        for i in 0..40 {
            let speed = 0.5 + 0.05 * f64::from(i);
            for (system, options) in [(&system, tight()), (&system, loose()), (&with_tiny_steps, tight())] {
                if !system.discontinuities.is_empty() && i % 10 > 0 {
                    continue;
                }
                for (name, _, log) in run_from(system, options, [1e-4, -speed], 1e-2) {
                    let expected = [Branch::Active, Branch::Released, Branch::Active, Branch::Released];
                    let context = format!("{name}: δ_max {transition_m:e} at {speed}: {:?}", log.events);
                    assert_eq!(log.branches(), expected, "{context}");
                    // The free flight between release and reloading ends where k δ = c σ(δ/δ_max) v.
                    let release = log.steps.iter().find(|step| step.0 == log.events[1].0).expect("a step to the event");
                    let speed_away = release.2;
                    let ratio = STIFFNESS * transition_m / (DAMPING * speed_away);
                    let s = 2.0 * ratio / (3.0 + (9.0 - 8.0 * ratio).sqrt());
                    let flight = (-release.1 - s * transition_m) / speed_away;
                    let return_time = log.events[2].0 - log.events[1].0;
                    // A released contact reloads at 3 nN; the spring reaches that force after this delay.
                    let (contact_time, reload_delay) = (s * transition_m / speed_away, 6e-9 / STIFFNESS / speed_away);
                    assert!((return_time - flight).abs() < 1e-3 * contact_time + reload_delay, "{context}: {flight:e}");
                }
            }
        }
    }
}

/// Damper alone, no external force: v(δ) = v0 − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) for δ ≤ δ_max, since m dv/dδ =
/// −c(δ).
#[test]
fn a_damper_alone_decelerates_a_mass_along_the_closed_form() {
    let law = NormalLaw { stiffness_n_per_m_e: 0.0, ..OBJECT };
    for (mass, v0) in [(0.02, 2.0), (0.02, 0.01), (5e-3, 7.0), (2.0, 1.5)] {
        let system = PointMass { mass, ..PointMass::new(free_flight, [plate(0.0, 1.0, law, 1e-10)]) };
        for (name, end, log) in run_from(&system, tight(), [1e-3, -v0], 1e-3 / v0 + 1e-3) {
            for (_, x, v) in &log.steps {
                let s = (-x).max(0.0) / law.depth_scale_m();
                assert!(s < 1.0);
                let expected = v0 - law.damping_max() / mass * law.depth_scale_m() * (s.powi(3) - 0.5 * s.powi(4));
                assert!((-v - expected).abs() < 1e-9 * v0, "{name}: {v:e} at {x:e}");
            }
            // The impulse equals the momentum lost, and the work equals the energy lost.
            let (v, [impulse, work]) = (end.state.v[0], end.state.z);
            let lost = 0.5 * mass * (v * v - v0 * v0);
            assert!((impulse - mass * (v + v0)).abs() < 1e-9 * mass * v0, "{name}: {impulse:e}");
            assert!((work - lost).abs() < 1e-9 * mass * v0 * v0, "{name}: {work:e} {lost:e}");
        }
    }
}

/// Without a damper the wall returns the energy it stores: the height is preserved over a hundred rebounds under
/// gravity.
#[test]
fn a_spring_alone_conserves_energy_over_a_hundred_rebounds() {
    let system = PointMass::new(free_fall, [plate(0.0, 1.0, ELASTIC, 1e-10)]);
    let height = 0.01;
    let period = 2.0 * (2.0 * height / 9.81f64).sqrt();
    // Longer than 100 flights, because the contacts also take time.
    for (name, end, log) in run_from(&system, tight(), [height, 0.0], 110.0 * period) {
        let (x, v) = (end.state.q[0], end.state.v[0]);
        let energy = 0.5 * v * v + 9.81 * x + elastic_energy(&ELASTIC, -x) / 0.02;
        let drift = energy / (9.81 * height) - 1.0;
        assert!(log.contact_times(0).len() >= 100, "{name}: {}", log.contact_times(0).len());
        assert!(drift.abs() < 1e-8, "{name}: {drift:e}");
    }
}

/// One rebound of the spring alone: the speed is restored, and the largest depth satisfies ½ m v² = k δᵉ⁺¹/(e + 1).
#[test]
fn one_rebound_returns_the_speed() {
    let (mass, v0) = (0.02, 2.0);
    let system = PointMass::new(free_flight, [plate(0.0, 1.0, ELASTIC, 1e-10)]);
    for (name, end, log) in run_from(&system, tight(), [1e-3, -v0], 5e-3) {
        let deepest = log.steps.iter().map(|s| -s.1).fold(0.0, f64::max);
        let expected = (0.5 * mass * v0 * v0 * 3.2 / ELASTIC.stiffness_n_per_m_e).powf(1.0 / 3.2);
        assert!((end.state.v[0] - v0).abs() < 1e-9 * v0, "{name}: {}", end.state.v[0]);
        assert!((end.state.z[0] - 2.0 * mass * v0).abs() < 1e-10);
        assert!(deepest <= expected * (1.0 + 1e-9) && deepest > 0.99 * expected, "{name}: {deepest:e} {expected:e}");
        assert_eq!(log.branches(), [Branch::Active, Branch::Released]);
    }
}
