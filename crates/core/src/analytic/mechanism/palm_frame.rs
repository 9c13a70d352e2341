//! The frame of a moving palm: the palm is at rest in it, the world moves, and inertial forces act on all bodies.
//!
//! Stiff contacts with the palm rest in this frame. In the frame of the world they chase a moving surface, which takes twice
//! the steps.

use super::inertial_field::AccelerationField;
use super::motion::Motions;
use crate::mechanism::{Body, Mechanism, Pose};
use crate::numeric::Real;
use crate::numeric::plane::Vector;
use crate::scene::PalmMotion;

/// The moving palm, if the equations are written in its frame: no other body has a prescribed motion, and no body keeps its
/// angle in the world.
pub(super) fn palm_of_frame(mechanism: &Mechanism) -> Option<usize> {
    let (palm, _) = mechanism.palm()?;
    let mut others = mechanism.bodies.iter().enumerate().filter(|(body, _)| *body != palm);
    others.all(|(_, body)| body.motion.is_none() && body.rotates()).then_some(palm)
}

/// Exchanges the palm and the ground: what is fixed to one of them is then fixed to the other.
pub(super) fn exchange_ground(mechanism: &mut Mechanism, palm: usize) {
    std::mem::swap(&mut mechanism.ground_outlines, &mut mechanism.bodies[palm].outlines);
    std::mem::swap(&mut mechanism.ground_points, &mut mechanism.bodies[palm].points);
    mechanism.rename_bodies(|body| match body {
        None => Some(palm),
        Some(body) if body == palm => None,
        other => other,
    });
}

/// Expresses the start of a mechanism in the frame of its palm: poses and rates of all bodies, and gravity. The palm, which
/// stands for the world in its frame, is at rest.
pub(super) fn place_in_frame(
    mechanism: &mut Mechanism,
    (palm, motion): (usize, &PalmMotion),
    (poses, rates): (&mut [Pose], &mut [Pose]),
) {
    let [px, py, turn] = motion.initial_pose;
    for (body, (pose, rate)) in poses.iter_mut().zip(rates).enumerate() {
        let ([x, y, angle], [vx, vy, spin]) = (if body == palm { [0.0; 3] } else { *pose }, *rate);
        let ([x, y], [vx, vy]) = (motion.in_initial_axes([x - px, y - py]), motion.in_initial_axes([vx, vy]));
        (*pose, *rate) = ([x, y, angle - turn], [vx, vy, spin]);
    }
    mechanism.gravity_m_s2 = motion.in_initial_axes(mechanism.gravity_m_s2);
}

/// Acceleration of a field at a point with this velocity, with the forces that depend on the velocity.
#[inline(always)]
pub(super) fn acceleration_at<T: Real>(field: &AccelerationField, [x, y]: Vector<T>, [vx, vy]: Vector<T>) -> Vector<T> {
    let AccelerationField { uniform, centrifugal, coriolis, euler } = *field;
    [
        x * centrifugal + y * euler + vy * (2.0 * coriolis) + uniform[0],
        y * centrifugal - x * euler - vx * (2.0 * coriolis) + uniform[1],
    ]
}

/// Mass and moment of inertia of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    pub mass: f64,
    pub moment: f64,
}

impl Inertia {
    pub fn of(body: &Body) -> Self {
        Self { mass: body.mass_kg, moment: body.inertia_kg_m2 }
    }

    /// Force and moment of an acceleration field on a body with this position and rate.
    pub fn load<T: Real>(&self, field: &AccelerationField, position: Vector<T>, rate: Vector<T>) -> [T; 3] {
        let [x, y] = acceleration_at(field, position, rate);
        [x * self.mass, y * self.mass, T::constant(-self.moment * field.euler)]
    }
}

/// Power of a load on a body in this motion.
pub(super) fn power<T: Real>(load: [T; 3], rate: [T; 3]) -> T {
    load[0] * rate[0] + load[1] * rate[1] + load[2] * rate[2]
}

/// The inertial loads on all bodies of a state, as [`Inertia::load`], with their positions.
pub(super) fn inertial_loads<'a>(
    mechanism: &'a Mechanism,
    (field, motions): (&'a AccelerationField, &'a Motions<f64>),
) -> impl Iterator<Item = (usize, [f64; 3])> + 'a {
    mechanism.bodies.iter().zip(&motions.bodies).enumerate().map(|(index, (body, motion))| {
        let [x, y, _] = motion.rate;
        (index, Inertia::of(body).load(field, motion.origin, [x, y]))
    })
}
