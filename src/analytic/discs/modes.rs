//! Which branch of its law each pair is on, and where that changes.

use super::pair::Other;
use super::{DiscMode, Discs, PAIRS, QUADRATURES, SiteState, stopping_time};
use crate::integrator::{Guard, Hybrid, System, Watch};
use crate::law::unclamped_normal_force;

/// Touch-down is landed on to within this fraction of δ_max, as far as positions have digits: contact times are measured.
const LANDING_FRACTION: f64 = 1e-8;

/// Lift-off and reload are landed on to within this force (N).
const FORCE_TOLERANCE: f64 = 1e-9;

/// A released contact takes up again above this force, so that lift-off and reload do not answer each other.
const RELOAD_FORCE: f64 = 3.0 * FORCE_TOLERANCE;

/// A restart takes this part of the time an impact needs to stop.
const RESTART_FRACTION: f64 = 0.05;

/// Part of the law's scales that a contact between driven or fixed surfaces may cross in a step: nothing it does is felt by
/// any coordinate, so that no error estimate would shorten its steps.
const DRIVEN_FRACTION: f64 = 0.05;

const QUIET: Guard = Guard { value: f64::INFINITY, rate: 0.0, interpolates: true, apart: true };

impl<const N: usize, const M: usize> Discs<N, M> {
    /// δ and its rate.
    #[inline(always)]
    fn depth(&self, q: &[f64; N], v: &[f64; N], pair: usize) -> (f64, f64) {
        let meeting = &self.meetings[pair];
        let geometry = meeting.geometry(q);
        (-geometry.gap, -meeting.rates(geometry.normal, v).gap_rate)
    }

    /// Guard of one pair on its branch.
    #[inline(always)]
    fn guard(&self, state: SiteState, delta: f64, rate: f64) -> Guard {
        let law = &self.law.normal;
        let force = || unclamped_normal_force(law, delta, rate).force;
        match state {
            SiteState::Natural => QUIET,
            SiteState::Free => Guard { value: -delta, rate: -rate, interpolates: true, apart: true },
            // Just landed and about to enter.
            SiteState::Active if delta <= 0.0 && rate >= 0.0 => Guard { interpolates: false, apart: false, ..QUIET },
            // Without a damper the force ends where the surfaces part, and is small long before.
            SiteState::Active if law.damping_max_n_s_per_m == 0.0 => Guard {
                value: if delta > 0.0 { delta } else { delta.min(-1e-290) },
                rate,
                interpolates: true,
                apart: false,
            },
            SiteState::Active => {
                let value = if delta > 0.0 { force() } else { delta.min(-1e-290) };
                Guard { value, rate: 0.0, interpolates: false, apart: false }
            }
            SiteState::Released => {
                Guard { value: RELOAD_FORCE - force(), rate: 0.0, interpolates: true, apart: delta < 0.0 }
            }
        }
    }

    /// Whether neither side of a pair feels it.
    fn is_driven(&self, pair: usize) -> bool {
        let meeting = &self.meetings[pair];
        let heavy = |disc: usize| self.movers[disc].inverse_mass == 0.0;
        heavy(meeting.disc)
            && match meeting.other {
                Other::Moving { disc, .. } => heavy(disc),
                Other::Fixed { .. } | Other::HalfPlane { .. } => true,
            }
    }
}

impl<const N: usize, const M: usize> Hybrid<N, QUADRATURES, PAIRS> for Discs<N, M> {
    fn next_corner(&self, _: f64) -> f64 {
        f64::INFINITY
    }

