//! The drawn parts of a mechanism: outlines, bars between the pins and outlines of a body, pins, pulleys and cables.
//!
//! A half plane is drawn as a part of its own, whose frame has the half plane below its x-axis; so is every other outline of
//! the ground, whose frame has its centre as origin.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::states::{States, at_start};
use super::{BodyRole, Drawing, DrawnBody, FramePose, Shape};
use crate::law::NormalLaw;
use crate::mechanism::tendon::{Segment, center_in, segment, settled_path, strands};
use crate::mechanism::{
    Command, ContactPair, Joint, JointCombination, Mechanism, Outline, OutlineId, OutlineShape, PathElement,
    PrescribedMotion,
};
use crate::numeric::elementary::{atan2, hypot, pow, sin_cos};
use crate::numeric::plane::{add, cross, dot, nearest_equivalent_angle, perp, rotate, scale, sub};

/// Radius of pins and half the width of bars, as a part of the size of the mechanism.
const PIN_PART: f64 = 0.015;
/// Corners of a full circle of a polygon.
const CIRCLE_CORNERS: usize = 32;

/// A drawn body: the body that it is fixed to (`None`: the ground), and its pose in that body.
struct Part {
    body: Option<usize>,
    pose: FramePose,
    drawn: DrawnBody,
}

/// Builds the drawing of a mechanism.
pub(super) fn drawing(mechanism: Mechanism) -> Drawing {
    let start = at_start(&mechanism);
    let parts = parts(&mechanism, &start);
    let [low, high] = extent(&mechanism, &start, &parts);
    let view_m = (high[0] - low[0]).max(high[1] - low[1]);
    // The arrow of a usual force is a tenth of the view.
    let effort = |command: &Command| match command {
        Command::Effort(profile) => profile.largest(),
        Command::Servo { kp, target, .. } => kp * target.largest(),
    };
    let efforts = mechanism.actuators.iter().map(|actuator| {
        let largest = match actuator.powertrain.is_direct() {
            true => effort(&actuator.command).min(actuator.limit.unwrap_or(f64::INFINITY)),
            false => actuator.effort_at_rest(effort(&actuator.command)).abs(),
        };
        largest / lever_m(&mechanism, actuator.on.terms[0].0, 0.5 * view_m)
    });
    let weights = mechanism.bodies.iter().filter(|body| body.motion.is_none()).map(|body| {
        let [x, y] = mechanism.gravity_m_s2;
        body.mass_kg * hypot(x, y)
    });
    let impacts =
        mechanism.contacts.iter().filter(|_| mechanism.joints.is_empty()).map(|pair| impact_n(&mechanism, pair));
    let typical_n = efforts.chain(weights).chain(impacts).filter(|force| force.is_finite()).fold(0.0, f64::max);
    Drawing {
        contacts: mechanism.point_contacts().into_iter().map(|contact| contact.name).collect(),
        arrow_m_per_n: 0.1 * view_m / if typical_n > 0.0 { typical_n } else { 1.0 },
        longest_arrow_m: 0.3 * view_m,
        extent_m: [low.map(|low| low - 0.1 * view_m), high.map(|high| high + 0.1 * view_m)],
        bodies: parts.into_iter().map(|part| part.drawn).collect(),
        mechanism,
    }
}

/// Largest force of an undamped impact of free bodies at their speeds at the start: k δᵉ with ½ m v² = k δ^(e+1)/(e+1).
fn impact_n(mechanism: &Mechanism, pair: &ContactPair) -> f64 {
    let rate_and_mass = |id: OutlineId| match id.body.map(|body| &mechanism.bodies[body]) {
        Some(body) => (body.rate, if body.motion.is_some() { f64::INFINITY } else { body.mass_kg }),
        None => ([0.0; 3], f64::INFINITY),
    };
    let [(first, m1), (second, m2)] = [pair.points, pair.face].map(rate_and_mass);
    let mass_kg = (m1.recip() + m2.recip()).recip();
    let NormalLaw { stiffness_n_per_m_e: k, exponent: e, .. } = pair.law.normal;
    let speed_m_s = hypot(first[0] - second[0], first[1] - second[1]);
    let energy_j = 0.5 * mass_kg * speed_m_s * speed_m_s;
    if k > 0.0 { k * pow((e + 1.0) * energy_j / k, e / (e + 1.0)) } else { 0.0 }
}

