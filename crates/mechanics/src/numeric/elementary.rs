//! Elementary functions of one library for every platform.
//!
//! Sums, products, quotients and square roots are rounded the same everywhere; sines and powers of a system's C library are not, and
//! impacts multiply last digits. The core calls none but these, and clippy refuses it all others.

use std::f64::consts::LOG2_E;

#[inline(always)]
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

#[inline(always)]
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// (sin x, cos x), for less than the two.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

#[inline(always)]
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

#[inline(always)]
pub fn asin(x: f64) -> f64 {
    libm::asin(x)
}

/// Angle of (x, y), in [−π, π].
#[inline(always)]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// √(x² + y²), without overflow between.
#[inline(always)]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

#[inline(always)]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

#[inline(always)]
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

#[inline(always)]
pub fn log2(x: f64) -> f64 {
    libm::log2(x)
}

#[inline(always)]
pub fn log10(x: f64) -> f64 {
    libm::log10(x)
}

#[inline(always)]
pub fn cbrt(x: f64) -> f64 {
    libm::cbrt(x)
}

/// Exponents, doubled, up to which xⁿ is products and a square root: those of the laws that are Hertz's, or linear.
const MOST_HALVES: i32 = 8;

/// xⁿ for x ≥ 0, to (1.1 + 3.5 |n log₂ x|) 2⁻⁵³ of it: five roundings of the logarithm, one of its power. For the 2.2nd power of a depth of
/// 1e-7 m that is 2e-14; the depth is a difference of lengths, and known to 1e-10. A power to the last digit would take three times as
/// long. Whole and half n, as far as 4, are products and cost less.
#[inline]
pub fn pow(x: f64, n: f64) -> f64 {
    let halves = (2.0 * n) as i32;
    if f64::from(halves) == 2.0 * n && (0..=MOST_HALVES).contains(&halves) {
        let whole = powi(x, halves / 2);
        return if halves % 2 == 0 { whole } else { whole * x.sqrt() };
    }
    libm::exp2(n * LOG2_E * libm::log(x))
}

