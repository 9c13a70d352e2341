//! Drawing of a finger with the symbols used in scenes and results, for light and dark backgrounds, and a table of their
//! meanings. Symbols are outlined in the background colour and do not overlap.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::canvas::{centred_style, fitted_text, text_left_of, text_right_of, text_width};
use super::outline::{MARGIN, Point, View, arrow_head, filled_outline, mirrored, outlines};
use super::svg::{Paint, Pixel, Svg, TextStyle, document};
use super::theme::{ANGLE, Colour, FORCE, INK, OBJECT, PALM, PAPER, SOFT};
use crate::drawing::Drawing;
use crate::format::ColumnFormat;
use crate::gripper::{FinalPosture, Joints, Lengths, Posture, close_loop, final_posture, joint_positions};
use crate::numeric::plane::{add, dot, scale, sub};
use crate::scene::Scene;
use crate::shape::{PlacedShape, circle_radius, dimensions};

// Size of the drawing, its margins for labels and, below, for the dimension of the base; row of the table; text size.
const WIDTH: f64 = 760.0;
const MAX_HEIGHT: f64 = 520.0;
const VIEW_MARGIN: f64 = 20.0;
const BASE_MARGIN: f64 = 40.0;
const ROW_HEIGHT: f64 = 24.0;
const LABEL_PX: f64 = 17.0;
/// Labels with a larger distance from their anchor get a leader line.
const MAX_LABEL_DISTANCE: f64 = 20.0;
/// Candidate distances between the anchor and the edge of the label.
const DISTANCES: [f64; 8] = [5.0, 9.0, 14.0, 21.0, 30.0, 42.0, 58.0, 78.0];
/// Number of candidate directions from the anchor to the label.
const DIRECTIONS: usize = 32;
/// Minimum gap between two labels.
const LABEL_GAP: f64 = 3.0;

/// Drawing of a linkage. All lengths are in pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    pub svg: String,
    /// The symbols in the drawing, each with its label box.
    pub labels: Vec<(&'static str, LabelBox)>,
    /// Width and height of the drawing, without the table below it.
    pub size: [f64; 2],
}

