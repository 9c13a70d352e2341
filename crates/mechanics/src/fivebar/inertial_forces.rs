//! Inertial forces on the links of a five-bar in a moving frame, as generalised forces.
//!
//! The inertial acceleration of a mass element at ρ with velocity w is e − α × ρ + Ω² ρ − 2 Ω × w, and the inertial
//! couple on a body is −J α; e is uniform. Forces are linear in (e, Ω², Ω, α), so that their time derivative is the
//! same sum with the derivatives of these.

#[cfg(test)]
use super::dynamics::absolute_rates;
use super::kinematics::{Directions, PassiveRates};
#[cfg(test)]
use super::kinematics::{directions, passive_rates};
use crate::gripper::{Body, Finger};
use crate::numeric::Real;
use crate::numeric::plane::{Vector, add, cross, dot, perp, rotate, scale_by};

/// Inertial accelerations in a moving frame, or their time derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AccelerationField {
    /// Uniform acceleration e, m/s².
    pub uniform: [f64; 2],
    /// Ω², or its time derivative.
    pub centrifugal: f64,
    /// Ω, or its time derivative.
    pub coriolis: f64,
    /// α, or its time derivative.
    pub euler: f64,
}

impl AccelerationField {
    /// Returns the field in the frame mirrored about the y axis.
    pub fn mirrored(self, mirror: f64) -> Self {
        let AccelerationField { uniform: [x, y], centrifugal, coriolis, euler } = self;
        AccelerationField { uniform: [mirror * x, y], centrifugal, coriolis: mirror * coriolis, euler: mirror * euler }
    }

    /// Whether the frame rotates.
    pub(crate) fn is_rotating(&self) -> bool {
        self.centrifugal != 0.0 || self.coriolis != 0.0 || self.euler != 0.0
    }
}

/// A chain of two links from the ground joint.
#[derive(Clone, Copy, Debug)]
struct Branch {
    length: f64,
    first: Body,
    second: Body,
}

/// The links with their masses, and the position of the ground joint in the frame.
#[derive(Clone, Copy, Debug)]
pub struct InertialForces {
    branches: [Branch; 2],
    ground: [f64; 2],
}

impl InertialForces {
    pub fn new(finger: &Finger, ground_m: [f64; 2]) -> Self {
        let (lengths, bodies) = (&finger.lengths, &finger.bodies);
        let branch = |length, first, second| Branch { length, first, second };
        let driven = branch(lengths.l11_m, bodies.l11, bodies.l12);
        let proximal = branch(lengths.l21_m, bodies.l21, bodies.l22);
        Self { branches: [driven, proximal], ground: ground_m }
    }

    /// Generalised forces on (q11, q21), N·m, at these absolute angular rates of the links.
    #[inline(always)]
    pub fn forces<T: Real>(
        &self,
        pose: &Directions<T>,
        passive: &PassiveRates<T>,
        rates: [T; 4],
        field: &AccelerationField,
    ) -> [T; 2] {
        let [driven, proximal] = &self.branches;
        let [one, three] = self.branch(driven, [pose.e1, pose.e3], [rates[0], rates[2]], field);
        let [two, four] = self.branch(proximal, [pose.e2, pose.e4], [rates[1], rates[3]], field);
        let along = |j: usize| passive.a3[j] * three + passive.a4[j] * four;
        [one + along(0), two + along(1)]
    }

