//! Scalar contact laws: pure functions of penetration, rate and slip, each with exact derivatives.
//!
//! A contact combines a normal law and a friction law; the joint limit is a normal law that acts on an angle.

mod bristle;
mod friction;
mod hunt_crossley;
mod regularised;
mod restitution;
mod step;

use crate::numeric::Real;
use crate::numeric::elementary::{pow, powi};

pub use bristle::Bristle;
pub use regularised::{friction_coefficient, friction_force};
pub use restitution::damping_from_restitution;
pub use step::smoothstep;

/// Normal law F = max(0, k δᵉ + c(δ) δ̇) (thesis (2.38)): a Hertz spring with a damper.
///
/// For a joint limit the same law gives a torque in N·m from an angle in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalLaw {
    /// k, in N/mᵉ (limit: N·m/radᵉ).
    pub stiffness_n_per_m_e: f64,
    /// Exponent e, at least 1.
    pub exponent: f64,
    pub damping: Damping,
}

/// Law of the damper, c(δ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// The damper of the thesis engages over the first δ_max of penetration.
    Step {
        /// c_max, in N·s/m (limit: N·m·s/rad).
        max_n_s_per_m: f64,
        /// δ_max, in m (limit: rad): penetration at which the damper is fully engaged.
        transition_m: f64,
    },
    /// c is constant: the damper of a cable.
    Constant {
        /// c, in N·s/m.
        n_s_per_m: f64,
    },
    /// c = (3/2) a k δᵉ (Hunt and Crossley 1975).
    HuntCrossley {
        /// a, in s/m (limit: s/rad). For slow impacts, the coefficient of restitution is 1 − a v.
        factor_s_per_m: f64,
    },
}

/// Depth over which a contact is resolved, m (limit: rad), if its law has no depth of its own.
const DEPTH_SCALE_M: f64 = 1e-5;

impl NormalLaw {
    /// Returns a law with a constant normal force, which is evaluated at a depth of 1; used for brakes.
    pub const fn constant_force(force: f64) -> Self {
        Self::step(force, 1.0, 0.0, 1.0)
    }

    /// Creates a law with the damper of the thesis: k in N/mᵉ, e, c_max in N·s/m, δ_max in m.
    pub const fn step(k: f64, e: f64, c_max: f64, delta_max: f64) -> Self {
        let damping = Damping::Step { max_n_s_per_m: c_max, transition_m: delta_max };
        Self { stiffness_n_per_m_e: k, exponent: e, damping }
    }

    /// c_max of the STEP damper, N·s/m (limit: N·m·s/rad); 0 for another damper.
    pub const fn damping_max(&self) -> f64 {
        match self.damping {
            Damping::Step { max_n_s_per_m, .. } => max_n_s_per_m,
            Damping::Constant { .. } | Damping::HuntCrossley { .. } => 0.0,
        }
    }

    /// Returns the law with the maximum c_max of its STEP damper changed; the depth of engagement is kept. A law with
    /// another damper is unchanged.
    pub const fn with_damping_max(mut self, c_max: f64) -> Self {
        if let Damping::Step { max_n_s_per_m, .. } = &mut self.damping {
            *max_n_s_per_m = c_max;
        }
        self
    }

    /// Depth over which the law changes its character, m (limit: rad): δ_max of the STEP damper.
    #[inline(always)]
    pub const fn depth_scale_m(&self) -> f64 {
        match self.damping {
            Damping::Step { transition_m, .. } => transition_m,
            Damping::Constant { .. } | Damping::HuntCrossley { .. } => DEPTH_SCALE_M,
        }
    }
}

/// Parameters of a friction law: the coefficient as a function of the slip rate, which all laws share, and the kind of
/// law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionLaw {
    pub mu_static: f64,
    pub mu_dynamic: f64,
    /// v_s: slip rate at which μ reaches μ_s.
    pub v_static_m_s: f64,
    /// v_d: slip rate from which μ = μ_d.
    pub v_dynamic_m_s: f64,
    pub kind: FrictionKind,
}

