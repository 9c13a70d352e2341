//! Poses of the object in the frame of the base, between samples.

use crate::criteria::segments::Hermite;
use crate::drawing::states::{ground_at, in_sample};
use crate::mechanism::{Mechanism, Pose};
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{add, rotate, sub};
use crate::scene::{Hand, Object, ObjectMotion, Scene};
use crate::trace::{BodyState, Sample};

/// Position of the centre of mass of the object, m, and its angle, rad, in a frame.
pub(super) type RelativePose = [f64; 3];

/// Where the state of a frame is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    /// At rest in the frame of the samples, in this state.
    Fixed(BodyState),
    /// Index among the reported bodies.
    Reported(usize),
    /// The ground beside a palm that moves.
    Ground,
    /// A body whose state follows from its joints.
    Derived(usize),
}

impl Frame {
    pub fn of(mechanism: &Mechanism, body: Option<usize>) -> Self {
        let palm = mechanism.palm().map(|(palm, _)| palm);
        match body {
            None if palm.is_none() => Frame::Fixed(BodyState::default()),
            Some(body) if palm == Some(body) => Frame::Fixed(BodyState::default()),
            Some(body) => mechanism.reported_index(body).map_or(Frame::Derived(body), Frame::Reported),
            None => Frame::Ground,
        }
    }

    /// Returns the frame of the object of a scene.
    pub fn of_object(scene: &Scene, mechanism: &Mechanism, object: usize) -> Self {
        fixed_object(&scene.hand).map_or_else(|| Frame::of(mechanism, Some(object)), Frame::Fixed)
    }

    pub fn state(self, mechanism: &Mechanism, sample: &Sample) -> BodyState {
        match self {
            Frame::Fixed(state) => state,
            Frame::Reported(index) => sample.body(index),
            Frame::Ground => ground_at(mechanism, sample.time_s),
            Frame::Derived(body) => *in_sample(mechanism, sample).of(Some(body)),
        }
    }
}

/// The state of a fixed object, which no sample contains.
pub(super) fn fixed_object(hand: &Hand) -> Option<BodyState> {
    match hand.object {
        Some(Object { motion: ObjectMotion::Fixed, centre_m, angle_rad, .. }) => {
            Some(BodyState { centre_m, angle_rad, ..BodyState::default() })
        }
        _ => None,
    }
}

/// Poses of the bodies of the mechanism in which a grasp is judged, in the frame of a sample.
pub(super) fn poses_in(scene: &Scene, sample: &Sample) -> Vec<Pose> {
    let of_sample = in_sample(&scene.drawn_mechanism(), sample).bodies;
    of_sample.iter().chain(&fixed_object(&scene.hand)).map(pose_of).collect()
}

/// Motion of a body between two instants.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyMotion([Hermite; 3]);

impl BodyMotion {
    pub fn between((t0, from): (f64, &BodyState), (t1, to): (f64, &BodyState)) -> Self {
        let along = |axis: usize| {
            let of = |state: &BodyState| (state.centre_m[axis], state.velocity_m_s[axis]);
            let ((q0, v0), (q1, v1)) = (of(from), of(to));
            Hermite::new((t0, q0, v0), (t1, q1, v1))
        };
        let angle = Hermite::new((t0, from.angle_rad, from.spin_rad_s), (t1, to.angle_rad, to.spin_rad_s));
        BodyMotion([along(0), along(1), angle])
    }

    pub fn at(&self, time_s: f64) -> [f64; 3] {
        self.0.map(|coordinate| coordinate.value(time_s))
    }
}

/// Pose of a body in a frame: of its centre of mass, which is `com_m` in its own frame.
pub(super) fn relative([x, y, angle]: [f64; 3], com_m: [f64; 2], [u, v, turn]: [f64; 3]) -> RelativePose {
    let rotation = |angle: f64| {
        let (sin, cos) = sin_cos(angle);
        [cos, sin]
    };
    let centre = add([x, y], rotate(com_m, rotation(angle)));
    let [x, y] = rotate(sub(centre, [u, v]), rotation(-turn));
    [x, y, angle - turn]
}

/// Pose of a state.
pub(super) fn pose_of(state: &BodyState) -> [f64; 3] {
    let [x, y] = state.centre_m;
    [x, y, state.angle_rad]
}
