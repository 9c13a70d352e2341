//! Motions of bodies and joints: poses, Jacobians and bias accelerations as functions of the K coordinates of a group,
//! in plain numbers or in numbers with derivatives by these coordinates.

use crate::mechanism::structure::Attachment;
use crate::mechanism::{Joint, JointCombination, JointKind, Mechanism, Pose};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, dot, perp, scale_by, sub};
use crate::numeric::{Dual, Real, array_from};

/// Rotates a vector of a frame with this direction (cos θ, sin θ) to the world.
#[inline(always)]
pub(super) fn rotated<T: Real>([cos, sin]: Vector<T>, [x, y]: [f64; 2]) -> Vector<T> {
    [cos * x - sin * y, sin * x + cos * y]
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
#[derive(Clone, Copy, Debug)]
pub(super) struct PointMotion<T, const K: usize> {
    pub position: Vector<T>,
    pub jacobian: [[T; K]; 2],
    pub rate: Vector<T>,
    pub bias: Vector<T>,
}

impl<const K: usize> BodyMotion<f64, K> {
    /// The pose alone.
    #[inline(always)]
    pub fn placed(&self) -> BodyMotion<f64, 0> {
        BodyMotion { origin: self.origin, direction: self.direction, angle: self.angle, ..BodyMotion::ground() }
    }

    /// Takes the pose of a placed body, and keeps everything else.
    #[inline(always)]
    pub fn place_at(&mut self, placed: &BodyMotion<f64, 0>) {
        (self.origin, self.direction, self.angle) = (placed.origin, placed.direction, placed.angle);
    }

    /// A body in a pose, with the rate of the pose.
    pub fn at([x, y, angle]: Pose, rate: Pose) -> Self {
        let (sin, cos) = sin_cos(angle);
        Self { origin: [x, y], direction: [cos, sin], angle, rate, ..Self::ground() }
    }

    /// The same pose with its derivatives by the coordinates, at rest.
    pub fn lifted(&self) -> BodyMotion<Dual<K>, K> {
        let lift = |value: f64, grad: [f64; K]| Dual { value, grad };
        let ([cos, sin], turn) = (self.direction, self.jacobian[2]);
        BodyMotion {
            origin: pair(|axis| lift(self.origin[axis], self.jacobian[axis])),
            direction: [lift(cos, turn.map(|part| -sin * part)), lift(sin, turn.map(|part| cos * part))],
            angle: lift(self.angle, turn),
            ..BodyMotion::ground()
        }
    }
}

impl<const K: usize> BodyMotion<f64, K> {
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

    /// Rates of the pose at the rates `v` of the coordinates.
    #[inline(always)]
    pub fn update_rate(&mut self, v: &[f64; K]) {
        self.rate = triple(|axis| rate_along(&self.jacobian[axis], v));
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

/// Rate of a quantity whose derivatives by the coordinates are `row`.
#[inline(always)]
pub(super) fn rate_along<T: Real, const K: usize>(row: &[T; K], v: &[f64; K]) -> T {
    row.iter().zip(v).fold(T::zero(), |sum, (entry, rate)| sum + *entry * *rate)
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
    /// Centres of mass of the bodies.
    pub centers: Vec<PointMotion<T, K>>,
    pub joints: Vec<JointMotion<T, K>>,
    /// Counts of the turns of the lines between pivots of dyads.
    pub counts: Vec<i32>,
}

impl<T: Real, const K: usize> Motions<T, K> {
    pub fn new(mechanism: &Mechanism) -> Self {
        Self {
            bodies: vec![BodyMotion::ground(); mechanism.bodies.len() + 1],
            centers: vec![BodyMotion::ground().point([0.0; 2]); mechanism.bodies.len()],
            joints: vec![JointMotion::at(T::zero()); mechanism.joints.len()],
            counts: Vec::new(),
        }
    }

    /// Motion of a combination of joint coordinates.
    #[inline(always)]
    pub fn combination(&self, on: &JointCombination) -> JointMotion<T, K> {
        if let Some(joint) = on.joint() {
            return self.joints[joint];
        }
        JointMotion {
            coordinate: on.value(|joint| self.joints[joint].coordinate),
            rate: on.sum(|joint| self.joints[joint].rate),
            bias: on.sum(|joint| self.joints[joint].bias),
            row: array_from(|k| on.sum(|joint| self.joints[joint].row[k])),
        }
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

/// Pose of a body at a joint with this coordinate.
pub(super) fn place<const K: usize>(
    joint: &Joint,
    at: &Attachment,
    base: &BodyMotion<f64, K>,
    coordinate: f64,
) -> BodyMotion<f64, 0> {
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    let turn = if joint.kind.is_angle() { coordinate } else { 0.0 };
    let mut body = BodyMotion::at([0.0, 0.0, base.angle + sign * (turn + joint.offset_rad)], [0.0; 3]);
    let mut point = base.position(joint.points_m[1 - own]);
    if let JointKind::Prismatic { axis_rad } = joint.kind {
        let u = if at.is_second { axis(axis_rad, base) } else { axis(axis_rad, &body) };
        point = add(point, scale_by(u, sign * coordinate));
    }
    body.origin = sub(point, body.rotated(joint.points_m[own]));
    body
}

/// Moves a placed body with its base, as if the joint between them were locked.
#[inline(always)]
pub(super) fn carry<T: Real, const K: usize>(base: &BodyMotion<T, K>, body: &mut BodyMotion<T, K>) {
    let across = perp(sub(body.origin, base.origin));
    body.jacobian[2] = base.jacobian[2];
    for (axis, across) in across.into_iter().enumerate() {
        for k in 0..K {
            body.jacobian[axis][k] = base.jacobian[axis][k] + across * base.jacobian[2][k];
        }
    }
}

/// Bias acceleration of a placed body without that of the joint that attaches it.
#[inline(always)]
pub(super) fn carried_bias<T: Real, const K: usize>(
    joint: &Joint,
    at: &Attachment,
    [base, body]: [&BodyMotion<T, K>; 2],
    joint_rate: T,
) -> [T; 3] {
    let arm = sub(body.origin, base.origin);
    let (across, squared) = (perp(arm), base.rate[2].squared());
    let carried = pair(|axis| base.bias[axis] + across[axis] * base.bias[2]);
    let [x, y] = match joint.kind {
        JointKind::Revolute => {
            let own_arm = body.rotated(joint.points_m[usize::from(at.is_second)]);
            let (base_arm, own_squared) = (add(arm, own_arm), body.rate[2].squared());
            pair(|axis| carried[axis] - base_arm[axis] * squared + own_arm[axis] * own_squared)
        }
        JointKind::Prismatic { axis_rad } => {
            let (first, sign) = if at.is_second { (base, 1.0) } else { (body, -1.0) };
            let u_across = scale_by(perp(axis(axis_rad, first)), sign);
            let coriolis = base.rate[2] * joint_rate * 2.0;
            pair(|axis| carried[axis] - arm[axis] * squared + u_across[axis] * coriolis)
        }
    };
    [x, y, base.bias[2]]
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
