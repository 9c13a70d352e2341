//! Where the branches of the finger's contacts change.

use super::mode::{Contact, Landing, Press, SiteState, is_kinked};
use super::model::{FingerMode, FingerMotion, GUARDS, QUADRATURES, own, spread};
use crate::fivebar::dynamics::{absolute_rates, solve_mass};
use crate::fivebar::kinematics::{Directions, PassiveRates, SINGULAR_SINE, nearest_singularity};
use crate::gripper::Site;
use crate::integrator::{Guard, Hybrid, Settled, System, Tolerances, Watch};
use crate::law::{NormalLaw, damping};
use crate::numeric::each;
use crate::numeric::elementary::{cbrt, pow, powi};
use crate::numeric::plane::{cross, dot};
use crate::scene::next_corner;

/// Touch-downs are landed on to within a part of δ_max, lift-off and reload to within a force far below anything the finger feels.
const LANDING: Landing = Landing { depth_share: 1e-5, force: 1e-6 };

/// The site of a guard: normal laws first, then slips.
fn site_of(guard: usize) -> Site {
    Site::ALL[guard % Site::ALL.len()]
}

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// What a guard asks of a site; `None` where the scene has no such contact.
    #[inline(always)]
    fn contact(
        &self,
        pose: &Directions<f64>,
        rates: &PassiveRates<f64>,
        v: &[f64; N],
        site: Site,
    ) -> Option<Contact<N>> {
        let geometry = self.geometry(pose, rates, site)?;
        let (rate, slip) = (-dot(geometry.normal_row, own(v)), dot(geometry.tangent_row, own(v)));
        let mut at = Contact {
            delta: -geometry.gap,
            rate,
            slip,
            memory: 0.0,
            row: spread(geometry.normal_row),
            tangent: spread(geometry.tangent_row),
        };
        if let Some(memory) = Self::memory_of(site) {
            (at.memory, at.tangent[memory]) = (v[memory], 1.0);
        }
        Some(at)
    }

    /// All guards of a state.
    #[inline(always)]
    fn guards(
        &self,
        pose: &Directions<f64>,
        rates: &PassiveRates<f64>,
        v: &[f64; N],
        mode: &FingerMode,
    ) -> [Guard<N>; GUARDS] {
        const SITES: usize = Site::ALL.len();
        let mut guards = [Guard::QUIET; GUARDS];
        for site in Site::ALL {
            let index = site as usize;
            if mode.is_left_alone(index) {
                continue;
            }
            let Some((at, law)) = self.contact(pose, rates, v, site).zip(self.finger.normal_law(site)) else {
                continue;
            };
            let press = Press::of(law, &at);
            guards[index] = mode.normal_guard(index, law, &LANDING, &at, &press);
            guards[index + 2 * SITES] = mode.damper_guard(index, law, &at);
            if let Some(friction) = self.finger.friction_law(site) {
                guards[index + SITES] = mode.slip_guard(index, friction, &at, &press);
            }
        }
        guards
    }

    /// One guard without its strain.
    #[inline(always)]
    fn guard(
        &self,
        place: &(Directions<f64>, PassiveRates<f64>),
        v: &[f64; N],
        mode: &FingerMode,
        guard: usize,
    ) -> Guard<N> {
        let (site, (pose, rates)) = (site_of(guard), place);
        let at = self.contact(pose, rates, v, site).zip(self.finger.normal_law(site));
        at.map_or(Guard::QUIET, |(at, law)| mode.guard(guard, (law, self.finger.friction_law(site)), &LANDING, &at))
    }
}

/// A contact only trembles if its rate and depth are no larger than this, m/s and m (limit: rad/s and rad); the rate at a relative
/// tolerance of 1e-5, less with its root. What lets go of such a contact leaves with another rate than it would have, so finer runs
/// (and with them the check) must see less of it; the reference, too, has to get through what trembles by 3e-3 (scenes/hard/limit-trembles)…
const TREMBLING_RATE: f64 = 0.05;
const LEAST_TREMBLING_RATE: f64 = 5e-3;
const TREMBLING_DEPTH: f64 = 1e-8;
/// …and its damper is weaker than this part of its spring.
const TREMBLING_DAMPER: f64 = 0.1;

