//! Elements of pictures: titles, frames with axes, lines and markers in them, legends, tiles and text.

use super::axis::Axis;
use super::svg::{Anchor, Paint, Path, Pixel, Svg, TEXT_SIZE, TextStyle, document};
use super::theme::{Colour, FAINT, INK, LINE, SOFT};

/// Coordinates of a point in a frame.
pub type PlotPoint = (f64, f64);

pub const WIDTH: f64 = 960.0;
/// Width of a legend next to a frame.
pub(crate) const LEGEND_WIDTH: f64 = 250.0;
/// Height of a title.
pub const TITLE_HEIGHT: f64 = 40.0;
/// Height of the tick labels and the axis label below a frame.
pub(crate) const AXIS_HEIGHT: f64 = 50.0;
/// Margin below a frame without axis labels.
const BOTTOM_MARGIN: f64 = 12.0;
/// Distance from the left of an area to its frame.
pub const LEFT_MARGIN: f64 = 86.0;
/// Margin above a frame.
const TOP_MARGIN: f64 = 8.0;
/// Margin to the right of a frame.
const RIGHT_MARGIN: f64 = 12.0;
/// Text size of the title.
const TITLE_SIZE: f64 = 19.0;
/// Height of a legend entry.
const LINE_HEIGHT: f64 = 24.0;
/// Minimum size of text. Text that is too wide is reduced to this size, then truncated.
const MIN_TEXT_SIZE: f64 = 11.0;

/// Schema of a picture: standalone with title and a legend on the right, or for a narrow column of a page, without the
/// title.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    Standalone,
    Column,
}

impl PictureFormat {
    pub fn width(self) -> f64 {
        match self {
            PictureFormat::Standalone => WIDTH,
            PictureFormat::Column => 420.0,
        }
    }

    /// Draws a picture; `height` does not include the title.
    pub fn picture(self, title: &str, height: f64, draw: impl FnOnce(&mut Svg)) -> String {
        match self {
            PictureFormat::Standalone => picture(title, TITLE_HEIGHT + height, draw),
            PictureFormat::Column => document([self.width(), height], title, draw),
        }
    }
}

/// Marker of a series of points, or style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Marker {
    Circle,
    Triangle,
    Square,
    Cross,
    Ring,
    /// Smaller markers for hundreds of points, and one for thousands.
    SmallTriangle,
    SmallDot,
    TinyDot,
    Line {
        width: f64,
    },
    FaintLine {
        width: f64,
    },
}

pub const THIN_LINE: Marker = Marker::Line { width: 1.0 };

/// An entry of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendEntry {
    pub marker: Marker,
    pub colour: Colour,
    pub text: String,
}

impl LegendEntry {
    pub fn new(marker: Marker, colour: Colour, text: &str) -> LegendEntry {
        LegendEntry { marker, colour, text: text.to_string() }
    }
}

/// A rectangular area of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

/// An area of a picture with axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub area: Area,
    pub x: Axis,
    pub y: Axis,
}

impl Frame {
    /// Pixel of a point; coordinates beyond an axis are clamped to its end.
    pub fn pixel(&self, (x, y): PlotPoint) -> Pixel {
        let fraction = |axis: &Axis, value: f64| ((value - axis.from) / (axis.to - axis.from)).clamp(0.0, 1.0);
        let Area { left, top, width, height } = self.area;
        [left + width * fraction(&self.x, x), top + height * (1.0 - fraction(&self.y, y))]
    }
}

/// Draws a picture with a title; `draw` draws relative to the lower edge of the title.
pub fn picture(title: &str, height: f64, draw: impl FnOnce(&mut Svg)) -> String {
    document([WIDTH, height], title, |svg| {
        fitted_text(svg, title, [16.0, 24.0], TITLE_SIZE, WIDTH - 32.0);
        svg.translated([0.0, TITLE_HEIGHT], draw);
    })
}

