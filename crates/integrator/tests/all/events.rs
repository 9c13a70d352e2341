//! Events: their location is accurate, none is missed, and simultaneous events are handled.

use crate::wall::{Branch, Log, OBJECT, Obstacle, PointMass, Wall, mass_at, tight, with_both_methods};
use phalanx_integrator::{Options, Tolerances};
use phalanx_mechanics::law::NormalLaw;

const ELASTIC: NormalLaw = NormalLaw { damping_max_n_s_per_m: 0.0, ..OBJECT };

fn plate(position: f64, side: f64, law: NormalLaw, location_tolerance_m: f64) -> Wall {
    Wall { obstacle: Obstacle::Plate { position, side }, law, location_tolerance_m }
}

/// Loose tolerances: event location must not depend on small steps.
fn loose() -> Options {
    Options { tolerances: Tolerances { atol_q: 1e-7, atol_v: 1e-3, rtol_v: 1e-3 }, ..tight() }
}

/// A fall onto a plate: t = √(2h/g). An oscillation x = a cos ωt against a plate at a/2: t = π/(3ω).
#[test]
fn contact_times_are_exact() {
    let free_fall: crate::wall::Field = |_, _, _| [-9.81, 0.0, 0.0, 0.0];
    let oscillation: crate::wall::Field = |_, x, _| [-1e4 * x, 0.0, -1e4, 0.0];
    let mut cases = Vec::new();
    for i in 1..=40 {
        let height = 1e-3 * f64::from(i);
        cases.push((free_fall, height, 0.0, (2.0 * height / 9.81).sqrt()));
    }
    for i in 1..=40 {
        let amplitude = 1e-3 * f64::from(i);
        cases.push((oscillation, amplitude, 0.5 * amplitude, std::f64::consts::PI / 300.0));
    }
    let mut worst = [0.0f64; 2];
    for (field, start, wall_position, time) in cases {
        let options = Options { tolerances: Tolerances { atol_q: 1e-16, atol_v: 1e-14, rtol_v: 1e-14 }, ..tight() };
        let system =
            PointMass { mass: 0.02, field, discontinuities: vec![], walls: [plate(wall_position, 1.0, OBJECT, 1e-16)] };
        for (i, (name, end, log)) in
            with_both_methods!(&system, options, mass_at(start, 0.0), time + 1e-6).into_iter().enumerate()
        {
            assert!(end.result.is_ok(), "{name}: {:?}", end.result);
            let contact_times = log.contact_times(0);
            assert!(!contact_times.is_empty(), "{name}: no contact at {time}");
            worst[i] = worst[i].max((contact_times[0] - time).abs());
        }
    }
    println!("contact times: Rodas5P {:.1e} s, Radau IIA {:.1e} s", worst[0], worst[1]);
    assert!(worst.iter().all(|w| *w < 1e-14), "{worst:?}");
}

/// Events are located within the requested tolerance, also if the root search hits the zero of the gap exactly.
#[test]
fn events_are_located_within_their_tolerance() {
    let damped_fall: crate::wall::Field = |_, x, v| [-9.81 - 3.0 * v - 40.0 * x, 0.0, -40.0, -3.0];
    let mut worst = 0.0f64;
    for i in 0..400 {
        let location_tolerance = 1e-10;
        let system = PointMass {
            mass: 0.02,
            field: damped_fall,
            discontinuities: vec![],
            walls: [plate(0.0, 1.0, OBJECT, location_tolerance)],
        };
        let height = 1e-3 + 1e-4 * f64::from(i);
        for options in [tight(), loose()] {
            for (name, end, log) in with_both_methods!(&system, options, mass_at(height, -0.5), 0.12) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                let time = log.contact_times(0)[0];
                let end_state = log.steps.iter().find(|s| s.0 == time).expect("a step that ends on the contact");
                worst = worst.max(end_state.1.abs() / location_tolerance);
            }
        }
    }
    println!("events located within {worst:.2e} of the tolerance");
    assert!(worst <= 1.0, "{worst}");
}

