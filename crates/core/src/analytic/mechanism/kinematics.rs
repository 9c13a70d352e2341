//! Kinematics of a group: poses, Jacobians and bias accelerations of its bodies, placement by placement.
//!
//! Every quantity is a function of the K coordinates of the group, evaluated in plain numbers or in numbers with
//! derivatives by these coordinates. A dyad is solved in two steps: its positions in closed form, then the rates of its
//! outer joints from the closure of its inner joint, which is linear.

use crate::mechanism::structure::{Attachment, Coordinate, Group, Placement, Source};
use crate::mechanism::{Joint, JointKind, Mechanism, Pose};
use crate::numeric::elementary::{atan2, sin_cos};
use crate::numeric::plane::{Vector, add, cross, dot, nearest_equivalent_angle, perp, scale, sub};
use crate::numeric::{Dual, Real, array_from};

/// A number that depends on the K coordinates of a group.
pub(super) trait GroupNumber<const K: usize>: Real {
    /// Whether the number has derivatives.
    const HAS_GRADIENT: bool;

    /// Returns a number with this value and these derivatives by the coordinates.
    fn with_gradient(value: f64, gradient: &[f64; K]) -> Self;
}

impl<const K: usize> GroupNumber<K> for f64 {
    const HAS_GRADIENT: bool = false;

    fn with_gradient(value: f64, _: &[f64; K]) -> Self {
        value
    }
}

impl<const K: usize> GroupNumber<K> for Dual<K> {
    const HAS_GRADIENT: bool = true;

    fn with_gradient(value: f64, gradient: &[f64; K]) -> Self {
        Dual { value, grad: *gradient }
    }
}

/// Pose of the frame of a body, its motion per unit of each coordinate rate, its rate, and its acceleration without
/// accelerations of the coordinates. Components are x, y and θ.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyMotion<T, const K: usize> {
    pub origin: Vector<T>,
    /// (cos θ, sin θ).
    pub direction: Vector<T>,
    pub angle: T,
    pub jacobian: [[T; K]; 3],
    pub rate: [T; 3],
    pub bias: [T; 3],
}

/// Coordinate of a joint, with its derivatives as for a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointMotion<T, const K: usize> {
    pub coordinate: T,
    pub row: [T; K],
    pub rate: T,
    pub bias: T,
}

/// Motion of a point of a body: position, Jacobian, rate and bias acceleration.
pub(super) struct PointMotion<T, const K: usize> {
    pub position: Vector<T>,
    pub jacobian: [[T; K]; 2],
    pub rate: Vector<T>,
    pub bias: Vector<T>,
}

impl<T: Real, const K: usize> BodyMotion<T, K> {
    /// The ground.
    pub fn ground() -> Self {
        let zero = T::zero();
        Self {
            origin: [zero; 2],
            direction: [T::constant(1.0), zero],
            angle: zero,
            jacobian: [[zero; K]; 3],
            rate: [zero; 3],
            bias: [zero; 3],
        }
    }

    fn value(&self) -> BodyMotion<f64, K> {
        BodyMotion {
            origin: pair(|k| self.origin[k].value()),
            direction: pair(|k| self.direction[k].value()),
            angle: self.angle.value(),
            jacobian: triple(|axis| array_from(|k| self.jacobian[axis][k].value())),
            rate: triple(|axis| self.rate[axis].value()),
            bias: triple(|axis| self.bias[axis].value()),
        }
    }

