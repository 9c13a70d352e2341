//! Joints of the engine model: the joint in rapier, the constraints that keep it closed, its coordinate, and the shift of its
//! anchor by which rapier closes it.

use std::f64::consts::FRAC_PI_2;

use rapier2d_f64::prelude::{GenericJointBuilder, JointAxesMask, Pose, Vector};

use super::coordinate::{Coordinate, Measure};
use super::plan::{Plan, PlannedJoint};
use crate::mechanism::JointKind;
use crate::numeric::elementary::{cos, sin, sin_cos};

/// A pair of constraints: the openings, to be kept at zero.
#[derive(Clone, Debug)]
pub(super) enum Pair {
    /// x and y from the first anchor to the second, less an anchor on the ground.
    Pin { ground: [f64; 2] },
    /// Sums of ratios times coordinates, less their values in a closed pair.
    Relation { terms: Vec<(Coordinate, [f64; 2])>, closed: [f64; 2] },
}

/// Constraints that keep a joint closed.
pub(super) fn constraints(plan: &Plan, joint: &PlannedJoint) -> Pair {
    match joint.kind {
        JointKind::Revolute => {
            let ground = match joint.bodies {
                [None, _] => joint.anchors_m[0],
                [_, None] => joint.anchors_m[1].map(|x| -x),
                _ => [0.0; 2],
            };
            Pair::Pin { ground }
        }
        JointKind::Prismatic { axis_rad } => {
            let across = (position(plan, joint, axis_rad + FRAC_PI_2), [1.0, 0.0]);
            // The angle between bodies that do not rotate needs no constraint.
            let rotates = |body: usize| plan.bodies[body].body.inertia_kg_m2 > 0.0;
            let ratio = f64::from(joint.bodies.into_iter().flatten().any(rotates));
            Pair::Relation { terms: vec![across, (relative_angle(joint), [0.0, ratio])], closed: [0.0; 2] }
        }
    }
}

/// The joint in rapier, without its settings.
pub(super) fn joint_in_rapier(joint: &PlannedJoint) -> GenericJointBuilder {
    let [anchor, other_anchor] = joint.anchors_m.map(|[x, y]| Vector::new(x, y));
    match joint.kind {
        JointKind::Revolute => GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
            .local_anchor1(anchor)
            .local_anchor2(other_anchor),
        JointKind::Prismatic { axis_rad } => GenericJointBuilder::new(JointAxesMask::LOCKED_PRISMATIC_AXES)
            .local_frame1(Pose::new(anchor, axis_rad))
            .local_frame2(Pose::new(other_anchor, axis_rad - joint.offset_rad)),
    }
}

/// Shift of the first anchor, in the frame of its body, that makes up for an overshoot of the constraints in a step in which
/// this body turns by `turn`, rad; `in_body` turns a direction of the world into that frame.
pub(super) fn anchor_shift(
    joint: &PlannedJoint,
    overshoot: [f64; 2],
    turn: f64,
    in_body: impl FnOnce([f64; 2]) -> [f64; 2],
) -> [f64; 2] {
    match joint.kind {
        JointKind::Revolute => {
            // The shifted anchor rotates with its body; the shift solves (1 + turn ×) shift = overshoot.
            let [a, b] = overshoot.map(|x| x / (1.0 + turn * turn));
            in_body([a + turn * b, b - turn * a])
        }
        // Across the axis, in the frame of the first body; the angle is linear.
        JointKind::Prismatic { axis_rad } => [-sin(axis_rad), cos(axis_rad)].map(|x| overshoot[0] * x),
    }
}

impl Plan {
    /// Returns the coordinate of a joint: an angle or a position.
    pub fn joint_coordinate(&self, joint: &PlannedJoint) -> Coordinate {
        match joint.kind {
            JointKind::Revolute if joint.is_reversed => relative_angle(joint).negated(),
            JointKind::Revolute => relative_angle(joint),
            JointKind::Prismatic { axis_rad } => position(self, joint, axis_rad),
        }
    }
}

/// Position of the second anchor of a joint relative to the first, along an axis of the first body.
fn position(plan: &Plan, joint: &PlannedJoint, axis_rad: f64) -> Coordinate {
    let (sin, cos) = sin_cos(axis_rad);
    let points = [0, 1].map(|k: usize| plan.body_point(joint.bodies[k], joint.anchors_m[k]));
    Coordinate { measure: Measure::Slide { points, axis: [cos, sin] }, offset: 0.0 }
}

/// Angle of the second body of a joint relative to the first, less the offset of the joint.
fn relative_angle(joint: &PlannedJoint) -> Coordinate {
    let [first, second] = [joint.bodies[0].map(|body| (body, -1.0)), joint.bodies[1].map(|body| (body, 1.0))];
    let on = second.or(first).unwrap_or_default();
    Coordinate { measure: Measure::Angle { on, against: second.and(first) }, offset: joint.offset_rad }
}
