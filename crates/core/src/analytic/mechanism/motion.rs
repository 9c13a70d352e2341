//! Motions of bodies and joints: poses, Jacobians and bias accelerations as functions of the coordinates of a group, in plain
//! numbers or in numbers with derivatives by some of these coordinates.

use crate::mechanism::tendon::Bend;
use crate::mechanism::{JointCombination, Mechanism, Pose};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, perp, sub};
use crate::numeric::{Dual, Real};
use crate::scene;
use std::ops::Range;

/// Rotates a vector of a frame with this direction (cos θ, sin θ) to the world.
#[inline(always)]
pub(super) fn rotated<T: Real>([cos, sin]: Vector<T>, [x, y]: [f64; 2]) -> Vector<T> {
    [cos * x - sin * y, sin * x + cos * y]
}

/// Number of coordinates by which numbers have derivatives; a group with more is evaluated several times. Bodies that
/// depend on none of these coordinates are not evaluated.
pub(super) const LANES: usize = 4;

/// A number with derivatives by up to [`LANES`] coordinates of a group.
pub(super) type Lanes = Dual<LANES>;

/// Pose of the frame of a body, whose origin is its centre of mass, its rate, and its acceleration without accelerations of the coordinates. Components are x, y
/// and θ.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyMotion<T> {
    pub origin: Vector<T>,
    /// (cos θ, sin θ).
    pub direction: Vector<T>,
    pub angle: T,
    pub rate: [T; 3],
    pub bias: [T; 3],
}

/// Coordinate of a joint, with its derivatives as for a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointMotion<T> {
    pub coordinate: T,
    pub rate: T,
    pub bias: T,
}

/// Motion of a point of a body: position and rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointMotion<T> {
    pub position: Vector<T>,
    pub rate: Vector<T>,
}

impl BodyMotion<f64> {
    /// Takes over the pose of a placed body and keeps everything else.
    #[inline(always)]
    pub fn place_at(&mut self, placed: &Self) {
        (self.origin, self.direction, self.angle) = (placed.origin, placed.direction, placed.angle);
    }

    /// Returns the motion of a body with this pose and this rate of the pose.
    pub fn at([x, y, angle]: Pose, rate: Pose) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { origin: [x, y], direction: [cos, sin], angle, rate, ..Self::ground() }
    }

    /// Returns the same pose at rest, with its derivatives with respect to the coordinates from `first` on; `columns`
    /// is the motion of the body per unit of the rate of each coordinate.
    pub fn lifted(&self, columns: &[[f64; 3]], first: usize) -> BodyMotion<Lanes> {
        let columns = columns.get(first..).unwrap_or_default();
        let lift = |value: f64, part: &dyn Fn(&[f64; 3]) -> f64| {
            let mut lifted = Dual::constant(value);
            lifted.grad.iter_mut().zip(columns).for_each(|(grad, column)| *grad = part(column));
            lifted
        };
        let [cos, sin] = self.direction;
        BodyMotion {
            origin: pair(|axis| lift(self.origin[axis], &|column| column[axis])),
            direction: [lift(cos, &|column| -sin * column[2]), lift(sin, &|column| cos * column[2])],
            angle: lift(self.angle, &|column| column[2]),
            ..BodyMotion::ground()
        }
    }

    /// Returns the same motion with all derivatives 0.
    pub fn constant(&self) -> BodyMotion<Lanes> {
        let constant = |numbers: [f64; 3]| numbers.map(Dual::constant);
        BodyMotion {
            origin: self.origin.map(Dual::constant),
            direction: self.direction.map(Dual::constant),
            angle: Dual::constant(self.angle),
            rate: constant(self.rate),
            bias: constant(self.bias),
        }
    }
}

impl BodyMotion<f64> {
    /// Transforms a vector of the world to the frame of the body.
    pub fn in_frame(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.direction;
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Transforms a point of the world to the frame of the body.
    pub fn point_in_frame(&self, point: [f64; 2]) -> [f64; 2] {
        self.in_frame(sub(point, self.origin))
    }

    /// Velocity of a point of the world relative to the body, in its frame.
    pub fn velocity_in_frame(&self, point: [f64; 2], rate: [f64; 2]) -> [f64; 2] {
        self.in_frame(sub(rate, self.rate_at(sub(point, self.origin))))
    }
}

impl<T: Real> BodyMotion<T> {
    /// Returns the motion of the ground.
    pub fn ground() -> Self {
        let zero = T::zero();
        Self { origin: [zero; 2], direction: [T::constant(1.0), zero], angle: zero, rate: [zero; 3], bias: [zero; 3] }
    }

