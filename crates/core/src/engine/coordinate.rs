//! Scalar coordinates with their rows in the velocities of bodies: the angle of a joint, the position of a slider, the
//! length of a spring or a cable, and sums of coordinates.

use crate::numeric::elementary::{powi, sin_cos};
use crate::numeric::plane::{add, cross, dot, opening_angle, perp, rotate, scale, sub};

/// Velocity (x, y, angle) of a body, or force and torque about its centre of mass.
pub type Twist = [f64; 3];

/// Pose of a body: centre of mass, and orientation both as (cos, sin) and as a continuous angle.
#[derive(Clone, Copy, Debug)]
pub struct BodyPose {
    pub com: [f64; 2],
    pub direction: [f64; 2],
    pub angle: f64,
}

impl BodyPose {
    /// Returns the pose after a body has moved with a velocity.
    pub(crate) fn after(&self, interval_s: f64, velocity: &Twist) -> Self {
        let angle = self.angle + interval_s * velocity[2];
        let (sin, cos) = sin_cos(angle);
        let com = [self.com[0] + interval_s * velocity[0], self.com[1] + interval_s * velocity[1]];
        Self { com, direction: [cos, sin], angle }
    }
}

/// A generalised direction: the impulse on each body per unit impulse along the row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Body on which the row acts, and the components of the row for it.
    pub on: (usize, Twist),
    /// Body that takes the reaction, and the components of the row for it.
    pub against: Option<(usize, Twist)>,
    /// Further bodies of a cable or of a sum of coordinates, with the components of the row for them.
    pub others: Vec<(usize, Twist)>,
}

/// Product of a row and a velocity.
pub(crate) fn power(row: &Twist, v: &Twist) -> f64 {
    row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
}

impl Row {
    /// A row of one body or two.
    pub(crate) fn new(on: (usize, Twist), against: Option<(usize, Twist)>) -> Self {
        Self { on, against, others: Vec::new() }
    }

    /// A row that no motion changes.
    pub(crate) fn none() -> Self {
        Self::new((0, [0.0; 3]), None)
    }

    /// Adds up components of bodies.
    pub(super) fn sum(parts: impl Iterator<Item = (usize, Twist)>) -> Self {
        let mut sides: Vec<(usize, Twist)> = Vec::new();
        for (body, part) in parts {
            match sides.iter_mut().find(|(other, _)| *other == body) {
                Some((_, sum)) => (0..3).for_each(|axis| sum[axis] += part[axis]),
                None => sides.push((body, part)),
            }
        }
        let mut sides = sides.into_iter();
        Self { on: sides.next().unwrap_or_default(), against: sides.next(), others: sides.collect() }
    }

    /// All bodies with their components.
    pub(crate) fn sides(&self) -> impl Iterator<Item = &(usize, Twist)> {
        std::iter::once(&self.on).chain(&self.against).chain(&self.others)
    }

    /// Returns the rate along the row at these velocities.
    pub fn rate(&self, velocities: &[Twist]) -> f64 {
        let along = |(body, row): &(usize, Twist)| power(row, &velocities[*body]);
        let pair = along(&self.on) + self.against.as_ref().map_or(0.0, along);
        self.others.iter().fold(pair, |sum, other| sum + along(other))
    }

    /// Returns the components of a body.
    pub(crate) fn on_body(&self, body: usize) -> Twist {
        self.sides()
            .filter(|(on, _)| *on == body)
            .fold([0.0; 3], |sum, (_, row)| std::array::from_fn(|k| sum[k] + row[k]))
    }

    pub fn rate_of(&self, body: usize, velocity: &Twist) -> f64 {
        power(&self.on_body(body), velocity)
    }

    /// Adds a multiple of the row to a generalised impulse.
    pub fn add_to(&self, impulse: &mut [Twist], size: f64) {
        for (body, row) in self.sides() {
            for axis in 0..3 {
                impulse[*body][axis] += size * row[axis];
            }
        }
    }
}

/// A function of the poses, minus an offset.
#[derive(Clone, Debug)]
pub struct Coordinate {
    pub measure: Measure,
    pub offset: f64,
}