/// Draws the linkage of a finger in its final grasp, or at its start if there is no final grasp.
pub fn linkage(scene: &Scene) -> Linkage {
    let linkage = &scene.finger().linkage;
    let object = scene.object().map(|object| object.placed());
    let grasp =
        object.and_then(|object| Some((object, final_posture(&linkage.lengths, linkage.assembly, object).ok()?)));
    let initial = &scene.finger().initial;
    let (posture, posture_name) = match &grasp {
        Some((_, end)) => (end.posture, "at its grasp"),
        None => {
            let start = close_loop(&linkage.lengths, linkage.assembly, initial.q11_rad, initial.q21_rad);
            // A scene whose initial linkage does not close is rejected elsewhere.
            let upright =
                Posture { q11_rad: 0.0, q21_rad: FRAC_PI_2, q12_rad: FRAC_PI_2, q22_rad: -linkage.lengths.phi22_rad };
            (start.unwrap_or(upright), "at its start")
        }
    };
    let drawing = Drawing::from_scene(scene);
    let outlines = outlines(&drawing.bodies, &drawing.poses_for_postures(scene, &[posture]));
    let mirror_x = object.map(|object| object.centre_m[0]);
    let view = view(&outlines, mirror_x);
    let size @ [width, drawing] = [WIDTH, view.height()];
    let joints = joint_positions(&linkage.lengths, &posture);
    let mut sketch = Sketch { lengths: linkage.lengths, posture, joints, view, lines: Vec::new(), labels: Vec::new() };
    sketch.add_links();
    sketch.add_angles();
    if let Some((object, end)) = &grasp {
        sketch.add_forces(object, end);
    }
    sketch.add_dimensions(object);
    // Forces and lengths are placed first because they have less space; the label of an angle may be anywhere along its
    // arc.
    sketch.labels.sort_by_key(|label| label.stroke == Stroke::Angle);
    let Sketch { joints, view, lines, labels, .. } = sketch;
    let segments: Vec<[Pixel; 2]> =
        lines.iter().flat_map(|(_, points)| points.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    let boxes = place_labels(&labels, &segments, size);
    let table = table(scene, &posture, grasp.is_some());
    let rows = table.len().div_ceil(2);
    let height = (drawing + 40.0 + ROW_HEIGHT * rows as f64 + 12.0).round();
    let title = format!("{}: the linkage {posture_name}, with the symbols of scenes and results", scene.name);
    let svg = document([width, height], &title, |svg| {
        if scene.hand.palm.is_some() {
            svg.rectangle([[0.0, view.pixel([0.0; 2])[1]], [width, drawing]], Paint::fill(PALM));
        }
        for (outline, _) in outlines.iter().filter(|(_, fill)| *fill != OBJECT) {
            let other = mirror_x.map(|x| mirrored(outline, x)).unwrap_or_default();
            filled_outline(svg, &view, &other, Paint::line(SOFT, 1.2).dashed("4 4").faded(0.7));
        }
        for (outline, fill) in &outlines {
            filled_outline(svg, &view, outline, Paint::fill(*fill).with_edge(SOFT));
        }
        let (forces, others): (Vec<_>, Vec<_>) = lines.iter().partition(|(stroke, _)| *stroke == Stroke::Force);
        others.iter().for_each(|(stroke, points)| draw_line(svg, *stroke, points));
        for joint in [[0.0; 2], joints.a12_m, joints.a13_m, joints.a22_m] {
            svg.circle(view.pixel(joint), 4.5, Paint { stroke: Some((INK, 1.6)), ..Paint::fill(PAPER) });
        }
        forces.iter().for_each(|(stroke, points)| draw_line(svg, *stroke, points));
        for (label, LabelBox { centre: [x, y], height, .. }) in labels.iter().zip(&boxes) {
            let [ax, ay] = label.anchor;
            let distance = (ax - x).hypot(ay - y);
            if distance - 0.5 * height > MAX_LABEL_DISTANCE {
                let part = 0.5 * height / distance + 0.05;
                draw_line(svg, Stroke::Leader, &[[x + part * (ax - x), y + part * (ay - y)], [ax, ay]]);
            }
            let style = TextStyle { has_halo: true, ..centred_style(LABEL_PX, ink(label.stroke)) };
            svg.text(label.symbol, [*x, *y], style);
        }
        // The outline of the distal body encloses its mass: the triangle of its joints and its tip, widened by w.
        let text = format!("{}, {posture_name}; sharp corners beyond t22 and l22 have mass but no contact", scene.name);
        fitted_text(svg, &text, [20.0, drawing + 20.0], 14.0, width - 40.0);
        for (index, (symbol, ink, description, value)) in table.iter().enumerate() {
            let x = 20.0 + (index / rows) as f64 * (0.5 * width);
            let y = drawing + 40.0 + ROW_HEIGHT * ((index % rows) as f64 + 0.5);
            text_right_of(svg, symbol, [x, y], 15.0, *ink);
            let right = x + 0.5 * width - 40.0;
            fitted_text(svg, description, [x + 60.0, y], 14.0, right - x - 72.0 - text_width(value, 14.0));
            text_left_of(svg, value, [right, y], 14.0, INK);
        }
    });
    Linkage { svg, labels: labels.iter().map(|label| label.symbol).zip(boxes).collect(), size }
}

/// Creates a view of the finger, the object and the other finger; a narrow drawing is centred.
fn view(outlines: &[(Vec<Point>, Colour)], mirror_x: Option<f64>) -> View {
    let mut points: Vec<Point> = outlines.iter().flat_map(|(outline, _)| outline.clone()).chain([[0.0; 2]]).collect();
    points.extend(mirror_x.map_or_else(Vec::new, |x| mirrored(&points, x)));
    let View { low, high, scale } =
        View::within_size(&points, [WIDTH - 2.0 * VIEW_MARGIN, MAX_HEIGHT - 2.0 * VIEW_MARGIN - BASE_MARGIN]);
    let side_margin = 0.5 * ((WIDTH - 2.0 * MARGIN) / scale - (high[0] - low[0]));
    let [above, below] = [VIEW_MARGIN, VIEW_MARGIN + BASE_MARGIN].map(|pixels| pixels / scale);
    View { low: [low[0] - side_margin, low[1] - below], high: [high[0] + side_margin, high[1] + above], scale }
}

/// Kind of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stroke {
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

fn ink(stroke: Stroke) -> Colour {
    match stroke {
        Stroke::Link | Stroke::Dimension => INK,
        Stroke::Angle => ANGLE,
        Stroke::Force => FORCE,
        Stroke::Reference | Stroke::Leader => SOFT,
    }
}

fn draw_line(svg: &mut Svg, stroke: Stroke, points: &[Pixel]) {
    let (width, dash, heads, head_size) = match stroke {
        Stroke::Link => (1.4, "9 3 2 3", 0, 0.0),
        Stroke::Reference => (1.2, "3 3", 0, 0.0),
        Stroke::Leader => (1.0, "", 0, 0.0),
        Stroke::Dimension => (1.4, "", 2, 8.0),
        Stroke::Angle => (1.8, "", 1, 8.0),
        Stroke::Force => (4.0, "", 1, 13.0),
    };
    svg.polyline(points, Paint::line(ink(stroke), width).dashed(dash));
    if let (1.., [.., second_last, last]) = (heads, points) {
        arrow_head(svg, *second_last, *last, head_size, ink(stroke));
    }
    if let (2, [first, second, ..]) = (heads, points) {
        arrow_head(svg, *second, *first, head_size, ink(stroke));
    }
}

/// The finger, and the lines and labels drawn on it, in pixels.
struct Sketch {
    lengths: Lengths,
    posture: Posture,
    joints: Joints,
    view: View,
    lines: Vec<(Stroke, Vec<Pixel>)>,
    labels: Vec<Label>,
}

impl Sketch {
    fn line(&mut self, stroke: Stroke, points: impl Into<Vec<Pixel>>) {
        self.lines.push((stroke, points.into()));
    }

    /// Adds a label with an anchor in pixels and a preferred direction in world coordinates.
    fn label(&mut self, symbol: &'static str, stroke: Stroke, anchor: Pixel, [x, y]: Point) {
        self.labels.push(Label { symbol, stroke, anchor, direction: [x, -y] });
    }

    fn add_links(&mut self) {
        let Joints { a12_m, a13_m, a22_m, tip_m, .. } = self.joints;
        let interior_point = middle(middle([0.0; 2], a12_m), middle(a13_m, a22_m));
        for (name, from, to) in [
            ("l11", [0.0; 2], a12_m),
            ("l12", a12_m, a13_m),
            ("l21", [0.0; 2], a22_m),
            ("l22", a22_m, a13_m),
            ("t22", a22_m, tip_m),
        ] {
            self.line(Stroke::Link, [self.view.pixel(from), self.view.pixel(to)]);
            let midpoint = middle(from, to);
            // The normal points to the outer side of the four-bar linkage.
            let normal = [from[1] - to[1], to[0] - from[0]];
            let side = dot(sub(midpoint, interior_point), normal).signum();
            self.label(name, Stroke::Link, self.view.pixel(midpoint), scale(normal, side));
        }
    }

    /// Adds angles with their reference lines, with different radii at the same joint.
    fn add_angles(&mut self) {
        let (q, j) = (self.posture, self.joints);
        let arm = q.q21_rad + q.q22_rad;
        for (name, joint, from, turn_angle, radius, reference) in [
            ("q11", [0.0; 2], 0.0, q.q11_rad, 74.0, 96.0),
            ("q21", [0.0; 2], 0.0, q.q21_rad, 48.0, 0.0),
            ("q12", j.a12_m, q.q11_rad, q.q12_rad, 34.0, 62.0),
            ("q22", j.a22_m, q.q21_rad, q.q22_rad, 46.0, 66.0),
            ("φ22", j.a22_m, arm, self.lengths.phi22_rad, 28.0, 0.0),
        ] {
            let [x, y] = self.view.pixel(joint);
            let point_on_arc = |angle: f64, radius: f64| [x + radius * angle.cos(), y - radius * angle.sin()];
            if reference > 0.0 {
                self.line(Stroke::Reference, [[x, y], point_on_arc(from, reference)]);
            }
            let turn_angle = if turn_angle.abs() > 2.0 * PI { turn_angle % (2.0 * PI) } else { turn_angle };
            let pieces = (turn_angle.abs() / 0.05).ceil().max(2.0) as usize;
            let points = (0..=pieces).map(|k| point_on_arc(from + turn_angle * k as f64 / pieces as f64, radius));
            self.line(Stroke::Angle, points.collect::<Vec<_>>());
            // The arcs of φ22 and q22 overlap: label each where the other is absent.
            let label_angle = from + if name == "φ22" { 0.75 } else { 0.5 } * turn_angle;
            self.label(name, Stroke::Angle, point_on_arc(label_angle, radius), unit_vector(label_angle));
        }
    }

    /// Adds the normal forces of the object on the phalanges, not to scale.
    fn add_forces(&mut self, object: &PlacedShape, end: &FinalPosture) {
        let Joints { a22_m, tip_m, .. } = self.joints;
        for (name, from, to, part_m, length_m) in [
            ("F21", [0.0; 2], a22_m, end.l_c21_m, self.lengths.l21_m),
            ("F22", a22_m, tip_m, end.l_c22_m, self.lengths.t22_m),
        ] {
            let outward = sub(add(from, scale(sub(to, from), part_m / length_m)), object.centre_m);
            let direction = outward.map(|k| k / outward[0].hypot(outward[1]));
            let contact = self.view.pixel(object.furthest_point_m(direction));
            let tip = [contact[0] + 62.0 * direction[0], contact[1] - 62.0 * direction[1]];
            self.line(Stroke::Force, [contact, tip]);
            self.label(name, Stroke::Force, tip, direction);
        }
    }

    fn add_dimensions(&mut self, object: Option<PlacedShape>) {
        // The half width, near the end of the proximal phalanx, on the side opposite to the object.
        let direction_rad = self.posture.q21_rad;
        let centre = scale(unit_vector(direction_rad), 0.8 * self.lengths.l21_m);
        let normal = unit_vector(direction_rad - FRAC_PI_2);
        let edge = self.view.pixel(add(centre, scale(normal, self.lengths.half_width_m)));
        self.line(Stroke::Dimension, [self.view.pixel(centre), edge]);
        self.label("w", Stroke::Dimension, edge, normal);
        let Some(object) = object else { return };
        // The base: distance between the joint on the palm and the middle of the gripper.
        let y = self.view.height() - 26.0;
        let (left, right) = (self.view.pixel(object.centre_m), self.view.pixel([0.0; 2]));
        self.line(Stroke::Reference, [left, [left[0], y + 6.0]]);
        self.line(Stroke::Reference, [right, [right[0], y + 6.0]]);
        self.line(Stroke::Dimension, [[left[0], y], [right[0], y]]);
        self.label("base", Stroke::Dimension, middle([left[0], y], [right[0], y]), [0.0, -1.0]);
        let Some(radius_m) = circle_radius(&object.shape) else { return };
        let rim_point = self.view.pixel(add(object.centre_m, scale(unit_vector(0.75 * PI), radius_m)));
        self.line(Stroke::Dimension, [left, rim_point]);
        self.label("radius", Stroke::Dimension, middle(left, rim_point), [0.5, 1.0]);
    }
}

fn middle(a: Point, b: Point) -> Point {
    scale(add(a, b), 0.5)
}

fn unit_vector(angle: f64) -> Point {
    [angle.cos(), angle.sin()]
}

/// A row of the table: symbol, colour, meaning and value.
type Row = (&'static str, Colour, &'static str, String);

fn table(scene: &Scene, q: &Posture, has_forces: bool) -> Vec<Row> {
    let l = &scene.finger().linkage.lengths;
    let (length, angle) = (ColumnFormat::for_column("l12_m"), ColumnFormat::for_column("trajectory_rad"));
    let mm = |length_m: f64| format!("{} mm", length.number(length_m, 4).replace('-', "−"));
    let deg = |angle_rad: f64| format!("{}°", angle.number(angle_rad, 4).replace('-', "−"));
    let mut rows: Vec<Row> = vec![
        ("l11", INK, "driven by the motor", mm(l.l11_m)),
        ("l12", INK, "coupler", mm(l.l12_m)),
        ("l21", INK, "proximal phalanx", mm(l.l21_m)),
        ("l22", INK, "arm of the distal body", mm(l.l22_m)),
        ("t22", INK, "distal phalanx (with l22)", mm(l.t22_m)),
        ("φ22", ANGLE, "from the arm to t22", deg(l.phi22_rad)),
        ("w", INK, "half width of a link", mm(l.half_width_m)),
    ];
    if let Some(object) = scene.object() {
        rows.push(("base", INK, "from joint to middle", mm(-object.centre_m[0])));
        let sizes = dimensions(&object.shape);
        rows.extend(sizes.map(|(name, size_m)| (name, INK, "of the object", mm(size_m))));
    }
    rows.extend([
        ("q11", ANGLE, "angle of l11", deg(q.q11_rad)),
        ("q21", ANGLE, "angle of l21", deg(q.q21_rad)),
        ("q12", ANGLE, "of l12 against l11", deg(q.q12_rad)),
        ("q22", ANGLE, "of l22 against l21", deg(q.q22_rad)),
    ]);
    if has_forces {
        rows.push(("F21", FORCE, "object on proximal phalanx", String::new()));
        rows.push(("F22", FORCE, "object on distal phalanx", String::new()));
    }
    rows
}

/// A label to be placed.
#[derive(Clone, Debug, PartialEq)]
struct Label {
    symbol: &'static str,
    stroke: Stroke,
    /// Point that the label refers to.
    anchor: Pixel,
    /// Preferred direction from the anchor; of any length but 0.
    direction: Pixel,
}

/// A placed label: its centre and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelBox {
    centre: Pixel,
    width: f64,
    height: f64,
}

