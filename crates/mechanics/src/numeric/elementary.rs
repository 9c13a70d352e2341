//! Elementary functions from a single library on every platform.
//!
//! Sums, products, quotients and square roots are rounded identically everywhere; sines and powers of a system's C
//! library are not, and impacts amplify rounding differences. The core uses only these functions; clippy rejects all
//! others.

use std::f64::consts::LOG2_E;

/// `ln` is the natural logarithm, `sin_cos` returns (sin x, cos x), and `hypot` does not overflow.
pub use libm::{
    acos, asin, atan, atan2, cbrt, cos, exp, hypot, log as ln, log1p as ln_1p, log2, log10, sin, sincos as sin_cos, tan,
};

/// Largest doubled exponent for which xⁿ is computed by products and a square root: covers Hertz and linear laws.
const MAX_HALF_POWERS: i32 = 8;

/// xⁿ for x ≥ 0. The relative error is at most (1.1 + 3.5 |n log₂ x|) 2⁻⁵³: five roundings of the logarithm and one of
/// the power. For a depth of 1e-7 m to the power 2.2 it is 2e-14; the depth itself, a difference of lengths, has a
/// relative error of 1e-10. A correctly rounded power would take three times as long. Integer and half-integer n up to
/// 4 use products and cost less.
#[inline]
pub fn pow(x: f64, n: f64) -> f64 {
    let half_powers = (2.0 * n) as i32;
    if f64::from(half_powers) == 2.0 * n && (0..=MAX_HALF_POWERS).contains(&half_powers) {
        let integer_power = powi(x, half_powers / 2);
        return if half_powers % 2 == 0 { integer_power } else { integer_power * x.sqrt() };
    }
    libm::exp2(n * LOG2_E * libm::log(x))
}

