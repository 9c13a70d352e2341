//! The damper of Hunt and Crossley from the coefficient of restitution at one impact speed (Marhefka and Orin 1999, IEEE
//! Transactions on Systems, Man, and Cybernetics A 29, 566–572).
//!
//! The rebound of a free mass from v₀ to v₁ obeys x − ln(1 + x) + e x + ln(1 − e x) = 0 with x = (3/2) a v₀ and e = v₁/v₀:
//! x depends on e only, not on mass, stiffness or exponent. At other speeds v the coefficient follows from (3/2) a v.

use super::Damping;
use crate::numeric::elementary::ln_1p;

/// Halvings of the interval of x, which leave the last digits of a number.
const HALVINGS: u32 = 200;

/// Returns the damper with which a free mass rebounds at the fraction `restitution` (0 exclusive to 1) of the impact
/// `speed`, m/s (limit: rad/s).
pub fn damping_from_restitution(restitution: f64, speed: f64) -> Damping {
    let e = restitution;
    // Positive below the root, and negative up to x = 1/e.
    let balance = |x: f64| (x - ln_1p(x)) + (e * x + ln_1p(-e * x));
    let [mut low, mut high] = [0.0, 1.0 / e];
    for _ in 0..if e < 1.0 { HALVINGS } else { 0 } {
        let middle = 0.5 * (low + high);
        if balance(middle) > 0.0 { low = middle } else { high = middle }
    }
    Damping::HuntCrossley { factor_s_per_m: low / (1.5 * speed) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_impacts_and_elastic_ones_follow_the_series() {
        for (e, tolerance) in [(0.9, 1e-2), (0.99, 1e-4), (0.999, 1e-6)] {
            let Damping::HuntCrossley { factor_s_per_m } = damping_from_restitution(e, 2.0) else { panic!() };
            // x = (3/2) (1 − e²)/(1 + e³) to second order in 1 − e.
            let series = (1.0 - e * e) / (1.0 + e * e * e) / 2.0;
            assert!((factor_s_per_m / series - 1.0).abs() < tolerance, "{e}: {factor_s_per_m}, {series}");
        }
        assert_eq!(damping_from_restitution(1.0, 2.0), Damping::HuntCrossley { factor_s_per_m: 0.0 });
    }

    /// Page 10.6: with a = 0.3 s/m, a mass rebounds from 1 m/s at 0.7679997890785 m/s.
    #[test]
    fn the_rebound_of_the_reference_is_inverted() {
        let Damping::HuntCrossley { factor_s_per_m } = damping_from_restitution(0.7679997890785, 1.0) else { panic!() };
        assert!((factor_s_per_m - 0.3).abs() < 1e-12, "{factor_s_per_m}");
    }
}
