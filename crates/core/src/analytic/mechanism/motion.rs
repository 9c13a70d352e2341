//! Motions of bodies and joints: poses, Jacobians and bias accelerations as functions of the K coordinates of a group,
//! in plain numbers or in numbers with derivatives by these coordinates.

use crate::mechanism::structure::Attachment;
use crate::mechanism::{Joint, JointKind, Mechanism, Pose};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, dot, perp, scale, scale_by, sub};
use crate::numeric::{Dual, Real, array_from};

/// A number that depends on the K coordinates of a group.
pub(super) trait GroupNumber<const K: usize>: Real {
    /// Whether the number has derivatives.
    const HAS_GRADIENT: bool;

    /// Returns a number with this value and these derivatives by the coordinates.
    fn with_gradient(value: f64, gradient: &[f64; K]) -> Self;
}

impl<const K: usize> GroupNumber<K> for f64 {
    const HAS_GRADIENT: bool = false;

    fn with_gradient(value: f64, _: &[f64; K]) -> Self {
        value
    }
}

impl<const K: usize> GroupNumber<K> for Dual<K> {
    const HAS_GRADIENT: bool = true;

    fn with_gradient(value: f64, gradient: &[f64; K]) -> Self {
        Dual { value, grad: *gradient }
    }
}

/// Pose of the frame of a body, its motion per unit of each coordinate rate, its rate, and its acceleration without
/// accelerations of the coordinates. Components are x, y and θ.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyMotion<T, const K: usize> {
    pub origin: Vector<T>,
    /// (cos θ, sin θ).
    pub direction: Vector<T>,
    pub angle: T,
    pub jacobian: [[T; K]; 3],
    pub rate: [T; 3],
    pub bias: [T; 3],
}

/// Coordinate of a joint, with its derivatives as for a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointMotion<T, const K: usize> {
    pub coordinate: T,
    pub row: [T; K],
    pub rate: T,
    pub bias: T,
}

/// Motion of a point of a body: position, Jacobian, rate and bias acceleration.
pub(super) struct PointMotion<T, const K: usize> {
    pub position: Vector<T>,
    pub jacobian: [[T; K]; 2],
    pub rate: Vector<T>,
    pub bias: Vector<T>,
}

impl<const K: usize> BodyMotion<f64, K> {
    /// A body in a pose, with the rate of the pose.
    pub fn at([x, y, angle]: Pose, rate: Pose) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { origin: [x, y], direction: [cos, sin], angle, rate, ..Self::ground() }
    }
}

impl<T: Real, const K: usize> BodyMotion<T, K> {
    /// The ground.
    pub fn ground() -> Self {
        let zero = T::zero();
        Self {
            origin: [zero; 2],
            direction: [T::constant(1.0), zero],
            angle: zero,
            jacobian: [[zero; K]; 3],
            rate: [zero; 3],
            bias: [zero; 3],
        }
    }

    pub fn value(&self) -> BodyMotion<f64, K> {
        BodyMotion {
            origin: pair(|k| self.origin[k].value()),
            direction: pair(|k| self.direction[k].value()),
            angle: self.angle.value(),
            jacobian: triple(|axis| array_from(|k| self.jacobian[axis][k].value())),
            rate: triple(|axis| self.rate[axis].value()),
            bias: triple(|axis| self.bias[axis].value()),
        }
    }