/// xⁿ by products: what the standard library makes of it is not said to be the same everywhere.
#[inline]
pub fn powi(x: f64, n: i32) -> f64 {
    let (mut product, mut square, mut left) = (1.0, x, n.unsigned_abs());
    while left > 0 {
        if left % 2 == 1 {
            product *= square;
        }
        square *= square;
        left /= 2;
    }
    if n < 0 { 1.0 / product } else { product }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1), the same on every platform: products and sums of 64-bit integers.
    fn evenly(count: usize) -> impl Iterator<Item = f64> {
        let next =
            |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        std::iter::successors(Some(1), next)
            .skip(1)
            .take(count)
            .map(|state| (state >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Numbers between 2^−30 and 2^30, as many in each octave.
    fn octaves(count: usize) -> impl Iterator<Item = f64> {
        evenly(count).zip(evenly(2 * count).skip(count)).map(|(x, y)| (1.0 + x) * powi(2.0, (60.0 * y) as i32 - 30))
    }

    /// The largest difference, in last digits of `exact`.
    fn most_ulp(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
        pairs.fold(0.0, |most, (got, exact)| {
            assert!(got.is_finite() && exact.is_finite());
            let ulp = f64::from_bits(exact.abs().to_bits() + 1) - exact.abs();
            most.max((got - exact).abs() / ulp)
        })
    }

    /// Both are within one last digit of the truth.
    #[test]
    fn all_are_the_standard_library_s_to_two_last_digits() {
        let angles = || evenly(100_000).map(|x| 20.0 * x - 10.0);
        let unit = || evenly(100_000).map(|x| 2.0 * x - 1.0);
        let both = || octaves(100_000).zip(octaves(150_000).skip(50_000));
        for (name, most) in [
            ("sin", most_ulp(angles().map(|x| (sin(x), x.sin())))),
            ("cos", most_ulp(angles().map(|x| (cos(x), x.cos())))),
            ("sine of both", most_ulp(angles().map(|x| (sin_cos(x).0, x.sin())))),
            ("cosine of both", most_ulp(angles().map(|x| (sin_cos(x).1, x.cos())))),
            ("tan", most_ulp(angles().map(|x| (tan(x), x.tan())))),
            ("asin", most_ulp(unit().map(|x| (asin(x), x.asin())))),
            ("atan2", most_ulp(both().map(|(y, x)| (atan2(y, x), y.atan2(x))))),
            ("hypot", most_ulp(both().map(|(x, y)| (hypot(x, y), x.hypot(y))))),
            ("exp", most_ulp(angles().map(|x| (exp(x), x.exp())))),
            ("ln", most_ulp(octaves(100_000).map(|x| (ln(x), x.ln())))),
            ("log2", most_ulp(octaves(100_000).map(|x| (log2(x), x.log2())))),
            ("log10", most_ulp(octaves(100_000).map(|x| (log10(x), x.log10())))),
            ("cbrt", most_ulp(octaves(100_000).map(|x| (cbrt(x), x.cbrt())))),
        ] {
            assert!(most <= 2.0, "{name}: {most} last digits");
        }
    }

    #[test]
    fn powers_are_as_exact_as_they_are_said_to_be() {
        let mut most: f64 = 0.0;
        for n in [-0.2, 0.2, 1.0 / 3.2, 1.1, 1.2, 2.2, 3.2, 5.7] {
            for x in octaves(20_000) {
                let bound = (1.1 + 3.5 * (n * x.log2()).abs()) * 0.5 * f64::EPSILON;
                // The quotient and the standard library's power have errors of their own.
                let off = ((pow(x, n) / x.powf(n) - 1.0).abs() - f64::EPSILON).max(0.0);
                most = most.max(off / bound);
            }
        }
        assert!(most <= 1.0, "{most} of what is said");
        let depths = || evenly(10_000).map(|x| 1e-7 * (1.0 + x));
        assert!(depths().all(|x| (pow(x, 2.2) / x.powf(2.2) - 1.0).abs() < 2e-14));
    }

    #[test]
    fn whole_and_half_powers_are_products() {
        for x in octaves(1000) {
            assert_eq!([0.0, 1.0, 2.0, 3.0].map(|n| pow(x, n)), [1.0, x, x * x, x * x * x]);
            assert_eq!([0.5, 1.5, 2.5].map(|n| pow(x, n)), [x.sqrt(), x * x.sqrt(), x * x * x.sqrt()]);
            assert!(most_ulp([4.0, 3.5].map(|n| (pow(x, n), x.powf(n))).into_iter()) <= 2.0);
        }
        assert_eq!([2, -2, 0, 11].map(|n| powi(10.0, n)), [100.0, 0.01, 1.0, 1e11]);
    }

    #[test]
    fn powers_have_the_limits_of_a_power() {
        assert_eq!([0.0, 0.5, 1.0, 2.2].map(|n| pow(0.0, n)), [1.0, 0.0, 0.0, 0.0]);
        assert_eq!(
            (pow(0.0, -0.2), pow(f64::INFINITY, -0.2), pow(f64::INFINITY, 2.2)),
            (f64::INFINITY, 0.0, f64::INFINITY)
        );
        assert_eq!((pow(1e300, 2.2), pow(1e-300, 2.2), pow(1.0, 2.2)), (f64::INFINITY, 0.0, 1.0));
        assert!(pow(f64::NAN, 2.2).is_nan() && pow(f64::NAN, 1.5).is_nan() && pow(-1.0, 2.2).is_nan());
    }

    /// Mirror images stay mirror images.
    #[test]
    fn sines_are_odd_and_cosines_even_to_the_last_digit() {
        for x in evenly(10_000).map(|x| 20.0 * x) {
            let ((s, c), (mirrored_s, mirrored_c)) = (sin_cos(x), sin_cos(-x));
            assert_eq!((mirrored_s, mirrored_c), (-s, c));
            assert_eq!((sin(-x), cos(-x), tan(-x), atan2(-x, 0.3)), (-s, c, -tan(x), -atan2(x, 0.3)));
            assert_eq!((sin(x), cos(x)), (s, c));
        }
    }

    /// All bits of many values: one that is another on some platform makes another sum (Fowler–Noll–Vo).
    #[test]
    fn every_platform_has_the_same_bits() {
        let mut sum: u64 = 0xcbf2_9ce4_8422_2325;
        let mut take = |value: f64| sum = (sum ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(23);
        for (x, y) in evenly(20_000).zip(octaves(20_000)) {
            let angle = 20.0 * x - 10.0;
            let (sine, cosine) = sin_cos(angle);
            let of_angle = [sine, cosine, sin(angle), cos(angle), tan(angle), exp(angle), asin(2.0 * x - 1.0)];
            let of_size = [atan2(y, angle), hypot(y, angle), ln(y), log2(y), log10(y), cbrt(y), powi(y, 7)];
            let powers = [-0.2, 1.2, 1.5, 2.2, 3.0].map(|n| pow(y, n));
            of_angle.into_iter().chain(of_size).chain(powers).for_each(&mut take);
        }
        assert_eq!(sum, 0x6ec9_e56f_5776_342f, "{sum:#x}");
    }
}
