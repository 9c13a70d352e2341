//! Reproducible random numbers: SplitMix64 (Steele, Lea and Flood 2014), whose sequence is fixed by its definition. The
//! generators of a library may change with its version, and stored results could not be reproduced.

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
}
