//! What pictures are made of: titles, frames with axes, lines and marks on them, legends beside them, boxes and words.

use super::axis::Axis;
use super::svg::{Paint, Path, Pixel, Side, Svg, TEXT_SIZE, Words, document};
use super::theme::{Colour, FAINT, INK, LINE, SOFT};

/// A place on a frame.
pub type Place = (f64, f64);

pub const WIDTH: f64 = 960.0;
/// Width of a legend beside a frame.
pub const LEGEND: f64 = 250.0;
/// Height of a title.
pub const HEAD: f64 = 40.0;
/// Height of the figures and the label below a frame, and of what is there without them.
pub const FOOT: f64 = 50.0;
const NO_FOOT: f64 = 12.0;
/// From the left of an area to its frame, and what is free above and on the right.
pub const LEFT: f64 = 86.0;
const ABOVE: f64 = 8.0;
const RIGHT: f64 = 12.0;
const TITLE_SIZE: f64 = 19.0;
const LINE_HEIGHT: f64 = 24.0;
/// Texts that are too wide become smaller down to this, then shorter.
const SMALLEST: f64 = 11.0;

/// What a picture is for: a sheet of its own, with its legend beside it, or a narrow column of a page, which has the title itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Sheet,
    Column,
}

impl Form {
    pub fn width(self) -> f64 {
        match self {
            Form::Sheet => WIDTH,
            Form::Column => 420.0,
        }
    }

    /// A picture of a height without its title.
    pub fn picture(self, title: &str, height: f64, draw: impl FnOnce(&mut Svg)) -> String {
        match self {
            Form::Sheet => picture(title, HEAD + height, draw),
            Form::Column => document([self.width(), height], title, draw),
        }
    }
}

/// The sign of a family of points, and how a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    Circle,
    Triangle,
    Square,
    Cross,
    Ring,
    /// Smaller ones, for hundreds of points, and one for thousands.
    SmallTriangle,
    SmallDot,
    Speck,
    Line {
        width: f64,
    },
    Pale {
        width: f64,
    },
}

pub const THIN: Mark = Mark::Line { width: 1.0 };

/// One line of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub mark: Mark,
    pub colour: Colour,
    pub text: String,
}

impl Entry {
    pub fn new(mark: Mark, colour: Colour, text: &str) -> Entry {
        Entry { mark, colour, text: text.to_string() }
    }
}

/// A part of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

/// A part of a picture that has axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub within: Area,
    pub x: Axis,
    pub y: Axis,
}

impl Frame {
    /// Where a place is; what is beyond an axis lies on its end.
    pub fn pixel(&self, (x, y): Place) -> Pixel {
        let part = |axis: &Axis, value: f64| ((value - axis.from) / (axis.to - axis.from)).clamp(0.0, 1.0);
        let Area { left, top, width, height } = self.within;
        [left + width * part(&self.x, x), top + height * (1.0 - part(&self.y, y))]
    }
}

/// A picture with its title; what is below the title is drawn from there.
pub fn picture(title: &str, height: f64, draw: impl FnOnce(&mut Svg)) -> String {
    document([WIDTH, height], title, |svg| {
        fitted(svg, title, [16.0, 24.0], TITLE_SIZE, WIDTH - 32.0);
        svg.moved([0.0, HEAD], draw);
    })
}

/// A picture of one frame with its legend beside it.
pub fn chart(
    title: &str,
    height: f64,
    x: &Axis,
    y: &Axis,
    draw: impl FnOnce(&mut Svg, &Frame) -> Vec<Entry>,
) -> String {
    picture(title, height, |svg| {
        let on = frame(svg, Area { left: 0.0, top: 0.0, width: WIDTH - LEGEND, height: height - HEAD }, x, y, true);
        let entries = draw(svg, &on);
        legend(svg, [WIDTH - LEGEND, 0.0], LEGEND, &entries);
    })
}