/// Length over which the effort of an actuator on a joint becomes a force: 1 of a prismatic joint, otherwise the distance to
/// the farthest pin of a body on it, or a default.
fn lever_m(mechanism: &Mechanism, joint: usize, default_m: f64) -> f64 {
    let Joint { kind, bodies, points_m, .. } = &mechanism.joints[joint];
    if !kind.is_angle() {
        return 1.0;
    }
    let of_body = |(body, [x, y]): (&Option<usize>, [f64; 2])| {
        let pins = if body.is_some() { pins_m(mechanism, *body) } else { Vec::new() };
        pins.into_iter().map(|[u, v]| hypot(u - x, v - y)).fold(0.0, f64::max)
    };
    let largest_m = bodies.iter().zip(*points_m).map(of_body).fold(0.0, f64::max);
    if largest_m > 0.0 { largest_m } else { default_m }
}

/// Poses of the drawn bodies.
pub(super) fn poses(mechanism: &Mechanism, states: &States) -> Vec<FramePose> {
    let cables = cables(mechanism, states).into_iter().map(|bar| bar.pose);
    placements(mechanism).map(|(body, local)| in_world(states.of(body).pose(), local)).chain(cables).collect()
}

/// Velocities and angular rates of the drawn bodies.
pub(super) fn velocities(mechanism: &Mechanism, states: &States) -> Vec<FramePose> {
    let velocity = |(body, local): (Option<usize>, FramePose)| {
        let state = states.of(body);
        pose(state.point(local.position_m).1, state.spin_rad_s)
    };
    let cables = cables(mechanism, states).into_iter().map(|bar| bar.rate);
    placements(mechanism).map(velocity).chain(cables).collect()
}

/// A bar of a drawn cable with its motion, and its ends along it per length of its segment at the start.
struct CableBar {
    name: String,
    pose: FramePose,
    rate: FramePose,
    ends: [f64; 2],
    segment_m: f64,
}

/// Bars on a segment of a cable: their place along it, and their ends. They cover it while it has 0.5 to 1.5 times its
/// length at the start.
const CABLE_BARS: [(f64, [f64; 2]); 3] = [(0.0, [0.0, 0.5]), (0.5, [-0.25, 0.25]), (1.0, [-0.5, 0.0])];

/// The bars of all cables with the bodies in these states. Where a cable is off a pulley, the bars of the segments on both
/// sides of it share the straight segment between its neighbours.
fn cables(mechanism: &Mechanism, states: &States) -> Vec<CableBar> {
    let guesses: Vec<[f64; 3]> = mechanism.bodies.iter().map(|body| body.pose).collect();
    let state = |element: &PathElement| states.of(element.body).point(element.point_m);
    let mut bars = Vec::new();
    for tendon in &mechanism.tendons {
        let bends = settled_path(&tendon.path, |element| state(element).0);
        let shares = strands(&bends).flat_map(|[from, to]| (from..to).map(move |index| (index, [from, to])));
        for (index, [first, last]) in shares {
            let (ends, count) = ([&tendon.path[first], &tendon.path[last]], (last - first) as f64);
            let [(from, from_rate), (to, to_rate)] = ends.map(state);
            let Segment { length, direction } = segment(ends, sub(to, from));
            let spin = cross(direction, sub(to_rate, from_rate)) / length;
            // The angle is continuous within half a turn from that of the guess.
            let guessed = sub(center_in(ends[1], &guesses), center_in(ends[0], &guesses));
            let angle_rad = nearest_equivalent_angle(atan2(direction[1], direction[0]), atan2(guessed[1], guessed[0]));
            let tangent = |center, k: usize| sub(center, scale(perp(direction), ends[k].signed_radius_m()));
            let velocity = |rate, k: usize| add(rate, scale(direction, ends[k].signed_radius_m() * spin));
            let share = |part: f64| ((index - first) as f64 + part) / count;
            let between = |a: [f64; 2], b: [f64; 2], part: f64| add(scale(a, 1.0 - share(part)), scale(b, share(part)));
            bars.extend(CABLE_BARS.iter().enumerate().map(|(k, &(part, bar_ends))| CableBar {
                name: format!("{}[{}]", tendon.name, CABLE_BARS.len() * index + k),
                pose: pose(between(tangent(from, 0), tangent(to, 1), part), angle_rad),
                rate: pose(between(velocity(from_rate, 0), velocity(to_rate, 1), part), spin),
                ends: bar_ends,
                segment_m: length / count,
            }));
        }
    }
    bars
}

