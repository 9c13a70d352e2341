//! Interface between the integrator and a hybrid system.

use std::fmt::Debug;

use super::layout::{Layout, Matrix, VectorOf};
use super::{CoordinateBounds, Tolerances};

/// Values of the right-hand side: accelerations, and rates of the quadratures.
#[derive(Clone, Debug)]
pub struct Rates<L: Layout> {
    pub a: VectorOf<L>,
    pub g: L::Quadratures,
}

impl<L: Layout> Rates<L> {
    pub fn zero(layout: L) -> Self {
        Self { a: layout.vector(0.0), g: layout.zero_quadratures() }
    }
}

/// The right-hand side with its exact derivatives.
#[derive(Clone, Debug)]
pub struct Linearised<L: Layout> {
    pub rates: Rates<L>,
    /// ∂a/∂q.
    pub a_q: L::Square<f64>,
    /// ∂a/∂v.
    pub a_v: L::Square<f64>,
    /// ∂a/∂t.
    pub a_t: VectorOf<L>,
    /// ∂g/∂q.
    pub g_q: L::QuadratureRows,
    /// ∂g/∂v.
    pub g_v: L::QuadratureRows,
    /// ∂g/∂t.
    pub g_t: L::Quadratures,
}

impl<L: Layout> Linearised<L> {
    pub fn zero(layout: L) -> Self {
        Self {
            rates: Rates::zero(layout),
            a_q: layout.square(0.0),
            a_v: layout.square(0.0),
            a_t: layout.vector(0.0),
            g_q: layout.zero_quadrature_rows(),
            g_v: layout.zero_quadrature_rows(),
            g_t: layout.zero_quadratures(),
        }
    }

    /// Sets all numbers to 0.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.rates.a.as_mut().fill(0.0);
        self.rates.g.as_mut().fill(0.0);
        self.a_q.fill(0.0);
        self.a_v.fill(0.0);
        self.a_t.as_mut().fill(0.0);
        self.g_q.fill(0.0);
        self.g_v.fill(0.0);
        self.g_t.as_mut().fill(0.0);
    }
}

/// A smooth second-order system within one mode (one frozen set of branches).
pub trait System {
    type Layout: Layout;
    type Mode: Clone + Debug;

    fn layout(&self) -> Self::Layout;

    /// Number of coordinates with equations of second order; they come first. The remaining rates are first-order
    /// states, such as those of bristles. The rate of a first-order state depends only on the preceding coordinates and
    /// rates, and on the state itself. Nothing depends on the coordinates at the indices of first-order states; they
    /// stay at 0.
    #[inline(always)]
    fn second_order_count(&self) -> usize {
        self.layout().coordinates()
    }

    /// Number of coordinates in use. The others stay at 0 and have no effect.
    #[inline(always)]
    fn coordinate_count(&self) -> usize {
        self.layout().coordinates()
    }

    /// Writes the right-hand side.
    fn rates(
        &self,
        t: f64,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
        rates: &mut Rates<Self::Layout>,
    );

    /// Writes the right-hand side and its derivatives. `linearised` is [`Linearised::zero`] or the result of an earlier call.
    fn linearise(
        &self,
        t: f64,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
        linearised: &mut Linearised<Self::Layout>,
    );
}

/// How the zero crossings of an event function are searched within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RootSearch {
    /// A value with a known rate. It is checked at the midpoint, at the end, and, if its rates at the ends allow a dip,
    /// at its minimum.
    #[default]
    Gap,
    /// A gap with a known rate and with bounds of its derivatives ([`Hybrid::gap_bounds`]). No zero within the step is
    /// missed.
    Bounded,
    /// A value that is checked only at the end, such as the force of a stiff damper. Inside a step, the interpolated
    /// rate is off the slow manifold, and the force is a large multiple of it.
    EndOnly,
    /// A value that a step resolves well, such as a rate. If its curvature allows a dip, it is sampled inside the step,
    /// and at the minimum between samples.
    Smooth,
    /// The force of a slowly separating contact. It is searched like `Smooth`, but only in steps that lose most of the
    /// contact's depth.
    FadingForce,
    /// Like `Smooth`, and always sampled in a step in which the surfaces separate.
    Interior,
}