/// An empty frame with its axes; `foot` says whether the label and the figures of the horizontal axis are there.
pub fn frame(svg: &mut Svg, area: Area, x: &Axis, y: &Axis, foot: bool) -> Frame {
    let within = Area {
        left: area.left + LEFT,
        top: area.top + ABOVE,
        width: area.width - LEFT - RIGHT,
        height: area.height - ABOVE - if foot { FOOT } else { NO_FOOT },
    };
    let on = Frame { within, x: x.clone(), y: y.clone() };
    let upright = |at: f64| [on.pixel((at, y.from)), on.pixel((at, y.to))];
    let level = |at: f64| [on.pixel((x.from, at)), on.pixel((x.to, at))];
    for (colour, at, above) in [(FAINT, &x.between, &y.between), (LINE, &x.ticks, &y.ticks)] {
        let lines = at.iter().map(|at| upright(*at)).chain(above.iter().map(|at| level(*at)));
        svg.path(&lines.fold(Path::default(), |path, ends| path.through(&ends)), Paint::line(colour, 1.0));
    }
    let [corner, top, end] = [on.pixel((x.from, y.from)), on.pixel((x.from, y.to)), on.pixel((x.to, y.from))];
    let mut axes = Path::default().through(&[top, corner, end]);
    for [[left, top], _] in y.ticks.iter().map(|tick| level(*tick)) {
        axes = axes.through(&[[left - 5.0, top], [left, top]]);
    }
    for [[left, foot], _] in x.ticks.iter().map(|tick| upright(*tick)) {
        axes = axes.through(&[[left, foot], [left, foot + 5.0]]);
    }
    svg.path(&axes, Paint::line(SOFT, 1.0));
    for tick in &y.ticks {
        let [left, at] = level(*tick)[0];
        words_to(svg, &y.text(*tick), [left - 9.0, at], TEXT_SIZE, INK);
    }
    let middle = within.top + 0.5 * within.height;
    let size = fitting(&y.label, TEXT_SIZE, area.height - 8.0);
    svg.words(&y.label, [area.left + 16.0, middle], Words { upright: true, ..around(size, INK) });
    if foot {
        for tick in &x.ticks {
            let [at, below] = upright(*tick)[0];
            words(svg, &x.text(*tick), [at, below + 15.0], TEXT_SIZE, INK);
        }
        let size = fitting(&x.label, TEXT_SIZE, within.width);
        words(svg, &x.label, [within.left + 0.5 * within.width, corner[1] + 38.0], size, INK);
    }
    on
}

/// A line on a frame.
pub fn line(svg: &mut Svg, on: &Frame, points: impl IntoIterator<Item = Place>, mark: Mark, colour: Colour) {
    let pixels: Vec<Pixel> = points.into_iter().map(|at| on.pixel(at)).collect();
    svg.polyline(&pixels, stroke(mark, colour));
}

/// A line on a frame from one end of the vertical axis to the other.
pub fn upright(svg: &mut Svg, on: &Frame, x: f64, colour: Colour) {
    line(svg, on, [(x, on.y.from), (x, on.y.to)], THIN, colour);
}

/// A line on a frame from one end of the horizontal axis to the other.
pub fn level(svg: &mut Svg, on: &Frame, y: f64, mark: Mark, colour: Colour) {
    line(svg, on, [(on.x.from, y), (on.x.to, y)], mark, colour);
}

/// A mark on a frame.
pub fn point(svg: &mut Svg, on: &Frame, at: Place, mark: Mark, colour: Colour) {
    points(svg, on, [at], mark, colour);
}

/// Marks of one kind on a frame.
pub fn points(svg: &mut Svg, on: &Frame, places: impl IntoIterator<Item = Place>, mark: Mark, colour: Colour) {
    let pixels: Vec<Pixel> = places.into_iter().map(|at| on.pixel(at)).collect();
    marks(svg, &pixels, mark, colour);
}

/// Marks of one kind, in pixels.
pub fn marks(svg: &mut Svg, places: &[Pixel], mark: Mark, colour: Colour) {
    let mut path = Path::default();
    for &[x, y] in places.iter().filter(|at| at.iter().all(|part| part.is_finite())) {
        let triangle = |r: f64| [[x, y - r], [x + 0.87 * r, y + 0.5 * r], [x - 0.87 * r, y + 0.5 * r]];
        match mark {
            Mark::Triangle => path = path.through(&triangle(7.0)).closed(),
            Mark::SmallTriangle => path = path.through(&triangle(5.0)).closed(),
            Mark::Cross => {
                let bar = |up: f64| [[x - 6.0, y - 6.0 * up], [x + 6.0, y + 6.0 * up]];
                path = path.through(&bar(1.0)).through(&bar(-1.0));
            }
            Mark::Ring => path.ring([x, y], 10.0),
            Mark::Square => path.tile([[x - 5.0, y - 5.0], [x + 5.0, y + 5.0]]),
            _ => path.dot([x, y]),
        }
    }
    let round = |width: f64| Paint { cap: "round", ..Paint::line(colour, width) };
    let paint = match mark {
        Mark::Triangle | Mark::SmallTriangle | Mark::Square => Paint::fill(colour),
        Mark::Cross => Paint::line(colour, 3.0),
        Mark::Ring => Paint::line(colour, 2.0),
        Mark::Circle => round(10.0),
        Mark::SmallDot => round(4.0),
        Mark::Speck => round(2.0),
        Mark::Line { .. } | Mark::Pale { .. } => return,
    };
    svg.path(&path, paint);
}