    /// Rotates a vector of the body frame to the world.
    #[inline(always)]
    pub fn rotated(&self, [x, y]: [f64; 2]) -> Vector<T> {
        let [cos, sin] = self.direction;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// Position of a point of the body frame in the world.
    #[inline(always)]
    pub fn position(&self, point: [f64; 2]) -> Vector<T> {
        add(self.origin, self.rotated(point))
    }

    /// Rate of the point at an arm from the origin.
    #[inline(always)]
    fn rate_at(&self, arm: Vector<T>) -> Vector<T> {
        let across = perp(arm);
        pair(|axis| self.rate[axis] + across[axis] * self.rate[2])
    }

    #[inline(always)]
    fn bias_at(&self, arm: Vector<T>) -> Vector<T> {
        let (across, squared) = (perp(arm), self.rate[2].squared());
        pair(|axis| self.bias[axis] + across[axis] * self.bias[2] - arm[axis] * squared)
    }

    /// Motion of a point of the body frame.
    #[inline(always)]
    pub fn point(&self, point: [f64; 2]) -> PointMotion<T, K> {
        let arm = self.rotated(point);
        let across = perp(arm);
        PointMotion {
            position: add(self.origin, arm),
            jacobian: pair(|axis| array_from(|k| self.jacobian[axis][k] + across[axis] * self.jacobian[2][k])),
            rate: self.rate_at(arm),
            bias: self.bias_at(arm),
        }
    }
}

/// Both results of a function of 0 and 1. Unlike `map` of an array, it is always inlined.
#[inline(always)]
pub(super) fn pair<T>(f: impl Fn(usize) -> T) -> [T; 2] {
    [f(0), f(1)]
}

/// Results of a function of 0, 1 and 2.
#[inline(always)]
fn triple<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

impl<T: Real, const K: usize> JointMotion<T, K> {
    /// A joint at rest.
    fn at(coordinate: T) -> Self {
        Self { coordinate, row: [T::zero(); K], rate: T::zero(), bias: T::zero() }
    }
}

/// Poses and motions of all bodies and joints of a mechanism in one state.
#[derive(Clone, Debug)]
pub(super) struct Motions<T, const K: usize> {
    /// Bodies of the mechanism, then the ground.
    bodies: Vec<BodyMotion<T, K>>,
    pub joints: Vec<JointMotion<T, K>>,
}

impl<T: Real, const K: usize> Motions<T, K> {
    pub fn new(mechanism: &Mechanism) -> Self {
        Self {
            bodies: vec![BodyMotion::ground(); mechanism.bodies.len() + 1],
            joints: vec![JointMotion::at(T::zero()); mechanism.joints.len()],
        }
    }

    /// Motions of all bodies.
    pub fn all_bodies(&self) -> &[BodyMotion<T, K>] {
        &self.bodies[..self.bodies.len() - 1]
    }

    /// Motion of a body; `None` is the ground.
    #[inline(always)]
    pub fn body(&self, body: Option<usize>) -> &BodyMotion<T, K> {
        &self.bodies[body.unwrap_or(self.bodies.len() - 1)]
    }
}

/// Assembly mode of a dyad: the sign of its root, and the coordinates of its outer joints and its inner joint at the
/// start. Angles are the equivalents nearest to them, because whole turns do not follow from the coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct AssemblyMode {
    pub sign: f64,
    pub coordinates: [f64; 3],
}

/// A dyad as it is in one pose: outer joints, and the sine and cosine of the transmission angle with its rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transmission {
    pub sine: f64,
    pub cosine: f64,
    pub angle_rate: f64,
}

/// A group with the assembly modes of its dyads, in the order of its placements.
#[derive(Clone, Debug)]
pub(super) struct PlacedGroup {
    pub group: Group,
    pub modes: Vec<Option<AssemblyMode>>,
    /// Index of the first coordinate of the group.
    pub first: usize,
}

impl PlacedGroup {
    /// Builds a group from its assembled poses at the start.
    pub fn new<const K: usize>(mechanism: &Mechanism, group: Group, first: usize, poses: &[Pose]) -> Self {
        let mut motions = Motions::<f64, K>::new(mechanism);
        for (motion, [x, y, angle]) in motions.bodies.iter_mut().zip(poses) {
            let (sin, cos) = sin_cos(*angle);
            (motion.origin, motion.direction, motion.angle) = ([*x, *y], [cos, sin], *angle);
        }
        let mode = |placement: &Placement| {
            let Placement::Dyad { outer, inner } = placement else { return None };
            let joints = [outer[0].joint, outer[1].joint, *inner].map(|joint| &mechanism.joints[joint]);
            let coordinates = joints.map(|joint| joint_coordinate(joint, |body| *motions.body(body)));
            let bases = pair(|k| motions.body(outer[k].base));
            let distance = |sign: f64| {
                let found = solve_dyad(mechanism, (outer, *inner), bases, &AssemblyMode { sign, coordinates });
                let error = |k: usize| {
                    let error = (found[k] - coordinates[k]).abs();
                    if joints[k].kind == JointKind::Revolute {
                        error
                    } else {
                        error / bases_length(bases, &motions, outer)
                    }
                };
                error(0) + error(1)
            };
            let sign = if distance(-1.0) < distance(1.0) { -1.0 } else { 1.0 };
            Some(AssemblyMode { sign, coordinates })
        };
        let modes = group.placements.iter().map(mode).collect();
        Self { group, modes, first }
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.group.coordinates.len()
    }

