//! A palm that moves: what everything in its frame feels beyond the world's gravity, and the table, which rests in the world.

use super::model::Multibody;
use super::parts::{DiscPart, Plane};
use super::touch::Touch;
use crate::fivebar::carried::Field;
use crate::numeric::Real;
use crate::numeric::elementary::sin_cos;
use crate::numeric::plane::{add, dot, perp, rotate, scale, sub};
use crate::scene::{PalmMotion, Pose};
use crate::shape::{Placed, Support, support};

/// What is felt, and its derivative by time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Felt {
    pub field: Field,
    pub rate: Field,
}

/// Spec 6.5: gravity turned into the frame, less that of a palm at rest, and the inertial accelerations.
pub fn felt(motion: &PalmMotion, gravity: [f64; 2], t: f64) -> Felt {
    let Pose { place, rate, acceleration, jerk } = motion.pose(t);
    let ([_, _, angle], [_, _, omega]) = (place, rate);
    let (sin, cos) = sin_cos(angle);
    let into = |[x, y]: [f64; 2]| rotate([x, y], [cos, -sin]);
    let [gx, gy] = gravity;
    let all = into([gx - acceleration[0], gy - acceleration[1]]);
    let turned = perp(all);
    let [jx, jy] = into([-jerk[0], -jerk[1]]);
    Felt {
        field: Field {
            uniform: [all[0] - gx, all[1] - gy],
            centrifugal: omega * omega,
            coriolis: omega,
            euler: acceleration[2],
        },
        rate: Field {
            uniform: [jx - omega * turned[0], jy - omega * turned[1]],
            centrifugal: 2.0 * omega * acceleration[2],
            coriolis: acceleration[2],
            euler: jerk[2],
        },
    }
}

/// A disc on a table that rests in the world, on (x, y, t, θ).
///
/// The table's surface is at height h of the world, its normal (0, −1) there; in the palm's frame n = R(−Φ) (0, −1), and the rates of gap
/// and slip beyond those of the disc are −(Ẏ + Ω n⊥·ρ) at the point ρ that touches, and Ẋ − Ω (h − Y).
#[inline(always)]
pub fn table<T: Real>(plane: &Plane, pose: &Pose, since: T, placed: &Placed<T>) -> Touch<T, 4> {
    let Pose { place, rate, acceleration, .. } = *pose;
    // Each with its rate in time.
    let grows = |value: f64, rate: f64| since * rate + value;
    let (sin, cos) = grows(place[2], rate[2]).sin_cos();
    let normal = [-sin, -cos];
    let omega = grows(rate[2], acceleration[2]);
    let height = grows(plane.offset - place[1], -rate[1]);
    let Support { distance, slope } = support(placed, [-normal[0], -normal[1]]);
    let centre = placed.centre_m;
    let along = dot(normal, centre);
    let lever = along + height;
    let tangent = perp(normal);
    let moves = -(grows(rate[1], acceleration[1]) + omega * (dot(tangent, centre) - slope));
    let slides = grows(rate[0], acceleration[0]) - omega * height;
    Touch {
        gap: lever - distance,
        normal_row: [normal[0], normal[1], moves, slope],
        tangent_row: [tangent[0], tangent[1], slides, -lever],
        normal,
        point: sub(add(centre, scale(normal, -lever)), scale(tangent, slope)),
    }
}

impl<const N: usize, const C: usize> Multibody<N, C> {
    #[inline(always)]
    pub(super) fn felt(&self, t: f64) -> Felt {
        match (&self.palm_motion, self.moves()) {
            (Some(motion), true) => felt(motion, self.gravity, t),
            _ => Felt::default(),
        }
    }

    /// The palm's pose at the time that a state is of.
    #[inline(always)]
    pub(super) fn pose(&self, q: &[f64; N]) -> Pose {
        self.palm_motion.as_ref().zip(self.time).map_or_else(Pose::default, |(motion, time)| motion.pose(q[time]))
    }
}