/// A legend from its upper left corner, as wide as that, all in one size.
pub fn legend(svg: &mut Svg, [left, top]: Pixel, width: f64, entries: &[Entry]) {
    let room = width - 48.0;
    let size = entries.iter().map(|entry| fitting(&entry.text, TEXT_SIZE, room)).fold(TEXT_SIZE, f64::min);
    for (index, entry) in entries.iter().enumerate() {
        let y = top + 20.0 + LINE_HEIGHT * index as f64;
        sign(svg, [left + 20.0, y], entry);
        fitted(svg, &entry.text, [left + 42.0, y], size, room);
    }
}

/// Height of a legend of so many entries.
pub fn legend_height(entries: usize) -> f64 {
    16.0 + LINE_HEIGHT * entries as f64
}

/// A legend in one line.
pub fn legend_across(svg: &mut Svg, entries: &[Entry]) {
    let mut x = 16.0;
    for entry in entries {
        sign(svg, [x + 10.0, 16.0], entry);
        words_from(svg, &entry.text, [x + 26.0, 16.0], TEXT_SIZE, INK);
        x += 26.0 + text_width(&entry.text, TEXT_SIZE) + 24.0;
    }
}

/// Colours with their words, side by side from a place, in as many lines as it takes; where the last of them ends.
pub fn key<'a>(
    svg: &mut Svg,
    [left, top]: Pixel,
    entries: impl IntoIterator<Item = (Colour, &'a str)>,
    size: f64,
) -> Pixel {
    let (mut x, mut y) = (left, top);
    for (colour, text) in entries {
        let long = 30.0 + text_width(text, size) + 20.0;
        if x + long > WIDTH && x > left {
            (x, y) = (left, y + LINE_HEIGHT);
        }
        tile(svg, [[x, y - 8.0], [x + 22.0, y + 8.0]], colour, SOFT);
        words_from(svg, text, [x + 30.0, y], size, INK);
        x += long;
    }
    [x, y]
}

fn sign(svg: &mut Svg, [x, y]: Pixel, entry: &Entry) {
    match entry.mark {
        Mark::Line { .. } | Mark::Pale { .. } => {
            svg.polyline(&[[x - 14.0, y], [x + 14.0, y]], stroke(entry.mark, entry.colour));
        }
        mark => marks(svg, &[[x, y]], mark, entry.colour),
    }
}

/// Words around a place, in pixels.
pub fn words(svg: &mut Svg, text: &str, at: Pixel, size: f64, colour: Colour) {
    svg.words(text, at, around(size, colour));
}

/// Words from a place to the right.
pub fn words_from(svg: &mut Svg, text: &str, at: Pixel, size: f64, colour: Colour) {
    svg.words(text, at, Words { side: Side::Right, ..around(size, colour) });
}

/// Words up to a place.
pub fn words_to(svg: &mut Svg, text: &str, at: Pixel, size: f64, colour: Colour) {
    svg.words(text, at, Words { side: Side::Left, ..around(size, colour) });
}

/// How words around a place are written.
pub fn around(size: f64, colour: Colour) -> Words {
    Words { size, colour, side: Side::Around, upright: false, rim: false }
}

/// Words from a place to the right that are no wider than that.
pub fn fitted(svg: &mut Svg, text: &str, at: Pixel, size: f64, width: f64) {
    let size = fitting(text, size, width);
    words_from(svg, &shortened(text, size, width), at, size, INK);
}

/// The size at which a text is no wider than that, if it does not become too small.
fn fitting(text: &str, size: f64, width: f64) -> f64 {
    (size * width / text_width(text, size).max(1.0)).floor().clamp(SMALLEST, size)
}

/// How wide a text is in the widest of the usual fonts (DejaVu Sans), about, in pixels.
pub fn text_width(text: &str, size: f64) -> f64 {
    size * text.chars().map(letter).sum::<f64>()
}

