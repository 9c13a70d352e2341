//! The interface by which models use any friction law.
//!
//! A law is an arm of [`FrictionKind`] with a file of its own: its force, the rate of its internal state, the ranges of slip
//! within which it is smooth, and an implicit step. Models call the methods of [`FrictionLaw`] only.

use super::{
    Bristle, FrictionKind, FrictionLaw, FrictionPoint, FrictionRange, FrictionStep, RANGE_OVERLAP, SlipWeight, bristle,
    regularised,
};
use crate::numeric::Real;

impl From<Option<Bristle>> for FrictionKind {
    /// Friction with stiction by this bristle; the regularised law without one.
    fn from(bristle: Option<Bristle>) -> Self {
        bristle.map_or(FrictionKind::Regularised, FrictionKind::Bristle)
    }
}

impl FrictionKind {
    /// Number of internal states: 0 or 1. Models integrate them together with the velocities.
    #[inline(always)]
    pub fn states(&self) -> usize {
        match self {
            FrictionKind::Regularised => 0,
            FrictionKind::Bristle(_) => 1,
        }
    }

    /// Returns the rate of the internal state of a contact without a force.
    #[inline(always)]
    pub fn relaxation<T: Real>(&self, state: T) -> T {
        match self {
            FrictionKind::Regularised => T::zero(),
            FrictionKind::Bristle(bristle) => bristle.relaxation(state),
        }
    }

    /// Returns the internal state after `time_s` without a force.
    pub fn relaxed(&self, state: f64, time_s: f64) -> f64 {
        match self {
            FrictionKind::Regularised => state,
            FrictionKind::Bristle(bristle) => bristle.relaxed(state, time_s),
        }
    }

    /// Energy of an internal state, J.
    pub fn energy(&self, state: f64) -> f64 {
        match self {
            FrictionKind::Regularised => 0.0,
            FrictionKind::Bristle(bristle) => bristle.energy(state),
        }
    }
}

impl FrictionLaw {
    /// Whether the law has an internal state; it then holds without creep, and its slip events are reported.
    #[inline(always)]
    pub fn has_state(&self) -> bool {
        self.kind.states() > 0
    }

    /// Width of the narrowest slip range of the law, in m/s.
    #[inline(always)]
    pub fn min_slip_scale_m_s(&self) -> f64 {
        self.v_static_m_s.min(self.v_dynamic_m_s - self.v_static_m_s)
    }

    /// Friction force on the sliding surface, along the tangent, N. `state` is `None` for a law without a state. In a
    /// monitored range, the branch of this range gives the force, also beyond the end of the range.
    #[inline(always)]
    pub fn force<T: Real>(&self, slip: T, state: Option<T>, normal: T, range: FrictionRange) -> T {
        match (&self.kind, state) {
            (FrictionKind::Bristle(bristle), Some(state)) => {
                bristle::force_in_range(self, bristle, [slip, state, normal], range)
            }
            (FrictionKind::Bristle(_), None) | (FrictionKind::Regularised, _) => {
                regularised::friction_force(self, slip, normal)
            }
        }
    }

    /// Rate of the internal state due to a friction force, N. It is added to the
    /// [relaxation](FrictionKind::relaxation).
    #[inline(always)]
    pub fn state_rate<T: Real>(&self, friction: T) -> T {
        match &self.kind {
            FrictionKind::Regularised => T::zero(),
            FrictionKind::Bristle(bristle) => -friction * bristle.stretch_gain(),
        }
    }

    /// Returns the range of the law that contains a point.
    #[inline(always)]
    pub fn range(&self, at: FrictionPoint) -> FrictionRange {
        match &self.kind {
            FrictionKind::Regularised => regularised::range(self, at.slip),
            FrictionKind::Bristle(bristle) => bristle::range(self, bristle, at),
        }
    }

    /// Distance of a point from the end of a range including its overlap, as a slip in m/s; negative beyond this end.
    #[inline(always)]
    pub fn range_margin(&self, range: FrictionRange, at: FrictionPoint) -> f64 {
        match &self.kind {
            FrictionKind::Bristle(bristle) => bristle::range_margin(self, bristle, range, at),
            FrictionKind::Regularised => regularised::margin(self, range, at.slip) + self.overlap_m_s(range),
        }
    }

