//! Impacts of one mass on a wall against closed forms.

use crate::wall::{Branch, OBJECT, Obstacle, PointMass, Wall, mass_at, tight, with_both_methods};
use phalanx_mechanics::law::{NormalLaw, elastic_energy};

const FREE_FLIGHT: crate::wall::Field = |_, _, _| [0.0; 4];
const FREE_FALL: crate::wall::Field = |_, _, _| [-9.81, 0.0, 0.0, 0.0];

fn floor(law: NormalLaw) -> Wall {
    Wall { obstacle: Obstacle::Plate { position: 0.0, side: 1.0 }, law, location_tolerance_m: 1e-10 }
}

/// Damper alone, no external force: v(δ) = v0 − (c_max/m)(δ³/δ_max² − δ⁴/(2 δ_max³)) for δ ≤ δ_max, since m dv/dδ =
/// −c(δ).
#[test]
fn a_damper_alone_decelerates_a_mass_along_the_closed_form() {
    let law = NormalLaw { stiffness_n_per_m_e: 0.0, ..OBJECT };
    for (mass, v0) in [(0.02, 2.0), (0.02, 0.01), (5e-3, 7.0), (2.0, 1.5)] {
        let system = PointMass { mass, field: FREE_FLIGHT, discontinuities: vec![], walls: [floor(law)] };
        for (name, end, log) in with_both_methods!(&system, tight(), mass_at(1e-3, -v0), 1e-3 / v0 + 1e-3) {
            assert!(end.result.is_ok(), "{name}: {:?}", end.result);
            let mut worst = 0.0f64;
            for (_, x, v) in &log.steps {
                let delta = (-x).max(0.0);
                let s = delta / law.transition_m;
                assert!(s < 1.0);
                let expected = v0 - law.damping_max_n_s_per_m / mass * law.transition_m * (s.powi(3) - 0.5 * s.powi(4));
                worst = worst.max((-v - expected).abs());
            }
            // The impulse equals the momentum lost, and the work equals the energy lost.
            let (v, [impulse, work]) = (end.state.v[0], end.state.z);
            let lost = 0.5 * mass * (v * v - v0 * v0);
            println!("{name} {mass} kg {v0} m/s: error of v {worst:.1e} m/s, {} steps", end.counters.steps);
            assert!(worst < 1e-9 * v0, "{name}: {worst:e}");
            assert!((impulse - mass * (v + v0)).abs() < 1e-9 * mass * v0, "{name}: {impulse:e}");
            assert!((work - lost).abs() < 1e-9 * mass * v0 * v0, "{name}: {work:e} {lost:e}");
        }
    }
}

/// Without a damper the wall returns the energy it stores: the height is preserved over a hundred rebounds under
/// gravity.
#[test]
fn a_spring_alone_conserves_energy_over_a_hundred_rebounds() {
    let law = NormalLaw { damping_max_n_s_per_m: 0.0, ..OBJECT };
    let system = PointMass { mass: 0.02, field: FREE_FALL, discontinuities: vec![], walls: [floor(law)] };
    let height = 0.01;
    let period = 2.0 * (2.0 * height / 9.81f64).sqrt();
    // Longer than 100 flights, because the contacts also take time.
    let span = 110.0 * period;
    for (name, end, log) in with_both_methods!(&system, tight(), mass_at(height, 0.0), span) {
        assert!(end.result.is_ok(), "{name}: {:?}", end.result);
        let (x, v) = (end.state.q[0], end.state.v[0]);
        let energy = 0.5 * v * v + 9.81 * x + elastic_energy(&law, -x) / 0.02;
        let drift = energy / (9.81 * height) - 1.0;
        let rebounds = log.contact_times(0).len();
        println!("{name}: {rebounds} rebounds, energy drift {drift:.1e}, {} steps", end.counters.steps);
        assert!(rebounds >= 100, "{name}: {rebounds}");
        assert!(drift.abs() < 1e-8, "{name}: {drift:e}");
    }
}

/// One rebound of the spring alone: the speed is restored, and the largest depth satisfies ½ m v² = k δᵉ⁺¹/(e + 1).
#[test]
fn one_rebound_returns_the_speed() {
    let law = NormalLaw { damping_max_n_s_per_m: 0.0, ..OBJECT };
    let (mass, v0) = (0.02, 2.0);
    let system = PointMass { mass, field: FREE_FLIGHT, discontinuities: vec![], walls: [floor(law)] };
    for (name, end, log) in with_both_methods!(&system, tight(), mass_at(1e-3, -v0), 5e-3) {
        assert!(end.result.is_ok(), "{name}: {:?}", end.result);
        let deepest = log.steps.iter().map(|s| -s.1).fold(0.0, f64::max);
        let expected = (0.5 * mass * v0 * v0 * 3.2 / law.stiffness_n_per_m_e).powf(1.0 / 3.2);
        println!(
            "{name}: error of v {:.3e} m/s, depth {deepest:.6e} m, expected {expected:.6e} m",
            end.state.v[0] - v0
        );
        assert!((end.state.v[0] - v0).abs() < 1e-9 * v0, "{name}: {}", end.state.v[0]);
        assert!((end.state.z[0] - 2.0 * mass * v0).abs() < 1e-10);
        assert!(deepest <= expected * (1.0 + 1e-9) && deepest > 0.99 * expected, "{name}: {deepest:e} {expected:e}");
        assert_eq!(log.events.iter().map(|e| e.2).collect::<Vec<_>>(), [Branch::Active, Branch::Released]);
    }
}
