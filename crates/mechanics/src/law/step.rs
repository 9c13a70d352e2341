//! The damper of the thesis: c(δ) = c_max σ(δ/δ_max) (thesis (2.39), errata 7).

use crate::numeric::elementary::cbrt;

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

/// c(δ) and dc/dδ.
#[inline(always)]
pub(super) fn damping(max_n_s_per_m: f64, transition_m: f64, delta: f64) -> (f64, f64) {
    let (sigma, slope) = smoothstep(delta / transition_m);
    (max_n_s_per_m * sigma, max_n_s_per_m * slope / transition_m)
}

/// Depth at which the damper alone stops a mass.
pub(super) fn stopping_depth(max_n_s_per_m: f64, transition_m: f64, speed: f64, inverse_mass: f64) -> f64 {
    // v(δ) = v₀ − (c/m)(δ³/δ_max² − …), linear beyond the transition.
    let excess_depth = speed / (max_n_s_per_m * inverse_mass) - 0.5 * transition_m;
    match excess_depth > 0.0 {
        true => transition_m + excess_depth,
        false => cbrt(speed * transition_m * transition_m / (max_n_s_per_m * inverse_mass)),
    }
}