    /// Rotates a vector of the body frame to the world.
    #[inline(always)]
    pub fn rotated(&self, [x, y]: [f64; 2]) -> Vector<T> {
        let [cos, sin] = self.direction;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Position of a point of the body frame in the world.
    #[inline(always)]
    pub fn position(&self, point: [f64; 2]) -> Vector<T> {
        add(self.origin, self.rotated(point))
    }

    /// Rate of the point at an arm from the origin.
    #[inline(always)]
    pub fn rate_at(&self, arm: Vector<T>) -> Vector<T> {
        let across = perp(arm);
        pair(|axis| self.rate[axis] + across[axis] * self.rate[2])
    }

    #[inline(always)]
    fn bias_at(&self, arm: Vector<T>) -> Vector<T> {
        let (across, squared) = (perp(arm), self.rate[2].squared());
        pair(|axis| self.bias[axis] + across[axis] * self.bias[2] - arm[axis] * squared)
    }

    /// Motion of a point of the body frame.
    #[inline(always)]
    pub fn point(&self, point: [f64; 2]) -> PointMotion<T, K> {
        let arm = self.rotated(point);
        let across = perp(arm);
        PointMotion {
            position: add(self.origin, arm),
            jacobian: pair(|axis| array_from(|k| self.jacobian[axis][k] + across[axis] * self.jacobian[2][k])),
            rate: self.rate_at(arm),
            bias: self.bias_at(arm),
        }
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

impl<T: Real, const K: usize> JointMotion<T, K> {
    /// A joint at rest.
    pub fn at(coordinate: T) -> Self {
        Self { coordinate, row: [T::zero(); K], rate: T::zero(), bias: T::zero() }
    }
}

/// Poses and motions of all bodies and joints of a mechanism in one state.
#[derive(Clone, Debug)]
pub(super) struct Motions<T, const K: usize> {
    /// Bodies of the mechanism, then the ground.
    pub bodies: Vec<BodyMotion<T, K>>,
    pub joints: Vec<JointMotion<T, K>>,
}

impl<T: Real, const K: usize> Motions<T, K> {
    /// Motions in plain numbers.
    pub fn value(&self) -> Motions<f64, K> {
        let joint = |motion: &JointMotion<T, K>| JointMotion {
            coordinate: motion.coordinate.value(),
            row: array_from(|k| motion.row[k].value()),
            rate: motion.rate.value(),
            bias: motion.bias.value(),
        };
        Motions {
            bodies: self.bodies.iter().map(BodyMotion::value).collect(),
            joints: self.joints.iter().map(joint).collect(),
        }
    }

    pub fn new(mechanism: &Mechanism) -> Self {
        Self {
            bodies: vec![BodyMotion::ground(); mechanism.bodies.len() + 1],
            joints: vec![JointMotion::at(T::zero()); mechanism.joints.len()],
        }
    }

    /// Motions of all bodies.
    pub fn all_bodies(&self) -> &[BodyMotion<T, K>] {
        &self.bodies[..self.bodies.len() - 1]
    }

    /// Motion of a body; `None` is the ground.
    #[inline(always)]
    pub fn body(&self, body: Option<usize>) -> &BodyMotion<T, K> {
        &self.bodies[body.unwrap_or(self.bodies.len() - 1)]
    }
}

/// Unit vector along the axis of a prismatic joint, from a body of the joint.
#[inline(always)]
pub(super) fn axis<T: Real, const K: usize>(axis_rad: f64, first: &BodyMotion<T, K>) -> Vector<T> {
    let (sin, cos) = sin_cos(axis_rad);
    first.rotated([cos, sin])
}

/// Places a body at a joint with a known coordinate.
#[inline(always)]
pub(super) fn place<T: Real, const K: usize>(
    joint: &Joint,
    at: &Attachment,
    base: &BodyMotion<T, K>,
    motion: &JointMotion<T, K>,
) -> BodyMotion<T, K> {
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    let (base_point, own_point) = (joint.points_m[1 - own], joint.points_m[own]);
    let base_arm = base.rotated(base_point);
    let mut body = BodyMotion::ground();
    match joint.kind {
        JointKind::Revolute => {
            body.angle = base.angle + (motion.coordinate + joint.offset_rad) * sign;
            let (sin, cos) = body.angle.sin_cos();
            body.direction = [cos, sin];
            let arm = body.rotated(own_point);
            let (base_across, across) = (perp(base_arm), perp(arm));
            body.origin = sub(add(base.origin, base_arm), arm);
            body.rate[2] = base.rate[2] + motion.rate * sign;
            body.bias[2] = base.bias[2] + motion.bias * sign;
            for k in 0..K {
                body.jacobian[2][k] = base.jacobian[2][k] + motion.row[k] * sign;
            }
            let (base_squared, squared) = (base.rate[2].squared(), body.rate[2].squared());
            for axis in 0..2 {
                body.rate[axis] = base.rate[axis] + base_across[axis] * base.rate[2] - across[axis] * body.rate[2];
                body.bias[axis] = base.bias[axis] + base_across[axis] * base.bias[2]
                    - base_arm[axis] * base_squared
                    - across[axis] * body.bias[2]
                    + arm[axis] * squared;
                for k in 0..K {
                    body.jacobian[axis][k] = base.jacobian[axis][k] + base_across[axis] * base.jacobian[2][k]
                        - across[axis] * body.jacobian[2][k];
                }
            }
        }
        JointKind::Prismatic { axis_rad } => {
            body.angle = base.angle + joint.offset_rad * sign;
            let (sin, cos) = body.angle.sin_cos();
            body.direction = [cos, sin];
            let u = scale_by(axis(axis_rad, if at.is_second { base } else { &body }), sign);
            let arm = sub(add(base_arm, scale(u, motion.coordinate)), body.rotated(own_point));
            let (across, u_across) = (perp(arm), perp(u));
            body.origin = add(base.origin, arm);
            (body.rate[2], body.bias[2], body.jacobian[2]) = (base.rate[2], base.bias[2], base.jacobian[2]);
            let (squared, coriolis) = (base.rate[2].squared(), base.rate[2] * motion.rate * 2.0);
            for axis in 0..2 {
                body.rate[axis] = base.rate[axis] + across[axis] * base.rate[2] + u[axis] * motion.rate;
                body.bias[axis] = base.bias[axis] + across[axis] * base.bias[2] - arm[axis] * squared
                    + u[axis] * motion.bias
                    + u_across[axis] * coriolis;
                for k in 0..K {
                    body.jacobian[axis][k] =
                        base.jacobian[axis][k] + across[axis] * base.jacobian[2][k] + u[axis] * motion.row[k];
                }
            }
        }
    }
    body
}

/// Motion of a placed body per unit rate of the joint that attaches it.
#[inline(always)]
pub(super) fn column<T: Real, const K: usize>(
    joint: &Joint,
    at: &Attachment,
    bodies: [&BodyMotion<T, K>; 2],
) -> [T; 3] {
    let [base, body] = bodies;
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    match joint.kind {
        JointKind::Revolute => {
            let [x, y] = scale_by(perp(body.rotated(joint.points_m[own])), -sign);
            [x, y, T::constant(sign)]
        }
        JointKind::Prismatic { axis_rad } => {
            let [x, y] = scale_by(axis(axis_rad, if at.is_second { base } else { body }), sign);
            [x, y, T::zero()]
        }
    }
}

/// Coordinate of a joint from the poses of its bodies.
pub(super) fn joint_coordinate<const K: usize>(
    joint: &Joint,
    motion: impl Fn(Option<usize>) -> BodyMotion<f64, K>,
) -> f64 {
    let [first, second] = joint.bodies.map(motion);
    match joint.kind {
        JointKind::Revolute => second.angle - first.angle - joint.offset_rad,
        JointKind::Prismatic { axis_rad } => {
            let offset = sub(second.position(joint.points_m[1]), first.position(joint.points_m[0]));
            dot(axis(axis_rad, &first), offset)
        }
    }
}

/// Rate of a joint from the motions of its bodies.
pub(super) fn joint_rate<const K: usize>(joint: &Joint, motion: impl Fn(Option<usize>) -> BodyMotion<f64, K>) -> f64 {
    let [first, second] = joint.bodies.map(motion);
    match joint.kind {
        JointKind::Revolute => second.rate[2] - first.rate[2],
        JointKind::Prismatic { axis_rad } => {
            let [a, b] = [first.point(joint.points_m[0]), second.point(joint.points_m[1])];
            dot(axis(axis_rad, &first), sub(b.rate, a.rate))
        }
    }
}