    /// Evaluates all bodies and joints of the group at the coordinates `q` and rates `v` of the group.
    pub fn evaluate<T: GroupNumber<K>, const K: usize>(
        &self,
        mechanism: &Mechanism,
        (q, v): (&[f64], &[f64]),
        motions: &mut Motions<T, K>,
    ) {
        let coordinate = |index: usize| {
            let mut unit = [0.0; K];
            unit[index] = 1.0;
            JointMotion {
                coordinate: T::with_gradient(q[index], &unit),
                row: array_from(|k| T::constant(unit[k])),
                rate: T::constant(v[index]),
                bias: T::zero(),
            }
        };
        for (placement, mode) in self.group.placements.iter().zip(&self.modes) {
            match placement {
                Placement::Free { body, first } => {
                    let parts = triple(|axis| coordinate(first + axis));
                    motions.bodies[*body] = free_body(&parts);
                }
                Placement::Joint { at, coordinate: source } => {
                    let joint = match source {
                        Source::Coordinate(index) => coordinate(*index),
                        Source::Coupling(index) => coupled_joint(mechanism, *index, at.joint, &motions.joints),
                    };
                    motions.joints[at.joint] = joint;
                    motions.bodies[at.body] = place(&mechanism.joints[at.joint], at, motions.body(at.base), &joint);
                }
                Placement::Dyad { outer, inner } => {
                    let Some(mode) = mode else { continue };
                    let bases = pair(|k| motions.body(outer[k].base));
                    let (bodies, joints) = close_dyad(mechanism, (outer, *inner), bases, mode, v);
                    for (k, at) in outer.iter().enumerate() {
                        motions.bodies[at.body] = bodies[k];
                        motions.joints[at.joint] = joints[k];
                    }
                    let inner_joint = &mut motions.joints[*inner];
                    *inner_joint = inner_motion(&mechanism.joints[*inner], outer, &bodies);
                    if mechanism.joints[*inner].kind == JointKind::Revolute {
                        let angle = inner_joint.coordinate.value();
                        let turns = nearest_equivalent_angle(angle, mode.coordinates[2]) - angle;
                        inner_joint.coordinate = inner_joint.coordinate + turns;
                    }
                }
            }
        }
    }

    /// Transmission of every dyad; a dyad without transmission is singular.
    pub fn transmissions<'a, const K: usize>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (usize, Transmission)> + 'a {
        self.group.placements.iter().enumerate().filter_map(|(index, placement)| match placement {
            Placement::Dyad { outer, inner } => Some((index, transmission(mechanism, (outer, *inner), motions))),
            _ => None,
        })
    }

    /// Angles of the revolute joints of dyads relative to the start: joint, angle, and rate.
    pub fn dyad_angles<'a, const K: usize>(
        &'a self,
        mechanism: &'a Mechanism,
        motions: &'a Motions<f64, K>,
    ) -> impl Iterator<Item = (usize, f64, f64)> + 'a {
        let dyads = self.group.placements.iter().zip(&self.modes).filter_map(|(placement, mode)| match placement {
            Placement::Dyad { outer, inner } => Some(([outer[0].joint, outer[1].joint, *inner], (*mode)?.coordinates)),
            _ => None,
        });
        let joints = dyads.flat_map(|(joints, starts)| joints.into_iter().zip(starts));
        joints.filter(|(joint, _)| mechanism.joints[*joint].kind == JointKind::Revolute).map(|(joint, start)| {
            let motion = &motions.joints[joint];
            (joint, motion.coordinate - start, motion.rate)
        })
    }

    /// Coordinates and rates of the group in assembled poses.
    pub fn start(&self, mechanism: &Mechanism, (poses, rates): (&[Pose], &[Pose])) -> Vec<(f64, f64)> {
        let motion = |body: Option<usize>| {
            let mut motion = BodyMotion::<f64, 1>::ground();
            if let Some(body) = body {
                let ([x, y, angle], rate) = (poses[body], rates[body]);
                let (sin, cos) = sin_cos(angle);
                (motion.origin, motion.direction, motion.angle, motion.rate) = ([x, y], [cos, sin], angle, rate);
            }
            motion
        };
        let start = |coordinate: &Coordinate| match coordinate {
            Coordinate::Joint(joint) => {
                let joint = &mechanism.joints[*joint];
                (joint_coordinate(joint, motion), joint_rate(joint, motion))
            }
            Coordinate::Body(body, axis) => (poses[*body][*axis], rates[*body][*axis]),
        };
        self.group.coordinates.iter().map(start).collect()
    }
}

fn bases_length<const K: usize>(
    bases: [&BodyMotion<f64, K>; 2],
    motions: &Motions<f64, K>,
    outer: &[Attachment; 2],
) -> f64 {
    let offset = |k: usize| sub(motions.bodies[outer[k].body].origin, bases[k].origin);
    let squared = |k: usize| dot(offset(k), offset(k));
    (squared(0) + squared(1)).sqrt().max(f64::MIN_POSITIVE)
}

