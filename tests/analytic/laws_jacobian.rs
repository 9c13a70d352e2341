//! The Jacobian of the equations of motion of discs against central differences.

use crate::support::laws::{THESIS_FRICTION, THESIS_NORMAL, disc, scene, with_half_plane};
use phalanx::analytic::multibody::{Multibody, quadratures};
use phalanx::analytic::{ContactState, Mode};
use phalanx::integrator::{Linearised, Rates, State, System};
use phalanx::scene::DiscMotion;

const PAIRS: usize = 12;
const QUADRATURES: usize = quadratures(PAIRS);

/// Three rotating and sliding discs, one of them driven; each overlaps another disc or a fixed surface.
#[test]
fn jacobian_matches_central_differences() {
    let free = DiscMotion::Free { mass_kg: 0.3, inertia_kg_m2: Some(2e-4), velocity_m_s: [0.4, -0.3], spin_rad_s: 2.0 };
    let stiff = DiscMotion::Free { mass_kg: 0.7, inertia_kg_m2: None, velocity_m_s: [-0.2, 0.1], spin_rad_s: 0.0 };
    let driven = DiscMotion::Driven { velocity_m_s: [0.1, 0.3], acceleration_m_s2: [1.0, 2.0], spin_rad_s: -1.5 };
    let discs = vec![
        disc("a", 0.05, [0.0, 0.05 - 4e-6], free),
        disc("b", 0.04, [0.07, 0.056_568_5], stiff),
        disc("c", 0.03, [-0.05, 0.112_44], driven),
        disc("wall", 0.02, [0.13, 0.056], DiscMotion::Fixed),
    ];
    let mut scene = with_half_plane(scene(discs, THESIS_NORMAL, Some(THESIS_FRICTION), 1e-3));
    scene.system.gravity_m_s2 = [0.0, -9.81];
    let model = Multibody::<9, PAIRS>::new(&scene.system);
    let start: State<9, QUADRATURES> = model.start(&scene.system);
    let overlapping = (0..model.contact_count())
        .filter_map(|pair| model.contact_reading(&start.q, &start.v, pair, ContactState::Clamped))
        .filter(|reading| reading.delta > 1e-7)
        .count();
    assert!(overlapping >= 3, "only {overlapping} pairs overlap");
    let mode = Mode::from([ContactState::Active; PAIRS]);
    let exact: Linearised<9, QUADRATURES> = model.linearise(0.0, &start.q, &start.v, &mode);
    for column in 0..18 {
        let h = if column < 9 { 1e-10 } else { 1e-6 };
        let shifted = |sign: f64| -> Rates<9, QUADRATURES> {
            let (mut q, mut v) = (start.q, start.v);
            match column {
                0..9 => q[column] += sign * h,
                _ => v[column - 9] += sign * h,
            }
            model.rates(0.0, &q, &v, &mode)
        };
        let (up, down) = (shifted(1.0), shifted(-1.0));
        for row in 0..9 {
            let slope = (up.a[row] - down.a[row]) / (2.0 * h);
            let analytic = if column < 9 { exact.a_q[row][column] } else { exact.a_v[row][column - 9] };
            let scale = exact.rates.a[row].abs() / if column < 9 { 1e-6 } else { 1.0 };
            assert!(
                (analytic - slope).abs() <= 1e-5 * slope.abs().max(scale).max(1.0),
                "a {row} {column}: {analytic} {slope}"
            );
        }
        for row in 0..QUADRATURES {
            let slope = (up.g[row] - down.g[row]) / (2.0 * h);
            let analytic = if column < 9 { exact.g_q[row][column] } else { exact.g_v[row][column - 9] };
            let scale = exact.rates.g[row].abs() / if column < 9 { 1e-6 } else { 1.0 };
            assert!(
                (analytic - slope).abs() <= 1e-5 * slope.abs().max(scale).max(1.0),
                "g {row} {column}: {analytic} {slope}"
            );
        }
    }
}
