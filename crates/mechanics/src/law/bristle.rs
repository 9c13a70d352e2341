//! Friction that holds: a bristle (spring and damper side by side) in series with a Coulomb slider (cf. Haessig & Friedland 1991, Dupont
//! et al. 2002).
//!
//! With s the stretch of the bristle, L = μ(v) F_n and T = min(max(k s + c v, −L), L) the friction is −T and ṡ = (T − k s)/c. What a
//! model carries along is σ = k s/c, a speed, so that T = c (σ + v) within the cone and σ̇ = (k/c) (T/c − σ).

use super::{FrictionLaw, friction_coefficient, friction_force};
use crate::numeric::Real;

/// A bristle, by its damping c and the time c/k in which it relaxes when it is let go; of a brake, in rad for m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristle {
    /// N·s/m (N·m·s/rad).
    pub damping_n_s_per_m: f64,
    pub relaxation_s: f64,
}

impl Bristle {
    /// Rate at which a bristle that is let go relaxes, k/c, 1/s.
    #[inline(always)]
    pub fn rate(&self) -> f64 {
        1.0 / self.relaxation_s
    }

    /// ½ k s², J.
    pub fn energy(&self, memory: f64) -> f64 {
        0.5 * self.damping_n_s_per_m * self.relaxation_s * memory * memory
    }

    /// What σ̇ has of T: k/c².
    #[inline(always)]
    pub fn driven(&self) -> f64 {
        1.0 / (self.relaxation_s * self.damping_n_s_per_m)
    }
}

/// μ(v) ≥ 0, even in v: μ_s up to v_s, beyond |μ| of the regularised law; and its slope.
#[inline(always)]
pub fn cone(law: &FrictionLaw, v: f64) -> (f64, f64) {
    if v.abs() < law.v_static_m_s {
        return (law.mu_static, 0.0);
    }
    let (mu, slope) = friction_coefficient(law, v);
    (mu.abs(), slope * v.signum())
}

/// T for a slip (m/s), a memory σ (m/s) and a normal force (N).
#[inline(always)]
pub fn bristle_pull<T: Real>(law: &FrictionLaw, bristle: &Bristle, slip: T, memory: T, normal: T) -> T {
    let (mu, slope) = cone(law, slip.value());
    let most = slip.chain(mu, slope) * normal;
    let held = (memory + slip) * bristle.damping_n_s_per_m;
    if held.value() > most.value() {
        most
    } else if held.value() < -most.value() {
        -most
    } else {
        held
    }
}

/// Friction on the sliding surface by whichever law there is: that of a bristle where it has a memory, the regularised one otherwise.
#[inline(always)]
pub fn friction_with_memory<T: Real>(law: &FrictionLaw, slip: T, memory: Option<T>, normal: T) -> T {
    match law.bristle.as_ref().zip(memory) {
        Some((bristle, memory)) => -bristle_pull(law, bristle, slip, memory, normal),
        None => friction_force(law, slip, normal),
    }
}

/// What an implicit step of length h makes of a bristle: T at a slip, its derivatives by slip and normal force, and the memory after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stepped {
    pub pull: f64,
    pub by_slip: f64,
    pub by_normal: f64,
    pub memory: f64,
}

