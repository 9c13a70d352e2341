//! Reproducible random numbers: SplitMix64 (Steele, Lea and Flood 2014), whose sequence is fixed by its definition. The
//! generators of a library may change with its version, and stored results could not be reproduced.

use crate::numeric::elementary::{cos, ln};

/// Increment of the state: 2⁶⁴ over the golden ratio.
const INCREMENT: u64 = 0x9e37_79b9_7f4a_7c15;

/// Output of SplitMix64 for the state after `state`.
pub(super) fn scramble(state: u64) -> u64 {
    let mut z = state.wrapping_add(INCREMENT);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Converts the upper 53 bits to a number in [0, 1).
pub(super) fn unit_interval(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// Generator of random numbers.
#[derive(Clone, Debug)]
pub(super) struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    pub fn new(seed: u64) -> Self {
        SplitMix64 { state: scramble(seed) }
    }

    fn next(&mut self) -> u64 {
        let bits = scramble(self.state);
        self.state = self.state.wrapping_add(INCREMENT);
        bits
    }

    /// Uniform number in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        unit_interval(self.next())
    }

    /// Uniform index from 0 to `count` − 1.
    pub fn index_below(&mut self, count: usize) -> usize {
        (self.next() % count.max(1) as u64) as usize
    }

    /// Standard normal number (Box and Muller 1958; the second number of the pair is discarded).
    pub fn normal(&mut self) -> f64 {
        // 1 − u is above 0, so its logarithm is finite.
        let radius = (-2.0 * ln(1.0 - self.uniform())).sqrt();
        radius * cos(std::f64::consts::TAU * self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference: output of the authors' code for the seed 1234567.
    #[test]
    fn matches_the_reference_sequence() {
        let mut state = 1_234_567u64;
        let mut next = || {
            let bits = scramble(state);
            state = state.wrapping_add(INCREMENT);
            bits
        };
        assert_eq!(
            [next(), next(), next()],
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    #[test]
    fn distributions_have_the_expected_moments() {
        let mut random = SplitMix64::new(1);
        let count = 100_000;
        let normals: Vec<f64> = (0..count).map(|_| random.normal()).collect();
        let mean = normals.iter().sum::<f64>() / f64::from(count);
        let square = normals.iter().map(|x| x * x).sum::<f64>() / f64::from(count);
        // The standard deviations of these estimates are 0.0032 and 0.0045.
        assert!(mean.abs() < 0.013 && (square - 1.0).abs() < 0.018, "{mean} {square}");
        let mut counts = [0u32; 7];
        (0..70_000).for_each(|_| counts[random.index_below(7)] += 1);
        assert!(counts.iter().all(|bin| bin.abs_diff(10_000) < 400), "{counts:?}");
    }
}
