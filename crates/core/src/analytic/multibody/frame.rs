//! A moving palm: inertial forces in its frame, and the table, which is at rest in the world.

use super::FINGERS;
use super::components::{ObjectComponent, Plane};
use super::model::Multibody;
use crate::analytic::contact::ContactKinematics;
use crate::analytic::inertial_field::{InertialField, inertial_field};
use crate::fivebar::dynamics::AccelerationField;
use crate::numeric::plane::{add, dot, perp, scale, sub};
use crate::numeric::{Real, array_from};
use crate::scene::Pose;
use crate::shape::{PlacedShape, Support, support};

/// Contact of the object with a table at rest in the world, on (x, y, t, θ).
///
/// In the world, the table's surface is at height h with normal (0, −1). In the palm's frame, n = R(−Φ) (0, −1). The
/// table's own motion adds −(Ẏ + Ω n⊥·ρ) at the contact point ρ to the gap rate, and Ẋ − Ω (h − Y) to the slip.
/// `time_offset` is 0 as a number, or the differentiation variable of time.
#[inline(always)]
pub fn table<T: Real>(plane: &Plane, pose: &Pose, time_offset: T, placed: &PlacedShape<T>) -> ContactKinematics<T, 4> {
    let Pose { position, rate, acceleration, .. } = *pose;
    let linear_in_time = |value: f64, rate: f64| time_offset * rate + value;
    let (sin, cos) = linear_in_time(position[2], rate[2]).sin_cos();
    let normal = [-sin, -cos];
    let omega = linear_in_time(rate[2], acceleration[2]);
    let height = linear_in_time(plane.offset - position[1], -rate[1]);
    let Support { distance, slope } = support(placed, [-normal[0], -normal[1]]);
    let centre = placed.centre_m;
    let centre_along_normal = dot(normal, centre);
    let lever = centre_along_normal + height;
    let tangent = perp(normal);
    let table_normal_rate = -(linear_in_time(rate[1], acceleration[1]) + omega * (dot(tangent, centre) - slope));
    let table_slip = linear_in_time(rate[0], acceleration[0]) - omega * height;
    ContactKinematics {
        gap: lever - distance,
        normal_row: [normal[0], normal[1], table_normal_rate, slope],
        tangent_row: [tangent[0], tangent[1], table_slip, -lever],
        normal,
        point: sub(add(centre, scale(normal, -lever)), scale(tangent, slope)),
    }
}

impl<const N: usize> Multibody<N> {
    /// Inertial field at time `t`; zero in a frame at rest.
    #[inline(always)]
    pub(super) fn inertial_field(&self, t: f64) -> InertialField {
        match (&self.palm_motion, self.palm_moves()) {
            (Some(motion), true) => inertial_field(motion, self.gravity, t),
            _ => InertialField::default(),
        }
    }

    /// Pose of the palm at the time contained in the coordinates.
    #[inline(always)]
    pub(super) fn pose(&self, q: &[f64; N]) -> Pose {
        self.palm_motion.as_ref().zip(self.time_index).map_or_else(Pose::default, |(motion, time)| motion.pose(q[time]))
    }
}

/// Inertial force and moment of a field on the object.
#[inline(always)]
pub(crate) fn inertial_force(
    object: &ObjectComponent,
    field: &AccelerationField,
    pose: [f64; 3],
    v: [f64; 3],
) -> [f64; 3] {
    let ([x, y, _], [vx, vy, _]) = (pose, v);
    let AccelerationField { uniform: [ex, ey], centrifugal, coriolis, euler } = *field;
    let (mass, inertia) = (object.mass, object.inertia);
    [
        mass * (ex + euler * y + centrifugal * x + 2.0 * coriolis * vy),
        mass * (ey - euler * x + centrifugal * y - 2.0 * coriolis * vx),
        -inertia * euler,
    ]
}

/// The mass matrix: a block for each finger and a diagonal block for the object. A differential adds one entry that
/// couples both driven links. `fingers` is (M₁₁, M₁₂, M₂₂) of each finger, including the inertia that rotates with its
/// driven link. The mass of the object is in the model.
#[derive(Clone, Copy, Debug)]
pub struct Inertia<'a, const N: usize> {
    model: &'a Multibody<N>,
    fingers: [[f64; 3]; FINGERS],
}

/// The inverse of the mass matrix.
#[derive(Clone, Copy, Debug)]
pub struct Inverse<'a, const N: usize> {
    model: &'a Multibody<N>,
    fingers: [[f64; 3]; FINGERS],
    /// 1 − c² (A⁻¹)₁₁ (B⁻¹)₁₁, with the coupling M₁₂ = c between the driven links.
    remainder: f64,
}

impl<'a, const N: usize> Inertia<'a, N> {
    /// Takes the fingers' own mass matrices; entries of missing fingers are ignored.
    #[inline(always)]
    pub fn new(model: &'a Multibody<N>, mut fingers: [[f64; 3]; FINGERS]) -> Self {
        (0..FINGERS).for_each(|finger| fingers[finger][0] += model.rotor_inertia[finger]);
        Self { model, fingers }
    }

