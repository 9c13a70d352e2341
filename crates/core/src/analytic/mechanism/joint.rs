//! Joints of the analytic model: the pose and motion of a body that a joint attaches, the coordinate of a joint between two
//! bodies, the constraints of a joint that closes a loop, and bounds of all these over a part of a step.

use super::body_bounds::length;
use super::motion::{BodyMotion, pair};
use crate::analytic::motion_bound::{MotionBound, RateBound};
use crate::mechanism::structure::Attachment;
use crate::mechanism::{Joint, JointKind};
use crate::numeric::Real;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, dot, perp, scale_by, sub};

/// Unit vector along the axis of a prismatic joint, from a body of the joint.
#[inline(always)]
pub(super) fn axis<T: Real>(axis_rad: f64, first: &BodyMotion<T>) -> Vector<T> {
    let (sin, cos) = sin_cos(axis_rad);
    first.rotated([cos, sin])
}

/// Moves a body to its pose at a joint with this coordinate.
#[inline(always)]
pub(super) fn place(
    joint: &Joint,
    at: &Attachment,
    base: &BodyMotion<f64>,
    coordinate: f64,
    body: &mut BodyMotion<f64>,
) {
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    let turn = if joint.kind.is_angle() { coordinate } else { 0.0 };
    body.angle = base.angle + sign * (turn + joint.offset_rad);
    let (sin, cos) = sin_cos(body.angle);
    body.direction = [cos, sin];
    let mut point = base.position(joint.points_m[1 - own]);
    if let JointKind::Prismatic { axis_rad } = joint.kind {
        let u = if at.is_second { axis(axis_rad, base) } else { axis(axis_rad, body) };
        point = add(point, scale_by(u, sign * coordinate));
    }
    body.origin = sub(point, body.rotated(joint.points_m[own]));
}

/// Motion of a placed body with that of its base, as if the joint between them were locked; `across` is its arm from the base,
/// turned by a quarter.
#[inline(always)]
pub(super) fn carried<T: Real>(base: [T; 3], across: Vector<T>) -> [T; 3] {
    [base[0] + across[0] * base[2], base[1] + across[1] * base[2], base[2]]
}

