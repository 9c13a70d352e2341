//! The mechanism with its letters as a picture, and the table of what they are; every letter has a rim of the ground's colour.

use super::Linkage;
use super::marks::{LABEL_PX, Line, Marks, Stroke};
use super::mechanism::Mechanism;
use super::place::{Point, placed};
use crate::plot::canvas::{around, fitted, text_width, words_from, words_to};
use crate::plot::outline::head;
use crate::plot::svg::{Paint, Svg, Words, document};
use crate::plot::theme::{ANGLE, Colour, FORCE, INK, PALM, PAPER, SOFT};
use crate::scene::Scene;
use crate::shape::sizes;

/// A label farther from what it names than this gets a line to it.
const NEAR: f64 = 20.0;
/// A row of the table below.
const ROW: f64 = 24.0;

pub(super) fn draw(scene: &Scene, m: &Mechanism, marks: &Marks) -> Linkage {
    let [width, drawing] = marks.size;
    // Forces and lengths first: where they can be is narrow, an angle can be named anywhere along its arc.
    let mut order: Vec<usize> = (0..marks.letters.len()).collect();
    order.sort_by_key(|&index| marks.letters[index].kind == Stroke::Angle);
    let wishes: Vec<_> = order.iter().map(|&index| marks.letters[index].wish.clone()).collect();
    let lines: Vec<[Point; 2]> =
        marks.lines.iter().flat_map(|line| line.points.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    let spots = placed(&wishes, &lines, marks.size);
    let table = table(scene, m, !marks.letters.iter().any(|letter| letter.letter == "F21"));
    let rows = table.len().div_ceil(2);
    let height = (drawing + 40.0 + ROW * rows as f64 + 12.0).round();
    let title = format!("{}: the linkage {}, with the letters of scenes and results", scene.name, m.shown);
    let svg = document([width, height], &title, |svg| {
        if let Some(level) = marks.palm {
            svg.rectangle([[0.0, level], [width, drawing]], Paint::fill(PALM));
        }
        for (outline, paint) in &marks.bodies {
            svg.polygon(outline, *paint);
        }
        for line in marks.lines.iter().filter(|line| line.stroke != Stroke::Force) {
            stroke(svg, line);
        }
        for joint in &marks.joints {
            svg.circle(*joint, 4.5, Paint { stroke: Some((INK, 1.6)), ..Paint::fill(PAPER) });
        }
        for line in marks.lines.iter().filter(|line| line.stroke == Stroke::Force) {
            stroke(svg, line);
        }
        for (&index, spot) in order.iter().zip(&spots) {
            let letter = &marks.letters[index];
            let [x, y] = spot.centre;
            let [ax, ay] = letter.wish.anchor;
            let gap = (ax - x).hypot(ay - y) - 0.5 * spot.height;
            if gap > NEAR {
                let part = 0.5 * spot.height / (ax - x).hypot(ay - y) + 0.05;
                let near = [x + part * (ax - x), y + part * (ay - y)];
                stroke(svg, &Line { stroke: Stroke::Leader, points: vec![near, [ax, ay]] });
            }
            svg.words(letter.letter, spot.centre, Words { rim: true, ..around(LABEL_PX, ink(letter.kind)) });
        }
        // Its outline is that of its mass: the triangle of its joints and its tip, widened by w, whose corners are sharp.
        let text = format!("{}, {}; sharp corners beyond t22 and l22 are mass, and never touch", scene.name, m.shown);
        fitted(svg, &text, [20.0, drawing + 20.0], 14.0, width - 40.0);
        for (index, (letter, ink, what, value)) in table.iter().enumerate() {
            let x = 20.0 + (index / rows) as f64 * (0.5 * width);
            let y = drawing + 40.0 + ROW * ((index % rows) as f64 + 0.5);
            words_from(svg, letter, [x, y], 15.0, *ink);
            let right = x + 0.5 * width - 40.0;
            fitted(svg, what, [x + 60.0, y], 14.0, right - x - 72.0 - text_width(value, 14.0));
            words_to(svg, value, [right, y], 14.0, INK);
        }
    });
    let labels = order.iter().zip(&spots).map(|(&index, spot)| (marks.letters[index].letter, *spot)).collect();
    Linkage { svg, labels, size: marks.size }
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
    if let (1.., [.., before, last]) = (heads, &line.points[..]) {
        head(svg, *before, *last, size, ink);
    }
    if let (2, [first, second, ..]) = (heads, &line.points[..]) {
        head(svg, *second, *first, size, ink);
    }
}

/// A row of the table: a letter, what it is, and how much here.
type Row = (&'static str, Colour, &'static str, String);

fn table(scene: &Scene, m: &Mechanism, free: bool) -> Vec<Row> {
    let (l, q) = (&m.lengths, &m.posture);
    let mm = |metres: f64| format!("{} mm", rounded(metres * 1e3));
    let deg = |radians: f64| format!("{}°", rounded(radians.to_degrees()));
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
        let sizes = sizes(&object.shape);
        rows.extend(sizes.map(|(name, size_m)| (name, INK, "of the object", mm(size_m))));
    }
    rows.extend([
        ("q11", ANGLE, "angle of l11", deg(q.q11_rad)),
        ("q21", ANGLE, "angle of l21", deg(q.q21_rad)),
        ("q12", ANGLE, "of l12 against l11", deg(q.q12_rad)),
        ("q22", ANGLE, "of l22 against l21", deg(q.q22_rad)),
    ]);
    if !free {
        rows.push(("F21", FORCE, "object on proximal phalanx", String::new()));
        rows.push(("F22", FORCE, "object on distal phalanx", String::new()));
    }
    rows
}

/// Four digits, and no zeros behind the last that counts.
fn rounded(value: f64) -> String {
    let whole = value.abs().max(1e-3).log10().floor() as i32;
    let text = format!("{value:.*}", usize::try_from(3 - whole).unwrap_or(0).min(4));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_string() } else { text.replace('-', "−") }
}
