//! Regularised Coulomb friction with a stiction peak (thesis (2.35), Fig. 2.9, errata 8).

use super::{FrictionLaw, FrictionPoint, FrictionRange, FrictionStep, smoothstep};
use crate::numeric::Real;

/// μ(v) and dμ/dv, odd in the slip velocity `v` (m/s).
///
/// |v| < v_s: μ_s [2 σ((v + v_s)/(2 v_s)) − 1];  v_s ≤ |v| < v_d: μ_s + (μ_d − μ_s) σ((|v| − v_s)/(v_d − v_s));
/// beyond: μ_d. The force on the sliding surface is −μ(v) F_n.
#[inline(always)]
pub fn friction_coefficient(law: &FrictionLaw, v: f64) -> (f64, f64) {
    let speed = v.abs();
    if speed < law.v_static_m_s {
        let (sigma, slope) = smoothstep((v + law.v_static_m_s) / (2.0 * law.v_static_m_s));
        (law.mu_static * (2.0 * sigma - 1.0), law.mu_static * slope / law.v_static_m_s)
    } else {
        let width = law.v_dynamic_m_s - law.v_static_m_s;
        let mu_change = law.mu_dynamic - law.mu_static;
        let (sigma, slope) = smoothstep((speed - law.v_static_m_s) / width);
        ((law.mu_static + mu_change * sigma).copysign(v), mu_change * slope / width)
    }
}

/// Friction on the sliding surface, −μ(v) F_n along the tangent (thesis (2.35)): `slip` in m/s, `normal` in N.
#[inline(always)]
pub fn friction_force<T: Real>(law: &FrictionLaw, slip: T, normal: T) -> T {
    let (mu, slope) = friction_coefficient(law, slip.value());
    slip.chain(mu, slope) * -normal
}

/// Returns the range of a slip rate.
#[inline(always)]
pub(super) fn range(law: &FrictionLaw, v: f64) -> FrictionRange {
    let (speed, forward) = (v.abs(), v > 0.0);
    if speed <= law.v_static_m_s {
        FrictionRange::Sticking
    } else if speed <= law.v_dynamic_m_s {
        FrictionRange::Transition { forward }
    } else {
        FrictionRange::Sliding { forward }
    }
}

/// Distance of `v` from the nearest nominal end of a range, in m/s; negative outside the range.
#[inline(always)]
pub(super) fn margin(law: &FrictionLaw, range: FrictionRange, v: f64) -> f64 {
    let signed_speed = |forward: bool| if forward { v } else { -v };
    match range {
        FrictionRange::Sticking => law.v_static_m_s - v.abs(),
        FrictionRange::Transition { forward } => {
            (signed_speed(forward) - law.v_static_m_s).min(law.v_dynamic_m_s - signed_speed(forward))
        }
        FrictionRange::Sliding { forward } => signed_speed(forward) - law.v_dynamic_m_s,
        FrictionRange::Any => f64::INFINITY,
    }
}

/// Returns the adjacent range at the end nearest to `v`.
pub(super) fn neighbour(law: &FrictionLaw, range: FrictionRange, v: f64) -> FrictionRange {
    let forward = v > 0.0;
    match range {
        FrictionRange::Sticking => FrictionRange::Transition { forward },
        FrictionRange::Transition { .. } => {
            if v.abs() - law.v_static_m_s < law.v_dynamic_m_s - v.abs() {
                FrictionRange::Sticking
            } else {
                FrictionRange::Sliding { forward }
            }
        }
        FrictionRange::Sliding { .. } => FrictionRange::Transition { forward },
        FrictionRange::Any => FrictionRange::Any,
    }
}

/// Bounds of the ratio of friction to normal force while the slip changes between two values.
pub(super) fn ratio_bounds(law: &FrictionLaw, slips: [f64; 2]) -> [f64; 2] {
    let [from, to] = [slips[0].min(slips[1]), slips[0].max(slips[1])];
    let peaks = [-law.v_static_m_s, law.v_static_m_s].into_iter().filter(|peak| (from..=to).contains(peak));
    let ratios = [from, to].into_iter().chain(peaks).map(|slip| -friction_coefficient(law, slip).0);
    ratios.fold([f64::INFINITY, f64::NEG_INFINITY], |[lower, upper], ratio| [lower.min(ratio), upper.max(ratio)])
}

