//! The accelerations that a grasp can bear, around all directions, with the gripper beside them.

use std::f64::consts::TAU;

use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, RGBColor};

use super::axis::round_step;
use super::canvas::{
    Area, BLACK, BLUE, COUPLER, DISTAL, DRIVER, DrawError, Entry, GREY, Mark, OBJECT, ORANGE, PALE, PALM, PROXIMAL,
    Pixel, WHITE, WIDTH, legend, picture, tile_plain, titled, words, words_from,
};
use super::outline::{Point, View, filled, outline};
use crate::criteria::Driven;
use crate::drawing::{Drawing, Part, Shape, poses};
use crate::grasp::gripper::{GripperGrasp, Holds};
use crate::scene::Scene;
use crate::statics::{Balance, Balanced};
use crate::wording::figures::G_M_S2;

/// Side of the polar plot, and room for the words around it.
const SIDE: u32 = 620;
const AROUND: f64 = 46.0;
const HEAD: u32 = 40;
const BESIDE: u32 = WIDTH - SIDE;
/// Height of the legend above the gripper.
const LEGEND: u32 = 190;

/// Accelerations beyond so many times the median of those that are limited run off the plot.
const OFF: f64 = 3.0;

/// Along which circles have their figures: between the directions that are named.
const FIGURES_RAD: f64 = 0.25 * TAU * 0.4;

/// The picture, with the last of the friction coefficients.
pub fn balance(scene: &Scene, found: &GripperGrasp) -> Result<String, DrawError> {
    let last = found.holds.last();
    let friction = last.and_then(|holds| holds.mu_static).map_or_else(String::new, |mu| format!(", μ_s {mu}"));
    picture(HEAD + SIDE, |area| {
        let title = format!("{}: accelerations of the palm that its grasp bears{friction}", found.scene);
        let below = titled(area, &title)?;
        let (left, right) = below.split_horizontally(SIDE);
        let polar = Polar::of(last);
        polar.ground(&left)?;
        let mut entries = Vec::new();
        for (driven, balances, colour) in curves(last) {
            polar.curve(&left, balances, colour)?;
            entries.push(Entry::new(Mark::Line { width: 3 }, colour, name(driven)));
            entries.extend(polar.remark(balances).map(|text| Entry::new(Mark::Line { width: 0 }, colour, &text)));
        }
        polar.figures(&left)?;
        let (above, hand) = right.split_vertically(LEGEND);
        legend(&above, &entries)?;
        silhouette(&hand, scene, found)
    })
}

fn name(driven: Driven) -> &'static str {
    match driven {
        Driven::Blocked => "motors blocked",
        Driven::AtTorque => "motors at their torque",
    }
}

fn curves(holds: Option<&Holds>) -> impl Iterator<Item = (Driven, &[Balance], RGBColor)> {
    let all = holds.into_iter().flat_map(|holds| Driven::BOTH.into_iter().zip(&holds.polar));
    all.zip([BLUE, ORANGE]).map(|((driven, balances), colour)| (driven, &balances[..], colour))
}

/// The scale of a polar plot, in g.
struct Polar {
    rim: f64,
    step: f64,
}

impl Polar {
    fn of(holds: Option<&Holds>) -> Self {
        let limited = curves(holds).flat_map(|(_, balances, _)| balances);
        let mut limited: Vec<f64> =
            limited.filter_map(|balance| Some(balance.largest.acceleration_m_s2()? / G_M_S2)).collect();
        limited.sort_by(f64::total_cmp);
        let largest = limited.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let median = limited.get(limited.len() / 2).copied().unwrap_or(largest);
        let most = if median > 0.0 { largest.min(OFF * median) } else { largest };
        let step = round_step(most);
        Polar { rim: step * (most / step).ceil().max(1.0), step }
    }

    fn radius() -> f64 {
        0.5 * f64::from(SIDE) - AROUND
    }

    /// Of an acceleration, in g.
    fn pixel(&self, [x, y]: [f64; 2]) -> Pixel {
        let (middle, scale) = (0.5 * f64::from(SIDE), Self::radius() / self.rim);
        ((middle + scale * x).round() as i32, (middle - scale * y).round() as i32)
    }

    fn along(&self, g: f64, direction: [f64; 2]) -> Pixel {
        self.pixel(direction.map(|part| g * part))
    }

    fn circle(&self, g: f64) -> Vec<Pixel> {
        (0..=180).map(|i| self.along(g, heading(TAU * f64::from(i) / 180.0))).collect()
    }

    fn circles(&self) -> impl Iterator<Item = f64> {
        let count = (self.rim / self.step).round() as i32;
        (1..=count).map(|index| self.step * f64::from(index))
    }

    /// Circles, spokes, and the directions by name.
    fn ground(&self, area: &Area) -> Result<(), DrawError> {
        for g in self.circles() {
            area.draw(&PathElement::new(self.circle(g), PALE.stroke_width(1)))?;
        }
        for index in 0..12 {
            let direction = heading(TAU * f64::from(index) / 12.0);
            let ends = vec![self.along(0.0, direction), self.along(self.rim, direction)];
            area.draw(&PathElement::new(ends, PALE.stroke_width(1)))?;
            let middle = 0.5 * f64::from(SIDE);
            let out = Self::radius() + 22.0;
            let at = ((middle + out * direction[0]).round() as i32, (middle - out * direction[1]).round() as i32);
            let text = match index {
                0 => "right".to_string(),
                3 => "down, out of the palm".to_string(),
                6 => "left".to_string(),
                9 => "up".to_string(),
                _ => format!("{}°", 30 * index),
            };
            words(area, &text, at, 15, BLACK)?;
        }
        Ok(())
    }

