//! Events: where they are found, that none is missed, and that those which coincide do no harm.

use crate::wall::{Branch, Line, Log, OBJECT, Place, Wall, at, tight, with_both};
use phalanx_integrator::{Options, Tolerances};
use phalanx_mechanics::law::NormalLaw;

const ELASTIC: NormalLaw = NormalLaw { damping_max_n_s_per_m: 0.0, ..OBJECT };

fn plate(at: f64, side: f64, law: NormalLaw, landing_m: f64) -> Wall {
    Wall { place: Place::Plate { at, side }, law, landing_m }
}

/// Everyday tolerances: events must not depend on small steps.
fn loose() -> Options {
    Options { tolerances: Tolerances { atol_q: 1e-7, atol_v: 1e-3, rtol_v: 1e-3 }, ..tight() }
}

/// A fall onto a plate: t = √(2h/g); a swing x = a cos ωt against one at a/2: t = π/(3ω).
#[test]
fn contact_times_are_exact() {
    let falls: crate::wall::Field = |_, _, _| [-9.81, 0.0, 0.0, 0.0];
    let swings: crate::wall::Field = |_, x, _| [-1e4 * x, 0.0, -1e4, 0.0];
    let mut cases = Vec::new();
    for i in 1..=40 {
        let height = 1e-3 * f64::from(i);
        cases.push((falls, height, 0.0, (2.0 * height / 9.81).sqrt()));
    }
    for i in 1..=40 {
        let amplitude = 1e-3 * f64::from(i);
        cases.push((swings, amplitude, 0.5 * amplitude, std::f64::consts::PI / 300.0));
    }
    let mut worst = [0.0f64; 2];
    for (field, start, at_x, time) in cases {
        let options = Options { tolerances: Tolerances { atol_q: 1e-16, atol_v: 1e-14, rtol_v: 1e-14 }, ..tight() };
        let system = Line { mass: 0.02, field, corners: vec![], walls: [plate(at_x, 1.0, OBJECT, 1e-16)] };
        for (i, (name, end, log)) in with_both!(&system, options, at(start, 0.0), time + 1e-6).into_iter().enumerate() {
            assert!(end.result.is_ok(), "{name}: {:?}", end.result);
            let touched = log.touchdowns(0);
            assert!(!touched.is_empty(), "{name}: no contact at {time}");
            worst[i] = worst[i].max((touched[0] - time).abs());
        }
    }
    println!("contact times: Rodas5P {:.1e} s, Radau IIA {:.1e} s", worst[0], worst[1]);
    assert!(worst.iter().all(|w| *w < 1e-14), "{worst:?}");
}

/// Landings stop within the tolerance asked for, however the root search goes: also where it hits the gap's zero exactly.
#[test]
fn landings_keep_their_tolerance() {
    let falls: crate::wall::Field = |_, x, v| [-9.81 - 3.0 * v - 40.0 * x, 0.0, -40.0, -3.0];
    let mut worst = 0.0f64;
    for i in 0..400 {
        let landing = 1e-10;
        let system = Line { mass: 0.02, field: falls, corners: vec![], walls: [plate(0.0, 1.0, OBJECT, landing)] };
        let height = 1e-3 + 1e-4 * f64::from(i);
        for options in [tight(), loose()] {
            for (name, end, log) in with_both!(&system, options, at(height, -0.5), 0.12) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                let time = log.touchdowns(0)[0];
                let landed = log.steps.iter().find(|s| s.0 == time).expect("a step that ends on the contact");
                worst = worst.max(landed.1.abs() / landing);
            }
        }
    }
    println!("landings within {worst:.2e} of the tolerance");
    assert!(worst <= 1.0, "{worst}");
}

/// A window a micrometre thin, met at 5 m/s by steps of milliseconds, wherever it lies within the step.
#[test]
fn thin_obstacles_are_not_stepped_over() {
    let coasts: crate::wall::Field = |_, _, _| [0.0; 4];
    for half in [1e-4, 1e-5, 1e-6] {
        for i in 0..200 {
            let at_x = 1e-3 + 0.4e-3 * f64::from(i);
            let place = Place::Window { at: at_x, half };
            // Ten times the spring that would stop 0.02 kg at 5 m/s in the middle of the window.
            let stiffness_n_per_m_e = 10.0 * 0.25 * 3.2 / half.powf(3.2);
            let law = NormalLaw { stiffness_n_per_m_e, ..ELASTIC };
            let system =
                Line { mass: 0.02, field: coasts, corners: vec![], walls: [Wall { place, law, landing_m: 1e-12 }] };
            for (name, end, log) in with_both!(&system, loose(), at(0.0, 5.0), 0.03) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                let touched = log.touchdowns(0);
                assert_eq!(touched.len(), 1, "{name}: half {half:e} at {at_x}");
                assert!((touched[0] - (at_x - half) / 5.0).abs() < 1e-12, "{name}: {touched:?}");
                assert!((end.state.v[0] + 5.0).abs() < 0.5, "{name}: passed with {}", end.state.v[0]);
            }
        }
    }
}

