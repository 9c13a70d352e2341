//! Outlines of bodies, and the contacts of their points with faces.

use super::Mechanism;
use crate::law::{ContactLaw, FrictionLaw};
use crate::numeric::elementary::{atan2, hypot, sin_cos};
use crate::numeric::plane::{add, cross, dot, perp, rotate, scale, sub};
use std::f64::consts::{PI, TAU};

/// A named outline in the frame of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    pub name: String,
    pub shape: OutlineShape,
}

/// Shape of an outline: a convex core, enlarged by a radius.
#[derive(Clone, Debug, PartialEq)]
pub enum OutlineShape {
    Disc {
        center_m: [f64; 2],
        radius_m: f64,
    },
    Capsule {
        from_m: [f64; 2],
        to_m: [f64; 2],
        radius_m: f64,
    },
    /// A convex polygon; vertices are counter-clockwise.
    Polygon {
        vertices_m: Vec<[f64; 2]>,
        radius_m: f64,
    },
    /// The solid half plane through a point; `normal` is its outward unit normal. It has no points.
    HalfPlane {
        point_m: [f64; 2],
        normal: [f64; 2],
    },
    /// An ellipse with the angle of its first semi-axis. It cannot be a face.
    Ellipse {
        center_m: [f64; 2],
        semi_axes_m: [f64; 2],
        angle_rad: f64,
    },
}

/// An outline of a body (`None` is the ground), by its indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutlineId {
    pub body: Option<usize>,
    pub outline: usize,
}

/// Two outlines that may touch. The points of one outline touch the face of the other.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPair {
    /// Name of the contacts; `None` if they are named after the outlines.
    pub name: Option<String>,
    pub points: OutlineId,
    pub face: OutlineId,
    pub law: ContactLaw,
    /// Rolling resistance: a moment against the relative rotation of the bodies. It is a friction law whose
    /// coefficients are lengths, m, and whose rates are in rad/s.
    pub rolling: Option<FrictionLaw>,
    pub force_point: ForcePoint,
    /// Whether samples report the force on the body of the face, with the normal towards it. Otherwise they report the
    /// force on the body of the points.
    pub is_reported_on_face: bool,
}

/// Where a contact force acts on both bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ForcePoint {
    /// On the surface of the face.
    #[default]
    Face,
    /// On the surface of the points.
    Points,
    /// In the middle of the overlap.
    Middle,
    /// On each body's own surface, as in the thesis. The two friction forces then form a couple: friction force times
    /// overlap.
    Each,
}

/// The part of an outline that touches a face, in the frame of its body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutlinePoint {
    /// A vertex of the core, with the radius about it.
    Vertex { point_m: [f64; 2], radius_m: f64 },
    /// The point of an ellipse that is nearest to the core of the face. `axis` is the direction of the first semi-axis.
    Ellipse { center_m: [f64; 2], semi_axes_m: [f64; 2], axis: [f64; 2] },
}

/// A point of an outline against a face: one contact.
#[derive(Clone, Debug, PartialEq)]
pub struct PointContact {
    /// Name such as `ball.rim/ground.floor`, or `box.skin[2]/ground.floor` if the outline has several points.
    pub name: String,
    /// Index of its pair in [`Mechanism::contacts`].
    pub pair: usize,
    pub body: Option<usize>,
    pub point: OutlinePoint,
}

/// Two outlines that touch.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlinePair {
    /// Name of the contact in the scene; by default the names of both outlines, such as `left.pad/object.skin`.
    pub name: String,
    pub outlines: [OutlineId; 2],
    /// Indices among [`Mechanism::point_contacts`].
    pub points: Vec<usize>,
}

impl OutlineShape {
    /// Vertices of the core, counter-clockwise; empty for a half plane or an ellipse.
    pub fn vertices_m(&self) -> Vec<[f64; 2]> {
        match self {
            OutlineShape::Disc { center_m, .. } => vec![*center_m],
            OutlineShape::Capsule { from_m, to_m, .. } => vec![*from_m, *to_m],
            OutlineShape::Polygon { vertices_m, .. } => vertices_m.clone(),
            OutlineShape::HalfPlane { .. } | OutlineShape::Ellipse { .. } => Vec::new(),
        }
    }

