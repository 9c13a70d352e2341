//! Bodies as foxglove primitives: filled outlines in the plane, one entity per body, each in its own frame.

use std::f64::consts::{PI, TAU};

use foxglove::messages::line_primitive::Type as LineType;
use foxglove::messages::{
    Color, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneUpdate, TriangleListPrimitive, Vector3,
};

use phalanx_core::drawing::{BodyRole, Drawing, DrawnBody, Shape};
use phalanx_core::numeric::elementary::{atan2, sin_cos};

/// Number of corners of a full circle.
const CIRCLE_CORNERS: usize = 64;
/// Distance between the layers of bodies, relative to the size of the view.
const LAYER_SPACING: f64 = 2e-3;
/// Thickness of outlines, relative to the size of the view.
const OUTLINE_THICKNESS: f64 = 2e-3;

/// Returns the scene update that contains all bodies, without a timestamp.
pub fn scene(drawing: &Drawing) -> SceneUpdate {
    let view_m = drawing.view_m();
    let entities = drawing.bodies.iter().map(|body| entity(body, drawing, view_m)).collect();
    SceneUpdate { deletions: Vec::new(), entities }
}

fn entity(body: &DrawnBody, drawing: &Drawing, view_m: f64) -> SceneEntity {
    let (colour, layer) = style(body.role);
    let z = layer * LAYER_SPACING * view_m;
    let (mut triangles, mut lines) = (Vec::new(), Vec::new());
    for (index, shape) in body.shapes.iter().enumerate() {
        // The contact surface is drawn above the outline of the body's mass.
        let z = z + 0.25 * index as f64 * LAYER_SPACING * view_m;
        let corners = outline(shape, drawing.extent_m);
        let points: Vec<Point3> = corners.iter().map(|&[x, y]| Point3 { x, y, z }).collect();
        let alpha = if index == 0 { 0.55 } else { 0.9 };
        triangles.push(TriangleListPrimitive {
            pose: Some(identity()),
            // A fan: every shape is convex.
            indices: (1..points.len() as u32 - 1).flat_map(|k| [0, k, k + 1]).collect(),
            points: points.clone(),
            color: Some(Color { a: alpha, ..colour }),
            colors: Vec::new(),
        });
        lines.push(LinePrimitive {
            r#type: LineType::LineLoop as i32,
            pose: Some(identity()),
            thickness: OUTLINE_THICKNESS * view_m,
            scale_invariant: false,
            points,
            color: Some(Color { a: 1.0, ..colour }),
            colors: Vec::new(),
            indices: Vec::new(),
        });
    }
    SceneEntity {
        frame_id: body.name.clone(),
        id: body.name.clone(),
        // The shapes move with their frame.
        frame_locked: true,
        lines,
        triangles,
        ..SceneEntity::default()
    }
}

/// Returns the corners of a convex shape, counter-clockwise; a half plane is clipped to the view.
fn outline(shape: &Shape, [low, high]: [[f64; 2]; 2]) -> Vec<[f64; 2]> {
    match shape {
        Shape::Polygon { corners_m } => corners_m.clone(),
        Shape::Disc { radius_m } => arc([0.0; 2], *radius_m, 0.0, TAU, CIRCLE_CORNERS),
        Shape::Capsule { from_m, to_m, radius_m } => {
            let direction_rad = atan2(to_m[1] - from_m[1], to_m[0] - from_m[0]);
            let half = |centre: [f64; 2], from_rad: f64| {
                arc(centre, *radius_m, direction_rad + from_rad, direction_rad + (from_rad + PI), CIRCLE_CORNERS / 2)
            };
            [half(*to_m, -0.5 * PI), half(*from_m, 0.5 * PI)].concat()
        }
        Shape::HalfPlane { level_m } => {
            let floor = low[1].min(level_m - 0.05 * (high[0] - low[0]));
            vec![[low[0], floor], [high[0], floor], [high[0], *level_m], [low[0], *level_m]]
        }
    }
}

/// Returns points on an arc. A full circle omits the last one, which would repeat the first.
fn arc([x, y]: [f64; 2], radius: f64, from: f64, to: f64, corners: usize) -> Vec<[f64; 2]> {
    let segments = if to - from >= TAU { corners } else { corners - 1 };
    (0..corners)
        .map(|k| {
            let (sin, cos) = sin_cos(from + (to - from) * k as f64 / segments as f64);
            [x + radius * cos, y + radius * sin]
        })
        .collect()
}

/// Returns the colour and the layer of a part. Colours are the same as in all other pictures, saturated enough for a
/// dark background; driver and coupler are behind the phalanges.
fn style(part: BodyRole) -> (Color, f64) {
    let ([r, g, b], layer) = match part {
        BodyRole::Palm => ([120.0, 120.0, 120.0], -2.0),
        BodyRole::Object => ([190.0, 170.0, 120.0], -1.0),
        BodyRole::Driver => ([122.0, 134.0, 150.0], 0.0),
        BodyRole::Coupler => ([160.0, 170.0, 184.0], 1.0),
        BodyRole::Proximal => ([0.0, 114.0, 178.0], 2.0),
        BodyRole::Distal => ([213.0, 94.0, 0.0], 3.0),
    };
    (Color { r: r / 255.0, g: g / 255.0, b: b / 255.0, a: 1.0 }, layer)
}

fn identity() -> Pose {
    Pose {
        position: Some(Vector3 { x: 0.0, y: 0.0, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}
