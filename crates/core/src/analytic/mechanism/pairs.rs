//! Forces between two bodies, on the poses (x, y, θ) of both: contacts of a point with a face, and linear springs.

use super::motion::{BodyMotion, pair};
use crate::analytic::multibody::contact_kinematics::{ContactKinematics, WithDerivatives};
use crate::mechanism::{ForcePoint, OutlineShape, Spring};
use crate::numeric::plane::{Vector, add, cross, dot, perp, scale, scale_by, sub};
use crate::numeric::{Dual, Real, array_from};

/// A point of body A with a radius about it, against an outline of body B.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointOnFace {
    pub bodies: [Option<usize>; 2],
    pub point_m: [f64; 2],
    pub radius_m: f64,
    pub face: OutlineShape,
    pub force_point: ForcePoint,
}

/// Number of pose components of two bodies.
pub(super) const POSES: usize = 6;

/// Frame of a body of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<T> {
    pub origin: Vector<T>,
    pub direction: Vector<T>,
}

impl<T: Real> Frame<T> {
    #[inline(always)]
    fn rotated(&self, [x, y]: [f64; 2]) -> Vector<T> {
        let [cos, sin] = self.direction;
        [cos * x - sin * y, sin * x + cos * y]
    }

    #[inline(always)]
    fn position(&self, point: [f64; 2]) -> Vector<T> {
        add(self.origin, self.rotated(point))
    }
}

impl Frame<f64> {
    pub fn new<const K: usize>(body: &BodyMotion<f64, K>) -> Self {
        Self { origin: body.origin, direction: body.direction }
    }
}

impl Frame<Dual<POSES>> {
    /// The frame of body `index` of a pair, with its pose as variables; a frame of the ground is constant.
    pub fn variable<const K: usize>(body: &BodyMotion<Dual<K>, K>, index: usize, is_ground: bool) -> Self {
        let constant = |value: f64| Dual::constant(value);
        let mut frame = Self {
            origin: pair(|k| constant(body.origin[k].value)),
            direction: pair(|k| constant(body.direction[k].value)),
        };
        if !is_ground {
            let first = 3 * index;
            frame.origin[0].grad[first] = 1.0;
            frame.origin[1].grad[first + 1] = 1.0;
            let [cos, sin] = pair(|k| frame.direction[k].value);
            (frame.direction[0].grad[first + 2], frame.direction[1].grad[first + 2]) = (-sin, cos);
        }
        frame
    }
}

/// Point of the core of a face that is nearest to a point, as its distance and unit normal towards the point.
#[inline(always)]
fn distance<T: Real>(face: &OutlineShape, frame: &Frame<T>, point: Vector<T>) -> (T, Vector<T>) {
    let from_point = |nearest: Vector<T>| {
        let offset = sub(point, nearest);
        let distance = dot(offset, offset).sqrt();
        (distance, scale(offset, distance.recip()))
    };
    match *face {
        OutlineShape::HalfPlane { point_m, normal } => {
            let normal = frame.rotated(normal);
            (dot(normal, sub(point, frame.position(point_m))), normal)
        }
        OutlineShape::Disc { center_m, .. } => from_point(frame.position(center_m)),
        OutlineShape::Capsule { from_m, to_m, .. } => {
            let axis = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let length = dot(axis, axis).sqrt();
            let direction = frame.rotated(scale_by(axis, 1.0 / length));
            let from = frame.position(from_m);
            let along = dot(direction, sub(point, from)).value();
            if along <= 0.0 {
                from_point(from)
            } else if along >= length {
                from_point(frame.position(to_m))
            } else {
                let across = cross(direction, sub(point, from));
                let side = if across.value() < 0.0 { -1.0 } else { 1.0 };
                (across * side, scale_by(perp(direction), side))
            }
        }
    }
}

/// Kinematics of a contact of two bodies with these frames: the rows are over the poses of both.
#[inline(always)]
pub(super) fn contact<T: Real>(pair: &PointOnFace, frames: &[Frame<T>; 2]) -> ContactKinematics<T, POSES> {
    let point = frames[0].position(pair.point_m);
    let (distance, normal) = distance(&pair.face, &frames[1], point);
    let face_radius = pair.face.radius_m();
    let gap = distance - (pair.radius_m + face_radius);
    // Distances of the force points of both bodies from the point, against the normal.
    let [on_points, on_face] = [T::constant(pair.radius_m), distance - face_radius];
    let depths = match pair.force_point {
        ForcePoint::Face => [on_face; 2],
        ForcePoint::Points => [on_points; 2],
        ForcePoint::Middle => [(on_face + on_points) * 0.5; 2],
        ForcePoint::Each => [on_points, on_face],
    };
    let force_points = depths.map(|depth| sub(point, scale(normal, depth)));
    let tangent = perp(normal);
    let row = |direction: Vector<T>| {
        let turn = |body: usize| cross(sub(force_points[body], frames[body].origin), direction);
        let [x, y] = direction;
        [x, y, turn(0), -x, -y, -turn(1)]
    };
    ContactKinematics { gap, normal_row: row(normal), tangent_row: row(tangent), normal, point: force_points[0] }
}

/// Tension of a linear spring, with the derivatives of length and rate by the poses.
pub(super) struct SpringState<T> {
    pub length: T,
    /// Derivative of the length by the poses of both bodies.
    pub row: [T; POSES],
}

#[inline(always)]
pub(super) fn spring<T: Real>(points_m: [[f64; 2]; 2], frames: &[Frame<T>; 2]) -> SpringState<T> {
    let points = [frames[0].position(points_m[0]), frames[1].position(points_m[1])];
    let offset = sub(points[1], points[0]);
    let length = dot(offset, offset).sqrt();
    let u = scale(offset, length.recip());
    let turn = |k: usize| cross(sub(points[k], frames[k].origin), u);
    SpringState { length, row: [-u[0], -u[1], -turn(0), u[0], u[1], turn(1)] }
}

/// Loads of a linear spring on the poses of both bodies, and the power of its damper.
pub(super) fn spring_loads(data: &Spring, state: &SpringState<f64>, rates: &[f64; POSES]) -> ([f64; POSES], f64) {
    let rate: f64 = (0..POSES).map(|k| state.row[k] * rates[k]).sum();
    let tension = data.stiffness * (state.length - data.rest) + data.damping * rate;
    (array_from(|k| -tension * state.row[k]), -data.damping * rate * rate)
}

/// [`spring_loads`] with derivatives by poses and rates.
pub(super) fn spring_loads_with_derivatives(
    data: &Spring,
    state: &SpringState<Dual<POSES>>,
    rates: &[f64; POSES],
) -> ([WithDerivatives<POSES, POSES>; POSES], WithDerivatives<POSES, POSES>) {
    let rate = (0..POSES).fold(Dual::<POSES>::constant(0.0), |sum, k| sum + state.row[k] * rates[k]);
    let tension = (state.length - data.rest) * data.stiffness + rate * data.damping;
    let load = |k: usize| {
        let force = -(tension * state.row[k]);
        WithDerivatives {
            value: force.value,
            by_q: force.grad,
            by_v: array_from(|l| -data.damping * state.row[l].value * state.row[k].value),
            by_bristle: 0.0,
        }
    };
    let power = -(rate * rate * data.damping);
    let power = WithDerivatives {
        value: power.value,
        by_q: power.grad,
        by_v: array_from(|l| -2.0 * data.damping * rate.value * state.row[l].value),
        by_bristle: 0.0,
    };
    (array_from(load), power)
}