    /// Distance of a point from the nominal end of a range, as a slip in m/s; negative beyond this end.
    pub fn nominal_margin(&self, range: FrictionRange, at: FrictionPoint) -> f64 {
        match &self.kind {
            FrictionKind::Regularised => regularised::margin(self, range, at.slip),
            FrictionKind::Bristle(_) => self.range_margin(range, at) - self.overlap_m_s(range),
        }
    }

    /// Distance by which a range extends beyond its nominal end, as a multiple of [`FrictionLaw::min_slip_scale_m_s`].
    #[inline(always)]
    pub fn range_overlap(&self, range: FrictionRange) -> f64 {
        match (&self.kind, range) {
            (FrictionKind::Bristle(_), FrictionRange::Sticking | FrictionRange::Transition { .. }) => {
                bristle::CONE_OVERLAP
            }
            _ => RANGE_OVERLAP,
        }
    }

    /// The same distance, m/s.
    #[inline(always)]
    fn overlap_m_s(&self, range: FrictionRange) -> f64 {
        self.range_overlap(range) * self.min_slip_scale_m_s()
    }

    /// Returns the range beyond the end that is nearest to a point.
    pub fn neighbour_range(&self, range: FrictionRange, at: FrictionPoint) -> FrictionRange {
        match &self.kind {
            FrictionKind::Regularised => regularised::neighbour(self, range, at.slip),
            FrictionKind::Bristle(bristle) => bristle::neighbour_range(self, bristle, range, at),
        }
    }

    /// Whether a step may leave this range and return to it. This holds for the regularised sticking range, whose
    /// branch continues smoothly beyond its ends.
    #[inline(always)]
    pub fn may_return_to(&self, range: FrictionRange) -> bool {
        range == FrictionRange::Sticking && !self.has_state()
    }

    /// Error weight of the slip in a range, under a normal force in N. For a law with a state, it is the weight of the
    /// sum of slip and state. `None` if the friction force hardly depends on the slip.
    #[inline(always)]
    pub fn slip_weight(&self, range: FrictionRange, normal: f64) -> Option<SlipWeight> {
        match (&self.kind, range) {
            (FrictionKind::Bristle(bristle), FrictionRange::Sticking) => Some(SlipWeight {
                slip_scale: bristle::slip_scale(bristle, self.mu_static * normal.max(0.0)),
                normal_force: 0.0,
            }),
            (FrictionKind::Bristle(_), _) | (_, FrictionRange::Sliding { .. } | FrictionRange::Any) => None,
            (FrictionKind::Regularised, _) => {
                Some(SlipWeight { slip_scale: self.min_slip_scale_m_s(), normal_force: normal.max(0.0) })
            }
        }
    }

    /// Bounds of the ratio of friction force to normal force for slips between two values, m/s.
    pub fn ratio_bounds(&self, slips: [f64; 2]) -> [f64; 2] {
        match &self.kind {
            FrictionKind::Regularised => regularised::ratio_bounds(self, slips),
            FrictionKind::Bristle(_) => bristle::ratio_bounds(self, slips),
        }
    }

    /// Friction at the end of an implicit Euler step of length `h`, s. `at` contains the slip and the normal force at
    /// the end of the step, and the state at its start. With `one_way`, only negative slip is resisted.
    #[inline(always)]
    pub fn implicit_step(&self, at: FrictionPoint, h: f64, one_way: bool) -> FrictionStep {
        match &self.kind {
            FrictionKind::Regularised => regularised::implicit_step(self, at, one_way),
            FrictionKind::Bristle(bristle) => bristle::implicit_step(self, bristle, at, h, one_way),
        }
    }

    /// Force of an internal state at zero slip, N.
    pub fn state_force(&self, state: f64) -> f64 {
        match &self.kind {
            FrictionKind::Regularised => 0.0,
            FrictionKind::Bristle(bristle) => bristle.damping_n_s_per_m * state.abs(),
        }
    }

    /// Slip rate at which sticking friction has this force, N, if the internal state is 0; infinite for a law that
    /// cannot stick.
    pub fn sticking_slip(&self, force: f64) -> f64 {
        match &self.kind {
            FrictionKind::Regularised => f64::INFINITY,
            FrictionKind::Bristle(bristle) => force / bristle.damping_n_s_per_m,
        }
    }
}
