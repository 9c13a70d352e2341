//! Fonts, colours, frames, and legends that stand beside the frames, where they cover nothing.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, Cross, PathElement, Rectangle, Text, TriangleMarker};
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, RGBColor, ShapeStyle, TextStyle};

use super::axis::Axis;
use super::dark::with_dark;

/// Why a picture could not be drawn. Drawing to a text in memory does not fail by itself.
pub type DrawError = DrawingAreaErrorKind<std::io::Error>;
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Frame<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<Axis, Axis>>;
/// A place on a frame, and one in pixels of an area.
type Place = (f64, f64);
pub type Pixel = (i32, i32);

pub const WIDTH: u32 = 960;
/// Width of a legend beside a frame.
pub const LEGEND: u32 = 220;
/// Of curves, in turn.
pub const COLOURS: [RGBColor; 6] = [BLUE, ORANGE, GREEN, PURPLE, AMBER, GREY];
const FONT: &str = "sans-serif";
const TITLE_SIZE: u32 = 19;
const TEXT_SIZE: u32 = 15;
const LINE_HEIGHT: i32 = 24;

/// Colours that stay apart for every kind of eye (Okabe and Ito).
pub const BLUE: RGBColor = RGBColor(0, 114, 178);
pub const ORANGE: RGBColor = RGBColor(213, 94, 0);
pub const GREEN: RGBColor = RGBColor(0, 158, 115);
pub const PURPLE: RGBColor = RGBColor(170, 80, 140);
pub const AMBER: RGBColor = RGBColor(200, 140, 0);
pub const BLACK: RGBColor = RGBColor(0, 0, 0);
pub const GREY: RGBColor = RGBColor(120, 120, 120);
pub const WHITE: RGBColor = RGBColor(255, 255, 255);
/// The parts of a finger and what is around it, as on the page.
pub const DRIVER: RGBColor = RGBColor(185, 194, 207);
pub const COUPLER: RGBColor = RGBColor(211, 217, 226);
pub const PROXIMAL: RGBColor = RGBColor(169, 210, 236);
pub const DISTAL: RGBColor = RGBColor(245, 199, 161);
pub const OBJECT: RGBColor = RGBColor(227, 220, 203);
pub const PALM: RGBColor = RGBColor(228, 231, 236);
pub const PALE: RGBColor = RGBColor(232, 232, 232);
const PALEST: RGBColor = RGBColor(246, 246, 246);

/// The sign of a family of points, and how a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Circle,
    Triangle,
    Square,
    Cross,
    Ring,
    /// Smaller ones, for hundreds of points, and a single pixel for thousands.
    SmallTriangle,
    SmallDot,
    Speck,
    Line {
        width: u32,
    },
    Pale {
        width: u32,
    },
}

/// Every picture has it at its beginning.
pub const PICTURE_MARK: &str = "<!-- phalanx -->";

/// One line of a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    pub mark: Mark,
    pub colour: RGBColor,
    pub text: String,
}

impl Entry {
    pub fn new(mark: Mark, colour: RGBColor, text: &str) -> Entry {
        Entry { mark, colour, text: text.to_string() }
    }
}

/// Draws a picture of a height into a text.
pub fn picture(height: u32, draw: impl FnOnce(&Area) -> Result<(), DrawError>) -> Result<String, DrawError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
    }
    Ok(finished(&with_dark(&text)))
}

/// Says in the picture whose it is, behind the tag that opens it. XML has no place for control characters, not even escaped.
fn finished(svg: &str) -> String {
    let svg = svg.replace(|c: char| c.is_control() && !matches!(c, '\n' | '\t'), "\u{fffd}");
    match svg.split_once('>') {
        Some((tag, rest)) => format!("{tag}>\n{PICTURE_MARK}{rest}"),
        None => svg,
    }
}

