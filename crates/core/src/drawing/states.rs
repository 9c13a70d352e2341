//! States of all bodies of a mechanism: reported by a sample, or computed from its joints.

use super::FramePose;
use crate::mechanism::{Mechanism, Pose, assemble, pose_in_world};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{add, perp, rotate, scale, sub};
use crate::trace::{BodyState, Sample};

/// States of all bodies and of the ground, relative to a moving palm.
pub(crate) struct States {
    pub bodies: Vec<BodyState>,
    pub ground: BodyState,
}

impl States {
    pub fn of(&self, body: Option<usize>) -> &BodyState {
        body.map_or(&self.ground, |body| &self.bodies[body])
    }
}

impl BodyState {
    /// A point of the frame of the body, and its velocity.
    pub(super) fn point(&self, point_m: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = sin_cos(self.angle_rad);
        let arm = rotate(point_m, [cos, sin]);
        (add(self.centre_m, arm), add(self.velocity_m_s, scale(perp(arm), self.spin_rad_s)))
    }

    pub(super) fn pose(&self) -> FramePose {
        FramePose { position_m: self.centre_m, angle_rad: self.angle_rad }
    }
}

/// Poses of all bodies at the start. If the mechanism cannot be assembled, they are the guesses of the scene.
pub fn poses_at_start(mechanism: &Mechanism) -> Vec<[f64; 3]> {
    let guesses = || mechanism.bodies.iter().map(|body| body.pose).collect();
    assemble(mechanism).map_or_else(|_| guesses(), |start| start.poses)
}

/// The states at the start, at rest.
pub(super) fn at_start(mechanism: &Mechanism) -> States {
    let state = |[x, y, angle_rad]: [f64; 3]| BodyState { centre_m: [x, y], angle_rad, ..BodyState::default() };
    States { bodies: poses_at_start(mechanism).into_iter().map(state).collect(), ground: BodyState::default() }
}

/// The states in a sample. Bodies that it does not report follow from the coordinates of their revolute joints.
pub(crate) fn in_sample(mechanism: &Mechanism, sample: &Sample) -> States {
    let mut states =
        States { bodies: vec![BodyState::default(); mechanism.bodies.len()], ground: BodyState::default() };
    let mut is_placed = vec![false; mechanism.bodies.len()];
    for (index, body) in mechanism.reported_bodies().enumerate() {
        (states.bodies[body], is_placed[body]) = (sample.body(index), true);
    }
    if let Some((palm, motion)) = mechanism.palm() {
        let pose = motion.pose(sample.time_s);
        (states.ground, states.bodies[palm], is_placed[palm]) =
            (ground_in_palm(pose.position, pose.rate), BodyState::default(), true);
    }
    // Each pass places the bodies next to those that are placed.
    while let Some(joint) = mechanism.joints.iter().position(|joint| {
        let [a, b] = joint.bodies.map(|body| body.is_none_or(|body| is_placed[body]));
        a != b && joint.kind.is_angle()
    }) {
        let (of, state) = (&mechanism.joints[joint], sample.joint_state(joint));
        let from = usize::from(!of.bodies[0].is_none_or(|body| is_placed[body]));
        let sign = if from == 0 { 1.0 } else { -1.0 };
        let base = states.of(of.bodies[from]);
        let (pin_m, pin_m_s) = base.point(of.points_m[from]);
        let angle_rad = base.angle_rad + sign * (of.offset_rad + state.angle_rad);
        let spin_rad_s = base.spin_rad_s + sign * state.rate_rad_s;
        let about_pin = BodyState { angle_rad, spin_rad_s, ..BodyState::default() };
        let (arm_m, arm_m_s) = about_pin.point(of.points_m[1 - from]);
        let body = of.bodies[1 - from].expect("the ground is placed");
        states.bodies[body] =
            BodyState { centre_m: sub(pin_m, arm_m), velocity_m_s: sub(pin_m_s, arm_m_s), ..about_pin };
        is_placed[body] = true;
    }
    states
}

/// Pose in the world of the moving palm relative to which samples report; zero without one.
pub(crate) fn palm_pose(mechanism: &Mechanism, time_s: f64) -> Pose {
    mechanism.palm().map_or([0.0; 3], |(_, motion)| motion.pose(time_s).position)
}

/// Poses of all bodies in the world.
pub(crate) fn poses_in_world(mechanism: &Mechanism, sample: &Sample) -> Vec<Pose> {
    let palm = palm_pose(mechanism, sample.time_s);
    let in_world = |BodyState { centre_m: [x, y], angle_rad, .. }: BodyState| pose_in_world(palm, [x, y, angle_rad]);
    in_sample(mechanism, sample).bodies.into_iter().map(in_world).collect()
}

/// The state of the ground at a time.
pub(crate) fn ground_at(mechanism: &Mechanism, time_s: f64) -> BodyState {
    let pose = mechanism.palm().map(|(_, motion)| motion.pose(time_s));
    pose.map_or_else(BodyState::default, |pose| ground_in_palm(pose.position, pose.rate))
}

/// State of the ground relative to a palm with this pose and rate.
fn ground_in_palm([x, y, angle]: [f64; 3], [vx, vy, spin]: [f64; 3]) -> BodyState {
    let (sin, cos) = sin_cos(angle);
    let in_palm = |vector| rotate(vector, [cos, -sin]);
    let centre_m = in_palm([-x, -y]);
    let velocity_m_s = sub(in_palm([-vx, -vy]), scale(perp(centre_m), spin));
    BodyState { centre_m, angle_rad: -angle, velocity_m_s, spin_rad_s: -spin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Axis, Move, PalmMotion};

    /// The palm rises and turns; the ground sinks and turns back, and its velocities match differences of its poses.
    #[test]
    fn the_ground_moves_against_the_palm() {
        let single_move = |axis, distance| Move { axis, distance, start_s: 0.1, length_s: 0.2 };
        let moves = vec![single_move(Axis::X, 0.2), single_move(Axis::Y, -0.03), single_move(Axis::Angle, 0.4)];
        let motion = PalmMotion { moves, ..PalmMotion::default() };
        let at = |time_s: f64| {
            let pose = motion.pose(time_s);
            ground_in_palm(pose.position, pose.rate)
        };
        let ([x, y, angle], ground) = (motion.pose(0.17).position, at(0.17));
        // A point of the ground has its coordinates in the world.
        let (point, _) = ground.point([0.3, 0.04]);
        let (sin, cos) = angle.sin_cos();
        let in_world = add([x, y], rotate(point, [cos, sin]));
        assert!((in_world[0] - 0.3).abs() < 1e-15 && (in_world[1] - 0.04).abs() < 1e-15, "{in_world:?}");
        let (ahead, behind) = (at(0.17 + 1e-6), at(0.17 - 1e-6));
        let rate = |ahead: f64, behind: f64| (ahead - behind) / 2e-6;
        for axis in 0..2 {
            let found = rate(ahead.centre_m[axis], behind.centre_m[axis]);
            assert!((ground.velocity_m_s[axis] - found).abs() < 1e-7, "{found}");
        }
        assert!((ground.spin_rad_s - rate(ahead.angle_rad, behind.angle_rad)).abs() < 1e-7);
    }
}