    /// Radius about the core.
    pub fn radius_m(&self) -> f64 {
        match *self {
            OutlineShape::Disc { radius_m, .. }
            | OutlineShape::Capsule { radius_m, .. }
            | OutlineShape::Polygon { radius_m, .. } => radius_m,
            OutlineShape::HalfPlane { .. } | OutlineShape::Ellipse { .. } => 0.0,
        }
    }

    /// Largest projection of the outline on a unit vector of its frame, m; infinite for a half plane.
    pub fn support_m(&self, direction: [f64; 2]) -> f64 {
        match self {
            OutlineShape::HalfPlane { .. } => f64::INFINITY,
            OutlineShape::Ellipse { center_m, semi_axes_m: [a, b], angle_rad } => {
                let (sin, cos) = sin_cos(*angle_rad);
                let [along, across] = rotate(direction, [cos, -sin]);
                dot(*center_m, direction) + hypot(a * along, b * across)
            }
            other => {
                let vertices = other.vertices_m().into_iter().map(|vertex| dot(vertex, direction));
                vertices.fold(f64::NEG_INFINITY, f64::max) + other.radius_m()
            }
        }
    }

    /// Largest distance from the origin of the frame to a point of the outline, m; infinite for a half plane.
    pub fn reach_m(&self) -> f64 {
        match self {
            OutlineShape::HalfPlane { .. } => f64::INFINITY,
            OutlineShape::Ellipse { center_m: [x, y], semi_axes_m: [a, b], .. } => hypot(*x, *y) + a.max(*b),
            other => {
                let distances = other.vertices_m().into_iter().map(|[x, y]| hypot(x, y));
                distances.fold(0.0, f64::max) + other.radius_m()
            }
        }
    }

    /// Returns the outline in a new frame; `origin_m` and `angle_rad` are the pose of the old frame in the new one.
    pub fn moved(&self, origin_m: [f64; 2], angle_rad: f64) -> Self {
        let (sin, cos) = sin_cos(angle_rad);
        let point = |point: [f64; 2]| add(origin_m, rotate(point, [cos, sin]));
        match self.clone() {
            OutlineShape::Disc { center_m, radius_m } => OutlineShape::Disc { center_m: point(center_m), radius_m },
            OutlineShape::Capsule { from_m, to_m, radius_m } => {
                OutlineShape::Capsule { from_m: point(from_m), to_m: point(to_m), radius_m }
            }
            OutlineShape::Polygon { vertices_m, radius_m } => {
                OutlineShape::Polygon { vertices_m: vertices_m.into_iter().map(point).collect(), radius_m }
            }
            OutlineShape::HalfPlane { point_m, normal } => {
                OutlineShape::HalfPlane { point_m: point(point_m), normal: rotate(normal, [cos, sin]) }
            }
            OutlineShape::Ellipse { center_m, semi_axes_m, angle_rad: own_rad } => {
                OutlineShape::Ellipse { center_m: point(center_m), semi_axes_m, angle_rad: own_rad + angle_rad }
            }
        }
    }

    /// Returns the points that can touch a face; empty for a half plane.
    pub fn points(&self) -> Vec<OutlinePoint> {
        if let OutlineShape::Ellipse { center_m, semi_axes_m, angle_rad } = *self {
            let (sin, cos) = sin_cos(angle_rad);
            return vec![OutlinePoint::Ellipse { center_m, semi_axes_m, axis: [cos, sin] }];
        }
        let radius_m = self.radius_m();
        self.vertices_m().into_iter().map(|point_m| OutlinePoint::Vertex { point_m, radius_m }).collect()
    }
}