    /// Rotates a vector of the body frame to the world.
    #[inline(always)]
    pub fn rotated(&self, vector: [f64; 2]) -> Vector<T> {
        rotated(self.direction, vector)
    }

    /// Position of a point of the body frame in the world.
    #[inline(always)]
    pub fn position(&self, point: [f64; 2]) -> Vector<T> {
        add(self.origin, self.rotated(point))
    }

    /// Rate of the point whose position relative to the origin of the body is `arm`.
    #[inline(always)]
    pub fn rate_at(&self, arm: Vector<T>) -> Vector<T> {
        let across = perp(arm);
        pair(|axis| self.rate[axis] + across[axis] * self.rate[2])
    }

    #[inline(always)]
    pub fn bias_at(&self, arm: Vector<T>) -> Vector<T> {
        let (across, squared) = (perp(arm), self.rate[2].squared());
        pair(|axis| self.bias[axis] + across[axis] * self.bias[2] - arm[axis] * squared)
    }

    /// Motion of a point that is given in the frame of the body.
    #[inline(always)]
    pub fn point(&self, point: [f64; 2]) -> PointMotion<T> {
        let arm = self.rotated(point);
        PointMotion { position: add(self.origin, arm), rate: self.rate_at(arm) }
    }
}

/// Both results of a function of 0 and 1. Unlike `map` of an array, it is always inlined.
#[inline(always)]
pub(super) fn pair<T>(f: impl Fn(usize) -> T) -> [T; 2] {
    [f(0), f(1)]
}

/// Results of a function of 0, 1 and 2.
#[inline(always)]
pub(super) fn triple<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// What is evaluated of the motions of bodies and joints, whose poses and coordinates are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Their rates.
    Rates,
    /// Derivatives by the coordinates and bias accelerations, if the rates are known.
    Derivatives,
    All,
}

impl Part {
    #[inline(always)]
    pub fn has_rates(self) -> bool {
        self != Self::Derivatives
    }

    #[inline(always)]
    pub fn has_derivatives(self) -> bool {
        self != Self::Rates
    }
}

impl<T: Real> JointMotion<T> {
    /// A joint at rest.
    pub fn at(coordinate: T) -> Self {
        Self { coordinate, rate: T::zero(), bias: T::zero() }
    }
}

/// Where the derivatives of a body or joint by the coordinates of its group are stored, and which of them are not 0.
#[derive(Clone, Debug, Default)]
pub(super) struct Support {
    /// Index of the derivative with respect to the first coordinate of the group.
    pub first: usize,
    /// Coordinates of the group on which the body or joint depends, in ascending order.
    pub coordinates: Vec<usize>,
}

impl Support {
    /// Whether the body or joint depends on a coordinate in `range`.
    pub fn meets(&self, range: &Range<usize>) -> bool {
        self.coordinates.iter().any(|coordinate| range.contains(coordinate))
    }

    /// Returns the union of sets of coordinates, in ascending order.
    pub fn union<'a>(all: impl IntoIterator<Item = &'a [usize]>) -> Vec<usize> {
        let mut union: Vec<usize> = all.into_iter().flatten().copied().collect();
        union.sort_unstable();
        union.dedup();
        union
    }
}

