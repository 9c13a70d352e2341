//! Scalar contact laws: pure functions of penetration, rate and slip, each with exact derivatives.
//!
//! A contact is a normal law times a friction law; the joint limit is a normal law that acts on an angle.

mod bristle;
mod contact;
mod friction;
mod hertz;
mod normal;
mod smoothstep;

pub use bristle::{Bristle, Stepped, bristle_pull, cone, friction_with_memory, stepped};
pub use contact::{friction_force, normal_over_gap};
pub use friction::{FrictionRange, friction_coefficient, friction_range};
pub use hertz::{Material, hertz_stiffness};
pub use normal::{
    NormalForce, damping, elastic_energy, is_damped, normal_force, spring_force, stopping_depth, unclamped_normal_force,
};
pub use smoothstep::smoothstep;

/// Parameters of the Hertz/STEP normal law (thesis (2.38), (2.39), errata 7): F = max(0, k δᵉ + c(δ) δ̇).
///
/// For the joint limit the same law gives a torque in N·m from an angle in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalLaw {
    /// k, in N/mᵉ (limit: N·m/radᵉ).
    pub stiffness_n_per_m_e: f64,
    /// e, at least 1.
    pub exponent: f64,
    /// c_max, in N·s/m (limit: N·m·s/rad).
    pub damping_max_n_s_per_m: f64,
    /// δ_max, in m (limit: rad): penetration at which the damper is fully engaged.
    pub transition_m: f64,
}

impl NormalLaw {
    /// The law of what is pressed with a given force, however it moves: at a depth of 1, as a brake's is.
    pub const fn pressed_with(force: f64) -> Self {
        Self { stiffness_n_per_m_e: force, exponent: 1.0, damping_max_n_s_per_m: 0.0, transition_m: 1.0 }
    }
}

/// Parameters of the regularised Coulomb law (thesis (2.35), errata 8), or of friction that holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    pub mu_static: f64,
    pub mu_dynamic: f64,
    /// v_s: slip speed at which μ reaches μ_s.
    pub v_static_m_s: f64,
    /// v_d: slip speed from which μ = μ_d.
    pub v_dynamic_m_s: f64,
    /// What holds below the cone; `None` is the regularised law.
    pub bristle: Option<Bristle>,
}

/// Law of one contact: normal law times friction law; `None` is frictionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
}

impl ContactLaw {
    /// What holds below the cone; `None` where nothing does.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}