    fn longest_step(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> f64 {
        let mut longest = f64::INFINITY;
        for pair in (0..self.pairs()).filter(|pair| mode[*pair] == SiteState::Active && self.is_driven(*pair)) {
            let (delta, rate) = self.depth(q, v, pair);
            let depth = delta.max(self.law.normal.transition_m);
            longest = longest.min(DRIVEN_FRACTION * depth / rate.abs());
            if let Some(friction) = &self.law.friction {
                let a = self.rates(t, q, v, mode).a;
                let meeting = &self.meetings[pair];
                let normal = meeting.geometry(q).normal;
                longest = longest.min(DRIVEN_FRACTION * friction.v_static_m_s / meeting.rates(normal, &a).slip.abs());
            }
        }
        longest
    }

    #[inline(always)]
    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Watch<PAIRS> {
        let guards = std::array::from_fn(|pair| {
            if pair >= self.pairs() || mode[pair] == SiteState::Natural {
                return QUIET;
            }
            let (delta, rate) = self.depth(q, v, pair);
            self.guard(mode[pair], delta, rate)
        });
        Watch { guards, clearance: f64::INFINITY, clearance_rate: 0.0 }
    }

    fn landing_tolerance(&self, site: usize, mode: &DiscMode) -> f64 {
        let law = &self.law.normal;
        match mode[site] {
            SiteState::Active if law.damping_max_n_s_per_m > 0.0 => FORCE_TOLERANCE,
            SiteState::Released | SiteState::Natural => FORCE_TOLERANCE,
            SiteState::Free | SiteState::Active => LANDING_FRACTION * law.transition_m,
        }
    }

    fn switch(&self, site: usize, mode: &DiscMode) -> DiscMode {
        let mut next = *mode;
        next[site] = match mode[site] {
            SiteState::Free | SiteState::Released => SiteState::Active,
            SiteState::Active => SiteState::Released,
            SiteState::Natural => SiteState::Natural,
        };
        next
    }

    fn relax(&self, guards: &[Guard; PAIRS], mode: &DiscMode) -> Option<DiscMode> {
        let mut next = *mode;
        for (state, guard) in next.iter_mut().zip(guards) {
            if *state == SiteState::Released && guard.apart {
                *state = SiteState::Free;
            }
        }
        (next != *mode).then_some(next)
    }

    fn with_natural(&self, site: usize, mode: &DiscMode) -> DiscMode {
        let mut next = *mode;
        next[site] = SiteState::Natural;
        next
    }

    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> DiscMode {
        // Without the pairs that are just touching, to see which way they are about to move.
        let mut mode = [SiteState::Free; PAIRS];
        let mut touching = [None; PAIRS];
        let law = &self.law.normal;
        for pair in 0..self.pairs() {
            let (delta, rate) = self.depth(q, v, pair);
            if delta.abs() <= LANDING_FRACTION * law.transition_m {
                touching[pair] = Some(rate);
            } else if delta > 0.0 {
                let force = unclamped_normal_force(law, delta, rate).force;
                mode[pair] = if force >= 0.0 { SiteState::Active } else { SiteState::Released };
            }
        }
        let free = self.rates(t, q, v, &mode).a;
        for (pair, touch) in touching.iter().enumerate() {
            let Some(rate) = *touch else { continue };
            let resting = rate.abs() < 1e-12;
            let closing = || -self.meetings[pair].rates(self.meetings[pair].geometry(q).normal, &free).gap_rate;
            if rate >= 1e-12 || (resting && closing() > 0.0) {
                mode[pair] = SiteState::Active;
            }
        }
        mode
    }

    fn restart_step(&self, site: usize, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Option<f64> {
        if mode[site] != SiteState::Active {
            return None;
        }
        let meeting = &self.meetings[site];
        let other = match meeting.other {
            Other::Moving { disc, .. } => self.movers[disc].inverse_mass,
            Other::Fixed { .. } | Other::HalfPlane { .. } => 0.0,
        };
        let mobility = self.movers[meeting.disc].inverse_mass + other;
        let speed = self.depth(q, v, site).1.abs();
        Some(RESTART_FRACTION * stopping_time(&self.law.normal, speed, 1.0 / mobility))
    }

    fn obstacle(&self, _: &[f64; N]) -> String {
        "two discs have the same centre".to_string()
    }
}