fn pose(position_m: [f64; 2], angle_rad: f64) -> FramePose {
    FramePose { position_m, angle_rad }
}

fn in_world(body: FramePose, local: FramePose) -> FramePose {
    pose(body.apply(local.position_m), body.angle_rad + local.angle_rad)
}

/// All bodies with their outlines; the ground first.
fn outlined(mechanism: &Mechanism) -> impl Iterator<Item = (Option<usize>, &[Outline])> {
    let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| (Some(index), &body.outlines[..]));
    [(None, &mechanism.ground_outlines[..])].into_iter().chain(bodies)
}

/// Outlines that are parts of their own: half planes, and all outlines of the ground.
fn single_outlines(mechanism: &Mechanism) -> impl Iterator<Item = (Option<usize>, &Outline)> {
    let is_single = |(body, outline): &(Option<usize>, &Outline)| body.is_none() || is_half_plane(&outline.shape);
    outlined(mechanism)
        .flat_map(|(body, outlines)| outlines.iter().map(move |outline| (body, outline)))
        .filter(is_single)
}

fn is_half_plane(shape: &OutlineShape) -> bool {
    matches!(shape, OutlineShape::HalfPlane { .. })
}

/// Pose in its body of the frame of an outline that is a part of its own.
fn outline_frame(shape: &OutlineShape) -> FramePose {
    match shape {
        OutlineShape::HalfPlane { point_m, normal: [x, y] } => pose(*point_m, atan2(*y, *x) - FRAC_PI_2),
        OutlineShape::Disc { center_m, .. } | OutlineShape::Ellipse { center_m, .. } => pose(*center_m, 0.0),
        OutlineShape::Capsule { .. } | OutlineShape::Polygon { .. } => FramePose::default(),
    }
}

/// Bodies and poses of the parts: the outlines that are parts of their own, the ground, and the bodies.
fn placements(mechanism: &Mechanism) -> impl Iterator<Item = (Option<usize>, FramePose)> + '_ {
    let single = single_outlines(mechanism).map(|(body, outline)| (body, outline_frame(&outline.shape)));
    single.chain(outlined(mechanism).map(|(body, _)| (body, FramePose::default())))
}

/// Draws an outline.
fn surface(shape: &OutlineShape) -> Shape {
    match *shape {
        OutlineShape::Disc { center_m, radius_m } if center_m == [0.0; 2] => Shape::Disc { radius_m },
        OutlineShape::Disc { center_m, radius_m } => Shape::Capsule { from_m: center_m, to_m: center_m, radius_m },
        OutlineShape::Capsule { from_m, to_m, radius_m } => Shape::Capsule { from_m, to_m, radius_m },
        OutlineShape::HalfPlane { .. } => Shape::HalfPlane { level_m: 0.0 },
        _ => Shape::Polygon { corners_m: corners_m(shape) },
    }
}