impl<const N: usize, const W: usize> FingerMotion<N, W> {
    /// The state with one contact at rest at the depth at which its spring holds what presses on it, if it trembles about that.
    fn at_rest(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &FingerMode,
        site: Site,
        fastest: f64,
    ) -> Option<Settled<N>> {
        let terms = self.finger.terms(own(q));
        let (at, law) = self.contact(&terms.pose, &terms.rates, v, site).zip(self.finger.normal_law(site))?;
        let small = at.delta.abs() <= TREMBLING_DEPTH && at.rate.abs() <= fastest;
        if !small || law.stiffness_n_per_m_e == 0.0 {
            return None;
        }
        let mut without = *mode;
        without[site as usize] = SiteState::Free;
        let free = self.rates(t, q, v, &without).a;
        // Along the free motion rows turn: their part in the gap's acceleration, by a central difference.
        let moved = |h: f64| -> Option<f64> {
            let q = [q[0] + h * v[0], q[1] + h * v[1]];
            let (pose, rates) = self.finger.place(q);
            Some(dot(self.geometry(&pose, &rates, site)?.normal_row, own(v)))
        };
        let turning = (moved(TURNING_S)? - moved(-TURNING_S)?) / (2.0 * TURNING_S);
        let row = own(&at.row);
        let response = solve_mass(&terms.mass, row);
        let mobility = dot(row, response);
        let load = -(dot(row, own(&free)) + turning) / mobility;
        if load <= 0.0 {
            return None;
        }
        let depth = pow(load / law.stiffness_n_per_m_e, 1.0 / law.exponent);
        let stiffness = law.exponent * load / depth;
        let critical = 2.0 * (stiffness / mobility).sqrt();
        if depth > TREMBLING_DEPTH || damping(law, depth).0 > TREMBLING_DAMPER * critical {
            return None;
        }
        // The gap shrinks by what the depth lacks, and its rate goes.
        let (gap, rate) = ((at.delta - depth) / mobility, at.rate / mobility);
        let response: [f64; N] = spread(response);
        Some(Settled {
            q: each(|i| q[i] + gap * response[i]),
            v: each(|i| v[i] + rate * response[i]),
            decay: 0.5 * damping(law, depth).0 * mobility,
        })
    }
}

/// Time over which rows are seen to turn, either way.
const TURNING_S: f64 = 1e-7;

impl<const N: usize, const W: usize> Hybrid<N, QUADRATURES, GUARDS> for FingerMotion<N, W> {
    fn next_corner(&self, t: f64) -> f64 {
        next_corner(&self.actuation, t)
    }

    #[inline(always)]
    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> Watch<N, GUARDS> {
        let (pose, rates) = self.finger.place(own(q));
        let (sine, cosine) = (cross(pose.e3, pose.e4), dot(pose.e3, pose.e4));
        let [_, _, rate3, rate4] = absolute_rates(&rates, own(v));
        let guards = self.guards(&pose, &rates, v, mode);
        Watch {
            guards,
            clearance: sine.abs() - SINGULAR_SINE,
            clearance_rate: sine.signum() * cosine * (rate4 - rate3),
        }
    }

    #[inline(always)]
    fn glance(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode, guard: usize) -> Guard<N> {
        self.guard(&self.finger.place(own(q)), v, mode, guard)
    }

    #[inline(always)]
    fn values(&self, q: &[f64; N], v: &[f64; N], mode: &FingerMode, wanted: &[bool; GUARDS]) -> [f64; GUARDS] {
        const SITES: usize = Site::ALL.len();
        let (pose, rates) = self.finger.place(own(q));
        let mut values = [f64::NAN; GUARDS];
        for site in Site::ALL {
            let guards = [site as usize, site as usize + SITES, site as usize + 2 * SITES];
            if guards.iter().all(|guard| !wanted[*guard]) {
                continue;
            }
            let at = self.contact(&pose, &rates, v, site).zip(self.finger.normal_law(site));
            let laws = |law| (law, self.finger.friction_law(site));
            for guard in guards.into_iter().filter(|guard| wanted[*guard]) {
                let quiet = Guard::<N>::QUIET;
                values[guard] = at.map_or(quiet, |(at, law)| mode.guard(guard, laws(law), &LANDING, &at)).value;
            }
        }
        values
    }

    fn landing_tolerance(&self, guard: usize, mode: &FingerMode) -> f64 {
        let site = site_of(guard);
        let friction = self.finger.friction_law(site);
        self.finger.normal_law(site).map_or(0.0, |law| mode.landing_tolerance(guard, law, friction, &LANDING))
    }

