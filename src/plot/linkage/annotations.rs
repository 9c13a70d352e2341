//! Symbols of the drawing, and the lines that show their meaning.

use std::f64::consts::{FRAC_PI_2, PI};

use super::label_placement::{LabelRequest, Point};
use super::mechanism::Mechanism;
use crate::drawing::{Drawing, poses_for_postures};
use crate::numeric::plane::{add, dot, scale, sub};
use crate::plot::outline::{MARGIN, View, mirrored, outlines};
use crate::plot::svg::Paint;
use crate::plot::theme::{Colour, OBJECT, SOFT};
use crate::scene::Scene;
use crate::shape::circle_radius;

/// Width of the picture.
const WIDTH: f64 = 760.0;
/// Maximum height of the drawing in the picture.
const MAX_HEIGHT: f64 = 520.0;
/// Margin around the view for labels.
const VIEW_MARGIN: f64 = 20.0;
/// Margin below the view for the dimension of the base.
const BASE_MARGIN: f64 = 40.0;

pub(super) const LABEL_PX: f64 = 17.0;

/// Kind of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    /// The line between two joints, which has the length of a link.
    Link,
    /// Reference line of an angle.
    Reference,
    /// A dimension, with arrows at both ends.
    Dimension,
    /// An angle, with an arrow at its end.
    Angle,
    Force,
    /// Leader line from a distant label to its anchor.
    Leader,
}

/// A polyline.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub stroke: Stroke,
    pub points: Vec<Point>,
}

/// A symbol with the request for its placement.
pub(super) struct Label {
    pub symbol: &'static str,
    pub kind: Stroke,
    pub request: LabelRequest,
}

pub(super) struct Annotations {
    /// Outlines and their paints.
    pub bodies: Vec<(Vec<Point>, Paint)>,
    pub lines: Vec<Line>,
    pub labels: Vec<Label>,
    pub joints: Vec<Point>,
    pub size: [f64; 2],
    /// Height of the surface of the palm in pixels, if the scene has one.
    pub palm: Option<f64>,
}

impl Annotations {
    fn line(&mut self, stroke: Stroke, points: impl Into<Vec<Point>>) {
        self.lines.push(Line { stroke, points: points.into() });
    }

    /// Adds a label with an anchor in pixels and a preferred direction in world coordinates.
    fn label(&mut self, symbol: &'static str, kind: Stroke, anchor: Point, [x, y]: Point) {
        // Characters of common fonts are about 0.6 times as wide as high.
        let width = 0.62 * LABEL_PX * symbol.chars().count() as f64;
        let request = LabelRequest { anchor, direction: [x, -y], width, height: LABEL_PX };
        self.labels.push(Label { symbol, kind, request });
    }
}

pub(super) fn annotations(scene: &Scene, m: &Mechanism) -> Annotations {
    let outlines = outlines(&Drawing::from_scene(scene).bodies, &poses_for_postures(scene, &[m.posture]));
    let view = view(m, &outlines);
    let mut result = Annotations {
        bodies: bodies(m, &outlines, &view),
        lines: Vec::new(),
        labels: Vec::new(),
        joints: [[0.0; 2], m.joints.a12_m, m.joints.a13_m, m.joints.a22_m].map(|joint| view.pixel(joint)).into(),
        size: [WIDTH, view.height()],
        palm: m.palm.then(|| view.pixel([0.0; 2])[1]),
    };
    links(m, &view, &mut result);
    angles(m, &view, &mut result);
    forces(m, &view, &mut result);
    dimensions(m, &view, &mut result);
    result
}

/// Creates a view of the finger, the object and the other finger; a narrow drawing is centred.
fn view(m: &Mechanism, outlines: &[(Vec<Point>, Colour)]) -> View {
    let mut points: Vec<Point> = outlines.iter().flat_map(|(outline, _)| outline.clone()).chain([[0.0; 2]]).collect();
    if let Some(object) = m.object {
        points.extend(mirrored(&points.clone(), object.centre_m[0]));
    }
    let View { low, high, scale } =
        View::within_size(&points, [WIDTH - 2.0 * VIEW_MARGIN, MAX_HEIGHT - 2.0 * VIEW_MARGIN - BASE_MARGIN]);
    let side_margin = 0.5 * ((WIDTH - 2.0 * MARGIN) / scale - (high[0] - low[0]));
    let [above, below] = [VIEW_MARGIN, VIEW_MARGIN + BASE_MARGIN].map(|pixels| pixels / scale);
    View { low: [low[0] - side_margin, low[1] - below], high: [high[0] + side_margin, high[1] + above], scale }
}

/// Returns the object and the links, with the outline of the other finger behind them.
fn bodies(m: &Mechanism, outlines: &[(Vec<Point>, Colour)], view: &View) -> Vec<(Vec<Point>, Paint)> {
    let pixels = |outline: &[Point]| outline.iter().map(|point| view.pixel(*point)).collect::<Vec<Point>>();
    let other = Paint::line(SOFT, 1.2).dashed("4 4").faded(0.7);
    let links = outlines.iter().filter(|(_, fill)| *fill != OBJECT);
    let others = m
        .object
        .iter()
        .flat_map(|object| links.clone().map(|(outline, _)| (pixels(&mirrored(outline, object.centre_m[0])), other)));
    others.chain(outlines.iter().map(|(outline, fill)| (pixels(outline), Paint::fill(*fill).with_edge(SOFT)))).collect()
}

