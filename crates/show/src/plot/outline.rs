//! Bodies as filled outlines, on one scale for both axes.

use std::f64::consts::{FRAC_PI_2, TAU};

use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, RGBColor};

use super::canvas::{Area, DrawError, Pixel};
use crate::drawing::{Pose, Shape};

pub type Point = [f64; 2];

const MARGIN: f64 = 24.0;

/// From the world to pixels of an area: one scale for both axes.
pub struct View {
    pub low: Point,
    pub high: Point,
    pub scale: f64,
}

impl View {
    /// A view of all points, so wide in pixels.
    pub fn of(points: &[Point], width: u32) -> Self {
        let fold = |i: usize, pick: fn(f64, f64) -> f64, from: f64| points.iter().map(|p| p[i]).fold(from, pick);
        let low = [0, 1].map(|i| fold(i, f64::min, f64::INFINITY));
        let high = [0, 1].map(|i| fold(i, f64::max, f64::NEG_INFINITY));
        View { low, high, scale: (f64::from(width) - 2.0 * MARGIN) / (high[0] - low[0]) }
    }

    /// One that is neither wider nor higher.
    pub fn within(points: &[Point], [width, height]: [u32; 2]) -> Self {
        let view = View::of(points, width);
        let scale = (f64::from(height) - 2.0 * MARGIN) / (view.high[1] - view.low[1]);
        View { scale: view.scale.min(scale), ..view }
    }

    pub fn height(&self) -> u32 {
        (self.scale * (self.high[1] - self.low[1]) + 2.0 * MARGIN).round() as u32
    }

    pub fn pixel(&self, [x, y]: Point) -> Pixel {
        let place = |distance: f64| (MARGIN + self.scale * distance).round() as i32;
        (place(x - self.low[0]), place(self.high[1] - y))
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

fn on_circle(centre: Point, radius: f64, angle: f64) -> Point {
    [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
}

pub fn circle(centre: Point, radius: f64) -> Vec<Point> {
    (0..96).map(|i| on_circle(centre, radius, TAU * f64::from(i) / 96.0)).collect()
}

/// An outline with its inside.
pub fn filled(area: &Area, view: &View, outline: &[Point], fill: impl Color, edge: RGBColor) -> Result<(), DrawError> {
    let mut pixels: Vec<Pixel> = outline.iter().map(|point| view.pixel(*point)).collect();
    area.draw(&Polygon::new(pixels.clone(), fill.filled()))?;
    pixels.extend(pixels.first().copied());
    area.draw(&PathElement::new(pixels, edge.stroke_width(1)))
}
