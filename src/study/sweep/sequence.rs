//! Low-discrepancy and random points in a unit cube. Each point follows from its index alone, so that a resumed study
//! gets the same points.
//!
//! * **halton**: radical inverses of the index in the first primes (Halton 1960), shifted by a random vector modulo 1
//!   (Cranley and Patterson 1976). Every prefix covers the cube evenly, and a longer sample contains the shorter one.
//! * **latin-hypercube**: one point in each of `count` slices of every axis (McKay, Beckman and Conover 1979).
//! * **random**: independent points, for statistics.
//!
//! Existing libraries for such sequences either return `f32` or depend on a linear algebra library.

use schemars::JsonSchema;
use serde::Deserialize;

/// The first primes: bases of the axes of a Halton sequence. For larger bases, two axes are correlated over too many
/// points.
const PRIMES: [u64; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// Increment of the state of SplitMix64: 2⁶⁴ over the golden ratio.
const INCREMENT: u64 = 0x9e37_79b9_7f4a_7c15;

/// Maximum number of axes of a Halton sequence.
pub(super) const MAX_HALTON_AXES: usize = PRIMES.len();

/// Sampling method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Method {
    #[default]
    Halton,
    LatinHypercube,
    Random,
}

/// The points of a sample.
#[derive(Clone, Debug)]
pub(super) struct Sequence {
    method: Method,
    count: u64,
    seed: u64,
    /// Slice of each point on every axis of a Latin hypercube.
    slices: Vec<Vec<u32>>,
}

impl Sequence {
    /// Creates a sequence of `count` points. For a Latin hypercube, at most [`u32::MAX`] points are allowed.
    pub fn new(method: Method, count: u64, seed: u64, dimensions: usize) -> Self {
        let slices_of_axis = |axis: usize| {
            random_permutation(u32::try_from(count).unwrap_or(u32::MAX), seed ^ scramble(axis as u64 + 1))
        };
        let slices = match method {
            Method::LatinHypercube => (0..dimensions).map(slices_of_axis).collect(),
            Method::Halton | Method::Random => Vec::new(),
        };
        Sequence { method, count, seed, slices }
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the coordinate of a point along an axis, in [0, 1).
    pub fn coordinate(&self, point: u64, axis: usize) -> f64 {
        match self.method {
            Method::Halton => {
                let shift = unit_interval(scramble(self.seed ^ scramble(axis as u64 + 1)));
                (radical_inverse(point + 1, PRIMES[axis % PRIMES.len()]) + shift).fract()
            }
            Method::LatinHypercube => {
                let slice = self.slices.get(axis).and_then(|slices| slices.get(point as usize)).copied().unwrap_or(0);
                let offset = unit_interval(scramble(self.seed ^ scramble(scramble(point) ^ axis as u64)));
                ((f64::from(slice) + offset) / self.count as f64).min(1.0 - f64::EPSILON)
            }
            Method::Random => unit_interval(scramble(self.seed ^ scramble(scramble(point) ^ axis as u64))),
        }
    }
}

/// Radical inverse: the digits of an index, mirrored at the radix point.
fn radical_inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f64;
        value += weight * (index % base) as f64;
        index /= base;
    }
    value
}

/// Random permutation of 0 … `count` − 1 (Fisher and Yates).
fn random_permutation(count: u32, seed: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..order.len()).rev() {
        let other = scramble(seed ^ scramble(last as u64)) % (last as u64 + 1);
        order.swap(last, other as usize);
    }
    order
}

/// Output of SplitMix64 (Steele, Lea and Flood 2014) for the state after `state`. Its sequence is fixed by its
/// definition; the generators of a library may change with its version.
fn scramble(state: u64) -> u64 {
    let mut z = state.wrapping_add(INCREMENT);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Converts the upper 53 bits to a number in [0, 1).
fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference: output of the authors' code for the seed 1234567.
    #[test]
    fn scramble_matches_the_reference_sequence() {
        let states = [0, 1, 2].map(|step: u64| 1_234_567u64.wrapping_add(step.wrapping_mul(INCREMENT)));
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!(states.map(scramble), expected);
    }

    /// Largest deviation of the fraction of points in [0, x) from x on one axis.
    fn discrepancy(sequence: &Sequence, axis: usize) -> f64 {
        let mut points: Vec<f64> = (0..sequence.count()).map(|point| sequence.coordinate(point, axis)).collect();
        points.sort_by(f64::total_cmp);
        let count = points.len() as f64;
        let deviation =
            |(index, x): (usize, &f64)| (index as f64 / count - x).abs().max(((index + 1) as f64 / count - x).abs());
        points.iter().enumerate().map(deviation).fold(0.0, f64::max)
    }

    #[test]
    fn radical_inverse_matches_reference_values() {
        assert_eq!([1, 2, 3, 4, 5].map(|index| radical_inverse(index, 2)), [0.5, 0.25, 0.75, 0.125, 0.625]);
        assert!((radical_inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn low_discrepancy_sequences_are_more_even_than_random_points() {
        for axis in 0..6 {
            let [halton, latin, random] = [Method::Halton, Method::LatinHypercube, Method::Random]
                .map(|method| discrepancy(&Sequence::new(method, 4096, 1, 6), axis));
            assert!(halton < 0.005 && latin <= 2.0 / 4096.0, "{halton} {latin}");
            assert!(random > 0.005 && random < 0.04, "{random}");
        }
    }

    #[test]
    fn a_longer_halton_sample_contains_the_shorter_one_and_depends_on_the_seed() {
        let [short, long, other] =
            [(100, 1), (1000, 1), (100, 2)].map(|(count, seed)| Sequence::new(Method::Halton, count, seed, 4));
        for point in 0..100 {
            for axis in 0..4 {
                let x = short.coordinate(point, axis);
                assert!((0.0..1.0).contains(&x));
                assert_eq!(x, long.coordinate(point, axis));
                assert_ne!(x, other.coordinate(point, axis));
            }
        }
    }

    #[test]
    fn axes_of_random_points_are_independent() {
        let sequence = Sequence::new(Method::Random, 10_000, 3, 2);
        let products =
            (0..10_000).map(|point| (sequence.coordinate(point, 0) - 0.5) * (sequence.coordinate(point, 1) - 0.5));
        // The standard deviation of the mean is 1/12/√10000 = 8e-4.
        assert!((products.sum::<f64>() / 1e4).abs() < 3e-3);
    }
}
