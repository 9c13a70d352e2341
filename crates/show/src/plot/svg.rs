//! An SVG as text: elements out of which no text and no attribute can break, and places in tenths of a pixel.

use std::collections::BTreeSet;
use std::fmt::{Display, Write};

use super::theme::{Colour, INK, PAPER, style};
use crate::wording::escaped;

/// A place in pixels, y downwards.
pub type Pixel = [f64; 2];

/// Every picture has it at its beginning.
pub const PICTURE_MARK: &str = "<!-- phalanx -->";

/// Size of letters, where nothing else is said.
pub const TEXT_SIZE: f64 = 15.0;

/// What has been drawn so far, and the colours in it by the attributes that name them.
#[derive(Default)]
pub struct Svg {
    text: String,
    used: BTreeSet<(&'static str, Colour)>,
}

/// How a shape is filled and its line is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paint {
    pub fill: Option<Colour>,
    /// Its colour and its width.
    pub stroke: Option<(Colour, f64)>,
    /// Of the inside, or of the line of what has none.
    pub opacity: Option<f64>,
    /// Lengths of dashes and gaps.
    pub dash: &'static str,
    /// How lines end.
    pub cap: &'static str,
}

impl Paint {
    pub fn fill(colour: Colour) -> Paint {
        Paint { fill: Some(colour), ..Paint::default() }
    }

    pub fn line(colour: Colour, width: f64) -> Paint {
        Paint { stroke: Some((colour, width)), ..Paint::default() }
    }

    pub fn with_edge(self, colour: Colour) -> Paint {
        Paint { stroke: Some((colour, 1.0)), ..self }
    }

    pub fn faded(self, opacity: f64) -> Paint {
        Paint { opacity: Some(opacity), ..self }
    }

    pub fn dashed(self, dash: &'static str) -> Paint {
        Paint { dash, ..self }
    }
}

/// How a text is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Words {
    pub size: f64,
    pub colour: Colour,
    pub side: Side,
    /// From below upwards.
    pub upright: bool,
    /// With a rim of the ground's colour.
    pub rim: bool,
}

/// Where a text is from its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Around,
    Left,
}

/// A whole picture of a size; `label` says what it is to those who do not see it.
pub fn document([width, height]: [f64; 2], label: &str, draw: impl FnOnce(&mut Svg)) -> String {
    let mut svg = Svg::default();
    svg.used.insert(("fill", INK));
    svg.rectangle([[0.0; 2], [width, height]], Paint::fill(PAPER));
    draw(&mut svg);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"{}\" font-family=\"sans-serif\" font-size=\"{TEXT_SIZE}\" fill=\"{INK}\" \
         stroke-linejoin=\"round\">\n{PICTURE_MARK}\n<style>\n{}</style>\n{}</svg>\n",
        escaped(label),
        style(&svg.used),
        svg.text
    )
}

impl Svg {
    /// The beginning of an element; attributes follow, and an end.
    pub fn open(&mut self, name: &str) -> &mut Svg {
        self.text.push('<');
        self.text.push_str(name);
        self
    }

    pub fn set(&mut self, name: &str, value: impl Display) -> &mut Svg {
        // Writing to a string cannot fail.
        let _ = write!(self.text, " {name}=\"{}\"", escaped(&value.to_string()));
        self
    }

    fn place(&mut self, name: &str, pixels: f64) -> &mut Svg {
        self.set(name, short(tenths(pixels)))
    }

    fn colour(&mut self, attribute: &'static str, colour: Option<Colour>) -> &mut Svg {
        match colour {
            Some(colour) => {
                self.used.insert((attribute, colour));
                self.set(attribute, colour)
            }
            None => self.set(attribute, "none"),
        }
    }

    fn paint(&mut self, paint: Paint) -> &mut Svg {
        self.colour("fill", paint.fill);
        if let Some((colour, width)) = paint.stroke {
            self.colour("stroke", Some(colour)).set("stroke-width", width);
        }
        if let Some(opacity) = paint.opacity {
            self.set(if paint.fill.is_some() { "fill-opacity" } else { "stroke-opacity" }, opacity);
        }
        for (name, value) in [("stroke-dasharray", paint.dash), ("stroke-linecap", paint.cap)] {
            if !value.is_empty() {
                self.set(name, value);
            }
        }
        self
    }

    pub fn end(&mut self) {
        self.text.push_str("/>\n");
    }

    /// The end of an element that has others within it.
    pub fn around(&mut self, name: &str, inside: impl FnOnce(&mut Svg)) {
        self.text.push('>');
        inside(self);
        let _ = writeln!(self.text, "</{name}>");
    }

    /// The end of an element that has a text.
    pub fn saying(&mut self, name: &str, text: &str) {
        self.around(name, |svg| svg.text.push_str(&escaped(text)));
    }