/// Width of a letter of size 1.
fn letter(of: char) -> f64 {
    match of {
        'i' | 'j' | 'l' | 'I' | 'J' | ' ' | '.' | ',' | '·' | '\'' => 0.31,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | ':' | '-' | '/' | '²' | '¹' | '⁰' => 0.39,
        'm' | 'w' | 'M' | 'W' | '%' | '+' | '−' | '=' | '<' | '>' | '≤' | '≥' | '×' | '…' => 0.92,
        'A'..='Z' => 0.7,
        _ => 0.61,
    }
}

/// A text that is no wider than that, with an ellipsis where something is left out.
pub fn shortened(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_string();
    }
    let mut room = width / size - letter('…');
    let fits = |of: &char| {
        room -= letter(*of);
        room >= 0.0
    };
    format!("{}…", text.chars().take_while(fits).collect::<String>().trim_end())
}

/// Boxes side by side, without edges: those of a colour are one element.
pub fn tiles(svg: &mut Svg, tiles: impl IntoIterator<Item = ([Pixel; 2], Colour)>) {
    let mut paths: Vec<(Colour, Path)> = Vec::new();
    for (corners, colour) in tiles {
        let known = paths.iter().position(|(of, _)| *of == colour);
        let index = known.unwrap_or_else(|| {
            paths.push((colour, Path::default()));
            paths.len() - 1
        });
        paths[index].1.tile(corners);
    }
    for (colour, path) in &paths {
        svg.crisp(path, *colour);
    }
}

/// The edge of a box.
pub fn outline(svg: &mut Svg, corners: [Pixel; 2], edge: Colour) {
    svg.rectangle(corners, Paint::line(edge, 1.0));
}

/// A box with its edge, from one corner to the other.
pub fn tile(svg: &mut Svg, corners: [Pixel; 2], fill: Colour, edge: Colour) {
    svg.rectangle(corners, Paint::fill(fill).with_edge(edge));
}

fn stroke(mark: Mark, colour: Colour) -> Paint {
    match mark {
        Mark::Pale { width } => Paint::line(colour, width).faded(0.35),
        Mark::Line { width } => Paint::line(colour, width),
        _ => Paint::line(colour, 2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_is_too_wide_becomes_smaller_and_then_shorter() {
        assert_eq!((fitting("short", 15.0, 200.0), shortened("short", 15.0, 200.0)), (15.0, "short".to_string()));
        let long = "a name of thirty-three characters";
        let small = fitting(long, 15.0, 240.0);
        assert!((SMALLEST..15.0).contains(&small) && text_width(long, small) <= 240.0, "{small}");
        assert_eq!(shortened(long, small, 240.0), long);
        let short = shortened(long, SMALLEST, 100.0);
        assert!(short.ends_with('…') && short.len() > 12 && text_width(&short, SMALLEST) <= 100.0, "{short}");
    }

    #[test]
    fn all_of_a_legend_has_one_size() {
        let entries =
            ["short", "a text that is rather too long for its legend"].map(|text| Entry::new(THIN, INK, text));
        let drawn = document([99.0, 99.0], "", |svg| legend(svg, [0.0; 2], LEGEND, &entries));
        assert_eq!(drawn.matches("font-size=\"11\"").count(), 2, "{drawn}");
    }

    #[test]
    fn what_is_beyond_an_axis_lies_on_its_end() {
        let within = Area { left: 10.0, top: 20.0, width: 100.0, height: 50.0 };
        let on = Frame { within, x: Axis::over("", 0.0, 1.0), y: Axis::over("", 0.0, 1.0) };
        assert_eq!([(0.5, 0.5), (2.0, -1.0)].map(|at| on.pixel(at)), [[60.0, 45.0], [110.0, 70.0]]);
    }

    #[test]
    fn boxes_of_a_colour_are_one_element() {
        let drawn = document([9.0, 9.0], "", |svg| {
            let at = |x: f64| [[x, 0.0], [x + 1.0, 1.0]];
            tiles(svg, [(at(0.0), INK), (at(1.0), LINE), (at(2.0), INK)]);
        });
        assert_eq!(drawn.matches("<path").count(), 2);
        assert!(drawn.contains("<path d=\"M0 0h1v1h-1zm2 0h1v1h-1z\" fill=\"#1B1F26\""), "{drawn}");
    }
}