/// A body whose pose is three coordinates.
fn free_body<T: Real, const K: usize>(parts: &[JointMotion<T, K>; 3]) -> BodyMotion<T, K> {
    let angle = parts[2].coordinate;
    let (sin, cos) = angle.sin_cos();
    BodyMotion {
        origin: [parts[0].coordinate, parts[1].coordinate],
        direction: [cos, sin],
        angle,
        jacobian: [parts[0].row, parts[1].row, parts[2].row],
        rate: [parts[0].rate, parts[1].rate, parts[2].rate],
        bias: [T::zero(); 3],
    }
}

/// A joint whose coordinate follows from a coupling: q = (value − Σ cᵢ qᵢ)/c.
fn coupled_joint<T: Real, const K: usize>(
    mechanism: &Mechanism,
    coupling: usize,
    joint: usize,
    joints: &[JointMotion<T, K>],
) -> JointMotion<T, K> {
    let coupling = &mechanism.couplings[coupling];
    let own: f64 = coupling.terms.iter().filter(|(term, _)| *term == joint).map(|(_, factor)| factor).sum();
    let mut found = JointMotion::at(T::constant(coupling.value / own));
    for (term, factor) in coupling.terms.iter().filter(|(term, _)| *term != joint) {
        let (ratio, other) = (-factor / own, &joints[*term]);
        found.coordinate += other.coordinate * ratio;
        found.rate += other.rate * ratio;
        found.bias += other.bias * ratio;
        (0..K).for_each(|k| found.row[k] += other.row[k] * ratio);
    }
    found
}

/// Unit vector along the axis of a prismatic joint, from a body of the joint.
#[inline(always)]
fn axis<T: Real, const K: usize>(axis_rad: f64, first: &BodyMotion<T, K>) -> Vector<T> {
    let (sin, cos) = sin_cos(axis_rad);
    first.rotated([cos, sin])
}

/// Places a body at a joint with a known coordinate.
#[inline(always)]
fn place<T: Real, const K: usize>(
    joint: &Joint,
    at: &Attachment,
    base: &BodyMotion<T, K>,
    motion: &JointMotion<T, K>,
) -> BodyMotion<T, K> {
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    let (base_point, own_point) = (joint.points_m[1 - own], joint.points_m[own]);
    let base_arm = base.rotated(base_point);
    let mut body = BodyMotion::ground();
    match joint.kind {
        JointKind::Revolute => {
            body.angle = base.angle + (motion.coordinate + joint.offset_rad) * sign;
            let (sin, cos) = body.angle.sin_cos();
            body.direction = [cos, sin];
            let arm = body.rotated(own_point);
            let (base_across, across) = (perp(base_arm), perp(arm));
            body.origin = sub(add(base.origin, base_arm), arm);
            body.rate[2] = base.rate[2] + motion.rate * sign;
            body.bias[2] = base.bias[2] + motion.bias * sign;
            for k in 0..K {
                body.jacobian[2][k] = base.jacobian[2][k] + motion.row[k] * sign;
            }
            let (base_squared, squared) = (base.rate[2].squared(), body.rate[2].squared());
            for axis in 0..2 {
                body.rate[axis] = base.rate[axis] + base_across[axis] * base.rate[2] - across[axis] * body.rate[2];
                body.bias[axis] = base.bias[axis] + base_across[axis] * base.bias[2]
                    - base_arm[axis] * base_squared
                    - across[axis] * body.bias[2]
                    + arm[axis] * squared;
                for k in 0..K {
                    body.jacobian[axis][k] = base.jacobian[axis][k] + base_across[axis] * base.jacobian[2][k]
                        - across[axis] * body.jacobian[2][k];
                }
            }
        }
        JointKind::Prismatic { axis_rad } => {
            body.angle = base.angle + joint.offset_rad * sign;
            let (sin, cos) = body.angle.sin_cos();
            body.direction = [cos, sin];
            let u = scale_const(axis(axis_rad, if at.is_second { base } else { &body }), sign);
            let arm = sub(add(base_arm, scale(u, motion.coordinate)), body.rotated(own_point));
            let (across, u_across) = (perp(arm), perp(u));
            body.origin = add(base.origin, arm);
            (body.rate[2], body.bias[2], body.jacobian[2]) = (base.rate[2], base.bias[2], base.jacobian[2]);
            let (squared, coriolis) = (base.rate[2].squared(), base.rate[2] * motion.rate * 2.0);
            for axis in 0..2 {
                body.rate[axis] = base.rate[axis] + across[axis] * base.rate[2] + u[axis] * motion.rate;
                body.bias[axis] = base.bias[axis] + across[axis] * base.bias[2] - arm[axis] * squared
                    + u[axis] * motion.bias
                    + u_across[axis] * coriolis;
                for k in 0..K {
                    body.jacobian[axis][k] =
                        base.jacobian[axis][k] + across[axis] * base.jacobian[2][k] + u[axis] * motion.row[k];
                }
            }
        }
    }
    body
}

