//! What each letter names, and the lines that show it.

use std::f64::consts::{FRAC_PI_2, PI};

use super::mechanism::Mechanism;
use super::place::{Point, Wish};
use crate::drawing::{Drawing, poses_in};
use crate::numeric::plane::{add, scale};
use crate::plot::outline::{MARGIN, View, mirrored, outlines};
use crate::plot::svg::Paint;
use crate::plot::theme::{Colour, OBJECT, SOFT};
use crate::scene::Scene;
use crate::shape::round;

/// Width of the picture, and most height of the drawing in it.
const WIDTH: f64 = 760.0;
const MOST_HEIGHT: f64 = 520.0;
/// Room around the view for labels, and below it for the base.
const ROOM: f64 = 20.0;
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

/// An outline and how it is drawn.
pub(super) type Body = (Vec<Point>, Paint);

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

pub(super) fn marks(scene: &Scene, m: &Mechanism) -> Marks {
    let outlines = outlines(&Drawing::of(scene).bodies, &poses_in(scene, &[m.posture]));
    let view = view(m, &outlines);
    let mut made = Marks {
        bodies: bodies(m, &outlines, &view),
        lines: Vec::new(),
        letters: Vec::new(),
        joints: [[0.0; 2], m.joints.a12_m, m.joints.a13_m, m.joints.a22_m].map(|joint| view.pixel(joint)).into(),
        size: [WIDTH, view.height()],
        palm: m.palm.then(|| view.pixel([0.0; 2])[1]),
    };
    links(m, &view, &mut made);
    angles(m, &view, &mut made);
    forces(m, &view, &mut made);
    dimensions(m, &view, &mut made);
    made
}

/// A view of the finger, the object and the other finger; what is narrow stands in the middle.
fn view(m: &Mechanism, outlines: &[(Vec<Point>, Colour)]) -> View {
    let mut points: Vec<Point> = outlines.iter().flat_map(|(outline, _)| outline.clone()).chain([[0.0; 2]]).collect();
    if let Some(object) = m.object {
        points.extend(mirrored(&points.clone(), object.centre_m[0]));
    }
    let View { low, high, scale } = View::within(&points, [WIDTH - 2.0 * ROOM, MOST_HEIGHT - 2.0 * ROOM - BELOW]);
    let aside = 0.5 * ((WIDTH - 2.0 * MARGIN) / scale - (high[0] - low[0]));
    let [above, below] = [ROOM, ROOM + BELOW].map(|pixels| pixels / scale);
    View { low: [low[0] - aside, low[1] - below], high: [high[0] + aside, high[1] + above], scale }
}

/// The object and the links; the other finger, in outline, behind them.
fn bodies(m: &Mechanism, outlines: &[(Vec<Point>, Colour)], view: &View) -> Vec<Body> {
    let pixels = |outline: &[Point]| outline.iter().map(|point| view.pixel(*point)).collect::<Vec<Point>>();
    let other = Paint::line(SOFT, 1.2).dashed("4 4").faded(0.7);
    let links = outlines.iter().filter(|(_, fill)| *fill != OBJECT);
    let others = m
        .object
        .iter()
        .flat_map(|object| links.clone().map(|(outline, _)| (pixels(&mirrored(outline, object.centre_m[0])), other)));
    others.chain(outlines.iter().map(|(outline, fill)| (pixels(outline), Paint::fill(*fill).with_edge(SOFT)))).collect()
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
        made.lines.push(Line { stroke: Stroke::Link, points: vec![view.pixel(from), view.pixel(to)] });
        let at = middle(from, to);
        // To the side that is away from the four bars.
        let normal = [from[1] - to[1], to[0] - from[0]];
        let side = ((at[0] - inside[0]) * normal[0] + (at[1] - inside[1]) * normal[1]).signum();
        made.letters.push(letter(name, Stroke::Link, view.pixel(at), normal.map(|k| side * k)));
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
        let [x, y] = view.pixel(at);
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
        let from = view.pixel(*at);
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
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![view.pixel(centre), view.pixel(edge)] });
    made.letters.push(letter("w", Stroke::Dimension, view.pixel(edge), way));
    let Some(object) = m.object else { return };
    // The base: between the joint on the palm and the middle of the gripper.
    let y = made.size[1] - 26.0;
    let (left, right) = (view.pixel(object.centre_m), view.pixel([0.0; 2]));
    made.lines.push(Line { stroke: Stroke::Reference, points: vec![left, [left[0], y + 6.0]] });
    made.lines.push(Line { stroke: Stroke::Reference, points: vec![right, [right[0], y + 6.0]] });
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![[left[0], y], [right[0], y]] });
    made.letters.push(letter("base", Stroke::Dimension, middle([left[0], y], [right[0], y]), [0.0, -1.0]));
    let Some(radius_m) = round(&object.shape) else { return };
    let rim = view.pixel(add(object.centre_m, scale(towards(0.75 * PI), radius_m)));
    made.lines.push(Line { stroke: Stroke::Dimension, points: vec![left, rim] });
    made.letters.push(letter("radius", Stroke::Dimension, middle(left, rim), [0.5, 1.0]));
}