    #[inline(always)]
    pub fn inverse(&self) -> Inverse<'a, N> {
        let mut fingers = self.fingers;
        for block in &mut fingers {
            let [a, b, d] = *block;
            let inverse = 1.0 / (a * d - b * b);
            *block = [d * inverse, -b * inverse, a * inverse];
        }
        let coupling = self.model.coupling;
        let remainder = 1.0 - coupling * coupling * fingers[0][0] * fingers[1][0];
        Inverse { model: self.model, fingers, remainder }
    }

    /// Kinetic energy ½ vᵀ M v, J.
    pub fn kinetic(&self, v: &[f64; N]) -> f64 {
        let mut energy = 0.0;
        for ([a, b, d], v) in self.fingers.iter().zip(v.chunks_exact(2)) {
            energy += 0.5 * (a * v[0] * v[0] + d * v[1] * v[1]) + b * v[0] * v[1];
        }
        energy += self.model.coupling * v[0] * v[2];
        if let Some((_, object)) = self.model.moving_object() {
            let [vx, vy, spin] = self.model.object_rates(v);
            energy += 0.5 * (object.mass * (vx * vx + vy * vy) + object.inertia * spin * spin);
        }
        energy
    }
}

impl<const N: usize> Inverse<'_, N> {
    /// Solves M x = `load`.
    #[inline(always)]
    pub fn solve(&self, load: &[f64; N]) -> [f64; N] {
        let mut columns = [[0.0]; N];
        for i in 0..N {
            columns[i] = [load[i]];
        }
        self.solve_columns(&mut columns);
        array_from(|i| columns[i][0])
    }

    /// Replaces a matrix of loads by M⁻¹ of it, row by row, so that the compiler can vectorise over the columns. Bristle
    /// states have no mass: their load is their rate.
    #[inline(always)]
    pub(crate) fn solve_columns<const K: usize>(&self, a: &mut [[f64; K]; N]) {
        for finger in 0..FINGERS {
            let ([m, c, n], [first, second]) = (self.fingers[finger], [2 * finger, 2 * finger + 1]);
            let [f, g] = [a[first], a[second]];
            for j in 0..K {
                (a[first][j], a[second][j]) = (m * f[j] + c * g[j], c * f[j] + n * g[j]);
            }
        }
        if self.model.coupling != 0.0 {
            // The coupling adds −c times the other finger's q̈11 to the load on each q11.
            let (c, [right, left]) = (self.model.coupling, [a[0], a[2]]);
            let coupled_mobility = c * self.fingers[1][0];
            let second: [f64; K] = array_from(|j| (left[j] - coupled_mobility * right[j]) / self.remainder);
            let first: [f64; K] = array_from(|j| right[j] - c * self.fingers[0][0] * second[j]);
            for (finger, other) in [second, first].into_iter().enumerate() {
                let [m, n] = [c * self.fingers[finger][0], c * self.fingers[finger][1]];
                for j in 0..K {
                    a[2 * finger][j] -= m * other[j];
                    a[2 * finger + 1][j] -= n * other[j];
                }
            }
        }
        if let Some((first, object)) = self.model.moving_object() {
            let inverses = [object.inverse_mass, object.inverse_mass, object.inverse_inertia];
            for (i, inverse) in inverses.into_iter().enumerate() {
                a[first + i].iter_mut().for_each(|a| *a *= inverse);
            }
        }
        // Time has a constant rate.
        if let Some(time) = self.model.time_index.filter(|_| self.model.palm_moves()) {
            a[time] = [0.0; K];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;
    use crate::numeric::plane::rotate;
    use crate::scene::PalmMotion;
    use crate::scene::{Axis, Move};

    fn motion() -> PalmMotion {
        let single_move = |axis, distance| Move { axis, distance, start_s: 0.0, length_s: 0.1 };
        PalmMotion {
            moves: vec![single_move(Axis::X, 0.1), single_move(Axis::Y, -0.03), single_move(Axis::Angle, 0.7)],
            ..PalmMotion::default()
        }
    }

    /// The acceleration of a freely falling point, seen from the palm, equals gravity plus the inertial field.
    #[test]
    fn inertial_field_matches_a_falling_point_seen_from_the_palm() {
        let (motion, gravity, h) = (motion(), [0.5, 9.81], 1e-5);
        for t in [0.02, 0.05, 0.083] {
            let position_in_frame = |t: f64| {
                let [x, y, angle] = motion.pose(t).position;
                let falling = [0.04 + 0.5 * gravity[0] * t * t, 0.02 + 0.3 * t + 0.5 * gravity[1] * t * t];
                rotate([falling[0] - x, falling[1] - y], [angle.cos(), -angle.sin()])
            };
            let (before, at, after) = (position_in_frame(t - h), position_in_frame(t), position_in_frame(t + h));
            let v = [0, 1].map(|i| (after[i] - before[i]) / (2.0 * h));
            let found = inertial_field(&motion, gravity, t);
            let AccelerationField { uniform: [ex, ey], centrifugal, coriolis, euler } = found.field;
            let expected = [
                gravity[0] + ex + euler * at[1] + centrifugal * at[0] + 2.0 * coriolis * v[1],
                gravity[1] + ey - euler * at[0] + centrifugal * at[1] - 2.0 * coriolis * v[0],
            ];
            for i in 0..2 {
                let acceleration = (after[i] - 2.0 * at[i] + before[i]) / (h * h);
                assert!(
                    (acceleration - expected[i]).abs() < 1e-4 * expected[i].abs().max(10.0),
                    "{acceleration} {expected:?}"
                );
            }
            let (late, early) =
                (inertial_field(&motion, gravity, t + h).field, inertial_field(&motion, gravity, t - h).field);
            let difference_quotient =
                |component: fn(&AccelerationField) -> f64| (component(&late) - component(&early)) / (2.0 * h);
            for (rate, component) in [
                (found.rate.uniform[0], (|f| f.uniform[0]) as fn(&AccelerationField) -> f64),
                (found.rate.uniform[1], |f| f.uniform[1]),
                (found.rate.centrifugal, |f| f.centrifugal),
                (found.rate.coriolis, |f| f.coriolis),
                (found.rate.euler, |f| f.euler),
            ] {
                assert!(
                    (rate - difference_quotient(component)).abs() < 1e-5 * (100.0 + rate.abs()),
                    "{rate} {}",
                    difference_quotient(component)
                );
            }
        }
    }

    /// The rows give the rates of gap and slip between the points of object and table, and their derivatives are exact.
    #[test]
    fn table_rows_match_differences_and_rolling() {
        let (motion, radius, h) = (motion(), 0.02, 1e-6);
        let plane = Plane::at_level(0.04, -1.0);
        let at = |t: f64, centre: [f64; 2]| table(&plane, &motion.pose(t), 0.0, &PlacedShape::disc(radius, centre));
        for t in [0.03, 0.06] {
            let centre = [0.004, 0.019];
            let found = at(t, centre);
            let difference_quotients = |value: &dyn Fn(&ContactKinematics<f64, 4>) -> f64| {
                let x = |by: f64| value(&at(t, [centre[0] + by, centre[1]]));
                let y = |by: f64| value(&at(t, [centre[0], centre[1] + by]));
                let time = |by: f64| value(&at(t + by, centre));
                [x(h) - x(-h), y(h) - y(-h), time(h) - time(-h)].map(|difference| difference / (2.0 * h))
            };
            let gap = difference_quotients(&|kinematics| kinematics.gap);
            assert!((0..3).all(|i| (gap[i] - found.normal_row[i]).abs() < 1e-7), "{gap:?} {:?}", found.normal_row);
            let dual = |value: f64, index: usize| Dual::<3>::variable(value, index);
            let PlacedShape { shape, .. } = PlacedShape::disc(radius, centre);
            let centre_m = [dual(centre[0], 0), dual(centre[1], 1)];
            let placed = PlacedShape { shape, centre_m, angle_rad: Dual::zero() };
            let duals = table(&plane, &motion.pose(t), dual(0.0, 2), &placed);
            for k in 0..4 {
                for (row, expected) in [
                    (duals.normal_row[k].grad, difference_quotients(&|kinematics| kinematics.normal_row[k])),
                    (duals.tangent_row[k].grad, difference_quotients(&|kinematics| kinematics.tangent_row[k])),
                ] {
                    assert!(
                        (0..3).all(|i| (row[i] - expected[i]).abs() < 1e-5 * (1.0 + expected[i].abs())),
                        "{k}: {row:?} {expected:?}"
                    );
                }
            }
            // A wheel that rolls on the table does not slip. Its rates are computed in the world and transformed to the
            // frame.
            let Pose { position, rate, .. } = motion.pose(t);
            let (spin, rotate_into_frame) = (30.0, |v: [f64; 2]| rotate(v, [position[2].cos(), -position[2].sin()]));
            let [px, py] = rotate(centre, [position[2].cos(), position[2].sin()]);
            let frame_velocity = [rate[0] - rate[2] * py, rate[1] + rate[2] * px];
            let lever = found.gap + radius;
            // The table is above the wheel: a counter-clockwise spin rolls towards the world's −x.
            let rolling = rotate_into_frame([spin * lever - frame_velocity[0], -frame_velocity[1]]);
            let rates = [rolling[0], rolling[1], 1.0, spin - rate[2]];
            let rate_along = |row: &[f64; 4]| row.iter().zip(rates).map(|(row, rate)| row * rate).sum::<f64>();
            assert!(rate_along(&found.normal_row).abs() < 1e-12, "{}", rate_along(&found.normal_row));
            assert!(rate_along(&found.tangent_row).abs() < 1e-12, "{}", rate_along(&found.tangent_row));
        }
    }
}
