//! Which branch of its law each contact is on, and where that changes.

use super::model::{Mode, Model, QUADRATURES, SiteState};
use crate::fivebar::dynamics::{absolute_rates, solve_mass};
use crate::fivebar::kinematics::{SINGULAR_SINE, nearest_singularity};
use crate::gripper::Site;
use crate::integrator::{Guard, Hybrid, System, Watch};
use crate::law::{NormalLaw, unclamped_normal_force};
use crate::numeric::plane::{cross, dot};
use crate::scene::next_corner;

/// Touch-down is landed on to within this fraction of δ_max.
const LANDING_FRACTION: f64 = 1e-5;

/// Lift-off and reload are landed on to within this force, far below anything the finger feels (N; limit: N·m).
const FORCE_TOLERANCE: f64 = 1e-6;

/// A released contact takes up again above this force, so that lift-off and reload do not answer each other.
const RELOAD_FORCE: f64 = 3.0 * FORCE_TOLERANCE;

fn landing_depth(law: &NormalLaw) -> f64 {
    LANDING_FRACTION * law.transition_m
}

impl Hybrid<2, QUADRATURES, 3> for Model {
    fn next_corner(&self, t: f64) -> f64 {
        next_corner(&self.actuation, t)
    }

    #[inline(always)]
    fn watch(&self, q: &[f64; 2], v: &[f64; 2], mode: &Mode) -> Watch<3> {
        let terms = self.terms(*q);
        let pose = &terms.pose;
        let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
        let [_, _, rate3, rate4] = absolute_rates(&terms.rates, *v);
        let guards = Site::ALL.map(|site| {
            let state = mode[site as usize];
            let quiet = Guard { value: f64::INFINITY, rate: 0.0, interpolates: true, apart: true };
            let force_guard = |value| Guard { value, rate: 0.0, interpolates: false, apart: false };
            if state == SiteState::Natural {
                return quiet;
            }
            let (Some(geometry), Some(law)) = (self.geometry(&terms, site), self.normal_law(site)) else {
                return quiet;
            };
            let gap_rate = dot(geometry.normal_row, *v);
            let (delta, rate) = (-geometry.gap, -gap_rate);
            match state {
                SiteState::Free => Guard { value: geometry.gap, rate: gap_rate, interpolates: true, apart: true },
                SiteState::Active if delta > 0.0 => force_guard(unclamped_normal_force(law, delta, rate).force),
                // Just landed and about to enter, or gone through zero without ever pulling.
                SiteState::Active => force_guard(if rate >= 0.0 { f64::INFINITY } else { delta.min(-1e-290) }),
                _ => {
                    let force = unclamped_normal_force(law, delta, rate).force;
                    Guard { value: RELOAD_FORCE - force, rate: 0.0, interpolates: true, apart: delta < 0.0 }
                }
            }
        });
        Watch {
            guards,
            clearance: sine.abs() - SINGULAR_SINE,
            clearance_rate: sine.signum() * cosine * (rate4 - rate3),
        }
    }

    fn landing_tolerance(&self, site: usize, mode: &Mode) -> f64 {
        let which = Site::ALL[site];
        match mode[site] {
            SiteState::Free => self.normal_law(which).map_or(0.0, landing_depth),
            _ => FORCE_TOLERANCE,
        }
    }

    fn switch(&self, site: usize, mode: &Mode) -> Mode {
        let mut next = *mode;
        next[site] = match mode[site] {
            SiteState::Free | SiteState::Released => SiteState::Active,
            SiteState::Active => SiteState::Released,
            SiteState::Natural => SiteState::Natural,
        };
        next
    }

    fn relax(&self, guards: &[Guard; 3], mode: &Mode) -> Option<Mode> {
        let mut next = *mode;
        for (state, guard) in next.iter_mut().zip(guards) {
            if *state == SiteState::Released && guard.apart {
                *state = SiteState::Free;
            }
        }
        (next != *mode).then_some(next)
    }

    fn with_natural(&self, site: usize, mode: &Mode) -> Mode {
        let mut next = *mode;
        next[site] = SiteState::Natural;
        next
    }

    fn read_mode(&self, t: f64, q: &[f64; 2], v: &[f64; 2]) -> Mode {
        let terms = self.terms(*q);
        // Without the sites that are just touching, to see which way they are about to move.
        let mut mode = [SiteState::Free; 3];
        let mut touching = [None; 3];
        for site in Site::ALL {
            let index = site as usize;
            let (Some(geometry), Some(law)) = (self.geometry(&terms, site), self.normal_law(site)) else {
                continue;
            };
            let (delta, rate) = (-geometry.gap, -dot(geometry.normal_row, *v));
            if delta.abs() <= landing_depth(law) {
                touching[index] = Some((geometry.normal_row, rate));
            } else if delta > 0.0 {
                let force = unclamped_normal_force(law, delta, rate).force;
                mode[index] = if force >= 0.0 { SiteState::Active } else { SiteState::Released };
            }
        }
        let free = self.rates(t, q, v, &mode).a;
        for (state, touch) in mode.iter_mut().zip(touching) {
            let Some((row, rate)) = touch else { continue };
            let resting = rate.abs() < 1e-12;
            if rate >= 1e-12 || (resting && -dot(row, free) > 0.0) {
                *state = SiteState::Active;
            }
        }
        mode
    }

    fn restart_step(&self, site: usize, q: &[f64; 2], v: &[f64; 2], mode: &Mode) -> Option<f64> {
        if mode[site] != SiteState::Active {
            return None;
        }
        let which = Site::ALL[site];
        let terms = self.terms(*q);
        let (geometry, law) = (self.geometry(&terms, which)?, self.normal_law(which)?);
        let row = geometry.normal_row;
        let speed = dot(row, *v).abs();
        let mobility = dot(row, solve_mass(&terms.mass, row));
        Some(RESTART_FRACTION * stopping_time(law, speed, 1.0 / mobility))
    }

    fn obstacle(&self, q: &[f64; 2]) -> String {
        format!("singular configuration: {}", nearest_singularity(&self.dynamics.lengths, *q))
    }
}

const RESTART_FRACTION: f64 = 0.05;

/// Time scale of an impact at `speed` of an effective `mass`: depth over speed, with the depth at which damper or spring,
/// whichever bites first, has used up the momentum.
///
/// Damper alone: m v = c_max (δ³/δ_max² − …), spring alone: m v² / 2 = k δᵉ⁺¹/(e + 1).
pub(super) fn stopping_time(law: &NormalLaw, speed: f64, mass: f64) -> f64 {
    let speed = speed.max(1e-6);
    let by_damper = if law.damping_max_n_s_per_m > 0.0 {
        (mass * speed * law.transition_m.powi(2) / law.damping_max_n_s_per_m).cbrt()
    } else {
        f64::INFINITY
    };
    let by_spring =
        (0.5 * (law.exponent + 1.0) * mass * speed * speed / law.stiffness_n_per_m_e).powf(1.0 / (law.exponent + 1.0));
    by_damper.min(by_spring) / speed
}
