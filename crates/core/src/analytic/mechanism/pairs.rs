//! Forces between two bodies, on their relative pose: contacts of a point with a face, and linear springs.

use super::nearest::{Frame, Nearest, POSES, PointOnFace};
use crate::analytic::contact::{ContactKinematics, WithDerivatives};
use crate::mechanism::{ForcePoint, Spring};
use crate::numeric::plane::{Vector, cross, dot, perp, scale, sub};
use crate::numeric::{Dual, Real, array_from};

/// Kinematics of a contact of two bodies with these frames and nearest points: the rows are over the relative pose.
#[inline(always)]
pub(super) fn contact<T: Real>(
    pair: &PointOnFace,
    frames: &[Frame<T>; 2],
    Nearest { point, distance, normal }: Nearest<T>,
) -> ContactKinematics<T, POSES> {
    let (point_radius, face_radius) = (pair.point_radius_m(), pair.face.radius_m);
    let gap = distance - (point_radius + face_radius);
    // Distances of the force points of both bodies from the point, against the normal.
    let [on_points, on_face] = [T::constant(point_radius), distance - face_radius];
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
        [x, y, turn(0), -turn(1)]
    };
    ContactKinematics { gap, normal_row: row(normal), tangent_row: row(tangent), normal, point: force_points[0] }
}

/// Tension of a linear spring, with the derivatives of length and rate by the poses.
pub(super) struct SpringState<T> {
    pub length: T,
    /// Derivative of the length with respect to the relative pose of the two bodies.
    pub row: [T; POSES],
}

#[inline(always)]
pub(super) fn spring<T: Real>(points_m: [[f64; 2]; 2], frames: &[Frame<T>; 2]) -> SpringState<T> {
    let points = [frames[0].position(points_m[0]), frames[1].position(points_m[1])];
    let offset = sub(points[1], points[0]);
    let length = dot(offset, offset).sqrt();
    let u = scale(offset, length.recip());
    let turn = |k: usize| cross(sub(points[k], frames[k].origin), u);
    SpringState { length, row: [-u[0], -u[1], -turn(0), turn(1)] }
}

/// Loads of a linear spring on the relative pose of both bodies, and the power of its damper.
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
            by_state: 0.0,
        }
    };
    let power = -(rate * rate * data.damping);
    let power = WithDerivatives {
        value: power.value,
        by_q: power.grad,
        by_v: array_from(|l| -2.0 * data.damping * rate.value * state.row[l].value),
        by_state: 0.0,
    };
    (array_from(load), power)
}
