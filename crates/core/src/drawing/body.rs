//! Bodies, shapes and poses of a drawing.

use serde::Serialize;

use crate::numeric::elementary::sin_cos;
use crate::shape;

/// The drawing of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Fixed bodies first, so that moving bodies are drawn over them.
    pub bodies: Vec<Body>,
    /// Names of the contacts, in the order of samples.
    pub contacts: Vec<String>,
    /// Arrow length per newton. The arrow of a usual force is about half as long as a phalanx (a radius).
    pub arrow_m_per_n: f64,
    /// Largest arrow length; impact forces can be a thousand times the usual ones.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of a view of all bodies, at the start and (with fingers) in the grasp.
    pub extent_m: [[f64; 2]; 2],
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Body {
    /// `l11`, `l12`, `l21`, `l22`, `object`, `palm`, `plane`, or the name of a disc.
    pub name: String,
    #[serde(rename = "part")]
    pub role: BodyRole,
    /// Whether the body does not move.
    pub fixed: bool,
    pub shapes: Vec<Shape>,
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
    Disc,
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
    /// Converts a shape: a disc if it is round, otherwise a polygon.
    pub fn from_shape(shape: &shape::Shape) -> Self {
        let polygon = || Shape::Polygon { corners_m: shape.at([0.0; 2]).outline_m() };
        shape::circle_radius(shape).map_or_else(polygon, |radius_m| Shape::Disc { radius_m })
    }
}

/// Pose of a body's frame in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    pub position_m: [f64; 2],
    pub angle_rad: f64,
}

impl Pose {
    /// Transforms a point of the body to the world.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = sin_cos(self.angle_rad);
        [self.position_m[0] + c * x - s * y, self.position_m[1] + s * x + c * y]
    }
}

/// Lower left and upper right corner of everything except half planes, with a margin of a tenth.
pub(super) fn view_extent(posed_bodies: &[(&Body, Pose)]) -> [[f64; 2]; 2] {
    let mut corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let mut include = |[x, y]: [f64; 2], radius: f64| {
        corners[0] = [corners[0][0].min(x - radius), corners[0][1].min(y - radius)];
        corners[1] = [corners[1][0].max(x + radius), corners[1][1].max(y + radius)];
    };
    for (body, pose) in posed_bodies {
        for shape in &body.shapes {
            match shape {
                Shape::Polygon { corners_m } => corners_m.iter().for_each(|corner| include(pose.apply(*corner), 0.0)),
                Shape::Capsule { from_m, to_m, radius_m } => {
                    include(pose.apply(*from_m), *radius_m);
                    include(pose.apply(*to_m), *radius_m);
                }
                Shape::Disc { radius_m } => include(pose.position_m, *radius_m),
                Shape::HalfPlane { .. } => {}
            }
        }
    }
    let margin = 0.1 * (corners[1][0] - corners[0][0]).max(corners[1][1] - corners[0][1]);
    [corners[0].map(|low| low - margin), corners[1].map(|high| high + margin)]
}
