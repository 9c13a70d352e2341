//! Which branch of its laws every contact is on, and the guards that say where that ends: for fingers and discs alike.

use std::ops::{Index, IndexMut};

use crate::integrator::{Guard, Look, Strain};
use crate::law::{
    Bristle, FrictionLaw, FrictionRange, NormalLaw, cone, damping, friction_range, is_damped, spring_force,
    unclamped_normal_force,
};

/// Branch of the normal law at one site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SiteState {
    /// Surfaces apart: no force.
    Free,
    /// k δᵉ + c δ̇ as it stands; an event ends it where it turns negative.
    Active,
    /// Still overlapping, but let go: the clamp holds the force at zero.
    Released,
    /// max(0, k δᵉ + c δ̇), whatever happens: for one step where events chatter.
    Natural,
}

impl SiteState {
    /// Whether there is a force on this branch.
    #[inline(always)]
    pub fn presses(self) -> bool {
        matches!(self, Self::Active | Self::Natural)
    }
}

/// Whether a contact is less deep than its damper's transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamperRange {
    /// δ < δ_max: c grows with the depth.
    Engaging,
    /// c = c_max.
    Engaged,
    /// Not looked at.
    Any,
}

/// Branches of all sites: of their normal laws, and the ranges of their dampers and friction laws.
///
/// The ranges change no force: the laws are the same functions in all of them. They keep a step from leaping over a part of a law, like
/// from sliding one way to sliding the other across the whole sticking range, where neither its stages nor its error would see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode<const S: usize> {
    pub sites: [SiteState; S],
    pub slips: [FrictionRange; S],
    pub dampers: [DamperRange; S],
}

impl DamperRange {
    /// That of a contact which is so deep.
    #[inline(always)]
    pub fn of(law: &NormalLaw, delta: f64) -> Self {
        match is_damped(law) {
            false => DamperRange::Any,
            true if delta < law.transition_m => DamperRange::Engaging,
            true => DamperRange::Engaged,
        }
    }
}

impl<const S: usize> From<[SiteState; S]> for Mode<S> {
    fn from(sites: [SiteState; S]) -> Self {
        Self { sites, ..Self::FREE }
    }
}

impl<const S: usize> Index<usize> for Mode<S> {
    type Output = SiteState;

    #[inline(always)]
    fn index(&self, site: usize) -> &SiteState {
        &self.sites[site]
    }
}

impl<const S: usize> IndexMut<usize> for Mode<S> {
    #[inline(always)]
    fn index_mut(&mut self, site: usize) -> &mut SiteState {
        &mut self.sites[site]
    }
}

/// What one site is asked about: its penetration and rate, its slip, and the rows that give the rates of gap and slip.
#[derive(Clone, Copy, Debug)]
pub struct Contact<const N: usize> {
    pub delta: f64,
    pub rate: f64,
    pub slip: f64,
    /// σ of its bristle.
    pub memory: f64,
    pub row: [f64; N],
    pub tangent: [f64; N],
}

/// What the normal law makes of a contact: the forces of its spring and its damper, N (limit: N·m), which may pull.
#[derive(Clone, Copy, Debug, Default)]
pub struct Press {
    spring: f64,
    damper: f64,
}

impl Press {
    #[inline(always)]
    pub fn of<const N: usize>(law: &NormalLaw, at: &Contact<N>) -> Self {
        if at.delta <= 0.0 {
            return Self { spring: 0.0, damper: 0.0 };
        }
        Self { spring: spring_force(law, at.delta), damper: damping(law, at.delta).0 * at.rate }
    }

    #[inline(always)]
    pub fn force(&self) -> f64 {
        self.spring + self.damper
    }
}

/// Part of the cone, and a force in N, by which a bristle's pull may be off by as much as its law's finest range.
const CONE_SHARE: f64 = 0.1;
const CONE_FLOOR: f64 = 1e-3;

/// How far a bristle's pull is below the cone on one side of it, in parts of what counts as the law's finest range of slip, m/s.
fn room_below<const N: usize>(law: &FrictionLaw, bristle: &Bristle, at: &Contact<N>, force: f64, forward: bool) -> f64 {
    let most = cone(law, at.slip).0 * force.max(0.0);
    let held = bristle.damping_n_s_per_m * (at.memory + at.slip);
    law.finest_m_s() * (most - if forward { held } else { -held }) / (CONE_SHARE * (most + CONE_FLOOR))
}