fn middle(a: Point, b: Point) -> Point {
    scale(add(a, b), 0.5)
}

fn unit_vector(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

fn links(m: &Mechanism, view: &View, result: &mut Annotations) {
    let j = &m.joints;
    let interior_point = middle(middle([0.0; 2], j.a12_m), middle(j.a13_m, j.a22_m));
    for (name, from, to) in [
        ("l11", [0.0; 2], j.a12_m),
        ("l12", j.a12_m, j.a13_m),
        ("l21", [0.0; 2], j.a22_m),
        ("l22", j.a22_m, j.a13_m),
        ("t22", j.a22_m, j.tip_m),
    ] {
        result.line(Stroke::Link, [view.pixel(from), view.pixel(to)]);
        let midpoint = middle(from, to);
        // The normal points to the outer side of the four-bar linkage.
        let normal = [from[1] - to[1], to[0] - from[0]];
        let side = dot(sub(midpoint, interior_point), normal).signum();
        result.label(name, Stroke::Link, view.pixel(midpoint), scale(normal, side));
    }
}

/// Angles with their reference lines, with different radii at the same joint.
fn angles(m: &Mechanism, view: &View, result: &mut Annotations) {
    let (q, j) = (&m.posture, &m.joints);
    let arm = q.q21_rad + q.q22_rad;
    for (name, joint, from, turn_angle, radius, reference) in [
        ("q11", [0.0; 2], 0.0, q.q11_rad, 74.0, 96.0),
        ("q21", [0.0; 2], 0.0, q.q21_rad, 48.0, 0.0),
        ("q12", j.a12_m, q.q11_rad, q.q12_rad, 34.0, 62.0),
        ("q22", j.a22_m, q.q21_rad, q.q22_rad, 46.0, 66.0),
        ("φ22", j.a22_m, arm, m.lengths.phi22_rad, 28.0, 0.0),
    ] {
        let [x, y] = view.pixel(joint);
        let point_on_arc = |angle: f64, radius: f64| [x + radius * angle.cos(), y - radius * angle.sin()];
        if reference > 0.0 {
            result.line(Stroke::Reference, [[x, y], point_on_arc(from, reference)]);
        }
        let turn_angle = if turn_angle.abs() > 2.0 * PI { turn_angle % (2.0 * PI) } else { turn_angle };
        let pieces = (turn_angle.abs() / 0.05).ceil().max(2.0) as usize;
        let points = (0..=pieces).map(|k| point_on_arc(from + turn_angle * k as f64 / pieces as f64, radius));
        result.line(Stroke::Angle, points.collect::<Vec<Point>>());
        // The arcs of φ22 and q22 overlap: label each where the other is absent.
        let label_angle = from + if name == "φ22" { 0.75 } else { 0.5 } * turn_angle;
        result.label(name, Stroke::Angle, point_on_arc(label_angle, radius), unit_vector(label_angle));
    }
}

/// Adds the normal forces of the object on the phalanges, not to scale.
fn forces(m: &Mechanism, view: &View, result: &mut Annotations) {
    let Some(contacts) = &m.contacts else { return };
    for (name, (contact_point, direction)) in ["F21", "F22"].into_iter().zip(contacts) {
        let from = view.pixel(*contact_point);
        let tip = [from[0] + 62.0 * direction[0], from[1] - 62.0 * direction[1]];
        result.line(Stroke::Force, [from, tip]);
        result.label(name, Stroke::Force, tip, *direction);
    }
}

fn dimensions(m: &Mechanism, view: &View, result: &mut Annotations) {
    // The half width, near the end of the proximal phalanx, on the side opposite to the object.
    let direction_rad = m.posture.q21_rad;
    let centre = scale(unit_vector(direction_rad), 0.8 * m.lengths.l21_m);
    let normal = unit_vector(direction_rad - FRAC_PI_2);
    let edge = view.pixel(add(centre, scale(normal, m.lengths.half_width_m)));
    result.line(Stroke::Dimension, [view.pixel(centre), edge]);
    result.label("w", Stroke::Dimension, edge, normal);
    let Some(object) = m.object else { return };
    // The base: distance between the joint on the palm and the middle of the gripper.
    let y = result.size[1] - 26.0;
    let (left, right) = (view.pixel(object.centre_m), view.pixel([0.0; 2]));
    result.line(Stroke::Reference, [left, [left[0], y + 6.0]]);
    result.line(Stroke::Reference, [right, [right[0], y + 6.0]]);
    result.line(Stroke::Dimension, [[left[0], y], [right[0], y]]);
    result.label("base", Stroke::Dimension, middle([left[0], y], [right[0], y]), [0.0, -1.0]);
    let Some(radius_m) = circle_radius(&object.shape) else { return };
    let rim_point = view.pixel(add(object.centre_m, scale(unit_vector(0.75 * PI), radius_m)));
    result.line(Stroke::Dimension, [left, rim_point]);
    result.label("radius", Stroke::Dimension, middle(left, rim_point), [0.5, 1.0]);
}