    /// All that is drawn in it, away from where it would be.
    pub fn moved(&mut self, [x, y]: Pixel, draw: impl FnOnce(&mut Svg)) {
        let (x, y) = (short(tenths(x)), short(tenths(y)));
        self.open("g").set("transform", format_args!("translate({x} {y})")).around("g", |svg| {
            svg.text.push('\n');
            draw(svg);
        });
    }

    pub fn path(&mut self, path: &Path, paint: Paint) {
        if !path.d.is_empty() {
            self.open("path").set("d", &path.d).paint(paint).end();
        }
    }

    /// A path whose edges lie side by side: without the faint seams that smooth edges would have.
    pub fn crisp(&mut self, path: &Path, fill: Colour) {
        self.open("path").set("d", &path.d).paint(Paint::fill(fill)).set("shape-rendering", "crispEdges").end();
    }

    pub fn polyline(&mut self, points: &[Pixel], paint: Paint) {
        self.path(&Path::default().through(points), paint);
    }

    pub fn polygon(&mut self, points: &[Pixel], paint: Paint) {
        self.path(&Path::default().through(points).closed(), paint);
    }

    pub fn circle(&mut self, [x, y]: Pixel, radius: f64, paint: Paint) {
        self.open("circle").place("cx", x).place("cy", y).place("r", radius).paint(paint).end();
    }

    /// A place that leads elsewhere, round and not to be seen.
    pub fn link(&mut self, to: &str, title: &str, [x, y]: Pixel, radius: f64) {
        self.open("a").set("href", to).around("a", |svg| {
            svg.open("circle").place("cx", x).place("cy", y).set("r", radius).set("fill", "transparent");
            svg.around("circle", |svg| svg.open("title").saying("title", title));
        });
    }

    /// From one corner to the other.
    pub fn rectangle(&mut self, [[left, top], [right, bottom]]: [Pixel; 2], paint: Paint) {
        self.open("rect").place("x", left).place("y", top).place("width", right - left).place("height", bottom - top);
        self.paint(paint).end();
    }

    /// A text whose middle is at the height of its place.
    pub fn words(&mut self, text: &str, [x, y]: Pixel, words: Words) {
        let Words { size, colour, side, upright, rim } = words;
        if text.is_empty() {
            return;
        }
        self.open("text").place("x", x).place("y", y + 0.35 * size);
        if upright {
            self.set("transform", format_args!("rotate(-90 {} {})", short(tenths(x)), short(tenths(y))));
        }
        if size != TEXT_SIZE {
            self.set("font-size", size);
        }
        match side {
            Side::Right => {}
            Side::Around => drop(self.set("text-anchor", "middle")),
            Side::Left => drop(self.set("text-anchor", "end")),
        }
        if colour != INK {
            self.colour("fill", Some(colour));
        }
        if rim {
            self.colour("stroke", Some(PAPER))
                .set("stroke-width", 4)
                .set("stroke-linejoin", "round")
                .set("paint-order", "stroke");
        }
        self.saying("text", text);
    }
}

/// What a pen draws, from tenth to tenth of a pixel, so that no error adds up.
#[derive(Default)]
pub struct Path {
    d: String,
    pen: [i64; 2],
    /// Where the pen goes back to when the line is closed.
    start: [i64; 2],
}

impl Path {
    fn number(&mut self, tenths: i64) {
        if tenths >= 0 && self.d.ends_with(|last: char| last.is_ascii_digit()) {
            self.d.push(' ');
        }
        self.d.push_str(&short(tenths));
    }

    fn go(&mut self, [x, y]: [i64; 2]) {
        let [dx, dy] = [x - self.pen[0], y - self.pen[1]];
        self.number(dx);
        self.number(dy);
        self.pen = [x, y];
    }

    fn lift(&mut self, to: [i64; 2]) {
        self.d.push(if self.d.is_empty() { 'M' } else { 'm' });
        self.go(to);
        self.start = to;
    }

    /// A line through points, without those that a straight line has anyway, and without places that are no numbers.
    pub fn through(mut self, points: &[Pixel]) -> Path {
        let mut kept: Vec<[i64; 2]> = Vec::with_capacity(points.len());
        for at in points.iter().filter(|at| at.iter().all(|part| part.is_finite())).map(|at| at.map(tenths)) {
            let by = |from: [i64; 2], to: [i64; 2]| [to[0] - from[0], to[1] - from[1]];
            match kept[..] {
                [.., last] if last == at => continue,
                [.., before, last] => {
                    let (a, b) = (by(before, last), by(last, at));
                    if a[0] * b[1] == a[1] * b[0] && a[0] * b[0] + a[1] * b[1] > 0 {
                        kept.pop();
                    }
                }
                _ => {}
            }
            kept.push(at);
        }
        let [first, rest @ ..] = &kept[..] else { return self };
        self.lift(*first);
        if !rest.is_empty() {
            self.d.push('l');
        }
        rest.iter().for_each(|at| self.go(*at));
        self
    }