    fn switch(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> FingerMode {
        let site = site_of(guard);
        let (pose, rates) = self.finger.place(own(q));
        let at = self.contact(&pose, &rates, v, site).zip(self.finger.normal_law(site));
        at.map_or(*mode, |(at, law)| mode.switched(guard, law, self.finger.friction_law(site), &at))
    }

    fn is_told(&self, guard: usize) -> bool {
        guard < Site::ALL.len()
    }

    fn relax(&self, guards: &[Guard<N>; GUARDS], mode: &FingerMode) -> Option<FingerMode> {
        mode.relaxed(guards)
    }

    fn with_natural(&self, guard: usize, mode: &FingerMode) -> FingerMode {
        mode.with_natural(guard)
    }

    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> FingerMode {
        let (pose, rates) = self.finger.place(own(q));
        let at = |index: usize| {
            let site = Site::ALL[index];
            let (at, law) = self.contact(&pose, &rates, v, site).zip(self.finger.normal_law(site))?;
            Some((at, law, self.finger.friction_law(site)))
        };
        FingerMode::read(&LANDING, at, |mode| self.rates(t, q, v, mode).a)
    }

    fn restart_step(&self, guard: usize, q: &[f64; N], v: &[f64; N], mode: &FingerMode) -> Option<f64> {
        let which = site_of(guard);
        if mode[which as usize] != SiteState::Active {
            return None;
        }
        let terms = self.finger.terms(own(q));
        let (geometry, law) = (self.geometry(&terms.pose, &terms.rates, which)?, self.finger.normal_law(which)?);
        let row = geometry.normal_row;
        let speed = dot(row, own(v)).abs();
        let mobility = dot(row, solve_mass(&terms.mass, row));
        Some(first_step(law, speed, 1.0 / mobility))
    }

    fn settle(
        &self,
        t: f64,
        (q, v): (&[f64; N], &[f64; N]),
        mode: &FingerMode,
        tolerances: &Tolerances,
    ) -> Option<Settled<N>> {
        let mut all = Settled { q: *q, v: *v, decay: f64::INFINITY };
        let fastest = TREMBLING_RATE * (tolerances.rtol_v / 1e-5).sqrt();
        let fastest = fastest.clamp(LEAST_TREMBLING_RATE, TREMBLING_RATE);
        for site in Site::ALL {
            if let Some(at_rest) = self.at_rest(t, (&all.q, &all.v), mode, site, fastest) {
                all = Settled { decay: all.decay.min(at_rest.decay), ..at_rest };
            }
        }
        all.decay.is_finite().then_some(all)
    }

    fn obstacle(&self, q: &[f64; N]) -> String {
        format!("singular configuration: {}", nearest_singularity(&self.finger.dynamics.lengths, own(q)))
    }
}

/// Part of the time an impact needs to stop that its first step may take.
const RESTART_FRACTION: f64 = 0.05;
/// The same where a spring without a smooth force stops it: a first step misses (h/T)^(e+1) of its impulse.
const KINKED_FRACTION: f64 = 0.01;

/// First step of an impact at `speed` of an effective `mass`: a part of its time scale, depth over speed, with the depth at which damper
/// or spring, whichever bites first, has used up the momentum.
///
/// Damper alone: m v = c_max (δ³/δ_max² − …), spring alone: m v² / 2 = k δᵉ⁺¹/(e + 1).
pub(super) fn first_step(law: &NormalLaw, speed: f64, mass: f64) -> f64 {
    let [damper, spring] = stopping_depths(law, speed, mass);
    let fraction = if is_kinked(law) && spring < damper { KINKED_FRACTION } else { RESTART_FRACTION };
    fraction * (damper.min(spring) / speed.max(SLOWEST_IMPACT))
}

const SLOWEST_IMPACT: f64 = 1e-6;

/// Depths in which damper and spring would stop an impact, each alone.
fn stopping_depths(law: &NormalLaw, speed: f64, mass: f64) -> [f64; 2] {
    let speed = speed.max(SLOWEST_IMPACT);
    let by_damper = if law.damping_max_n_s_per_m > 0.0 {
        cbrt(mass * speed * powi(law.transition_m, 2) / law.damping_max_n_s_per_m)
    } else {
        f64::INFINITY
    };
    let by_spring =
        pow(0.5 * (law.exponent + 1.0) * mass * speed * speed / law.stiffness_n_per_m_e, 1.0 / (law.exponent + 1.0));
    [by_damper, by_spring]
}
