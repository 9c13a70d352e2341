//! The first step of an impact.

use super::mode::is_kinked;
use crate::law::NormalLaw;
use crate::numeric::elementary::{cbrt, pow, powi};

/// First step of an impact, as a fraction of the time that the impact needs to stop.
const RESTART_FRACTION: f64 = 0.05;
/// The same fraction for an impact stopped by a spring with a kink: the first step misses (h/T)^(e+1) of its impulse.
const KINKED_FRACTION: f64 = 0.01;

/// First step of an impact at `speed` of an effective `mass`: a part of the time scale depth / speed, with the smaller
/// of the depths at which damper or spring alone absorbs the momentum.
///
/// Damper alone: m v = c_max (δ³/δ_max² − …); spring alone: m v² / 2 = k δᵉ⁺¹/(e + 1).
pub(crate) fn first_impact_step(law: &NormalLaw, speed: f64, mass: f64) -> f64 {
    let [damper, spring] = stopping_depths(law, speed, mass);
    let fraction = if is_kinked(law) && spring < damper { KINKED_FRACTION } else { RESTART_FRACTION };
    fraction * (damper.min(spring) / speed.max(MIN_IMPACT_SPEED))
}

/// Lower bound of the impact speed, against division by zero, m/s.
const MIN_IMPACT_SPEED: f64 = 1e-6;

/// Depths at which damper and spring, each alone, would stop an impact.
fn stopping_depths(law: &NormalLaw, speed: f64, mass: f64) -> [f64; 2] {
    let speed = speed.max(MIN_IMPACT_SPEED);
    let damper_depth = if law.damping_max() > 0.0 {
        cbrt(mass * speed * powi(law.depth_scale_m(), 2) / law.damping_max())
    } else {
        f64::INFINITY
    };
    let spring_depth =
        pow(0.5 * (law.exponent + 1.0) * mass * speed * speed / law.stiffness_n_per_m_e, 1.0 / (law.exponent + 1.0));
    [damper_depth, spring_depth]
}