/// Force and moment of a field on a disc, and how they grow with its velocity.
#[inline(always)]
pub fn disc_feels(disc: &DiscPart, field: &Field, [x, y, _]: [f64; 3], [vx, vy, _]: [f64; 3]) -> [f64; 3] {
    let Field { uniform: [ex, ey], centrifugal, coriolis, euler } = *field;
    let (mass, inertia) = (disc.mass, disc.inertia);
    [
        mass * (ex + euler * y + centrifugal * x + 2.0 * coriolis * vy),
        mass * (ey - euler * x + centrifugal * y - 2.0 * coriolis * vx),
        -inertia * euler,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Dual;
    use crate::scene::{Axis, Move};

    fn motion() -> PalmMotion {
        let one = |axis, distance| Move { axis, distance, start_s: 0.0, length_s: 0.1 };
        PalmMotion {
            moves: vec![one(Axis::X, 0.1), one(Axis::Y, -0.03), one(Axis::Angle, 0.7)],
            ..PalmMotion::default()
        }
    }

    /// A point at rest in the world is seen to accelerate from the palm just as what is felt there says.
    #[test]
    fn what_is_felt_keeps_a_free_mass_on_its_parabola() {
        let (motion, gravity, h) = (motion(), [0.5, 9.81], 1e-5);
        for t in [0.02, 0.05, 0.083] {
            let seen = |t: f64| {
                let [x, y, angle] = motion.pose(t).place;
                let fallen = [0.04 + 0.5 * gravity[0] * t * t, 0.02 + 0.3 * t + 0.5 * gravity[1] * t * t];
                rotate([fallen[0] - x, fallen[1] - y], [angle.cos(), -angle.sin()])
            };
            let (before, at, after) = (seen(t - h), seen(t), seen(t + h));
            let v = [0, 1].map(|i| (after[i] - before[i]) / (2.0 * h));
            let found = felt(&motion, gravity, t);
            let Field { uniform: [ex, ey], centrifugal, coriolis, euler } = found.field;
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
            let (late, early) = (felt(&motion, gravity, t + h).field, felt(&motion, gravity, t - h).field);
            let slope = |of: fn(&Field) -> f64| (of(&late) - of(&early)) / (2.0 * h);
            for (rate, of) in [
                (found.rate.uniform[0], (|f| f.uniform[0]) as fn(&Field) -> f64),
                (found.rate.uniform[1], |f| f.uniform[1]),
                (found.rate.centrifugal, |f| f.centrifugal),
                (found.rate.coriolis, |f| f.coriolis),
                (found.rate.euler, |f| f.euler),
            ] {
                assert!((rate - slope(of)).abs() < 1e-5 * (100.0 + rate.abs()), "{rate} {}", slope(of));
            }
        }
    }

    /// Rates of gap and slip are those of the object's and the table's points, and every row has its derivatives.
    #[test]
    fn a_table_at_rest_is_seen_to_move() {
        let (motion, radius, h) = (motion(), 0.02, 1e-6);
        let plane = Plane::at(0.04, -1.0);
        let at = |t: f64, centre: [f64; 2]| table(&plane, &motion.pose(t), 0.0, &Placed::disc(radius, centre));
        for t in [0.03, 0.06] {
            let centre = [0.004, 0.019];
            let found = at(t, centre);
            let slope = |of: &dyn Fn(&Touch<f64, 4>) -> f64| {
                let x = |by: f64| of(&at(t, [centre[0] + by, centre[1]]));
                let y = |by: f64| of(&at(t, [centre[0], centre[1] + by]));
                let time = |by: f64| of(&at(t + by, centre));
                [x(h) - x(-h), y(h) - y(-h), time(h) - time(-h)].map(|difference| difference / (2.0 * h))
            };
            let gap = slope(&|touch| touch.gap);
            assert!((0..3).all(|i| (gap[i] - found.normal_row[i]).abs() < 1e-7), "{gap:?} {:?}", found.normal_row);
            let dual = |value: f64, index: usize| Dual::<3>::variable(value, index);
            let Placed { shape, .. } = Placed::disc(radius, centre);
            let centre_m = [dual(centre[0], 0), dual(centre[1], 1)];
            let placed = Placed { shape, centre_m, angle_rad: Dual::zero() };
            let duals = table(&plane, &motion.pose(t), dual(0.0, 2), &placed);
            for k in 0..4 {
                for (row, by) in [
                    (duals.normal_row[k].grad, slope(&|touch| touch.normal_row[k])),
                    (duals.tangent_row[k].grad, slope(&|touch| touch.tangent_row[k])),
                ] {
                    assert!((0..3).all(|i| (row[i] - by[i]).abs() < 1e-5 * (1.0 + by[i].abs())), "{k}: {row:?} {by:?}");
                }
            }
            // A wheel that rolls on the table does not slip: from the world, then in the frame.
            let Pose { place, rate, .. } = motion.pose(t);
            let (spin, world) = (30.0, |v: [f64; 2]| rotate(v, [place[2].cos(), -place[2].sin()]));
            let [px, py] = rotate(centre, [place[2].cos(), place[2].sin()]);
            let carried = [rate[0] - rate[2] * py, rate[1] + rate[2] * px];
            let lever = found.gap + radius;
            // On a table above, a spin that is counter-clockwise rolls to the right of the world's −x.
            let rolling = world([spin * lever - carried[0], -carried[1]]);
            let rates = [rolling[0], rolling[1], 1.0, spin - rate[2]];
            let along = |row: &[f64; 4]| row.iter().zip(rates).map(|(row, rate)| row * rate).sum::<f64>();
            assert!(along(&found.normal_row).abs() < 1e-12, "{}", along(&found.normal_row));
            assert!(along(&found.tangent_row).abs() < 1e-12, "{}", along(&found.tangent_row));
        }
    }
}