/// Poses and motions of all bodies and joints of a mechanism in one state.
#[derive(Clone, Debug)]
pub(super) struct Motions<T> {
    /// Bodies of the mechanism, then the ground.
    pub bodies: Vec<BodyMotion<T>>,
    pub joints: Vec<JointMotion<T>>,
    /// Counts of the turns of the lines between the pivots of dyads.
    pub counts: Vec<i32>,
    /// Coordinates of all joints at the last accepted state, from which Newton's method starts when it places Assur
    /// groups beyond dyads; empty if there are no such groups.
    pub near: Vec<f64>,
    /// How cables pass their path elements, cable by cable.
    pub bends: Vec<Bend>,
    /// For each body, its pose and the time derivatives if it has a prescribed motion.
    pub prescribed: Vec<scene::Pose>,
    /// Where the derivatives of each body are stored; the ground comes last.
    pub body_supports: Vec<Support>,
    /// Where the derivatives of each joint are stored.
    pub joint_supports: Vec<Support>,
    /// Motion of each body per unit of the rate of each coordinate of its group.
    pub columns: Vec<[T; 3]>,
    /// Derivative of each joint coordinate with respect to each coordinate of its group.
    pub rows: Vec<T>,
}

impl<T: Real> Motions<T> {
    /// Creates motions at rest, without derivatives with respect to coordinates.
    pub fn new(mechanism: &Mechanism) -> Self {
        let (bodies, joints) = (mechanism.bodies.len(), mechanism.joints.len());
        Self {
            bodies: vec![BodyMotion::ground(); bodies + 1],
            joints: vec![JointMotion::at(T::zero()); joints],
            counts: Vec::new(),
            near: Vec::new(),
            bends: Vec::new(),
            prescribed: vec![scene::Pose::default(); bodies],
            body_supports: vec![Support::default(); bodies + 1],
            joint_supports: vec![Support::default(); joints],
            columns: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Makes room for the derivatives, in the same places as in `like`.
    pub fn reserve(&mut self, like: &Motions<f64>) {
        self.body_supports.clone_from(&like.body_supports);
        self.joint_supports.clone_from(&like.joint_supports);
        self.columns = vec![[T::zero(); 3]; like.columns.len()];
        self.rows = like.rows.iter().map(|entry| T::constant(*entry)).collect();
    }

    /// Motion of a combination of joint coordinates.
    #[inline(always)]
    pub fn combination(&self, on: &JointCombination) -> JointMotion<T> {
        if let Some(joint) = on.joint() {
            return self.joints[joint];
        }
        JointMotion {
            coordinate: on.value(|joint| self.joints[joint].coordinate),
            rate: on.sum(|joint| self.joints[joint].rate),
            bias: on.sum(|joint| self.joints[joint].bias),
        }
    }

    /// Derivative of a combination of joint coordinates with respect to the coordinate `k` of their group.
    #[inline(always)]
    pub fn row_entry(&self, on: &JointCombination, k: usize) -> T {
        let entry = |joint: usize| self.rows[self.joint_supports[joint].first + k];
        on.joint().map_or_else(|| on.sum(entry), entry)
    }

    /// Derivative of a joint coordinate with respect to the coordinate `k` of its group.
    #[inline(always)]
    pub fn joint_entry(&self, joint: usize, k: usize) -> T {
        self.rows[self.joint_supports[joint].first + k]
    }

    /// Motion of a body per unit of the rate of the coordinate `k` of its group.
    #[inline(always)]
    pub fn column(&self, body: usize, k: usize) -> [T; 3] {
        self.columns[self.body_supports[body].first + k]
    }

    /// Adds the generalised loads of a force at the origin of a body and of a moment.
    #[inline(always)]
    pub fn add_body_load(&self, body: usize, of_body: [T; 3], load: &mut [T]) {
        let Support { first, coordinates } = &self.body_supports[body];
        let columns = &self.columns[*first..][..load.len()];
        let along = |[x, y, turn]: [T; 3]| of_body[0] * x + of_body[1] * y + of_body[2] * turn;
        match coordinates[..] {
            // Most bodies depend on one or two coordinates.
            [i] => load[i] += along(columns[i]),
            [i, j] => {
                load[i] += along(columns[i]);
                load[j] += along(columns[j]);
            }
            ref all => all.iter().for_each(|&i| load[i] += along(columns[i])),
        }
    }

    /// Motion of a body; `None` is the ground.
    #[inline(always)]
    pub fn body(&self, body: Option<usize>) -> &BodyMotion<T> {
        &self.bodies[self.index(body)]
    }

    /// Index of a body; `None` is the ground.
    #[inline(always)]
    pub fn index(&self, body: Option<usize>) -> usize {
        body.unwrap_or(self.bodies.len() - 1)
    }
}