    /// Generalised forces on the absolute angles of both links of a branch.
    #[inline(always)]
    fn branch<T: Real>(
        &self,
        branch: &Branch,
        [first, second]: [Vector<T>; 2],
        [first_rate, second_rate]: [T; 2],
        field: &AccelerationField,
    ) -> [T; 2] {
        let Branch { length, first: Body { mass_kg: m1, com_m: c1, inertia_kg_m2: j1 }, second: outer } = *branch;
        let Body { mass_kg: m2, com_m: c2, inertia_kg_m2: j2 } = outer;
        let (u1, link, u2) = (rotate(first, c1), scale_by(first, length), rotate(second, c2));
        let uniform = |u: Vector<T>| perp(u)[0] * field.uniform[0] + perp(u)[1] * field.uniform[1];
        let inner = uniform(u1) * m1 + uniform(link) * m2;
        let outer = uniform(u2) * m2;
        if !field.is_rotating() {
            return [inner, outer];
        }
        let ground = self.ground.map(T::constant);
        let (rho1, joint) = (add(ground, u1), add(ground, link));
        let rho2 = add(joint, u2);
        // Components along u⊥ of Ω² ρ and of −α × ρ = −α ρ⊥, with ρ⊥·u⊥ = ρ·u.
        let rotational = |rho: Vector<T>, u: Vector<T>| cross(u, rho) * field.centrifugal - dot(rho, u) * field.euler;
        // Coriolis torques act only between the two links of a branch.
        let coriolis_torque = cross(link, u2) * (2.0 * m2 * field.coriolis);
        [
            inner + rotational(rho1, u1) * m1 + rotational(rho2, link) * m2 + second_rate * coriolis_torque
                - j1 * field.euler,
            outer + rotational(rho2, u2) * m2 - first_rate * coriolis_torque - j2 * field.euler,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gripper::{Assembly, Bodies, Lengths};

    /// Compares with the inertial forces of single bodies projected by a numerical Jacobian.
    #[test]
    fn generalised_forces_match_a_numerical_jacobian() {
        let lengths = Lengths {
            l11_m: 0.015,
            l12_m: 0.0223,
            l21_m: 0.0244,
            l22_m: 0.0075,
            t22_m: 0.0128,
            phi22_rad: 2.09,
            half_width_m: 0.0025,
        };
        let body = |mass_kg, a, b, inertia_kg_m2| Body { mass_kg, com_m: [a, b], inertia_kg_m2 };
        let bodies = Bodies {
            l11: body(0.0043, 0.0075, 0.001, 1.5e-7),
            l12: body(0.0059, 0.0112, -0.002, 3.8e-7),
            l21: body(0.0063, 0.0122, 0.0015, 4.7e-7),
            l22: body(0.0082, -0.0007, 0.0055, 5.7e-7),
        };
        let finger = Finger { lengths, bodies, assembly: Assembly::Reference };
        let (ground, gamma, q, v) = ([0.017, 0.0], -1.0, [-0.6, 0.9], [12.0, -7.0]);
        let field = AccelerationField { uniform: [3.0, -8.0], centrifugal: 49.0, coriolis: 7.0, euler: -120.0 };
        // Centres of mass and angles of all bodies.
        let poses = |q: [f64; 2]| -> [[f64; 3]; 4] {
            let pose = directions(&lengths, gamma, q);
            let body_pose = |base: [f64; 2], e: [f64; 2], body: &Body| {
                let [x, y] = rotate(e, body.com_m);
                [base[0] + x, base[1] + y, e[1].atan2(e[0])]
            };
            let on = |e: [f64; 2], length: f64| [ground[0] + length * e[0], ground[1] + length * e[1]];
            [
                body_pose(ground, pose.e1, &bodies.l11),
                body_pose(on(pose.e1, lengths.l11_m), pose.e3, &bodies.l12),
                body_pose(ground, pose.e2, &bodies.l21),
                body_pose(on(pose.e2, lengths.l21_m), pose.e4, &bodies.l22),
            ]
        };
        let h = 1e-6;
        let rows = [0, 1].map(|j| {
            let poses_at = |by: f64| poses(std::array::from_fn(|k| if k == j { q[k] + by } else { q[k] }));
            let (up, down) = (poses_at(h), poses_at(-h));
            [0, 1, 2, 3].map(|i| [0, 1, 2].map(|k| (up[i][k] - down[i][k]) / (2.0 * h)))
        });
        let mut expected = [0.0; 2];
        for (i, body) in [bodies.l11, bodies.l12, bodies.l21, bodies.l22].iter().enumerate() {
            let [x, y, _] = poses(q)[i];
            let [wx, wy, _] = [0, 1, 2].map(|k| rows[0][i][k] * v[0] + rows[1][i][k] * v[1]);
            let AccelerationField { uniform: [ex, ey], centrifugal, coriolis, euler } = field;
            let acceleration = [
                ex + euler * y + centrifugal * x + 2.0 * coriolis * wy,
                ey - euler * x + centrifugal * y - 2.0 * coriolis * wx,
            ];
            for j in 0..2 {
                let row = rows[j][i];
                expected[j] += body.mass_kg * (acceleration[0] * row[0] + acceleration[1] * row[1])
                    - body.inertia_kg_m2 * euler * row[2];
            }
        }
        let pose = directions(&lengths, gamma, q);
        let passive = passive_rates(&lengths, &pose);
        let found = InertialForces::new(&finger, ground).forces(&pose, &passive, absolute_rates(&passive, v), &field);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1e-3), "{found} {expected}");
        }
        assert!(expected.iter().all(|force| force.abs() > 1e-5), "{expected:?}");
    }
}
