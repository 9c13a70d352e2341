//! Dyads: two bodies with three joints, which close a loop. A dyad is solved in two steps: its positions in closed form,
//! as the intersection of two circles or lines, then the rates of its outer joints from the closure of its inner joint,
//! which is linear.

use super::joint::{Closure, axis, carried, carried_bias, closure, column, place, quadratic_terms};
use super::motion::{BodyMotion, Motions, Part, pair, rotated, triple};
use crate::mechanism::structure::Attachment;
use crate::mechanism::{Joint, Mechanism};
use crate::numeric::Real;
use crate::numeric::elementary::{atan2, sin_cos};
use crate::numeric::plane::{add, cross, dot, nearest_equivalent_angle, perp, scale, scale_by, sub};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

/// Assembly mode of a dyad: the sign of its root, and the ranges of the angles of its bodies.
///
/// Whole turns of a body do not follow from its direction. In an assembly mode, each body is within a range of half a turn
/// or less about an angle that follows from another one. If an outer joint slides, this is the angle of the body that
/// slides; otherwise that of the line between the pivots of the outer joints, whose turns the mode of the model counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct AssemblyMode {
    pub sign: f64,
    /// Middles of the ranges of the two bodies, relative to the reference angle. If the reference is the line, they are
    /// relative to its angle at the start.
    pub middles_rad: [f64; 2],
    pub line: Option<PivotLine>,
    /// Whether the angles of the dyad are evaluated together with its positions, because forces or other bodies depend
    /// on them.
    pub has_angles: bool,
    /// Whether the motions of the two outer joints and of the inner joint are evaluated together with those of the
    /// bodies, because forces or other joints depend on them.
    pub moves_joints: [bool; 3],
}

/// The line from the pivot of the first outer joint of a dyad to that of the second.
#[derive(Clone, Copy, Debug)]
pub(super) struct PivotLine {
    /// Index of the count of turns of the line.
    pub count: usize,
    /// Direction of the line at the start.
    pub start: [f64; 2],
}

/// Counts per turn of a line. A state is at most a few counts away from the one before, and angles are exact while the line
/// is less than a quarter of a turn from its count.
const COUNTS_PER_TURN: usize = 8;

