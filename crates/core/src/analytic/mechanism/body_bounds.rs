//! Bounds of bodies, joints and coordinates over a part of a step.

use crate::analytic::motion_bound::{MotionBound, RateBound};
use crate::mechanism::Mechanism;
use crate::numeric::plane::{Vector, dot};

/// Bounds of all bodies and joints of a mechanism.
#[derive(Clone, Debug)]
pub(super) struct MechanismBounds {
    /// Bodies of the mechanism, then the ground.
    pub bodies: Vec<MotionBound>,
    pub joints: Vec<RateBound>,
    /// Part of the step over which all dyads and cables stay regular.
    pub clearance_reach: f64,
}

pub(super) fn length(vector: Vector<f64>) -> f64 {
    dot(vector, vector).sqrt()
}

impl MechanismBounds {
    pub fn new(mechanism: &Mechanism) -> Self {
        Self {
            bodies: vec![MotionBound::default(); mechanism.bodies.len() + 1],
            joints: vec![RateBound::default(); mechanism.joints.len()],
            clearance_reach: f64::INFINITY,
        }
    }

    pub fn body(&self, body: Option<usize>) -> &MotionBound {
        &self.bodies[body.unwrap_or(self.bodies.len() - 1)]
    }
}

/// Bounds of coordinates over a part of a step, by their index in a group, with the width of the part.
pub(super) struct Coordinates<'a> {
    pub rate: &'a [f64],
    pub acceleration: &'a [f64],
    pub width: f64,
}

impl Coordinates<'_> {
    pub fn bound(&self, index: usize) -> RateBound {
        RateBound { rate: self.rate[index], acceleration: self.acceleration[index] }
    }

    /// Bound of a free body, whose pose is given by `axes` coordinates from `first` on.
    pub fn free_body(&self, first: usize, axes: usize) -> MotionBound {
        let [x, y] = [first, first + 1].map(|index| self.bound(index));
        let turn = if axes == 3 { self.bound(first + 2) } else { RateBound::default() };
        MotionBound {
            speed: length([x.rate, y.rate]),
            acceleration: length([x.acceleration, y.acceleration]),
            spin: turn.rate,
            spin_acceleration: turn.acceleration,
        }
    }

    /// Largest value of a length over the part; `value` and `rate` are those at one end of it.
    pub fn largest(&self, value: f64, rate: f64) -> f64 {
        value.abs() + rate * self.width
    }
}
