//! Mirror images about the y axis.
//!
//! Frames are mirrored too: the image of the pose (x, y, θ) is (−x, y, −θ), that of a point (x, y) of a frame is (−x, y).
//! Joints of an image have the coordinates, rates and forces of the original.

use super::{
    Actuator, Body, ContactPair, Coupling, DistanceFeedback, Joint, JointCombination, NamedPoint, Outline, OutlineId,
    OutlineShape, PathElement, PointId, Powertrain, Rotor, Spring, SpringKind, SumLimit, Tendon,
};

/// Indices of the mirror images of bodies and joints. The index of a body or joint without an image is its own.
#[derive(Clone, Copy, Debug)]
pub struct Mirror<'a> {
    pub body: &'a [usize],
    pub joint: &'a [usize],
}

/// The difference from zero has no negative zero.
fn flip([x, y]: [f64; 2]) -> [f64; 2] {
    [0.0 - x, y]
}

impl Mirror<'_> {
    fn of_body(&self, body: Option<usize>) -> Option<usize> {
        body.map(|body| self.body[body])
    }

    fn combination(&self, on: &JointCombination) -> JointCombination {
        let terms = on.terms.iter().map(|(joint, factor)| (self.joint[*joint], *factor)).collect();
        JointCombination { terms, offset: on.offset }
    }

    /// Returns the image of a body.
    pub fn body(&self, body: &Body, name: String) -> Body {
        let [x, y, angle] = body.pose;
        let [vx, vy, spin] = body.rate;
        let outline = |outline: &Outline| Outline { name: outline.name.clone(), shape: mirrored_shape(&outline.shape) };
        Body {
            name,
            com_m: flip(body.com_m),
            pose: [0.0 - x, y, 0.0 - angle],
            rate: [0.0 - vx, vy, 0.0 - spin],
            outlines: body.outlines.iter().map(outline).collect(),
            points: body
                .points
                .iter()
                .map(|NamedPoint { name, at_m }| NamedPoint { name: name.clone(), at_m: flip(*at_m) })
                .collect(),
            drawn_m: body
                .drawn_m
                .iter()
                .map(|corners| corners.iter().rev().map(|corner| flip(*corner)).collect())
                .collect(),
            ..body.clone()
        }
    }

    /// Returns the image of a joint.
    pub fn joint(&self, joint: &Joint, name: String) -> Joint {
        joint.image(name, joint.bodies.map(|body| self.of_body(body)), flip)
    }

    /// Returns the image of a spring.
    pub fn spring(&self, spring: &Spring, name: String) -> Spring {
        let kind = match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                SpringKind::Torsional { on: self.combination(on), preload: *preload }
            }
            SpringKind::Linear { bodies, points_m } => {
                SpringKind::Linear { bodies: bodies.map(|body| self.of_body(body)), points_m: points_m.map(flip) }
            }
        };
        Spring { name, kind, ..spring.clone() }
    }

    /// Returns the image of a coupling.
    pub fn coupling(&self, coupling: &Coupling, name: String) -> Coupling {
        Coupling { name, on: self.combination(&coupling.on) }
    }

    /// Returns the image of a rotor.
    pub fn rotor(&self, rotor: &Rotor, name: String) -> Rotor {
        Rotor { name, on: self.combination(&rotor.on), inertia: rotor.inertia }
    }

    /// Returns the image of an actuator.
    pub fn actuator(&self, actuator: &Actuator, name: String) -> Actuator {
        let point = |id: PointId| PointId { body: self.of_body(id.body), ..id };
        let feedback = actuator.powertrain.feedback;
        let feedback = feedback.map(|of| DistanceFeedback { points: of.points.map(point), ..of });
        let powertrain = Powertrain { feedback, ..actuator.powertrain.clone() };
        Actuator { name, on: self.combination(&actuator.on), powertrain, ..actuator.clone() }
    }

    /// Returns the image of the limits of a sum.
    pub fn sum_limit(&self, limit: &SumLimit, name: String) -> SumLimit {
        SumLimit { name, on: self.combination(&limit.on), ..limit.clone() }
    }

    fn spools(&self, joints: &[(usize, f64)]) -> Vec<(usize, f64)> {
        joints.iter().map(|(joint, factor)| (self.joint[*joint], *factor)).collect()
    }

    /// Returns the image of a tendon, without its actuator.
    pub fn tendon(&self, tendon: &Tendon, name: String) -> Tendon {
        let element = |element: &PathElement| PathElement {
            body: self.of_body(element.body),
            point_m: flip(element.point_m),
            // The direction of an eyelet has no effect.
            side: if element.is_pulley() { -element.side } else { element.side },
            ..*element
        };
        Tendon {
            name,
            path: tendon.path.iter().map(element).collect(),
            joints: self.spools(&tendon.joints),
            far_joints: self.spools(&tendon.far_joints),
            actuator: None,
            ..tendon.clone()
        }
    }

    /// Returns the image of a contact pair. Outlines of bodies without an image are kept.
    pub fn contact(&self, pair: &ContactPair) -> ContactPair {
        let image = |id: OutlineId| OutlineId { body: self.of_body(id.body), ..id };
        ContactPair { points: image(pair.points), face: image(pair.face), ..pair.clone() }
    }
}

fn mirrored_shape(shape: &OutlineShape) -> OutlineShape {
    match shape.clone() {
        OutlineShape::Disc { center_m, radius_m } => OutlineShape::Disc { center_m: flip(center_m), radius_m },
        OutlineShape::Capsule { from_m, to_m, radius_m } => {
            OutlineShape::Capsule { from_m: flip(from_m), to_m: flip(to_m), radius_m }
        }
        OutlineShape::Polygon { vertices_m, radius_m } => {
            OutlineShape::Polygon { vertices_m: vertices_m.into_iter().rev().map(flip).collect(), radius_m }
        }
        OutlineShape::HalfPlane { point_m, normal } => {
            OutlineShape::HalfPlane { point_m: flip(point_m), normal: flip(normal) }
        }
        OutlineShape::Ellipse { center_m, semi_axes_m, angle_rad } => {
            OutlineShape::Ellipse { center_m: flip(center_m), semi_axes_m, angle_rad: 0.0 - angle_rad }
        }
    }
}
