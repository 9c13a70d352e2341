//! Bounds of the motion of bodies over a part of a step, from bounds of their coordinates: how far and how fast bodies can
//! move at most, without evaluating them. All bounds are per step and per step².

use crate::fivebar::kinematics::SINGULAR_SINE;
use crate::integrator::{CoordinateBounds, GapBound, Layout};

/// Bounds of the motion of a body: of the origin of its frame, and of its angle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotionBound {
    pub speed: f64,
    pub acceleration: f64,
    pub spin: f64,
    pub spin_acceleration: f64,
}

/// Bounds of the rate of a point or a coordinate, and of its acceleration.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RateBound {
    pub rate: f64,
    pub acceleration: f64,
}

/// Product of two bounds: zero if one of them is, even if the other one is not known.
#[inline(always)]
fn product(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl RateBound {
    /// Bound that excludes nothing.
    pub const NONE: Self = Self { rate: f64::INFINITY, acceleration: f64::INFINITY };

    /// Bound of a coordinate.
    pub fn of_coordinate<L: Layout>(bounds: &CoordinateBounds<L>, index: usize) -> Self {
        Self { rate: bounds.rate[index], acceleration: bounds.acceleration[index] }
    }

    /// Returns the bound over a part of a step. `rate` is the rate per step at one end of the part; `width` is its
    /// length.
    #[inline(always)]
    pub fn with_known_rate(self, rate: f64, width: f64) -> Self {
        Self { rate: self.rate.min(rate + self.acceleration * width), ..self }
    }

    pub fn plus(self, other: Self) -> Self {
        Self { rate: self.rate + other.rate, acceleration: self.acceleration + other.acceleration }
    }

    pub fn times(self, factor: f64) -> Self {
        Self { rate: product(self.rate, factor.abs()), acceleration: product(self.acceleration, factor.abs()) }
    }

    /// Bound of a gap whose rate is the rate of this coordinate.
    pub fn gap(self) -> GapBound {
        GapBound { rate: self.rate, curvature: self.acceleration }
    }
}

impl MotionBound {
    /// Bound that excludes nothing.
    pub const NONE: Self = Self {
        speed: f64::INFINITY,
        acceleration: f64::INFINITY,
        spin: f64::INFINITY,
        spin_acceleration: f64::INFINITY,
    };

    /// Returns the bound of a body from those of its origin and its angle.
    pub fn new(origin: RateBound, turn: RateBound) -> Self {
        Self {
            speed: origin.rate,
            acceleration: origin.acceleration,
            spin: turn.rate,
            spin_acceleration: turn.acceleration,
        }
    }

    /// Returns the bound over a part of a step; the rates per second of the body's pose at one end of the part are
    /// known. Unlike bounds from the lengths of links alone, these bounds do not grow along a chain of bodies.
    #[inline(always)]
    pub fn with_known_rates(self, [x, y, turn]: [f64; 3], (step_s, width): (f64, f64)) -> Self {
        let speed = RateBound { rate: self.speed, acceleration: self.acceleration };
        Self::new(
            speed.with_known_rate((x * x + y * y).sqrt() * step_s, width),
            self.turn().with_known_rate(turn.abs() * step_s, width),
        )
    }

    pub fn turn(&self) -> RateBound {
        RateBound { rate: self.spin, acceleration: self.spin_acceleration }
    }

    /// Bound of a point at the distance `arm` from the origin of the body.
    #[inline(always)]
    pub fn point(&self, arm: f64) -> RateBound {
        RateBound {
            rate: self.speed + product(self.spin, arm),
            acceleration: self.acceleration + product(self.spin_acceleration + self.spin * self.spin, arm),
        }
    }

    /// Bound of a body that rotates about a pivot; `arm` is the distance of its origin from the pivot.
    #[inline(always)]
    pub fn about_pivot(pivot: RateBound, turn: RateBound, arm: f64) -> Self {
        let origin = Self::new(pivot, turn).point(arm);
        Self::new(origin, turn)
    }

    /// Bound of another body that slides along an axis of this body without rotating relative to it. `slide` bounds the
    /// coordinate, and `arm` bounds the distance between the origins of the two bodies.
    pub fn sliding(&self, slide: RateBound, arm: f64) -> Self {
        let carried = self.point(arm);
        let coriolis = 2.0 * product(self.spin, slide.rate);
        let origin = carried.plus(RateBound { rate: slide.rate, acceleration: slide.acceleration + coriolis });
        Self::new(origin, self.turn())
    }

    /// Bound of a point of another body, as seen in the frame of this body. `point` is the bound of the point in the
    /// world; `distance` bounds its distance from the origin of this body.
    #[inline(always)]
    pub fn seen(&self, point: RateBound, distance: f64) -> RateBound {
        let base = self.point(distance);
        let rate = point.rate + base.rate;
        RateBound { rate, acceleration: point.acceleration + base.acceleration + 2.0 * product(self.spin, rate) }
    }
}

/// Two bodies that turn about moving pivots and are pinned together, at the distances `arms` from them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PinnedPair {
    /// Bound of the vector between the two pivots.
    pub between: RateBound,
    pub arms: [f64; 2],
}

impl PinnedPair {
    /// K in |dγ/dΘ| ≤ K/sin γ, where γ is the angle between the two arms.
    pub fn angle_change(&self) -> f64 {
        self.between.rate * (1.0 / self.arms[0] + 1.0 / self.arms[1])
    }

    /// Bounds of the angles of the two bodies while the sine of the angle between the arms is at least `sine`.
    ///
    /// With the arms d and the velocities r of the pivots, ω₁ d₁⊥ − ω₂ d₂⊥ = r₂ − r₁, so that ω₁ = (r₂ − r₁)·d₂/(d₁ ×
    /// d₂).
    pub fn turns(&self, sine: f64) -> [RateBound; 2] {
        let rates = self.arms.map(|arm| self.between.rate / (arm * sine));
        let centripetal: f64 = (0..2).map(|k| self.arms[k] * rates[k] * rates[k]).sum();
        let acceleration = |arm: f64| (self.between.acceleration + centripetal) / (arm * sine);
        [0, 1].map(|k| RateBound { rate: rates[k], acceleration: acceleration(self.arms[k]) })
    }
}

/// Lower bound of the sine of an angle γ over a part of a step of this width; at one end it is `sine`. d(sin² γ)/dΘ is
/// at least −2 K if |dγ/dΘ| ≤ K/sin γ. Not a number if it may vanish.
pub(crate) fn smallest_sine(sine: f64, angle_change: f64, width: f64) -> f64 {
    (sine * sine - 2.0 * angle_change * width).sqrt()
}

/// The reach of a clearance without a bound of its rate: 0, or the clearance itself if it is negative or not a number.
pub(crate) fn nothing_known(clearance: f64) -> f64 {
    if clearance >= 0.0 { 0.0 } else { clearance }
}

/// Part of the step in which the sine stays above that of a singular configuration; 0 if no bound is known.
pub(crate) fn sine_reach(sine: f64, angle_change: f64) -> f64 {
    let squared = sine * sine - SINGULAR_SINE * SINGULAR_SINE;
    match angle_change > 0.0 {
        true if angle_change.is_finite() => squared / (2.0 * angle_change),
        false if angle_change == 0.0 => squared * f64::INFINITY,
        _ => nothing_known(squared),
    }
}
