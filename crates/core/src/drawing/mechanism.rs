//! Drawing of a mechanism: outlines, bars between the joints of a body, pins, pulleys and cables.
//!
//! A half plane is drawn as a body of its own, whose frame has the half plane below its x-axis.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::{Body, BodyRole, Drawing, Pose, Shape};
use crate::mechanism::tendon::{Segment, center_in, segment};
use crate::mechanism::{Command, Joint, JointKind, Mechanism, Outline, OutlineShape, PathElement, assemble};
use crate::numeric::elementary::{atan2, hypot, sin_cos};
use crate::numeric::plane::{add, cross, dot, nearest_equivalent_angle, perp, rotate, scale, sub};
use crate::trace::{BodyState, Sample};

/// Radius of pins and half the width of bars, as a part of the size of the mechanism.
const PIN_PART: f64 = 0.015;
/// Corners of a circle that is not about the origin of its body.
const CIRCLE_CORNERS: usize = 32;

/// A drawn body: the body that it is fixed to (`None`: the ground), and its pose in that body.
struct Part {
    body: Option<usize>,
    pose: Pose,
    drawn: Body,
}

/// Builds the drawing of a mechanism.
pub(super) fn drawing(mechanism: &Mechanism) -> Drawing {
    let parts = parts(mechanism);
    let [low, high] = extent(mechanism, &parts);
    let view_m = (high[0] - low[0]).max(high[1] - low[1]);
    // The arrow of a usual force is a tenth of the view.
    let effort = |command: &Command| match command {
        Command::Effort(profile) => profile.largest(),
        Command::Servo { kp, target, .. } => kp * target.largest(),
    };
    let efforts = mechanism.actuators.iter().map(|actuator| {
        let limit = actuator.limit.unwrap_or(f64::INFINITY);
        effort(&actuator.command).min(limit)
            / if is_linear(mechanism, actuator.on.terms[0].0) { 1.0 } else { 0.5 * view_m }
    });
    let weights = mechanism.bodies.iter().map(|body| {
        let [x, y] = mechanism.gravity_m_s2;
        body.mass_kg * hypot(x, y)
    });
    let typical_n = efforts.chain(weights).fold(0.0, f64::max);
    Drawing {
        contacts: mechanism.point_contacts().into_iter().map(|contact| contact.name).collect(),
        arrow_m_per_n: 0.1 * view_m / if typical_n > 0.0 { typical_n } else { 1.0 },
        longest_arrow_m: 0.3 * view_m,
        extent_m: [low.map(|low| low - 0.1 * view_m), high.map(|high| high + 0.1 * view_m)],
        bodies: parts.into_iter().map(|part| part.drawn).collect(),
    }
}

fn is_linear(mechanism: &Mechanism, joint: usize) -> bool {
    matches!(mechanism.joints[joint].kind, JointKind::Prismatic { .. })
}

/// Poses of the drawn bodies.
pub(super) fn poses(mechanism: &Mechanism, sample: &Sample) -> Vec<Pose> {
    let bodies: Vec<Pose> = sample.bodies().map(|body| pose(body.centre_m, body.angle_rad)).collect();
    placements(mechanism)
        .map(|(body, local)| in_world(body.map_or(Pose::default(), |body| bodies[body]), local))
        .chain(cables(mechanism, &|body| sample.body(body)).into_iter().map(|bar| bar.pose))
        .collect()
}

/// Velocities and angular rates of the drawn bodies.
pub(super) fn velocities(mechanism: &Mechanism, sample: &Sample) -> Vec<Pose> {
    let velocity = |(body, local): (Option<usize>, Pose)| {
        let Some(body) = body else { return Pose::default() };
        let BodyState { angle_rad, velocity_m_s, spin_rad_s, .. } = sample.body(body);
        let (sin, cos) = sin_cos(angle_rad);
        let arm = rotate(local.position_m, [cos, sin]);
        pose(add(velocity_m_s, scale(perp(arm), spin_rad_s)), spin_rad_s)
    };
    let cables = cables(mechanism, &|body| sample.body(body)).into_iter().map(|bar| bar.rate);
    placements(mechanism).map(velocity).chain(cables).collect()
}

/// A bar of a drawn cable with its motion, and its ends along it per length of its segment at the start.
struct CableBar {
    name: String,
    pose: Pose,
    rate: Pose,
    ends: [f64; 2],
    segment_m: f64,
}

/// Bars on a segment of a cable: their place along it, and their ends. They cover it while it has 0.5 to 1.5 times its
/// length at the start.
const CABLE_BARS: [(f64, [f64; 2]); 3] = [(0.0, [0.0, 0.5]), (0.5, [-0.25, 0.25]), (1.0, [-0.5, 0.0])];