/// Directions of all counts within a turn.
const COUNT_DIRECTIONS: [[f64; 2]; COUNTS_PER_TURN] = [
    [1.0, 0.0],
    [FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [0.0, 1.0],
    [-FRAC_1_SQRT_2, FRAC_1_SQRT_2],
    [-1.0, 0.0],
    [-FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
    [0.0, -1.0],
    [FRAC_1_SQRT_2, -FRAC_1_SQRT_2],
];

/// Cosine of the angle beyond which the line is counted anew: 30°.
const RECOUNT_COSINE: f64 = 0.866;
/// Cosine of the largest angle of the line at the end of a step: 75°.
const VALID_COSINE: f64 = 0.26;
/// Largest motion of the pivots in a step, as a fraction of their distance: the line turns by less than 30°.
const LINE_STEP: f64 = 0.5;
/// The same with the speed at the end of the step: the line turns by less than 45°.
const LINE_STEP_AT_END: f64 = 0.7;

impl PivotLine {
    /// Cosine and sine of the angle of the line relative to its count.
    fn relative(&self, counts: &[i32], offset: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = COUNT_DIRECTIONS[counts[self.count].rem_euclid(COUNTS_PER_TURN as i32) as usize];
        let reference = rotated(self.start, [cos, sin]);
        let length = dot(offset, offset).sqrt();
        [dot(reference, offset) / length, cross(reference, offset) / length]
    }

    /// Returns the new count after an accepted step; `None` if the line is still in the range of its count.
    pub fn recounted(&self, counts: &[i32], offset: [f64; 2]) -> Option<i32> {
        let [cos, sin] = self.relative(counts, offset);
        (cos < RECOUNT_COSINE)
            .then(|| counts[self.count] + (atan2(sin, cos) / TAU * COUNTS_PER_TURN as f64).round() as i32)
    }

    /// Whether the count at the start of a step of length `dt` is still valid at its end; `offset` and `rate` are the
    /// relative position and rate of the pivots there.
    pub fn is_valid(&self, dt: f64, counts: &[i32], (offset, rate): ([f64; 2], [f64; 2])) -> bool {
        let motion = dt * dot(rate, rate).sqrt();
        motion <= LINE_STEP_AT_END * dot(offset, offset).sqrt() && self.relative(counts, offset)[0] >= VALID_COSINE
    }

    /// Returns the longest allowed step; `offset` and `rate` are the relative position and rate of the pivots.
    pub fn max_step(offset: [f64; 2], rate: [f64; 2]) -> f64 {
        LINE_STEP * (dot(offset, offset) / dot(rate, rate)).sqrt()
    }
}

/// Offset of the pivots of the outer joints of a dyad, and its rate.
pub(super) fn pivot_offset(
    mechanism: &Mechanism,
    outer: &[Attachment; 2],
    motions: &Motions<f64>,
) -> ([f64; 2], [f64; 2]) {
    let [from, to] = pair(|k| {
        let (at, base) = (&outer[k], motions.body(outer[k].base));
        let arm = base.rotated(mechanism.joints[at.joint].points_m[usize::from(!at.is_second)]);
        (add(base.origin, arm), base.rate_at(arm))
    });
    (sub(to.0, from.0), sub(to.1, from.1))
}

/// Middles of the ranges of the angles of both bodies of a dyad.
pub(super) fn middles(
    mechanism: &Mechanism,
    outer: &[Attachment; 2],
    mode: &AssemblyMode,
    motions: &Motions<f64>,
) -> [f64; 2] {
    let from = match mode.line {
        Some(line) => TAU / COUNTS_PER_TURN as f64 * f64::from(motions.counts[line.count]),
        None => sliding_angle(mechanism, outer, |base| motions.body(base).angle).map_or(0.0, |(_, angle)| angle),
    };
    mode.middles_rad.map(|middle| from + middle)
}

/// The first body of a dyad whose outer joint slides, and its angle.
fn sliding_angle(
    mechanism: &Mechanism,
    outer: &[Attachment; 2],
    base_angle: impl Fn(Option<usize>) -> f64,
) -> Option<(usize, f64)> {
    let k = outer.iter().position(|at| !mechanism.joints[at.joint].kind.is_angle())?;
    Some((k, base_angle(outer[k].base) + outer[k].sign() * mechanism.joints[outer[k].joint].offset_rad))
}

/// Assembly mode of a dyad in its pose at the start; the sign of the root remains to be set. `count` is the first
/// unused index of the counts of turns.
pub(super) fn mode_at_start(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    motions: &Motions<f64>,
    count: usize,
) -> AssemblyMode {
    let joints = pair(|k| &mechanism.joints[outer[k].joint]);
    let inner = &mechanism.joints[inner];
    let of = inner_bodies(inner, outer);
    let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
    let bodies = pair(|k| &motions.bodies[outer[k].body]);
    // The inner joint as seen from the pivot of a body, or the normal of a slide.
    let arm = |k: usize| match inner.kind.axis_rad() {
        None => bodies[k].rotated(sub(points[k], joints[k].points_m[usize::from(outer[k].is_second)])),
        Some(axis_rad) => perp(axis(axis_rad, bodies[of[0]])),
    };
    let angle_from = |from: [f64; 2], k: usize| atan2(cross(from, arm(k)), dot(from, arm(k)));
    let (middles_rad, line) = match sliding_angle(mechanism, outer, |base| motions.body(base).angle) {
        None => {
            let (offset, _) = pivot_offset(mechanism, outer, motions);
            // Both arms, or the normal, are on one side of the line.
            let middle = |k: usize| {
                let angle = angle_from(offset, k);
                bodies[k].angle - angle + FRAC_PI_2.copysign(angle)
            };
            let start = scale_by(offset, 1.0 / dot(offset, offset).sqrt());
            (pair(middle), Some(PivotLine { count, start }))
        }
        Some((slider, angle)) => {
            let middle = |k: usize| match (inner.kind.axis_rad(), joints[slider].kind.axis_rad()) {
                _ if k == slider => 0.0,
                // The component of the arm along the slide keeps its sign.
                (None, Some(axis_rad)) => {
                    let at = &outer[slider];
                    let along = axis(axis_rad, if at.is_second { motions.body(at.base) } else { bodies[slider] });
                    let from = if dot(along, arm(k)) < 0.0 { scale_by(along, -1.0) } else { along };
                    bodies[k].angle - angle_from(from, k) - angle
                }
                // The bodies turn together.
                _ => bodies[k].angle - angle,
            };
            (pair(middle), None)
        }
    };
    AssemblyMode { sign: 1.0, middles_rad, line, has_angles: true, moves_joints: [true; 3] }
}

/// A dyad as it is in one pose: outer joints, and the sine and cosine of the transmission angle with its rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transmission {
    pub sine: f64,
    pub cosine: f64,
    pub angle_rate: f64,
}

/// A function of the closure at a motion of one body.
#[inline(always)]
pub(super) fn applied<T: Real>(closure: &Closure<T>, equation: usize, body: usize, motion: [T; 3]) -> T {
    let [x, y, angle] = closure[equation][body];
    x * motion[0] + y * motion[1] + angle * motion[2]
}

/// Evaluates the motions of the two placed bodies of a dyad, and of its outer joints where `moves_joints` asks for them.
#[inline(always)]
pub(super) fn close_dyad<T: Real>(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    moves_joints: [bool; 2],
    motions: &mut Motions<T>,
    part: Part,
) {
    let joints = pair(|k| &mechanism.joints[outer[k].joint]);
    let inner = &mechanism.joints[inner];
    let of = inner_bodies(inner, outer);
    if joints[0].kind.is_angle() && joints[1].kind.is_angle() && inner.kind.is_angle() {
        let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
        return close_pins((joints, outer, points), moves_joints, motions, part);
    }
    let base_of = pair(|k| motions.index(outer[k].base));
    let bases = pair(|k| motions.bodies[base_of[k]]);
    let mut bodies = pair(|k| motions.bodies[outer[k].body]);
    let closure = closure(inner, of, &bodies);
    let columns = pair(|k| column(joints[k], &outer[k], [&bases[k], &bodies[k]]));
    let inverse = inverse_closure(&closure, &columns);
    // Motions of both outer joints that close the dyad, from the motions of its bodies with these joints at rest.
    let closing = |carried: [[T; 3]; 2], terms: [T; 2]| {
        let residual = pair(|equation| {
            applied(&closure, equation, 0, carried[0]) + applied(&closure, equation, 1, carried[1]) + terms[equation]
        });
        pair(|k| -(inverse[k][0] * residual[0] + inverse[k][1] * residual[1]))
    };
    let across = pair(|k| perp(sub(bodies[k].origin, bases[k].origin)));
    // Coriolis terms of slides contain the rates of the joints.
    move_closed(outer, [true; 2], motions, part, |bases| {
        let carried = pair(|k| carried(bases[k], across[k]));
        let rows = closing(carried, [T::zero(); 2]);
        (rows, pair(|k| triple(|axis| carried[k][axis] + columns[k][axis] * rows[k])))
    });
    if !part.has_derivatives() {
        return;
    }
    for k in 0..2 {
        bodies[k].rate = motions.bodies[outer[k].body].rate;
        let rate = motions.joints[outer[k].joint].rate;
        bodies[k].bias = carried_bias(joints[k], &outer[k], [&bases[k], &bodies[k]], rate);
    }
    let biases = closing(pair(|k| bodies[k].bias), quadratic_terms(inner, of, &bodies));
    for k in 0..2 {
        motions.joints[outer[k].joint].bias = biases[k];
        motions.bodies[outer[k].body].bias = triple(|axis| bodies[k].bias[axis] + columns[k][axis] * biases[k]);
    }
}

/// Evaluates the rates of the outer joints and the bodies of a dyad, and their motions per unit of each coordinate rate.
/// `closed` returns the motions of joints and bodies from those of the bases.
#[inline(always)]
fn move_closed<T: Real>(
    outer: &[Attachment; 2],
    moves_joints: [bool; 2],
    motions: &mut Motions<T>,
    part: Part,
    closed: impl Fn([[T; 3]; 2]) -> ([T; 2], [[T; 3]; 2]),
) {
    let bases = pair(|k| motions.index(outer[k].base));
    if part.has_rates() {
        let (turns, moved) = closed(pair(|k| motions.bodies[bases[k]].rate));
        for k in 0..2 {
            motions.bodies[outer[k].body].rate = moved[k];
            if moves_joints[k] {
                motions.joints[outer[k].joint].rate = turns[k];
            }
        }
    }
    if !part.has_derivatives() {
        return;
    }
    let Motions { body_supports, joint_supports, columns, rows, .. } = motions;
    let of_bases = pair(|k| body_supports[bases[k]].first);
    let of_bodies = pair(|k| body_supports[outer[k].body].first);
    let of_joints = pair(|k| joint_supports[outer[k].joint].first);
    for &i in &body_supports[outer[0].body].coordinates {
        let (turns, moved) = closed(pair(|k| columns[of_bases[k] + i]));
        for k in 0..2 {
            columns[of_bodies[k] + i] = moved[k];
            if moves_joints[k] {
                rows[of_joints[k] + i] = turns[k];
            }
        }
    }
}

/// [`close_dyad`] for three revolute joints, with the points of the inner joint in the frames of both bodies.
///
/// The inner joint moves with each base, by r₁ and r₂, and about the pivot of each outer joint: r₁ + w₁ d₁⊥ = r₂ + w₂ d₂⊥
/// with the arms d from the pivots. Therefore w₁ = (r₂ − r₁)·d₂/(d₁ × d₂), and likewise w₂.
#[inline(always)]
fn close_pins<T: Real>(
    (joints, outer, points): ([&Joint; 2], &[Attachment; 2], [[f64; 2]; 2]),
    moves_joints: [bool; 2],
    motions: &mut Motions<T>,
    part: Part,
) {
    let [a, b] = pair(|k| motions.index(outer[k].base));
    let [first, second] = pair(|k| outer[k].body);
    let Motions { bodies, joints: of_joints, body_supports, joint_supports, columns, rows, .. } = motions;
    let pivot = |k: usize| joints[k].points_m[usize::from(outer[k].is_second)];
    let arms = [bodies[first].rotated(points[0]), bodies[second].rotated(points[1])];
    let to_inner = add(bodies[first].origin, arms[0]);
    let from_pivot =
        [bodies[first].rotated(sub(points[0], pivot(0))), bodies[second].rotated(sub(points[1], pivot(1)))];
    let from_base = [sub(to_inner, bodies[a].origin), sub(to_inner, bodies[b].origin)];
    let inverse = cross(from_pivot[0], from_pivot[1]).recip();
    let [by_first, by_second] = [scale(from_pivot[1], inverse), scale(from_pivot[0], inverse)];
    // Motion of the inner joint and rates about both pivots, from its motions with both bases.
    let closed = |[with_a, with_b]: [[T; 2]; 2]| {
        let gap = sub(with_b, with_a);
        let turns = [dot(gap, by_first), dot(gap, by_second)];
        ([with_a[0] - from_pivot[0][1] * turns[0], with_a[1] + from_pivot[0][0] * turns[0]], turns)
    };
    let with_base = |[x, y, turn]: [T; 3], arm: [T; 2]| [x - arm[1] * turn, y + arm[0] * turn];
    // Motions of both bodies and rates about both pivots, from the motions of both bases.
    let moved = |of_a: [T; 3], of_b: [T; 3]| {
        let (motion, turns) = closed([with_base(of_a, from_base[0]), with_base(of_b, from_base[1])]);
        let of_body = |k: usize, base_turn: T| {
            let turn = base_turn + turns[k];
            [motion[0] + arms[k][1] * turn, motion[1] - arms[k][0] * turn, turn]
        };
        ([of_body(0, of_a[2]), of_body(1, of_b[2])], turns)
    };
    if part.has_rates() {
        let (rates, turns) = moved(bodies[a].rate, bodies[b].rate);
        (bodies[first].rate, bodies[second].rate) = (rates[0], rates[1]);
        for k in 0..2 {
            if moves_joints[k] {
                of_joints[outer[k].joint].rate = turns[k] * outer[k].sign();
            }
        }
    }
    if !part.has_derivatives() {
        return;
    }
    let [of_a, of_b, of_first, of_second] = [a, b, first, second].map(|body| body_supports[body].first);
    for &i in &body_supports[first].coordinates {
        let (of_bodies, turns) = moved(columns[of_a + i], columns[of_b + i]);
        (columns[of_first + i], columns[of_second + i]) = (of_bodies[0], of_bodies[1]);
        for k in 0..2 {
            if moves_joints[k] {
                rows[joint_supports[outer[k].joint].first + i] = turns[k] * outer[k].sign();
            }
        }
    }
    let squared = [bodies[first].rate[2].squared(), bodies[second].rate[2].squared()];
    let bases = [a, b].map(|base| (bodies[base].bias, bodies[base].rate[2].squared()));
    let carried = pair(|k| {
        let (bias, base_squared) = bases[k];
        let [x, y] = with_base(bias, from_base[k]);
        let centripetal =
            |axis: usize| (from_base[k][axis] - from_pivot[k][axis]) * base_squared + from_pivot[k][axis] * squared[k];
        [x - centripetal(0), y - centripetal(1)]
    });
    let (motion, turns) = closed(carried);
    for (k, body) in [first, second].into_iter().enumerate() {
        let turn = bases[k].0[2] + turns[k];
        let [x, y] = arms[k];
        bodies[body].bias = [motion[0] + y * turn + x * squared[k], motion[1] - x * turn + y * squared[k], turn];
        if moves_joints[k] {
            of_joints[outer[k].joint].bias = turns[k] * outer[k].sign();
        }
    }
}

/// Inverse of the 2 × 2 matrix of the closure by the rates of the outer joints.
#[inline(always)]
fn inverse_closure<T: Real>(closure: &Closure<T>, columns: &[[T; 3]; 2]) -> [[T; 2]; 2] {
    let matrix = pair(|equation| pair(|k| applied(closure, equation, k, columns[k])));
    let inverse_det = (matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]).recip();
    [
        [matrix[1][1] * inverse_det, -(matrix[0][1] * inverse_det)],
        [-(matrix[1][0] * inverse_det), matrix[0][0] * inverse_det],
    ]
}