    /// What each circle stands for; over the curves.
    fn figures(&self, area: &Area) -> Result<(), DrawError> {
        for g in self.circles() {
            let (x, y) = self.along(g, heading(FIGURES_RAD));
            let digits = usize::from(self.step < 1.0) + usize::from(self.step < 0.1);
            let text = format!("{g:.digits$} g");
            let half = 4 * text.chars().count() as i32 + 2;
            tile_plain(area, [(x - half, y - 9), (x + half, y + 9)], WHITE)?;
            words(area, &text, (x, y), 13, GREY)?;
        }
        Ok(())
    }

    fn reach(&self, balance: &Balance) -> f64 {
        match &balance.largest {
            Balanced::Nothing => 0.0,
            Balanced::UpTo(limit) => limit.acceleration_m_s2 / G_M_S2,
            Balanced::Any => f64::INFINITY,
        }
    }

    /// The edge of what is balanced; where it is beyond the rim, along it and thick.
    fn curve(&self, area: &Area, balances: &[Balance], colour: RGBColor) -> Result<(), DrawError> {
        if balances.iter().all(|balance| balance.largest == Balanced::Nothing) {
            return Ok(());
        }
        let all: Vec<(bool, [f64; 2])> = balances
            .iter()
            .chain(balances.first())
            .map(|balance| {
                let reach = self.reach(balance);
                (reach > self.rim, balance.direction.map(|part| part * reach.min(self.rim)))
            })
            .collect();
        let pixels: Vec<Pixel> = all.iter().map(|(_, at)| self.pixel(*at)).collect();
        area.draw(&Polygon::new(pixels, colour.mix(0.13).filled()))?;
        // Each piece on one side of the rim is one line; what joins them belongs to the thin ones.
        let sides: Vec<(bool, [f64; 2], [f64; 2])> =
            all.windows(2).map(|pair| (pair[0].0 && pair[1].0, pair[0].1, pair[1].1)).collect();
        for piece in sides.chunk_by(|a, b| a.0 == b.0) {
            let points: Vec<[f64; 2]> =
                piece.iter().take(1).map(|side| side.1).chain(piece.iter().map(|side| side.2)).collect();
            let (points, width) = if piece[0].0 { (points, 6) } else { (straightened(&points, 1e-6 * self.rim), 2) };
            let pixels: Vec<Pixel> = points.into_iter().map(|at| self.pixel(at)).collect();
            area.draw(&PathElement::new(pixels, colour.stroke_width(width)))?;
        }
        Ok(())
    }

    /// What the curve does not show.
    fn remark(&self, balances: &[Balance]) -> Option<String> {
        let any = balances.iter().any(|balance| balance.largest == Balanced::Any);
        let beyond = balances
            .iter()
            .any(|balance| matches!(balance.largest, Balanced::UpTo(_)) && self.reach(balance) > self.rim);
        let nothing = balances.iter().all(|balance| balance.largest == Balanced::Nothing);
        match (nothing, any, beyond) {
            (true, ..) => Some("does not even hold at rest".to_string()),
            (_, true, true) => Some(format!("thick: any, or more than {} g", self.rim)),
            (_, true, false) => Some("thick: any acceleration".to_string()),
            (_, false, true) => Some(format!("thick: more than {} g", self.rim)),
            _ => None,
        }
    }
}

/// Without the points that lie on a line between their neighbours: what can be balanced is a polygon, whose sides are straight.
fn straightened(points: &[[f64; 2]], off: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for (index, &point) in points.iter().enumerate() {
        let (Some(&from), Some(&to)) = (kept.last(), points.get(index + 1)) else {
            kept.push(point);
            continue;
        };
        let (along, aside) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
        let area = along[0] * aside[1] - along[1] * aside[0];
        if area.abs() > off * along[0].hypot(along[1]) {
            kept.push(point);
        }
    }
    kept
}

fn heading(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos, sin]
}

/// The gripper as it stands, and which way the palm's axes point.
fn silhouette(area: &Area, scene: &Scene, found: &GripperGrasp) -> Result<(), DrawError> {
    let drawing = Drawing::of(scene);
    let poses = poses(scene, &found.sample);
    let mut outlines: Vec<(Vec<Point>, RGBColor)> = Vec::new();
    for (body, pose) in drawing.bodies.iter().zip(&poses) {
        let fill = match body.part {
            Part::Driver => DRIVER,
            Part::Coupler => COUPLER,
            Part::Proximal => PROXIMAL,
            Part::Distal => DISTAL,
            Part::Object => OBJECT,
            Part::Palm | Part::Disc => continue,
        };
        let shapes = body.shapes.iter().filter(|shape| !matches!(shape, Shape::HalfPlane { .. }));
        outlines.extend(shapes.map(|shape| (outline(shape, pose), fill)));
    }
    let mut points: Vec<Point> = outlines.iter().flat_map(|(outline, _)| outline.iter().copied()).collect();
    let radius = scene.system.grasped().radius_m;
    points.push([0.0, -0.35 * radius]);
    let view = View::within(&points, [BESIDE - 20, SIDE - LEGEND - 40]);
    if scene.system.palm.is_some() {
        let [left, right] = [view.low[0], view.high[0]];
        let below = view.low[1];
        filled(area, &view, &[[left, 0.0], [right, 0.0], [right, below], [left, below]], PALM.mix(1.0), PALM)?;
        words(area, "palm", view.pixel([0.0, 0.5 * below]), 13, GREY)?;
    }
    for (outline, fill) in &outlines {
        filled(area, &view, outline, fill.mix(1.0), GREY)?;
    }
    words_from(area, "the hand, with the same directions", (24, view.height() as i32 + 10), 13, GREY)
}