#[inline(always)]
fn scale_const<T: Real>(a: Vector<T>, s: f64) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

/// Motion of a placed body per unit rate of the joint that attaches it.
#[inline(always)]
fn column<T: Real, const K: usize>(joint: &Joint, at: &Attachment, bodies: [&BodyMotion<T, K>; 2]) -> [T; 3] {
    let [base, body] = bodies;
    let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
    match joint.kind {
        JointKind::Revolute => {
            let [x, y] = scale_const(perp(body.rotated(joint.points_m[own])), -sign);
            [x, y, T::constant(sign)]
        }
        JointKind::Prismatic { axis_rad } => {
            let [x, y] = scale_const(axis(axis_rad, if at.is_second { base } else { body }), sign);
            [x, y, T::zero()]
        }
    }
}

/// The closure of the inner joint of a dyad: two linear functions of the motions of its bodies.
struct Closure<T> {
    /// Derivatives of both functions by x, y and θ of each body.
    by_motion: [[[T; 3]; 2]; 2],
    /// Terms of the accelerations that are quadratic in the rates.
    quadratic: [T; 2],
}

impl<T: Real> Closure<T> {
    /// The closure of a joint whose bodies A and B are the bodies `of` of the dyad.
    #[inline(always)]
    fn new<const K: usize>(joint: &Joint, of: [usize; 2], bodies: &[BodyMotion<T, K>; 2]) -> Self {
        let (zero, one) = (T::zero(), T::constant(1.0));
        let [first, second] = [&bodies[of[0]], &bodies[of[1]]];
        let arms = [first.rotated(joint.points_m[0]), second.rotated(joint.points_m[1])];
        let [across_a, across_b] = [perp(arms[0]), perp(arms[1])];
        let squared = [first.rate[2].squared(), second.rate[2].squared()];
        let mut by_motion = [[[zero; 3]; 2]; 2];
        let quadratic;
        match joint.kind {
            JointKind::Revolute => {
                // P_A − P_B = 0.
                by_motion[0][of[0]] = [one, zero, across_a[0]];
                by_motion[1][of[0]] = [zero, one, across_a[1]];
                by_motion[0][of[1]] = [-one, zero, -across_b[0]];
                by_motion[1][of[1]] = [zero, -one, -across_b[1]];
                quadratic = pair(|axis| arms[1][axis] * squared[1] - arms[0][axis] * squared[0]);
            }
            JointKind::Prismatic { axis_rad } => {
                // n·(P_B − P_A) = 0 and θ_B − θ_A = offset.
                let u = axis(axis_rad, first);
                let n = perp(u);
                let offset = sub(add(second.origin, arms[1]), add(first.origin, arms[0]));
                let speed = sub(second.rate_at(arms[1]), first.rate_at(arms[0]));
                by_motion[0][of[0]] = [-n[0], -n[1], -dot(n, across_a) - dot(u, offset)];
                by_motion[0][of[1]] = [n[0], n[1], dot(n, across_b)];
                by_motion[1][of[0]] = [zero, zero, -one];
                by_motion[1][of[1]] = [zero, zero, one];
                let centripetal = dot(n, arms[0]) * squared[0] - dot(n, arms[1]) * squared[1];
                let turning = first.rate[2] * dot(u, speed) * 2.0 + squared[0] * dot(n, offset);
                quadratic = [centripetal - turning, zero];
            }
        }
        Self { by_motion, quadratic }
    }

    #[inline(always)]
    fn applied(&self, equation: usize, body: usize, motion: [T; 3]) -> T {
        let [x, y, angle] = self.by_motion[equation][body];
        x * motion[0] + y * motion[1] + angle * motion[2]
    }
}