/// The bars of all cables with the bodies in these states.
fn cables(mechanism: &Mechanism, body: &dyn Fn(usize) -> BodyState) -> Vec<CableBar> {
    let guesses: Vec<[f64; 3]> = mechanism.bodies.iter().map(|body| body.pose).collect();
    let state = |element: &PathElement| {
        let BodyState { centre_m, angle_rad, velocity_m_s, spin_rad_s } =
            element.body.map_or_else(BodyState::default, body);
        let (sin, cos) = sin_cos(angle_rad);
        let arm = rotate(element.point_m, [cos, sin]);
        (add(centre_m, arm), add(velocity_m_s, scale(perp(arm), spin_rad_s)))
    };
    let mut bars = Vec::new();
    for tendon in &mechanism.tendons {
        for (index, ends) in tendon.path.windows(2).enumerate() {
            let [(from, from_rate), (to, to_rate)] = [state(&ends[0]), state(&ends[1])];
            let Segment { length, direction } = segment([&ends[0], &ends[1]], sub(to, from));
            let spin = cross(direction, sub(to_rate, from_rate)) / length;
            // The angle is continuous within half a turn from that of the guess.
            let guessed = sub(center_in(&ends[1], &guesses), center_in(&ends[0], &guesses));
            let angle_rad = nearest_equivalent_angle(atan2(direction[1], direction[0]), atan2(guessed[1], guessed[0]));
            let tangent = |center, k: usize| sub(center, scale(perp(direction), ends[k].signed_radius_m()));
            let velocity = |rate, k: usize| add(rate, scale(direction, ends[k].signed_radius_m() * spin));
            let between = |a: [f64; 2], b: [f64; 2], part: f64| add(scale(a, 1.0 - part), scale(b, part));
            bars.extend(CABLE_BARS.iter().enumerate().map(|(k, &(part, bar_ends))| CableBar {
                name: format!("{}[{}]", tendon.name, CABLE_BARS.len() * index + k),
                pose: pose(between(tangent(from, 0), tangent(to, 1), part), angle_rad),
                rate: pose(between(velocity(from_rate, 0), velocity(to_rate, 1), part), spin),
                ends: bar_ends,
                segment_m: length,
            }));
        }
    }
    bars
}

/// Poses of all bodies at the start; the guesses of a mechanism that cannot be assembled.
pub fn poses_at_start(mechanism: &Mechanism) -> Vec<[f64; 3]> {
    let guesses = || mechanism.bodies.iter().map(|body| body.pose).collect();
    assemble(mechanism).map_or_else(|_| guesses(), |start| start.poses)
}

fn pose(position_m: [f64; 2], angle_rad: f64) -> Pose {
    Pose { position_m, angle_rad }
}

fn in_world(body: Pose, local: Pose) -> Pose {
    pose(body.apply(local.position_m), body.angle_rad + local.angle_rad)
}

/// All bodies with their outlines; the ground first.
fn outlined(mechanism: &Mechanism) -> impl Iterator<Item = (Option<usize>, &[Outline])> {
    let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| (Some(index), &body.outlines[..]));
    [(None, &mechanism.ground_outlines[..])].into_iter().chain(bodies)
}

/// Bodies and poses of the parts: the half planes of all bodies, and the ground and the bodies themselves.
fn placements(mechanism: &Mechanism) -> impl Iterator<Item = (Option<usize>, Pose)> + '_ {
    let half_planes = outlined(mechanism).flat_map(|(body, outlines)| {
        outlines.iter().filter_map(move |outline| match outline.shape {
            OutlineShape::HalfPlane { point_m, normal: [x, y] } => Some((body, pose(point_m, atan2(y, x) - FRAC_PI_2))),
            _ => None,
        })
    });
    half_planes.chain(outlined(mechanism).map(|(body, _)| (body, Pose::default())))
}