impl LabelBox {
    fn bounds(&self, margin: f64) -> [f64; 4] {
        let [x, y] = self.centre;
        let (w, h) = (0.5 * self.width + margin, 0.5 * self.height + margin);
        [x - w, y - h, x + w, y + h]
    }

    /// Whether two labels are less than `margin` apart.
    pub fn overlaps(&self, other: &LabelBox, margin: f64) -> bool {
        let (a, b) = (self.bounds(margin), other.bounds(0.0));
        a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
    }

    /// Whether the label lies within a picture of this width and height.
    pub fn is_within(&self, [width, height]: [f64; 2]) -> bool {
        let [x0, y0, x1, y1] = self.bounds(0.0);
        x0 >= 0.0 && y0 >= 0.0 && x1 <= width && y1 <= height
    }

    /// Length of a line that the label covers.
    fn covered_length(&self, [from, to]: [Pixel; 2]) -> f64 {
        let [x0, y0, x1, y1] = self.bounds(1.0);
        let along = sub(to, from);
        // Line clipping by Liang and Barsky.
        let (mut low, mut high) = (0.0f64, 1.0f64);
        for (p, q) in
            [(-along[0], from[0] - x0), (along[0], x1 - from[0]), (-along[1], from[1] - y0), (along[1], y1 - from[1])]
        {
            if p == 0.0 && q < 0.0 {
                return 0.0;
            }
            if p < 0.0 {
                low = low.max(q / p);
            } else if p > 0.0 {
                high = high.min(q / p);
            }
        }
        (high - low).max(0.0) * along[0].hypot(along[1])
    }
}