/// Indices in the dyad of the bodies A and B of its inner joint.
#[inline(always)]
pub(super) fn inner_bodies(inner: &Joint, outer: &[Attachment; 2]) -> [usize; 2] {
    if inner.bodies[0] == Some(outer[0].body) { [0, 1] } else { [1, 0] }
}

/// Evaluates the motion of the inner joint of a dyad, whose coordinate is known.
#[inline(always)]
pub(super) fn move_inner_joint<T: Real>(
    mechanism: &Mechanism,
    (outer, index): (&[Attachment; 2], usize),
    motions: &mut Motions<T>,
    part: Part,
) {
    let of = inner_bodies(&mechanism.joints[index], outer);
    move_joint_between(mechanism, pair(|k| outer[of[k]].body), index, motions, part);
}

/// Evaluates the motion of a joint whose coordinate is known from those of its bodies.
#[inline(always)]
pub(super) fn move_joint_between<T: Real>(
    mechanism: &Mechanism,
    of: [usize; 2],
    index: usize,
    motions: &mut Motions<T>,
    part: Part,
) {
    let inner = &mechanism.joints[index];
    let [first, second] = pair(|k| &motions.bodies[of[k]]);
    // The motion of the joint from those of both bodies.
    match inner.kind.axis_rad() {
        None => {
            if part.has_derivatives() {
                motions.joints[index].bias = second.bias[2] - first.bias[2];
            }
            move_by_bodies(of, index, motions, part, |[first, second]| second[2] - first[2]);
        }
        Some(axis_rad) => {
            let u = axis(axis_rad, first);
            let arms = [first.rotated(inner.points_m[0]), second.rotated(inner.points_m[1])];
            if part.has_derivatives() {
                // The bodies turn together: n·ḋ = ω q, with the distance d = q u.
                let bias = dot(u, sub(second.bias_at(arms[1]), first.bias_at(arms[0])));
                let turning = first.rate[2].squared() * motions.joints[index].coordinate;
                motions.joints[index].bias = bias + turning;
            }
            let across = [perp(arms[0]), perp(arms[1])];
            move_by_bodies(of, index, motions, part, |bodies| {
                let [first, second] = pair(|k| carried(bodies[k], across[k]));
                let along = |axis: usize| u[axis] * (second[axis] - first[axis]);
                along(0) + along(1)
            });
        }
    }
}

