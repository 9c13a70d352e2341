//! A grasp at rest: the finger, its mirror image, the object, forces on the object, and a free motion.

use super::canvas::{LegendEntry, Marker, PictureFormat, THIN_LINE, legend, legend_height};
use super::outline::{Point, View, arrow, filled_outline, mirrored, outlines, palm};
use super::svg::{Paint, Svg};
use super::theme::{BLUE, Colour, GREEN, INK, OBJECT, ORANGE, PURPLE, SOFT};
use crate::drawing::{Body, Drawing, poses_for_postures};
use crate::grasp::finger::{Forces, Grasp, Palm};
use crate::gripper::{Posture, posture_at};
use crate::scene::Scene;
use crate::shape::max_radius;
use crate::statics::{Certificate, FormClosure, Unknown};

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

/// Draws the grasp with the forces for the last of the friction coefficients.
pub fn grasp(scene: &Scene, found: &Grasp, picture_format: PictureFormat) -> String {
    let bodies = Drawing::from_scene(scene).bodies;
    let rest = link_outlines(scene, &bodies, &found.end.posture);
    let centre = found.object.centre_m;
    let object_outline = found.object.outline_m();
    let displaced_outlines = displaced_outlines(scene, found, &bodies);
    let both = |outline: &Vec<Point>| [outline.clone(), mirrored(outline, centre[0])];
    let mut points: Vec<Point> =
        rest.iter().map(|(outline, _)| outline).flat_map(both).flatten().chain(object_outline.clone()).collect();
    points.extend(displaced_outlines.iter().flatten());
    points.push([centre[0], -0.15 * max_radius(&found.object.shape)]);
    let left = if picture_format == PictureFormat::Standalone {
        picture_format.width() - LEGEND_WIDTH
    } else {
        picture_format.width()
    };
    let view = View::with_width(&points, left);
    let (legend_corner, height) = match picture_format {
        PictureFormat::Standalone => ([left, 0.0], view.height().max(360.0)),
        PictureFormat::Column => ([0.0, view.height()], view.height() + legend_height(MAX_ENTRIES)),
    };

    let last = found.forces.last();
    let friction = last.map_or_else(String::new, |forces| match forces.mu_static {
        [a, b] if a == b => format!(", μ_s {a}"),
        [a, b] => format!(", μ_s {a} and {b}"),
    });
    let title = format!("{}: the grasp at rest{friction}; forces on the object", found.scene);
    picture_format.picture(&title, height, |svg| {
        if scene.system.palm.is_some() {
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
fn link_outlines(scene: &Scene, bodies: &[Body], posture: &Posture) -> Vec<(Vec<Point>, Colour)> {
    let all = outlines(bodies, &poses_for_postures(scene, &[*posture]));
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
fn displaced_outlines(scene: &Scene, found: &Grasp, bodies: &[Body]) -> Vec<Vec<Point>> {
    let Some((displacement, joints)) = drawn_motion(found) else {
        return Vec::new();
    };
    let centre = found.object.centre_m;
    let mut displaced_outlines = Vec::new();
    if displacement != [0.0; 2] {
        displaced_outlines
            .push(found.object.at([centre[0] + displacement[0], centre[1] + displacement[1]]).outline_m());
    }
    for (finger, [q21, q22]) in joints.into_iter().enumerate() {
        let end = &found.end.posture;
        let linkage = &scene.finger().linkage;
        // The posture may not exist for a large motion; then the finger is not drawn.
        let Ok(posture) = posture_at(&linkage.lengths, linkage.assembly, end.q21_rad + q21, end.q22_rad + q22) else {
            continue;
        };
        let outlines = link_outlines(scene, bodies, &posture);
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
    let mut entries = Vec::new();
    for (i, (name, colour)) in
        [("F21, by the proximal phalanx", BLUE), ("F22, by the distal phalanx", ORANGE)].into_iter().enumerate()
    {
        let contact = &found.contacts[i];
        let is_pulling = normal[i] < 0.0;
        // The contact force on the object acts against n, the friction against t.
        let to = [0, 1].map(|k| {
            let push = contact.normal[k] + forces.mu_static[i] * contact.tangent[k];
            contact.point_m[k] - scale * normal[i] * push
        });
        let ends = [contact.point_m, to];
        for ends in [ends.to_vec(), mirrored(&ends, centre[0])] {
            arrow(svg, view.pixel(ends[0]), view.pixel(ends[1]), colour);
        }
        let text = match is_pulling {
            true => format!("{name}: would have to pull {:.2} N", -normal[i]),
            false => format!("{name}: {:.2} N", normal[i]),
        };
        entries.push(LegendEntry::new(line, colour, &text));
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
    entries.push(LegendEntry::new(line, PURPLE, &text));
    entries
}

/// Legend entry on form closure; draws the motion of the object if the grasp is not form-closed.
fn closure(svg: &mut Svg, view: &View, found: &Grasp) -> LegendEntry {
    let centre = found.object.centre_m;
    let Some((displacement, _)) = drawn_motion(found) else {
        return LegendEntry::new(Marker::Circle, GREEN, "form-closed");
    };
    let length = displacement[0].hypot(displacement[1]);
    if length > 0.0 {
        let to = [0, 1].map(|i| centre[i] + 0.5 * max_radius(&found.object.shape) * displacement[i] / length);
        arrow(svg, view.pixel(centre), view.pixel(to), GREEN);
    }
    LegendEntry::new(THIN_LINE, GREEN, "not form-closed: a free motion")
}