/// An obstacle as thin as 1 µm, hit at 5 m/s with steps of milliseconds, at any position within the step.
#[test]
fn thin_obstacles_are_not_missed() {
    let free_flight: crate::wall::Field = |_, _, _| [0.0; 4];
    for half in [1e-4, 1e-5, 1e-6] {
        for i in 0..200 {
            let wall_position = 1e-3 + 0.4e-3 * f64::from(i);
            let obstacle = Obstacle::Window { position: wall_position, half };
            // Ten times the stiffness that would stop 0.02 kg at 5 m/s in the middle of the obstacle.
            let stiffness_n_per_m_e = 10.0 * 0.25 * 3.2 / half.powf(3.2);
            let law = NormalLaw { stiffness_n_per_m_e, ..ELASTIC };
            let system = PointMass {
                mass: 0.02,
                field: free_flight,
                discontinuities: vec![],
                walls: [Wall { obstacle, law, location_tolerance_m: 1e-12 }],
            };
            for (name, end, log) in with_both_methods!(&system, loose(), mass_at(0.0, 5.0), 0.03) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
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
    let upward_acceleration: crate::wall::Field = |_, _, _| [10.0, 0.0, 0.0, 0.0];
    for t0 in [1e-2, 3e-2, 0.1] {
        for (below, free) in [(0.0, true), (-1e-12, true), (1e-9, false)] {
            let system = PointMass {
                mass: 0.02,
                field: upward_acceleration,
                discontinuities: vec![],
                walls: [plate(0.0, 1.0, OBJECT, 1e-10)],
            };
            let start = mass_at(5.0 * t0 * t0 - below, -10.0 * t0);
            for (name, end, log) in with_both_methods!(&system, tight(), start, 2.0 * t0) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                let (x, v) = (end.state.q[0], end.state.v[0]);
                let contact_times = log.contact_times(0).len();
                assert!(x.is_finite() && v.is_finite());
                if free {
                    assert!((v - 10.0 * t0).abs() < 1e-6 * t0, "{name}: {v} {contact_times}");
                } else {
                    assert!(contact_times >= 1, "{name}: contact not detected");
                    // The wall does not pull, and returns no more energy than it absorbed.
                    let [before, after] = [[start.q[0], start.v[0]], [x, v]].map(|[x, v]| 0.5 * v * v - 10.0 * x);
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
    let free_fall: crate::wall::Field = |_, _, _| [-9.81, 0.0, 0.0, 0.0];
    let doubled_law = NormalLaw {
        stiffness_n_per_m_e: 2.0 * OBJECT.stiffness_n_per_m_e,
        damping_max_n_s_per_m: 2.0 * OBJECT.damping_max_n_s_per_m,
        ..OBJECT
    };
    let single_wall_system = PointMass {
        mass: 0.02,
        field: free_fall,
        discontinuities: vec![],
        walls: [plate(0.0, 1.0, doubled_law, 1e-10)],
    };
    let wall = plate(0.0, 1.0, OBJECT, 1e-10);
    let double_wall_system = PointMass { mass: 0.02, field: free_fall, discontinuities: vec![], walls: [wall, wall] };
    let single = with_both_methods!(&single_wall_system, tight(), mass_at(0.01, -1.0), 0.02);
    let double = with_both_methods!(&double_wall_system, tight(), mass_at(0.01, -1.0), 0.02);
    for ((name, a, _), (_, b, log)) in single.into_iter().zip(double) {
        assert!(a.result.is_ok() && b.result.is_ok(), "{name}: {:?} {:?}", a.result, b.result);
        let (first, second) = (log.contact_times(0)[0], log.contact_times(1)[0]);
        assert!((first - second).abs() < 1e-10, "{name}: {first} {second}");
        let (dx, dv) = (a.state.q[0] - b.state.q[0], a.state.v[0] - b.state.v[0]);
        println!("{name}: x {dx:.1e}, v {dv:.1e}, impulse {:.1e}", a.state.z[0] - b.state.z[0]);
        assert!(dx.abs() < 1e-10 && dv.abs() < 1e-8, "{name}: {dx:e} {dv:e}");
        assert!((a.state.z[0] - b.state.z[0]).abs() < 1e-9);
    }
}

/// Alternating contacts with opposite walls.
#[test]
fn a_mass_bounces_between_two_elastic_walls_without_loss() {
    let free_flight: crate::wall::Field = |_, _, _| [0.0; 4];
    let law = NormalLaw { stiffness_n_per_m_e: 1e14, ..ELASTIC };
    let walls = [plate(0.0, 1.0, law, 1e-12), plate(1e-3, -1.0, law, 1e-12)];
    let system = PointMass { mass: 0.02, field: free_flight, discontinuities: vec![], walls };
    for (name, end, log) in with_both_methods!(&system, tight(), mass_at(5e-4, 1.0), 80e-3) {
        assert!(end.result.is_ok(), "{name}: {:?}", end.result);
        let counts = [0, 1].map(|wall| log.contact_times(wall).len());
        println!("{name}: {counts:?} contacts, error of the speed {:.2e} m/s", end.state.v[0].abs() - 1.0);
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
    let steps: crate::wall::Field = |t, _, _| [if t < 0.0123 { 3.0 } else { -5.0 }, 0.0, 0.0, 0.0];
    let system = PointMass {
        mass: 0.02,
        field: steps,
        discontinuities: vec![discontinuity],
        walls: [plate(-1.0, 1.0, OBJECT, 1e-10)],
    };
    for options in [tight(), loose()] {
        for (name, end, log) in with_both_methods!(&system, options, mass_at(0.01, 0.1), 0.05) {
            assert!(end.result.is_ok(), "{name}: {:?}", end.result);
            assert!(log.steps.iter().any(|s| s.0 == discontinuity), "{name}: no step ends on the discontinuity");
            let (v1, rest) = (0.1 + 3.0 * discontinuity, 0.05 - discontinuity);
            let x1 = 0.01 + 0.1 * discontinuity + 1.5 * discontinuity * discontinuity;
            let (x, v) = (x1 + v1 * rest - 2.5 * rest * rest, v1 - 5.0 * rest);
            let off = [end.state.q[0] - x, end.state.v[0] - v];
            println!("{name}: errors of x and v: {off:?}");
            assert!(off[0].abs() < 1e-15 && off[1].abs() < 1e-14, "{name}: {off:?}");
            assert_eq!(end.time_s, 0.05);
        }
    }
}

/// The branches that the contact entered, in order.
fn branches(log: &Log) -> Vec<Branch> {
    log.events.iter().map(|event| event.2).collect()
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
    let law = NormalLaw {
        stiffness_n_per_m_e: returning_force::STIFFNESS,
        exponent: 1.0,
        damping_max_n_s_per_m: returning_force::DAMPING,
        transition_m: 1e-6,
    };
    let system = |discontinuities| PointMass {
        mass: 0.02,
        field: returning_force::forcing,
        discontinuities,
        walls: [plate(0.0, 1.0, law, 1e-12)],
    };
    let without_discontinuities = system(vec![]);
    let with_discontinuities = system((-2000..4000).map(|i| 1e-7 * f64::from(i)).collect());
    let (mut missed, mut thetas) = (Vec::new(), Vec::new());
    for half in [5e-6, 2e-6, 5e-7] {
        // Steps grow from 10 ns by a factor of eight: the step that contains the force maximum begins 47 µs after the
        // start and is 328 µs long.
        for i in 0..80 {
            let t0 = -1.72e-4 + 4e-6 * f64::from(i);
            let [x, v] = returning_force::start(t0, half);
            for (system, options) in [
                (&without_discontinuities, tight()),
                (&without_discontinuities, loose()),
                (&with_discontinuities, tight()),
            ] {
                if !system.discontinuities.is_empty() && i % 20 > 0 {
                    continue;
                }
                for (name, end, log) in with_both_methods!(system, options, mass_at(x, v), t0, 4e-4) {
                    assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                    let before = log
                        .steps
                        .iter()
                        .rev()
                        .map(|step| step.0)
                        .find(|t| *t < returning_force::FORCE_MAXIMUM_S - 2.0 * half);
                    let theta = (returning_force::FORCE_MAXIMUM_S - before.unwrap_or(t0)) / 3.28e-4;
                    thetas.push(theta);
                    if branches(&log) != [Branch::Active, Branch::Released] {
                        missed.push((name, half, theta, log.events));
                        continue;
                    }
                    assert_eq!(end.counters.events, 2);
                    for (event, time) in log
                        .events
                        .iter()
                        .zip([returning_force::FORCE_MAXIMUM_S - half, returning_force::FORCE_MAXIMUM_S + half])
                    {
                        assert!((event.0 - time).abs() < 0.01 * half, "{name}: half {half:e}: {event:?} {time:e}");
                    }
                }
            }
        }
    }
    let interior = thetas.iter().filter(|theta| **theta > 0.05 && **theta < 0.95).count();
    println!("{} of {} returns inside a step", interior, thetas.len());
    assert!(2 * interior > thetas.len(), "the steps are too short for a test");
    assert!(missed.is_empty(), "{} of {} missed: {:?}", missed.len(), thetas.len(), missed.first());
}

/// A linear spring with a damper that fades with the square of the depth: a rebounding mass is released at a large
/// depth, and the contact is active again over the last (k/3c) δ_max²/v before separation.
#[test]
fn forces_that_return_just_before_separation_are_detected() {
    let free_flight: crate::wall::Field = |_, _, _| [0.0; 4];
    let (stiffness, damping) = (1e4, 20.0);
    for transition_m in [1e-4, 1e-5, 1e-6] {
        let law =
            NormalLaw { stiffness_n_per_m_e: stiffness, exponent: 1.0, damping_max_n_s_per_m: damping, transition_m };
        for i in 0..40 {
            let speed = 0.5 + 0.05 * f64::from(i);
            let system = |discontinuities| PointMass {
                mass: 0.02,
                field: free_flight,
                discontinuities,
                walls: [plate(0.0, 1.0, law, 1e-12)],
            };
            let without_discontinuities = system(vec![]);
            let with_discontinuities = system((0..5000).map(|i| 2e-6 * f64::from(i)).collect());
            for (system, options) in [
                (&without_discontinuities, tight()),
                (&without_discontinuities, loose()),
                (&with_discontinuities, tight()),
            ] {
                if !system.discontinuities.is_empty() && i % 10 > 0 {
                    continue;
                }
                for (name, end, log) in with_both_methods!(system, options, mass_at(1e-4, -speed), 1e-2) {
                    assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                    let found = branches(&log);
                    let expected = [Branch::Active, Branch::Released, Branch::Active, Branch::Released];
                    assert_eq!(found, expected, "{name}: δ_max {transition_m:e} at {speed}: {:?}", log.events);
                    // The free flight between release and reloading ends where k δ = c σ(δ/δ_max) v.
                    let release = log.steps.iter().find(|step| step.0 == log.events[1].0).expect("a step to the event");
                    let speed_away = release.2;
                    let ratio = stiffness * transition_m / (damping * speed_away);
                    let s = 2.0 * ratio / (3.0 + (9.0 - 8.0 * ratio).sqrt());
                    let flight = (-release.1 - s * transition_m) / speed_away;
                    let return_time = log.events[2].0 - log.events[1].0;
                    // A released contact reloads at 3 nN; the spring reaches that force after this delay.
                    let (contact_time, reload_delay) = (s * transition_m / speed_away, 6e-9 / stiffness / speed_away);
                    assert!(
                        (return_time - flight).abs() < 1e-3 * contact_time + reload_delay,
                        "{name}: δ_max {transition_m:e} at {speed}: reloaded after {return_time:e}, expected {flight:e}"
                    );
                }
            }
        }
    }
}