#[derive(Clone, Debug)]
pub enum Measure {
    /// Sum of the angles of up to two bodies times their ratios.
    Angle { on: (usize, f64), against: Option<(usize, f64)> },
    /// Position of the second point relative to the first, along an axis fixed in the first body.
    Slide { points: [BodyPoint; 2], axis: [f64; 2] },
    /// Length of a cable over circles; between two points, their distance.
    Cable { circles: Vec<Circle> },
    /// Sum of coordinates times factors.
    Sum { terms: Vec<(Coordinate, f64)> },
}

/// A circle about a point of a body, which a cable wraps; for an eyelet the radius is 0.
#[derive(Clone, Copy, Debug)]
pub struct Circle {
    pub center: BodyPoint,
    /// Radius, m; positive if the cable passes counter-clockwise, with the centre to its left.
    pub signed_radius_m: f64,
    /// Whether the cable is on it; an eyelet always is.
    pub is_on: bool,
}

impl Circle {
    /// Position of its centre.
    pub(super) fn position(&self, pose: &dyn Fn(usize) -> BodyPose) -> [f64; 2] {
        let of_body = self.center.body.map_or(GROUND, pose);
        add(of_body.com, rotate(self.center.arm_m, of_body.direction))
    }
}

/// The straight part of a cable between two circles, with the arms and velocities of their centres.
pub(super) struct Segment {
    /// Index of the circle at its start.
    from: usize,
    bodies: [Option<usize>; 2],
    arms: [[f64; 2]; 2],
    pub length: f64,
    /// Unit vector along the cable.
    pub along: [f64; 2],
}

/// A point of a body, relative to its centre of mass and in its frame; for the ground, a point of the world.
#[derive(Clone, Copy, Debug)]
pub struct BodyPoint {
    pub body: Option<usize>,
    pub arm_m: [f64; 2],
}

/// Two points and the vector between them in the world, with the pose of the first body.
struct Points {
    base: BodyPose,
    base_arm: [f64; 2],
    arms: [[f64; 2]; 2],
    between: [f64; 2],
}

const GROUND: BodyPose = BodyPose { com: [0.0; 2], direction: [1.0, 0.0], angle: 0.0 };

impl Coordinate {
    /// Returns the coordinate that is the angle of a body.
    pub fn angle_of(on: usize) -> Self {
        Self { measure: Measure::Angle { on: (on, 1.0), against: None }, offset: 0.0 }
    }

    /// Returns the coordinate less `offset`.
    pub(crate) fn less(self, offset: f64) -> Self {
        Self { offset: self.offset + offset, ..self }
    }

    /// Returns the sum of coordinates times factors.
    pub(crate) fn sum(terms: Vec<(Self, f64)>) -> Self {
        Self { measure: Measure::Sum { terms }, offset: 0.0 }
    }

    /// Returns the coordinate times −1; not for lengths.
    pub(crate) fn negated(self) -> Self {
        let negate = |(body, ratio): (usize, f64)| (body, -ratio);
        let measure = match self.measure {
            Measure::Angle { on, against } => Measure::Angle { on: negate(on), against: against.map(negate) },
            Measure::Slide { points, axis } => Measure::Slide { points, axis: scale(axis, -1.0) },
            Measure::Sum { terms } => {
                Measure::Sum { terms: terms.into_iter().map(|(term, factor)| (term, -factor)).collect() }
            }
            cable @ Measure::Cable { .. } => cable,
        };
        Self { measure, offset: -self.offset }
    }

    pub fn value(&self, poses: &[BodyPose]) -> f64 {
        self.value_at(&|body| poses[body])
    }

    fn value_at(&self, pose: &dyn Fn(usize) -> BodyPose) -> f64 {
        let value = match &self.measure {
            Measure::Angle { on, against } => {
                let angle = |(body, ratio): &(usize, f64)| ratio * pose(*body).angle;
                against.as_ref().map_or(angle(on), |against| angle(on) + angle(against))
            }
            Measure::Slide { points, axis } => {
                let at = Points::new(points, pose);
                dot(rotate(*axis, at.base.direction), at.between)
            }
            Measure::Cable { circles } => {
                let straight: f64 = segments(circles, pose).map(|segment| segment.length).sum();
                straight
                    + wraps(circles, pose).map(|(index, wrap)| circles[index].signed_radius_m.abs() * wrap).sum::<f64>()
            }
            Measure::Sum { terms } => terms.iter().map(|(term, factor)| factor * term.value_at(pose)).sum(),
        };
        value - self.offset
    }

