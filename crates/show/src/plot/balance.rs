//! The accelerations that a grasp can bear, around all directions, with the gripper beside them.

use std::f64::consts::TAU;

use super::axis::round_step;
use super::canvas::{Entry, Form, Mark, WIDTH, around, legend, legend_height, words, words_from};
use super::outline::{Point, View, filled, outlines, palm};
use super::svg::{Paint, Path, Pixel, Svg, Words};
use super::theme::{BLUE, Colour, INK, LINE, ORANGE, SOFT};
use crate::criteria::Driven;
use crate::drawing::{Drawing, poses};
use crate::grasp::gripper::{GripperGrasp, Holds};
use crate::scene::Scene;
use crate::shape::reach;
use crate::statics::{Balance, Balanced};
use crate::wording::figures::G_M_S2;

/// Side of the polar plot, and room for the words around it.
const SIDE: f64 = 620.0;
const AROUND: f64 = 46.0;
const BESIDE: f64 = WIDTH - SIDE;
/// Height of the legend above the gripper, and its entries.
const LEGEND: f64 = 190.0;
const ENTRIES: usize = 4;
/// Height of the gripper below the legend.
const HAND: f64 = 260.0;

/// Accelerations beyond so many times the median of those that are limited run off the plot.
const OFF: f64 = 3.0;

/// Along which circles have their figures: between the directions that are named.
const FIGURES_RAD: f64 = 0.125 * TAU;

/// The picture, with the last of the friction coefficients.
pub fn balance(scene: &Scene, found: &GripperGrasp, form: Form) -> String {
    let last = found.holds.last();
    let friction = last.and_then(|holds| holds.mu_static).map_or_else(String::new, |mu| format!(", μ_s {mu}"));
    let title = format!("{}: accelerations of the palm that its grasp bears{friction}", found.scene);
    // Where the legend is, where the gripper, and how much room that has.
    let side = if form == Form::Sheet { SIDE } else { form.width() };
    let (corner, hand, room) = match form {
        Form::Sheet => ([side, 0.0], [side, LEGEND], [BESIDE - 20.0, SIDE - LEGEND - 40.0]),
        Form::Column => ([0.0, side], [0.0, side + legend_height(ENTRIES)], [side - 20.0, HAND]),
    };
    form.picture(&title, side.max(hand[1] + room[1] + 40.0), |svg| {
        let polar = Polar::of(last, side);
        polar.ground(svg);
        let mut entries = Vec::new();
        for (driven, balances, colour) in curves(last) {
            polar.curve(svg, balances, colour);
            entries.push(Entry::new(Mark::Line { width: 3.0 }, colour, name(driven)));
            entries.extend(polar.remark(balances).map(|text| Entry::new(Mark::Line { width: 0.0 }, colour, &text)));
        }
        polar.figures(svg);
        legend(svg, corner, form.width() - corner[0], &entries);
        svg.moved(hand, |svg| silhouette(svg, scene, found, room));
    })
}

fn name(driven: Driven) -> &'static str {
    match driven {
        Driven::Blocked => "motors blocked",
        Driven::AtTorque => "motors at their torque",
    }
}

fn curves(holds: Option<&Holds>) -> impl Iterator<Item = (Driven, &[Balance], Colour)> {
    let all = holds.into_iter().flat_map(|holds| Driven::BOTH.into_iter().zip(&holds.polar));
    all.zip([BLUE, ORANGE]).map(|((driven, balances), colour)| (driven, &balances[..], colour))
}

/// The scale of a polar plot, in g.
struct Polar {
    rim: f64,
    step: f64,
    side: f64,
}

impl Polar {
    fn of(holds: Option<&Holds>, side: f64) -> Self {
        let limited = curves(holds).flat_map(|(_, balances, _)| balances);
        let mut limited: Vec<f64> =
            limited.filter_map(|balance| Some(balance.largest.acceleration_m_s2()? / G_M_S2)).collect();
        limited.sort_by(f64::total_cmp);
        let largest = limited.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let median = limited.get(limited.len() / 2).copied().unwrap_or(largest);
        let most = if median > 0.0 { largest.min(OFF * median) } else { largest };
        let step = round_step(most);
        Polar { rim: step * (most / step).ceil().max(1.0), step, side }
    }

