//! Pictures of a grasp at rest: the finger, its mirror image, the object, forces on it and a free motion; and a polar plot
//! of the accelerations that a gripper's grasp withstands in all directions, with a drawing of the gripper.

use std::f64::consts::TAU;

use super::canvas::{
    LegendEntry, Marker, PictureFormat, THIN_LINE, WIDTH, centred_style, legend, legend_height, text_centred,
    text_right_of,
};
use super::chart::round_step;
use super::outline::{Point, View, arrow, filled_outline, mirrored, outlines, palm};
use super::svg::{Paint, Path, Pixel, Svg, TextStyle};
use super::theme::{BLUE, Colour, GREEN, INK, LINE, OBJECT, ORANGE, PURPLE, SOFT};
use crate::drawing::Drawing;
use crate::format::numbers::G_M_S2;
use crate::grasp::FrictionCase;
use crate::grasp::finger::{Forces, Grasp, Palm};
use crate::grasp::gripper::GripperGrasp;
use crate::grasp::mechanism::MechanismGrasp;
use crate::gripper::{Posture, posture_at};
use crate::numeric::plane::add;
use crate::scene::Scene;
use crate::shape::max_radius;
use crate::statics::{Certificate, FormClosure, MechanismBalance, MechanismLimit, Unknown};
use crate::trace::Sample;

/// Width of the legend next to the grasp.
const LEGEND_WIDTH: f64 = 330.0;
/// Maximum number of entries of the legend.
const MAX_ENTRIES: usize = 4;
/// Extent of the drawn free motion of the object, as a fraction of its radius.
const MOTION_RADII: f64 = 0.2;
/// Extent of the drawn free motion of the fastest joint, rad.
const MOTION_RAD: f64 = 0.15;

/// Length of the arrow of the largest force, as a fraction of the object's radius.
const MAX_FORCE_LENGTH: f64 = 0.65;

/// Draws the grasp with the forces for the last friction coefficient.
pub fn grasp(scene: &Scene, found: &Grasp, picture_format: PictureFormat) -> String {
    let drawing = Drawing::from_scene(scene);
    let rest = link_outlines(scene, &drawing, &found.end.posture);
    let centre = found.object.centre_m;
    let object_outline = found.object.outline_m();
    let displaced_outlines = displaced_outlines(scene, found, &drawing);
    let both = |outline: &Vec<Point>| [outline.clone(), mirrored(outline, centre[0])];
    let mut points: Vec<Point> =
        rest.iter().map(|(outline, _)| outline).flat_map(both).flatten().chain(object_outline.clone()).collect();
    points.extend(displaced_outlines.iter().flatten());
    points.push([centre[0], -0.15 * max_radius(&found.object.shape)]);
    let (view, legend_corner, height) = match picture_format {
        PictureFormat::Standalone => {
            let left = picture_format.width() - LEGEND_WIDTH;
            let view = View::with_width(&points, left);
            (view, [left, 0.0], view.height().max(360.0))
        }
        PictureFormat::Column => {
            let view = View::with_width(&points, picture_format.width());
            (view, [0.0, view.height()], view.height() + legend_height(MAX_ENTRIES))
        }
    };
    let last = found.forces.last();
    let friction = last.map_or_else(String::new, |forces| match forces.mu_static {
        [a, b] if a == b => format!(", μ_s {a}"),
        [a, b] => format!(", μ_s {a} and {b}"),
    });
    let title = format!("{}: the grasp at rest{friction}; forces on the object", found.scene);
    picture_format.picture(&title, height, |svg| {
        if scene.hand.palm.is_some() {
            palm(svg, &view, centre[0]);
        }
        for (outline, fill) in &rest {
            let faded = Paint::fill(*fill).with_edge(SOFT).faded(0.5);
            filled_outline(svg, &view, &mirrored(outline, centre[0]), faded);
        }
        filled_outline(svg, &view, &object_outline, Paint::fill(OBJECT).with_edge(SOFT));
        for (outline, fill) in &rest {
            filled_outline(svg, &view, outline, Paint::fill(*fill).with_edge(INK));
        }
        for outline in &displaced_outlines {
            filled_outline(svg, &view, outline, Paint::line(GREEN, 1.0).dashed("5 4"));
        }
        let mut entries = last.map_or_else(Vec::new, |forces| arrows(svg, &view, found, forces));
        entries.push(closure(svg, &view, found));
        legend(svg, legend_corner, picture_format.width() - legend_corner[0], &entries);
    })
}

