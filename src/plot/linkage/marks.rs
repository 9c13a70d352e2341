//! What each letter names, and the lines that show it.

use std::f64::consts::{FRAC_PI_2, PI};

use super::mechanism::Mechanism;
use super::place::{Point, Wish};
use crate::drawing::{Pose, Shape};
use crate::gripper::{link_outline, tip_outline};

/// Width of the picture, and most height of the drawing in it.
pub(super) const WIDTH: f64 = 640.0;
const MOST_HEIGHT: f64 = 520.0;
/// Room around the bodies for labels, and below them for the base.
const MARGIN: f64 = 44.0;
const BELOW: f64 = 40.0;

pub(super) const LABEL_PX: f64 = 17.0;

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stroke {
    /// The line between two joints, which is what a length is.
    Link,
    /// Where an angle counts from.
    Reference,
    /// A dimension, with arrows at both ends.
    Dimension,
    /// An angle, with an arrow at its end.
    Angle,
    Force,
    /// From a label that is far from what it names.
    Leader,
}

/// A line of one or many pieces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub stroke: Stroke,
    pub points: Vec<Point>,
}

/// A filled outline.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Form {
    Polygon(Vec<Point>),
    Capsule { from: Point, to: Point, radius: f64 },
    Disc { centre: Point, radius: f64 },
}