/// Places the two bodies of a dyad; returns them with the motions of the outer joints.
#[inline(always)]
fn close_dyad<T: GroupNumber<K>, const K: usize>(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    bases: [&BodyMotion<T, K>; 2],
    mode: &AssemblyMode,
    v: &[f64],
) -> ([BodyMotion<T, K>; 2], [JointMotion<T, K>; 2]) {
    let joints = pair(|k| &mechanism.joints[outer[k].joint]);
    let inner = (&mechanism.joints[inner], inner_bodies(&mechanism.joints[inner], outer));
    let values = pair(|k| bases[k].value());
    let coordinates = solve_dyad_joints(joints, inner, outer, [&values[0], &values[1]], mode);
    // The derivatives of the outer coordinates are the rows of their rates in plain numbers.
    let rows = match T::HAS_GRADIENT {
        true => outer_rows(joints, inner, outer, [&values[0], &values[1]], &pair(|k| JointMotion::at(coordinates[k]))),
        false => [[0.0; K]; 2],
    };
    let lifted = pair(|k| JointMotion::at(T::with_gradient(coordinates[k], &rows[k])));
    let mut motions = lifted;
    let rows = outer_rows(joints, inner, outer, bases, &lifted);
    for k in 0..2 {
        motions[k].row = rows[k];
        motions[k].rate = v.iter().enumerate().fold(T::zero(), |sum, (i, rate)| sum + rows[k][i] * *rate);
    }
    let placed = |motions: &[JointMotion<T, K>; 2]| pair(|k| place(joints[k], &outer[k], bases[k], &motions[k]));
    let mut bodies = placed(&motions);
    let closure = Closure::new(inner.0, inner.1, &bodies);
    let columns = pair(|k| column(joints[k], &outer[k], [bases[k], &bodies[k]]));
    let residual = pair(|equation| {
        closure.applied(equation, 0, bodies[0].bias)
            + closure.applied(equation, 1, bodies[1].bias)
            + closure.quadratic[equation]
    });
    let inverse = inverse_closure(&closure, &columns);
    for k in 0..2 {
        let bias = -(inverse[k][0] * residual[0] + inverse[k][1] * residual[1]);
        motions[k].bias = bias;
        (0..3).for_each(|axis| bodies[k].bias[axis] += columns[k][axis] * bias);
    }
    (bodies, motions)
}

/// Rows of the rates of both outer joints, from the closure with the outer joints at rest.
#[inline(always)]
fn outer_rows<T: Real, const K: usize>(
    joints: [&Joint; 2],
    (inner, of): (&Joint, [usize; 2]),
    outer: &[Attachment; 2],
    bases: [&BodyMotion<T, K>; 2],
    coordinates: &[JointMotion<T, K>; 2],
) -> [[T; K]; 2] {
    let bodies = pair(|k| place(joints[k], &outer[k], bases[k], &coordinates[k]));
    let closure = Closure::new(inner, of, &bodies);
    let columns = pair(|k| column(joints[k], &outer[k], [bases[k], &bodies[k]]));
    let inverse = inverse_closure(&closure, &columns);
    let mut rows = [[T::zero(); K]; 2];
    for i in 0..K {
        let motion = |k: usize| triple(|axis| bodies[k].jacobian[axis][i]);
        let residual =
            pair(|equation| closure.applied(equation, 0, motion(0)) + closure.applied(equation, 1, motion(1)));
        for (k, row) in rows.iter_mut().enumerate() {
            row[i] = -(inverse[k][0] * residual[0] + inverse[k][1] * residual[1]);
        }
    }
    rows
}

/// Inverse of the 2 × 2 matrix of the closure by the rates of the outer joints.
#[inline(always)]
fn inverse_closure<T: Real>(closure: &Closure<T>, columns: &[[T; 3]; 2]) -> [[T; 2]; 2] {
    let matrix = pair(|equation| pair(|k| closure.applied(equation, k, columns[k])));
    let inverse_det = (matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0]).recip();
    [
        [matrix[1][1] * inverse_det, -(matrix[0][1] * inverse_det)],
        [-(matrix[1][0] * inverse_det), matrix[0][0] * inverse_det],
    ]
}

/// Indices in the dyad of the bodies A and B of its inner joint.
#[inline(always)]
fn inner_bodies(inner: &Joint, outer: &[Attachment; 2]) -> [usize; 2] {
    if inner.bodies[0] == Some(outer[0].body) { [0, 1] } else { [1, 0] }
}

/// Motion of the inner joint of a dyad with placed bodies.
#[inline(always)]
fn inner_motion<T: Real, const K: usize>(
    inner: &Joint,
    outer: &[Attachment; 2],
    bodies: &[BodyMotion<T, K>; 2],
) -> JointMotion<T, K> {
    let of = inner_bodies(inner, outer);
    let [first, second] = [&bodies[of[0]], &bodies[of[1]]];
    match inner.kind {
        JointKind::Revolute => JointMotion {
            coordinate: second.angle - first.angle - inner.offset_rad,
            row: array_from(|k| second.jacobian[2][k] - first.jacobian[2][k]),
            rate: second.rate[2] - first.rate[2],
            bias: second.bias[2] - first.bias[2],
        },
        JointKind::Prismatic { axis_rad } => {
            let u = axis(axis_rad, first);
            let [a, b] = [first.point(inner.points_m[0]), second.point(inner.points_m[1])];
            let coordinate = dot(u, sub(b.position, a.position));
            JointMotion {
                coordinate,
                row: array_from(|k| {
                    pair(|axis| u[axis] * (b.jacobian[axis][k] - a.jacobian[axis][k]))
                        .into_iter()
                        .fold(T::zero(), |sum, part| sum + part)
                }),
                rate: dot(u, sub(b.rate, a.rate)),
                // The bodies turn together: n·ḋ = ω q, with the distance d = q u.
                bias: dot(u, sub(b.bias, a.bias)) + first.rate[2].squared() * coordinate,
            }
        }
    }
}

