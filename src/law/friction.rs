//! Friction law: regularised Coulomb with stiction peak (thesis (2.35), Fig. 2.9, errata 8).

use super::{FrictionLaw, smoothstep};

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
        let drop = law.mu_dynamic - law.mu_static;
        let (sigma, slope) = smoothstep((speed - law.v_static_m_s) / width);
        ((law.mu_static + drop * sigma).copysign(v), drop * slope / width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: FrictionLaw = FrictionLaw { mu_static: 0.8, mu_dynamic: 0.56, v_static_m_s: 0.1, v_dynamic_m_s: 0.2 };

    #[test]
    fn errata_08_branches_meet_and_the_law_is_odd() {
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
    fn slope_matches_central_differences() {
        for v in [-0.17, -0.03, 0.0, 0.05, 0.13, 0.5] {
            let step = 1e-6;
            let slope =
                (friction_coefficient(&LAW, v + step).0 - friction_coefficient(&LAW, v - step).0) / (2.0 * step);
            assert!((friction_coefficient(&LAW, v).1 - slope).abs() < 1e-8, "{v}");
        }
    }

    #[test]
    fn coefficient_stays_within_the_static_one() {
        for i in -400..=400 {
            let v = i as f64 * 1e-3;
            let mu = friction_coefficient(&LAW, v).0;
            assert!(mu.abs() <= LAW.mu_static + 1e-15 && mu * v >= 0.0);
        }
    }
}