/// Evaluates the rate of a joint and its derivatives, by a function of the motions of its bodies.
#[inline(always)]
fn move_by_bodies<T: Real>(
    bodies: [usize; 2],
    joint: usize,
    motions: &mut Motions<T>,
    part: Part,
    motion: impl Fn([[T; 3]; 2]) -> T,
) {
    if part.has_rates() {
        motions.joints[joint].rate = motion(pair(|k| motions.bodies[bodies[k]].rate));
    }
    if part.has_derivatives() {
        let Motions { body_supports, joint_supports, columns, rows, .. } = motions;
        let (of_row, of_bodies) = (joint_supports[joint].first, pair(|k| body_supports[bodies[k]].first));
        for &k in &joint_supports[joint].coordinates {
            rows[of_row + k] = motion(pair(|side| columns[of_bodies[side] + k]));
        }
    }
}

/// Locus of a point of a body that is attached at a joint.
#[derive(Clone, Copy)]
enum Locus {
    /// A circle about the pivot; `arm` is the arm to the point in the body frame.
    Circle { center: [f64; 2], arm: [f64; 2] },
    /// A line in the direction of the coordinate of the joint; `angle` is the angle of the body.
    Line { point: [f64; 2], direction: [f64; 2], angle: f64 },
}

impl Locus {
    /// Locus of a point (in the frame of the attached body).
    #[inline(always)]
    fn new(joint: &Joint, at: &Attachment, base: &BodyMotion<f64>, point: [f64; 2]) -> Self {
        let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
        let pivot = base.position(joint.points_m[1 - own]);
        let arm = sub(point, joint.points_m[own]);
        match joint.kind.axis_rad() {
            None => Locus::Circle { center: pivot, arm },
            Some(axis_rad) => {
                let angle = base.angle + sign * joint.offset_rad;
                let (sin, cos) = sin_cos(angle);
                let body = BodyMotion { direction: [cos, sin], angle, ..BodyMotion::ground() };
                let first = if at.is_second { base.direction } else { body.direction };
                let first = BodyMotion { direction: first, ..BodyMotion::ground() };
                let direction = scale_by(axis(axis_rad, &first), sign);
                Locus::Line { point: add(pivot, body.rotated(arm)), direction, angle }
            }
        }
    }
}

