//! Friction with stiction: a bristle (spring and damper in parallel) in series with a Coulomb slider (cf. Haessig &
//! Friedland 1991, Dupont et al. 2002).
//!
//! With the stretch s of the bristle, L = μ(v) F_n and T = min(max(k s + c v, −L), L), the friction is −T and ṡ = (T −
//! k s)/c. The internal state of a model is σ = k s/c, a speed, so that T = c (σ + v) within the cone and σ̇ = (k/c)
//! (T/c − σ).

use super::regularised::{self, friction_coefficient};
use super::{FrictionLaw, FrictionPoint, FrictionRange, FrictionStep, RANGE_OVERLAP};
use crate::numeric::Real;
use crate::numeric::elementary::exp;

/// A bristle with damping c; its relaxation time is c/k when it is unloaded. For a brake, angles replace lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristle {
    /// c, in N·s/m (brake: N·m·s/rad).
    pub damping_n_s_per_m: f64,
    pub relaxation_s: f64,
}

impl Bristle {
    /// Relaxation rate of an unloaded bristle, k/c, 1/s.
    #[inline(always)]
    pub fn rate(&self) -> f64 {
        1.0 / self.relaxation_s
    }

    /// Stored energy ½ k s², J, in the internal state σ = k s/c.
    pub fn energy(&self, state: f64) -> f64 {
        0.5 * self.damping_n_s_per_m * self.relaxation_s * state * state
    }

    /// σ̇ without a force.
    #[inline(always)]
    pub(super) fn relaxation<T: Real>(&self, state: T) -> T {
        state * -self.rate()
    }

    /// σ after a time without a force.
    pub(super) fn relaxed(&self, state: f64, time_s: f64) -> f64 {
        state * exp(-time_s * self.rate())
    }

    /// Gain from T to σ̇: k/c².
    #[inline(always)]
    pub fn stretch_gain(&self) -> f64 {
        1.0 / (self.relaxation_s * self.damping_n_s_per_m)
    }
}

/// Friction coefficient of the cone and its slope: even in v; μ_s up to v_s, |μ| of the regularised law beyond.
#[inline(always)]
pub(super) fn friction_cone(law: &FrictionLaw, v: f64) -> (f64, f64) {
    if v.abs() < law.v_static_m_s {
        return (law.mu_static, 0.0);
    }
    let (mu, slope) = friction_coefficient(law, v);
    (mu.abs(), slope * v.signum())
}

/// T for a slip (m/s), an internal state σ (m/s) and a normal force (N).
#[inline(always)]
pub(super) fn bristle_force<T: Real>(law: &FrictionLaw, bristle: &Bristle, slip: T, state: T, normal: T) -> T {
    let (mu, slope) = friction_cone(law, slip.value());
    let limit = slip.chain(mu, slope) * normal;
    let sticking_force = (state + slip) * bristle.damping_n_s_per_m;
    if sticking_force.value() > limit.value() {
        limit
    } else if sticking_force.value() < -limit.value() {
        -limit
    } else {
        sticking_force
    }
}

/// Normal force from which a sticking bristle may leave the cone within a step, N. A smaller one is that of surfaces that
/// hardly touch, whose rounding errors exceed the cone.
const MIN_STICKING_N: f64 = 1e-9;

/// Friction on the sliding surface at a slip, an internal state and a normal force.
///
/// In a monitored range a bristle has the force of that branch also beyond its end: c (σ + v) while it sticks, and the force
/// of its side of the cone in transition. Steps are then smooth up to the event that ends the range. The law itself changes
/// its slope there from c to 0, within rates that are a millionth of usual ones.
#[inline(always)]
pub(super) fn force_in_range<T: Real>(
    law: &FrictionLaw,
    bristle: &Bristle,
    [slip, state, normal]: [T; 3],
    range: FrictionRange,
) -> T {
    match range {
        FrictionRange::Sticking if normal.value() > MIN_STICKING_N => -(state + slip) * bristle.damping_n_s_per_m,
        FrictionRange::Transition { forward } => {
            let (mu, slope) = friction_cone(law, slip.value());
            let limit = slip.chain(mu, slope) * normal;
            if forward { -limit } else { limit }
        }
        _ => -bristle_force(law, bristle, slip, state, normal),
    }
}