    /// Returns the change of the coordinate from poses (x, y, angle) `before` to the poses `after`.
    pub(crate) fn change(&self, before: &[[f64; 3]], after: &[BodyPose]) -> f64 {
        if let Measure::Angle { on, against } = &self.measure {
            let rotation = |(body, ratio): &(usize, f64)| ratio * (after[*body].angle - before[*body][2]);
            return rotation(on) + against.as_ref().map_or(0.0, rotation);
        }
        let pose_before = |body: usize| {
            let [x, y, angle] = before[body];
            let (sin, cos) = sin_cos(angle);
            BodyPose { com: [x, y], direction: [cos, sin], angle }
        };
        self.value(after) - self.value_at(&pose_before)
    }

    /// Returns the row that gives the rate of the coordinate from the velocities of the bodies.
    pub fn row(&self, poses: &[BodyPose]) -> Row {
        match &self.measure {
            Measure::Angle { on, against } => {
                let side = |(body, ratio): &(usize, f64)| (*body, [0.0, 0.0, *ratio]);
                Row::new(side(on), against.as_ref().map(side))
            }
            Measure::Slide { points, axis } => {
                let at = Points::new(points, |body| poses[body]);
                point_row(points, rotate(*axis, at.base.direction), [at.base_arm, at.arms[1]])
            }
            Measure::Cable { circles } => {
                Row::sum(segments(circles, &|body| poses[body]).flat_map(|segment| segment.sides(1.0)))
            }
            Measure::Sum { terms } => Row::sum(terms.iter().flat_map(|(term, factor)| {
                let row = term.row(poses);
                let sides: Vec<_> = row.sides().map(|(body, row)| (*body, row.map(|part| factor * part))).collect();
                sides
            })),
        }
    }

    /// Puts a cable within the coordinate on these circles.
    pub(super) fn set_path(&mut self, on: &[Circle]) {
        match &mut self.measure {
            Measure::Cable { circles } => circles.clone_from_slice(on),
            Measure::Sum { terms } => terms.iter_mut().for_each(|(term, _)| term.set_path(on)),
            Measure::Angle { .. } | Measure::Slide { .. } => {}
        }
    }

    /// Returns the vector between the first two circles of a cable; 0 for another coordinate.
    pub(crate) fn between(&self, poses: &[BodyPose]) -> [f64; 2] {
        match &self.measure {
            Measure::Cable { circles } => {
                Points::new(&[circles[0].center, circles[1].center], |body| poses[body]).between
            }
            _ => [0.0; 2],
        }
    }

    /// Returns the axis of a slide in the world.
    pub(crate) fn axis(&self, poses: &[BodyPose]) -> [f64; 2] {
        let Measure::Slide { points: [first, _], axis } = &self.measure else { return [0.0; 2] };
        rotate(*axis, first.body.map_or(GROUND, |body| poses[body]).direction)
    }

    /// Returns the second time derivative of the coordinate for these velocities and zero accelerations.
    pub fn second_rate(&self, poses: &[BodyPose], velocities: &[Twist]) -> f64 {
        match &self.measure {
            Measure::Angle { .. } => 0.0,
            Measure::Slide { points, axis } => {
                let at = Points::new(points, |body| poses[body]);
                let turning = points[0].body.map_or(0.0, |body| velocities[body][2]);
                let [rate, centripetal] = relative_motion(points.map(|point| point.body), at.arms, velocities);
                let axis = rotate(*axis, at.base.direction);
                dot(axis, centripetal) + 2.0 * turning * dot(perp(axis), rate)
                    - powi(turning, 2) * dot(axis, at.between)
            }
            Measure::Cable { circles } => {
                segments(circles, &|body| poses[body]).map(|segment| segment.second_rate(velocities)).sum()
            }
            Measure::Sum { terms } => {
                terms.iter().map(|(term, factor)| factor * term.second_rate(poses, velocities)).sum()
            }
        }
    }
}

