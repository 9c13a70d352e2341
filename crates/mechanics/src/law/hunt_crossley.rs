//! The damper of Hunt and Crossley (1975): c(δ) = (3/2) a k δᵉ, so that F = k δᵉ (1 + (3/2) a δ̇).
//!
//! With b = 3 a/2, a rebound without other forces obeys b v₀ − ln(1 + b v₀) = −b v₁ − ln(1 − b v₁), for any mass,
//! stiffness and exponent.

use super::NormalLaw;
use crate::numeric::elementary::{ln_1p, pow};

/// c(δ) and dc/dδ.
#[inline(always)]
pub(super) fn damping(law: &NormalLaw, factor_s_per_m: f64, delta: f64) -> (f64, f64) {
    let power = 1.5 * factor_s_per_m * law.stiffness_n_per_m_e * pow(delta, law.exponent - 1.0);
    (power * delta, law.exponent * power)
}

/// Energy in the spring, per mass, at the greatest depth of an impact at `speed`: (b v − ln(1 + b v))/b².
pub(super) fn energy_at_greatest_depth(factor_s_per_m: f64, speed: f64) -> f64 {
    let b = 1.5 * factor_s_per_m;
    let x = b * speed;
    // The series avoids the cancellation at small x.
    if x < 1e-4 { 0.5 * speed * speed * (1.0 - 2.0 / 3.0 * x) } else { (x - ln_1p(x)) / (b * b) }
}
