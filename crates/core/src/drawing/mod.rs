//! Drawing of a scene: the shapes of its bodies in their own frames, and the poses of these frames at an instant.
//!
//! The pictures in a log and the animated page both use this module, so they show the same bodies.

mod parts;
pub(crate) mod states;

use serde::Serialize;

use crate::gripper::Posture;
use crate::mechanism::Mechanism;
use crate::numeric::elementary::sin_cos;
use crate::scene::Scene;
use crate::trace::{FingerState, Sample, Schema};
pub use states::poses_at_start;

/// The drawing of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The bodies. Half planes and outlines of the ground come first, so that other bodies are drawn over them.
    pub bodies: Vec<DrawnBody>,
    /// Names of the contacts between surfaces, in the order of the samples.
    pub contacts: Vec<String>,
    /// Length of a force arrow per newton, m/N.
    pub arrow_m_per_n: f64,
    /// Largest arrow length, m. It is needed because impact forces can be a thousand times the usual forces.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of a view of all bodies at the start, m.
    pub extent_m: [[f64; 2]; 2],
    mechanism: Mechanism,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnBody {
    /// Name of a body of the mechanism, or of an outline of the ground; for a half plane, that of the half plane and
    /// its body.
    pub name: String,
    #[serde(rename = "part")]
    pub role: BodyRole,
    /// Whether the body does not move.
    pub fixed: bool,
    pub shapes: Vec<Shape>,
    /// Points that pages mark with a ring, in the frame of the body: pins, and the centre of an object.
    pub marks_m: Vec<[f64; 2]>,
}

/// Role of a body in the mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyRole {
    /// Link l11.
    Driver,
    /// Link l12.
    Coupler,
    /// Link l21.
    Proximal,
    /// Distal body, l22 and t22.
    Distal,
    Object,
    Palm,
}

/// A shape in the frame of its body.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Shape {
    /// Outline of a body's mass, counter-clockwise.
    Polygon { corners_m: Vec<[f64; 2]> },
    /// Contact surface of a phalanx: a segment with a radius.
    Capsule { from_m: [f64; 2], to_m: [f64; 2], radius_m: f64 },
    /// A disc about the origin of the body.
    Disc { radius_m: f64 },
    /// Everything below y = level.
    HalfPlane { level_m: f64 },
}

impl Shape {
    /// Centres and radii of discs whose convex hull contains the shape; none for a half plane.
    fn discs(&self) -> Vec<([f64; 2], f64)> {
        match self {
            Shape::Polygon { corners_m } => corners_m.iter().map(|corner| (*corner, 0.0)).collect(),
            Shape::Capsule { from_m, to_m, radius_m } => vec![(*from_m, *radius_m), (*to_m, *radius_m)],
            Shape::Disc { radius_m } => vec![([0.0; 2], *radius_m)],
            Shape::HalfPlane { .. } => Vec::new(),
        }
    }
}

/// Pose of a body's frame in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FramePose {
    pub position_m: [f64; 2],
    pub angle_rad: f64,
}

impl FramePose {
    /// Transforms a point from the frame of the body to the world.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = sin_cos(self.angle_rad);
        [self.position_m[0] + c * x - s * y, self.position_m[1] + s * x + c * y]
    }
}

impl Drawing {
    /// Builds the drawing of a scene; all kinds of scenes are supported.
    pub fn from_scene(scene: &Scene) -> Self {
        parts::drawing(scene.drawn_mechanism().into_owned())
    }

    /// Length of the arrow of a force, m, with the sign of the force.
    pub fn arrow_m(&self, force_n: f64) -> f64 {
        (force_n * self.arrow_m_per_n).clamp(-self.longest_arrow_m, self.longest_arrow_m)
    }

    /// Length of the longer side of the view, m.
    pub fn view_m(&self) -> f64 {
        let [low, high] = self.extent_m;
        (high[0] - low[0]).max(high[1] - low[1])
    }

    /// Poses of the bodies of the drawing in a sample, in their order.
    pub fn poses(&self, sample: &Sample) -> Vec<FramePose> {
        parts::poses(&self.mechanism, &states::in_sample(&self.mechanism, sample))
    }

    /// Time derivatives of [`Drawing::poses`]: velocities and angular velocities instead of positions and angles.
    pub fn velocities(&self, sample: &Sample) -> Vec<FramePose> {
        parts::velocities(&self.mechanism, &states::in_sample(&self.mechanism, sample))
    }

    /// Poses of the bodies at the start.
    pub fn poses_at_start(&self) -> Vec<FramePose> {
        parts::poses(&self.mechanism, &states::at_start(&self.mechanism))
    }

    /// Poses of the bodies with the fingers in these postures. All other bodies have their poses at the start.
    pub fn poses_for_postures(&self, scene: &Scene, postures: &[Posture]) -> Vec<FramePose> {
        let mut sample = Sample::new(0.0, Schema::from_scene(scene).counts());
        let bodies = states::at_start(&self.mechanism).bodies;
        let reported = self.mechanism.reported_bodies();
        reported.enumerate().for_each(|(index, body)| sample.set_body(index, &bodies[body]));
        for (finger, posture) in postures.iter().enumerate() {
            let Posture { q11_rad, q21_rad, q12_rad, q22_rad } = *posture;
            sample.set_finger(finger, &FingerState { q11_rad, q21_rad, q12_rad, q22_rad, ..FingerState::default() });
        }
        self.poses(&sample)
    }
}
