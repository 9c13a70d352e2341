//! Cables: the pulleys that are on their paths, their wraps, and the speed of a cable over its path elements.

use super::coordinate::{BodyPose, Circle, Coordinate, Row, Segment, Twist, segments, wraps};
use crate::law::FrictionLaw;
use crate::mechanism::tendon::CableFault;
use crate::numeric::elementary::hypot;
use crate::numeric::plane::{angle_between, dot, perp, scale, sub};

/// A cable is off a pulley from a wrap of −`BAND` on, and on it again from a gap of −`BAND` radii on.
const BAND: f64 = 1e-10;
/// A wrap below this after a step is one that has grown beyond 270 degrees, rad.
const UNWRAPPED: f64 = -0.75;

/// Friction of a cable on one of its circles.
#[derive(Clone, Copy, Debug)]
pub struct PlannedCableFriction {
    pub tendon: usize,
    pub circle: usize,
    /// The law under a normal force of 1: the force is the friction coefficient.
    pub law: FrictionLaw,
}

/// Finds the circles that are on a path, from those that were before: a circle with the most negative wrap leaves it, otherwise
/// one with the most negative gap joins it, until there is neither. The first path of a run has no fault.
pub(super) fn update_path(circles: &mut [Circle], poses: &[BodyPose], is_first: bool) -> Option<CableFault> {
    let pose = |body: usize| poses[body];
    // Two circles without a segment have a wrap that is not a number.
    if circles.iter().all(|circle| circle.is_on) && wraps(circles, &pose).all(|(_, wrap)| wrap >= -BAND) {
        return None;
    }
    loop {
        let on: Vec<usize> = (0..circles.len()).filter(|index| circles[*index].is_on).collect();
        let parts: Vec<Segment> = segments(circles, &pose).collect();
        if let Some(open) = parts.iter().position(|part| part.length.is_nan()) {
            return Some(CableFault::NoSegment([on[open], on[open + 1]]));
        }
        let lifted = wraps(circles, &pose).filter(|(_, wrap)| *wrap < -BAND);
        if let Some((index, wrap)) = lifted.min_by(|a, b| a.1.total_cmp(&b.1)) {
            if wrap < UNWRAPPED && !is_first {
                return Some(CableFault::TooFar(index));
            }
            circles[index].is_on = false;
            continue;
        }
        let off = (0..circles.len()).filter(|index| !circles[*index].is_on);
        let depth = |index: usize| {
            let place = on.iter().rposition(|before| *before < index).unwrap_or(0);
            let ends = [circles[on[place]], circles[on[place + 1]]];
            (index, gap(&circles[index], &parts[place], ends, &pose) / circles[index].signed_radius_m.abs())
        };
        let reached = off.map(depth).filter(|(_, gap)| *gap < -BAND).min_by(|a, b| a.1.total_cmp(&b.1));
        let (index, gap) = reached?;
        // A gap that closes is small; one that jumps is that of a segment behind the centre.
        if gap < -1.0 && !is_first {
            return Some(CableFault::Behind(index));
        }
        circles[index].is_on = true;
    }
}

/// Distance of a circle from a segment between two others, less its radius; negative if the segment crosses it.
fn gap(circle: &Circle, part: &Segment, ends: [Circle; 2], pose: &dyn Fn(usize) -> BodyPose) -> f64 {
    let (center, radius) = (circle.position(pose), circle.signed_radius_m);
    let across = perp(part.along);
    let [from, to] = ends.map(|end| sub(end.position(pose), scale(across, end.signed_radius_m)));
    let [[x, y], beyond] = [sub(center, from), sub(center, to)];
    let distance = if dot([x, y], part.along) < 0.0 {
        hypot(x, y)
    } else if dot(beyond, part.along) > 0.0 {
        hypot(beyond[0], beyond[1])
    } else {
        dot([x, y], across) * radius.signum()
    };
    distance - radius.abs()
}