/// The range that the friction of a contact under a normal force is in. A bristle sticks below its cone, and has two ranges of sliding.
pub fn range_of<const N: usize>(law: &FrictionLaw, at: &Contact<N>, force: f64) -> FrictionRange {
    let Some(bristle) = &law.bristle else { return friction_range(law, at.slip) };
    let forward = at.memory + at.slip > 0.0;
    if room_below(law, bristle, at, force, forward) >= 0.0 {
        FrictionRange::Sticks
    } else if at.slip.abs() <= law.v_dynamic_m_s {
        FrictionRange::Yields { forward }
    } else {
        FrictionRange::Slides { forward: at.slip > 0.0 }
    }
}

/// How far a contact is from the end of a range, m/s or what counts as that.
fn room_of<const N: usize>(range: FrictionRange, law: &FrictionLaw, at: &Contact<N>, force: f64) -> f64 {
    let Some(bristle) = &law.bristle else { return range.room(law, at.slip) };
    match range {
        FrictionRange::Sticks => {
            let [up, down] = [true, false].map(|forward| room_below(law, bristle, at, force, forward));
            up.min(down)
        }
        FrictionRange::Yields { forward } => {
            (-room_below(law, bristle, at, force, forward)).min(law.v_dynamic_m_s - at.slip.abs())
        }
        FrictionRange::Slides { .. } | FrictionRange::Any => range.room(law, at.slip),
    }
}

/// The range beyond the end that a contact is nearest to.
fn neighbour_of<const N: usize>(range: FrictionRange, law: &FrictionLaw, at: &Contact<N>, force: f64) -> FrictionRange {
    let Some(bristle) = &law.bristle else { return range.neighbour(law, at.slip) };
    match range {
        FrictionRange::Sticks => FrictionRange::Yields { forward: at.memory + at.slip > 0.0 },
        FrictionRange::Slides { forward } => FrictionRange::Yields { forward },
        FrictionRange::Yields { forward }
            if -room_below(law, bristle, at, force, forward) < law.v_dynamic_m_s - at.slip.abs() =>
        {
            FrictionRange::Sticks
        }
        FrictionRange::Yields { .. } => FrictionRange::Slides { forward: at.slip > 0.0 },
        FrictionRange::Any => FrictionRange::Any,
    }
}

/// Noise of a depth, m or rad: some last digits of the coordinates it is the difference of.
const DEPTH_NOISE: f64 = 2e-15;

/// How exactly events are landed on: forces in N (limit: N·m).
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// Part of δ_max.
    pub depth_share: f64,
    pub force: f64,
}

impl Landing {
    /// No finer than what a spring makes of the last digits of its depth.
    fn force(&self, law: &NormalLaw) -> f64 {
        self.force.max(spring_force(law, DEPTH_NOISE))
    }

    /// A released contact takes up again above this force, so that lift-off and reload do not answer each other.
    fn reload(&self, law: &NormalLaw) -> f64 {
        3.0 * self.force(law)
    }
}

/// Whether some derivative of the spring's force is infinite where surfaces part: no polynomial of a step follows it there.
pub fn is_kinked(law: &NormalLaw) -> bool {
    law.exponent.fract() != 0.0 && law.exponent < 3.0
}

/// Rates below which a contact creeps rather than rebounds, m/s (limit: rad/s).
const SLOWEST_REBOUND: f64 = 1e-2;

/// A contact that parts so slowly that its damper takes this part of its spring's force may let go within a step and be back at its
/// end: a long step holds by its polynomial what the law has let go.
const FADING: f64 = 0.5;

/// Part of a range's width by which a slip or depth may be beyond it before it counts as left, so that neighbours do not answer each
/// other…
const RANGE_MARGIN: f64 = 0.01;
/// …and part of that within which it is landed on.
const RANGE_LANDING: f64 = 0.3;

impl<const S: usize> Mode<S> {
    pub const FREE: Self =
        Self { sites: [SiteState::Free; S], slips: [FrictionRange::Any; S], dampers: [DamperRange::Any; S] };
    /// The laws left to themselves: what an integrator without events takes.
    pub const NATURAL: Self =
        Self { sites: [SiteState::Natural; S], slips: [FrictionRange::Any; S], dampers: [DamperRange::Any; S] };

