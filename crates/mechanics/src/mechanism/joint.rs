//! Joints: their kinds, coordinates and constraints, with gradients by the poses of their bodies, and their mirror images.

use std::f64::consts::PI;

use super::Pose;
use crate::law::{FrictionLaw, NormalLaw};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{Vector, add, dot, perp, rotate, sub};

/// A joint between bodies A and B at one point of each, in their frames. Its coordinate is q. Its generalised force Q
/// is a torque on B, or a force on B along the axis; the reaction acts on A.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    pub name: String,
    pub kind: JointKind,
    pub bodies: [Option<usize>; 2],
    pub points_m: [[f64; 2]; 2],
    /// Revolute: q = θ_B − θ_A − offset. Prismatic: θ_B − θ_A = offset.
    pub offset_rad: f64,
    /// Coordinate at the start, rad or m; `None` if it follows from other joints.
    pub start: Option<f64>,
    pub start_rate: f64,
    /// Q = −damping q̇, in N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Inertia of rotor and gear, kg·m² or kg: kinetic energy ½ armature q̇².
    pub armature: f64,
    /// Coulomb friction against the rate: the law under a normal force of 1 gives N·m or N at rates in rad/s or m/s.
    pub friction: Option<FrictionLaw>,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    /// Law of both limits; `None` for a joint without limits.
    pub limit: Option<NormalLaw>,
    /// Name of the limit in samples, for a joint with only one limit; by default `JOINT_lower` or `JOINT_upper`.
    pub limit_name: Option<String>,
}

/// Kind of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    Revolute,
    /// B slides along u = e(θ_A + axis): q = u·(P_B − P_A).
    Prismatic {
        axis_rad: f64,
    },
}

impl JointKind {
    /// Whether the coordinate is an angle. Otherwise it is a length, and the bodies do not rotate relative to each
    /// other.
    #[inline]
    pub fn is_angle(&self) -> bool {
        matches!(self, JointKind::Revolute)
    }

    /// Angle of the axis along which the joint slides, in the frame of its first body, rad; `None` for a joint that
    /// does not slide.
    #[inline]
    pub fn axis_rad(&self) -> Option<f64> {
        match self {
            JointKind::Revolute => None,
            JointKind::Prismatic { axis_rad } => Some(*axis_rad),
        }
    }

    /// Name of the kind in messages.
    pub fn name(&self) -> &'static str {
        match self {
            JointKind::Revolute => "a revolute joint",
            JointKind::Prismatic { .. } => "a prismatic joint",
        }
    }
}

impl Joint {
    /// Returns a joint without damping, armature, friction or limits. Its coordinate at the start follows from other
    /// joints.
    pub fn new(name: impl Into<String>, kind: JointKind, bodies: [Option<usize>; 2], points_m: [[f64; 2]; 2]) -> Self {
        Self {
            name: name.into(),
            kind,
            bodies,
            points_m,
            offset_rad: 0.0,
            start: None,
            start_rate: 0.0,
            damping: 0.0,
            armature: 0.0,
            friction: None,
            lower: None,
            upper: None,
            limit: None,
            limit_name: None,
        }
    }

    /// Returns the mirror image of the joint between the images of its bodies, with the same coordinate; `flip` is the image of
    /// a point. A revolute joint connects the bodies in the opposite order, so that its coordinate has the same sign.
    pub(super) fn image(&self, name: String, mut bodies: [Option<usize>; 2], flip: fn([f64; 2]) -> [f64; 2]) -> Self {
        let mut points_m = self.points_m.map(flip);
        let (kind, offset_rad) = match self.kind {
            JointKind::Revolute => {
                bodies.reverse();
                points_m.reverse();
                (JointKind::Revolute, self.offset_rad)
            }
            JointKind::Prismatic { axis_rad } => {
                (JointKind::Prismatic { axis_rad: PI - axis_rad }, 0.0 - self.offset_rad)
            }
        };
        Self { name, kind, bodies, points_m, offset_rad, ..self.clone() }
    }
}

/// Gradient of a scalar by the poses of a joint's two bodies.
pub(super) enum Terms {
    /// θ_B − θ_A.
    Angle,
    Point([[f64; 3]; 2]),
}

impl Terms {
    pub fn by_pose(self) -> [Pose; 2] {
        match self {
            Terms::Angle => [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]],
            Terms::Point(by_pose) => by_pose,
        }
    }
}

/// Lever arm of a joint's point in the world, and the point.
fn point(joint: &Joint, side: usize, poses: &[Pose]) -> (Vector<f64>, Vector<f64>) {
    let [x, y, angle] = joint.bodies[side].map_or([0.0; 3], |body| poses[body]);
    let (sin, cos) = sin_cos(angle);
    let arm = rotate(joint.points_m[side], [cos, sin]);
    (arm, add([x, y], arm))
}

fn angle(joint: &Joint, poses: &[Pose]) -> f64 {
    let [a, b] = joint.bodies.map(|body| body.map_or(0.0, |body| poses[body][2]));
    b - a - joint.offset_rad
}

/// Unit vector of the axis of a prismatic joint.
fn axis(joint: &Joint, axis_rad: f64, poses: &[Pose]) -> Vector<f64> {
    let (sin, cos) = sin_cos(axis_rad + joint.bodies[0].map_or(0.0, |body| poses[body][2]));
    [cos, sin]
}

/// n·(P_B − P_A) for a direction n that turns with A (`turns`) or is fixed, with its gradient.
fn along(joint: &Joint, n: Vector<f64>, turns: bool, poses: &[Pose]) -> (f64, Terms) {
    let [(arm_a, a), (arm_b, b)] = [0, 1].map(|side| point(joint, side, poses));
    let between = sub(b, a);
    let by_turning = if turns { dot(perp(n), between) } else { 0.0 };
    let by_a = [-n[0], -n[1], by_turning - dot(n, perp(arm_a))];
    (dot(n, between), Terms::Point([by_a, [n[0], n[1], dot(n, perp(arm_b))]]))
}

/// Both constraints of a joint.
pub(super) fn joint_conditions(joint: &Joint, poses: &[Pose]) -> [(f64, Terms); 2] {
    match joint.kind {
        JointKind::Revolute => [[1.0, 0.0], [0.0, 1.0]].map(|n| along(joint, n, false, poses)),
        JointKind::Prismatic { axis_rad } => {
            [along(joint, perp(axis(joint, axis_rad, poses)), true, poses), (angle(joint, poses), Terms::Angle)]
        }
    }
}

/// Returns the coordinate of a joint in these poses.
pub fn coordinate_in(joint: &Joint, poses: &[Pose]) -> f64 {
    coordinate(joint, poses).0
}

/// Returns the gradient of the coordinate of a joint with respect to the poses of its two bodies.
pub fn coordinate_gradient(joint: &Joint, poses: &[Pose]) -> [Pose; 2] {
    coordinate(joint, poses).1.by_pose()
}

/// Returns the gradients of the two constraints of a joint with respect to the poses of its two bodies.
pub fn constraint_gradients(joint: &Joint, poses: &[Pose]) -> [[Pose; 2]; 2] {
    joint_conditions(joint, poses).map(|(_, terms)| terms.by_pose())
}

/// Coordinate of a joint.
pub(super) fn coordinate(joint: &Joint, poses: &[Pose]) -> (f64, Terms) {
    match joint.kind {
        JointKind::Revolute => (angle(joint, poses), Terms::Angle),
        JointKind::Prismatic { axis_rad } => along(joint, axis(joint, axis_rad, poses), true, poses),
    }
}