/// Angle by which a cable turns about a circle: the wrap of a pulley, or the angle at an eyelet without its sign.
pub(super) fn turn(circles: &[Circle], index: usize, poses: &[BodyPose]) -> f64 {
    let pose = |body: usize| poses[body];
    if circles[index].signed_radius_m != 0.0 {
        return wraps(circles, &pose).find(|(of, _)| *of == index).map_or(0.0, |(_, wrap)| wrap.max(0.0));
    }
    let place = circles[..index].iter().filter(|circle| circle.is_on).count();
    let parts: Vec<Segment> = segments(circles, &pose).skip(place - 1).take(2).collect();
    angle_between(parts[0].along, parts[1].along).abs()
}

/// Row of the speed of a cable over a circle towards its first segment: what the segments and spools behind it lose, and the
/// rotation of the circle.
pub(super) fn slip_row(circles: &[Circle], index: usize, far: &[(Coordinate, f64)], poses: &[BodyPose]) -> Row {
    let place = circles[..index].iter().filter(|circle| circle.is_on).count();
    let pose = |body: usize| poses[body];
    let behind = segments(circles, &pose).skip(place).flat_map(|part| part.sides(-1.0));
    let spools = far.iter().flat_map(|(spool, factor)| {
        let row = spool.row(poses);
        let sides: Vec<_> = row.sides().map(|(body, row)| (*body, row.map(|part| -factor * part))).collect();
        sides
    });
    let circle = &circles[index];
    let rotation = circle.center.body.map(|body| (body, [0.0, 0.0, circle.signed_radius_m]));
    Row::sum(behind.chain(spools).chain(rotation))
}

/// Rate of this speed without accelerations.
pub(super) fn slip_rate(
    circles: &[Circle],
    index: usize,
    far: &[(Coordinate, f64)],
    (poses, velocities): (&[BodyPose], &[Twist]),
) -> f64 {
    let place = circles[..index].iter().filter(|circle| circle.is_on).count();
    let behind: f64 = segments(circles, &|body| poses[body]).skip(place).map(|part| part.second_rate(velocities)).sum();
    let spools: f64 = far.iter().map(|(spool, factor)| factor * spool.second_rate(poses, velocities)).sum();
    -behind - spools
}

/// Rate of the turn about a circle, as a difference.
pub(super) fn turn_rate(circles: &[Circle], index: usize, poses: &[BodyPose], velocities: &[Twist]) -> f64 {
    const INTERVAL_S: f64 = 1e-7;
    let after: Vec<BodyPose> = poses.iter().zip(velocities).map(|(pose, v)| pose.after(INTERVAL_S, v)).collect();
    (turn(circles, index, &after) - turn(circles, index, poses)) / INTERVAL_S
}

/// State of a cable at a circle.
#[derive(Clone, Copy, Debug, Default)]
pub struct CableReading {
    pub is_on: bool,
    /// Wrap, rad; 0 if the cable is off.
    pub turn: f64,
    /// Distance of the cable from a circle that it is off, m.
    pub gap: f64,
    /// Speed of the cable towards the first segment, m/s; 0 if the cable is off or has no friction.
    pub slip: f64,
    /// Tension behind the circle, N.
    pub tension: f64,
}

/// Reads a circle of a cable, without the tension; `rubs` states whether the cable has friction.
pub(super) fn read_circle(
    circles: &[Circle],
    index: usize,
    (far, rubs): (&[(Coordinate, f64)], bool),
    (poses, velocities): (&[BodyPose], &[Twist]),
) -> CableReading {
    let (is_on, none) = (circles[index].is_on, CableReading::default());
    if is_on {
        let slip = if rubs { slip_row(circles, index, far, poses).rate(velocities) } else { 0.0 };
        return CableReading { is_on, turn: turn(circles, index, poses), slip, ..none };
    }
    let pose = |body: usize| poses[body];
    let on: Vec<usize> = (0..circles.len()).filter(|index| circles[*index].is_on).collect();
    let place = on.iter().rposition(|before| *before < index).unwrap_or(0);
    let ends = [circles[on[place]], circles[on[place + 1]]];
    let part = segments(circles, &pose).nth(place);
    CableReading { gap: part.map_or(0.0, |part| gap(&circles[index], &part, ends, &pose)), ..none }
}