    /// A fresh reading at a state whose contacts are `at`; `free` gives the accelerations in a mode. A site that just touches presses
    /// where its gap closes, or rests and would close without all that just touch.
    pub fn read<'a, const N: usize>(
        landing: &Landing,
        at: impl Fn(usize) -> Option<(Contact<N>, &'a NormalLaw, Option<&'a FrictionLaw>)>,
        free: impl FnOnce(&Self) -> [f64; N],
    ) -> Self {
        let mut mode = Self::FREE;
        let mut touching = [None; S];
        for (site, touch) in touching.iter_mut().enumerate() {
            let Some((contact, law, friction)) = at(site) else { continue };
            let Contact { delta, rate, row, .. } = contact;
            let pressed = Press::of(law, &contact).force();
            mode.dampers[site] = DamperRange::of(law, delta);
            mode.slips[site] = friction.map_or(FrictionRange::Any, |law| range_of(law, &contact, pressed));
            if delta.abs() <= landing.depth_share * law.transition_m {
                *touch = Some((row, rate));
            } else if delta > 0.0 {
                let force = unclamped_normal_force(law, delta, rate).force;
                mode[site] = if force >= 0.0 { SiteState::Active } else { SiteState::Released };
            }
        }
        let free = free(&mode);
        for (state, touch) in mode.sites.iter_mut().zip(touching) {
            let Some((row, rate)) = touch else { continue };
            let resting = rate.abs() < 1e-12;
            if rate >= 1e-12 || (resting && -along(&row, &free) > 0.0) {
                *state = SiteState::Active;
            }
        }
        mode
    }

    /// Whether the friction of a site is beyond the range in which it sticks: `None` where nothing presses, and where it is not looked at.
    pub fn slips_at(&self, site: usize) -> Option<bool> {
        match self.slips[site] {
            _ if !self.sites[site].presses() => None,
            FrictionRange::Any => None,
            range => Some(range != FrictionRange::Sticks),
        }
    }

    /// Whether a site has no branch that could end.
    #[inline(always)]
    pub fn is_left_alone(&self, site: usize) -> bool {
        self.sites[site] == SiteState::Natural && self.slips[site] == FrictionRange::Any
    }

    /// One guard, whose site is as `at` says, without its strain.
    #[inline(always)]
    pub fn guard<const N: usize>(
        &self,
        guard: usize,
        (law, friction): (&NormalLaw, Option<&FrictionLaw>),
        landing: &Landing,
        at: &Contact<N>,
    ) -> Guard<N> {
        let site = guard % S;
        match (guard / S, friction) {
            (0, _) => self.normal_guard(site, law, landing, at, &Press::of(law, at)),
            (1, Some(friction)) => {
                let press = if friction.bristle.is_some() { Press::of(law, at) } else { Press::default() };
                self.slip_guard(site, friction, at, &press)
            }
            (1, None) => Guard::QUIET,
            _ => self.damper_guard(site, law, at),
        }
    }

    /// Guard of the normal law of a site.
    #[inline(always)]
    pub fn normal_guard<const N: usize>(
        &self,
        site: usize,
        law: &NormalLaw,
        landing: &Landing,
        at: &Contact<N>,
        press: &Press,
    ) -> Guard<N> {
        let Contact { delta, rate, .. } = *at;
        let quiet = Guard::QUIET;
        let strain = || {
            let springy = press.spring > press.damper.abs();
            let rebounds = springy && rate.abs() > SLOWEST_REBOUND;
            if delta > 0.0 { Strain::Depth { row: at.row, depth: delta, rebounds, springy } } else { Strain::None }
        };
        match self.sites[site] {
            SiteState::Natural => quiet,
            SiteState::Free => Guard { value: -delta, rate: -rate, look: Look::Gap, ..quiet },
            // Just landed and about to enter.
            SiteState::Active if delta <= 0.0 && rate >= 0.0 => Guard { apart: false, ..quiet },
            // Without a damper the force ends where the surfaces part, and is small long before.
            SiteState::Active if !is_damped(law) => {
                let value = if delta > 0.0 { delta } else { delta.min(-1e-290) };
                Guard { value, rate, look: Look::Gap, apart: false, strain: strain() }
            }
            SiteState::Active => {
                // Gone through zero without ever pulling counts as let go too.
                let value = if delta > 0.0 { press.force() } else { delta.min(-1e-290) };
                let look = if value < FADING * press.spring { Look::Fading } else { Look::End };
                Guard { value, look, apart: false, strain: strain(), ..quiet }
            }
            // The force of a released contact may come and go within a step.
            SiteState::Released => {
                Guard { value: landing.reload(law) - press.force(), look: Look::Inside, apart: delta < 0.0, ..quiet }
            }
        }
    }

    /// Guard of the friction law of a site.
    #[inline(always)]
    pub fn slip_guard<const N: usize>(
        &self,
        site: usize,
        law: &FrictionLaw,
        at: &Contact<N>,
        press: &Press,
    ) -> Guard<N> {
        if !self.sites[site].presses() || self.slips[site] == FrictionRange::Any {
            return Guard::QUIET;
        }
        let value = room_of(self.slips[site], law, at, press.force()) + RANGE_MARGIN * law.finest_m_s();
        // Out of sticking a step may look and come back; out of sliding it must not miss that it would have stuck.
        let look = if self.slips[site] == FrictionRange::Sticks { Look::End } else { Look::Smooth };
        let strain = match self.slips[site] {
            FrictionRange::Sticks if law.bristle.is_some() => held(law, at, press),
            _ if law.bristle.is_some() => Strain::None,
            FrictionRange::Slides { .. } | FrictionRange::Any => Strain::None,
            _ => Strain::Slip { row: at.tangent, finest: law.finest_m_s(), normal: press.force().max(0.0) },
        };
        Guard { value, look, apart: false, strain, ..Guard::QUIET }
    }

    /// Guard of the damper of a site.
    #[inline(always)]
    pub fn damper_guard<const N: usize>(&self, site: usize, law: &NormalLaw, at: &Contact<N>) -> Guard<N> {
        let room = match self.dampers[site] {
            _ if self.sites[site] != SiteState::Active => return Guard::QUIET,
            DamperRange::Any => return Guard::QUIET,
            DamperRange::Engaging => [law.transition_m - at.delta, -at.rate],
            DamperRange::Engaged => [at.delta - law.transition_m, at.rate],
        };
        let value = room[0] + RANGE_MARGIN * law.transition_m;
        Guard { value, rate: room[1], look: Look::Gap, apart: false, ..Guard::QUIET }
    }

    /// How near to zero the guard of a site must be for its event: guards from S on are those of slips, from 2 S on of dampers.
    pub fn landing_tolerance(
        &self,
        site: usize,
        law: &NormalLaw,
        friction: Option<&FrictionLaw>,
        landing: &Landing,
    ) -> f64 {
        if site >= 2 * S {
            return RANGE_LANDING * RANGE_MARGIN * law.transition_m;
        }
        if site >= S {
            return friction.map_or(0.0, |law| RANGE_LANDING * RANGE_MARGIN * law.finest_m_s());
        }
        match self.sites[site] {
            SiteState::Active if is_damped(law) => landing.force(law),
            SiteState::Released | SiteState::Natural => landing.force(law),
            SiteState::Free | SiteState::Active => landing.depth_share * law.transition_m,
        }
    }

    /// The mode after the event of a guard, whose site is as `at` says.
    pub fn switched<const N: usize>(
        &self,
        guard: usize,
        law: &NormalLaw,
        friction: Option<&FrictionLaw>,
        at: &Contact<N>,
    ) -> Self {
        let (delta, force) = (at.delta, Press::of(law, at).force());
        let mut next = *self;
        if guard >= 2 * S {
            let damper = &mut next.dampers[guard - 2 * S];
            *damper = if *damper == DamperRange::Engaging { DamperRange::Engaged } else { DamperRange::Engaging };
            return next;
        }
        let range = friction.map_or(FrictionRange::Any, |law| range_of(law, at, force));
        if guard >= S {
            let site = guard - S;
            next.slips[site] = match self.slips[site] == range {
                // Landed on from inside.
                true => friction.map_or(range, |law| neighbour_of(range, law, at, force)),
                false => range,
            };
            return next;
        }
        next.sites[guard] = match self.sites[guard] {
            SiteState::Free | SiteState::Released => SiteState::Active,
            SiteState::Active => SiteState::Released,
            SiteState::Natural => SiteState::Natural,
        };
        next.slips[guard] = range;
        next.dampers[guard] = DamperRange::of(law, delta);
        next
    }

    /// The mode after a step where released surfaces have parted.
    pub fn relaxed<const N: usize, const G: usize>(&self, guards: &[Guard<N>; G]) -> Option<Self> {
        let mut next = *self;
        for (state, guard) in next.sites.iter_mut().zip(guards) {
            if *state == SiteState::Released && guard.apart {
                *state = SiteState::Free;
            }
        }
        (next != *self).then_some(next)
    }

    /// The mode with the law of a guard left to itself.
    pub fn with_natural(&self, guard: usize) -> Self {
        let mut next = *self;
        match guard / S {
            0 => next.sites[guard] = SiteState::Natural,
            1 => next.slips[guard - S] = FrictionRange::Any,
            _ => next.dampers[guard - 2 * S] = DamperRange::Any,
        }
        next
    }
}

/// What a contact that a bristle holds is sensitive to: slip and memory together, of which the cone leaves little.
fn held<const N: usize>(law: &FrictionLaw, at: &Contact<N>, press: &Press) -> Strain<N> {
    let most = law.mu_static * press.force().max(0.0);
    let finest = law.bristle.map_or(f64::INFINITY, |bristle| (most + CONE_FLOOR) / bristle.damping_n_s_per_m);
    Strain::Slip { row: at.tangent, finest, normal: 0.0 }
}

/// The rate along a row.
#[inline(always)]
pub fn along<const N: usize>(row: &[f64; N], rates: &[f64; N]) -> f64 {
    let mut sum = -0.0;
    for i in 0..N {
        sum += row[i] * rates[i];
    }
    sum
}
