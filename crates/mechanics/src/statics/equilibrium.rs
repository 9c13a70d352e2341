//! Contact forces in static equilibrium (thesis §2.1.4, errata 4 and 9), and the resulting force of the object on the
//! palm (thesis (3.2), errata 10).

use super::Result;
use crate::fivebar::kinematics::{
    Directions, PassiveRates, SINGULAR_SINE, SpringModel, passive_rates, reference_gamma, straight_directions,
};
use crate::gripper::{Assembly, FinalPosture, Finger, NumberError, Posture, PostureError, Spring, number};
use crate::numeric::elementary::{cos, sin, sin_cos};
use crate::numeric::plane::cross;

/// Error for a grasp whose forces or form closure cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StaticsError {
    #[error(transparent)]
    Number(#[from] NumberError),
    #[error(
        "l12 and l22 are in line in the final posture (the sine of their angle is {sine:.2e}, at least 1e-3 is needed): the \
         motor can resist any force on the distal phalanx there, so change phi22, l22 or l12"
    )]
    InLine { sine: f64 },
    #[error(
        "l11 and l12 are in line in the final posture (dq22/dq11 is {slope:.2e}): the motor cannot move the distal phalanx there, so \
         change l11, l12 or phi22"
    )]
    DeadPoint { slope: f64 },
    #[error(
        "the distal phalanx touches the object {:.2e} mm from its joint: its torque cannot produce a contact force there, so make l21 \
         longer or move the object closer",
        .lever_m * 1e3
    )]
    NoLever { lever_m: f64 },
    #[error(
        "form closure could not be decided: {certificate} fails its check (the residual is {residual:.1e}, at most 1e-9 is \
         allowed); the grasp is on the boundary, change it slightly"
    )]
    Undecided { certificate: &'static str, residual: f64 },
    #[error(
        "form closure could not be decided: there is neither a free motion nor multipliers that exclude one, within \
         rounding; the grasp is on the boundary, change it slightly"
    )]
    NeitherMotionNorMultipliers,
    #[error(
        "the linear programme of form closure has no solution ({reason}); the grasp is close to singular, change it slightly"
    )]
    Program { reason: String },
    #[error(
        "the linear programme of the force balance has no solution ({reason}); the posture is close to singular, change it \
         slightly"
    )]
    Balance { reason: String },
    #[error(transparent)]
    Loop(#[from] PostureError),
}

/// |∂q22/∂q11| below which the motor cannot move the tip.
const DEAD_POINT_SLOPE: f64 = 1e-9;

/// Kinematic quantities of one posture.
#[derive(Clone, Copy, Debug)]
pub struct StaticKinematics {
    pub pose: Directions<f64>,
    pub rates: PassiveRates<f64>,
    /// ∂q22/∂(q11, q21). Their sum is 0: equal rates of l11 and l21 rotate the finger as one body.
    pub tip_slope: [f64; 2],
}

/// Link directions and passive rates of the final posture. Returns an error if the posture is singular: if l12 and l22
/// are in line ([`StaticsError::InLine`]), or l11 and l12 ([`StaticsError::DeadPoint`]).
pub fn static_kinematics(finger: &Finger, end: &FinalPosture) -> Result<StaticKinematics> {
    static_kinematics_at(finger, &end.posture)
}

/// [`static_kinematics`] for any posture.
pub(crate) fn static_kinematics_at(finger: &Finger, q: &Posture) -> Result<StaticKinematics> {
    let e = |angle: f64| [cos(angle), sin(angle)];
    let pose = Directions {
        e1: e(q.q11_rad),
        e2: e(q.q21_rad),
        e3: e(q.q11_rad + q.q12_rad),
        e4: e(q.q21_rad + q.q22_rad),
        q_rad: [q.q11_rad, q.q21_rad],
    };
    let sine = cross(pose.e3, pose.e4);
    if sine.is_nan() || sine.abs() < SINGULAR_SINE {
        return Err(StaticsError::InLine { sine });
    }
    let rates = passive_rates(&finger.lengths, &pose);
    let tip_slope = [rates.a4[0], rates.a4[1] - 1.0];
    if tip_slope[0].is_nan() || tip_slope[0].abs() < DEAD_POINT_SLOPE {
        return Err(StaticsError::DeadPoint { slope: tip_slope[0] });
    }
    Ok(StaticKinematics { pose, rates, tip_slope })
}

/// Smallest lever with which a torque can produce a contact force, in m.
pub(super) const MIN_LEVER_M: f64 = 1e-9;

/// Normal forces of both contacts at rest, positive in compression, and the resulting force on the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    pub f21_n: f64,
    pub f22_n: f64,
    pub pfp_n: f64,
}

