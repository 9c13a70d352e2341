//! Contact forces at rest (thesis §2.1.4, errata 4 and 9).

use super::{AtRest, StaticsError, at_rest, palm_force_each};
use crate::fivebar::kinematics::{reference_gamma, straight};
use crate::fivebar::spring::SpringModel;
use crate::gripper::{Assembly, FinalPosture, Finger, Site, Spring};
use crate::numeric::elementary::{cos, sin};

/// Lever of a contact below which no torque makes a force there, in m.
pub(super) const NO_LEVER_M: f64 = 1e-9;

/// Normal forces of both contacts at rest, positive in compression, and what they make on the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equilibrium {
    pub f21_n: f64,
    pub f22_n: f64,
    pub pfp_n: f64,
}

/// Which phalanx would have to pull: it lets go instead, and the object is pushed out (thesis §1.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ejection {
    None,
    Proximal,
    Distal,
    Both,
}

impl Equilibrium {
    /// Force positiveness (thesis §1.2.3): neither contact has to pull.
    pub fn is_force_positive(&self) -> bool {
        self.f21_n >= 0.0 && self.f22_n >= 0.0
    }

    /// Palm force positiveness (thesis §3.4.2): the object is not lifted off the palm.
    pub fn is_palm_force_positive(&self) -> bool {
        self.pfp_n >= 0.0
    }

    /// What lets go.
    pub fn ejection(&self) -> Ejection {
        match (self.f21_n >= 0.0, self.f22_n >= 0.0) {
            (true, true) => Ejection::None,
            (false, true) => Ejection::Proximal,
            (true, false) => Ejection::Distal,
            (false, false) => Ejection::Both,
        }
    }

    /// Whether one contact would have to pull.
    pub fn ejects(&self, site: Site) -> bool {
        match site {
            Site::Proximal => self.f21_n < 0.0,
            Site::Distal => self.f22_n < 0.0,
            Site::Limit => false,
        }
    }
}

/// τ_a + τ_s on (q11, q21) at the final posture, in N·m (2.30), (2.31): motor torque and spring.
///
/// The spring may be of any kind and in any place. A torsional one is wound from the straight configuration; in the other
/// assembly mode, which has none, by less than a turn.
///
/// # Errors
/// A torque that is no number; the singular postures of [`at_rest`].
pub fn drive_loads(
    finger: &Finger,
    end: &FinalPosture,
    motor_n_m: f64,
    spring: Option<&Spring>,
) -> Result<[f64; 2], StaticsError> {
    number("the motor torque", motor_n_m, true, "must be finite")?;
    let [s11, s21] = spring_loads(finger, &at_rest(finger, end)?, spring)?;
    Ok([motor_n_m + s11, s21])
}

/// τ_s on (q11, q21) in any posture, in N·m (2.30), as [`drive_loads`] has it.
pub(super) fn spring_loads(
    finger: &Finger,
    AtRest { pose, rates, .. }: &AtRest,
    spring: Option<&Spring>,
) -> Result<[f64; 2], StaticsError> {
    let Some(spring) = spring else { return Ok([0.0; 2]) };
    let reference = reference_gamma(&finger.lengths);
    let model = match finger.assembly {
        Assembly::Reference => SpringModel::new(spring, &finger.lengths, reference, &straight(&finger.lengths)),
        Assembly::Other => SpringModel::new(spring, &finger.lengths, -reference, pose),
    };
    let [s11, s21] = model.generalised_force(pose, rates);
    number("the spring's torque", s11 + s21, true, "must be finite")?;
    Ok([s11, s21])
}

/// J_C = [J_C21, J_C22] of (2.32), J_C2j = J_P2jᵀ (n + μ t) (errata 9), in m: generalised forces on (q11, q21) for each newton
/// of normal force; `jacobian[i][j]` is of coordinate i and contact j.
///
/// n points from the object into the phalanx. The object feels its friction towards the palm, so the phalanx feels it along t,
/// from its joint to its end.
///
/// # Errors
/// The singular postures of [`at_rest`].
pub fn contact_jacobian(
    finger: &Finger,
    end: &FinalPosture,
    mu_static: [f64; 2],
) -> Result<[[f64; 2]; 2], StaticsError> {
    let AtRest { rates, .. } = at_rest(finger, end)?;
    let (l21, w) = (finger.lengths.l21_m, finger.lengths.half_width_m);
    let bend = end.posture.q22_rad + finger.lengths.phi22_rad;
    // Of q̇21 and of the tip's absolute rate θ̇4 = a4·q̇: J_Pᵀ n and J_Pᵀ t of the contact points.
    let proximal = -end.l_c21_m - mu_static[0] * w;
    let carried = -l21 * cos(bend) + mu_static[1] * l21 * sin(bend);
    let turned = -end.l_c22_m - mu_static[1] * w;
    let [a0, a1] = rates.a4;
    Ok([[0.0, turned * a0], [proximal, carried + turned * a1]])
}

/// Normal forces [F21, F22] = −J_C⁻¹ (τ_a + τ_s) (2.32) at the final posture, with friction μ_s at both contacts.
///
/// `loads` is τ_a + τ_s of [`drive_loads`]; weight is none of it. Of a constant spring on q22 and without friction,
/// F22 ≥ 0 ⇔ τ11 ≥ k_s ∂q22/∂q11.
///
/// # Errors
/// A load or a friction coefficient out of range, the singular postures of [`at_rest`], a tip contact without a lever.
pub fn equilibrium(
    finger: &Finger,
    end: &FinalPosture,
    loads: [f64; 2],
    mu_static: f64,
) -> Result<Equilibrium, StaticsError> {
    equilibrium_each(finger, end, loads, [mu_static; 2])
}

/// [`equilibrium`] with a friction coefficient for the proximal and one for the distal contact.
///
/// # Errors
/// As [`equilibrium`].
pub fn equilibrium_each(
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
    if lever_m < NO_LEVER_M {
        return Err(StaticsError::NoLever { lever_m });
    }
    let [[_, j12], [j21, j22]] = contact_jacobian(finger, end, mu_static)?;
    let f22_n = -loads[0] / j12;
    let f21_n = -(loads[1] + j22 * f22_n) / j21;
    Ok(Equilibrium { f21_n, f22_n, pfp_n: palm_force_each(end, [f21_n, f22_n], mu_static) })
}

fn number(name: &'static str, value: f64, in_range: bool, allowed: &'static str) -> Result<(), StaticsError> {
    if value.is_finite() && in_range { Ok(()) } else { Err(StaticsError::Number { name, value, allowed }) }
}