/// The friction laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrictionKind {
    /// Regularised Coulomb friction (thesis (2.35), errata 8), which creeps.
    Regularised,
    /// Friction with stiction, which holds without creep.
    Bristle(Bristle),
}

/// Slip (m/s), internal state, and normal force (N) of a contact.
#[derive(Clone, Copy, Debug)]
pub struct FrictionPoint {
    pub slip: f64,
    /// 0 for a law without a state.
    pub state: f64,
    pub normal: f64,
}

/// Ranges of slip within which a law is smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionRange {
    /// Regularised: |v| ≤ v_s. With stiction: the friction is within the cone.
    Sticking,
    /// Regularised: v_s < |v| ≤ v_d, with the sign of v given by `forward`. With stiction: at the cone, |v| ≤ v_d.
    Transition { forward: bool },
    /// v_d < |v|.
    Sliding { forward: bool },
    /// Any slip: the range is not monitored.
    Any,
}

/// Error weight of a slip rate.
#[derive(Clone, Copy, Debug)]
pub struct SlipWeight {
    /// Slip rate over which the law changes, m/s.
    pub slip_scale: f64,
    /// Normal force for which an error of the slip counts, N; 0 for an error that always counts.
    pub normal_force: f64,
}

/// Result of an implicit step: opposing force, its derivatives with respect to slip and normal force, and the state at
/// the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionStep {
    pub force: f64,
    pub d_slip: f64,
    pub d_normal: f64,
    pub state: f64,
}

/// Overlap of neighbouring ranges as a fraction of the finest slip scale: a range extends by this much beyond its
/// nominal end, so that the ranges do not alternate.
pub const RANGE_OVERLAP: f64 = 0.01;

/// Law of one contact: a normal law and a friction law. Without a friction law the contact is frictionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
}

/// A force with its derivatives with respect to penetration and penetration rate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalForce {
    /// F, in N (limit: N·m).
    pub force: f64,
    /// ∂F/∂δ.
    pub d_delta: f64,
    /// ∂F/∂δ̇.
    pub d_rate: f64,
}

/// c(δ) and dc/dδ, for δ > 0.
#[inline(always)]
pub fn damping(law: &NormalLaw, delta: f64) -> (f64, f64) {
    match law.damping {
        Damping::Step { max_n_s_per_m, transition_m } => step::damping(max_n_s_per_m, transition_m, delta),
        Damping::Constant { n_s_per_m } => (n_s_per_m, 0.0),
        Damping::HuntCrossley { factor_s_per_m } => hunt_crossley::damping(law, factor_s_per_m, delta),
    }
}

/// Whether the force depends on the rate. If it does, the force of a contact may vanish before the surfaces separate.
#[inline(always)]
pub fn is_damped(law: &NormalLaw) -> bool {
    match law.damping {
        Damping::Step { max_n_s_per_m, .. } => max_n_s_per_m > 0.0,
        Damping::Constant { n_s_per_m } => n_s_per_m > 0.0,
        Damping::HuntCrossley { factor_s_per_m } => factor_s_per_m > 0.0,
    }
}

/// Force of the spring k δᵉ, in N (limit: N·m); 0 for δ ≤ 0.
#[inline(always)]
pub fn spring_force(law: &NormalLaw, delta: f64) -> f64 {
    if delta > 0.0 { law.stiffness_n_per_m_e * pow(delta, law.exponent) } else { 0.0 }
}

/// Normal force k δᵉ + c(δ) δ̇ for δ > 0, without the clamp: negative where a real contact would release. Zero for δ ≤
/// 0.
///
/// `delta` in m (limit: rad), `rate` in m/s (rad/s).
#[inline(always)]
pub fn unclamped_normal_force(law: &NormalLaw, delta: f64, rate: f64) -> NormalForce {
    if delta <= 0.0 {
        return NormalForce::default();
    }
    // This power is also the derivative divided by e; it stays finite at δ → 0 because e ≥ 1.
    let power = law.stiffness_n_per_m_e * pow(delta, law.exponent - 1.0);
    let (c, dc) = damping(law, delta);
    NormalForce { force: power * delta + c * rate, d_delta: law.exponent * power + dc * rate, d_rate: c }
}