/// Outlines of the four links at a posture.
fn link_outlines(scene: &Scene, drawing: &Drawing, posture: &Posture) -> Vec<(Vec<Point>, Colour)> {
    let all = outlines(&drawing.bodies, &drawing.poses_for_postures(scene, &[*posture]));
    all.into_iter().filter(|(_, fill)| *fill != OBJECT).collect()
}

/// Displacement of the object and (q21, q22) of both fingers in the drawn free motion.
fn drawn_motion(found: &Grasp) -> Option<(Point, [[f64; 2]; 2])> {
    let FormClosure { certificate: Certificate::Motion { values, .. }, unknowns, .. } = &found.closure else {
        return None;
    };
    let rate_of = |unknown: Unknown| unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
    let object = [rate_of(Unknown::ObjectX), rate_of(Unknown::ObjectY)];
    let joints = [0, 1].map(|finger| [rate_of(Unknown::Proximal { finger }), rate_of(Unknown::Distal { finger })]);
    let fastest = joints.iter().flatten().fold(0.0, |max_rate: f64, rate| max_rate.max(rate.abs()));
    let speed = object[0].hypot(object[1]);
    let object_time = MOTION_RADII * max_radius(&found.object.shape) / speed;
    let time = object_time.min(MOTION_RAD / fastest);
    time.is_finite().then(|| (object.map(|v| v * time), joints.map(|rates| rates.map(|rate| rate * time))))
}

/// Outlines of object and links after the drawn free motion.
fn displaced_outlines(scene: &Scene, found: &Grasp, drawing: &Drawing) -> Vec<Vec<Point>> {
    let Some((displacement, joints)) = drawn_motion(found) else { return Vec::new() };
    let centre = found.object.centre_m;
    let mut displaced_outlines = Vec::new();
    if displacement != [0.0; 2] {
        displaced_outlines.push(found.object.at(add(centre, displacement)).outline_m());
    }
    for (finger, [q21, q22]) in joints.into_iter().enumerate() {
        let end = &found.end.posture;
        let linkage = &scene.finger().linkage;
        // The posture may not exist for a large motion; then the finger is not drawn.
        let Ok(posture) = posture_at(&linkage.lengths, linkage.assembly, end.q21_rad + q21, end.q22_rad + q22) else {
            continue;
        };
        let outlines = link_outlines(scene, drawing, &posture);
        displaced_outlines.extend(outlines.iter().map(|(outline, _)| match finger {
            0 => outline.clone(),
            _ => mirrored(outline, centre[0]),
        }));
    }
    displaced_outlines
}

/// Draws the forces on the object by both fingers and by the palm, and returns their legend entries.
fn arrows(svg: &mut Svg, view: &View, found: &Grasp, forces: &Forces) -> Vec<LegendEntry> {
    let centre = found.object.centre_m;
    let normal = [forces.equilibrium.f21_n, forces.equilibrium.f22_n];
    let palm_n = 2.0 * forces.equilibrium.pfp_n;
    let is_on_palm = found.palm.supports_object() && palm_n >= 0.0;
    let size = |i: usize| normal[i].abs() * 1f64.hypot(forces.mu_static[i]);
    let largest = size(0).max(size(1)).max(if is_on_palm { palm_n } else { 0.0 });
    let scale = if largest > 0.0 { MAX_FORCE_LENGTH * max_radius(&found.object.shape) / largest } else { 0.0 };
    let line = Marker::Line { width: 3.0 };
    let mut entries: Vec<LegendEntry> = Vec::new();
    for (i, (name, colour)) in
        [("F21, by the proximal phalanx", BLUE), ("F22, by the distal phalanx", ORANGE)].into_iter().enumerate()
    {
        let contact = &found.contacts[i];
        // The contact force on the object acts against n, the friction against t.
        let to = [0, 1].map(|k| {
            let push = contact.normal[k] + forces.mu_static[i] * contact.tangent[k];
            contact.point_m[k] - scale * normal[i] * push
        });
        let ends = [contact.point_m, to];
        for ends in [ends.to_vec(), mirrored(&ends, centre[0])] {
            arrow(svg, view.pixel(ends[0]), view.pixel(ends[1]), colour);
        }
        let pull = if normal[i] < 0.0 { "would have to pull " } else { "" };
        entries.push((line, colour, format!("{name}: {pull}{:.2} N", normal[i].abs())));
    }
    let text = match (found.palm, palm_n) {
        (Palm::None | Palm::Separated { .. }, _) => format!("PFP, towards the palm: {palm_n:.2} N"),
        (_, force) if force >= 0.0 => format!("2 PFP, by the palm: {force:.2} N"),
        (_, force) => format!("2 PFP, by the palm: would have to pull {:.2} N", -force),
    };
    if is_on_palm {
        let foot = found.object.lowest_point_m();
        arrow(svg, view.pixel(foot), view.pixel([foot[0], foot[1] + scale * palm_n]), PURPLE);
    }
    entries.push((line, PURPLE, text));
    entries
}

