//! Scalar coordinates of up to two bodies, with their rows in the velocities: the angle of a joint, the position of a
//! slider, the length of a spring.

use crate::numeric::elementary::{hypot, powi, sin_cos};
use crate::numeric::plane::{add, cross, dot, perp, rotate, scale, sub};

/// Velocity (x, y, angle) of a body, or a force and a torque about its centre of mass.
pub type Twist = [f64; 3];

/// Pose of a body: centre of mass, orientation as (cos, sin), and as a continuous angle.
#[derive(Clone, Copy, Debug)]
pub struct BodyPose {
    pub com: [f64; 2],
    pub direction: [f64; 2],
    pub angle: f64,
}

/// A generalised direction: the impulse on each body per unit impulse along the row.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Body and its components of the row.
    pub on: (usize, Twist),
    /// Body that takes the reaction, with its components.
    pub against: Option<(usize, Twist)>,
}

/// Product of a row and a velocity.
fn power(row: &Twist, v: &Twist) -> f64 {
    row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
}

impl Row {
    /// Returns the rate along the row.
    pub fn rate(&self, velocities: &[Twist]) -> f64 {
        let along = |(body, row): &(usize, Twist)| power(row, &velocities[*body]);
        along(&self.on) + self.against.as_ref().map_or(0.0, along)
    }

    pub fn rate_of(&self, body: usize, velocity: &Twist) -> f64 {
        let body_row = std::iter::once(&self.on).chain(&self.against).filter(|(on, _)| *on == body);
        body_row.map(|(_, row)| power(row, velocity)).sum()
    }

    /// Adds a multiple of the row to a generalised impulse.
    pub fn add_to(&self, impulse: &mut [Twist], size: f64) {
        for (body, row) in std::iter::once(&self.on).chain(&self.against) {
            for axis in 0..3 {
                impulse[*body][axis] += size * row[axis];
            }
        }
    }
}

/// A measure of the poses less an offset.
#[derive(Clone, Copy, Debug)]
pub struct Coordinate {
    pub measure: Measure,
    pub offset: f64,
}

#[derive(Clone, Copy, Debug)]
pub enum Measure {
    /// Sum of the angles of up to two bodies times their ratios.
    Angle { on: (usize, f64), against: Option<(usize, f64)> },
    /// Position of the second point relative to the first, along an axis fixed in the first body.
    Slide { points: [BodyPoint; 2], axis: [f64; 2] },
    /// Distance between two points.
    Distance { points: [BodyPoint; 2] },
}

/// A point relative to the centre of mass of its body, in the frame of the body; a point of the world for the ground.
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
    /// Angle of a body.
    pub fn angle_of(on: usize) -> Self {
        Self { measure: Measure::Angle { on: (on, 1.0), against: None }, offset: 0.0 }
    }

    /// Ratio of the angle of a body in an angle; 0 for other bodies and measures.
    pub(crate) fn angle_ratio(&self, body: usize) -> f64 {
        let Measure::Angle { on, against } = self.measure else { return 0.0 };
        std::iter::once(on).chain(against).find(|(other, _)| *other == body).map_or(0.0, |(_, ratio)| ratio)
    }

    /// Returns the coordinate less `offset`.
    pub(crate) fn less(self, offset: f64) -> Self {
        Self { offset: self.offset + offset, ..self }
    }

    /// Returns the coordinate times −1; not for distances.
    pub(crate) fn negated(self) -> Self {
        let negate = |(body, ratio): (usize, f64)| (body, -ratio);
        let measure = match self.measure {
            Measure::Angle { on, against } => Measure::Angle { on: negate(on), against: against.map(negate) },
            Measure::Slide { points, axis } => Measure::Slide { points, axis: scale(axis, -1.0) },
            distance @ Measure::Distance { .. } => distance,
        };
        Self { measure, offset: -self.offset }
    }

    pub fn value(&self, poses: &[BodyPose]) -> f64 {
        self.value_at(|body| poses[body])
    }

    fn value_at(&self, pose: impl Fn(usize) -> BodyPose) -> f64 {
        let value = match &self.measure {
            Measure::Angle { on, against } => {
                let angle = |(body, ratio): &(usize, f64)| ratio * pose(*body).angle;
                against.as_ref().map_or(angle(on), |against| angle(on) + angle(against))
            }
            Measure::Slide { points, axis } => {
                let at = Points::new(points, pose);
                dot(rotate(*axis, at.base.direction), at.between)
            }
            Measure::Distance { points } => {
                let [x, y] = Points::new(points, pose).between;
                hypot(x, y)
            }
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
        self.value(after) - self.value_at(pose_before)
    }

    /// Returns the row that gives the rate of the coordinate from the velocities of the bodies.
    pub fn row(&self, poses: &[BodyPose]) -> Row {
        match &self.measure {
            Measure::Angle { on, against } => {
                let side = |(body, ratio): &(usize, f64)| (*body, [0.0, 0.0, *ratio]);
                Row { on: side(on), against: against.as_ref().map(side) }
            }
            Measure::Slide { points, axis } => {
                let at = Points::new(points, |body| poses[body]);
                point_row(points, rotate(*axis, at.base.direction), [at.base_arm, at.arms[1]])
            }
            Measure::Distance { points } => {
                let at = Points::new(points, |body| poses[body]);
                let [x, y] = at.between;
                point_row(points, scale(at.between, 1.0 / hypot(x, y)), at.arms)
            }
        }
    }

    /// Returns the axis of a slide in the world.
    pub(crate) fn axis(&self, poses: &[BodyPose]) -> [f64; 2] {
        let Measure::Slide { points: [first, _], axis } = &self.measure else { return [0.0; 2] };
        rotate(*axis, first.body.map_or(GROUND, |body| poses[body]).direction)
    }

    /// Returns the second time derivative of the coordinate at these velocities without accelerations.
    pub fn second_rate(&self, poses: &[BodyPose], velocities: &[Twist]) -> f64 {
        let (Measure::Slide { points, .. } | Measure::Distance { points }) = &self.measure else { return 0.0 };
        let at = Points::new(points, |body| poses[body]);
        let [first, second] = [0, 1].map(|k: usize| points[k].body.map_or([0.0; 3], |body| velocities[body]));
        let velocity = |[x, y, rate]: Twist, arm: [f64; 2]| add([x, y], scale(perp(arm), rate));
        let rate = sub(velocity(second, at.arms[1]), velocity(first, at.arms[0]));
        let centripetal = sub(scale(at.arms[0], powi(first[2], 2)), scale(at.arms[1], powi(second[2], 2)));
        match &self.measure {
            Measure::Slide { axis, .. } => {
                let axis = rotate(*axis, at.base.direction);
                dot(axis, centripetal) + 2.0 * first[2] * dot(perp(axis), rate)
                    - powi(first[2], 2) * dot(axis, at.between)
            }
            _ => {
                let length = hypot(at.between[0], at.between[1]);
                let axis = scale(at.between, 1.0 / length);
                dot(axis, centripetal) + powi(cross(axis, rate), 2) / length
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
    Row { on, against: second.and(first) }
}
