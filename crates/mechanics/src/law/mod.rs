//! Scalar contact laws: pure functions of penetration, rate and slip, each with exact derivatives.
//!
//! A contact combines a normal law and a friction law; the joint limit is a normal law that acts on an angle.

mod bristle;
mod friction;
mod hertz;
mod normal;

pub use bristle::{Bristle, BristleStep, bristle_force, friction_cone, friction_with_state, implicit_bristle_step};
pub use friction::{FrictionRange, friction_coefficient, friction_force, friction_range};
pub use hertz::{Material, hertz_stiffness};
pub use normal::{
    NormalForce, damping, elastic_energy, is_damped, normal_force, normal_over_gap, spring_force, stopping_depth,
    unclamped_normal_force,
};

/// Parameters of the Hertz/STEP normal law (thesis (2.38), (2.39), errata 7): F = max(0, k δᵉ + c(δ) δ̇).
///
/// For the joint limit the same law gives a torque in N·m from an angle in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalLaw {
    /// k, in N/mᵉ (limit: N·m/radᵉ).
    pub stiffness_n_per_m_e: f64,
    /// Exponent e, at least 1.
    pub exponent: f64,
    /// c_max, in N·s/m (limit: N·m·s/rad).
    pub damping_max_n_s_per_m: f64,
    /// δ_max, in m (limit: rad): penetration at which the damper is fully engaged.
    pub transition_m: f64,
}

impl NormalLaw {
    /// Returns a law with a constant normal force, evaluated at a depth of 1; used for brakes.
    pub const fn constant_force(force: f64) -> Self {
        Self { stiffness_n_per_m_e: force, exponent: 1.0, damping_max_n_s_per_m: 0.0, transition_m: 1.0 }
    }
}

/// Parameters of the regularised Coulomb law (thesis (2.35), errata 8), or of friction with stiction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    pub mu_static: f64,
    pub mu_dynamic: f64,
    /// v_s: slip speed at which μ reaches μ_s.
    pub v_static_m_s: f64,
    /// v_d: slip speed from which μ = μ_d.
    pub v_dynamic_m_s: f64,
    /// Bristle of the stiction law; `None` selects the regularised law.
    pub bristle: Option<Bristle>,
}

/// Law of one contact: normal law and friction law; without a friction law the contact is frictionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
}

impl ContactLaw {
    /// Bristle of the stiction law; `None` for the regularised law and without friction.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}

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
