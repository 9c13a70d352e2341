//! Draws the mechanism with its symbols and a table of their meanings. Symbols are outlined in the background colour.

use super::Linkage;
use super::annotations::{Annotations, LABEL_PX, Line, Stroke};
use super::label_placement::{Point, place_labels};
use super::mechanism::Mechanism;
use crate::format::Quantity;
use crate::plot::canvas::{centred_style, fitted_text, text_left_of, text_right_of, text_width};
use crate::plot::outline::arrow_head;
use crate::plot::svg::{Paint, Svg, TextStyle, document};
use crate::plot::theme::{ANGLE, Colour, FORCE, INK, PALM, PAPER, SOFT};
use crate::scene::Scene;
use crate::shape::dimensions;

/// Labels with a larger distance from their anchor get a leader line.
const MAX_LABEL_DISTANCE: f64 = 20.0;
/// Height of a row of the table below the drawing.
const ROW_HEIGHT: f64 = 24.0;

pub(super) fn draw(scene: &Scene, m: &Mechanism, annotations: &Annotations) -> Linkage {
    let [width, drawing] = annotations.size;
    // Forces and lengths are placed first because they have less space; the label of an angle may be anywhere along its
    // arc.
    let mut order: Vec<usize> = (0..annotations.labels.len()).collect();
    order.sort_by_key(|&index| annotations.labels[index].kind == Stroke::Angle);
    let requests: Vec<_> = order.iter().map(|&index| annotations.labels[index].request.clone()).collect();
    let lines: Vec<[Point; 2]> =
        annotations.lines.iter().flat_map(|line| line.points.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    let boxes = place_labels(&requests, &lines, annotations.size);
    let table = table(scene, m, !annotations.labels.iter().any(|label| label.symbol == "F21"));
    let rows = table.len().div_ceil(2);
    let height = (drawing + 40.0 + ROW_HEIGHT * rows as f64 + 12.0).round();
    let title = format!("{}: the linkage {}, with the symbols of scenes and results", scene.name, m.posture_name);
    let svg = document([width, height], &title, |svg| {
        if let Some(level) = annotations.palm {
            svg.rectangle([[0.0, level], [width, drawing]], Paint::fill(PALM));
        }
        for (outline, paint) in &annotations.bodies {
            svg.polygon(outline, *paint);
        }
        for line in annotations.lines.iter().filter(|line| line.stroke != Stroke::Force) {
            stroke(svg, line);
        }
        for joint in &annotations.joints {
            svg.circle(*joint, 4.5, Paint { stroke: Some((INK, 1.6)), ..Paint::fill(PAPER) });
        }
        for line in annotations.lines.iter().filter(|line| line.stroke == Stroke::Force) {
            stroke(svg, line);
        }
        for (&index, label_box) in order.iter().zip(&boxes) {
            let label = &annotations.labels[index];
            let [x, y] = label_box.centre;
            let [ax, ay] = label.request.anchor;
            let gap = (ax - x).hypot(ay - y) - 0.5 * label_box.height;
            if gap > MAX_LABEL_DISTANCE {
                let part = 0.5 * label_box.height / (ax - x).hypot(ay - y) + 0.05;
                let leader_end = [x + part * (ax - x), y + part * (ay - y)];
                stroke(svg, &Line { stroke: Stroke::Leader, points: vec![leader_end, [ax, ay]] });
            }
            let style = TextStyle { has_halo: true, ..centred_style(LABEL_PX, ink(label.kind)) };
            svg.text(label.symbol, label_box.centre, style);
        }
        // The outline of the distal body encloses its mass: the triangle of its joints and its tip, widened by w.
        let text =
            format!("{}, {}; sharp corners beyond t22 and l22 have mass but no contact", scene.name, m.posture_name);
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
    let labels =
        order.iter().zip(&boxes).map(|(&index, label_box)| (annotations.labels[index].symbol, *label_box)).collect();
    Linkage { svg, labels, size: annotations.size }
}

fn ink(stroke: Stroke) -> Colour {
    match stroke {
        Stroke::Link | Stroke::Dimension => INK,
        Stroke::Angle => ANGLE,
        Stroke::Force => FORCE,
        Stroke::Reference | Stroke::Leader => SOFT,
    }
}

fn stroke(svg: &mut Svg, line: &Line) {
    let ink = ink(line.stroke);
    let (width, dash, heads) = match line.stroke {
        Stroke::Link => (1.4, "9 3 2 3", 0),
        Stroke::Reference => (1.2, "3 3", 0),
        Stroke::Leader => (1.0, "", 0),
        Stroke::Dimension => (1.4, "", 2),
        Stroke::Angle => (1.8, "", 1),
        Stroke::Force => (4.0, "", 1),
    };
    svg.polyline(&line.points, Paint::line(ink, width).dashed(dash));
    let size = if line.stroke == Stroke::Force { 13.0 } else { 8.0 };
    if let (1.., [.., second_last, last]) = (heads, &line.points[..]) {
        arrow_head(svg, *second_last, *last, size, ink);
    }
    if let (2, [first, second, ..]) = (heads, &line.points[..]) {
        arrow_head(svg, *second, *first, size, ink);
    }
}

/// A row of the table: symbol, colour, meaning and value.
type Row = (&'static str, Colour, &'static str, String);

fn table(scene: &Scene, m: &Mechanism, has_no_forces: bool) -> Vec<Row> {
    let (l, q) = (&m.lengths, &m.posture);
    let (length, angle) = (Quantity::for_column("l12_m"), Quantity::for_column("trajectory_rad"));
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
    if !has_no_forces {
        rows.push(("F21", FORCE, "object on proximal phalanx", String::new()));
        rows.push(("F22", FORCE, "object on distal phalanx", String::new()));
    }
    rows
}