impl Points {
    fn new(points: &[BodyPoint; 2], pose: impl Fn(usize) -> BodyPose) -> Self {
        let [base, other] = [0, 1].map(|k: usize| points[k].body.map_or(GROUND, &pose));
        let arms = [rotate(points[0].arm_m, base.direction), rotate(points[1].arm_m, other.direction)];
        let end = add(other.com, arms[1]);
        Self { base, base_arm: sub(end, base.com), arms, between: sub(end, add(base.com, arms[0])) }
    }
}

/// Row of a unit force along an axis on the second body, at an arm, with its reaction on the first body.
fn point_row(points: &[BodyPoint; 2], axis: [f64; 2], arms: [[f64; 2]; 2]) -> Row {
    let side = |k: usize, axis: [f64; 2]| points[k].body.map(|body| (body, [axis[0], axis[1], cross(arms[k], axis)]));
    let [first, second] = [side(0, scale(axis, -1.0)), side(1, axis)];
    let on = second.or(first).unwrap_or((0, [0.0; 3]));
    Row::new(on, second.and(first))
}

/// Velocity and centripetal acceleration of the second of two points of bodies relative to the first.
fn relative_motion(bodies: [Option<usize>; 2], arms: [[f64; 2]; 2], velocities: &[Twist]) -> [[f64; 2]; 2] {
    let [first, second] = bodies.map(|body| body.map_or([0.0; 3], |body| velocities[body]));
    let velocity = |[x, y, rate]: Twist, arm: [f64; 2]| add([x, y], scale(perp(arm), rate));
    let rate = sub(velocity(second, arms[1]), velocity(first, arms[0]));
    [rate, sub(scale(arms[0], powi(first[2], 2)), scale(arms[1], powi(second[2], 2)))]
}

impl Segment {
    /// Components of the rate of its length, times a factor.
    pub fn sides(&self, factor: f64) -> impl Iterator<Item = (usize, Twist)> + use<> {
        let side = |k: usize, sign: f64| {
            let [x, y] = scale(self.along, sign * factor);
            Some((self.bodies[k]?, [x, y, cross(self.arms[k], [x, y])]))
        };
        [side(0, -1.0), side(1, 1.0)].into_iter().flatten()
    }

    /// Second time derivative of the length of the cable by this part, without accelerations. The part turns at the rate
    /// of its ends across it; the arcs that it leaves or joins cancel.
    pub fn second_rate(&self, velocities: &[Twist]) -> f64 {
        let [rate, centripetal] = relative_motion(self.bodies, self.arms, velocities);
        dot(self.along, centripetal) + powi(cross(self.along, rate), 2) / self.length
    }
}

/// The straight parts of a cable between the circles that it is on. Between circles with signed radii r and s, the part is at
/// the distance s − r from the line of the centres.
pub(super) fn segments(circles: &[Circle], pose: &dyn Fn(usize) -> BodyPose) -> impl Iterator<Item = Segment> {
    let mut last: Option<(usize, &Circle)> = None;
    circles.iter().enumerate().filter(|(_, circle)| circle.is_on).filter_map(move |(index, circle)| {
        let (from, before) = last.replace((index, circle))?;
        let pair = [before, circle];
        let Points { arms, between, .. } = Points::new(&[pair[0].center, pair[1].center], pose);
        let offset = pair[1].signed_radius_m - pair[0].signed_radius_m;
        let squared = dot(between, between);
        let length = (squared - offset * offset).sqrt();
        let along = scale(sub(scale(between, length), scale(perp(between), offset)), 1.0 / squared);
        Some(Segment { from, bodies: pair.map(|circle| circle.center.body), arms, length, along })
    })
}

/// The angles by which a cable wraps the circles that it is on, with their indices; negative where it would push.
pub(super) fn wraps(circles: &[Circle], pose: &dyn Fn(usize) -> BodyPose) -> impl Iterator<Item = (usize, f64)> {
    let mut last = None;
    segments(circles, pose).filter_map(move |segment| {
        let (after, index) = (segment.along, segment.from);
        let before = last.replace(after)?;
        let radius = circles[index].signed_radius_m;
        let wrap = if radius > 0.0 { opening_angle(before, after) } else { opening_angle(after, before) };
        (radius != 0.0).then_some((index, wrap))
    })
}
