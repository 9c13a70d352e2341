//! What a drawing is made of.

use serde::Serialize;

use crate::numeric::elementary::sin_cos;
use crate::shape;

/// Everything that is to be drawn of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Fixed bodies first, so that what moves is drawn over them.
    pub bodies: Vec<Body>,
    /// Names of the contacts, in the order in which samples have them.
    pub contacts: Vec<String>,
    /// Length of a force arrow for each newton, so that a usual force is about half as long as a phalanx (a radius).
    pub arrow_m_per_n: f64,
    /// An arrow is never longer: forces of an impact can be a thousand times the usual ones.
    pub longest_arrow_m: f64,
    /// Lower left and upper right corner of a view that has all bodies, at the start and (of a finger) at the grasp.
    pub extent_m: [[f64; 2]; 2],
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// `l11`, `l12`, `l21`, `l22`, `object`, `palm`, or the name of a disc or `plane`.
    pub name: String,
    pub part: Part,
    /// Whether it stays where it is.
    pub fixed: bool,
    pub shapes: Vec<Shape>,
}

/// What a body is in its mechanism.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// l11.
    Driver,
    /// l12.
    Coupler,
    /// l21.
    Proximal,
    /// l22 and t22.
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
    /// The surface of a phalanx that touches: a segment with a radius.
    Capsule { from_m: [f64; 2], to_m: [f64; 2], radius_m: f64 },
    /// About the origin of the body.
    Disc { radius_m: f64 },
    /// Everything below y = level.
    HalfPlane { level_m: f64 },
}

impl Shape {
    /// Of a body of any shape: a disc where it is round, or else a polygon.
    pub fn of(shape: &shape::Shape) -> Self {
        let polygon = || Shape::Polygon { corners_m: shape.at([0.0; 2]).outline_m() };
        shape::round(shape).map_or_else(polygon, |radius_m| Shape::Disc { radius_m })
    }
}

/// Where the frame of a body is in the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    pub position_m: [f64; 2],
    pub angle_rad: f64,
}

impl Pose {
    /// A point of the body in the world.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = sin_cos(self.angle_rad);
        [self.position_m[0] + c * x - s * y, self.position_m[1] + s * x + c * y]
    }
}

/// Lower left and upper right corner of everything but half planes, with a margin of a tenth.
pub(super) fn extent(places: &[(&Body, Pose)]) -> [[f64; 2]; 2] {
    let mut corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let mut include = |[x, y]: [f64; 2], radius: f64| {
        corners[0] = [corners[0][0].min(x - radius), corners[0][1].min(y - radius)];
        corners[1] = [corners[1][0].max(x + radius), corners[1][1].max(y + radius)];
    };
    for (body, pose) in places {
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
