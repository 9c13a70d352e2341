//! Bodies as filled outlines, on one scale for both axes, and arrows.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::canvas::words;
use super::svg::{Paint, Pixel, Svg};
use super::theme::{COUPLER, Colour, DISTAL, DRIVER, OBJECT, PALM, PROXIMAL, SOFT};
use crate::drawing::{Body, Part, Pose, Shape};

pub type Point = [f64; 2];

/// What is free around a view, in pixels.
pub const MARGIN: f64 = 24.0;

/// From the world to pixels: one scale for both axes.
pub struct View {
    pub low: Point,
    pub high: Point,
    pub scale: f64,
}

impl View {
    /// A view of all points, so wide in pixels.
    pub fn of(points: &[Point], width: f64) -> Self {
        let fold = |i: usize, pick: fn(f64, f64) -> f64, from: f64| points.iter().map(|p| p[i]).fold(from, pick);
        let low = [0, 1].map(|i| fold(i, f64::min, f64::INFINITY));
        let high = [0, 1].map(|i| fold(i, f64::max, f64::NEG_INFINITY));
        View { low, high, scale: (width - 2.0 * MARGIN) / (high[0] - low[0]) }
    }

    /// One that is neither wider nor higher.
    pub fn within(points: &[Point], [width, height]: [f64; 2]) -> Self {
        let view = View::of(points, width);
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

/// The outline of a shape of a body; none of a half plane.
pub fn outline(shape: &Shape, pose: &Pose) -> Vec<Point> {
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

/// Outlines of links and objects, in their colours; planes have none.
pub fn outlines(bodies: &[Body], poses: &[Pose]) -> Vec<(Vec<Point>, Colour)> {
    let of = |(body, pose): (&Body, &Pose)| {
        let fill = match body.part {
            Part::Driver => DRIVER,
            Part::Coupler => COUPLER,
            Part::Proximal => PROXIMAL,
            Part::Distal => DISTAL,
            Part::Object => OBJECT,
            Part::Palm | Part::Disc => return Vec::new(),
        };
        // The bar of a proximal phalanx lies within the surface that touches, but for its corners.
        let within = |shape: &&Shape| body.part == Part::Proximal && matches!(shape, Shape::Polygon { .. });
        body.shapes.iter().filter(|shape| !within(shape)).map(|shape| (outline(shape, pose), fill)).collect()
    };
    bodies.iter().zip(poses).flat_map(of).filter(|(outline, _)| !outline.is_empty()).collect()
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

/// An outline with its inside.
pub fn filled(svg: &mut Svg, view: &View, outline: &[Point], paint: Paint) {
    let pixels: Vec<Pixel> = outline.iter().map(|point| view.pixel(*point)).collect();
    svg.polygon(&pixels, paint);
}

/// The palm from its surface down, with its name.
pub fn palm(svg: &mut Svg, view: &View, middle_x: f64) {
    let [left, right] = [view.low[0], view.high[0]];
    let below = view.low[1];
    filled(svg, view, &[[left, 0.0], [right, 0.0], [right, below], [left, below]], Paint::fill(PALM));
    svg.polyline(&[view.pixel([left, 0.0]), view.pixel([right, 0.0])], Paint::line(SOFT, 2.0));
    words(svg, "palm", view.pixel([middle_x, 0.5 * below]), 13.0, SOFT);
}

/// The head of an arrow, at the end of a line.
pub fn head(svg: &mut Svg, from: Pixel, [x, y]: Pixel, size: f64, colour: Colour) {
    let [dx, dy] = [x - from[0], y - from[1]];
    let length = dx.hypot(dy);
    if length < 1e-9 {
        return;
    }
    let [dx, dy] = [size * dx / length, size * dy / length];
    let back = |aside: f64| [x - dx - aside * dy, y - dy + aside * dx];
    svg.polygon(&[[x, y], back(0.42), back(-0.42)], Paint::fill(colour));
}

/// An arrow between two places in pixels; one that is too short to be seen is not drawn.
pub fn arrow(svg: &mut Svg, from: Pixel, to: Pixel, colour: Colour) {
    let length = (to[0] - from[0]).hypot(to[1] - from[1]);
    if length < 2.0 {
        return;
    }
    let size = 11.0f64.min(0.7 * length);
    let part = 1.0 - 0.8 * size / length;
    let neck = [0, 1].map(|k| from[k] + part * (to[k] - from[k]));
    svg.polyline(&[from, neck], Paint::line(colour, 3.0));
    head(svg, from, to, size, colour);
}
