//! Shapes, lines and texts as an SVG. Colours are those of the page, in both of its schemes; every text has a rim of the
//! ground's colour.

use std::fmt::Write;

use super::Linkage;
use super::marks::{Form, LABEL_PX, Line, Marks, Stroke, WIDTH};
use super::mechanism::Mechanism;
use super::place::{Point, placed};
use crate::plot::PICTURE_MARK;
use crate::scene::Scene;
use crate::wording::escaped;

/// Parts and their colours in light and dark, as in the style sheet of the page.
const FILLS: [(&str, &str, &str); 5] = [
    ("driver", "#b9c2cf", "#4c5766"),
    ("coupler", "#d3d9e2", "#3a4350"),
    ("proximal", "#a9d2ec", "#1f5678"),
    ("distal", "#f5c7a1", "#7d4316"),
    ("object", "#e3dccb", "#4a453a"),
];
/// Lines and texts by what they show: `k` lengths, `a` angles, `f` forces, `s` what is less important.
const INKS: [(&str, &str, &str); 4] = [
    ("k", "#1b1f26", "#eceff3"),
    ("a", "#005a9c", "#63b7f0"),
    ("f", "#b3261e", "#ff8078"),
    ("s", "#565e6b", "#a7b0bd"),
];
const GROUND: [&str; 2] = ["#ffffff", "#1b1f26"];
const PALM: [&str; 2] = ["#e4e7ec", "#262c35"];
/// A label farther from what it names than this gets a line to it.
const NEAR: f64 = 20.0;
/// A row of the table below.
const ROW: f64 = 24.0;

pub(super) fn svg(scene: &Scene, m: &Mechanism, marks: &Marks) -> Linkage {
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
    let height = drawing + 40.0 + ROW * rows as f64 + 12.0;

    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" role=\"img\" font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"{LABEL_PX}\">\n\
         <title>{}: the linkage {}, with the letters of scenes and results</title>\n{PICTURE_MARK}\n<style>\n{}</style>\n",
        escaped(&printable(&scene.name)),
        m.shown,
        style()
    );
    // Writing to a string cannot fail.
    let _ = writeln!(text, "<rect class=\"ground\" width=\"{width:.0}\" height=\"{height:.0}\"/>");
    if let Some(level) = marks.palm {
        let _ = writeln!(
            text,
            "<rect class=\"palm\" y=\"{level:.1}\" width=\"{width:.0}\" height=\"{:.1}\"/>",
            drawing - level
        );
    }
    for (part, form) in &marks.bodies {
        shape(&mut text, part, form);
    }
    for line in marks.lines.iter().filter(|line| line.stroke != Stroke::Force) {
        stroke(&mut text, line);
    }
    for [x, y] in &marks.joints {
        let _ = writeln!(text, "<circle class=\"joint lk\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>");
    }
    for line in marks.lines.iter().filter(|line| line.stroke == Stroke::Force) {
        stroke(&mut text, line);
    }
    let mut labels = Vec::new();
    for (&index, spot) in order.iter().zip(&spots) {
        let letter = &marks.letters[index];
        let [x, y] = spot.centre;
        let [ax, ay] = letter.wish.anchor;
        let gap = (ax - x).hypot(ay - y) - 0.5 * spot.height;
        if gap > NEAR {
            let part = 0.5 * spot.height / (ax - x).hypot(ay - y) + 0.05;
            let near = [x + part * (ax - x), y + part * (ay - y)];
            stroke(&mut text, &Line { stroke: Stroke::Leader, points: vec![near, [ax, ay]] });
        }
        let ink = ink(letter.kind);
        let _ = writeln!(text, "<text class=\"{ink} rim\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", letter.letter);
        labels.push((letter.letter, *spot));
    }
    legend(&mut text, &table, drawing, &format!("{}, {}", printable(&scene.name), m.shown));
    text.push_str("</svg>\n");
    Linkage { svg: text, labels, size: marks.size }
}

/// Names come from files: no control characters, and no more than fits.
fn printable(name: &str) -> String {
    let clean: String = name.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    match clean.chars().count() > 50 {
        true => clean.chars().take(49).chain(['…']).collect(),
        false => clean,
    }
}

fn style() -> String {
    let scheme = |k: usize| {
        let mut rules =
            format!(".ground {{ fill: {g}; }} .rim {{ stroke: {g}; }} .joint {{ fill: {g}; }}\n", g = GROUND[k]);
        let _ = writeln!(rules, ".palm {{ fill: {}; }}", PALM[k]);
        for (name, light, dark) in FILLS {
            let _ = writeln!(rules, ".{name} {{ fill: {}; }}", [light, dark][k]);
        }
        for (name, light, dark) in INKS {
            let colour = [light, dark][k];
            let _ = writeln!(
                rules,
                ".{name} {{ fill: {colour}; }} .l{name} {{ stroke: {colour}; }} .h{name} {{ fill: {colour}; }}"
            );
        }
        rules
    };
    format!(
        "text {{ text-anchor: middle; dominant-baseline: central; }}\n\
         .rim {{ paint-order: stroke; stroke-width: 4px; stroke-linejoin: round; }}\n\
         .row {{ text-anchor: start; }} .value {{ text-anchor: end; }}\n\
         .line {{ fill: none; }} .edge {{ stroke-width: 1.2; }} .other {{ fill: none; stroke-dasharray: 4 4; opacity: 0.7; }}\n\
         .joint {{ stroke-width: 1.6; }}\n{}@media (prefers-color-scheme: dark) {{\n{}}}\n",
        scheme(0),
        scheme(1)
    ) + ".other { fill: none; }\n"
}

fn ink(stroke: Stroke) -> &'static str {
    match stroke {
        Stroke::Link | Stroke::Dimension => "k",
        Stroke::Angle => "a",
        Stroke::Force => "f",
        Stroke::Reference | Stroke::Leader => "s",
    }
}

