//! SVG as text. Texts and names are escaped; coordinates have a resolution of a tenth of a pixel.

use std::fmt::{self, Display, Formatter, Write};

use super::theme::{Colour, INK, PAPER, style};
use crate::format::escape_markup;

/// Coordinates in pixels; y points downwards.
pub type Pixel = [f64; 2];

/// Comment at the beginning of every picture. The program recognises its own files by it.
pub const PICTURE_MARK: &str = "<!-- phalanx -->";

/// Default text size.
pub const TEXT_SIZE: f64 = 15.0;

/// An SVG document that is being drawn: its elements so far.
#[derive(Default)]
pub struct Svg {
    text: String,
}

/// Fill and stroke of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paint {
    pub fill: Option<Colour>,
    /// Colour and width of the stroke; `None` for no stroke.
    pub stroke: Option<(Colour, f64)>,
    /// Opacity of the fill, or of the stroke of a shape without fill.
    pub opacity: Option<f64>,
    /// Lengths of dashes and gaps.
    pub dash: &'static str,
    /// Shape of the ends of lines.
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

/// Attributes of an element.
impl Display for Paint {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let fill = self.fill.map_or("none".to_string(), |colour| colour.to_string());
        write!(f, " fill=\"{fill}\"")?;
        if let Some((colour, width)) = self.stroke {
            write!(f, " stroke=\"{colour}\" stroke-width=\"{width}\"")?;
        }
        if let Some(opacity) = self.opacity {
            write!(f, " {}-opacity=\"{opacity}\"", if self.fill.is_some() { "fill" } else { "stroke" })?;
        }
        for (name, value) in [("stroke-dasharray", self.dash), ("stroke-linecap", self.cap)] {
            if !value.is_empty() {
                write!(f, " {name}=\"{value}\"")?;
            }
        }
        Ok(())
    }
}

/// Style of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    pub size: f64,
    pub colour: Colour,
    /// Part of the text that is placed at its coordinates: `start`, `middle` or `end`.
    pub anchor: &'static str,
    /// Whether the text runs upwards.
    pub is_vertical: bool,
    /// Whether the text is outlined in the background colour.
    pub has_halo: bool,
}

/// Writes a complete SVG document; `label` is its accessible name.
pub fn document([width, height]: [f64; 2], label: &str, draw: impl FnOnce(&mut Svg)) -> String {
    let mut svg = Svg::default();
    svg.rectangle([[0.0; 2], [width, height]], Paint::fill(PAPER));
    draw(&mut svg);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"{}\" font-family=\"sans-serif\" font-size=\"{TEXT_SIZE}\" fill=\"{INK}\" \
         stroke-linejoin=\"round\">\n{PICTURE_MARK}\n<style>\n{}</style>\n{}</svg>\n",
        escape_markup(label),
        style(&svg.text),
        svg.text
    )
}