/// Angle of a body at an outer joint of a dyad, from its direction and the middle of its range, and the coordinate of the
/// joint.
pub(super) fn outer_angle(
    joint: &Joint,
    at: &Attachment,
    base_angle: f64,
    [cos, sin]: [f64; 2],
    middle_rad: f64,
) -> (f64, f64) {
    let coordinate_at = |angle: f64| at.sign() * (angle - base_angle) - joint.offset_rad;
    let coordinate = nearest_equivalent_angle(coordinate_at(atan2(sin, cos)), coordinate_at(middle_rad));
    (base_angle + at.sign() * (coordinate + joint.offset_rad), coordinate)
}

/// Poses of the two bodies of a dyad and coordinates of its outer joints, from the intersection of the loci of its inner
/// joint. Not a number if there is none. Angles of circles are 0 unless the mode has angles.
#[inline(always)]
pub(super) fn place_dyad(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    bases: [&BodyMotion<f64>; 2],
    (mode, middles): (&AssemblyMode, [f64; 2]),
) -> ([BodyMotion<f64>; 2], [f64; 2]) {
    let joints = pair(|k| &mechanism.joints[outer[k].joint]);
    let inner = &mechanism.joints[inner];
    let of = inner_bodies(inner, outer);
    // Points of the inner joint, in the order of the bodies of the dyad.
    let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
    let loci = pair(|k| Locus::new(joints[k], &outer[k], bases[k], points[k]));
    let nearest = |k: usize, raw: f64| match joints[k].kind.is_angle() {
        true => {
            let middle = outer[k].sign() * (middles[k] - bases[k].angle) - joints[k].offset_rad;
            nearest_equivalent_angle(raw, middle)
        }
        false => raw,
    };
    if let Some(axis_rad) = inner.kind.axis_rad() {
        let raw = slide(joints, (inner, of, axis_rad), outer, bases, (&loci, mode.sign));
        let coordinates = pair(|k| nearest(k, raw[k]));
        let mut bodies = [BodyMotion::ground(); 2];
        for (k, body) in bodies.iter_mut().enumerate() {
            place(joints[k], &outer[k], bases[k], coordinates[k], body);
        }
        return (bodies, coordinates);
    }
    let position = intersection(&loci, mode.sign);
    let mut bodies = [BodyMotion::ground(); 2];
    let mut coordinates = [0.0; 2];
    for (k, body) in bodies.iter_mut().enumerate() {
        match loci[k] {
            Locus::Circle { center, arm } => {
                let offset = sub(position, center);
                body.direction = scale_by([dot(arm, offset), cross(arm, offset)], 1.0 / dot(arm, arm));
                if mode.has_angles {
                    let base_angle = bases[k].angle;
                    (body.angle, coordinates[k]) =
                        outer_angle(joints[k], &outer[k], base_angle, body.direction, middles[k]);
                }
            }
            Locus::Line { point, direction, angle } => {
                *body = BodyMotion::at([0.0, 0.0, angle], [0.0; 3]);
                coordinates[k] = dot(sub(position, point), direction);
            }
        }
        body.origin = sub(position, body.rotated(points[k]));
    }
    (bodies, coordinates)
}

