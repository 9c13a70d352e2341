//! A grasp at rest: the finger, its mirror image, the object, forces on the object, and a motion that is free.

use plotters::element::{PathElement, Polygon};
use plotters::style::{Color, RGBColor, ShapeStyle};

use super::canvas::{
    Area, BLACK, BLUE, COUPLER, DISTAL, DRIVER, DrawError, Entry, GREEN, GREY, Mark, OBJECT, ORANGE, PALM, PROXIMAL,
    PURPLE, WIDTH, legend, picture, titled, words,
};
use super::outline::{Point, View, circle, filled, outline};
use crate::drawing::{Body, Drawing, Part, poses_in};
use crate::grasp::finger::{Forces, Grasp, Palm};
use crate::gripper::{Posture, posture_at};
use crate::scene::Scene;
use crate::statics::{Certificate, FormClosure, Unknown};

/// Width of the legend.
const BESIDE: u32 = 330;
const HEAD: u32 = 40;
/// How far the free motion is drawn: the object by a part of its radius, or the fastest joint by an angle.
const SHOWN_RADII: f64 = 0.2;
const SHOWN_RAD: f64 = 0.15;

/// The largest force is drawn as long as this part of the object's radius.
const LONGEST: f64 = 0.65;

/// The picture, with the forces of the last of the friction coefficients.
pub fn grasp(scene: &Scene, found: &Grasp) -> Result<String, DrawError> {
    let bodies = Drawing::of(scene).bodies;
    let rest = coloured(scene, &bodies, &found.end.posture);
    let centre = found.disc.centre_m;
    let round = circle(centre, found.disc.radius_m);
    let ghosts = ghosts(scene, found, &bodies);
    let both = |outline: &Vec<Point>| [outline.clone(), mirrored(outline, centre[0])];
    let mut points: Vec<Point> =
        rest.iter().map(|(outline, _)| outline).flat_map(both).flatten().chain(round.clone()).collect();
    points.extend(ghosts.iter().flatten());
    points.push([centre[0], -0.15 * found.disc.radius_m]);
    let view = View::of(&points, WIDTH - BESIDE);

    let last = found.forces.last();
    let friction = last.map_or_else(String::new, |forces| match forces.mu_static {
        [a, b] if a == b => format!(", μ_s {a}"),
        [a, b] => format!(", μ_s {a} and {b}"),
    });
    picture(HEAD + view.height().max(360), |area| {
        let below = titled(area, &format!("{}: the grasp at rest{friction}; forces on the object", found.scene))?;
        let (left, right) = below.split_horizontally(WIDTH - BESIDE);
        if scene.system.palm.is_some() {
            ground(&left, &view, centre[0])?;
        }
        for (outline, fill) in &rest {
            filled(&left, &view, &mirrored(outline, centre[0]), fill.mix(0.5), GREY)?;
        }
        filled(&left, &view, &round, OBJECT.mix(1.0), GREY)?;
        for (outline, fill) in &rest {
            filled(&left, &view, outline, fill.mix(1.0), BLACK)?;
        }
        for outline in &ghosts {
            dashed(&left, &view, outline, GREEN)?;
        }
        let mut entries = match last {
            Some(forces) => arrows(&left, &view, found, forces)?,
            None => Vec::new(),
        };
        entries.extend(closure(&left, &view, found)?);
        legend(&right, &entries)?;
        Ok(())
    })
}

/// Outlines of the four links at a posture.
fn links(scene: &Scene, bodies: &[Body], posture: &Posture) -> Vec<Vec<Point>> {
    coloured(scene, bodies, posture).into_iter().map(|(outline, _)| outline).collect()
}

/// The same with the colours of their parts.
fn coloured(scene: &Scene, bodies: &[Body], posture: &Posture) -> Vec<(Vec<Point>, RGBColor)> {
    let poses = poses_in(scene, &[*posture]);
    let mut outlines = Vec::new();
    for (body, pose) in bodies.iter().zip(&poses) {
        let fill = match body.part {
            Part::Driver => DRIVER,
            Part::Coupler => COUPLER,
            Part::Proximal => PROXIMAL,
            Part::Distal => DISTAL,
            Part::Object | Part::Palm | Part::Disc => continue,
        };
        outlines.extend(body.shapes.iter().map(|shape| (outline(shape, pose), fill)));
    }
    outlines
}

fn mirrored(outline: &[Point], about_x: f64) -> Vec<Point> {
    outline.iter().map(|[x, y]| [2.0 * about_x - x, *y]).collect()
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
    let by_object = SHOWN_RADII * found.disc.radius_m / speed;
    let time = by_object.min(SHOWN_RAD / fastest);
    time.is_finite().then(|| (object.map(|v| v * time), joints.map(|rates| rates.map(|rate| rate * time))))
}