/// Bias acceleration of a placed body without that of the joint that attaches it.
#[inline(always)]
pub(super) fn carried_bias<T: Real>(
    joint: &Joint,
    at: &Attachment,
    [base, body]: [&BodyMotion<T>; 2],
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
pub(super) fn column<T: Real>(joint: &Joint, at: &Attachment, bodies: [&BodyMotion<T>; 2]) -> [T; 3] {
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
pub(super) fn joint_coordinate(joint: &Joint, motion: impl Fn(Option<usize>) -> BodyMotion<f64>) -> f64 {
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
pub(super) fn joint_rate(joint: &Joint, motion: impl Fn(Option<usize>) -> BodyMotion<f64>) -> f64 {
    let [first, second] = joint.bodies.map(motion);
    match joint.kind {
        JointKind::Revolute => second.rate[2] - first.rate[2],
        JointKind::Prismatic { axis_rad } => {
            let [a, b] = [first.point(joint.points_m[0]), second.point(joint.points_m[1])];
            dot(axis(axis_rad, &first), sub(b.rate, a.rate))
        }
    }
}

/// Direction of the force of a joint on its second body, and its torque, per unit effort; `first` is its first body.
pub(super) fn effort_direction(joint: &Joint, first: &BodyMotion<f64>) -> ([f64; 2], f64) {
    match joint.kind {
        JointKind::Revolute => ([0.0; 2], 1.0),
        JointKind::Prismatic { axis_rad } => (axis(axis_rad, first), 0.0),
    }
}

/// Misfit of both constraints of a joint.
pub(super) fn misfit(joint: &Joint, [first, second]: [&BodyMotion<f64>; 2]) -> [f64; 2] {
    let [a, b] = [first.position(joint.points_m[0]), second.position(joint.points_m[1])];
    match joint.kind {
        JointKind::Revolute => sub(a, b),
        JointKind::Prismatic { axis_rad } => {
            [dot(perp(axis(axis_rad, first)), sub(b, a)), second.angle - first.angle - joint.offset_rad]
        }
    }
}

/// Derivatives of the two constraints of a joint that closes a loop by x, y and θ of each of its bodies.
pub(super) type Closure<T> = [[[T; 3]; 2]; 2];

/// Derivatives of the constraints of a joint whose bodies A and B are the bodies `of` of this pair.
#[inline(always)]
pub(super) fn closure<T: Real>(joint: &Joint, of: [usize; 2], bodies: &[BodyMotion<T>; 2]) -> Closure<T> {
    let (zero, one) = (T::zero(), T::constant(1.0));
    let [first, second] = [&bodies[of[0]], &bodies[of[1]]];
    let arms = [first.rotated(joint.points_m[0]), second.rotated(joint.points_m[1])];
    let [across_a, across_b] = [perp(arms[0]), perp(arms[1])];
    let mut by_motion = [[[zero; 3]; 2]; 2];
    match joint.kind {
        JointKind::Revolute => {
            // P_A − P_B = 0.
            by_motion[0][of[0]] = [one, zero, across_a[0]];
            by_motion[1][of[0]] = [zero, one, across_a[1]];
            by_motion[0][of[1]] = [-one, zero, -across_b[0]];
            by_motion[1][of[1]] = [zero, -one, -across_b[1]];
        }
        JointKind::Prismatic { axis_rad } => {
            // n·(P_B − P_A) = 0 and θ_B − θ_A = offset.
            let u = axis(axis_rad, first);
            let n = perp(u);
            let offset = sub(add(second.origin, arms[1]), add(first.origin, arms[0]));
            by_motion[0][of[0]] = [-n[0], -n[1], -dot(n, across_a) - dot(u, offset)];
            by_motion[0][of[1]] = [n[0], n[1], dot(n, across_b)];
            by_motion[1][of[0]] = [zero, zero, -one];
            by_motion[1][of[1]] = [zero, zero, one];
        }
    }
    by_motion
}

/// Terms of the accelerations of the closure that are quadratic in the rates.
#[inline(always)]
pub(super) fn quadratic_terms<T: Real>(joint: &Joint, of: [usize; 2], bodies: &[BodyMotion<T>; 2]) -> [T; 2] {
    let [first, second] = [&bodies[of[0]], &bodies[of[1]]];
    let arms = [first.rotated(joint.points_m[0]), second.rotated(joint.points_m[1])];
    let squared = [first.rate[2].squared(), second.rate[2].squared()];
    match joint.kind {
        JointKind::Revolute => pair(|axis| arms[1][axis] * squared[1] - arms[0][axis] * squared[0]),
        JointKind::Prismatic { axis_rad } => {
            let u = axis(axis_rad, first);
            let n = perp(u);
            let offset = sub(add(second.origin, arms[1]), add(first.origin, arms[0]));
            let speed = sub(second.rate_at(arms[1]), first.rate_at(arms[0]));
            let centripetal = dot(n, arms[0]) * squared[0] - dot(n, arms[1]) * squared[1];
            let turning = first.rate[2] * dot(u, speed) * 2.0 + squared[0] * dot(n, offset);
            [centripetal - turning, T::zero()]
        }
    }
}

/// A joint that attaches a body: the distances of its point from the origins of base and body.
pub(super) fn arms(joint: &Joint, at: &Attachment) -> [f64; 2] {
    let own = usize::from(at.is_second);
    [1 - own, own].map(|k| length(joint.points_m[k]))
}

/// Bound of the coordinate of a joint between bodies with these bounds.
pub(super) fn joint_between(joint: &Joint, [a, b]: [MotionBound; 2]) -> RateBound {
    match joint.kind {
        JointKind::Revolute => a.turn().plus(b.turn()),
        JointKind::Prismatic { .. } => {
            let between = a.point(length(joint.points_m[0])).plus(b.point(length(joint.points_m[1])));
            RateBound { acceleration: between.acceleration + a.spin * between.rate, ..between }
        }
    }
}

/// Bound of a body that a joint attaches to a base with this bound. `turn` bounds the turn of the body, `own` the coordinate of
/// the joint, and `slide` the magnitude of a coordinate that is a length.
pub(super) fn attached_body(
    joint: &Joint,
    at: &Attachment,
    base: &MotionBound,
    turn: RateBound,
    (own, slide): (RateBound, f64),
) -> MotionBound {
    let [base_arm, own_arm] = arms(joint, at);
    match joint.kind {
        JointKind::Revolute => MotionBound::about_pivot(base.point(base_arm), turn, own_arm),
        JointKind::Prismatic { .. } => base.sliding(own, base_arm + slide + own_arm),
    }
}