/// The drawn bodies, in the order of their placements.
fn parts(mechanism: &Mechanism, start: &States) -> Vec<Part> {
    let size_m = size_m(mechanism);
    let ground_moves = mechanism.palm().is_some();
    let is_fixed = |body: Option<usize>| body.is_none() && !ground_moves;
    let single = single_outlines(mechanism).map(|(body, outline)| {
        let is_body = mechanism.bodies.iter().any(|other| other.name == outline.name);
        let FramePose { position_m: [x, y], .. } = outline_frame(&outline.shape);
        DrawnBody {
            // The name of the outline alone, unless a body has the same name.
            name: match body {
                None if !is_body => outline.name.clone(),
                _ => format!("{}.{}", mechanism.body_name(body), outline.name),
            },
            role: if is_half_plane(&outline.shape) { BodyRole::Palm } else { role_of_ground(mechanism) },
            fixed: is_fixed(body),
            shapes: vec![surface(&outline.shape.moved([-x, -y], 0.0))],
            marks_m: if matches!(outline.shape, OutlineShape::Disc { .. }) { vec![[0.0; 2]] } else { Vec::new() },
        }
    });
    let pin_m = PIN_PART * size_m;
    let pins_from_ground = pins_from_ground(mechanism);
    let bodies = outlined(mechanism).map(|(body, outlines)| {
        let pins = pins_m(mechanism, body);
        let drawn_m = body.map_or(&[][..], |body| &mechanism.bodies[body].drawn_m);
        let mut shapes: Vec<Shape> =
            drawn_m.iter().map(|corners_m| Shape::Polygon { corners_m: corners_m.clone() }).collect();
        if body.is_some() && shapes.is_empty() {
            shapes = skeleton(mechanism, body, &pins, outlines, pin_m);
        }
        let surfaces = outlines.iter().filter(|outline| body.is_some() && !is_half_plane(&outline.shape));
        shapes.extend(surfaces.map(|outline| surface(&outline.shape)));
        if drawn_m.is_empty() {
            shapes.extend(pins.iter().map(|pin| circle(*pin, pin_m)));
        }
        let elements = mechanism.tendons.iter().flat_map(|tendon| &tendon.path).filter(|element| element.body == body);
        shapes.extend(elements.map(|element| circle(element.point_m, element.radius_m.max(0.5 * pin_m))));
        let role = body.map_or(BodyRole::Palm, |body| role(mechanism, body, &pins_from_ground));
        let marks_m = match (role, body) {
            (BodyRole::Object, Some(body)) => vec![mechanism.bodies[body].com_m],
            _ => pins,
        };
        DrawnBody { name: mechanism.body_name(body).to_owned(), role, fixed: is_fixed(body), shapes, marks_m }
    });
    let drawn = single.chain(bodies);
    let cable = |CableBar { name, pose, ends, segment_m, .. }: CableBar| {
        let [from_m, to_m] = ends.map(|end| [end * segment_m, 0.0]);
        let shapes = vec![bar(from_m, to_m, 0.2 * pin_m)];
        Part {
            body: None,
            pose,
            drawn: DrawnBody { name, role: BodyRole::Coupler, fixed: false, shapes, marks_m: vec![] },
        }
    };
    let cables = cables(mechanism, start).into_iter().map(cable);
    placements(mechanism).zip(drawn).map(|((body, pose), drawn)| Part { body, pose, drawn }).chain(cables).collect()
}

/// Role of the outlines of the ground: they are an object that bodies grasp, unless there is a free body.
fn role_of_ground(mechanism: &Mechanism) -> BodyRole {
    let has_object = (0..mechanism.bodies.len()).any(|body| !mechanism.has_joint(Some(body)));
    if has_object { BodyRole::Palm } else { BodyRole::Object }
}

/// Role of a body, which selects its colour. A body with a surface is a phalanx: a proximal one if a single pin is
/// between it and the ground. Bodies that an actuator drives directly or by a coupling are drivers.
fn role(mechanism: &Mechanism, index: usize, pins_from_ground: &[usize]) -> BodyRole {
    let body = Some(index);
    let mut outlines = mechanism.contacts.iter().flat_map(|contact| [contact.points, contact.face]);
    let has_surface = outlines.any(|outline| outline.body == body);
    let joints = |on: &JointCombination| -> Vec<usize> { on.terms.iter().map(|(joint, _)| *joint).collect() };
    let actuated: Vec<usize> = mechanism.actuators.iter().flat_map(|actuator| joints(&actuator.on)).collect();
    let is_driven = |joint: usize| {
        let mut coupled =
            mechanism.couplings.iter().map(|coupling| joints(&coupling.on)).filter(|all| all.contains(&joint));
        actuated.contains(&joint) || coupled.any(|all| all.iter().any(|other| actuated.contains(other)))
    };
    // The mirror image of a revolute joint has its bodies in the opposite order.
    let moves = |[a, b]: [Option<usize>; 2]| b == body || a == body && mechanism.is_base(b);
    match () {
        () if matches!(mechanism.bodies[index].motion, Some(PrescribedMotion::Palm(_))) => BodyRole::Palm,
        () if !mechanism.has_joint(body) => BodyRole::Object,
        () if has_surface && pins_from_ground[index] == 1 => BodyRole::Proximal,
        () if has_surface => BodyRole::Distal,
        () if (0..mechanism.joints.len()).any(|k| moves(mechanism.joints[k].bodies) && is_driven(k)) => {
            BodyRole::Driver
        }
        () => BodyRole::Coupler,
    }
}