impl Svg {
    fn line(&mut self, element: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "{element}");
    }

    /// Draws with the origin moved to a pixel.
    pub fn translated(&mut self, [x, y]: Pixel, draw: impl FnOnce(&mut Svg)) {
        self.line(format_args!("<g transform=\"translate({} {})\">", pixels(x), pixels(y)));
        draw(self);
        self.line("</g>");
    }

    pub fn path(&mut self, path: &Path, paint: Paint) {
        if !path.data.is_empty() {
            self.line(format_args!("<path d=\"{}\"{paint}/>", path.data));
        }
    }

    /// Draws a path of adjacent tiles without anti-aliasing, which would show seams between them.
    pub(crate) fn crisp_path(&mut self, path: &Path, fill: Colour) {
        let paint = Paint::fill(fill);
        self.line(format_args!("<path d=\"{}\"{paint} shape-rendering=\"crispEdges\"/>", path.data));
    }

    pub fn polyline(&mut self, points: &[Pixel], paint: Paint) {
        self.path(&Path::default().with_polyline(points), paint);
    }

    pub fn polygon(&mut self, points: &[Pixel], paint: Paint) {
        self.path(&Path::default().with_polyline(points).closed(), paint);
    }

    pub fn circle(&mut self, [x, y]: Pixel, radius: f64, paint: Paint) {
        let [x, y, radius] = [x, y, radius].map(pixels);
        self.line(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{paint}/>"));
    }

    /// Draws a rectangle given by two opposite corners.
    pub fn rectangle(&mut self, [[left, top], [right, bottom]]: [Pixel; 2], paint: Paint) {
        let [x, y, width, height] = [left, top, right - left, bottom - top].map(pixels);
        self.line(format_args!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{paint}/>"));
    }

    /// Draws a text that is vertically centred at its coordinates.
    pub fn text(&mut self, text: &str, [x, y]: Pixel, style: TextStyle) {
        if text.is_empty() {
            return;
        }
        let TextStyle { size, colour, anchor, is_vertical, has_halo } = style;
        let [left, middle, baseline] = [x, y, y + 0.35 * size].map(pixels);
        let attributes = [
            is_vertical.then(|| format!(" transform=\"rotate(-90 {left} {middle})\"")),
            (size != TEXT_SIZE).then(|| format!(" font-size=\"{size}\"")),
            (anchor != "start").then(|| format!(" text-anchor=\"{anchor}\"")),
            (colour != INK).then(|| format!(" fill=\"{colour}\"")),
            has_halo.then(|| {
                format!(" stroke=\"{PAPER}\" stroke-width=\"4\" stroke-linejoin=\"round\" paint-order=\"stroke\"")
            }),
        ];
        let attributes: String = attributes.into_iter().flatten().collect();
        self.line(format_args!("<text x=\"{left}\" y=\"{baseline}\"{attributes}>{}</text>", escape_markup(text)));
    }
}

/// A path. Coordinates are integers in tenths of a pixel, so that relative steps do not accumulate rounding errors.
#[derive(Default)]
pub struct Path {
    data: String,
    position: [i64; 2],
    /// Start of the current subpath, to which closing it returns.
    start: [i64; 2],
}

impl Path {
    fn push_number(&mut self, tenths: i64) {
        if tenths >= 0 && self.data.ends_with(|last: char| last.is_ascii_digit()) {
            self.data.push(' ');
        }
        self.data.push_str(&format_tenths(tenths));
    }

    fn line_to(&mut self, [x, y]: [i64; 2]) {
        let [dx, dy] = [x - self.position[0], y - self.position[1]];
        self.push_number(dx);
        self.push_number(dy);
        self.position = [x, y];
    }

    fn move_to(&mut self, to: [i64; 2]) {
        self.data.push(if self.data.is_empty() { 'M' } else { 'm' });
        self.line_to(to);
        self.start = to;
    }

    /// Adds a line through points; collinear points and points that are not finite are omitted.
    pub(crate) fn with_polyline(mut self, points: &[Pixel]) -> Path {
        let mut simplified: Vec<[i64; 2]> = Vec::with_capacity(points.len());
        let finite = points.iter().filter(|point| point.iter().all(|component| component.is_finite()));
        for point in finite.map(|point| point.map(tenths)) {
            let difference = |from: [i64; 2], to: [i64; 2]| [to[0] - from[0], to[1] - from[1]];
            match simplified[..] {
                [.., last] if last == point => continue,
                [.., before, last] => {
                    let (a, b) = (difference(before, last), difference(last, point));
                    if a[0] * b[1] == a[1] * b[0] && a[0] * b[0] + a[1] * b[1] > 0 {
                        simplified.pop();
                    }
                }
                _ => {}
            }
            simplified.push(point);
        }
        let [first, rest @ ..] = &simplified[..] else { return self };
        self.move_to(*first);
        if !rest.is_empty() {
            self.data.push('l');
        }
        rest.iter().for_each(|position| self.line_to(*position));
        self
    }

    pub fn closed(mut self) -> Path {
        if !self.data.is_empty() {
            self.data.push('z');
            self.position = self.start;
        }
        self
    }

    /// Adds a point, drawn by the round or square ends of a line of zero length.
    pub(crate) fn add_dot(&mut self, position: Pixel) {
        self.move_to(position.map(tenths));
        self.data.push_str("h0");
    }

    /// Adds a circle.
    pub(crate) fn add_circle(&mut self, [x, y]: Pixel, radius: f64) {
        self.move_to([x - radius, y].map(tenths));
        let (r, across) = (pixels(radius), pixels(2.0 * radius));
        let _ = write!(self.data, "a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0");
    }

    /// Adds a rectangle given by its upper left and lower right corner.
    pub(crate) fn add_rectangle(&mut self, [from, to]: [Pixel; 2]) {
        let ([left, top], [right, bottom]) = (from.map(tenths), to.map(tenths));
        self.move_to([left, top]);
        let (wide, tall) = (format_tenths(right - left), format_tenths(bottom - top));
        let _ = write!(self.data, "h{wide}v{tall}h{}z", format_tenths(left - right));
    }
}

/// Formats a number of pixels with at most one decimal.
fn pixels(value: f64) -> String {
    format_tenths(tenths(value))
}

fn tenths(pixels: f64) -> i64 {
    (10.0 * pixels).round() as i64
}

/// Shortest decimal form of a number of tenths.
fn format_tenths(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    match (tenths.abs() / 10, tenths.abs() % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (0, decimals) => format!("{sign}.{decimals}"),
        (whole, decimals) => format!("{sign}{whole}.{decimals}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_numbers_and_relative_paths() {
        assert_eq!([0.0, -0.04, 0.26, -0.5, 12.0, 3.12].map(pixels), ["0", "0", ".3", "-.5", "12", "3.1"]);
        let line = Path::default().with_polyline(&[
            [1.0, 1.0],
            [2.0, 1.04],
            [3.0, 1.0],
            [f64::NAN, 9.0],
            [3.0, 1.0],
            [3.5, 0.0],
        ]);
        assert_eq!(line.data, "M1 1l2 0 .5-1");
        let mut path = Path::default().with_polyline(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]).closed();
        path.add_dot([1.0, 1.0]);
        path.add_rectangle([[2.0, 2.0], [5.0, 3.0]]);
        assert_eq!(path.data, "M0 0l4 0 0 3zm1 1h0m1 1h3v1h-3z");
        // A reversal of direction is preserved.
        assert_eq!(Path::default().with_polyline(&[[0.0, 0.0], [4.0, 0.0], [2.0, 0.0]]).data, "M0 0l4 0-2 0");
    }

    #[test]
    fn document_is_well_formed_and_escapes_texts() {
        let hostile = "a < b && \"c\" > 'd' </text><script></svg>]]><!--\u{1b}";
        let shown = hostile.replace('\u{1b}', "\u{fffd}");
        let svg_text = document([10.0, 20.0], hostile, |svg| {
            svg.translated([1.0, 2.0], |svg| {
                svg.rectangle([[0.0; 2], [1.0; 2]], Paint::fill(INK).with_edge(PAPER).faded(0.5).dashed("1 2"));
                svg.circle([0.0; 2], 1.0, Paint { cap: "round", ..Paint::line(INK, 1.0) });
                svg.polyline(&[], Paint::default());
                let text_style =
                    TextStyle { size: 9.0, colour: PAPER, anchor: "end", is_vertical: true, has_halo: true };
                svg.text(hostile, [0.0; 2], text_style);
            });
        });
        assert!(svg_text.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"10\" height=\"20\""));
        assert!(!svg_text.contains("<script") && !svg_text.contains('\u{1b}'));
        assert!(svg_text.find(PICTURE_MARK).expect("a mark") < svg_text.find("<style>").expect("a style"));
        let xml = roxmltree::Document::parse(&svg_text).expect("well-formed");
        assert_eq!(xml.root_element().attribute("aria-label"), Some(&*shown));
        let text = xml.descendants().find(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")));
        assert_eq!(text.and_then(|node| node.text()), Some(&*shown));
        assert!(!svg_text.contains("d=\"\""), "an empty line is omitted");
    }
}