    fn radius(&self) -> f64 {
        0.5 * self.side - AROUND
    }

    /// Of an acceleration, in g.
    fn pixel(&self, [x, y]: [f64; 2]) -> Pixel {
        let (middle, scale) = (0.5 * self.side, self.radius() / self.rim);
        [middle + scale * x, middle - scale * y]
    }

    fn along(&self, g: f64, direction: [f64; 2]) -> Pixel {
        self.pixel(direction.map(|part| g * part))
    }

    fn circles(&self) -> impl Iterator<Item = f64> {
        let count = (self.rim / self.step).round() as i32;
        (1..=count).map(|index| self.step * f64::from(index))
    }

    /// Circles, spokes, and the directions by name.
    fn ground(&self, svg: &mut Svg) {
        let middle = self.pixel([0.0; 2]);
        let mut grid = Path::default();
        for g in self.circles() {
            grid.ring(middle, self.radius() * g / self.rim);
        }
        for index in 0..12 {
            let direction = heading(TAU * f64::from(index) / 12.0);
            grid = grid.through(&[middle, self.along(self.rim, direction)]);
            let out = self.radius() + 22.0;
            let text = match index {
                0 => "right".to_string(),
                3 => "down, out of the palm".to_string(),
                6 => "left".to_string(),
                9 => "up".to_string(),
                _ => format!("{}°", 30 * index),
            };
            words(svg, &text, [middle[0] + out * direction[0], middle[1] - out * direction[1]], 15.0, INK);
        }
        svg.path(&grid, Paint::line(LINE, 1.0));
    }

    /// What each circle stands for; over the curves.
    fn figures(&self, svg: &mut Svg) {
        for g in self.circles() {
            let at = self.along(g, heading(FIGURES_RAD));
            let digits = usize::from(self.step < 1.0) + usize::from(self.step < 0.1);
            svg.words(&format!("{g:.digits$} g"), at, Words { rim: true, ..around(13.0, SOFT) });
        }
    }

    fn reach(&self, balance: &Balance) -> f64 {
        match &balance.largest {
            Balanced::Nothing => 0.0,
            Balanced::UpTo(limit) => limit.acceleration_m_s2 / G_M_S2,
            Balanced::Any => f64::INFINITY,
        }
    }

    /// The edge of what is balanced; where it is beyond the rim, along it and thick.
    fn curve(&self, svg: &mut Svg, balances: &[Balance], colour: Colour) {
        if balances.iter().all(|balance| balance.largest == Balanced::Nothing) {
            return;
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
        svg.polygon(&pixels, Paint::fill(colour).faded(0.13));
        // Each piece on one side of the rim is one line; what joins them belongs to the thin ones.
        let sides: Vec<(bool, [f64; 2], [f64; 2])> =
            all.windows(2).map(|pair| (pair[0].0 && pair[1].0, pair[0].1, pair[1].1)).collect();
        for piece in sides.chunk_by(|a, b| a.0 == b.0) {
            let points: Vec<[f64; 2]> =
                piece.iter().take(1).map(|side| side.1).chain(piece.iter().map(|side| side.2)).collect();
            let (points, width) =
                if piece[0].0 { (points, 6.0) } else { (straightened(&points, 1e-6 * self.rim), 2.0) };
            let pixels: Vec<Pixel> = points.into_iter().map(|at| self.pixel(at)).collect();
            svg.polyline(&pixels, Paint::line(colour, width));
        }
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
fn silhouette(svg: &mut Svg, scene: &Scene, found: &GripperGrasp, room: [f64; 2]) {
    let bodies = outlines(&Drawing::of(scene).bodies, &poses(scene, &found.sample));
    let mut points: Vec<Point> = bodies.iter().flat_map(|(outline, _)| outline.iter().copied()).collect();
    points.push([0.0, -0.35 * reach(&scene.system.grasped().shape)]);
    let view = View::within(&points, room);
    if scene.system.palm.is_some() {
        palm(svg, &view, 0.0);
    }
    for (outline, fill) in &bodies {
        filled(svg, &view, outline, Paint::fill(*fill).with_edge(SOFT));
    }
    words_from(svg, "the hand, with the same directions", [24.0, view.height() + 10.0], 13.0, SOFT);
}