/// Coordinate of a joint from the poses of its bodies.
fn joint_coordinate<const K: usize>(joint: &Joint, motion: impl Fn(Option<usize>) -> BodyMotion<f64, K>) -> f64 {
    let [first, second] = joint.bodies.map(motion);
    match joint.kind {
        JointKind::Revolute => second.angle - first.angle - joint.offset_rad,
        JointKind::Prismatic { axis_rad } => {
            let offset = sub(second.position(joint.points_m[1]), first.position(joint.points_m[0]));
            dot(axis(axis_rad, &first), offset)
        }
    }
}

/// Rate of a joint from the motions of its bodies.
fn joint_rate<const K: usize>(joint: &Joint, motion: impl Fn(Option<usize>) -> BodyMotion<f64, K>) -> f64 {
    let [first, second] = joint.bodies.map(motion);
    match joint.kind {
        JointKind::Revolute => second.rate[2] - first.rate[2],
        JointKind::Prismatic { axis_rad } => {
            let [a, b] = [first.point(joint.points_m[0]), second.point(joint.points_m[1])];
            dot(axis(axis_rad, &first), sub(b.rate, a.rate))
        }
    }
}

/// Coordinates of the outer joints of a dyad, from the poses of its bases.
fn solve_dyad<const K: usize>(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    bases: [&BodyMotion<f64, K>; 2],
    mode: &AssemblyMode,
) -> [f64; 2] {
    let joints = pair(|k| &mechanism.joints[outer[k].joint]);
    let inner = &mechanism.joints[inner];
    solve_dyad_joints(joints, (inner, inner_bodies(inner, outer)), outer, bases, mode)
}

/// Locus of a point of a body that is attached at a joint.
#[derive(Clone, Copy)]
enum Locus {
    /// A circle about the pivot; `arm` is the arm to the point in the body frame.
    Circle { center: [f64; 2], arm: [f64; 2] },
    /// A line; `angle` is the angle of the body, and `sign` the direction of its coordinate along it.
    Line { point: [f64; 2], direction: [f64; 2], angle: f64 },
}

impl Locus {
    /// Locus of a point (in the frame of the attached body).
    fn new<const K: usize>(joint: &Joint, at: &Attachment, base: &BodyMotion<f64, K>, point: [f64; 2]) -> Self {
        let (sign, own) = if at.is_second { (1.0, 1) } else { (-1.0, 0) };
        let pivot = base.position(joint.points_m[1 - own]);
        let arm = sub(point, joint.points_m[own]);
        match joint.kind {
            JointKind::Revolute => Locus::Circle { center: pivot, arm },
            JointKind::Prismatic { axis_rad } => {
                let angle = base.angle + sign * joint.offset_rad;
                let (sin, cos) = sin_cos(angle);
                let body = BodyMotion::<f64, 1> { direction: [cos, sin], angle, ..BodyMotion::ground() };
                let first = if at.is_second { base.direction } else { body.direction };
                let first = BodyMotion::<f64, 1> { direction: first, ..BodyMotion::ground() };
                let direction = scale_const(axis(axis_rad, &first), sign);
                Locus::Line { point: add(pivot, body.rotated(arm)), direction, angle }
            }
        }
    }

    /// Coordinate of the joint for a position of the point.
    fn coordinate<const K: usize>(
        &self,
        joint: &Joint,
        at: &Attachment,
        base: &BodyMotion<f64, K>,
        position: [f64; 2],
    ) -> f64 {
        let sign = if at.is_second { 1.0 } else { -1.0 };
        match self {
            Locus::Circle { center, arm } => {
                let offset = sub(position, *center);
                let angle = atan2(offset[1], offset[0]) - atan2(arm[1], arm[0]);
                sign * (angle - base.angle) - joint.offset_rad
            }
            Locus::Line { point, direction, .. } => dot(sub(position, *point), *direction),
        }
    }
}