/// Legend entry on form closure; draws the motion of the object if the grasp is not form-closed.
fn closure(svg: &mut Svg, view: &View, found: &Grasp) -> LegendEntry {
    let centre = found.object.centre_m;
    let Some((displacement, _)) = drawn_motion(found) else {
        return (Marker::Circle, GREEN, "form-closed".to_string());
    };
    let length = displacement[0].hypot(displacement[1]);
    if length > 0.0 {
        let to = [0, 1].map(|i| centre[i] + 0.5 * max_radius(&found.object.shape) * displacement[i] / length);
        arrow(svg, view.pixel(centre), view.pixel(to), GREEN);
    }
    (THIN_LINE, GREEN, "not form-closed: a free motion".to_string())
}

/// Size of the polar plot.
const POLAR_SIZE: f64 = 620.0;
/// Margin for the labels around the polar plot.
const POLAR_MARGIN: f64 = 46.0;
/// Width of the column with the legend and the gripper.
const SIDE_WIDTH: f64 = WIDTH - POLAR_SIZE;
/// Height of the legend above the gripper.
const BALANCE_LEGEND_HEIGHT: f64 = 190.0;
/// Height of the gripper below the legend.
const GRIPPER_HEIGHT: f64 = 260.0;

/// Accelerations beyond this multiple of the median of the finite ones are cut off.
const MAX_OVER_MEDIAN: f64 = 3.0;

/// Direction of the labels of the circles, between the labelled directions.
const LABEL_DIRECTION_RAD: f64 = 0.125 * TAU;

/// Draws the balanced accelerations for the last friction coefficient.
pub fn balance(scene: &Scene, found: &GripperGrasp, picture_format: PictureFormat) -> String {
    let last = found.friction_cases.last();
    let plot = PolarPicture {
        title: polar_title(&found.scene, last.and_then(|case| case.mu_static)),
        curves: curves(last, ["motors blocked", "motors at their torque"]),
        directions: ["right", "down, out of the palm", "left", "up"],
        drawn: "the gripper, in the same directions",
        palm: scene.hand.palm.is_some().then(|| max_radius(&scene.hand.grasped().shape)),
    };
    plot.draw(scene, &found.sample, picture_format)
}

/// Draws a mechanism, and the accelerations of its base that its grasp withstands with the last friction coefficient.
pub fn mechanism_balance(scene: &Scene, found: &MechanismGrasp, picture_format: PictureFormat) -> String {
    let last = found.friction_cases.last();
    let plot = PolarPicture {
        title: polar_title(&found.scene, last.and_then(|case| case.mu_static)),
        curves: curves(last, ["actuators blocked", "actuators at their effort"]),
        directions: ["x", "y", "−x", "−y"],
        drawn: "the mechanism, in the same directions",
        palm: None,
    };
    plot.draw(scene, &found.sample, picture_format)
}

