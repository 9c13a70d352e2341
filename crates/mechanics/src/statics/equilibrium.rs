//! Contact forces in static equilibrium (thesis §2.1.4, errata 4 and 9), and the resulting force of the object on the
//! palm (thesis (3.2), errata 10).

use super::error::number;
use super::{StaticKinematics, StaticsError, static_kinematics};
use crate::fivebar::kinematics::{reference_gamma, straight_directions};
use crate::fivebar::spring::SpringModel;
use crate::gripper::{Assembly, FinalPosture, Finger, Spring};
use crate::numeric::elementary::{cos, sin, sin_cos};

/// Smallest lever with which a torque can produce a contact force, in m.
pub(super) const MIN_LEVER_M: f64 = 1e-9;

/// Normal forces of both contacts at rest, positive in compression, and the resulting force on the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    pub f21_n: f64,
    pub f22_n: f64,
    pub pfp_n: f64,
}

/// Phalanges that would have to pull: they separate instead, and the object is ejected (thesis §1.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ejection {
    None,
    Proximal,
    Distal,
    Both,
}

impl Equilibrium {
    /// Returns whether the grasp is force-positive (thesis §1.2.3): neither contact has to pull.
    pub fn is_force_positive(&self) -> bool {
        self.f21_n >= 0.0 && self.f22_n >= 0.0
    }

    /// Returns whether the grasp is palm-force-positive (thesis §3.4.2): the object is not lifted off the palm.
    pub fn is_palm_force_positive(&self) -> bool {
        self.pfp_n >= 0.0
    }

    /// Returns the phalanges that separate.
    pub fn ejection(&self) -> Ejection {
        match (self.f21_n >= 0.0, self.f22_n >= 0.0) {
            (true, true) => Ejection::None,
            (false, true) => Ejection::Proximal,
            (true, false) => Ejection::Distal,
            (false, false) => Ejection::Both,
        }
    }
}

/// τ_a + τ_s on (q11, q21) at the final posture, in N·m (2.30), (2.31): motor torque and spring.
///
/// The spring may be of any kind and placement. The deflection of a torsional spring is relative to the straight
/// configuration; in the other assembly mode, which has no straight configuration, it is less than a turn.
///
/// # Errors
/// Returns an error if the torque is not finite, and for the singular postures of [`static_kinematics`].
pub fn drive_loads(
    finger: &Finger,
    end: &FinalPosture,
    motor_n_m: f64,
    spring: Option<&Spring>,
) -> Result<[f64; 2], StaticsError> {
    number("the motor torque", motor_n_m, true, "must be finite")?;
    let [s11, s21] = spring_loads(finger, &static_kinematics(finger, end)?, spring)?;
    Ok([motor_n_m + s11, s21])
}

/// τ_s on (q11, q21) in any posture, in N·m (2.30), as in [`drive_loads`].
pub(super) fn spring_loads(
    finger: &Finger,
    StaticKinematics { pose, rates, .. }: &StaticKinematics,
    spring: Option<&Spring>,
) -> Result<[f64; 2], StaticsError> {
    let Some(spring) = spring else { return Ok([0.0; 2]) };
    let reference = reference_gamma(&finger.lengths);
    let model = match finger.assembly {
        Assembly::Reference => {
            SpringModel::new(spring, &finger.lengths, reference, &straight_directions(&finger.lengths))
        }
        Assembly::Other => SpringModel::new(spring, &finger.lengths, -reference, pose),
    };
    let [s11, s21] = model.generalised_force(pose, rates);
    number("the spring's torque", s11 + s21, true, "must be finite")?;
    Ok([s11, s21])
}

/// J_C = [J_C21, J_C22] of (2.32), J_C2j = J_P2jᵀ (n + μ t) (errata 9), in m: generalised forces on (q11, q21) per
/// newton of normal force; `jacobian[i][j]` belongs to coordinate i and contact j.
///
/// n points from the object into the phalanx. Friction on the object is directed towards the palm, and friction on the
/// phalanx along t, from its joint to its end.
///
/// # Errors
/// Returns an error for the singular postures of [`static_kinematics`].
pub fn contact_jacobian(
    finger: &Finger,
    end: &FinalPosture,
    mu_static: [f64; 2],
) -> Result<[[f64; 2]; 2], StaticsError> {
    let StaticKinematics { rates, .. } = static_kinematics(finger, end)?;
    let (l21, w) = (finger.lengths.l21_m, finger.lengths.half_width_m);
    let bend = end.posture.q22_rad + finger.lengths.phi22_rad;
    // Contributions of q̇21 and of the absolute tip rate θ̇4 = a4·q̇ to J_Pᵀ n and J_Pᵀ t of the contact points.
    let proximal = -end.l_c21_m - mu_static[0] * w;
    let from_proximal = -l21 * cos(bend) + mu_static[1] * l21 * sin(bend);
    let from_tip = -end.l_c22_m - mu_static[1] * w;
    let [a0, a1] = rates.a4;
    Ok([[0.0, from_tip * a0], [proximal, from_proximal + from_tip * a1]])
}

/// Normal forces [F21, F22] = −J_C⁻¹ (τ_a + τ_s) (2.32) at the final posture, with friction μ_s at both contacts.
///
/// `loads` is τ_a + τ_s of [`drive_loads`], without weight. For a constant spring on q22 without friction,
/// F22 ≥ 0 ⇔ τ11 ≥ k_s ∂q22/∂q11.
///
/// # Errors
/// Returns an error if a load or a friction coefficient is out of range or the tip contact has no lever arm, and for
/// the singular postures of [`static_kinematics`].
pub fn equilibrium(
    finger: &Finger,
    end: &FinalPosture,
    loads: [f64; 2],
    mu_static: f64,
) -> Result<Equilibrium, StaticsError> {
    equilibrium_with_mu(finger, end, loads, [mu_static; 2])
}

/// [`equilibrium`] with separate friction coefficients for the proximal and the distal contact.
///
/// # Errors
/// See [`equilibrium`].
pub fn equilibrium_with_mu(
    finger: &Finger,
    end: &FinalPosture,
    loads: [f64; 2],
    mu_static: [f64; 2],
) -> Result<Equilibrium, StaticsError> {
    number("the load on q11", loads[0], true, "must be finite")?;
    number("the load on q21", loads[1], true, "must be finite")?;
    for mu in mu_static {
        number("mu_static", mu, mu >= 0.0, "must be finite, 0 or more")?;
    }
    let lever_m = end.l_c22_m + mu_static[1] * finger.lengths.half_width_m;
    if lever_m < MIN_LEVER_M {
        return Err(StaticsError::NoLever { lever_m });
    }
    let [[_, j12], [j21, j22]] = contact_jacobian(finger, end, mu_static)?;
    let f22_n = -loads[0] / j12;
    let f21_n = -(loads[1] + j22 * f22_n) / j21;
    Ok(Equilibrium { f21_n, f22_n, pfp_n: palm_force_with_mu(end, [f21_n, f22_n], mu_static) })
}

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