/// F = max(0, k δᵉ + c(δ) δ̇), 0 for δ ≤ 0: a contact cannot pull (thesis (2.38)).
#[inline(always)]
pub fn normal_force(law: &NormalLaw, delta: f64, rate: f64) -> NormalForce {
    let unclamped = unclamped_normal_force(law, delta, rate);
    if unclamped.force > 0.0 { unclamped } else { NormalForce::default() }
}

/// Returns a normal force as a function of the gap (−δ) and its rate (−δ̇), from the value and the derivatives of the
/// law.
///
/// `law` maps (δ, δ̇) to the force on the active branch: [`normal_force`] or
/// [`unclamped_normal_force`].
#[inline(always)]
pub fn normal_over_gap<T: Real>(law: impl Fn(f64, f64) -> NormalForce, gap: T, gap_rate: T) -> T {
    let f = law(-gap.value(), -gap_rate.value());
    gap.chain2(gap_rate, f.force, -f.d_delta, -f.d_rate)
}

/// Energy in the Hertz spring, k δᵉ⁺¹/(e + 1), in J; 0 for δ ≤ 0.
pub fn elastic_energy(law: &NormalLaw, delta: f64) -> f64 {
    if delta <= 0.0 {
        return 0.0;
    }
    law.stiffness_n_per_m_e * pow(delta, law.exponent + 1.0) / (law.exponent + 1.0)
}

/// Approximate maximum penetration of an impact at `speed` without external force, m (limit: rad).
pub fn stopping_depth(law: &NormalLaw, speed: f64, inverse_mass: f64) -> f64 {
    // Depth at which the spring alone takes up an energy, per mass.
    let spring_depth = |energy: f64| {
        let e = law.exponent;
        pow((e + 1.0) * energy / (law.stiffness_n_per_m_e * inverse_mass), (e + 1.0).recip())
    };
    match law.damping {
        // The smaller of the depths at which the spring alone or the damper alone stops the mass.
        Damping::Step { max_n_s_per_m, transition_m } => spring_depth(0.5 * speed * speed).min(step::stopping_depth(
            max_n_s_per_m,
            transition_m,
            speed,
            inverse_mass,
        )),
        Damping::Constant { .. } => spring_depth(0.5 * speed * speed),
        Damping::HuntCrossley { factor_s_per_m } => {
            spring_depth(hunt_crossley::energy_at_greatest_depth(factor_s_per_m, speed))
        }
    }
}

/// Elastic constants of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    pub youngs_modulus_pa: f64,
    pub poisson_ratio: f64,
}