/// Draws an empty frame with its axes; `has_labels` states whether the horizontal axis has its labels.
pub fn frame(svg: &mut Svg, area: Area, x: &Axis, y: &Axis, has_labels: bool) -> Frame {
    let frame_area = Area {
        left: area.left + LEFT_MARGIN,
        top: area.top + TOP_MARGIN,
        width: area.width - LEFT_MARGIN - RIGHT_MARGIN,
        height: area.height - TOP_MARGIN - if has_labels { AXIS_HEIGHT } else { BOTTOM_MARGIN },
    };
    let frame = Frame { area: frame_area, x: x.clone(), y: y.clone() };
    let vertical = |coordinate: f64| [frame.pixel((coordinate, y.from)), frame.pixel((coordinate, y.to))];
    let horizontal = |coordinate: f64| [frame.pixel((x.from, coordinate)), frame.pixel((x.to, coordinate))];
    for (colour, across, above) in [(FAINT, &x.minor_ticks, &y.minor_ticks), (LINE, &x.ticks, &y.ticks)] {
        let lines = across.iter().copied().map(vertical).chain(above.iter().copied().map(horizontal));
        svg.path(&lines.fold(Path::default(), |path, ends| path.with_polyline(&ends)), Paint::line(colour, 1.0));
    }
    let [corner, top, end] = [frame.pixel((x.from, y.from)), frame.pixel((x.from, y.to)), frame.pixel((x.to, y.from))];
    let mut axes = Path::default().with_polyline(&[top, corner, end]);
    for [[left, top], _] in y.ticks.iter().map(|tick| horizontal(*tick)) {
        axes = axes.with_polyline(&[[left - 5.0, top], [left, top]]);
    }
    for [[left, has_labels], _] in x.ticks.iter().map(|tick| vertical(*tick)) {
        axes = axes.with_polyline(&[[left, has_labels], [left, has_labels + 5.0]]);
    }
    svg.path(&axes, Paint::line(SOFT, 1.0));
    for tick in &y.ticks {
        let [left, coordinate] = horizontal(*tick)[0];
        text_left_of(svg, &y.tick_label(*tick), [left - 9.0, coordinate], TEXT_SIZE, INK);
    }
    let middle = frame_area.top + 0.5 * frame_area.height;
    let size = fitting_size(&y.label, TEXT_SIZE, area.height - 8.0);
    svg.text(&y.label, [area.left + 16.0, middle], TextStyle { is_vertical: true, ..centred_style(size, INK) });
    if has_labels {
        for tick in &x.ticks {
            let [coordinate, below] = vertical(*tick)[0];
            text_centred(svg, &x.tick_label(*tick), [coordinate, below + 15.0], TEXT_SIZE, INK);
        }
        let size = fitting_size(&x.label, TEXT_SIZE, frame_area.width);
        text_centred(svg, &x.label, [frame_area.left + 0.5 * frame_area.width, corner[1] + 38.0], size, INK);
    }
    frame
}

/// Draws a line through pixels, or markers of one kind at them.
pub fn markers(svg: &mut Svg, pixels: &[Pixel], marker: Marker, colour: Colour) {
    match marker {
        Marker::Line { width } => return svg.polyline(pixels, Paint::line(colour, width)),
        Marker::FaintLine { width } => return svg.polyline(pixels, Paint::line(colour, width).faded(0.35)),
        _ => {}
    }
    let mut path = Path::default();
    for &[x, y] in pixels.iter().filter(|position| position.iter().all(|component| component.is_finite())) {
        let triangle = |r: f64| [[x, y - r], [x + 0.87 * r, y + 0.5 * r], [x - 0.87 * r, y + 0.5 * r]];
        match marker {
            Marker::Triangle => path = path.with_polyline(&triangle(7.0)).closed(),
            Marker::SmallTriangle => path = path.with_polyline(&triangle(5.0)).closed(),
            Marker::Cross => {
                let bar = |up: f64| [[x - 6.0, y - 6.0 * up], [x + 6.0, y + 6.0 * up]];
                path = path.with_polyline(&bar(1.0)).with_polyline(&bar(-1.0));
            }
            Marker::Ring => path.add_circle([x, y], 10.0),
            Marker::Square => path.add_rectangle([[x - 5.0, y - 5.0], [x + 5.0, y + 5.0]]),
            _ => path.add_dot([x, y]),
        }
    }
    let round = |width: f64| Paint { cap: "round", ..Paint::line(colour, width) };
    let paint = match marker {
        Marker::Triangle | Marker::SmallTriangle | Marker::Square => Paint::fill(colour),
        Marker::Cross => Paint::line(colour, 3.0),
        Marker::Ring => Paint::line(colour, 2.0),
        Marker::Circle => round(10.0),
        Marker::SmallDot => round(4.0),
        _ => round(2.0),
    };
    svg.path(&path, paint);
}