/// Intersection of two circles, a circle and a line, or two lines.
#[inline(always)]
fn intersection(loci: &[Locus; 2], sign: f64) -> [f64; 2] {
    match *loci {
        [Locus::Circle { center, arm }, Locus::Circle { center: other, arm: other_arm }] => {
            let offset = sub(other, center);
            let squared = dot(offset, offset);
            let along = (dot(arm, arm) - dot(other_arm, other_arm) + squared) / (2.0 * squared);
            let across = (dot(arm, arm) / squared - along * along).sqrt();
            add(center, add(scale_by(offset, along), scale_by(perp(offset), sign * across)))
        }
        [Locus::Circle { center, arm }, Locus::Line { point, direction, .. }]
        | [Locus::Line { point, direction, .. }, Locus::Circle { center, arm }] => {
            let offset = sub(center, point);
            let (along, distance) = (dot(offset, direction), cross(direction, offset));
            let half = (dot(arm, arm) - distance * distance).sqrt();
            add(point, scale_by(direction, along + sign * half))
        }
        [Locus::Line { point, direction, .. }, Locus::Line { point: other, direction: other_direction, .. }] => {
            let along = cross(sub(other, point), other_direction) / cross(direction, other_direction);
            add(point, scale_by(direction, along))
        }
    }
}