/// Places labels one after the other: near their anchors, in the preferred direction, off the lines of the picture.
/// Labels do not overlap and stay within a picture of that size, unless no candidate satisfies this.
fn place_labels(labels: &[Label], lines: &[[Pixel; 2]], size: [f64; 2]) -> Vec<LabelBox> {
    let mut boxes: Vec<LabelBox> = Vec::with_capacity(labels.len());
    for Label { symbol, anchor, direction, .. } in labels {
        // Characters of common fonts are about 0.6 times as wide as high.
        let (width, height) = (0.62 * LABEL_PX * symbol.chars().count() as f64, LABEL_PX);
        let cost = |label_box: &LabelBox| {
            let overlap_count = boxes.iter().filter(|other| label_box.overlaps(other, LABEL_GAP)).count();
            let out = if label_box.is_within(size) { 0.0 } else { 1e6 };
            let covered_length_sum: f64 = lines.iter().map(|line| label_box.covered_length(*line)).sum();
            // Anchors of other labels must stay visible.
            let is_hidden = |[x, y]: Pixel| label_box.covered_length([[x, y], [x + 0.1, y]]) > 0.0;
            let hidden_anchors = labels.iter().filter(|other| is_hidden(other.anchor)).count();
            out + 1e5 * overlap_count as f64 + 4.0 * covered_length_sum + 40.0 * hidden_anchors as f64
        };
        let start = direction[1].atan2(direction[0]);
        let mut best: Option<(f64, LabelBox)> = None;
        for (distance, k) in DISTANCES.into_iter().flat_map(|distance| (0..DIRECTIONS).map(move |k| (distance, k))) {
            // Alternate to both sides of the preferred direction.
            let turn = (k.div_ceil(2)) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 };
            let turn_cost = 14.0 * ((turn.abs() / DIRECTIONS as f64) * 4.0);
            // The remaining terms of the cost are positive and expensive to evaluate.
            if best.as_ref().is_some_and(|(lowest_cost, _)| distance + turn_cost >= *lowest_cost) {
                continue;
            }
            let (sin, cos) = (start + turn * TAU / DIRECTIONS as f64).sin_cos();
            // The label is tangent to a circle about the anchor, from outside.
            let reach = distance + (0.5 * width * cos.abs()).max(0.5 * height * sin.abs());
            let label_box = LabelBox { centre: [anchor[0] + reach * cos, anchor[1] + reach * sin], width, height };
            let cost = cost(&label_box) + distance + turn_cost;
            if best.as_ref().is_none_or(|(lowest_cost, _)| cost < *lowest_cost) {
                best = Some((cost, label_box));
            }
        }
        boxes.extend(best.map(|(_, label_box)| label_box));
    }
    boxes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(anchor: Pixel) -> Label {
        Label { symbol: "l11", stroke: Stroke::Link, anchor, direction: [0.0, -1.0] }
    }

    #[test]
    fn labels_keep_their_direction_avoid_lines_and_stay_within_the_picture() {
        let boxes = place_labels(&[label([100.0, 100.0])], &[], [200.0, 200.0]);
        assert!((boxes[0].centre[0] - 100.0).abs() < 1e-9 && boxes[0].centre[1] < 92.0, "{boxes:?}");
        let line = [[0.0, 85.0], [200.0, 85.0]];
        let boxes = place_labels(&[label([100.0, 100.0]), label([100.0, 4.0])], &[line], [200.0, 200.0]);
        assert!(boxes[0].covered_length(line) == 0.0 && boxes[0].centre[1] > 85.0, "{boxes:?}");
        assert!(boxes[1].is_within([200.0, 200.0]), "{boxes:?}");
        // The covered length of a line across a label is its width plus the margins.
        let across = LabelBox { centre: [50.0, 85.0], width: 30.0, height: 16.0 };
        assert!((across.covered_length(line) - 32.0).abs() < 1e-9, "{}", across.covered_length(line));
    }
}