    pub fn closed(mut self) -> Path {
        if !self.d.is_empty() {
            self.d.push('z');
            self.pen = self.start;
        }
        self
    }

    /// A point, which ends of lines make round or square.
    pub fn dot(&mut self, at: Pixel) {
        self.lift(at.map(tenths));
        self.d.push_str("h0");
    }

    /// A circle.
    pub fn ring(&mut self, [x, y]: Pixel, radius: f64) {
        self.lift([x - radius, y].map(tenths));
        let (r, across) = (short(tenths(radius)), short(tenths(2.0 * radius)));
        let _ = write!(self.d, "a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0");
    }

    /// A box from one corner to the other.
    pub fn tile(&mut self, [from, to]: [Pixel; 2]) {
        let ([left, top], [right, bottom]) = (from.map(tenths), to.map(tenths));
        self.lift([left, top]);
        let (wide, tall) = (short(right - left), short(bottom - top));
        let _ = write!(self.d, "h{wide}v{tall}h{}z", short(left - right));
    }
}

fn tenths(pixels: f64) -> i64 {
    (10.0 * pixels).round() as i64
}

/// As short as it can be said.
fn short(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    match (tenths.abs() / 10, tenths.abs() % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, part) => format!("{sign}.{part}"),
        (whole, part) => format!("{sign}{whole}.{part}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_paths_come_back_to_where_they_are() {
        assert_eq!(
            [0.0, -0.04, 0.26, -0.5, 12.0, 3.12].map(|at| short(tenths(at))),
            ["0", "0", ".3", "-.5", "12", "3.1"]
        );
        let line =
            Path::default().through(&[[1.0, 1.0], [2.0, 1.04], [3.0, 1.0], [f64::NAN, 9.0], [3.0, 1.0], [3.5, 0.0]]);
        assert_eq!(line.d, "M1 1l2 0 .5-1");
        let mut path = Path::default().through(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]).closed();
        path.dot([1.0, 1.0]);
        path.tile([[2.0, 2.0], [5.0, 3.0]]);
        assert_eq!(path.d, "M0 0l4 0 0 3zm1 1h0m1 1h3v1h-3z");
        // A step back is not left out.
        assert_eq!(Path::default().through(&[[0.0, 0.0], [4.0, 0.0], [2.0, 0.0]]).d, "M0 0l4 0-2 0");
    }

    #[test]
    fn nothing_breaks_out_of_a_text_or_an_attribute() {
        let foreign = "</text><script>\"&\u{1b}'";
        let words = Words { size: TEXT_SIZE, colour: INK, side: Side::Right, upright: false, rim: false };
        let made = document([10.0, 20.0], foreign, |svg| svg.words(foreign, [1.0, 2.0], words));
        assert!(made.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"10\" height=\"20\""));
        assert!(!made.contains("<script") && !made.contains('\u{1b}'));
        assert_eq!(made.matches("&lt;/text&gt;&lt;script&gt;&quot;&amp;\u{fffd}&#39;").count(), 2, "{made}");
        assert!(made.find(PICTURE_MARK).expect("a mark") < made.find("<style>").expect("a style"));
    }

    #[test]
    fn a_picture_is_whole_xml_that_says_what_it_was_told() {
        let foreign = "a < b && \"c\" > 'd' </svg>]]><!--";
        let made = document([10.0, 20.0], foreign, |svg| {
            svg.moved([1.0, 2.0], |svg| {
                svg.rectangle([[0.0; 2], [1.0; 2]], Paint::fill(INK).with_edge(PAPER).faded(0.5).dashed("1 2"));
                svg.circle([0.0; 2], 1.0, Paint { cap: "round", ..Paint::line(INK, 1.0) });
                svg.link(foreign, foreign, [0.0; 2], 1.0);
                svg.polyline(&[], Paint::default());
                let words = Words { size: 9.0, colour: PAPER, side: Side::Left, upright: true, rim: true };
                svg.words(foreign, [0.0; 2], words);
            });
        });
        let xml = roxmltree::Document::parse(&made).expect("well-formed");
        assert_eq!(xml.root_element().attribute("aria-label"), Some(foreign));
        let said =
            |name| xml.descendants().find(|of| of.has_tag_name(("http://www.w3.org/2000/svg", name))).expect(name);
        assert_eq!([said("text"), said("title")].map(|of| of.text()), [Some(foreign); 2]);
        assert_eq!(said("a").attribute("href"), Some(foreign));
        assert!(!made.contains("d=\"\""), "a line through no point is none");
    }
}