/// x = g (t − t0)²/2 just touches the wall at t0: nothing may happen to it. A little lower, and it must not gain energy.
#[test]
fn grazing_leaves_a_mass_as_it_was() {
    let rises: crate::wall::Field = |_, _, _| [10.0, 0.0, 0.0, 0.0];
    for t0 in [1e-2, 3e-2, 0.1] {
        for (below, free) in [(0.0, true), (-1e-12, true), (1e-9, false)] {
            let system = Line { mass: 0.02, field: rises, corners: vec![], walls: [plate(0.0, 1.0, OBJECT, 1e-10)] };
            let start = at(5.0 * t0 * t0 - below, -10.0 * t0);
            for (name, end, log) in with_both!(&system, tight(), start, 2.0 * t0) {
                assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                let (x, v) = (end.state.q[0], end.state.v[0]);
                let touched = log.touchdowns(0).len();
                assert!(x.is_finite() && v.is_finite());
                if free {
                    assert!((v - 10.0 * t0).abs() < 1e-6 * t0, "{name}: {v} {touched}");
                } else {
                    assert!(touched >= 1, "{name}: not seen");
                    // The wall does not pull, and gives back no more than it took.
                    let [before, after] = [[start.q[0], start.v[0]], [x, v]].map(|[x, v]| 0.5 * v * v - 10.0 * x);
                    assert!(after <= before + 1e-13, "{name}: {before:e} {after:e}");
                    assert!(log.steps.iter().all(|s| s.1 > -1.01e-9), "{name}: deeper than the free path");
                }
            }
        }
    }
}

/// Two walls at the same place are one wall of twice the strength, and both report their contact.
#[test]
fn two_sites_may_touch_at_the_same_instant() {
    let falls: crate::wall::Field = |_, _, _| [-9.81, 0.0, 0.0, 0.0];
    let twice = NormalLaw {
        stiffness_n_per_m_e: 2.0 * OBJECT.stiffness_n_per_m_e,
        damping_max_n_s_per_m: 2.0 * OBJECT.damping_max_n_s_per_m,
        ..OBJECT
    };
    let one = Line { mass: 0.02, field: falls, corners: vec![], walls: [plate(0.0, 1.0, twice, 1e-10)] };
    let wall = plate(0.0, 1.0, OBJECT, 1e-10);
    let two = Line { mass: 0.02, field: falls, corners: vec![], walls: [wall, wall] };
    let single = with_both!(&one, tight(), at(0.01, -1.0), 0.02);
    let double = with_both!(&two, tight(), at(0.01, -1.0), 0.02);
    for ((name, a, _), (_, b, log)) in single.into_iter().zip(double) {
        assert!(a.result.is_ok() && b.result.is_ok(), "{name}: {:?} {:?}", a.result, b.result);
        let (first, second) = (log.touchdowns(0)[0], log.touchdowns(1)[0]);
        assert!((first - second).abs() < 1e-10, "{name}: {first} {second}");
        let (dx, dv) = (a.state.q[0] - b.state.q[0], a.state.v[0] - b.state.v[0]);
        println!("{name}: x {dx:.1e}, v {dv:.1e}, impulse {:.1e}", a.state.z[0] - b.state.z[0]);
        assert!(dx.abs() < 1e-10 && dv.abs() < 1e-8, "{name}: {dx:e} {dv:e}");
        assert!((a.state.z[0] - b.state.z[0]).abs() < 1e-9);
    }
}