/// xⁿ by repeated multiplication. The standard library does not guarantee the same result on every platform.
#[inline]
pub fn powi(x: f64, n: i32) -> f64 {
    let (mut product, mut square, mut remaining) = (1.0, x, n.unsigned_abs());
    while remaining > 0 {
        if remaining % 2 == 1 {
            product *= square;
        }
        square *= square;
        remaining /= 2;
    }
    if n < 0 { 1.0 / product } else { product }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers in [0, 1) of a linear congruential generator, identical on every platform.
    fn uniform(count: usize) -> impl Iterator<Item = f64> {
        let next =
            |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        std::iter::successors(Some(1), next)
            .skip(1)
            .take(count)
            .map(|state| (state >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Numbers between 2^−30 and 2^30, uniform over octaves.
    fn octaves(count: usize) -> impl Iterator<Item = f64> {
        uniform(count).zip(uniform(2 * count).skip(count)).map(|(x, y)| (1.0 + x) * powi(2.0, (60.0 * y) as i32 - 30))
    }

    /// Returns the largest difference in units in the last place of `exact`.
    fn max_ulp_error(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
        pairs.fold(0.0, |worst, (computed, exact)| {
            assert!(computed.is_finite() && exact.is_finite());
            let ulp = f64::from_bits(exact.abs().to_bits() + 1) - exact.abs();
            worst.max((computed - exact).abs() / ulp)
        })
    }

    /// Both libraries are within one unit in the last place of the exact value.
    #[test]
    fn functions_agree_with_the_standard_library_to_two_units_in_the_last_place() {
        let angles = || uniform(100_000).map(|x| 20.0 * x - 10.0);
        let unit = || uniform(100_000).map(|x| 2.0 * x - 1.0);
        let both = || octaves(100_000).zip(octaves(150_000).skip(50_000));
        for (name, worst) in [
            ("sin", max_ulp_error(angles().map(|x| (sin(x), x.sin())))),
            ("cos", max_ulp_error(angles().map(|x| (cos(x), x.cos())))),
            ("sine of both", max_ulp_error(angles().map(|x| (sin_cos(x).0, x.sin())))),
            ("cosine of both", max_ulp_error(angles().map(|x| (sin_cos(x).1, x.cos())))),
            ("tan", max_ulp_error(angles().map(|x| (tan(x), x.tan())))),
            ("asin", max_ulp_error(unit().map(|x| (asin(x), x.asin())))),
            ("atan2", max_ulp_error(both().map(|(y, x)| (atan2(y, x), y.atan2(x))))),
            ("hypot", max_ulp_error(both().map(|(x, y)| (hypot(x, y), x.hypot(y))))),
            ("exp", max_ulp_error(angles().map(|x| (exp(x), x.exp())))),
            ("ln", max_ulp_error(octaves(100_000).map(|x| (ln(x), x.ln())))),
            ("log2", max_ulp_error(octaves(100_000).map(|x| (log2(x), x.log2())))),
            ("log10", max_ulp_error(octaves(100_000).map(|x| (log10(x), x.log10())))),
            ("cbrt", max_ulp_error(octaves(100_000).map(|x| (cbrt(x), x.cbrt())))),
        ] {
            assert!(worst <= 2.0, "{name}: {worst} ulp");
        }
    }

    #[test]
    fn powers_satisfy_their_error_bound() {
        let mut worst: f64 = 0.0;
        for n in [-0.2, 0.2, 1.0 / 3.2, 1.1, 1.2, 2.2, 3.2, 5.7] {
            for x in octaves(20_000) {
                let bound = (1.1 + 3.5 * (n * x.log2()).abs()) * 0.5 * f64::EPSILON;
                // The quotient and the standard library's power add their own rounding errors.
                let off = ((pow(x, n) / x.powf(n) - 1.0).abs() - f64::EPSILON).max(0.0);
                worst = worst.max(off / bound);
            }
        }
        assert!(worst <= 1.0, "{worst} of the error bound");
        let depths = || uniform(10_000).map(|x| 1e-7 * (1.0 + x));
        assert!(depths().all(|x| (pow(x, 2.2) / x.powf(2.2) - 1.0).abs() < 2e-14));
    }

    #[test]
    fn integer_and_half_integer_powers_are_products() {
        for x in octaves(1000) {
            assert_eq!([0.0, 1.0, 2.0, 3.0].map(|n| pow(x, n)), [1.0, x, x * x, x * x * x]);
            assert_eq!([0.5, 1.5, 2.5].map(|n| pow(x, n)), [x.sqrt(), x * x.sqrt(), x * x * x.sqrt()]);
            assert!(max_ulp_error([4.0, 3.5].map(|n| (pow(x, n), x.powf(n))).into_iter()) <= 2.0);
        }
        assert_eq!([2, -2, 0, 11].map(|n| powi(10.0, n)), [100.0, 0.01, 1.0, 1e11]);
    }

    #[test]
    fn powers_have_the_correct_limits() {
        assert_eq!([0.0, 0.5, 1.0, 2.2].map(|n| pow(0.0, n)), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(
            (pow(0.0, -0.2), pow(f64::INFINITY, -0.2), pow(f64::INFINITY, 2.2)),
            (f64::INFINITY, 0.0, f64::INFINITY)
        );
        assert_eq!((pow(1e300, 2.2), pow(1e-300, 2.2), pow(1.0, 2.2)), (f64::INFINITY, 0.0, 1.0));
        assert!(pow(f64::NAN, 2.2).is_nan() && pow(f64::NAN, 1.5).is_nan() && pow(-1.0, 2.2).is_nan());
    }

    /// Mirrored scenes stay exact mirror images.
    #[test]
    fn sines_are_exactly_odd_and_cosines_exactly_even() {
        for x in uniform(10_000).map(|x| 20.0 * x) {
            let ((s, c), (mirrored_s, mirrored_c)) = (sin_cos(x), sin_cos(-x));
            assert_eq!((mirrored_s, mirrored_c), (-s, c));
            assert_eq!((sin(-x), cos(-x), tan(-x), atan2(-x, 0.3)), (-s, c, -tan(x), -atan2(x, 0.3)));
            assert_eq!((sin(x), cos(x)), (s, c));
        }
    }

    /// Hashes all bits of many values (Fowler–Noll–Vo): any difference between platforms changes the hash.
    #[test]
    fn results_are_bitwise_identical_on_every_platform() {
        let mut sum: u64 = 0xcbf2_9ce4_8422_2325;
        let mut hash = |value: f64| sum = (sum ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(23);
        for (x, y) in uniform(20_000).zip(octaves(20_000)) {
            let angle = 20.0 * x - 10.0;
            let (sine, cosine) = sin_cos(angle);
            let angle_functions = [sine, cosine, sin(angle), cos(angle), tan(angle), exp(angle), asin(2.0 * x - 1.0)];
            let magnitude_functions = [atan2(y, angle), hypot(y, angle), ln(y), log2(y), log10(y), cbrt(y), powi(y, 7)];
            let powers = [-0.2, 1.2, 1.5, 2.2, 3.0].map(|n| pow(y, n));
            angle_functions.into_iter().chain(magnitude_functions).chain(powers).for_each(&mut hash);
        }
        assert_eq!(sum, 0x6ec9_e56f_5776_342f, "{sum:#x}");
    }
}
