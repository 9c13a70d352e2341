//! Contact forces in Birglen's formulation (thesis §1.2.1, §1.2.3): contact matrix, transmission matrix, forces.

use super::{StaticKinematics, StaticsError, static_kinematics};
use crate::gripper::{FinalPosture, Finger};
use crate::numeric::elementary::sin_cos;

/// J, T and f of one grasp. θ = (θ1, θ2) are the angle of the proximal phalanx and the angle of the tip relative to it;
/// the actuator angle is θ_a = q11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Birglen {
    /// J of (1.8), in m: normal velocities of the contacts J θ̇.
    pub jacobian_m: [[f64; 2]; 2],
    /// T of (1.10): θ̇ = T (θ̇_a, θ̇2). Its first row is (1, R_t).
    pub transmission: [[f64; 2]; 2],
    /// T⁻¹, which maps θ̇ to (θ̇_a, θ̇2).
    pub transmission_inverse: [[f64; 2]; 2],
    /// t = (T_a, T_2), in N·m: torques of motor and spring on (θ_a, θ2).
    pub torques_n_m: [f64; 2],
    /// f = J⁻ᵀ T⁻ᵀ t of (1.11), in N.
    pub forces_n: [f64; 2],
}

/// Forces of (1.11) for the loads τ_a + τ_s on (q11, q21) of [`drive_loads`](super::drive_loads).
///
/// Birglen's phalanges are lines. The lever of a normal force does not depend on the width, but friction on the surface
/// of a phalanx of half width w has the lever w about its joint. Hence the result agrees with
/// [`equilibrium`](fn@super::equilibrium) if μ w = 0.
///
/// # Errors
/// Returns an error for the singular postures of [`static_kinematics`], and if the tip contact is on its joint, where J
/// cannot be inverted.
pub fn birglen(finger: &Finger, end: &FinalPosture, loads: [f64; 2], mu_static: f64) -> Result<Birglen, StaticsError> {
    let StaticKinematics { tip_slope: [alpha, beta], .. } = static_kinematics(finger, end)?;
    let (l_c1, l_c2, l_1) = (end.l_c21_m, end.l_c22_m, finger.lengths.l21_m);
    if l_c2 < super::equilibrium::MIN_LEVER_M {
        return Err(StaticsError::NoLever { lever_m: l_c2 });
    }
    let (sin_2, cos_2) = sin_cos(end.posture.q22_rad + finger.lengths.phi22_rad);
    let jacobian_m = [[l_c1, 0.0], [l_c2 + l_1 * (cos_2 - mu_static * sin_2), l_c2]];
    // θ̇2 = α θ̇_a + β θ̇1, solved for θ̇1.
    let transmission = [[-alpha / beta, 1.0 / beta], [0.0, 1.0]];
    let transmission_inverse = [[-beta / alpha, 1.0 / alpha], [0.0, 1.0]];
    // Power: loads · (θ̇_a, θ̇1) = t · (θ̇_a, θ̇2).
    let [[t11, t12], _] = transmission;
    let torques_n_m = [loads[0] + loads[1] * t11, loads[1] * t12];
    // T⁻ᵀ t gives the torques on (θ1, θ2); J⁻ᵀ gives the forces.
    let [[i11, i12], _] = transmission_inverse;
    let on_phalanges = [i11 * torques_n_m[0], i12 * torques_n_m[0] + torques_n_m[1]];
    let f2 = on_phalanges[1] / jacobian_m[1][1];
    let f1 = (on_phalanges[0] - jacobian_m[1][0] * f2) / jacobian_m[0][0];
    Ok(Birglen { jacobian_m, transmission, transmission_inverse, torques_n_m, forces_n: [f1, f2] })
}