/// Opposite walls touched in turn.
#[test]
fn a_mass_rattles_between_two_walls_without_loss() {
    let coasts: crate::wall::Field = |_, _, _| [0.0; 4];
    let law = NormalLaw { stiffness_n_per_m_e: 1e14, ..ELASTIC };
    let walls = [plate(0.0, 1.0, law, 1e-12), plate(1e-3, -1.0, law, 1e-12)];
    let system = Line { mass: 0.02, field: coasts, corners: vec![], walls };
    for (name, end, log) in with_both!(&system, tight(), at(5e-4, 1.0), 80e-3) {
        assert!(end.result.is_ok(), "{name}: {:?}", end.result);
        let counts = [0, 1].map(|site| log.touchdowns(site).len());
        println!("{name}: {counts:?} contacts, speed {:.2e} off", end.state.v[0].abs() - 1.0);
        assert!(counts[0] > 30 && counts[0].abs_diff(counts[1]) <= 1, "{name}: {counts:?}");
        assert!(log.events.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert!(log.events.iter().all(|e| e.2 != Branch::Natural));
        assert!((end.state.v[0].abs() - 1.0).abs() < 1e-8, "{name}: {}", end.state.v[0]);
    }
}

/// A push that steps from +3 to −5 m/s² at a corner: a step ends on it to the last bit, and the motion is two parabolas.
#[test]
fn corners_are_landed_on() {
    let corner = 0.0123;
    let steps: crate::wall::Field = |t, _, _| [if t < 0.0123 { 3.0 } else { -5.0 }, 0.0, 0.0, 0.0];
    let system = Line { mass: 0.02, field: steps, corners: vec![corner], walls: [plate(-1.0, 1.0, OBJECT, 1e-10)] };
    for options in [tight(), loose()] {
        for (name, end, log) in with_both!(&system, options, at(0.01, 0.1), 0.05) {
            assert!(end.result.is_ok(), "{name}: {:?}", end.result);
            assert!(log.steps.iter().any(|s| s.0 == corner), "{name}: no step ends on the corner");
            let (v1, rest) = (0.1 + 3.0 * corner, 0.05 - corner);
            let x1 = 0.01 + 0.1 * corner + 1.5 * corner * corner;
            let (x, v) = (x1 + v1 * rest - 2.5 * rest * rest, v1 - 5.0 * rest);
            let off = [end.state.q[0] - x, end.state.v[0] - v];
            println!("{name}: x, v off by {off:?}");
            assert!(off[0].abs() < 1e-15 && off[1].abs() < 1e-14, "{name}: {off:?}");
            assert_eq!(end.time_s, 0.05);
        }
    }
}

/// The branches a site went to, in turn.
fn branches(log: &Log) -> Vec<Branch> {
    log.events.iter().map(|event| event.2).collect()
}

/// A soft contact whose free motion is a cubic in time: with κ = k/c, τ from its top,
/// δ = δ₀ (1 − κτ + κ²τ²/2) + ετ − (2β + κ³δ₀) τ³/6, so that (k δ + c δ̇)/c = ε (1 + κτ) − βτ² − κ (2β + κ³δ₀) τ³/6: its force returns
/// while |τ| < √(ε/β), to a few parts in a thousand, and at no other time. Every step of any size is exact.
mod returning {
    pub const STIFFNESS: f64 = 1e4;
    pub const DAMPING: f64 = 20.0;
    const KAPPA: f64 = STIFFNESS / DAMPING;
    const DEPTH: f64 = 1e-4;
    const BETA: f64 = 2.5e5;
    const JERK: f64 = 2.0 * BETA + KAPPA * KAPPA * KAPPA * DEPTH;
    pub const TOP: f64 = 2e-4;

    pub fn push(t: f64, _: f64, _: f64) -> [f64; 4] {
        [-KAPPA * KAPPA * DEPTH + JERK * (t - TOP), JERK, 0.0, 0.0]
    }

    /// x = −δ and its rate.
    pub fn start(t: f64, half: f64) -> [f64; 2] {
        let (tau, rise) = (t - TOP, BETA * half * half);
        let depth = DEPTH * (1.0 - KAPPA * tau + 0.5 * (KAPPA * tau).powi(2)) + rise * tau - JERK * tau.powi(3) / 6.0;
        let rate = -KAPPA * DEPTH * (1.0 - KAPPA * tau) + rise - 0.5 * JERK * tau * tau;
        [-depth, -rate]
    }
}

/// A released contact presses again for a few microseconds within a step of 0.3 ms, wherever in the step: both ends of that are
/// found where they are, and a run of tiny steps finds nothing else.
#[test]
fn forces_that_return_for_microseconds_within_a_step_are_found() {
    let law = NormalLaw {
        stiffness_n_per_m_e: returning::STIFFNESS,
        exponent: 1.0,
        damping_max_n_s_per_m: returning::DAMPING,
        transition_m: 1e-6,
    };
    let system = |corners| Line { mass: 0.02, field: returning::push, corners, walls: [plate(0.0, 1.0, law, 1e-12)] };
    let whole = system(vec![]);
    let fine = system((-2000..4000).map(|i| 1e-7 * f64::from(i)).collect());
    let (mut missed, mut places) = (Vec::new(), Vec::new());
    for half in [5e-6, 2e-6, 5e-7] {
        // Steps grow from 10 ns, eightfold each: the one that meets the top begins 47 µs after the start and is 328 µs long.
        for i in 0..80 {
            let t0 = -1.72e-4 + 4e-6 * f64::from(i);
            let [x, v] = returning::start(t0, half);
            for (system, options) in [(&whole, tight()), (&whole, loose()), (&fine, tight())] {
                if !system.corners.is_empty() && i % 20 > 0 {
                    continue;
                }
                for (name, end, log) in with_both!(system, options, at(x, v), t0, 4e-4) {
                    assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                    let before = log.steps.iter().rev().map(|step| step.0).find(|t| *t < returning::TOP - 2.0 * half);
                    let place = (returning::TOP - before.unwrap_or(t0)) / 3.28e-4;
                    places.push(place);
                    if branches(&log) != [Branch::Active, Branch::Released] {
                        missed.push((name, half, place, log.events));
                        continue;
                    }
                    assert_eq!(end.counters.events, 2);
                    for (event, time) in log.events.iter().zip([returning::TOP - half, returning::TOP + half]) {
                        assert!((event.0 - time).abs() < 0.01 * half, "{name}: half {half:e}: {event:?} {time:e}");
                    }
                }
            }
        }
    }
    let spread = places.iter().filter(|place| **place > 0.05 && **place < 0.95).count();
    println!("{} of {} returns at inner places of a step", spread, places.len());
    assert!(2 * spread > places.len(), "steps are too short to miss anything");
    assert!(missed.is_empty(), "{} of {} missed: {:?}", missed.len(), places.len(), missed.first());
}

/// A linear spring behind a damper that fades with the square of the depth: a mass that has rebounded is released far out, and
/// pressed again over the last (k/3c) δ_max²/v before the surfaces part.
#[test]
fn forces_that_return_just_before_surfaces_part_are_found() {
    let coasts: crate::wall::Field = |_, _, _| [0.0; 4];
    let (stiffness, damping) = (1e4, 20.0);
    for transition_m in [1e-4, 1e-5, 1e-6] {
        let law =
            NormalLaw { stiffness_n_per_m_e: stiffness, exponent: 1.0, damping_max_n_s_per_m: damping, transition_m };
        for i in 0..40 {
            let speed = 0.5 + 0.05 * f64::from(i);
            let system = |corners| Line { mass: 0.02, field: coasts, corners, walls: [plate(0.0, 1.0, law, 1e-12)] };
            let whole = system(vec![]);
            let fine = system((0..5000).map(|i| 2e-6 * f64::from(i)).collect());
            for (system, options) in [(&whole, tight()), (&whole, loose()), (&fine, tight())] {
                if !system.corners.is_empty() && i % 10 > 0 {
                    continue;
                }
                for (name, end, log) in with_both!(system, options, at(1e-4, -speed), 1e-2) {
                    assert!(end.result.is_ok(), "{name}: {:?}", end.result);
                    let found = branches(&log);
                    let wanted = [Branch::Active, Branch::Released, Branch::Active, Branch::Released];
                    assert_eq!(found, wanted, "{name}: δ_max {transition_m:e} at {speed}: {:?}", log.events);
                    // The free flight between letting go and pressing again ends where k δ = c σ(δ/δ_max) v.
                    let let_go = log.steps.iter().find(|step| step.0 == log.events[1].0).expect("a step to the event");
                    let away = let_go.2;
                    let ratio = stiffness * transition_m / (damping * away);
                    let s = 2.0 * ratio / (3.0 + (9.0 - 8.0 * ratio).sqrt());
                    let flight = (-let_go.1 - s * transition_m) / away;
                    let returned = log.events[2].0 - log.events[1].0;
                    // A released contact takes up again at 3 nN, of which the spring makes this much of the way.
                    let (last, late) = (s * transition_m / away, 6e-9 / stiffness / away);
                    assert!(
                        (returned - flight).abs() < 1e-3 * last + late,
                        "{name}: δ_max {transition_m:e} at {speed}: back after {returned:e}, expected {flight:e}"
                    );
                }
            }
        }
    }
}