impl Mechanism {
    /// Returns [points, face] for two outlines. If both outlines have corners and sides, both assignments are returned.
    pub fn directions(&self, [a, b]: [OutlineId; 2]) -> Vec<[OutlineId; 2]> {
        let rank = |id: OutlineId| match self.outline(id).shape {
            OutlineShape::HalfPlane { .. } => 0,
            OutlineShape::Capsule { .. } | OutlineShape::Polygon { .. } => 1,
            OutlineShape::Disc { .. } => 2,
            OutlineShape::Ellipse { .. } => 3,
        };
        match (rank(a), rank(b)) {
            (1, 1) => vec![[a, b], [b, a]],
            (first, second) if first > second => vec![[a, b]],
            _ => vec![[b, a]],
        }
    }

    /// Returns the pairs of outlines that can touch, in the order of the contacts. In each pair, an outline of the body
    /// `second` comes second.
    pub fn outline_pairs(&self, second: Option<usize>) -> Vec<OutlinePair> {
        let mut pairs: Vec<OutlinePair> = Vec::new();
        for (index, point) in self.point_contacts().iter().enumerate() {
            let contact = &self.contacts[point.pair];
            let [points, face] = [contact.points, contact.face];
            let swaps = second.is_some() && points.body == second;
            let outlines = if swaps { [face, points] } else { [points, face] };
            let is_same =
                |pair: &&mut OutlinePair| pair.outlines == outlines || pair.outlines == [outlines[1], outlines[0]];
            match pairs.iter_mut().find(is_same) {
                Some(pair) => pair.points.push(index),
                None => {
                    let of_outlines = || outlines.map(|id| self.outline_name(id)).join("/");
                    let name = contact.name.clone().unwrap_or_else(of_outlines);
                    pairs.push(OutlinePair { name, outlines, points: vec![index] });
                }
            }
        }
        pairs
    }

    /// Whether two pairs (points, face) are the same contact. The order matters only if both outlines have corners and
    /// sides.
    pub fn is_same_contact(&self, pair: [OutlineId; 2], [points, face]: [OutlineId; 2]) -> bool {
        pair == [points, face] || pair == [face, points] && self.directions(pair).len() == 1
    }
}

/// A plane area: size, centroid, and polar moment about the centroid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaneArea {
    pub area_m2: f64,
    pub centroid_m: [f64; 2],
    pub polar_m4: f64,
}

impl PlaneArea {
    /// Returns the sum of areas that do not overlap each other.
    pub fn sum(parts: &[Self]) -> Self {
        let area_m2 = parts.iter().map(|part| part.area_m2).sum();
        let moment = |axis: usize| parts.iter().map(|part| part.area_m2 * part.centroid_m[axis]).sum::<f64>();
        let centroid_m = [moment(0) / area_m2, moment(1) / area_m2];
        let polar = |part: &Self| {
            let arm = sub(part.centroid_m, centroid_m);
            part.polar_m4 + part.area_m2 * dot(arm, arm)
        };
        Self { area_m2, centroid_m, polar_m4: parts.iter().map(polar).sum() }
    }
}