fn points(points: &[Point]) -> String {
    points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ")
}

fn shape(text: &mut String, part: &str, form: &Form) {
    let class = format!("class=\"{part} ls edge\"");
    let _ = match form {
        Form::Polygon(corners) => writeln!(text, "<polygon {class} points=\"{}\"/>", points(corners)),
        Form::Disc { centre: [x, y], radius } => {
            writeln!(text, "<circle {class} cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>")
        }
        Form::Capsule { from, to, radius } => {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let angle = dy.atan2(dx).to_degrees();
            let length = dx.hypot(dy) + 2.0 * radius;
            writeln!(
                text,
                "<rect {class} x=\"{:.1}\" y=\"{:.1}\" width=\"{length:.1}\" height=\"{:.1}\" rx=\"{radius:.1}\" \
                 transform=\"translate({:.1} {:.1}) rotate({angle:.2})\"/>",
                -radius,
                -radius,
                2.0 * radius,
                from[0],
                from[1]
            )
        }
    };
}

fn stroke(text: &mut String, line: &Line) {
    let ink = ink(line.stroke);
    let (width, dash, heads) = match line.stroke {
        Stroke::Link => (1.4, " stroke-dasharray=\"9 3 2 3\"", 0),
        Stroke::Reference => (1.2, " stroke-dasharray=\"3 3\"", 0),
        Stroke::Leader => (1.0, "", 0),
        Stroke::Dimension => (1.4, "", 2),
        Stroke::Angle => (1.8, "", 1),
        Stroke::Force => (4.0, "", 1),
    };
    let _ = writeln!(
        text,
        "<polyline class=\"line l{ink}\" stroke-width=\"{width}\"{dash} points=\"{}\"/>",
        points(&line.points)
    );
    let size = if line.stroke == Stroke::Force { 13.0 } else { 8.0 };
    let n = line.points.len();
    if n >= 2 && heads >= 1 {
        head(text, ink, line.points[n - 2], line.points[n - 1], size);
    }
    if n >= 2 && heads == 2 {
        head(text, ink, line.points[1], line.points[0], size);
    }
}

/// The head of an arrow; on a line that is shorter than two of them, a smaller one.
fn head(text: &mut String, ink: &str, from: Point, [x, y]: Point, size: f64) {
    let [dx, dy] = [x - from[0], y - from[1]];
    let length = dx.hypot(dy);
    if length < 1e-9 {
        return;
    }
    let [dx, dy] = [dx / length, dy / length];
    let corners = [
        [x, y],
        [x - size * dx - 0.4 * size * dy, y - size * dy + 0.4 * size * dx],
        [x - size * dx + 0.4 * size * dy, y - size * dy - 0.4 * size * dx],
    ];
    let _ = writeln!(text, "<polygon class=\"h{ink}\" points=\"{}\"/>", points(&corners));
}

/// A row of the table: a letter, what it is, and how much here.
type Row = (&'static str, &'static str, &'static str, String);

fn table(scene: &Scene, m: &Mechanism, free: bool) -> Vec<Row> {
    let (l, q) = (&m.lengths, &m.posture);
    let mm = |metres: f64| format!("{} mm", rounded(metres * 1e3));
    let deg = |radians: f64| format!("{}°", rounded(radians.to_degrees()));
    let mut rows: Vec<Row> = vec![
        ("l11", "k", "driven by the motor", mm(l.l11_m)),
        ("l12", "k", "coupler", mm(l.l12_m)),
        ("l21", "k", "proximal phalanx", mm(l.l21_m)),
        ("l22", "k", "arm of the distal body", mm(l.l22_m)),
        ("t22", "k", "distal phalanx (with l22)", mm(l.t22_m)),
        ("φ22", "a", "from the arm to t22", deg(l.phi22_rad)),
        ("w", "k", "half width of a link", mm(l.half_width_m)),
    ];
    if let Some(object) = scene.object() {
        rows.push(("base", "k", "from joint to middle", mm(-object.centre_m[0])));
        rows.push(("radius", "k", "of the object", mm(object.radius_m)));
    }
    rows.extend([
        ("q11", "a", "angle of l11", deg(q.q11_rad)),
        ("q21", "a", "angle of l21", deg(q.q21_rad)),
        ("q12", "a", "of l12 against l11", deg(q.q12_rad)),
        ("q22", "a", "of l22 against l21", deg(q.q22_rad)),
    ]);
    if !free {
        rows.push(("F21", "f", "object on proximal phalanx", String::new()));
        rows.push(("F22", "f", "object on distal phalanx", String::new()));
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

fn legend(text: &mut String, table: &[Row], top: f64, title: &str) {
    let _ = writeln!(
        text,
        "<text class=\"s row\" x=\"20\" y=\"{:.1}\" font-size=\"14\">{}</text>",
        top + 20.0,
        escaped(title)
    );
    let rows = table.len().div_ceil(2);
    for (index, (letter, ink, what, value)) in table.iter().enumerate() {
        let x = 20.0 + (index / rows) as f64 * (0.5 * WIDTH);
        let y = top + 40.0 + ROW * ((index % rows) as f64 + 0.5);
        let _ = writeln!(text, "<text class=\"{ink} row\" x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"15\">{letter}</text>");
        let _ =
            writeln!(text, "<text class=\"k row\" x=\"{:.1}\" y=\"{y:.1}\" font-size=\"14\">{what}</text>", x + 60.0);
        let _ = writeln!(
            text,
            "<text class=\"k value\" x=\"{:.1}\" y=\"{y:.1}\" font-size=\"14\">{value}</text>",
            x + 0.5 * WIDTH - 30.0
        );
    }
}