/// A margin of this part of the friction cone plus [`CONE_TOLERANCE_N`] counts as the finest slip scale of the law.
const CONE_RELATIVE_TOLERANCE: f64 = 0.1;
/// Absolute part of that margin, N.
const CONE_TOLERANCE_N: f64 = 1e-3;

/// Overlap of sticking and transition, in finest slip scales: 1e-7 of the limit of the cone. Without it the ranges alternated
/// for thousands of steps of 1e-13 s where the force stays at the cone. It is smaller than the overlap of other ranges,
/// because the branch beyond is another force.
pub(super) const CONE_OVERLAP: f64 = 1e-6;

/// Margin between the friction force and the cone, on one side of the cone, scaled to a slip in m/s.
fn cone_margin(law: &FrictionLaw, bristle: &Bristle, at: FrictionPoint, forward: bool) -> f64 {
    let limit = friction_cone(law, at.slip).0 * at.normal.max(0.0);
    let friction = bristle.damping_n_s_per_m * (at.state + at.slip);
    law.min_slip_scale_m_s() * (limit - if forward { friction } else { -friction })
        / (CONE_RELATIVE_TOLERANCE * (limit + CONE_TOLERANCE_N))
}

/// Range at a point: a bristle sticks within its cone, and has two sliding ranges.
pub(super) fn range(law: &FrictionLaw, bristle: &Bristle, at: FrictionPoint) -> FrictionRange {
    let forward = at.state + at.slip > 0.0;
    if cone_margin(law, bristle, at, forward) >= 0.0 {
        FrictionRange::Sticking
    } else if at.slip.abs() <= law.v_dynamic_m_s {
        FrictionRange::Transition { forward }
    } else {
        FrictionRange::Sliding { forward: at.slip > 0.0 }
    }
}

/// Margin between a point and the end of a range with its overlap, as a slip in m/s.
pub(super) fn range_margin(law: &FrictionLaw, bristle: &Bristle, range: FrictionRange, at: FrictionPoint) -> f64 {
    match range {
        FrictionRange::Transition { forward } => {
            let to_sliding = law.v_dynamic_m_s - at.slip.abs() + RANGE_OVERLAP * law.min_slip_scale_m_s();
            let to_sticking = CONE_OVERLAP * law.min_slip_scale_m_s() - cone_margin(law, bristle, at, forward);
            to_sticking.min(to_sliding)
        }
        FrictionRange::Sticking => cone_margin(law, bristle, at, true).min(cone_margin(law, bristle, at, false)),
        FrictionRange::Sliding { .. } | FrictionRange::Any => {
            regularised::margin(law, range, at.slip) + RANGE_OVERLAP * law.min_slip_scale_m_s()
        }
    }
}

/// Range beyond the nearest end of a range.
pub(super) fn neighbour_range(
    law: &FrictionLaw,
    bristle: &Bristle,
    range: FrictionRange,
    at: FrictionPoint,
) -> FrictionRange {
    match range {
        FrictionRange::Sticking => FrictionRange::Transition { forward: at.state + at.slip > 0.0 },
        FrictionRange::Sliding { forward } => FrictionRange::Transition { forward },
        FrictionRange::Transition { forward }
            if -cone_margin(law, bristle, at, forward) < law.v_dynamic_m_s - at.slip.abs() =>
        {
            FrictionRange::Sticking
        }
        FrictionRange::Transition { .. } => FrictionRange::Sliding { forward: at.slip > 0.0 },
        FrictionRange::Any => FrictionRange::Any,
    }
}