/// k = (4/3) E* √R of F = k δ^{3/2}, in N/m^{3/2}, with 1/E* = Σ (1 − ν²)/E and 1/R = 1/R₁ + 1/R₂ (thesis (2.33),
/// (2.34), errata 6).
///
/// A flat face has an infinite radius.
pub fn hertz_stiffness(materials: [Material; 2], radii_m: [f64; 2]) -> f64 {
    let compliance: f64 = materials.iter().map(|m| (1.0 - powi(m.poisson_ratio, 2)) / m.youngs_modulus_pa).sum();
    let curvature: f64 = radii_m.iter().map(|r| r.recip()).sum();
    4.0 / 3.0 / compliance / curvature.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBJECT: NormalLaw = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);

    #[test]
    fn errata_07_damper_reaches_c_max_at_delta_max() {
        assert_eq!(damping(&OBJECT, 1e-5).0, 1e6);
        assert_eq!(damping(&OBJECT, 3e-5).0, 1e6);
        assert!((damping(&OBJECT, 5e-6).0 - 0.5e6).abs() < 1e-9);
        // As printed, a = +2 c_max/δ_max³ would give 5 c_max at δ_max.
        let thesis_damping = 2e6 + 3e6;
        assert!(damping(&OBJECT, 1e-5).0 < thesis_damping / 4.0);
    }

    #[test]
    fn spring_and_damper_match_the_closed_form() {
        for (delta, rate) in [(1e-7, 2.0), (3e-6, 0.5), (9.9e-6, -1e-3), (2e-5, 1e-4)] {
            let s: f64 = (delta / 1e-5f64).min(1.0);
            let expected = 1e8 * f64::powf(delta, 2.2) + 1e6 * (3.0 * s * s - 2.0 * s * s * s) * rate;
            let found = unclamped_normal_force(&OBJECT, delta, rate).force;
            assert!(
                (found - expected).abs() <= 1e-12 * expected.abs().max(1e-3),
                "depth {delta}, rate {rate}: {found}, expected {expected}"
            );
        }
    }

    #[test]
    fn derivatives_match_central_differences() {
        let hunt_crossley = NormalLaw { damping: Damping::HuntCrossley { factor_s_per_m: 0.3 }, ..OBJECT };
        let states = [(1e-7, 2.0), (3e-6, 0.5), (9.0e-6, -1e-3), (2e-5, 1e-4)];
        for ((delta, rate), law) in states.into_iter().flat_map(|state| [(state, OBJECT), (state, hunt_crossley)]) {
            let f = |d, r| unclamped_normal_force(&law, d, r).force;
            let law_at = unclamped_normal_force(&law, delta, rate);
            let (hd, hr) = (1e-5 * delta, 1e-5);
            let d_delta = (f(delta + hd, rate) - f(delta - hd, rate)) / (2.0 * hd);
            let d_rate = (f(delta, rate + hr) - f(delta, rate - hr)) / (2.0 * hr);
            assert!((law_at.d_delta - d_delta).abs() < 1e-7 * d_delta.abs(), "{delta} {rate}");
            assert!((law_at.d_rate - d_rate).abs() < 1e-7 * d_rate.abs().max(1.0), "{delta} {rate}");
        }
    }

    #[test]
    fn contact_never_pulls_and_vanishes_without_penetration() {
        assert_eq!(normal_force(&OBJECT, -1e-6, 5.0), NormalForce::default());
        assert_eq!(normal_force(&OBJECT, 0.0, 5.0), NormalForce::default());
        assert_eq!(normal_force(&OBJECT, 5e-6, -1.0), NormalForce::default());
        assert!(unclamped_normal_force(&OBJECT, 5e-6, -1.0).force < 0.0);
    }

    #[test]
    fn exponent_one_is_linear_with_finite_slope_at_zero() {
        let linear = NormalLaw { exponent: 1.0, ..OBJECT };
        let law_at = unclamped_normal_force(&linear, 1e-12, 0.0);
        assert!((law_at.d_delta - 1e8).abs() < 1e-6);
    }

    #[test]
    fn elastic_energy_is_the_integral_of_the_spring_force() {
        let delta: f64 = 4e-6;
        let n = 20_000;
        let step = delta / n as f64;
        // Midpoint rule.
        let sum: f64 = (0..n)
            .map(|i| OBJECT.stiffness_n_per_m_e * f64::powf((i as f64 + 0.5) * step, OBJECT.exponent) * step)
            .sum();
        assert!((sum / elastic_energy(&OBJECT, delta) - 1.0).abs() < 1e-8);
    }

    /// Steel sphere of 10 mm on a steel flat: δ = (9 F²/(16 E*² R))^{1/3} (Johnson, Contact Mechanics, (4.23)).
    #[test]
    fn errata_06_stiffness_agrees_with_johnson() {
        let steel = Material { youngs_modulus_pa: 210e9, poisson_ratio: 0.3 };
        let e_star = 210e9 / (2.0 * (1.0 - 0.09));
        let force: f64 = 100.0;
        let delta = (9.0 * force * force / (16.0 * e_star * e_star * 0.01)).cbrt();
        let k = hertz_stiffness([steel, steel], [0.01, f64::INFINITY]);
        assert!((k * delta.powf(1.5) / force - 1.0).abs() < 1e-12);
    }
}
