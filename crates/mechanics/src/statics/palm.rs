//! The force of the object on the palm (thesis (3.2), errata 10).

use crate::gripper::FinalPosture;
use crate::numeric::elementary::sin_cos;

/// PFP = F22 (sin φ_c + μ cos φ_c) − F21 (cos q21 − μ sin q21), in N: force of the object on the palm due to one
/// finger.
///
/// Friction on the object points along each phalanx towards its joint, that is, towards the palm as long as the phalanx
/// rises from its joint to its end. A second finger, the mirror image, contributes the same force and balances the
/// component parallel to the palm.
pub fn palm_force(end: &FinalPosture, f21_n: f64, f22_n: f64, mu: f64) -> f64 {
    palm_force_with_mu(end, [f21_n, f22_n], [mu; 2])
}

/// [`palm_force`] of [F21, F22] with separate friction coefficients of the contacts.
pub fn palm_force_with_mu(end: &FinalPosture, [f21_n, f22_n]: [f64; 2], [mu_21, mu_22]: [f64; 2]) -> f64 {
    let (sin_c, cos_c) = sin_cos(end.phi_c_rad);
    let (sin_21, cos_21) = sin_cos(end.posture.q21_rad);
    f22_n * (sin_c + mu_22 * cos_c) - f21_n * (cos_21 - mu_21 * sin_21)
}