/// Quantity of a contact with an error weight: its force law is more sensitive to it than the tolerances of coordinates
/// and rates reflect.
#[derive(Clone, Copy, Debug)]
pub enum WeightedQuantity {
    /// Penetration of an active contact; the row is over the coordinates. `is_spring_dominated`: the spring is stronger
    /// than the damper. `is_rebounding`: the contact is also moving, so that an error of its rate persists.
    Depth { depth: f64, is_rebounding: bool, is_spring_dominated: bool },
    /// Slip of an active contact; the row is over the rates. It has the smallest slip scale of the friction law, and
    /// the normal force.
    Slip { slip_scale: f64, normal_force: f64 },
}

/// Error weight of the contact of an event function.
#[derive(Clone, Debug)]
pub struct ErrorWeight<L: Layout> {
    /// Index of the event function.
    pub index: usize,
    pub quantity: WeightedQuantity,
    /// Derivative of the quantity with respect to the coordinates (depth) or rates (slip).
    pub row: VectorOf<L>,
}

/// An event function with its root-search policy. The current branch of a law is valid while the value is not negative.
#[derive(Clone, Copy, Debug)]
pub struct EventFunction {
    /// Not negative while the branch is valid.
    pub value: f64,
    /// Rate of `value`, if it is known (for a gap); otherwise 0. A sign change of the rate reveals a dip within a step.
    pub rate: f64,
    pub root_search: RootSearch,
    /// Whether the surfaces are separated, independent of the branch.
    pub is_separated: bool,
}

impl EventFunction {
    /// Event function that never triggers.
    pub const INACTIVE: Self =
        Self { value: f64::INFINITY, rate: 0.0, root_search: RootSearch::EndOnly, is_separated: true };
}

/// Values of all event functions in one state, and the clearance from the next singularity of the equations.
#[derive(Clone, Debug)]
pub struct EventSet<L: Layout> {
    pub functions: Vec<EventFunction>,
    /// Memory of error weights; the first `weight_count` are in use, in ascending order of their event functions.
    weights: Vec<ErrorWeight<L>>,
    weight_count: usize,
    /// Not negative while the equations are valid.
    pub clearance: f64,
    pub clearance_rate: f64,
}

impl<L: Layout> EventSet<L> {
    /// Creates a set of `count` functions that never trigger, with an infinite clearance.
    pub fn new(layout: L, count: usize) -> Self {
        Self {
            functions: vec![EventFunction::INACTIVE; count],
            weights: (0..count)
                .map(|index| ErrorWeight {
                    index,
                    quantity: WeightedQuantity::Slip { slip_scale: 0.0, normal_force: 0.0 },
                    row: layout.vector(0.0),
                })
                .collect(),
            weight_count: 0,
            clearance: f64::INFINITY,
            clearance_rate: 0.0,
        }
    }

    /// Sets all functions to [`EventFunction::INACTIVE`], removes all weights, and sets an infinite clearance.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.functions.fill(EventFunction::INACTIVE);
        self.weight_count = 0;
        (self.clearance, self.clearance_rate) = (f64::INFINITY, 0.0);
    }

    /// Adds an error weight for the event function `index`, and returns the row of the weight for the caller to fill.
    /// Each function has at most one weight. Weights may be added in any order.
    #[inline(always)]
    pub fn add_weight(&mut self, index: usize, quantity: WeightedQuantity) -> &mut VectorOf<L> {
        let count = self.weight_count;
        (self.weights[count].index, self.weights[count].quantity) = (index, quantity);
        let place =
            self.weights[..count].iter().rposition(|before| before.index < index).map_or(0, |before| before + 1);
        self.weight_count += 1;
        self.weights[place..=count].rotate_right(1);
        &mut self.weights[place].row
    }

    /// Error weights of contacts that enter the step error, in ascending order of their event functions.
    #[inline(always)]
    pub fn weights(&self) -> &[ErrorWeight<L>] {
        &self.weights[..self.weight_count]
    }

    /// Weighted quantity of an event function; `None` if the function has no weight.
    #[inline(always)]
    pub fn weight(&self, index: usize) -> Option<&WeightedQuantity> {
        self.weights().iter().find(|weight| weight.index == index).map(|weight| &weight.quantity)
    }
}