/// The title of a picture; what is left of the area below it.
pub fn titled<'a>(area: &Area<'a>, title: &str) -> Result<Area<'a>, DrawError> {
    let (head, rest) = area.split_vertically(TITLE_SIZE + 21);
    head.draw(&Text::new(title.to_string(), (16, 14), font(TITLE_SIZE)))?;
    Ok(rest)
}

/// An empty frame with its axes; `foot` says whether the label and the figures of the horizontal axis are there.
pub fn frame<'a>(area: &Area<'a>, x: &Axis, y: &Axis, foot: bool) -> Result<Frame<'a>, DrawError> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(8)
        .margin_right(12)
        .margin_left(8)
        .x_label_area_size(if foot { 50 } else { 12 })
        .y_label_area_size(78)
        .build_cartesian_2d(x.clone(), y.clone())?;
    for (axis, upright) in [(x, true), (y, false)] {
        let other = if upright { y } else { x };
        let lines = axis.between.iter().map(|&at| (at, PALEST)).chain(axis.ticks.iter().map(|&at| (at, PALE)));
        for (at, colour) in lines {
            let ends = match upright {
                true => vec![(at, other.from), (at, other.to)],
                false => vec![(other.from, at), (other.to, at)],
            };
            chart.draw_series([PathElement::new(ends, colour)])?;
        }
    }
    let mut mesh = chart.configure_mesh();
    mesh.disable_mesh().label_style(font(TEXT_SIZE)).axis_desc_style(font(TEXT_SIZE)).y_desc(&y.label);
    mesh.axis_style(GREY);
    let x_text = |tick: &f64| if foot { x.text(*tick) } else { String::new() };
    let y_text = |tick: &f64| y.text(*tick);
    mesh.y_label_formatter(&y_text).x_label_formatter(&x_text);
    mesh.y_labels(y.ticks.len()).x_labels(x.ticks.len());
    if foot {
        mesh.x_desc(&x.label);
    }
    mesh.draw()?;
    Ok(chart)
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (low, high): (i32, i32)) -> i32 {
        low + ((value - self.from) / (self.to - self.from) * f64::from(high - low)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.from..self.to
    }
}

/// A line on a frame.
pub fn line(frame: &mut Frame, points: Vec<Place>, mark: Mark, colour: RGBColor) -> Result<(), DrawError> {
    frame.draw_series([PathElement::new(points, stroke(mark, colour))])?;
    Ok(())
}

/// A mark on a frame.
pub fn point(frame: &mut Frame, at: Place, mark: Mark, colour: RGBColor) -> Result<(), DrawError> {
    let pixel = frame.backend_coord(&at);
    let area = frame.plotting_area().strip_coord_spec();
    let origin = area.get_base_pixel();
    sign(&area, (pixel.0 - origin.0, pixel.1 - origin.1), mark, colour)
}

/// A legend from the top of an area.
pub fn legend(area: &Area, entries: &[Entry]) -> Result<(), DrawError> {
    for (index, entry) in entries.iter().enumerate() {
        let y = 20 + LINE_HEIGHT * index as i32;
        match entry.mark {
            Mark::Line { .. } | Mark::Pale { .. } => {
                area.draw(&PathElement::new(vec![(6, y), (34, y)], stroke(entry.mark, entry.colour)))?;
            }
            mark => sign(area, (20, y), mark, entry.colour)?,
        }
        area.draw(&Text::new(entry.text.clone(), (44, y - TEXT_SIZE as i32 / 2), font(TEXT_SIZE)))?;
    }
    Ok(())
}

/// A legend in one line, from the left of an area.
pub fn legend_across(area: &Area, entries: &[Entry]) -> Result<(), DrawError> {
    let mut x = 16;
    for entry in entries {
        sign(area, (x + 10, 16), entry.mark, entry.colour)?;
        area.draw(&Text::new(entry.text.clone(), (x + 26, 16 - TEXT_SIZE as i32 / 2), font(TEXT_SIZE)))?;
        // A little generous for the width of letters.
        x += 26 + (entry.text.chars().count() as f64 * 0.56 * f64::from(TEXT_SIZE)) as i32 + 24;
    }
    Ok(())
}