/// Curves of a friction case, with the drives blocked and at their effort.
fn curves(case: Option<&FrictionCase>, names: [&'static str; 2]) -> Vec<Curve> {
    let point = |balance: &MechanismBalance| {
        let limit_g = match balance.largest {
            MechanismLimit::Infeasible { .. } => None,
            MechanismLimit::Limited { acceleration_m_s2, .. } => Some(acceleration_m_s2 / G_M_S2),
            MechanismLimit::Unlimited => Some(f64::INFINITY),
        };
        (balance.direction, limit_g)
    };
    let balances = case.into_iter().flat_map(|case| names.into_iter().zip(&case.polar));
    balances.map(|(name, balances)| Curve { name, points: balances.iter().map(point).collect() }).collect()
}

fn polar_title(scene: &str, mu_static: Option<f64>) -> String {
    let friction = mu_static.map_or_else(String::new, |mu| format!(", μ_s {mu}"));
    format!("{scene}: accelerations of the palm that the grasp withstands{friction}")
}

/// A polar plot of accelerations beside the drawing of what is accelerated.
struct PolarPicture {
    title: String,
    curves: Vec<Curve>,
    /// Labels at 0, 90, 180 and 270°.
    directions: [&'static str; 4],
    /// Caption of the drawing.
    drawn: &'static str,
    /// Size of the object on a palm, if there is one.
    palm: Option<f64>,
}

/// Balanced accelerations by direction, in g: `None` if not even rest is balanced, infinite without a limit.
struct Curve {
    name: &'static str,
    points: Vec<([f64; 2], Option<f64>)>,
}

impl PolarPicture {
    fn draw(&self, scene: &Scene, sample: &Sample, picture_format: PictureFormat) -> String {
        // Corners of the legend and of the drawing, and the size of the latter.
        let side = if picture_format == PictureFormat::Standalone { POLAR_SIZE } else { picture_format.width() };
        let (legend_corner, corner, size) = match picture_format {
            PictureFormat::Standalone => {
                let height = POLAR_SIZE - BALANCE_LEGEND_HEIGHT - 40.0;
                ([side, 0.0], [side, BALANCE_LEGEND_HEIGHT], [SIDE_WIDTH - 20.0, height])
            }
            PictureFormat::Column => {
                ([0.0, side], [0.0, side + legend_height(MAX_ENTRIES)], [side - 20.0, GRIPPER_HEIGHT])
            }
        };
        picture_format.picture(&self.title, side.max(corner[1] + size[1] + 40.0), |svg| {
            let polar = PolarPlot::new(&self.curves, side);
            polar.draw_grid(svg, &self.directions);
            let mut entries: Vec<LegendEntry> = Vec::new();
            for (curve, colour) in self.curves.iter().zip([BLUE, ORANGE]) {
                polar.draw_curve(svg, curve, colour);
                entries.push((Marker::Line { width: 3.0 }, colour, curve.name.to_string()));
                entries.extend(polar.note(curve).map(|text| (Marker::Line { width: 0.0 }, colour, text)));
            }
            polar.draw_labels(svg);
            legend(svg, legend_corner, picture_format.width() - legend_corner[0], &entries);
            svg.translated(corner, |svg| self.draw_bodies(svg, scene, sample, size));
        })
    }

    /// Draws the bodies in their posture, in the same directions as the plot.
    fn draw_bodies(&self, svg: &mut Svg, scene: &Scene, sample: &Sample, size: [f64; 2]) {
        let drawing = Drawing::from_scene(scene);
        let bodies = outlines(&drawing.bodies, &drawing.poses(sample));
        let mut points: Vec<Point> = bodies.iter().flat_map(|(outline, _)| outline.iter().copied()).collect();
        points.extend(self.palm.map(|radius| [0.0, -0.35 * radius]));
        let view = View::within_size(&points, size);
        if self.palm.is_some() {
            palm(svg, &view, 0.0);
        }
        for (outline, fill) in &bodies {
            filled_outline(svg, &view, outline, Paint::fill(*fill).with_edge(SOFT));
        }
        text_right_of(svg, self.drawn, [24.0, view.height() + 10.0], 13.0, SOFT);
    }
}

/// Geometry of the polar plot; accelerations in g.
struct PolarPlot {
    max_g: f64,
    step_g: f64,
    size_px: f64,
}

impl PolarPlot {
    fn new(curves: &[Curve], size_px: f64) -> Self {
        let limits = curves.iter().flat_map(|curve| &curve.points).filter_map(|(_, limit_g)| *limit_g);
        let mut limited: Vec<f64> = limits.filter(|limit_g| limit_g.is_finite()).collect();
        limited.sort_by(f64::total_cmp);
        let largest = limited.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let median = limited.get(limited.len() / 2).copied().unwrap_or(largest);
        let max_shown = if median > 0.0 { largest.min(MAX_OVER_MEDIAN * median) } else { largest };
        let step_g = round_step(max_shown);
        PolarPlot { max_g: step_g * (max_shown / step_g).ceil().max(1.0), step_g, size_px }
    }

    fn radius(&self) -> f64 {
        0.5 * self.size_px - POLAR_MARGIN
    }

    /// Pixel of an acceleration, in g.
    fn pixel(&self, [x, y]: [f64; 2]) -> Pixel {
        let (middle, scale) = (0.5 * self.size_px, self.radius() / self.max_g);
        [middle + scale * x, middle - scale * y]
    }

    fn pixel_along(&self, g: f64, direction: [f64; 2]) -> Pixel {
        self.pixel(direction.map(|component| g * component))
    }

    fn circles(&self) -> impl Iterator<Item = f64> {
        let count = (self.max_g / self.step_g).round() as i32;
        (1..=count).map(|index| self.step_g * f64::from(index))
    }

    /// Draws circles, spokes and the labels of the directions.
    fn draw_grid(&self, svg: &mut Svg, directions: &[&str; 4]) {
        let middle = self.pixel([0.0; 2]);
        let mut grid = Path::default();
        for g in self.circles() {
            grid.add_circle(middle, self.radius() * g / self.max_g);
        }
        for index in 0..12 {
            let direction = direction_at(TAU * f64::from(index) / 12.0);
            grid = grid.with_polyline(&[middle, self.pixel_along(self.max_g, direction)]);
            let label_radius = self.radius() + 22.0;
            let text = match index {
                0 | 3 | 6 | 9 => directions[index as usize / 3].to_string(),
                _ => format!("{}°", 30 * index),
            };
            let position = [middle[0] + label_radius * direction[0], middle[1] - label_radius * direction[1]];
            text_centred(svg, &text, position, 15.0, INK);
        }
        svg.path(&grid, Paint::line(LINE, 1.0));
    }

    /// Draws the labels of the circles, on top of the curves.
    fn draw_labels(&self, svg: &mut Svg) {
        for g in self.circles() {
            let position = self.pixel_along(g, direction_at(LABEL_DIRECTION_RAD));
            let digits = usize::from(self.step_g < 1.0) + usize::from(self.step_g < 0.1);
            svg.text(&format!("{g:.digits$} g"), position, TextStyle { has_halo: true, ..centred_style(13.0, SOFT) });
        }
    }

    /// Draws the boundary of the balanced accelerations. Parts beyond the outermost circle are drawn on it as a thick
    /// line.
    fn draw_curve(&self, svg: &mut Svg, Curve { points, .. }: &Curve, colour: Colour) {
        if points.iter().all(|(_, limit_g)| limit_g.is_none()) {
            return;
        }
        // Whether each point is beyond the outermost circle, and its position.
        let point = |(direction, limit_g): &([f64; 2], Option<f64>)| {
            let limit_g = limit_g.unwrap_or(0.0);
            (limit_g > self.max_g, self.pixel_along(limit_g.min(self.max_g), *direction))
        };
        let all: Vec<(bool, Pixel)> = points.iter().chain(points.first()).map(point).collect();
        let outline: Vec<Pixel> = all.iter().map(|(_, pixel)| *pixel).collect();
        svg.polygon(&outline, Paint::fill(colour).faded(0.13));
        // Consecutive segments beyond the outermost circle form one thick line; the other segments are thin.
        let is_thick: Vec<bool> = all.windows(2).map(|pair| pair[0].0 && pair[1].0).collect();
        let mut from = 0;
        for piece in is_thick.chunk_by(|a, b| a == b) {
            let points = &outline[from..=from + piece.len()];
            from += piece.len();
            match piece[0] {
                true => svg.polyline(points, Paint::line(colour, 6.0)),
                false => {
                    svg.polyline(&without_collinear_points(points, 1e-6 * self.radius()), Paint::line(colour, 2.0));
                }
            }
        }
    }

    /// Note on parts that the curve does not show.
    fn note(&self, Curve { points, .. }: &Curve) -> Option<String> {
        let limits = || points.iter().filter_map(|(_, limit_g)| *limit_g);
        let any = limits().any(f64::is_infinite);
        let beyond = limits().any(|limit_g| limit_g.is_finite() && limit_g > self.max_g);
        match (any, beyond) {
            _ if limits().next().is_none() => Some("not held even at rest".to_string()),
            (true, true) => Some(format!("thick: any, or more than {} g", self.max_g)),
            (true, false) => Some("thick: any acceleration".to_string()),
            (false, true) => Some(format!("thick: more than {} g", self.max_g)),
            (false, false) => None,
        }
    }
}

/// Removes points on the line between their neighbours. The balanced accelerations form a polygon with straight sides.
fn without_collinear_points(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let mut corners: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for (index, &point) in points.iter().enumerate() {
        let (Some(&from), Some(&to)) = (corners.last(), points.get(index + 1)) else {
            corners.push(point);
            continue;
        };
        let (segment, offset) = ([to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]);
        let area = segment[0] * offset[1] - segment[1] * offset[0];
        if area.abs() > tolerance * segment[0].hypot(segment[1]) {
            corners.push(point);
        }
    }
    corners
}

fn direction_at(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos, sin]
}
