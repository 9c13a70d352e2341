//! Normal law × friction law over any [`Real`]: one formula gives the force and its exact Jacobian.

use super::{FrictionLaw, NormalForce, friction_coefficient};
use crate::numeric::Real;

/// Returns a normal force as a function of the gap (−δ) and its rate (−δ̇), from the law's value and derivatives there.
///
/// `law` maps (δ, δ̇) to the force on the active branch: [`normal_force`](super::normal_force) or
/// [`unclamped_normal_force`](super::unclamped_normal_force).
#[inline(always)]
pub fn normal_over_gap<T: Real>(law: impl Fn(f64, f64) -> NormalForce, gap: T, gap_rate: T) -> T {
    let f = law(-gap.value(), -gap_rate.value());
    gap.chain2(gap_rate, f.force, -f.d_delta, -f.d_rate)
}

/// Friction on the sliding surface, −μ(v) F_n along the tangent (thesis (2.35)): `slip` in m/s, `normal` in N.
#[inline(always)]
pub fn friction_force<T: Real>(law: &FrictionLaw, slip: T, normal: T) -> T {
    let (mu, slope) = friction_coefficient(law, slip.value());
    slip.chain(mu, slope) * -normal
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{NormalLaw, normal_force};
    use crate::numeric::Dual;

    const NORMAL: NormalLaw =
        NormalLaw { stiffness_n_per_m_e: 1e8, exponent: 2.2, damping_max_n_s_per_m: 1e6, transition_m: 1e-5 };
    const FRICTION: FrictionLaw =
        FrictionLaw { mu_static: 0.8, mu_dynamic: 0.56, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: None };

    fn contact_forces<T: Real>(gap: T, rate: T, slip: T) -> [T; 2] {
        let normal = normal_over_gap(|delta, rate| normal_force(&NORMAL, delta, rate), gap, rate);
        [normal, friction_force(&FRICTION, slip, normal)]
    }

    /// The Jacobian of the composed law against its central differences.
    #[test]
    fn composed_law_has_exact_derivatives() {
        let at = [-3e-6, -0.5, 0.07];
        let step = [1e-11, 1e-6, 1e-7];
        let dual = contact_forces(Dual::<3>::variable(at[0], 0), Dual::variable(at[1], 1), Dual::variable(at[2], 2));
        for i in 0..3 {
            let shifted = |sign: f64| {
                let mut x = at;
                x[i] += sign * step[i];
                contact_forces(x[0], x[1], x[2])
            };
            let (up, down) = (shifted(1.0), shifted(-1.0));
            for (k, force) in dual.iter().enumerate() {
                let slope = (up[k] - down[k]) / (2.0 * step[i]);
                assert!((force.grad[i] - slope).abs() <= 1e-7 * slope.abs().max(1.0), "{i} {k}");
            }
        }
    }

    #[test]
    fn friction_opposes_slip_within_the_cone() {
        for slip in [-1.0, -0.15, -0.01, 0.0, 0.05, 0.3] {
            let [normal, tangential] = contact_forces(-2e-6, -0.3, slip);
            assert!(normal > 0.0 && tangential * slip <= 0.0 && tangential.abs() <= 0.8 * normal);
        }
    }
}