/// Coordinates of the outer joints of a dyad: the intersection of the loci of its inner joint. Not a number if there is
/// none.
fn solve_dyad_joints<const K: usize>(
    joints: [&Joint; 2],
    (inner, of): (&Joint, [usize; 2]),
    outer: &[Attachment; 2],
    bases: [&BodyMotion<f64, K>; 2],
    mode: &AssemblyMode,
) -> [f64; 2] {
    // Points of the inner joint, in the order of the bodies of the dyad.
    let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
    let loci = pair(|k| Locus::new(joints[k], &outer[k], bases[k], points[k]));
    let raw = match inner.kind {
        JointKind::Revolute => {
            let position = intersection(&loci, mode.sign);
            pair(|k| loci[k].coordinate(joints[k], &outer[k], bases[k], position))
        }
        JointKind::Prismatic { axis_rad } => slide(joints, (inner, of, axis_rad), outer, bases, (&loci, mode.sign)),
    };
    pair(|k| match joints[k].kind {
        JointKind::Revolute => nearest_equivalent_angle(raw[k], mode.coordinates[k]),
        JointKind::Prismatic { .. } => raw[k],
    })
}

/// Intersection of two circles, a circle and a line, or two lines.
fn intersection(loci: &[Locus; 2], sign: f64) -> [f64; 2] {
    match *loci {
        [Locus::Circle { center, arm }, Locus::Circle { center: other, arm: other_arm }] => {
            let offset = sub(other, center);
            let squared = dot(offset, offset);
            let along = (dot(arm, arm) - dot(other_arm, other_arm) + squared) / (2.0 * squared);
            let across = (dot(arm, arm) / squared - along * along).sqrt();
            add(center, add(scale_const(offset, along), scale_const(perp(offset), sign * across)))
        }
        [Locus::Circle { center, arm }, Locus::Line { point, direction, .. }]
        | [Locus::Line { point, direction, .. }, Locus::Circle { center, arm }] => {
            let offset = sub(center, point);
            let (along, distance) = (dot(offset, direction), cross(direction, offset));
            let half = (dot(arm, arm) - distance * distance).sqrt();
            add(point, scale_const(direction, along + sign * half))
        }
        [Locus::Line { point, direction, .. }, Locus::Line { point: other, direction: other_direction, .. }] => {
            let along = cross(sub(other, point), other_direction) / cross(direction, other_direction);
            add(point, scale_const(direction, along))
        }
    }
}

/// Coordinates of the outer joints of a dyad whose inner joint slides.
fn slide<const K: usize>(
    joints: [&Joint; 2],
    (inner, of, axis_rad): (&Joint, [usize; 2], f64),
    outer: &[Attachment; 2],
    bases: [&BodyMotion<f64, K>; 2],
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
            let normal = add(scale_const(offset, -height), scale_const(perp(offset), sign * across));
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
        Locus::Circle { .. } => {
            let turn = if outer[k].is_second { 1.0 } else { -1.0 };
            turn * (angles[k] - bases[k].angle) - joints[k].offset_rad
        }
        Locus::Line { direction, .. } => {
            let side = if k == b { -1.0 } else { 1.0 };
            side * gap / dot(normal, direction)
        }
    })
}

/// Transmission angle of a dyad: between the directions whose alignment makes it singular.
fn transmission<const K: usize>(
    mechanism: &Mechanism,
    (outer, inner): (&[Attachment; 2], usize),
    motions: &Motions<f64, K>,
) -> Transmission {
    let inner = &mechanism.joints[inner];
    let of = inner_bodies(inner, outer);
    let points = if of[0] == 0 { inner.points_m } else { [inner.points_m[1], inner.points_m[0]] };
    // Direction of the arm or line of each outer joint, with its angular rate.
    let direction = |k: usize| {
        let (joint, at) = (&mechanism.joints[outer[k].joint], &outer[k]);
        let (base, body) = (motions.body(at.base), &motions.bodies[at.body]);
        match joint.kind {
            JointKind::Revolute => {
                let own = usize::from(at.is_second);
                (body.rotated(sub(points[k], joint.points_m[own])), body.rate[2])
            }
            // The normal of a line takes the place of an arm.
            JointKind::Prismatic { axis_rad } => {
                (perp(axis(axis_rad, if at.is_second { base } else { body })), body.rate[2])
            }
        }
    };
    let [first, second] = match inner.kind {
        JointKind::Revolute => [direction(0), direction(1)],
        JointKind::Prismatic { axis_rad } => {
            let a = &motions.bodies[outer[of[0]].body];
            let slide = (axis(axis_rad, a), a.rate[2]);
            let is_circle = pair(|k| mechanism.joints[outer[k].joint].kind == JointKind::Revolute);
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
                    [slide, (scale_const(perp(normal), -1.0), rate)]
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