/// Smallest number of pins between each body and the ground or a body with prescribed motion.
fn pins_from_ground(mechanism: &Mechanism) -> Vec<usize> {
    let start = |body: usize| if mechanism.is_base(Some(body)) { 0 } else { usize::MAX };
    let mut pins: Vec<usize> = (0..mechanism.bodies.len()).map(start).collect();
    for _ in 0..mechanism.bodies.len() {
        for Joint { bodies: [a, b], kind, .. } in &mechanism.joints {
            for (from, to) in [(a, b), (b, a)] {
                let reached = from.map_or(0, |body| pins[body]).saturating_add(usize::from(kind.is_angle()));
                if let Some(body) = *to {
                    pins[body] = pins[body].min(reached);
                }
            }
        }
    }
    pins
}

/// Pins of a body and the centres of its spools, in its frame.
fn pins_m(mechanism: &Mechanism, body: Option<usize>) -> Vec<[f64; 2]> {
    let pins = mechanism.joints.iter().filter(|joint| joint.kind.is_angle());
    let points = pins.flat_map(|joint| joint.bodies.into_iter().zip(joint.points_m));
    let mut points: Vec<[f64; 2]> = points.filter(|(other, _)| *other == body).map(|(_, point)| point).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    points
}

/// The bars of a body: the convex hull of its pins, and a bar to every outline apart from it; its spools; blocks of
/// sliders without another shape.
fn skeleton(
    mechanism: &Mechanism,
    body: Option<usize>,
    pins: &[[f64; 2]],
    outlines: &[Outline],
    pin_m: f64,
) -> Vec<Shape> {
    let rounded = |vertices_m: Vec<[f64; 2]>| corners_m(&OutlineShape::Polygon { vertices_m, radius_m: 0.5 * pin_m });
    // A joint is drawn on its second body. That of a mirrored joint may be the ground; then it is its first one.
    let side = |joint: &Joint| usize::from(joint.bodies[1].is_some());
    let is_of_body = |joint: &&Joint| joint.bodies[side(joint)] == body;
    let spools = mechanism.tendons.iter().flat_map(|tendon| &tendon.joints);
    let spools = spools.map(|(joint, radius_m)| (&mechanism.joints[*joint], radius_m.abs()));
    let spools = spools.filter(|(joint, _)| joint.kind.is_angle() && is_of_body(joint));
    let mut drawn: Vec<Vec<[f64; 2]>> =
        spools.map(|(joint, radius_m)| circle_m(joint.points_m[side(joint)], radius_m)).collect();
    match pins {
        [] => {}
        [pin] => drawn.push(circle_m(*pin, pin_m)),
        _ => drawn.push(rounded(hull(pins))),
    }
    if outlines.is_empty() {
        for joint in mechanism.joints.iter().filter(is_of_body) {
            if let Some(axis_rad) = joint.kind.axis_rad() {
                let (sin, cos) = sin_cos(axis_rad - joint.offset_rad);
                let corner =
                    |[x, y]: [f64; 2]| add(joint.points_m[side(joint)], rotate([x * pin_m, y * pin_m], [cos, sin]));
                drawn.push([[-3.0, -2.0], [3.0, -2.0], [3.0, 2.0], [-3.0, 2.0]].map(corner).to_vec());
            }
        }
    }
    let mut apart: Vec<Vec<[f64; 2]>> = outlines.iter().map(|outline| corners_m(&outline.shape)).collect();
    apart.retain(|corners| !corners.is_empty());
    let mut joined = drawn.clone();
    joined.extend(if joined.is_empty() { apart.pop() } else { None });
    // The nearest outline first, so that others may be joined by it.
    while !apart.is_empty() {
        let pairs = (0..apart.len()).flat_map(|k| joined.iter().map(move |other| (k, other)));
        let bars = pairs.map(|(k, other)| (k, shortest_bar(other, &apart[k])));
        let nearest = bars.min_by(|(_, a), (_, b)| distance_m(a[0], a[1]).total_cmp(&distance_m(b[0], b[1])));
        let (k, ends) = nearest.expect("a pair: both lists have elements");
        if ends[0] != ends[1] {
            drawn.push(rounded(ends.to_vec()));
        }
        joined.push(apart.swap_remove(k));
    }
    drawn.into_iter().map(|corners_m| Shape::Polygon { corners_m }).collect()
}