/// The drawn bodies, in the order of their placements.
fn parts(mechanism: &Mechanism) -> Vec<Part> {
    let size_m = size_m(mechanism);
    let half_planes = outlined(mechanism).flat_map(|(body, outlines)| {
        let planes = outlines.iter().filter(|outline| matches!(outline.shape, OutlineShape::HalfPlane { .. }));
        planes.map(move |outline| Body {
            name: format!("{}.{}", mechanism.body_name(body), outline.name),
            role: BodyRole::Palm,
            fixed: body.is_none(),
            shapes: vec![Shape::HalfPlane { level_m: 0.0 }],
        })
    });
    let bodies = outlined(mechanism).map(|(body, outlines)| {
        let points: Vec<[f64; 2]> = joint_points(mechanism, body).collect();
        let surfaces = outlines.iter().filter_map(|outline| match outline.shape {
            OutlineShape::Disc { center_m, radius_m } if center_m == [0.0; 2] => Some(Shape::Disc { radius_m }),
            OutlineShape::Capsule { from_m, to_m, radius_m } => Some(Shape::Capsule { from_m, to_m, radius_m }),
            OutlineShape::HalfPlane { .. } => None,
            _ => Some(Shape::Polygon { corners_m: corners_m(&outline.shape) }),
        });
        let mut shapes: Vec<Shape> = surfaces.collect();
        // The ground has no bars.
        if body.is_some() {
            let bars = points.windows(2).filter(|ends| ends[0] != ends[1]);
            shapes.extend(bars.map(|ends| bar(ends[0], ends[1], 0.5 * PIN_PART * size_m)));
        }
        shapes.extend(points.iter().map(|point| circle(*point, PIN_PART * size_m)));
        let elements = mechanism.tendons.iter().flat_map(|tendon| &tendon.path).filter(|element| element.body == body);
        shapes.extend(elements.map(|element| circle(element.point_m, element.radius_m.max(0.5 * PIN_PART * size_m))));
        let is_driven = mechanism.actuators.iter().any(|actuator| {
            // The mirror image of a revolute joint has its bodies in the opposite order.
            let drives = |[a, b]: [Option<usize>; 2]| b == body || a == body && b.is_none();
            body.is_some() && actuator.on.terms.iter().any(|(joint, _)| drives(mechanism.joints[*joint].bodies))
        });
        let role = match body {
            None => BodyRole::Palm,
            Some(_) if points.is_empty() => BodyRole::Object,
            Some(_) if is_driven => BodyRole::Driver,
            Some(_) if outlines.is_empty() => BodyRole::Coupler,
            Some(_) => BodyRole::Distal,
        };
        Body { name: mechanism.body_name(body).to_owned(), role, fixed: body.is_none(), shapes }
    });
    let drawn = half_planes.chain(bodies);
    let start = poses_at_start(mechanism);
    let at_start = |body: usize| {
        let [x, y, angle_rad] = start[body];
        BodyState { centre_m: [x, y], angle_rad, ..BodyState::default() }
    };
    let cable = |CableBar { name, pose, ends, segment_m, .. }: CableBar| {
        let [from_m, to_m] = ends.map(|end| [end * segment_m, 0.0]);
        let shapes = vec![bar(from_m, to_m, 0.2 * PIN_PART * size_m)];
        Part { body: None, pose, drawn: Body { name, role: BodyRole::Coupler, fixed: false, shapes } }
    };
    let cables = cables(mechanism, &at_start).into_iter().map(cable);
    placements(mechanism).zip(drawn).map(|((body, pose), drawn)| Part { body, pose, drawn }).chain(cables).collect()
}

/// Points of the joints of a body, in its frame.
fn joint_points(mechanism: &Mechanism, body: Option<usize>) -> impl Iterator<Item = [f64; 2]> + '_ {
    let points = mechanism.joints.iter().flat_map(|joint| joint.bodies.into_iter().zip(joint.points_m));
    points.filter(move |(other, _)| *other == body).map(|(_, point)| point)
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
    Shape::Polygon { corners_m: corners_m(&OutlineShape::Disc { center_m, radius_m }) }
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

/// Lower left and upper right corner of everything at the start except half planes. A body on a pin of the ground may
/// turn all round.
fn extent(mechanism: &Mechanism, parts: &[Part]) -> [[f64; 2]; 2] {
    let bodies: Vec<Pose> =
        poses_at_start(mechanism).into_iter().map(|[x, y, angle_rad]| pose([x, y], angle_rad)).collect();
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let mut include = |[x, y]: [f64; 2], radius: f64| {
        low = [low[0].min(x - radius), low[1].min(y - radius)];
        high = [high[0].max(x + radius), high[1].max(y + radius)];
    };
    for Part { body, pose: local, drawn } in parts {
        let pose = in_world(body.map_or(Pose::default(), |body| bodies[body]), *local);
        let pivot = body.and_then(|body| {
            let is_ground_pin = |joint: &&Joint| joint.bodies == [None, Some(body)];
            mechanism.joints.iter().find(is_ground_pin).map(|joint| joint.points_m[0])
        });
        for shape in &drawn.shapes {
            let points: Vec<([f64; 2], f64)> = match shape {
                Shape::Polygon { corners_m } => corners_m.iter().map(|corner| (*corner, 0.0)).collect(),
                Shape::Capsule { from_m, to_m, radius_m } => vec![(*from_m, *radius_m), (*to_m, *radius_m)],
                Shape::Disc { radius_m } => vec![([0.0; 2], *radius_m)],
                Shape::HalfPlane { .. } => Vec::new(),
            };
            for (point, radius_m) in points {
                let at = pose.apply(point);
                include(at, radius_m);
                if let Some([x, y]) = pivot {
                    include([x, y], hypot(at[0] - x, at[1] - y) + radius_m);
                }
            }
        }
    }
    if low[0].is_finite() { [low, high] } else { [[-0.05; 2], [0.05; 2]] }
}