impl OutlineShape {
    /// Area of the outline; `None` for a half plane.
    pub fn area(&self) -> Option<PlaneArea> {
        match *self {
            OutlineShape::HalfPlane { .. } => return None,
            OutlineShape::Ellipse { center_m, semi_axes_m: [a, b], .. } => {
                let area_m2 = PI * a * b;
                return Some(PlaneArea { area_m2, centroid_m: center_m, polar_m4: 0.25 * area_m2 * (a * a + b * b) });
            }
            _ => {}
        }
        let (vertices_m, radius) = (self.vertices_m(), self.radius_m());
        let count = vertices_m.len();
        let vertex = |k: usize| vertices_m[k % count];
        let mut parts = Vec::new();
        // The core in triangles from the first vertex.
        for k in 1..count.saturating_sub(1) {
            let sides = [sub(vertex(k), vertex(0)), sub(vertex(k + 1), vertex(0)), sub(vertex(k + 1), vertex(k))];
            let area_m2 = 0.5 * cross(sides[0], sides[1]);
            let centroid_m = add(vertex(0), scale(add(sides[0], sides[1]), 1.0 / 3.0));
            let squares: f64 = sides.iter().map(|side| dot(*side, *side)).sum();
            parts.push(PlaneArea { area_m2, centroid_m, polar_m4: area_m2 * squares / 36.0 });
        }
        // A strip along each side, and a sector about each vertex.
        let outward = |k: usize| {
            let along = sub(vertex(k + 1), vertex(k));
            let length = hypot(along[0], along[1]);
            (scale(perp(along), -1.0 / length), length)
        };
        for k in 0..count {
            let (turn, middle) = if count == 1 {
                (TAU, [0.0; 2])
            } else {
                let ((before, _), (normal, length)) = (outward(k + count - 1), outward(k));
                let area_m2 = length * radius;
                let centroid_m = add(scale(add(vertex(k), vertex(k + 1)), 0.5), scale(normal, 0.5 * radius));
                parts.push(PlaneArea {
                    area_m2,
                    centroid_m,
                    polar_m4: area_m2 * (length * length + radius * radius) / 12.0,
                });
                let turn = atan2(cross(before, normal), dot(before, normal)).abs();
                let (sin, cos) = sin_cos(0.5 * turn);
                // Distance of the centroid of a sector from its vertex.
                (turn, scale(rotate(before, [cos, sin]), 4.0 * radius * sin / (3.0 * turn)))
            };
            let area_m2 = 0.5 * turn * radius * radius;
            let polar_m4 = area_m2 * (0.5 * radius * radius - dot(middle, middle));
            parts.push(PlaneArea { area_m2, centroid_m: add(vertex(k), middle), polar_m4 });
        }
        Some(PlaneArea::sum(&parts))
    }
}

/// Returns the core of a convex polygon whose corners are rounded with a radius: the polygon with its sides moved
/// inwards by this radius.
///
/// # Errors
/// Returns the largest rounding, m, if the given one is not smaller: a side of the core vanishes there.
pub fn rounded_core(outer_m: &[[f64; 2]], rounding_m: f64) -> Result<Vec<[f64; 2]>, f64> {
    let count = outer_m.len();
    let side = |k: usize| {
        let along = sub(outer_m[(k + 1) % count], outer_m[k % count]);
        let length_m = hypot(along[0], along[1]);
        (scale(perp(along), 1.0 / length_m), length_m)
    };
    // The vertex moves by the rounding times this vector; the part along a side is the tangent of half the turn.
    let inwards = |k: usize| {
        let (before, after) = (side(k + count - 1).0, side(k).0);
        scale(add(before, after), 1.0 / (1.0 + dot(before, after)))
    };
    let largest = |k: usize| {
        let (normal, length_m) = side(k);
        length_m / (cross(inwards(k), normal) - cross(inwards((k + 1) % count), normal))
    };
    let largest_m = (0..count).map(largest).fold(f64::INFINITY, f64::min);
    if rounding_m >= largest_m {
        return Err(largest_m);
    }
    Ok((0..count).map(|k| add(outer_m[k], scale(inwards(k), rounding_m))).collect())
}

impl Mechanism {
    /// Returns an outline by its indices.
    pub fn outline(&self, id: OutlineId) -> &Outline {
        let outlines = id.body.map_or(&self.ground_outlines, |body| &self.bodies[body].outlines);
        &outlines[id.outline]
    }

    /// Name of an outline with its body, such as `follower.pad`.
    pub fn outline_name(&self, id: OutlineId) -> String {
        format!("{}.{}", self.body_name(id.body), self.outline(id).name)
    }

    /// All contacts in the order that both models use: every point of every pair.
    pub fn point_contacts(&self) -> Vec<PointContact> {
        let mut all = Vec::new();
        for (pair, contact) in self.contacts.iter().enumerate() {
            let points = self.outline(contact.points).shape.points();
            let (points_name, face_name) = (self.outline_name(contact.points), self.outline_name(contact.face));
            for (index, point) in points.iter().enumerate() {
                let index = if points.len() > 1 { format!("[{index}]") } else { String::new() };
                let name = match &contact.name {
                    Some(name) => format!("{name}{index}"),
                    None => format!("{points_name}{index}/{face_name}"),
                };
                all.push(PointContact { name, pair, body: contact.points.body, point: *point });
            }
        }
        all
    }
}
