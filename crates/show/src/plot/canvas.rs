//! Elements of pictures: titles, markers, legends, tiles and text.

use super::svg::{Paint, Path, Pixel, Svg, TEXT_SIZE, TextStyle, document};
use super::theme::{Colour, INK, SOFT};

pub const WIDTH: f64 = 960.0;
/// Width of a legend next to a frame.
pub(crate) const LEGEND_WIDTH: f64 = 250.0;
/// Height of a title.
pub const TITLE_HEIGHT: f64 = 40.0;
/// Height of a legend entry.
const LINE_HEIGHT: f64 = 24.0;
/// Minimum size of text. Text that is too wide is reduced to this size, then truncated.
const MIN_TEXT_SIZE: f64 = 11.0;

/// Format of a picture: standalone, with a title and a legend on the right; or for a narrow column of a page, without
/// the title.
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

    /// Draws a picture. `height` does not include the height of the title.
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
pub type LegendEntry = (Marker, Colour, String);

/// Draws a picture with a title. The origin for `draw` is at the lower edge of the title.
pub fn picture(title: &str, height: f64, draw: impl FnOnce(&mut Svg)) -> String {
    document([WIDTH, height], title, |svg| {
        fitted_text(svg, title, [16.0, 24.0], 19.0, WIDTH - 32.0);
        svg.translated([0.0, TITLE_HEIGHT], draw);
    })
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

/// Draws a legend with this upper left corner and width. All entries have the same text size.
pub fn legend(svg: &mut Svg, [left, top]: Pixel, width: f64, entries: &[LegendEntry]) {
    let available_width = width - 48.0;
    let sizes = entries.iter().map(|(.., text)| fitting_size(text, TEXT_SIZE, available_width));
    let size = sizes.fold(TEXT_SIZE, f64::min);
    for (index, entry) in entries.iter().enumerate() {
        let y = top + 20.0 + LINE_HEIGHT * index as f64;
        legend_symbol(svg, [left + 20.0, y], entry);
        fitted_text(svg, &entry.2, [left + 42.0, y], size, available_width);
    }
}

/// Height of a legend with this number of entries.
pub(crate) fn legend_height(entries: usize) -> f64 {
    16.0 + LINE_HEIGHT * entries as f64
}

/// Draws a legend in one line.
pub(crate) fn horizontal_legend(svg: &mut Svg, entries: &[LegendEntry]) {
    let mut x = 16.0;
    for entry @ (.., text) in entries {
        legend_symbol(svg, [x + 10.0, 16.0], entry);
        text_right_of(svg, text, [x + 26.0, 16.0], TEXT_SIZE, INK);
        x += 26.0 + text_width(text, TEXT_SIZE) + 24.0;
    }
}

fn legend_symbol(svg: &mut Svg, [x, y]: Pixel, &(marker, colour, _): &LegendEntry) {
    let is_line = matches!(marker, Marker::Line { .. } | Marker::FaintLine { .. });
    let pixels = if is_line { vec![[x - 14.0, y], [x + 14.0, y]] } else { vec![[x, y]] };
    markers(svg, &pixels, marker, colour);
}

/// Draws colours and their labels side by side, in as many lines as needed. Returns the end of the last entry.
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
        svg.rectangle([[x, y - 8.0], [x + 22.0, y + 8.0]], Paint::fill(colour).with_edge(SOFT));
        text_right_of(svg, text, [x + 30.0, y], size, INK);
        x += long;
    }
    [x, y]
}

/// Draws text centred at a pixel.
pub fn text_centred(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, centred_style(size, colour));
}

/// Draws text that starts at a pixel.
pub fn text_right_of(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, TextStyle { anchor: "start", ..centred_style(size, colour) });
}

/// Draws text that ends at a pixel.
pub fn text_left_of(svg: &mut Svg, text: &str, position: Pixel, size: f64, colour: Colour) {
    svg.text(text, position, TextStyle { anchor: "end", ..centred_style(size, colour) });
}

/// Style of centred text.
pub fn centred_style(size: f64, colour: Colour) -> TextStyle {
    TextStyle { size, colour, anchor: "middle", is_vertical: false, has_halo: false }
}

/// Draws text that starts at a pixel, in a size that fits `width`.
pub fn fitted_text(svg: &mut Svg, text: &str, position: Pixel, size: f64, width: f64) {
    let size = fitting_size(text, size, width);
    text_right_of(svg, &truncated(text, size, width), position, size, INK);
}

/// Text size that fits `width`, but at least [`MIN_TEXT_SIZE`].
pub(crate) fn fitting_size(text: &str, size: f64, width: f64) -> f64 {
    (size * width / text_width(text, size).max(1.0)).floor().clamp(MIN_TEXT_SIZE, size)
}

/// Approximate width of a text in pixels, for the widest of the common fonts (DejaVu Sans).
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

/// Truncates a text to `width` pixels, with an ellipsis.
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
        let entries =
            ["short", "a text that is rather too long for its legend"].map(|text| (THIN_LINE, INK, text.to_string()));
        let svg_text = document([99.0, 99.0], "", |svg| legend(svg, [0.0; 2], LEGEND_WIDTH, &entries));
        assert_eq!(svg_text.matches("font-size=\"11\"").count(), 2, "{svg_text}");
    }

    #[test]
    fn tiles_of_a_colour_form_one_element() {
        let svg_text = document([9.0, 9.0], "", |svg| {
            let position = |x: f64| [[x, 0.0], [x + 1.0, 1.0]];
            tiles(svg, [(position(0.0), INK), (position(1.0), SOFT), (position(2.0), INK)]);
        });
        assert_eq!(svg_text.matches("<path").count(), 2);
        assert!(svg_text.contains("<path d=\"M0 0h1v1h-1zm2 0h1v1h-1z\" fill=\"#1B1F26\""), "{svg_text}");
    }
}
