//! Stiff contacts that oscillate about their equilibrium depth for longer than they can be resolved.

use crate::integrator::Tolerances;
use crate::law::{NormalLaw, damping};
use crate::numeric::elementary::pow;

/// Largest contact rate that counts as chatter, m/s (limit: rad/s), at a relative tolerance of 1e-5; it decreases with
/// the square root of the tolerance. Projecting a contact to equilibrium changes the rate with which it is released
/// later, so finer runs, including those of a check, use a smaller limit.
const MAX_CHATTER_RATE: f64 = 0.05;
/// Smallest [`MAX_CHATTER_RATE`]: the reference, too, must treat 3e-3 rad/s as chatter (scenes/hard/limit-trembles).
const MIN_CHATTER_RATE_LIMIT: f64 = 5e-3;
/// Largest depth that counts as chatter, m (limit: rad).
const MAX_CHATTER_DEPTH: f64 = 1e-8;
/// Largest damping of a chattering contact, as a fraction of the critical damping.
const MAX_CHATTER_DAMPING_RATIO: f64 = 0.1;
/// Step of the central difference of a row along the free motion, s.
pub(in crate::analytic) const DIFFERENCE_STEP_S: f64 = 1e-7;

/// Largest contact rate that counts as chatter at these tolerances.
pub(in crate::analytic) fn max_chatter_rate(tolerances: &Tolerances) -> f64 {
    let max_rate = MAX_CHATTER_RATE * (tolerances.rtol_v / 1e-5).sqrt();
    max_rate.clamp(MIN_CHATTER_RATE_LIMIT, MAX_CHATTER_RATE)
}

/// Whether a contact with this depth and rate may chatter about its equilibrium depth.
pub(in crate::analytic) fn may_chatter(law: &NormalLaw, [depth, rate]: [f64; 2], max_rate: f64) -> bool {
    depth.abs() <= MAX_CHATTER_DEPTH && rate.abs() <= max_rate && law.stiffness_n_per_m_e != 0.0
}

/// Impulses along the normal row, per mobility, that move a contact to its equilibrium depth and remove its rate.
#[derive(Clone, Copy, Debug)]
pub(in crate::analytic) struct Settling {
    pub of_depth: f64,
    pub of_rate: f64,
    /// Decay rate of the oscillation, 1/s.
    pub decay_rate: f64,
}

/// Returns what brings a contact to rest at its equilibrium depth, where the spring balances the load; `None` if the
/// contact does not chatter about that depth. `free_acceleration` is that of the gap without the contact, and `mobility`
/// the acceleration of the gap per force.
pub(in crate::analytic) fn settling(
    law: &NormalLaw,
    [depth, rate]: [f64; 2],
    free_acceleration: f64,
    mobility: f64,
) -> Option<Settling> {
    let load = -free_acceleration / mobility;
    if load.is_nan() || load <= 0.0 {
        return None;
    }
    let equilibrium = pow(load / law.stiffness_n_per_m_e, 1.0 / law.exponent);
    let stiffness = law.exponent * load / equilibrium;
    let critical = 2.0 * (stiffness / mobility).sqrt();
    if equilibrium > MAX_CHATTER_DEPTH || damping(law, equilibrium).0 > MAX_CHATTER_DAMPING_RATIO * critical {
        return None;
    }
    let decay_rate = 0.5 * damping(law, equilibrium).0 * mobility;
    Some(Settling { of_depth: (depth - equilibrium) / mobility, of_rate: rate / mobility, decay_rate })
}