/// Friction at the end of an implicit step.
#[inline(always)]
pub(super) fn implicit_step(law: &FrictionLaw, at: FrictionPoint, one_way: bool) -> FrictionStep {
    let FrictionPoint { slip, state, normal } = at;
    let (mu, slope) = if !one_way || slip < 0.0 { friction_coefficient(law, slip) } else { (0.0, 0.0) };
    FrictionStep { force: mu * normal, d_slip: slope * normal, d_normal: mu, state }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{FrictionKind, NormalLaw, normal_force, normal_over_gap};
    use crate::numeric::Dual;

    const LAW: FrictionLaw = FrictionLaw {
        mu_static: 0.8,
        mu_dynamic: 0.56,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.2,
        kind: FrictionKind::Regularised,
    };

    #[test]
    fn errata_08_branches_are_continuous_and_the_law_is_odd() {
        assert_eq!(friction_coefficient(&LAW, 0.0).0, 0.0);
        for (v, mu) in [(0.1, 0.8), (0.2, 0.56), (5.0, 0.56), (0.15, 0.68)] {
            assert!((friction_coefficient(&LAW, v).0 - mu).abs() < 1e-14, "{v}");
            assert_eq!(friction_coefficient(&LAW, -v).0, -friction_coefficient(&LAW, v).0);
        }
        for edge in [0.1, 0.2] {
            let (below, slope_below) = friction_coefficient(&LAW, edge - 1e-12);
            let (above, slope_above) = friction_coefficient(&LAW, edge + 1e-12);
            assert!((below - above).abs() < 1e-11 && (slope_below - slope_above).abs() < 1e-8);
        }
    }

    #[test]
    fn ranges_match_the_polynomial_pieces_of_the_law() {
        use FrictionRange::{Sliding, Sticking, Transition};
        for (v, range) in [
            (0.0, Sticking),
            (-0.1, Sticking),
            (0.15, Transition { forward: true }),
            (-0.15, Transition { forward: false }),
            (0.3, Sliding { forward: true }),
            (-7.0, Sliding { forward: false }),
        ] {
            assert_eq!(super::range(&LAW, v), range);
            assert!(margin(&LAW, range, v) >= 0.0, "{v}");
            assert!(margin(&LAW, range, 0.1001) < 0.0 || v > 0.1 && v < 0.2);
        }
        assert_eq!(neighbour(&LAW, Transition { forward: false }, -0.101), Sticking);
        assert_eq!(neighbour(&LAW, Transition { forward: true }, 0.199), Sliding { forward: true });
        assert_eq!(neighbour(&LAW, Sticking, -0.0999), Transition { forward: false });
    }

    #[test]
    fn slope_matches_central_differences() {
        for v in [-0.17, -0.03, 0.0, 0.05, 0.13, 0.5] {
            let step = 1e-6;
            let slope =
                (friction_coefficient(&LAW, v + step).0 - friction_coefficient(&LAW, v - step).0) / (2.0 * step);
            assert!((friction_coefficient(&LAW, v).1 - slope).abs() < 1e-8, "{v}");
        }
    }

    #[test]
    fn coefficient_never_exceeds_the_static_one() {
        for i in -400..=400 {
            let v = i as f64 * 1e-3;
            let mu = friction_coefficient(&LAW, v).0;
            assert!(mu.abs() <= LAW.mu_static + 1e-15 && mu * v >= 0.0);
        }
    }

    const NORMAL: NormalLaw = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);
    fn contact_forces<T: Real>(gap: T, rate: T, slip: T) -> [T; 2] {
        let normal = normal_over_gap(|delta, rate| normal_force(&NORMAL, delta, rate), gap, rate);
        [normal, friction_force(&LAW, slip, normal)]
    }

    /// The Jacobian of the composed law against its central differences.
    #[test]
    fn composed_law_has_exact_derivatives() {
        let at = [-3e-6, -0.5, 0.07];
        let step = [1e-11, 1e-6, 1e-7];
        let dual = contact_forces(Dual::<3>::variable(at[0], 0), Dual::variable(at[1], 1), Dual::variable(at[2], 2));
        for i in 0..3 {
            let shifted = |sign: f64| {
                let mut x = at;
                x[i] += sign * step[i];
                contact_forces(x[0], x[1], x[2])
            };
            let (up, down) = (shifted(1.0), shifted(-1.0));
            for (k, force) in dual.iter().enumerate() {
                let slope = (up[k] - down[k]) / (2.0 * step[i]);
                assert!((force.grad[i] - slope).abs() <= 1e-7 * slope.abs().max(1.0), "{i} {k}");
            }
        }
    }

    #[test]
    fn friction_opposes_slip_within_the_cone() {
        for slip in [-1.0, -0.15, -0.01, 0.0, 0.05, 0.3] {
            let [normal, tangential] = contact_forces(-2e-6, -0.3, slip);
            assert!(normal > 0.0 && tangential * slip <= 0.0 && tangential.abs() <= 0.8 * normal);
        }
    }
}