/// Draws a legend, given its upper left corner and width; all entries have the same text size.
pub fn legend(svg: &mut Svg, [left, top]: Pixel, width: f64, entries: &[LegendEntry]) {
    let available_width = width - 48.0;
    let size =
        entries.iter().map(|entry| fitting_size(&entry.text, TEXT_SIZE, available_width)).fold(TEXT_SIZE, f64::min);
    for (index, entry) in entries.iter().enumerate() {
        let y = top + 20.0 + LINE_HEIGHT * index as f64;
        legend_symbol(svg, [left + 20.0, y], entry);
        fitted_text(svg, &entry.text, [left + 42.0, y], size, available_width);
    }
}

/// Height of a legend with this number of entries.
pub(crate) fn legend_height(entries: usize) -> f64 {
    16.0 + LINE_HEIGHT * entries as f64
}

/// Draws a legend in one line.
pub fn horizontal_legend(svg: &mut Svg, entries: &[LegendEntry]) {
    let mut x = 16.0;
    for entry in entries {
        legend_symbol(svg, [x + 10.0, 16.0], entry);
        text_right_of(svg, &entry.text, [x + 26.0, 16.0], TEXT_SIZE, INK);
        x += 26.0 + text_width(&entry.text, TEXT_SIZE) + 24.0;
    }
}

/// Draws colours with their labels side by side, wrapped to as many lines as needed. Returns the end of the last entry.
pub fn colour_key<'a>(
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
        text_right_of(svg, text, [x + 30.0, y], size, INK);
        x += long;
    }
    [x, y]
}

fn legend_symbol(svg: &mut Svg, [x, y]: Pixel, entry: &LegendEntry) {
    let is_line = matches!(entry.marker, Marker::Line { .. } | Marker::FaintLine { .. });
    let pixels = if is_line { vec![[x - 14.0, y], [x + 14.0, y]] } else { vec![[x, y]] };
    markers(svg, &pixels, entry.marker, entry.colour);
}

/// Draws text centred at a pixel.
pub fn text_centred(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, centred_style(size, colour));
}

/// Draws text that starts at a pixel.
pub fn text_right_of(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, TextStyle { anchor: Anchor::Start, ..centred_style(size, colour) });
}

/// Draws text that ends at a pixel.
pub fn text_left_of(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, TextStyle { anchor: Anchor::End, ..centred_style(size, colour) });
}

/// Style of centred text.
pub fn centred_style(size: f64, colour: Colour) -> TextStyle {
    TextStyle { size, colour, anchor: Anchor::Middle, is_vertical: false, has_halo: false }
}

/// Draws text that starts at a pixel and fits `width`.
pub fn fitted_text(svg: &mut Svg, text: &str, position: Pixel, size: f64, width: f64) {
    let size = fitting_size(text, size, width);
    text_right_of(svg, &truncated(text, size, width), position, size, INK);
}

/// Text size that fits `width`, but at least [`MIN_TEXT_SIZE`].
fn fitting_size(text: &str, size: f64, width: f64) -> f64 {
    (size * width / text_width(text, size).max(1.0)).floor().clamp(MIN_TEXT_SIZE, size)
}

/// Approximate width of a text in pixels, in the widest of the common fonts (DejaVu Sans).
pub fn text_width(text: &str, size: f64) -> f64 {
    size * text.chars().map(glyph_width).sum::<f64>()
}