/// Scale of the sum of slip and state of a sticking bristle under this limit of its force, N, which bounds the sum tightly.
pub(super) fn slip_scale(bristle: &Bristle, limit: f64) -> f64 {
    (limit + CONE_TOLERANCE_N) / bristle.damping_n_s_per_m
}

/// Bounds of the ratio of friction to normal force. The slip does not determine the force, which only the cone bounds.
pub(super) fn ratio_bounds(law: &FrictionLaw, slips: [f64; 2]) -> [f64; 2] {
    let limit = slips.into_iter().map(|slip| friction_cone(law, slip).0).fold(0.0, f64::max);
    [-limit, limit]
}

/// One implicit Euler step: a sticking bristle stretches by the slip at its end; `one_way` resists negative slip only.
#[inline(always)]
pub(super) fn implicit_step(
    law: &FrictionLaw,
    bristle: &Bristle,
    at: FrictionPoint,
    h: f64,
    one_way: bool,
) -> FrictionStep {
    let FrictionPoint { slip, state, normal } = at;
    let (c, step_ratio) = (bristle.damping_n_s_per_m, h / bristle.relaxation_s);
    let (mu, slope) = friction_cone(law, slip);
    let limit = mu * normal;
    let sticking_force = c * (state + (1.0 + step_ratio) * slip);
    let upper = if one_way { 0.0 } else { limit };
    if sticking_force <= upper && sticking_force >= -limit {
        // Without a normal force there is no friction, and a nonzero slope would have no consistent slip.
        if limit == 0.0 {
            return FrictionStep { force: 0.0, d_slip: 0.0, d_normal: 0.0, state: state / (1.0 + step_ratio) };
        }
        return FrictionStep {
            force: sticking_force,
            d_slip: c * (1.0 + step_ratio),
            d_normal: 0.0,
            state: state + step_ratio * slip,
        };
    }
    let sign = if sticking_force > upper { if one_way { 0.0 } else { 1.0 } } else { -1.0 };
    let force = sign * limit;
    FrictionStep {
        force,
        d_slip: sign * slope * normal,
        d_normal: sign * mu,
        state: (state + step_ratio * force / c) / (1.0 + step_ratio),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::FrictionKind;
    use crate::numeric::Dual;

    const BRISTLE: Bristle = Bristle { damping_n_s_per_m: 1e6, relaxation_s: 1e-3 };
    const LAW: FrictionLaw = FrictionLaw {
        mu_static: 0.8,
        mu_dynamic: 0.56,
        v_static_m_s: 0.1,
        v_dynamic_m_s: 0.2,
        kind: FrictionKind::Bristle(BRISTLE),
    };

    fn step([slip, state, normal]: [f64; 3], h: f64, one_way: bool) -> FrictionStep {
        implicit_step(&LAW, &BRISTLE, FrictionPoint { slip, state, normal }, h, one_way)
    }

    #[test]
    fn there_is_no_friction_without_a_normal_force() {
        for slip in [-1e-12, 0.0, 1e-12] {
            let found = step([slip, 0.0, 0.0], 1e-7, false);
            assert_eq!((found.force, found.d_slip, found.state), (0.0, 0.0, 0.0), "{slip}");
        }
        assert!(step([0.0, 0.0, 1e-9], 1e-7, false).d_slip > 0.0);
    }

    #[test]
    fn the_cone_is_even_and_bounds_the_bristle_force() {
        for (v, mu) in [(0.0, 0.8), (0.05, 0.8), (0.1, 0.8), (0.15, 0.68), (0.2, 0.56), (7.0, 0.56)] {
            assert!(
                (friction_cone(&LAW, v).0 - mu).abs() < 1e-14 && friction_cone(&LAW, -v).0 == friction_cone(&LAW, v).0
            );
            assert_eq!(friction_cone(&LAW, v).1, -friction_cone(&LAW, -v).1);
        }
        for (slip, state, normal) in [(1e-6, 3e-6, 10.0), (0.3, 0.0, 10.0), (-0.3, 0.0, 10.0), (0.0, -1.0, 2.0)] {
            let force = bristle_force(&LAW, &BRISTLE, slip, state, normal);
            assert!(force.abs() <= 0.8 * normal && force * (slip + state) > 0.0);
        }
        assert_eq!(bristle_force(&LAW, &BRISTLE, 1e-6, 3e-6, 10.0), 4.0);
        assert_eq!(bristle_force(&LAW, &BRISTLE, 0.1, 0.0, 0.0), 0.0);
    }

    #[test]
    fn bristle_force_has_exact_derivatives_within_the_cone_and_beyond() {
        for at in [[1e-6, 3e-6, 10.0], [0.15, 1e-6, 10.0], [-0.17, 1e-6, 3.0], [0.4, 0.0, 3.0]] {
            let dual = [0, 1, 2].map(|i| Dual::<3>::variable(at[i], i));
            let found = bristle_force(&LAW, &BRISTLE, dual[0], dual[1], dual[2]);
            for i in 0..3 {
                let h = [1e-8, 1e-8, 1e-4][i];
                let force_at = |by: f64| {
                    let at: [f64; 3] = std::array::from_fn(|k| if k == i { at[k] + by } else { at[k] });
                    bristle_force(&LAW, &BRISTLE, at[0], at[1], at[2])
                };
                let slope = (force_at(h) - force_at(-h)) / (2.0 * h);
                assert!((found.grad[i] - slope).abs() < 1e-6 * slope.abs().max(1.0), "{at:?} {i}");
            }
        }
    }

    #[test]
    fn an_implicit_step_satisfies_the_law_at_its_end() {
        for (slip, state, h) in [(1e-6, 2e-6, 1e-4), (3e-5, 2e-6, 1e-4), (-0.2, 1e-6, 1e-5), (0.0, 9e-6, 1e-3)] {
            let found = step([slip, state, 10.0], h, false);
            let exact = bristle_force(&LAW, &BRISTLE, slip, found.state, 10.0);
            assert!((found.force - exact).abs() < 1e-9, "{found:?} {exact}");
            let rate = (found.force / BRISTLE.damping_n_s_per_m - found.state) / BRISTLE.relaxation_s;
            assert!((found.state - state - h * rate).abs() < 1e-18);
            let d = 1e-9;
            let force_at = |slip: f64, normal: f64| step([slip, state, normal], h, false).force;
            assert!(
                ((force_at(slip + d, 10.0) - force_at(slip - d, 10.0)) / (2.0 * d) - found.d_slip).abs()
                    < 1e-3 * (1.0 + found.d_slip.abs())
            );
            assert!(((force_at(slip, 10.0 + d) - force_at(slip, 10.0 - d)) / (2.0 * d) - found.d_normal).abs() < 1e-5);
        }
        // Slip in the free direction of a one-way bristle causes no force.
        assert_eq!(step([1e-5, 0.0, 10.0], 1e-4, true).force, 0.0);
        assert!(step([-1e-5, 0.0, 10.0], 1e-4, true).force < 0.0);
    }

    /// T v = d/dt ½ k s² + c ṡ² + T u with T u ≥ 0, u = v − ṡ.
    #[test]
    fn a_bristle_is_passive() {
        for slip in [-0.5, -1e-5, 0.0, 2e-6, 0.12, 3.0] {
            for state in [-8e-6, -1e-7, 0.0, 5e-6] {
                let force = bristle_force(&LAW, &BRISTLE, slip, state, 10.0);
                let (k, c) = (1e9, BRISTLE.damping_n_s_per_m);
                let (stretch, stretch_rate) = (c * state / k, force / c - state);
                let slider_rate = slip - stretch_rate;
                let dissipated_power = force * slip - k * stretch * stretch_rate;
                assert!(
                    (dissipated_power - c * stretch_rate * stretch_rate - force * slider_rate).abs()
                        < 1e-9 * (1.0 + dissipated_power.abs())
                );
                assert!(force * slider_rate >= -1e-20, "{slip} {state}: {}", force * slider_rate);
            }
        }
    }
}