/// A mark at a place of an area, in pixels.
pub fn mark(area: &Area, at: Pixel, mark: Mark, colour: RGBColor) -> Result<(), DrawError> {
    sign(area, at, mark, colour)
}

/// A thin line between two places of an area, in pixels.
pub fn line_between(area: &Area, ends: [Pixel; 2], colour: RGBColor) -> Result<(), DrawError> {
    area.draw(&PathElement::new(ends.to_vec(), colour.stroke_width(1)))
}

/// Words around a place of an area, in pixels.
pub fn words(area: &Area, text: &str, at: Pixel, size: u32, colour: RGBColor) -> Result<(), DrawError> {
    anchored(area, text, at, (size, colour), HPos::Center)
}

/// Words from a place to the right.
pub fn words_from(area: &Area, text: &str, at: Pixel, size: u32, colour: RGBColor) -> Result<(), DrawError> {
    anchored(area, text, at, (size, colour), HPos::Left)
}

/// Words up to a place.
pub fn words_to(area: &Area, text: &str, at: Pixel, size: u32, colour: RGBColor) -> Result<(), DrawError> {
    anchored(area, text, at, (size, colour), HPos::Right)
}

fn anchored(area: &Area, text: &str, at: Pixel, (size, colour): (u32, RGBColor), side: HPos) -> Result<(), DrawError> {
    let style = (FONT, size).into_font().color(&colour).pos(Pos::new(side, VPos::Center));
    area.draw(&Text::new(text.to_string(), at, style))
}

/// A box without an edge.
pub fn tile_plain(area: &Area, corners: [Pixel; 2], fill: RGBColor) -> Result<(), DrawError> {
    area.draw(&Rectangle::new(corners, ShapeStyle::from(&fill).filled()))
}

/// The edge of a box.
pub fn outline(area: &Area, corners: [Pixel; 2], edge: RGBColor) -> Result<(), DrawError> {
    area.draw(&Rectangle::new(corners, edge.stroke_width(1)))
}

/// A box with its edge, from one corner to the other.
pub fn tile(area: &Area, corners: [Pixel; 2], fill: RGBColor, edge: RGBColor) -> Result<(), DrawError> {
    tile_plain(area, corners, fill)?;
    outline(area, corners, edge)
}

fn sign(area: &Area, at: Pixel, mark: Mark, colour: RGBColor) -> Result<(), DrawError> {
    let filled = ShapeStyle::from(&colour).filled();
    match mark {
        Mark::Circle => area.draw(&Circle::new(at, 5, filled)),
        Mark::Triangle => area.draw(&TriangleMarker::new(at, 7, filled)),
        Mark::Square => area.draw(&Rectangle::new([(at.0 - 5, at.1 - 5), (at.0 + 5, at.1 + 5)], filled)),
        Mark::Cross => area.draw(&Cross::new(at, 6, colour.stroke_width(3))),
        Mark::Ring => area.draw(&Circle::new(at, 10, colour.stroke_width(2))),
        Mark::SmallTriangle => area.draw(&TriangleMarker::new(at, 5, filled)),
        Mark::SmallDot => area.draw(&Circle::new(at, 2, filled)),
        Mark::Speck => area.draw(&Circle::new(at, 1, filled)),
        Mark::Line { .. } | Mark::Pale { .. } => Ok(()),
    }
}

fn stroke(mark: Mark, colour: RGBColor) -> ShapeStyle {
    match mark {
        Mark::Line { width } => colour.stroke_width(width),
        Mark::Pale { width } => colour.mix(0.35).stroke_width(width),
        _ => colour.stroke_width(2),
    }
}

fn font(size: u32) -> TextStyle<'static> {
    (FONT, size).into_font().color(&BLACK)
}