/// One implicit Euler step from a memory: what sticks stretches by the slip at its end; `one_way` pulls back only against slip that is
/// negative.
#[inline(always)]
pub fn stepped(
    law: &FrictionLaw,
    bristle: &Bristle,
    [slip, memory, normal]: [f64; 3],
    h: f64,
    one_way: bool,
) -> Stepped {
    let (c, part) = (bristle.damping_n_s_per_m, h / bristle.relaxation_s);
    let (mu, slope) = cone(law, slip);
    let most = mu * normal;
    let held = c * (memory + (1.0 + part) * slip);
    let upper = if one_way { 0.0 } else { most };
    if held <= upper && held >= -most {
        // Nothing holds where nothing presses, however little there is to hold: a slope there is one that no slip finds again.
        if most == 0.0 {
            return Stepped { pull: 0.0, by_slip: 0.0, by_normal: 0.0, memory: memory / (1.0 + part) };
        }
        return Stepped { pull: held, by_slip: c * (1.0 + part), by_normal: 0.0, memory: memory + part * slip };
    }
    let sign = if held > upper { if one_way { 0.0 } else { 1.0 } } else { -1.0 };
    let pull = sign * most;
    Stepped {
        pull,
        by_slip: sign * slope * normal,
        by_normal: sign * mu,
        memory: (memory + part * pull / c) / (1.0 + part),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;

    const BRISTLE: Bristle = Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 };
    const LAW: FrictionLaw =
        FrictionLaw { mu_static: 0.8, mu_dynamic: 0.56, v_static_m_s: 0.1, v_dynamic_m_s: 0.2, bristle: Some(BRISTLE) };

    #[test]
    fn nothing_is_held_where_nothing_presses() {
        for slip in [-1e-12, 0.0, 1e-12] {
            let found = stepped(&LAW, &BRISTLE, [slip, 0.0, 0.0], 1e-7, false);
            assert_eq!((found.pull, found.by_slip, found.memory), (0.0, 0.0, 0.0), "{slip}");
        }
        assert!(stepped(&LAW, &BRISTLE, [0.0, 0.0, 1e-9], 1e-7, false).by_slip > 0.0);
    }

    #[test]
    fn the_cone_is_even_and_holds_what_sticks() {
        for (v, mu) in [(0.0, 0.8), (0.05, 0.8), (0.1, 0.8), (0.15, 0.68), (0.2, 0.56), (7.0, 0.56)] {
            assert!((cone(&LAW, v).0 - mu).abs() < 1e-14 && cone(&LAW, -v).0 == cone(&LAW, v).0);
            assert_eq!(cone(&LAW, v).1, -cone(&LAW, -v).1);
        }
        for (slip, memory, normal) in [(1e-6, 3e-6, 10.0), (0.3, 0.0, 10.0), (-0.3, 0.0, 10.0), (0.0, -1.0, 2.0)] {
            let pull = bristle_pull(&LAW, &BRISTLE, slip, memory, normal);
            assert!(pull.abs() <= 0.8 * normal && pull * (slip + memory) > 0.0);
        }
        assert_eq!(bristle_pull(&LAW, &BRISTLE, 1e-6, 3e-6, 10.0), 4.0);
        assert_eq!(bristle_pull(&LAW, &BRISTLE, 0.1, 0.0, 0.0), 0.0);
    }

    #[test]
    fn pulls_carry_their_derivatives_within_the_cone_and_beyond() {
        for at in [[1e-6, 3e-6, 10.0], [0.15, 1e-6, 10.0], [-0.17, 1e-6, 3.0], [0.4, 0.0, 3.0]] {
            let dual = [0, 1, 2].map(|i| Dual::<3>::variable(at[i], i));
            let found = bristle_pull(&LAW, &BRISTLE, dual[0], dual[1], dual[2]);
            for i in 0..3 {
                let h = [1e-8, 1e-8, 1e-4][i];
                let moved = |by: f64| {
                    let at: [f64; 3] = std::array::from_fn(|k| if k == i { at[k] + by } else { at[k] });
                    bristle_pull(&LAW, &BRISTLE, at[0], at[1], at[2])
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                assert!((found.grad[i] - slope).abs() < 1e-6 * slope.abs().max(1.0), "{at:?} {i}");
            }
        }
    }

    #[test]
    fn an_implicit_step_ends_on_the_law() {
        for (slip, memory, h) in [(1e-6, 2e-6, 1e-4), (3e-5, 2e-6, 1e-4), (-0.2, 1e-6, 1e-5), (0.0, 9e-6, 1e-3)] {
            let found = stepped(&LAW, &BRISTLE, [slip, memory, 10.0], h, false);
            let there = bristle_pull(&LAW, &BRISTLE, slip, found.memory, 10.0);
            assert!((found.pull - there).abs() < 1e-9, "{found:?} {there}");
            let rate = (found.pull / BRISTLE.damping_n_s_per_m - found.memory) / BRISTLE.relaxation_s;
            assert!((found.memory - memory - h * rate).abs() < 1e-18);
            let d = 1e-9;
            let at = |slip: f64, normal: f64| stepped(&LAW, &BRISTLE, [slip, memory, normal], h, false).pull;
            assert!(
                ((at(slip + d, 10.0) - at(slip - d, 10.0)) / (2.0 * d) - found.by_slip).abs()
                    < 1e-3 * (1.0 + found.by_slip.abs())
            );
            assert!(((at(slip, 10.0 + d) - at(slip, 10.0 - d)) / (2.0 * d) - found.by_normal).abs() < 1e-5);
        }
        // Slip that a ratchet lets pass leaves it without a pull.
        assert_eq!(stepped(&LAW, &BRISTLE, [1e-5, 0.0, 10.0], 1e-4, true).pull, 0.0);
        assert!(stepped(&LAW, &BRISTLE, [-1e-5, 0.0, 10.0], 1e-4, true).pull < 0.0);
    }

    /// T v = d/dt ½ k s² + c ṡ² + T u with T u ≥ 0, u = v − ṡ.
    #[test]
    fn a_bristle_is_passive() {
        for slip in [-0.5, -1e-5, 0.0, 2e-6, 0.12, 3.0] {
            for memory in [-8e-6, -1e-7, 0.0, 5e-6] {
                let pull = bristle_pull(&LAW, &BRISTLE, slip, memory, 10.0);
                let (k, c) = (1e9, BRISTLE.damping_n_s_per_m);
                let (stretch, stretching) = (c * memory / k, pull / c - memory);
                let slider = slip - stretching;
                let lost = pull * slip - k * stretch * stretching;
                assert!((lost - c * stretching * stretching - pull * slider).abs() < 1e-9 * (1.0 + lost.abs()));
                assert!(pull * slider >= -1e-20, "{slip} {memory}: {}", pull * slider);
            }
        }
    }
}
