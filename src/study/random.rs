//! Random numbers that are the same wherever and whenever a study runs: SplitMix64 (Steele, Lea and Flood 2014), whose stream is fixed
//! by its definition. Those of a library may change with its version, and results on the disk with them.

use crate::numeric::elementary::{cos, ln};

/// What a stream goes on by: 2⁶⁴ over the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64, of the state after this one.
pub(super) fn scramble(state: u64) -> u64 {
    let mut z = state.wrapping_add(STEP);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 53 bits as a number within [0, 1).
pub(super) fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random {
    state: u64,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        Random { state: scramble(seed) }
    }

    fn next(&mut self) -> u64 {
        let bits = scramble(self.state);
        self.state = self.state.wrapping_add(STEP);
        bits
    }

    /// Evenly within [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit(self.next())
    }

    /// One of 0 … count − 1.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    /// Normally, of mean 0 and deviation 1 (Box and Muller 1958; the second number of the pair is left).
    pub fn normal(&mut self) -> f64 {
        // Above 0, for its logarithm.
        let radius = (-2.0 * ln(1.0 - self.unit())).sqrt();
        radius * cos(std::f64::consts::TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers that the authors' code gives for the seed 1234567.
    #[test]
    fn the_stream_is_splitmix64() {
        let mut state = 1_234_567u64;
        let mut next = || {
            let bits = scramble(state);
            state = state.wrapping_add(STEP);
            bits
        };
        assert_eq!(
            [next(), next(), next()],
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    #[test]
    fn numbers_are_spread_as_they_should_be() {
        let mut random = Random::new(1);
        let count = 100_000;
        let normals: Vec<f64> = (0..count).map(|_| random.normal()).collect();
        let mean = normals.iter().sum::<f64>() / f64::from(count);
        let square = normals.iter().map(|x| x * x).sum::<f64>() / f64::from(count);
        // Deviations of these estimates are 0.0032 and 0.0045.
        assert!(mean.abs() < 0.013 && (square - 1.0).abs() < 0.018, "{mean} {square}");
        let mut counts = [0u32; 7];
        (0..70_000).for_each(|_| counts[random.below(7)] += 1);
        assert!(counts.iter().all(|found| found.abs_diff(10_000) < 400), "{counts:?}");
    }
}