/// Convex hull of sorted points, counter-clockwise (monotone chain).
fn hull(sorted: &[[f64; 2]]) -> Vec<[f64; 2]> {
    fn chain<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> Vec<[f64; 2]> {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && cross(sub(b, a), sub(*point, b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    }
    [chain(sorted.iter()), chain(sorted.iter().rev())].concat()
}

/// Ends of the shortest line between two convex polygons; equal if a corner of one is in the other.
fn shortest_bar(first: &[[f64; 2]], second: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let sides = |polygon: &[[f64; 2]]| {
        let polygon = polygon.to_vec();
        (0..polygon.len()).map(move |k| [polygon[k], polygon[(k + 1) % polygon.len()]])
    };
    // The point of a polygon that is nearest to a point.
    let nearest = |polygon: &[[f64; 2]], point: [f64; 2]| {
        if sides(polygon).all(|[a, b]| cross(sub(b, a), sub(point, a)) >= 0.0) {
            return point;
        }
        let on_side = |[a, b]: [[f64; 2]; 2]| {
            let along = sub(b, a);
            let part = dot(sub(point, a), along) / dot(along, along).max(f64::MIN_POSITIVE);
            add(a, scale(along, part.clamp(0.0, 1.0)))
        };
        let points = sides(polygon).map(on_side);
        let nearest = points.min_by(|a, b| distance_m(*a, point).total_cmp(&distance_m(*b, point)));
        nearest.expect("a polygon has sides")
    };
    let from_first = first.iter().map(|corner| [*corner, nearest(second, *corner)]);
    let from_second = second.iter().map(|corner| [nearest(first, *corner), *corner]);
    let shortest =
        from_first.chain(from_second).min_by(|a, b| distance_m(a[0], a[1]).total_cmp(&distance_m(b[0], b[1])));
    shortest.expect("a polygon has corners")
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    hypot(b[0] - a[0], b[1] - a[1])
}

/// Largest extent of a body.
fn size_m(mechanism: &Mechanism) -> f64 {
    let reach = |[x, y]: [f64; 2]| hypot(x, y);
    let joints = mechanism.joints.iter().flat_map(|joint| joint.points_m).map(reach);
    let outlines = outlined(mechanism)
        .flat_map(|(_, outlines)| outlines)
        .map(|outline| corners_m(&outline.shape).into_iter().map(reach).fold(0.0, f64::max));
    joints.chain(outlines).fold(1e-3, f64::max)
}

fn circle(center_m: [f64; 2], radius_m: f64) -> Shape {
    Shape::Polygon { corners_m: circle_m(center_m, radius_m) }
}

fn circle_m(center_m: [f64; 2], radius_m: f64) -> Vec<[f64; 2]> {
    corners_m(&OutlineShape::Disc { center_m, radius_m })
}

/// Corners of a polygon along an outline; none of a half plane.
fn corners_m(shape: &OutlineShape) -> Vec<[f64; 2]> {
    if let OutlineShape::Ellipse { center_m, semi_axes_m: [a, b], angle_rad } = *shape {
        let (sin, cos) = sin_cos(angle_rad);
        return arc(0.0, TAU).map(|[x, y]| add(center_m, rotate([a * x, b * y], [cos, sin]))).collect();
    }
    let (vertices_m, radius_m) = (shape.vertices_m(), shape.radius_m());
    let count = vertices_m.len();
    // Angle of the outer normal of the side after a vertex.
    let normal_rad = |k: usize| {
        let [x, y] = sub(vertices_m[(k + 1) % count], vertices_m[k % count]);
        atan2(-x, y)
    };
    let turn_rad = |k: usize| match count {
        1 => TAU,
        _ => (normal_rad(k) - normal_rad(k + count - 1)).rem_euclid(TAU),
    };
    let rounded = |k: usize| {
        let arc = arc(normal_rad(k + count - 1), if radius_m > 0.0 { turn_rad(k) } else { 0.0 });
        let vertex_m = vertices_m[k];
        arc.map(move |normal| add(vertex_m, scale(normal, radius_m)))
    };
    (0..count).flat_map(rounded).collect()
}

/// Unit vectors along an arc.
fn arc(start_rad: f64, turn_rad: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = (CIRCLE_CORNERS as f64 * turn_rad / TAU).round() as usize;
    (0..=count).map(move |k| {
        let (sin, cos) = sin_cos(start_rad + turn_rad * k as f64 / count.max(1) as f64);
        [cos, sin]
    })
}

fn bar(from_m: [f64; 2], to_m: [f64; 2], half_width_m: f64) -> Shape {
    let along = sub(to_m, from_m);
    let side = scale(perp(along), half_width_m / dot(along, along).sqrt());
    Shape::Polygon { corners_m: vec![sub(from_m, side), sub(to_m, side), add(to_m, side), add(from_m, side)] }
}

/// Lower left and upper right corner of everything at the start except half planes. A body on a pin of the ground or of a
/// moving palm may turn all round, but not into half planes.
fn extent(mechanism: &Mechanism, start: &States, parts: &[Part]) -> [[f64; 2]; 2] {
    let (mut at_start, mut turned) = (Vec::new(), Vec::new());
    for Part { body, pose: local, drawn } in parts {
        let pose = in_world(body.map_or(FramePose::default(), |body| start.bodies[body].pose()), *local);
        let pivot = mechanism.joints.iter().find_map(|joint| {
            let base = [0, 1]
                .into_iter()
                .find(|k: &usize| mechanism.is_base(joint.bodies[*k]) && joint.bodies[1 - k] == *body)?;
            (!mechanism.is_base(*body)).then(|| start.of(joint.bodies[base]).point(joint.points_m[base]).0)
        });
        for (point, radius_m) in drawn.shapes.iter().flat_map(Shape::discs) {
            let at = pose.apply(point);
            at_start.push((at, radius_m));
            turned.extend(pivot.map(|[x, y]| ([x, y], hypot(at[0] - x, at[1] - y) + radius_m)));
        }
    }
    let [mut low, mut high] = bounds(&turned);
    for (_, outline) in single_outlines(mechanism).filter(|(body, _)| mechanism.is_base(*body)) {
        let OutlineShape::HalfPlane { point_m, normal } = outline.shape else { continue };
        for axis in 0..2 {
            match normal[axis] {
                1.0 => low[axis] = low[axis].max(point_m[axis]),
                -1.0 => high[axis] = high[axis].min(point_m[axis]),
                _ => {}
            }
        }
    }
    let [start_low, start_high] = bounds(&at_start);
    let [low, high] =
        [[0, 1].map(|axis| low[axis].min(start_low[axis])), [0, 1].map(|axis| high[axis].max(start_high[axis]))];
    if low[0].is_finite() { [low, high] } else { [[-0.05; 2], [0.05; 2]] }
}

/// Lower left and upper right corner of discs with centres and radii.
fn bounds(discs: &[([f64; 2], f64)]) -> [[f64; 2]; 2] {
    discs.iter().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], ([x, y], radius)| {
        [[low[0].min(x - radius), low[1].min(y - radius)], [high[0].max(x + radius), high[1].max(y + radius)]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls_have_no_inner_and_no_collinear_points() {
        let square = [[0.0, 0.0], [0.0, 2.0], [1.0, 0.0], [1.0, 1.0], [2.0, 0.0], [2.0, 2.0]];
        assert_eq!(hull(&square), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert_eq!(hull(&[[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]]), [[0.0, 0.0], [3.0, 3.0]]);
    }

    #[test]
    fn bars_are_shortest_and_vanish_in_an_overlap() {
        let square_at = |x: f64| [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
        let tip = [[3.0, 0.5], [5.0, 0.0], [5.0, 1.0]];
        assert_eq!(shortest_bar(&square_at(0.0), &tip), [[1.0, 0.5], [3.0, 0.5]]);
        assert_eq!(shortest_bar(&tip, &square_at(0.0)), [[3.0, 0.5], [1.0, 0.5]]);
        let [from, to] = shortest_bar(&square_at(0.0), &square_at(0.5));
        assert_eq!(from, to);
    }
}
