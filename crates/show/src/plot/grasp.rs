//! A grasp at rest: the finger, its mirror image, the object, forces on the object, and a motion that is free.

use super::canvas::{Entry, Form, Mark, THIN, legend, legend_height};
use super::outline::{Point, View, arrow, filled, mirrored, outlines, palm};
use super::svg::{Paint, Svg};
use super::theme::{BLUE, Colour, GREEN, INK, OBJECT, ORANGE, PURPLE, SOFT};
use crate::drawing::{Body, Drawing, poses_in};
use crate::grasp::finger::{Forces, Grasp, Palm};
use crate::gripper::{Posture, posture_at};
use crate::scene::Scene;
use crate::shape::reach;
use crate::statics::{Certificate, FormClosure, Unknown};

/// Width of the legend beside the grasp, and its entries.
const BESIDE: f64 = 330.0;
const ENTRIES: usize = 4;
/// How far the free motion is drawn: the object by a part of its radius, or the fastest joint by an angle.
const SHOWN_RADII: f64 = 0.2;
const SHOWN_RAD: f64 = 0.15;

/// The largest force is drawn as long as this part of the object's radius.
const LONGEST: f64 = 0.65;

/// The picture, with the forces of the last of the friction coefficients.
pub fn grasp(scene: &Scene, found: &Grasp, form: Form) -> String {
    let bodies = Drawing::of(scene).bodies;
    let rest = links(scene, &bodies, &found.end.posture);
    let centre = found.object.centre_m;
    let round = found.object.outline_m();
    let ghosts = ghosts(scene, found, &bodies);
    let both = |outline: &Vec<Point>| [outline.clone(), mirrored(outline, centre[0])];
    let mut points: Vec<Point> =
        rest.iter().map(|(outline, _)| outline).flat_map(both).flatten().chain(round.clone()).collect();
    points.extend(ghosts.iter().flatten());
    points.push([centre[0], -0.15 * reach(&found.object.shape)]);
    let left = if form == Form::Sheet { form.width() - BESIDE } else { form.width() };
    let view = View::of(&points, left);
    let (corner, height) = match form {
        Form::Sheet => ([left, 0.0], view.height().max(360.0)),
        Form::Column => ([0.0, view.height()], view.height() + legend_height(ENTRIES)),
    };

    let last = found.forces.last();
    let friction = last.map_or_else(String::new, |forces| match forces.mu_static {
        [a, b] if a == b => format!(", μ_s {a}"),
        [a, b] => format!(", μ_s {a} and {b}"),
    });
    let title = format!("{}: the grasp at rest{friction}; forces on the object", found.scene);
    form.picture(&title, height, |svg| {
        if scene.system.palm.is_some() {
            palm(svg, &view, centre[0]);
        }
        for (outline, fill) in &rest {
            let faded = Paint::fill(*fill).with_edge(SOFT).faded(0.5);
            filled(svg, &view, &mirrored(outline, centre[0]), faded);
        }
        filled(svg, &view, &round, Paint::fill(OBJECT).with_edge(SOFT));
        for (outline, fill) in &rest {
            filled(svg, &view, outline, Paint::fill(*fill).with_edge(INK));
        }
        for outline in &ghosts {
            filled(svg, &view, outline, Paint::line(GREEN, 1.0).dashed("5 4"));
        }
        let mut entries = last.map_or_else(Vec::new, |forces| arrows(svg, &view, found, forces));
        entries.push(closure(svg, &view, found));
        legend(svg, corner, form.width() - corner[0], &entries);
    })
}

/// Outlines of the four links at a posture.
fn links(scene: &Scene, bodies: &[Body], posture: &Posture) -> Vec<(Vec<Point>, Colour)> {
    let all = outlines(bodies, &poses_in(scene, &[*posture]));
    all.into_iter().filter(|(_, fill)| *fill != OBJECT).collect()
}

/// The velocity of the object and (q̇21, q̇22) of both fingers in a free motion, for as long as it is drawn.
fn shown(found: &Grasp) -> Option<(Point, [[f64; 2]; 2])> {
    let FormClosure { certificate: Certificate::Motion { values, .. }, unknowns, .. } = &found.closure else {
        return None;
    };
    let of = |unknown: Unknown| unknowns.iter().position(|&k| k == unknown).map_or(0.0, |i| values[i]);
    let object = [of(Unknown::ObjectX), of(Unknown::ObjectY)];
    let joints = [0, 1].map(|finger| [of(Unknown::Proximal { finger }), of(Unknown::Distal { finger })]);
    let fastest = joints.iter().flatten().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    let speed = object[0].hypot(object[1]);
    let by_object = SHOWN_RADII * reach(&found.object.shape) / speed;
    let time = by_object.min(SHOWN_RAD / fastest);
    time.is_finite().then(|| (object.map(|v| v * time), joints.map(|rates| rates.map(|rate| rate * time))))
}