/// A body: its part names its colour.
pub(super) type Body = (&'static str, Form);

/// A letter at what it names.
pub(super) struct Letter {
    pub letter: &'static str,
    pub kind: Stroke,
    pub wish: Wish,
}

pub(super) struct Marks {
    pub bodies: Vec<Body>,
    pub lines: Vec<Line>,
    pub letters: Vec<Letter>,
    pub joints: Vec<Point>,
    pub size: [f64; 2],
    /// Where the palm begins, if there is one.
    pub palm: Option<f64>,
}

/// From metres to pixels.
struct View {
    scale: f64,
    low: Point,
    height: f64,
}

impl View {
    fn to(&self, [x, y]: Point) -> Point {
        [MARGIN + (x - self.low[0]) * self.scale, self.height - BELOW - MARGIN - (y - self.low[1]) * self.scale]
    }
}

pub(super) fn marks(m: &Mechanism) -> Marks {
    let outlines = outlines(m);
    let view = view(m, &outlines);
    let mut made = Marks {
        bodies: bodies(m, &outlines, &view),
        lines: Vec::new(),
        letters: Vec::new(),
        joints: [[0.0; 2], m.joints.a12_m, m.joints.a13_m, m.joints.a22_m].map(|joint| view.to(joint)).into(),
        size: [WIDTH, view.height],
        palm: m.palm.then(|| view.to([0.0; 2])[1]),
    };
    links(m, &view, &mut made);
    angles(m, &view, &mut made);
    forces(m, &view, &mut made);
    dimensions(m, &view, &mut made);
    made
}

/// The shapes of l11, l12, l21 and l22 in the world.
fn outlines(m: &Mechanism) -> [(&'static str, Vec<Shape>); 4] {
    let (l, q) = (&m.lengths, &m.posture);
    let w = l.half_width_m;
    let placed = |position_m, angle_rad, corners: &[Point]| {
        let pose = Pose { position_m, angle_rad };
        Shape::Polygon { corners_m: corners.iter().map(|corner| pose.apply(*corner)).collect() }
    };
    let surface = |from_m, to_m| Shape::Capsule { from_m, to_m, radius_m: w };
    let distal = match tip_outline(l) {
        Ok(corners) => placed(m.joints.a22_m, q.q21_rad + q.q22_rad, &corners),
        Err(_) => surface(m.joints.a22_m, m.joints.a13_m),
    };
    [
        ("driver", vec![placed([0.0; 2], q.q11_rad, &link_outline(l.l11_m, w))]),
        ("coupler", vec![placed(m.joints.a12_m, q.q11_rad + q.q12_rad, &link_outline(l.l12_m, w))]),
        ("proximal", vec![surface([0.0; 2], m.joints.a22_m)]),
        ("distal", vec![distal, surface(m.joints.a22_m, m.joints.tip_m)]),
    ]
}

/// Corners of a box about a shape.
fn corners(shape: &Shape) -> Vec<Point> {
    let about = |[x, y]: Point, r: f64| [[x - r, y - r], [x + r, y + r]];
    match shape {
        Shape::Polygon { corners_m } => corners_m.clone(),
        Shape::Capsule { from_m, to_m, radius_m } => [about(*from_m, *radius_m), about(*to_m, *radius_m)].concat(),
        _ => Vec::new(),
    }
}

fn view(m: &Mechanism, outlines: &[(&'static str, Vec<Shape>); 4]) -> View {
    let mut points: Vec<Point> = outlines.iter().flat_map(|(_, shapes)| shapes.iter().flat_map(corners)).collect();
    if let Some(object) = m.object {
        let ([x, y], r) = (object.centre_m, object.radius_m);
        points.extend([[x - r, y - r], [x + r, y + r]]);
    }
    let of = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| points.iter().map(|p| p[axis]).fold(start, pick);
    let low = [of(0, f64::min, f64::INFINITY), of(1, f64::min, 0.0)];
    let high = [of(0, f64::max, f64::NEG_INFINITY), of(1, f64::max, 0.0)];
    let (wide, tall) = (high[0] - low[0], high[1] - low[1]);
    let scale = ((WIDTH - 2.0 * MARGIN) / wide).min((MOST_HEIGHT - 2.0 * MARGIN - BELOW) / tall);
    // What is narrow stands in the middle.
    let low = [low[0] - 0.5 * ((WIDTH - 2.0 * MARGIN) / scale - wide), low[1]];
    View { scale, low, height: tall * scale + 2.0 * MARGIN + BELOW }
}

/// The object, the other finger in outline, and this one.
fn bodies(m: &Mechanism, outlines: &[(&'static str, Vec<Shape>); 4], view: &View) -> Vec<Body> {
    let form = |shape: &Shape, mirror: Option<f64>| {
        let to = |[x, y]: Point| view.to(mirror.map_or([x, y], |about| [2.0 * about - x, y]));
        match shape {
            Shape::Polygon { corners_m } => Some(Form::Polygon(corners_m.iter().map(|c| to(*c)).collect())),
            Shape::Capsule { from_m, to_m, radius_m } => {
                Some(Form::Capsule { from: to(*from_m), to: to(*to_m), radius: radius_m * view.scale })
            }
            _ => None,
        }
    };
    let mut made = Vec::new();
    if let Some(object) = m.object {
        let mirror = Some(object.centre_m[0]);
        let shapes = outlines.iter().flat_map(|(_, shapes)| shapes);
        made.extend(shapes.filter_map(|shape| Some(("other", form(shape, mirror)?))));
        made.push(("object", Form::Disc { centre: view.to(object.centre_m), radius: object.radius_m * view.scale }));
    }
    // The proximal phalanx lies over the driven link at their joint, as on the page.
    for (part, shapes) in outlines {
        made.extend(shapes.iter().filter_map(|shape| Some((*part, form(shape, None)?))));
    }
    made
}

/// A label for a letter at a place, in a direction in the world.
fn letter(letter: &'static str, kind: Stroke, anchor: Point, [x, y]: Point) -> Letter {
    // Letters of a usual font are about 0.6 as wide as high.
    let width = 0.62 * LABEL_PX * letter.chars().count() as f64;
    Letter { letter, kind, wish: Wish { anchor, way: [x, -y], width, height: LABEL_PX } }
}

fn middle(a: Point, b: Point) -> Point {
    [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
}

fn towards(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

fn links(m: &Mechanism, view: &View, made: &mut Marks) {
    let j = &m.joints;
    let inside = middle(middle([0.0; 2], j.a12_m), middle(j.a13_m, j.a22_m));
    for (name, from, to) in [
        ("l11", [0.0; 2], j.a12_m),
        ("l12", j.a12_m, j.a13_m),
        ("l21", [0.0; 2], j.a22_m),
        ("l22", j.a22_m, j.a13_m),
        ("t22", j.a22_m, j.tip_m),
    ] {
        made.lines.push(Line { stroke: Stroke::Link, points: vec![view.to(from), view.to(to)] });
        let at = middle(from, to);
        // To the side that is away from the four bars.
        let normal = [from[1] - to[1], to[0] - from[0]];
        let side = ((at[0] - inside[0]) * normal[0] + (at[1] - inside[1]) * normal[1]).signum();
        made.letters.push(letter(name, Stroke::Link, view.to(at), normal.map(|k| side * k)));
    }
}

/// Angles, each from a line of reference, with radii that keep those of one joint apart.
fn angles(m: &Mechanism, view: &View, made: &mut Marks) {
    let (q, j) = (&m.posture, &m.joints);
    let arm = q.q21_rad + q.q22_rad;
    for (name, at, from, turn, radius, reference) in [
        ("q11", [0.0; 2], 0.0, q.q11_rad, 74.0, 96.0),
        ("q21", [0.0; 2], 0.0, q.q21_rad, 48.0, 0.0),
        ("q12", j.a12_m, q.q11_rad, q.q12_rad, 34.0, 62.0),
        ("q22", j.a22_m, q.q21_rad, q.q22_rad, 46.0, 66.0),
        ("φ22", j.a22_m, arm, m.lengths.phi22_rad, 28.0, 0.0),
    ] {
        let [x, y] = view.to(at);
        let on = |angle: f64, radius: f64| [x + radius * angle.cos(), y - radius * angle.sin()];
        if reference > 0.0 {
            made.lines.push(Line { stroke: Stroke::Reference, points: vec![[x, y], on(from, reference)] });
        }
        let turn = if turn.abs() > 2.0 * PI { turn % (2.0 * PI) } else { turn };
        let pieces = (turn.abs() / 0.05).ceil().max(2.0) as usize;
        let points = (0..=pieces).map(|k| on(from + turn * k as f64 / pieces as f64, radius)).collect();
        made.lines.push(Line { stroke: Stroke::Angle, points });
        // φ22 and q22 share the angle between the phalanges: each is named where the other is not.
        let named = from + if name == "φ22" { 0.75 } else { 0.5 } * turn;
        made.letters.push(letter(name, Stroke::Angle, on(named, radius), towards(named)));
    }
}

/// Normal forces of the object on the phalanges. Their length is not to scale.
fn forces(m: &Mechanism, view: &View, made: &mut Marks) {
    let Some(contacts) = &m.contacts else { return };
    for (name, (at, way)) in ["F21", "F22"].into_iter().zip(contacts) {
        let from = view.to(*at);
        let tip = [from[0] + 62.0 * way[0], from[1] - 62.0 * way[1]];
        made.lines.push(Line { stroke: Stroke::Force, points: vec![from, tip] });
        made.letters.push(letter(name, Stroke::Force, tip, *way));
    }
}

fn dimensions(m: &Mechanism, view: &View, made: &mut Marks) {
    let w = m.lengths.half_width_m;
    // Half the width, near the end of the proximal phalanx, on the side that is away from the object.
    let along = m.posture.q21_rad;
    let part = 0.8 * m.lengths.l21_m;
    let centre = [part * along.cos(), part * along.sin()];
    let way = towards(along - FRAC_PI_2);
    let edge = [centre[0] + w * way[0], centre[1] + w * way[1]];
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![view.to(centre), view.to(edge)] });
    made.letters.push(letter("w", Stroke::Dimension, view.to(edge), way));
    let Some(object) = m.object else { return };
    // The base: between the joint on the palm and the middle of the gripper.
    let y = view.height - 26.0;
    let (left, right) = (view.to(object.centre_m), view.to([0.0; 2]));
    made.lines.push(Line { stroke: Stroke::Reference, points: vec![left, [left[0], y + 6.0]] });
    made.lines.push(Line { stroke: Stroke::Reference, points: vec![right, [right[0], y + 6.0]] });
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![[left[0], y], [right[0], y]] });
    made.letters.push(letter("base", Stroke::Dimension, middle([left[0], y], [right[0], y]), [0.0, -1.0]));
    let rim = towards(0.75 * PI);
    let rim = view.to([0, 1].map(|k| object.centre_m[k] + object.radius_m * rim[k]));
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![left, rim] });
    made.letters.push(letter("radius", Stroke::Dimension, middle(left, rim), [0.5, 1.0]));
}