/// Coordinates of the outer joints of a dyad whose inner joint slides.
fn slide(
    joints: [&Joint; 2],
    (inner, of, axis_rad): (&Joint, [usize; 2], f64),
    outer: &[Attachment; 2],
    bases: [&BodyMotion<f64>; 2],
    (loci, sign): (&[Locus; 2], f64),
) -> [f64; 2] {
    let [a, b] = of;
    // Angle of body A, from the distance of both points along the normal, or from a body that cannot turn.
    let angle = match (loci[a], loci[b]) {
        (Locus::Line { angle, .. }, _) => angle,
        (_, Locus::Line { angle, .. }) => angle - inner.offset_rad,
        (Locus::Circle { center, arm }, Locus::Circle { center: other, arm: other_arm }) => {
            let offset = sub(other, center);
            let turned = |[x, y]: [f64; 2], angle: f64| {
                let (sin, cos) = sin_cos(angle);
                [cos * x - sin * y, sin * x + cos * y]
            };
            let (sin, cos) = sin_cos(axis_rad);
            let height = dot([-sin, cos], sub(turned(other_arm, inner.offset_rad), arm));
            // n·offset = −height.
            let squared = dot(offset, offset);
            let across = (squared - height * height).sqrt();
            let normal = add(scale_by(offset, -height), scale_by(perp(offset), sign * across));
            atan2(-normal[0], normal[1]) - axis_rad
        }
    };
    let angles = if a == 0 { [angle, angle + inner.offset_rad] } else { [angle + inner.offset_rad, angle] };
    let (sin, cos) = sin_cos(angle + axis_rad);
    let normal = [-sin, cos];
    let position = |k: usize| match loci[k] {
        Locus::Circle { center, arm } => {
            let (sin, cos) = sin_cos(angles[k]);
            add(center, [cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]])
        }
        Locus::Line { point, .. } => point,
    };
    let gap = dot(normal, sub(position(b), position(a)));
    pair(|k| match loci[k] {
        Locus::Circle { .. } => outer[k].sign() * (angles[k] - bases[k].angle) - joints[k].offset_rad,
        Locus::Line { direction, .. } => {
            let side = if k == b { -1.0 } else { 1.0 };
            side * gap / dot(normal, direction)
        }
    })
}

