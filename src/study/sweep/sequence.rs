//! Points spread over a cube: low-discrepancy and random ones, each found from its index alone, so that a study that is taken
//! up again gets the same.
//!
//! * **halton**: radical inverses of the index in the first primes (Halton 1960), shifted by a random vector modulo 1
//!   (Cranley and Patterson 1976). Each first part of it fills the cube evenly, so a longer sample contains the shorter one.
//! * **latin-hypercube**: one point in each of `count` slices of every axis (McKay, Beckman and Conover 1979).
//! * **random**: independent points, for statistics.
//!
//! The libraries of such sequences either give `f32` or bring an algebra of their own along; these are short.

use crate::study::random::{scramble, unit};

/// The first primes: bases of the axes of a Halton sequence. Beyond these the points of two axes go hand in hand for too long.
const PRIMES: [u64; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// Most axes of a Halton sequence.
pub const MOST_HALTON: usize = PRIMES.len();

/// How a sample is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Halton,
    LatinHypercube,
    Random,
}

/// The points of a sample.
#[derive(Clone, Debug)]
pub struct Sequence {
    method: Method,
    count: u64,
    seed: u64,
    /// Slices of every axis of a Latin hypercube, by point.
    slices: Vec<Vec<u32>>,
}

impl Sequence {
    /// `count` points in so many dimensions; at most [`u32::MAX`].
    pub fn new(method: Method, count: u64, seed: u64, dimensions: usize) -> Self {
        let shuffled =
            |axis: usize| shuffle(u32::try_from(count).unwrap_or(u32::MAX), seed ^ scramble(axis as u64 + 1));
        let slices = match method {
            Method::LatinHypercube => (0..dimensions).map(shuffled).collect(),
            Method::Halton | Method::Random => Vec::new(),
        };
        Sequence { method, count, seed, slices }
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    /// Coordinate of a point on one axis, within [0, 1).
    pub fn at(&self, point: u64, axis: usize) -> f64 {
        match self.method {
            Method::Halton => {
                let shift = unit(scramble(self.seed ^ scramble(axis as u64 + 1)));
                (inverse(point + 1, PRIMES[axis % PRIMES.len()]) + shift).fract()
            }
            Method::LatinHypercube => {
                let slice = self.slices.get(axis).and_then(|slices| slices.get(point as usize)).copied().unwrap_or(0);
                let within = unit(scramble(self.seed ^ scramble(scramble(point) ^ axis as u64)));
                ((f64::from(slice) + within) / self.count as f64).min(1.0 - f64::EPSILON)
            }
            Method::Random => unit(scramble(self.seed ^ scramble(scramble(point) ^ axis as u64))),
        }
    }
}

/// The digits of an index, mirrored at the point.
fn inverse(mut index: u64, base: u64) -> f64 {
    let (mut value, mut weight) = (0.0, 1.0);
    while index > 0 {
        weight /= base as f64;
        value += weight * (index % base) as f64;
        index /= base;
    }
    value
}

/// 0 … count − 1 in random order (Fisher and Yates).
fn shuffle(count: u32, seed: u64) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count).collect();
    for last in (1..order.len()).rev() {
        let other = scramble(seed ^ scramble(last as u64)) % (last as u64 + 1);
        order.swap(last, other as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest deviation of the share of points within [0, x) from x, over one axis.
    fn discrepancy(sequence: &Sequence, axis: usize) -> f64 {
        let mut points: Vec<f64> = (0..sequence.count()).map(|point| sequence.at(point, axis)).collect();
        points.sort_by(f64::total_cmp);
        let count = points.len() as f64;
        let deviation =
            |(index, x): (usize, &f64)| (index as f64 / count - x).abs().max(((index + 1) as f64 / count - x).abs());
        points.iter().enumerate().map(deviation).fold(0.0, f64::max)
    }

    #[test]
    fn radical_inverses_are_those_of_the_books() {
        assert_eq!([1, 2, 3, 4, 5].map(|index| inverse(index, 2)), [0.5, 0.25, 0.75, 0.125, 0.625]);
        assert!((inverse(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn every_slice_of_a_latin_hypercube_has_one_point() {
        let sequence = Sequence::new(Method::LatinHypercube, 1000, 7, 3);
        for axis in 0..3 {
            let mut slices: Vec<u64> = (0..1000).map(|point| (sequence.at(point, axis) * 1000.0) as u64).collect();
            slices.sort_unstable();
            assert!(slices.into_iter().eq(0..1000));
        }
    }

    #[test]
    fn low_discrepancy_sequences_are_more_even_than_chance() {
        for axis in 0..6 {
            let [halton, latin, random] = [Method::Halton, Method::LatinHypercube, Method::Random]
                .map(|method| discrepancy(&Sequence::new(method, 4096, 1, 6), axis));
            assert!(halton < 0.005 && latin <= 2.0 / 4096.0, "{halton} {latin}");
            assert!(random > 0.005 && random < 0.04, "{random}");
        }
    }

    #[test]
    fn a_longer_halton_sample_begins_with_the_shorter_one_and_seeds_differ() {
        let [short, long, other] =
            [(100, 1), (1000, 1), (100, 2)].map(|(count, seed)| Sequence::new(Method::Halton, count, seed, 4));
        for point in 0..100 {
            for axis in 0..4 {
                let x = short.at(point, axis);
                assert!((0.0..1.0).contains(&x));
                assert_eq!(x, long.at(point, axis));
                assert_ne!(x, other.at(point, axis));
            }
        }
    }

    #[test]
    fn axes_of_random_points_are_independent() {
        let sequence = Sequence::new(Method::Random, 10_000, 3, 2);
        let products = (0..10_000).map(|point| (sequence.at(point, 0) - 0.5) * (sequence.at(point, 1) - 0.5));
        // Its standard deviation is 1/12/√10000 = 8e-4.
        assert!((products.sum::<f64>() / 1e4).abs() < 3e-3);
    }
}
