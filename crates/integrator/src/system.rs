//! What an integrator needs to know of a system.

use super::Tolerances;
use crate::numeric::each;

/// Right-hand side: accelerations and rates of the quadratures.
#[derive(Clone, Copy, Debug)]
pub struct Rates<const N: usize, const Z: usize> {
    pub a: [f64; N],
    pub g: [f64; Z],
}

/// The right-hand side with its exact derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Linearised<const N: usize, const Z: usize> {
    pub rates: Rates<N, Z>,
    /// ∂a/∂q, ∂a/∂v, ∂a/∂t.
    pub a_q: [[f64; N]; N],
    pub a_v: [[f64; N]; N],
    pub a_t: [f64; N],
    /// ∂g/∂q, ∂g/∂v, ∂g/∂t.
    pub g_q: [[f64; N]; Z],
    pub g_v: [[f64; N]; Z],
    pub g_t: [f64; Z],
}

/// A smooth second-order system within one mode (one frozen set of branches).
pub trait System<const N: usize, const Z: usize> {
    type Mode: Copy + std::fmt::Debug;

    /// How many of the N coordinates there are: the others, behind them, rest at 0 and nothing depends on them.
    #[inline(always)]
    fn coordinates(&self) -> usize {
        N
    }

    fn rates(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &Self::Mode) -> Rates<N, Z>;

    fn linearise(&self, t: f64, q: &[f64; N], v: &[f64; N], mode: &Self::Mode) -> Linearised<N, Z>;
}

/// How the value of a guard may be followed within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Look {
    /// A gap, whose rate is known: half way, at the end, and where it is smallest if its rates at the ends allow a dip.
    #[default]
    Gap,
    /// Only at the end. A stiff damper's force may not be read off the dense output: between the ends of a step the
    /// interpolated rate is off the slow manifold, and the force is a huge multiple of it.
    End,
    /// A smooth value without a known rate, which may dip below zero and come back within the step: at points inside, and
    /// where it is smallest between them.
    Inside,
    /// The force of a contact that parts slowly: the same, in steps that lose most of its depth.
    Fading,
    /// The same of a value that a step follows closely, a rate: at more points only where it bends enough for a dip.
    Smooth,
}

/// A quantity that the law of a site is sensitive to, beyond what tolerances of coordinates and rates know of: `row` says how these
/// change it, `scale` how large it is.
#[derive(Clone, Copy, Debug)]
pub enum Strain<const N: usize> {
    None,
    /// Penetration of a contact that presses, along coordinates; how deep it is, and whether it `rebounds`: is on its way with a
    /// spring that is stronger than its damper, so that an error of its rate is there to stay.
    Depth {
        row: [f64; N],
        depth: f64,
        rebounds: bool,
        springy: bool,
    },
    /// Slip of a contact that presses, along rates; the finest scale of its friction law, and the normal force.
    Slip {
        row: [f64; N],
        finest: f64,
        normal: f64,
    },
}

/// Whether a site's branch still holds.
#[derive(Clone, Copy, Debug)]
pub struct Guard<const N: usize> {
    /// Not negative while the branch holds.
    pub value: f64,
    /// Rate of `value` where it is known (a gap); 0 otherwise. A dip between two steps shows as a change of its sign.
    pub rate: f64,
    pub look: Look,
    /// Whether the surfaces are apart, whatever the branch.
    pub apart: bool,
    /// What of the site a step may err by a part of only.
    pub strain: Strain<N>,
}

impl<const N: usize> Guard<N> {
    /// Of a site where nothing can happen.
    pub const QUIET: Self =
        Self { value: f64::INFINITY, rate: 0.0, look: Look::End, apart: true, strain: Strain::None };
}

/// All guards in one state, and how far the state is from where the equations break down.
#[derive(Clone, Copy, Debug)]
pub struct Watch<const N: usize, const S: usize> {
    pub guards: [Guard<N>; S],
    /// Not negative while the equations hold.
    pub clearance: f64,
    /// Rate of `clearance`.
    pub clearance_rate: f64,
}

/// A state in which contacts rest at the depth their springs hold.
///
/// A stiff, hardly damped contact that is loaded at once trembles about that depth: by 1e-12 rad at 1e9 rad/s, ten thousand times in a
/// closing and with no effect on it. An integrator that resolves it takes minutes.
#[derive(Clone, Copy, Debug)]
pub struct Settled<const N: usize> {
    pub q: [f64; N],
    pub v: [f64; N],
    /// Rate at which the slowest of these trembles would have died by itself, 1/s.
    pub decay: f64,
}

/// A system whose modes change at events.
pub trait Hybrid<const N: usize, const Z: usize, const S: usize>: System<N, Z> {
    /// Next time after `t` at which the right-hand side jumps by itself; infinite if none.
    fn next_corner(&self, t: f64) -> f64;

    /// A bound on the next step from this state, where the error estimate knows of none: what only quadratures feel.
    #[inline(always)]
    fn longest_step(&self, _t: f64, _q: &[f64; N], _v: &[f64; N], _mode: &Self::Mode) -> f64 {
        f64::INFINITY
    }

    fn watch(&self, q: &[f64; N], v: &[f64; N], mode: &Self::Mode) -> Watch<N, S>;

    /// One guard as [`Hybrid::watch`] has it, but for its strain: looks within a step, several in most, ask no more.
    #[inline(always)]
    fn glance(&self, q: &[f64; N], v: &[f64; N], mode: &Self::Mode, guard: usize) -> Guard<N> {
        self.watch(q, v, mode).guards[guard]
    }

    /// Values of the wanted guards, of others anything.
    #[inline(always)]
    fn values(&self, q: &[f64; N], v: &[f64; N], mode: &Self::Mode, _wanted: &[bool; S]) -> [f64; S] {
        let guards = self.watch(q, v, mode).guards;
        each(|guard| guards[guard].value)
    }

    /// How near to zero a guard must be for its event to be taken.
    fn landing_tolerance(&self, site: usize, mode: &Self::Mode) -> f64;

    /// The mode after the event at `site`, in the state it was landed on in.
    fn switch(&self, site: usize, q: &[f64; N], v: &[f64; N], mode: &Self::Mode) -> Self::Mode;

    /// Whether an event at `site` is one of the system: told to observers, counted, and a start for the method. Others only
    /// keep steps from leaping over a part of a law.
    fn is_told(&self, _site: usize) -> bool {
        true
    }

    /// The mode after a step whose end has these guards, where it changes without any jump (a released contact that has
    /// left its partner).
    fn relax(&self, guards: &[Guard<N>; S], mode: &Self::Mode) -> Option<Self::Mode>;

    /// The mode with the branches of `site` left to the law itself: no event there.
    fn with_natural(&self, site: usize, mode: &Self::Mode) -> Self::Mode;

    /// A fresh reading of the mode at a state, for a start or after a step on natural branches.
    fn read_mode(&self, t: f64, q: &[f64; N], v: &[f64; N]) -> Self::Mode;

    /// First step after the event at `site`, if the event changes the time scale.
    fn restart_step(&self, site: usize, q: &[f64; N], v: &[f64; N], mode: &Self::Mode) -> Option<f64>;

    /// The state with hard contacts at rest where they only tremble: `None` where none does. See [`Settled`].
    fn settle(
        &self,
        _t: f64,
        _state: (&[f64; N], &[f64; N]),
        _mode: &Self::Mode,
        _tolerances: &Tolerances,
    ) -> Option<Settled<N>> {
        None
    }

    /// Says in words what a state without clearance has run into.
    fn obstacle(&self, q: &[f64; N]) -> String;
}