/// Transmission angle of a dyad: between the directions whose alignment makes it singular.
pub(super) fn transmission(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    motions: &Motions<f64>,
) -> Transmission {
    let inner = &mechanism.joints[inner];
    let of = inner_bodies(inner, outer);
    let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
    // Direction of the arm or line of each outer joint, with its angular rate.
    let direction = |k: usize| {
        let (joint, at) = (&mechanism.joints[outer[k].joint], &outer[k]);
        let (base, body) = (motions.body(at.base), &motions.bodies[at.body]);
        match joint.kind.axis_rad() {
            None => {
                let own = usize::from(at.is_second);
                (body.rotated(sub(points[k], joint.points_m[own])), body.rate[2])
            }
            // The normal of a line takes the place of an arm.
            Some(axis_rad) => (perp(axis(axis_rad, if at.is_second { base } else { body })), body.rate[2]),
        }
    };
    let [first, second] = match inner.kind.axis_rad() {
        None => [direction(0), direction(1)],
        Some(axis_rad) => {
            let a = &motions.bodies[outer[of[0]].body];
            let slide = (axis(axis_rad, a), a.rate[2]);
            let is_circle = pair(|k| mechanism.joints[outer[k].joint].kind.is_angle());
            match is_circle {
                [true, true] => {
                    let pivot = |k: usize| {
                        let at = &outer[k];
                        motions.body(at.base).point(mechanism.joints[at.joint].points_m[usize::from(!at.is_second)])
                    };
                    let (from, to) = (pivot(0), pivot(1));
                    let (offset, speed) = (sub(to.position, from.position), sub(to.rate, from.rate));
                    // The dyad is singular where the line of the pivots is normal to the slide.
                    [slide, (perp(offset), cross(offset, speed) / dot(offset, offset))]
                }
                [first_is_circle, _] => {
                    let (normal, rate) = direction(usize::from(first_is_circle));
                    [slide, (scale_by(perp(normal), -1.0), rate)]
                }
            }
        }
    };
    let length = (dot(first.0, first.0) * dot(second.0, second.0)).sqrt();
    Transmission {
        sine: cross(first.0, second.0) / length,
        cosine: dot(first.0, second.0) / length,
        angle_rate: second.1 - first.1,
    }
}