/// Bounds of the derivatives of a gap over a part of a step.
#[derive(Clone, Copy, Debug)]
pub struct GapBound {
    /// V: upper bound of the magnitude of the rate.
    pub rate: f64,
    /// A: at a distance τ from any point, the gap is at least its tangent there minus A τ²/2. The distance of convex
    /// bodies has such a bound, although its rate jumps where the nearest points pass a corner.
    pub curvature: f64,
}

/// Bounds of all gaps over a part of a step, and the distance of a state from the next singularity.
#[derive(Clone, Debug)]
pub struct GapBounds {
    /// Bounds, by the index of the event function. Bounds of functions that are not gaps are not read.
    pub gaps: Vec<GapBound>,
    /// Part of the step, forwards and backwards from the state, in which the clearance stays positive. It is 0 if the
    /// part is unknown, and NaN or negative if the clearance of the state itself is not positive.
    pub clearance_reach: f64,
}

impl GapBound {
    /// Bound that excludes nothing.
    pub const NONE: Self = Self { rate: f64::INFINITY, curvature: f64::INFINITY };

    /// Fraction of the step, on either side of a point, over which a gap is not negative; `gap` and `rate` are its
    /// value and rate at the point.
    #[inline(always)]
    pub fn reach(&self, gap: f64, rate: f64) -> f64 {
        if gap.is_nan() || gap < 0.0 {
            return 0.0;
        }
        // A rate that is not a number is no bound.
        let by_rate = match self.rate {
            rate if rate > 0.0 => gap / rate,
            0.0 => f64::INFINITY,
            _ => 0.0,
        };
        let a = self.curvature;
        let by_curvature = if !a.is_finite() {
            0.0
        } else if rate < 0.0 {
            2.0 * gap / ((rate * rate + 2.0 * a * gap).sqrt() - rate)
        } else if a > 0.0 {
            (rate + (rate * rate + 2.0 * a * gap).sqrt()) / a
        } else {
            f64::INFINITY
        };
        by_rate.max(by_curvature)
    }
}

impl GapBounds {
    /// Creates the bounds of `count` event functions. They exclude no part of the step from the search, and the clearance
    /// counts as positive over the whole step.
    pub fn new(count: usize) -> Self {
        Self { gaps: vec![GapBound::NONE; count], clearance_reach: f64::INFINITY }
    }
}

/// A quasi-static state, in which contacts rest at the equilibrium depth of their springs.
///
/// A stiff, weakly damped contact that is loaded suddenly oscillates about that depth: by 1e-12 rad at 1e9 rad/s, ten
/// thousand times in a closing motion and without effect on the motion. Resolving these oscillations takes minutes.
#[derive(Clone, Debug)]
pub struct QuasiStaticState<L: Layout> {
    pub q: VectorOf<L>,
    pub v: VectorOf<L>,
    /// Decay rate of the slowest of these oscillations, 1/s.
    pub decay_rate: f64,
}

/// A system whose modes change at events.
pub trait Hybrid: System {
    /// Number of event functions.
    fn event_count(&self) -> usize;

    /// Next time after `t` at which the right-hand side is discontinuous in time; infinite if there is none.
    fn next_discontinuity(&self, t: f64) -> f64;

    /// Upper bound of the next step from this state. It covers effects that the error estimate does not detect, because
    /// only quadratures depend on them.
    #[inline(always)]
    fn max_step(&self, _t: f64, _q: &VectorOf<Self::Layout>, _v: &VectorOf<Self::Layout>, _mode: &Self::Mode) -> f64 {
        f64::INFINITY
    }

    /// Evaluates all event functions, in place: `events` contains [`Hybrid::event_count`] functions.
    fn eval_events(
        &self,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
        events: &mut EventSet<Self::Layout>,
    );

    /// Distance from the next singularity of the equations, as [`EventSet::clearance`].
    fn clearance(&self, q: &VectorOf<Self::Layout>, v: &VectorOf<Self::Layout>, mode: &Self::Mode) -> f64;

    /// Evaluates one event function. Root searches within a step use this.
    fn eval_event(
        &self,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
        index: usize,
    ) -> EventFunction;

    /// Evaluates the selected event functions; the other values are unspecified.
    #[inline(always)]
    fn event_values(
        &self,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
        selected: &[bool],
        values: &mut [f64],
    ) {
        for index in (0..selected.len()).filter(|index| selected[*index]) {
            values[index] = self.eval_event(q, v, mode, index).value;
        }
    }