/// Outlines of everything a little later.
fn ghosts(scene: &Scene, found: &Grasp, bodies: &[Body]) -> Vec<Vec<Point>> {
    let Some((moved, joints)) = shown(found) else {
        return Vec::new();
    };
    let centre = found.object.centre_m;
    let mut ghosts = Vec::new();
    if moved != [0.0; 2] {
        ghosts.push(found.object.at([centre[0] + moved[0], centre[1] + moved[1]]).outline_m());
    }
    for (finger, [q21, q22]) in joints.into_iter().enumerate() {
        let end = &found.end.posture;
        let of = &scene.finger().linkage;
        // A large motion may have no posture: then only the object is drawn.
        let Ok(posture) = posture_at(&of.lengths, of.assembly, end.q21_rad + q21, end.q22_rad + q22) else {
            continue;
        };
        let outlines = links(scene, bodies, &posture);
        ghosts.extend(outlines.iter().map(|(outline, _)| match finger {
            0 => outline.clone(),
            _ => mirrored(outline, centre[0]),
        }));
    }
    ghosts
}

/// Forces on the object by both fingers and by the palm, and what the legend says of them.
fn arrows(svg: &mut Svg, view: &View, found: &Grasp, forces: &Forces) -> Vec<Entry> {
    let centre = found.object.centre_m;
    let normal = [forces.equilibrium.f21_n, forces.equilibrium.f22_n];
    let palm_n = 2.0 * forces.equilibrium.pfp_n;
    let held = found.palm.holds() && palm_n >= 0.0;
    let size = |i: usize| normal[i].abs() * 1f64.hypot(forces.mu_static[i]);
    let largest = size(0).max(size(1)).max(if held { palm_n } else { 0.0 });
    let scale = if largest > 0.0 { LONGEST * reach(&found.object.shape) / largest } else { 0.0 };
    let line = Mark::Line { width: 3.0 };
    let mut entries = Vec::new();
    for (i, (name, colour)) in
        [("F21, by the proximal phalanx", BLUE), ("F22, by the distal phalanx", ORANGE)].into_iter().enumerate()
    {
        let contact = &found.contacts[i];
        let pulls = normal[i] < 0.0;
        // The object is pushed against n, and by friction against t.
        let to = [0, 1].map(|k| {
            let push = contact.normal[k] + forces.mu_static[i] * contact.tangent[k];
            contact.point_m[k] - scale * normal[i] * push
        });
        let ends = [contact.point_m, to];
        for ends in [ends.to_vec(), mirrored(&ends, centre[0])] {
            arrow(svg, view.pixel(ends[0]), view.pixel(ends[1]), colour);
        }
        let text = match pulls {
            true => format!("{name}: would have to pull {:.2} N", -normal[i]),
            false => format!("{name}: {:.2} N", normal[i]),
        };
        entries.push(Entry::new(line, colour, &text));
    }
    let text = match (found.palm, palm_n) {
        (Palm::None | Palm::Apart { .. }, _) => format!("PFP, towards the palm: {palm_n:.2} N"),
        (_, force) if force >= 0.0 => format!("2 PFP, by the palm: {force:.2} N"),
        (_, force) => format!("2 PFP, by the palm: would have to pull {:.2} N", -force),
    };
    if held {
        let foot = found.object.lowest_m();
        arrow(svg, view.pixel(foot), view.pixel([foot[0], foot[1] + scale * palm_n]), PURPLE);
    }
    entries.push(Entry::new(line, PURPLE, &text));
    entries
}

/// Whether the grasp is form-closed, and the motion of the object if not.
fn closure(svg: &mut Svg, view: &View, found: &Grasp) -> Entry {
    let centre = found.object.centre_m;
    let Some((moved, _)) = shown(found) else {
        return Entry::new(Mark::Circle, GREEN, "form-closed");
    };
    let length = moved[0].hypot(moved[1]);
    if length > 0.0 {
        let to = [0, 1].map(|i| centre[i] + 0.5 * reach(&found.object.shape) * moved[i] / length);
        arrow(svg, view.pixel(centre), view.pixel(to), GREEN);
    }
    Entry::new(THIN, GREEN, "not form-closed: a free motion")
}
