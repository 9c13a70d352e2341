//! Where the branches of the pairs change.

use super::mode::{Contact, DamperRange, Landing, Press, range_of};
use super::pair::Other;
use super::{DiscMode, Discs, GUARDS, PAIRS, QUADRATURES, SiteState, first_step};
use crate::integrator::{Guard, Hybrid, System, Watch};
use crate::law::{FrictionRange, unclamped_normal_force};

/// Touch-downs are landed on to within a part of δ_max, as far as positions have digits: contact times are measured.
const LANDING: Landing = Landing { depth_share: 1e-8, force: 1e-9 };

/// Part of the law's scales that a contact between driven or fixed surfaces may cross in a step: nothing it does is felt by
/// any coordinate, so that no error estimate would shorten its steps.
const DRIVEN_FRACTION: f64 = 0.05;

impl<const N: usize, const M: usize> Discs<N, M> {
    /// What a guard asks of a pair.
    #[inline(always)]
    fn contact(&self, q: &[f64; N], v: &[f64; N], pair: usize) -> Contact<N> {
        let meeting = &self.meetings[pair];
        let geometry = meeting.geometry(q);
        let rates = meeting.rates(geometry.normal, v);
        let (memory, mut tangent) = (self.memory(pair), meeting.tangent_row(geometry.normal));
        memory.into_iter().for_each(|memory| tangent[memory] = 1.0);
        Contact {
            delta: -geometry.gap,
            rate: -rates.gap_rate,
            memory: memory.map_or(0.0, |memory| v[memory]),
            slip: rates.slip,
            row: meeting.normal_row(geometry.normal),
            tangent,
        }
    }

    /// δ and its rate.
    #[inline(always)]
    fn depth(&self, q: &[f64; N], v: &[f64; N], pair: usize) -> (f64, f64) {
        let meeting = &self.meetings[pair];
        let geometry = meeting.geometry(q);
        (-geometry.gap, -meeting.rates(geometry.normal, v).gap_rate)
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

impl<const N: usize, const M: usize> Hybrid<N, QUADRATURES, GUARDS> for Discs<N, M> {
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
    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Watch<N, GUARDS> {
        let mut guards = [Guard::QUIET; GUARDS];
        for pair in 0..self.pairs() {
            if mode[pair] == SiteState::Natural && mode.slips[pair] == FrictionRange::Any {
                continue;
            }
            let at = self.contact(q, v, pair);
            let press = Press::of(&self.law.normal, &at);
            guards[pair] = mode.normal_guard(pair, &self.law.normal, &LANDING, &at, &press);
            guards[2 * PAIRS + pair] = mode.damper_guard(pair, &self.law.normal, &at);
            if let Some(friction) = &self.law.friction {
                guards[PAIRS + pair] = mode.slip_guard(pair, friction, &at, &press);
            }
        }
        Watch { guards, clearance: f64::INFINITY, clearance_rate: 0.0 }
    }

    fn landing_tolerance(&self, guard: usize, mode: &DiscMode) -> f64 {
        mode.landing_tolerance(guard, &self.law.normal, self.law.friction.as_ref(), &LANDING)
    }

    fn switch(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> DiscMode {
        let at = self.contact(q, v, guard % PAIRS);
        mode.switched(guard, &self.law.normal, self.law.friction.as_ref(), &at)
    }

    fn is_told(&self, guard: usize) -> bool {
        guard < PAIRS
    }

    fn relax(&self, guards: &[Guard<N>; GUARDS], mode: &DiscMode) -> Option<DiscMode> {
        mode.relaxed(guards)
    }

    fn with_natural(&self, guard: usize, mode: &DiscMode) -> DiscMode {
        mode.with_natural(guard)
    }

    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> DiscMode {
        // Without the pairs that are just touching, to see which way they are about to move.
        let mut mode = DiscMode::FREE;
        let mut touching = [None; PAIRS];
        let law = &self.law.normal;
        for pair in 0..self.pairs() {
            let at = self.contact(q, v, pair);
            let Contact { delta, rate, .. } = at;
            let pressed = Press::of(law, &at).force();
            mode.dampers[pair] = DamperRange::of(law, delta);
            mode.slips[pair] = self.law.friction.map_or(FrictionRange::Any, |law| range_of(&law, &at, pressed));
            if delta.abs() <= LANDING.depth_share * law.transition_m {
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

    fn restart_step(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &DiscMode) -> Option<f64> {
        let site = guard % PAIRS;
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
        Some(first_step(&self.law.normal, speed, 1.0 / mobility))
    }

    fn obstacle(&self, _: &[f64; N]) -> String {
        "two discs have the same centre".to_string()
    }
}