    /// Bounds of the gaps with the policy [`RootSearch::Bounded`], and of the clearance, over a part of a step. `motion`
    /// bounds the coordinates over the part; `q` and `v` are the state at one of its ends, with this `clearance`. The bounds
    /// of other event functions are not read. `bounds` has [`Hybrid::event_count`] gaps.
    fn gap_bounds(
        &self,
        _motion: &CoordinateBounds<Self::Layout>,
        _state: (&VectorOf<Self::Layout>, &VectorOf<Self::Layout>),
        _clearance: f64,
        bounds: &mut GapBounds,
    ) {
        bounds.gaps.fill(GapBound::NONE);
        bounds.clearance_reach = f64::INFINITY;
    }

    /// Magnitude of the event function below which an event counts as located.
    fn event_tolerance(&self, index: usize, mode: &Self::Mode) -> f64;

    /// Changes the mode by event `index`, in the state at which the event was located.
    fn pass_event(&self, index: usize, q: &VectorOf<Self::Layout>, v: &VectorOf<Self::Layout>, mode: &mut Self::Mode);

    /// Whether event `index` is reported to observers, counted, and restarts the method. Other events only prevent
    /// steps from skipping a segment of a law.
    fn is_reported(&self, _index: usize) -> bool {
        true
    }

    /// Changes the mode at the end of a step if the change causes no discontinuity, such as when the surfaces of a
    /// released contact have separated. `functions` are the event functions at the end of the step. Returns whether the
    /// mode has changed.
    fn pass_step(&self, functions: &[EventFunction], mode: &mut Self::Mode) -> bool;

    /// Whether the mode at the start of a step is valid in the state at its end, a time `dt` later. A mode that counts whole
    /// turns from an angle is not valid if the step may turn too far; the step is then repeated with half of its length.
    #[inline(always)]
    fn is_mode_valid(
        &self,
        _dt: f64,
        _q: &VectorOf<Self::Layout>,
        _v: &VectorOf<Self::Layout>,
        _mode: &Self::Mode,
    ) -> bool {
        true
    }

    /// Changes the mode for the steps after a state, without an event and without a change of any law: whole turns are
    /// counted from another angle.
    #[inline(always)]
    fn count_turns(&self, _q: &VectorOf<Self::Layout>, _v: &VectorOf<Self::Layout>, _mode: &mut Self::Mode) {}

    /// Changes the mode so that contact `index` uses its clamped law, without events.
    fn clamp_law(&self, index: usize, mode: &mut Self::Mode);

    /// Returns the mode derived from a state alone, at the start of a run.
    fn mode_at(&self, t: f64, q: &VectorOf<Self::Layout>, v: &VectorOf<Self::Layout>) -> Self::Mode;

    /// Returns the mode derived from a state after a step with a clamped law. Only what a state does not contain is
    /// taken from the previous mode `last`.
    #[inline(always)]
    fn mode_after(
        &self,
        t: f64,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        _last: &Self::Mode,
    ) -> Self::Mode {
        self.mode_at(t, q, v)
    }

    /// Changes the mode at the time of a discontinuity.
    #[inline(always)]
    fn pass_discontinuity(
        &self,
        _t: f64,
        _q: &VectorOf<Self::Layout>,
        _v: &VectorOf<Self::Layout>,
        _mode: &mut Self::Mode,
    ) {
    }

    /// First step after event `index`, if the event changes the time scale.
    fn restart_step(
        &self,
        index: usize,
        q: &VectorOf<Self::Layout>,
        v: &VectorOf<Self::Layout>,
        mode: &Self::Mode,
    ) -> Option<f64>;

    /// Projects oscillating stiff contacts onto their equilibrium depth; `None` if there are none. See
    /// [`QuasiStaticState`].
    fn project_quasi_static(
        &self,
        _t: f64,
        _state: (&VectorOf<Self::Layout>, &VectorOf<Self::Layout>),
        _mode: &Self::Mode,
        _tolerances: &Tolerances,
    ) -> Option<QuasiStaticState<Self::Layout>> {
        None
    }

    /// Describes the singularity that a state without clearance has reached.
    fn describe_obstacle(&self, q: &VectorOf<Self::Layout>) -> String;
}
