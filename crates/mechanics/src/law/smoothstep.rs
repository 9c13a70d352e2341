//! The cubic STEP function used by both laws.

/// σ(s) = 3 s² − 2 s³ and dσ/ds, for s in 0…1; 0 below, 1 above (thesis (2.39), errata 7).
#[inline(always)]
pub fn smoothstep(s: f64) -> (f64, f64) {
    if s <= 0.0 {
        (0.0, 0.0)
    } else if s >= 1.0 {
        (1.0, 0.0)
    } else {
        (s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s))
    }
}