/// Outlines of everything a little later.
fn ghosts(scene: &Scene, found: &Grasp, bodies: &[Body]) -> Vec<Vec<Point>> {
    let Some((moved, joints)) = shown(found) else {
        return Vec::new();
    };
    let centre = found.disc.centre_m;
    let mut ghosts = Vec::new();
    if moved != [0.0; 2] {
        ghosts.push(circle([centre[0] + moved[0], centre[1] + moved[1]], found.disc.radius_m));
    }
    for (finger, [q21, q22]) in joints.into_iter().enumerate() {
        let end = &found.end.posture;
        let of = &scene.finger().linkage;
        // A large motion may have no posture: then only the object is drawn.
        let Ok(posture) = posture_at(&of.lengths, of.assembly, end.q21_rad + q21, end.q22_rad + q22) else {
            continue;
        };
        let outlines = links(scene, bodies, &posture);
        ghosts.extend(outlines.iter().map(|outline| match finger {
            0 => outline.clone(),
            _ => mirrored(outline, centre[0]),
        }));
    }
    ghosts
}

fn ground(area: &Area, view: &View, middle_x: f64) -> Result<(), DrawError> {
    let (left, right) = (view.low[0], view.high[0]);
    let below = view.low[1];
    filled(area, view, &[[left, 0.0], [right, 0.0], [right, below], [left, below]], PALM.mix(1.0), PALM)?;
    let line = vec![view.pixel([left, 0.0]), view.pixel([right, 0.0])];
    area.draw(&PathElement::new(line, GREY.stroke_width(2)))?;
    words(area, "palm", view.pixel([middle_x, 0.5 * below]), 13, GREY)
}

fn dashed(area: &Area, view: &View, outline: &[Point], colour: RGBColor) -> Result<(), DrawError> {
    let closed: Vec<Point> = outline.iter().chain(outline.first()).copied().collect();
    let (dash, gap) = (5.0 / view.scale, 4.0 / view.scale);
    let mut travelled = 0.0;
    for pair in closed.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let at = |s: f64| [0, 1].map(|i| from[i] + (to[i] - from[i]) * s / length);
        let mut s = 0.0;
        while s < length {
            let phase = (travelled + s) % (dash + gap);
            let drawn = phase < dash;
            let next = (s + if drawn { dash - phase } else { dash + gap - phase }).min(length);
            if drawn {
                let ends = vec![view.pixel(at(s)), view.pixel(at(next))];
                area.draw(&PathElement::new(ends, colour.stroke_width(1)))?;
            }
            // A step too small to count would not end.
            s = next.max(s + 0.1 * dash);
        }
        travelled += length;
    }
    Ok(())
}

fn arrow(area: &Area, view: &View, from: Point, to: Point, colour: RGBColor) -> Result<(), DrawError> {
    let (a, b) = (view.pixel(from), view.pixel(to));
    let (dx, dy) = (f64::from(b.0 - a.0), f64::from(b.1 - a.1));
    let length = dx.hypot(dy);
    if length < 2.0 {
        return Ok(());
    }
    let head = 11.0f64.min(0.7 * length);
    let (ux, uy) = (dx / length, dy / length);
    let back = |along: f64, aside: f64| {
        let place = |end: i32, u: f64, v: f64| (f64::from(end) - along * u + aside * v).round() as i32;
        (place(b.0, ux, -uy), place(b.1, uy, ux))
    };
    area.draw(&PathElement::new(vec![a, back(0.8 * head, 0.0)], colour.stroke_width(3)))?;
    let corners = vec![b, back(head, 0.45 * head), back(head, -0.45 * head)];
    area.draw(&Polygon::new(corners, ShapeStyle::from(&colour).filled()))
}

/// Forces on the object by both fingers and by the palm, and what the legend says of them.
fn arrows(area: &Area, view: &View, found: &Grasp, forces: &Forces) -> Result<Vec<Entry>, DrawError> {
    let centre = found.disc.centre_m;
    let normal = [forces.equilibrium.f21_n, forces.equilibrium.f22_n];
    let palm_n = 2.0 * forces.equilibrium.pfp_n;
    let held = found.palm.holds() && palm_n >= 0.0;
    let size = |i: usize| normal[i].abs() * 1f64.hypot(forces.mu_static[i]);
    let largest = size(0).max(size(1)).max(if held { palm_n } else { 0.0 });
    let scale = if largest > 0.0 { LONGEST * found.disc.radius_m / largest } else { 0.0 };
    let line = Mark::Line { width: 3 };
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
            arrow(area, view, ends[0], ends[1], colour)?;
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
        let foot = [centre[0], centre[1] - found.disc.radius_m];
        arrow(area, view, foot, [foot[0], foot[1] + scale * palm_n], PURPLE)?;
    }
    entries.push(Entry::new(line, PURPLE, &text));
    Ok(entries)
}

/// Whether the grasp is form-closed, and the motion of the object if not.
fn closure(area: &Area, view: &View, found: &Grasp) -> Result<Vec<Entry>, DrawError> {
    let centre = found.disc.centre_m;
    let Some((moved, _)) = shown(found) else {
        return Ok(vec![Entry::new(Mark::Circle, GREEN, "form-closed")]);
    };
    let length = moved[0].hypot(moved[1]);
    if length > 0.0 {
        let to = [0, 1].map(|i| centre[i] + 0.5 * found.disc.radius_m * moved[i] / length);
        arrow(area, view, centre, to, GREEN)?;
    }
    Ok(vec![Entry::new(Mark::Line { width: 1 }, GREEN, "not form-closed: a free motion")])
}