/// Phalanges whose normal force would have to pull. They separate instead, and the object is ejected (thesis §1.2.3).
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

/// Returns τ_a + τ_s on (q11, q21) at the final posture, in N·m (2.30), (2.31): the loads of motor torque and spring.
///
/// The spring may be of any kind and placement. The deflection of a torsional spring is relative to the straight
/// configuration. The other assembly mode has no straight configuration; there, the deflection is less than a turn.
pub fn drive_loads(finger: &Finger, end: &FinalPosture, motor_n_m: f64, spring: Option<&Spring>) -> Result<[f64; 2]> {
    number("the motor torque", motor_n_m, true, "must be finite")?;
    let StaticKinematics { pose, rates, .. } = static_kinematics(finger, end)?;
    let Some(spring) = spring else { return Ok([motor_n_m, 0.0]) };
    let reference = reference_gamma(&finger.lengths);
    let model = match finger.assembly {
        Assembly::Reference => {
            SpringModel::new(spring, &finger.lengths, reference, &straight_directions(&finger.lengths))
        }
        Assembly::Other => SpringModel::new(spring, &finger.lengths, -reference, &pose),
    };
    let [s11, s21] = model.generalised_force(&pose, &rates);
    number("the spring's torque", s11 + s21, true, "must be finite")?;
    Ok([motor_n_m + s11, s21])
}

/// J_C = [J_C21, J_C22] of (2.32), J_C2j = J_P2jᵀ (n + μ t) (errata 9), in m: generalised forces on (q11, q21) per
/// newton of normal force; `jacobian[i][j]` belongs to coordinate i and contact j.
///
/// n points from the object into the phalanx. Friction on the object is directed towards the palm, and friction on the
/// phalanx along t, from its joint to its end.
pub fn contact_jacobian(finger: &Finger, end: &FinalPosture, mu_static: [f64; 2]) -> Result<[[f64; 2]; 2]> {
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
pub fn equilibrium(finger: &Finger, end: &FinalPosture, loads: [f64; 2], mu_static: f64) -> Result<Equilibrium> {
    equilibrium_with_mu(finger, end, loads, [mu_static; 2])
}

/// [`equilibrium`] with separate friction coefficients for the proximal and the distal contact.
pub fn equilibrium_with_mu(finger: &Finger, end: &FinalPosture, loads: [f64; 2], mus: [f64; 2]) -> Result<Equilibrium> {
    number("the load on q11", loads[0], true, "must be finite")?;
    number("the load on q21", loads[1], true, "must be finite")?;
    for mu in mus {
        number("mu_static", mu, mu >= 0.0, "must be finite, 0 or more")?;
    }
    let lever_m = end.l_c22_m + mus[1] * finger.lengths.half_width_m;
    if lever_m < MIN_LEVER_M {
        return Err(StaticsError::NoLever { lever_m });
    }
    let [[_, j12], [j21, j22]] = contact_jacobian(finger, end, mus)?;
    let f22_n = -loads[0] / j12;
    let f21_n = -(loads[1] + j22 * f22_n) / j21;
    Ok(Equilibrium { f21_n, f22_n, pfp_n: palm_force_with_mu(end, [f21_n, f22_n], mus) })
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

/// Like [`palm_force`], with separate friction coefficients for the two contacts.
pub fn palm_force_with_mu(end: &FinalPosture, [f21_n, f22_n]: [f64; 2], [mu_21, mu_22]: [f64; 2]) -> f64 {
    let (sin_c, cos_c) = sin_cos(end.phi_c_rad);
    let (sin_21, cos_21) = sin_cos(end.posture.q21_rad);
    f22_n * (sin_c + mu_22 * cos_c) - f21_n * (cos_21 - mu_21 * sin_21)
}

/// J, T and f of one grasp in Birglen's formulation (thesis §1.2.1, §1.2.3). In θ = (θ1, θ2), θ1 is the angle of the
/// proximal phalanx, and θ2 is the angle of the tip relative to it. The actuator angle is θ_a = q11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Birglen {
    /// J of (1.8), in m: the normal velocities of the contacts are J θ̇.
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

/// Forces of (1.11); `loads` are τ_a + τ_s on (q11, q21) from [`drive_loads`](super::drive_loads).
///
/// Birglen's phalanges are lines. The lever of a normal force does not depend on the width, but friction on the surface
/// of a phalanx of half width w has the lever w about its joint. Hence the result agrees with
/// [`equilibrium`](fn@super::equilibrium) if μ w = 0.
pub fn birglen(finger: &Finger, end: &FinalPosture, loads: [f64; 2], mu_static: f64) -> Result<Birglen> {
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