/// Width of a character of size 1.
fn glyph_width(character: char) -> f64 {
    match character {
        'i' | 'j' | 'l' | 'I' | 'J' | ' ' | '.' | ',' | '·' | '\'' => 0.31,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | ':' | '-' | '/' | '²' | '¹' | '⁰' => 0.39,
        'm' | 'w' | 'M' | 'W' | '%' | '+' | '−' | '=' | '<' | '>' | '≤' | '≥' | '×' | '…' => 0.92,
        'A'..='Z' => 0.7,
        _ => 0.61,
    }
}

/// Truncates a text to `width`, with an ellipsis.
pub fn truncated(text: &str, size: f64, width: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_string();
    }
    let mut available_width = width / size - glyph_width('…');
    let fits = |character: &char| {
        available_width -= glyph_width(*character);
        available_width >= 0.0
    };
    format!("{}…", text.chars().take_while(fits).collect::<String>().trim_end())
}

/// Draws adjacent tiles without borders; all tiles of a colour form one element.
pub fn tiles(svg: &mut Svg, tiles: impl IntoIterator<Item = ([Pixel; 2], Colour)>) {
    let mut paths: Vec<(Colour, Path)> = Vec::new();
    for (corners, colour) in tiles {
        let known = paths.iter().position(|(other_colour, _)| *other_colour == colour);
        let index = known.unwrap_or_else(|| {
            paths.push((colour, Path::default()));
            paths.len() - 1
        });
        paths[index].1.add_rectangle(corners);
    }
    for (colour, path) in &paths {
        svg.crisp_path(path, *colour);
    }
}

/// Draws the border of a tile.
pub fn tile_border(svg: &mut Svg, corners: [Pixel; 2], edge: Colour) {
    svg.rectangle(corners, Paint::line(edge, 1.0));
}

/// Draws a tile with a border, given two opposite corners.
pub fn tile(svg: &mut Svg, corners: [Pixel; 2], fill: Colour, edge: Colour) {
    svg.rectangle(corners, Paint::fill(fill).with_edge(edge));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_is_too_wide_is_reduced_and_then_truncated() {
        assert_eq!((fitting_size("short", 15.0, 200.0), truncated("short", 15.0, 200.0)), (15.0, "short".to_string()));
        let long = "a name of thirty-three characters";
        let small = fitting_size(long, 15.0, 240.0);
        assert!((MIN_TEXT_SIZE..15.0).contains(&small) && text_width(long, small) <= 240.0, "{small}");
        assert_eq!(truncated(long, small, 240.0), long);
        let short = truncated(long, MIN_TEXT_SIZE, 100.0);
        assert!(short.ends_with('…') && short.len() > 12 && text_width(&short, MIN_TEXT_SIZE) <= 100.0, "{short}");
    }

    #[test]
    fn legend_entries_have_equal_text_size() {
        let entries = ["short", "a text that is rather too long for its legend"]
            .map(|text| LegendEntry::new(THIN_LINE, INK, text));
        let svg_text = document([99.0, 99.0], "", |svg| legend(svg, [0.0; 2], LEGEND_WIDTH, &entries));
        assert_eq!(svg_text.matches("font-size=\"11\"").count(), 2, "{svg_text}");
    }

    #[test]
    fn points_beyond_an_axis_are_clamped_to_its_end() {
        let frame_area = Area { left: 10.0, top: 20.0, width: 100.0, height: 50.0 };
        let frame = Frame { area: frame_area, x: Axis::from_range("", 0.0, 1.0), y: Axis::from_range("", 0.0, 1.0) };
        assert_eq!([(0.5, 0.5), (2.0, -1.0)].map(|position| frame.pixel(position)), [[60.0, 45.0], [110.0, 70.0]]);
    }

    #[test]
    fn tiles_of_a_colour_form_one_element() {
        let svg_text = document([9.0, 9.0], "", |svg| {
            let position = |x: f64| [[x, 0.0], [x + 1.0, 1.0]];
            tiles(svg, [(position(0.0), INK), (position(1.0), LINE), (position(2.0), INK)]);
        });
        assert_eq!(svg_text.matches("<path").count(), 2);
        assert!(svg_text.contains("<path d=\"M0 0h1v1h-1zm2 0h1v1h-1z\" fill=\"#1B1F26\""), "{svg_text}");
    }
}
