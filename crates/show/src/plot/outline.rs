//! Bodies as filled outlines with equal scales of both axes, and arrows.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::canvas::text_centred;
use super::svg::{Paint, Pixel, Svg};
use super::theme::{COUPLER, Colour, DISTAL, DRIVER, OBJECT, PALM, PROXIMAL, SOFT};
use crate::drawing::{BodyRole, DrawnBody, FramePose, Shape};

pub type Point = [f64; 2];

/// Margin around a view, in pixels.
pub const MARGIN: f64 = 24.0;

/// Transformation from world coordinates to pixels, with the same scale for both axes.
#[derive(Clone, Copy)]
pub struct View {
    pub low: Point,
    pub high: Point,
    pub scale: f64,
}

impl View {
    /// Creates a view of all points that has a width in pixels.
    pub fn with_width(points: &[Point], width: f64) -> Self {
        let fold = |i: usize, pick: fn(f64, f64) -> f64, from: f64| points.iter().map(|p| p[i]).fold(from, pick);
        let low = [0, 1].map(|i| fold(i, f64::min, f64::INFINITY));
        let high = [0, 1].map(|i| fold(i, f64::max, f64::NEG_INFINITY));
        View { low, high, scale: (width - 2.0 * MARGIN) / (high[0] - low[0]) }
    }

    /// Creates a view of all points that fits within a width and a height in pixels.
    pub fn within_size(points: &[Point], [width, height]: [f64; 2]) -> Self {
        let view = View::with_width(points, width);
        let scale = (height - 2.0 * MARGIN) / (view.high[1] - view.low[1]);
        View { scale: view.scale.min(scale), ..view }
    }

    pub fn height(&self) -> f64 {
        (self.scale * (self.high[1] - self.low[1]) + 2.0 * MARGIN).round()
    }

    pub fn pixel(&self, [x, y]: Point) -> Pixel {
        [MARGIN + self.scale * (x - self.low[0]), MARGIN + self.scale * (self.high[1] - y)]
    }
}

/// Returns the outline of a shape of a body in the world; empty for a half plane.
pub fn outline(shape: &Shape, pose: &FramePose) -> Vec<Point> {
    match shape {
        Shape::Polygon { corners_m } => corners_m.iter().map(|corner| pose.apply(*corner)).collect(),
        Shape::Disc { radius_m } => circle(pose.position_m, *radius_m),
        Shape::HalfPlane { .. } => Vec::new(),
        Shape::Capsule { from_m, to_m, radius_m } => {
            let (from, to) = (pose.apply(*from_m), pose.apply(*to_m));
            let along = (to[1] - from[1]).atan2(to[0] - from[0]);
            let cap = |centre: Point, start: f64| {
                (0..=12).map(move |i| on_circle(centre, *radius_m, start + FRAC_PI_2 * f64::from(i) / 6.0))
            };
            cap(to, along - FRAC_PI_2).chain(cap(from, along + FRAC_PI_2)).collect()
        }
    }
}

/// Outlines of links and objects, with their colours. Planes have no outline.
pub fn outlines(bodies: &[DrawnBody], poses: &[FramePose]) -> Vec<(Vec<Point>, Colour)> {
    let colours = |(body, pose): (&DrawnBody, &FramePose)| {
        let fill = match body.role {
            BodyRole::Driver => DRIVER,
            BodyRole::Coupler => COUPLER,
            BodyRole::Proximal => PROXIMAL,
            BodyRole::Distal => DISTAL,
            BodyRole::Object => OBJECT,
            BodyRole::Palm => return Vec::new(),
        };
        // The bar of a proximal phalanx lies within its contact surface except for the corners, so it is omitted.
        let is_covered = |shape: &&Shape| body.role == BodyRole::Proximal && matches!(shape, Shape::Polygon { .. });
        body.shapes.iter().filter(|shape| !is_covered(shape)).map(|shape| (outline(shape, pose), fill)).collect()
    };
    bodies.iter().zip(poses).flat_map(colours).filter(|(outline, _)| !outline.is_empty()).collect()
}

fn on_circle(centre: Point, radius: f64, angle: f64) -> Point {
    [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
}

fn circle(centre: Point, radius: f64) -> Vec<Point> {
    (0..96).map(|i| on_circle(centre, radius, TAU * f64::from(i) / 96.0)).collect()
}

pub fn mirrored(outline: &[Point], about_x: f64) -> Vec<Point> {
    outline.iter().map(|[x, y]| [2.0 * about_x - x, *y]).collect()
}

/// Draws a filled outline.
pub fn filled_outline(svg: &mut Svg, view: &View, outline: &[Point], paint: Paint) {
    let pixels: Vec<Pixel> = outline.iter().map(|point| view.pixel(*point)).collect();
    svg.polygon(&pixels, paint);
}

/// Draws the palm below its surface, with its name.
pub fn palm(svg: &mut Svg, view: &View, middle_x: f64) {
    let [left, right] = [view.low[0], view.high[0]];
    let below = view.low[1];
    filled_outline(svg, view, &[[left, 0.0], [right, 0.0], [right, below], [left, below]], Paint::fill(PALM));
    svg.polyline(&[view.pixel([left, 0.0]), view.pixel([right, 0.0])], Paint::line(SOFT, 2.0));
    text_centred(svg, "palm", view.pixel([middle_x, 0.5 * below]), 13.0, SOFT);
}

/// Draws an arrow head at the end of a line.
pub fn arrow_head(svg: &mut Svg, from: Pixel, [x, y]: Pixel, size: f64, colour: Colour) {
    let [dx, dy] = [x - from[0], y - from[1]];
    let length = dx.hypot(dy);
    if length < 1e-9 {
        return;
    }
    let [dx, dy] = [size * dx / length, size * dy / length];
    let back = |normal: f64| [x - dx - normal * dy, y - dy + normal * dx];
    svg.polygon(&[[x, y], back(0.42), back(-0.42)], Paint::fill(colour));
}

/// Draws an arrow between two pixels; arrows of less than 2 pixels are omitted.
pub fn arrow(svg: &mut Svg, from: Pixel, to: Pixel, colour: Colour) {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    if length < 2.0 {
        return;
    }
    let size = 11.0f64.min(0.7 * length);
    let fraction = 1.0 - 0.8 * size / length;
    let shaft_end = [0, 1].map(|k| from[k] + fraction * (to[k] - from[k]));
    svg.polyline(&[from, shaft_end], Paint::line(colour, 3.0));
    arrow_head(svg, from, to, size, colour);
}
