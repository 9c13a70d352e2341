//! Equations of motion (thesis (2.17)–(2.24)): two open trees, closed by the passive rates.

use super::kinematics::{Directions, PassiveBias, PassiveRates, passive_bias, passive_rates};
use crate::gripper::{Body, Finger, Lengths};
use crate::numeric::plane::{Vector, cross, dot, perp, rotate};
use crate::numeric::{Real, map_array};

/// The constants of one tree l_i1–l_i2 (2.19)–(2.22).
#[derive(Clone, Copy, Debug)]
pub struct Tree {
    /// I_i1 + m_i1 d_i1² + m_i2 l_i1², the constant part of M_ti[1,1] (errata 1: inertias outside the bracket).
    inertia_first: f64,
    /// I_i2 + m_i2 d_i2².
    inertia_second: f64,
    /// m_i2 l_i1 (a_i2, b_i2).
    coupling: [f64; 2],
    /// m_i1 (a_i1, b_i1) + m_i2 (l_i1, 0): mass moment that rotates with the first link.
    moment_first: [f64; 2],
    /// m_i2 (a_i2, b_i2).
    moment_second: [f64; 2],
}

impl Tree {
    pub fn new(length_first_m: f64, first: &Body, second: &Body) -> Self {
        let ([a1, b1], [a2, b2]) = (first.com_m, second.com_m);
        let (m1, m2, l) = (first.mass_kg, second.mass_kg, length_first_m);
        Self {
            inertia_first: first.inertia_kg_m2 + m1 * (a1 * a1 + b1 * b1) + m2 * l * l,
            inertia_second: second.inertia_kg_m2 + m2 * (a2 * a2 + b2 * b2),
            coupling: [m2 * l * a2, m2 * l * b2],
            moment_first: [m1 * a1 + m2 * l, m1 * b1],
            moment_second: [m2 * a2, m2 * b2],
        }
    }
}

/// M_ti in relative coordinates, its Coriolis coefficient and gravity vector (2.19)–(2.22).
#[derive(Clone, Copy, Debug)]
pub struct TreeTerms<T> {
    /// M_ti = [[m11, m12], [m12, m22]]: the first entry.
    pub m11: T,
    /// Second entry of M_ti.
    pub m12: T,
    /// Last entry of M_ti.
    pub m22: f64,
    /// h = m_i2 l_i1 (a_i2 sin q_i2 + b_i2 cos q_i2): B_ti = [−2h, 0], C_ti = [[0, −h], [h, 0]] (errata 2).
    pub h: T,
    /// Q_ti, the gradient of the gravity potential.
    pub gravity: [T; 2],
}

/// Returns the matrices of one tree, from the directions of its two links.
#[inline(always)]
pub(crate) fn tree_terms<T: Real>(tree: &Tree, first: Vector<T>, second: Vector<T>, gravity: [f64; 2]) -> TreeTerms<T> {
    let (cos, sin) = (dot(first, second), cross(first, second));
    let [ca, cb] = tree.coupling;
    let x = cos * ca - sin * cb;
    let h = sin * ca + cos * cb;
    let m12 = x + tree.inertia_second;
    // −g · ∂(Σ m s)/∂q: a vector u that rotates with the link moves along u⊥.
    let gravity_torque = |u: Vector<T>| perp(u)[0] * -gravity[0] - perp(u)[1] * gravity[1];
    let second_gravity_torque = gravity_torque(rotate(second, tree.moment_second));
    TreeTerms {
        m11: x * 2.0 + (tree.inertia_first + tree.inertia_second),
        m12,
        m22: tree.inertia_second,
        h,
        gravity: [gravity_torque(rotate(first, tree.moment_first)) + second_gravity_torque, second_gravity_torque],
    }
}

/// The position-dependent part of the equations of motion of the closed loop.
#[derive(Clone, Copy, Debug)]
pub struct Terms<T> {
    pub pose: Directions<T>,
    pub rates: PassiveRates<T>,
    /// M₁₁, M₁₂ = M₂₁ and M₂₂.
    pub mass: [T; 3],
    /// c = quadratic · (θ̇1², θ̇2², θ̇3², θ̇4²) + gravity. There are no cross terms, because the squares are those of
    /// absolute rates.
    pub quadratic: [[T; 4]; 2],
    pub gravity: [T; 2],
}

impl<T: Copy> Terms<T> {
    /// Converts every number, as [`Directions::map`].
    #[inline(always)]
    pub fn map<U: Copy + Default>(&self, f: impl Fn(T) -> U + Copy) -> Terms<U> {
        Terms {
            pose: self.pose.map(f),
            rates: self.rates.map(f),
            mass: map_array(self.mass, f),
            quadratic: map_array(self.quadratic, |row| map_array(row, f)),
            gravity: map_array(self.gravity, f),
        }
    }
}

/// The constant part of the dynamic model.
#[derive(Clone, Copy, Debug)]
pub struct Dynamics {
    pub lengths: Lengths,
    /// γ of (2.1).
    pub gamma: f64,
    driven: Tree,
    proximal: Tree,
    gravity: [f64; 2],
}

impl Dynamics {
    pub fn new(finger: &Finger, gamma: f64, gravity_m_s2: [f64; 2]) -> Self {
        let (lengths, bodies) = (finger.lengths, &finger.bodies);
        Self {
            lengths,
            gamma,
            driven: Tree::new(lengths.l11_m, &bodies.l11, &bodies.l12),
            proximal: Tree::new(lengths.l21_m, &bodies.l21, &bodies.l22),
            gravity: gravity_m_s2,
        }
    }
}

/// Closes the two trees (2.23): M = [I J_daᵀ] Sᵀ M_t S [I; J_da] and c likewise.
#[inline(always)]
pub fn terms<T: Real>(dynamics: &Dynamics, pose: Directions<T>) -> Terms<T> {
    let rates = passive_rates(&dynamics.lengths, &pose);
    let PassiveBias { b3, b4 } = passive_bias(&dynamics.lengths, &pose, &rates);
    let t1 = tree_terms(&dynamics.driven, pose.e1, pose.e3, dynamics.gravity);
    let t2 = tree_terms(&dynamics.proximal, pose.e2, pose.e4, dynamics.gravity);
    let j12 = [rates.a3[0] - 1.0, rates.a3[1]];
    let j22 = [rates.a4[0], rates.a4[1] - 1.0];

    let mass = [
        t1.m11 + j12[0] * (t1.m12 * 2.0 + j12[0] * t1.m22) + j22[0].squared() * t2.m22,
        j12[1] * (t1.m12 + j12[0] * t1.m22) + j22[0] * (t2.m12 + j22[1] * t2.m22),
        t2.m11 + j22[1] * (t2.m12 * 2.0 + j22[1] * t2.m22) + j12[1].squared() * t1.m22,
    ];

    // c_ti + M_ti (0, θ̈) in squares of absolute rates, since 2 q̇1 q̇2 + q̇2² = (q̇1 + q̇2)² − q̇1².
    let column = |k: usize| -> [T; 2] {
        let (mut c11, mut c12) = (t1.m12 * b3[k], b3[k] * t1.m22);
        let (mut c21, mut c22) = (t2.m12 * b4[k], b4[k] * t2.m22);
        match k {
            0 => {
                c11 += t1.h;
                c12 += t1.h;
            }
            1 => {
                c21 += t2.h;
                c22 += t2.h;
            }
            2 => c11 -= t1.h,
            _ => c21 -= t2.h,
        }
        [c11 + j12[0] * c12 + j22[0] * c22, c21 + j12[1] * c12 + j22[1] * c22]
    };
    let columns = [column(0), column(1), column(2), column(3)];
    Terms {
        pose,
        rates,
        mass,
        quadratic: [columns.map(|c| c[0]), columns.map(|c| c[1])],
        gravity: [
            t1.gravity[0] + j12[0] * t1.gravity[1] + j22[0] * t2.gravity[1],
            t2.gravity[0] + j12[1] * t1.gravity[1] + j22[1] * t2.gravity[1],
        ],
    }
}

/// θ̇3 and θ̇4 at generalised rates v.
#[inline(always)]
pub fn absolute_rates<T: Real>(rates: &PassiveRates<T>, v: [T; 2]) -> [T; 4] {
    [v[0], v[1], dot(rates.a3, v), dot(rates.a4, v)]
}

/// c(q_a, q̇_a) of (2.23): centrifugal, Coriolis and gravity terms.
#[inline(always)]
pub fn bias<T: Real>(terms: &Terms<T>, theta_dot: [T; 4]) -> [T; 2] {
    let w = theta_dot.map(|r| r.squared());
    let row = |k: &[T; 4]| (k[0] * w[0] + k[1] * w[1]) + (k[2] * w[2] + k[3] * w[3]);
    [row(&terms.quadratic[0]) + terms.gravity[0], row(&terms.quadratic[1]) + terms.gravity[1]]
}

/// Direct dynamic model (2.24): q̈_a = M⁻¹ (τ − c), `load` = τ − c.
#[inline(always)]
pub fn solve_mass<T: Real>(mass: &[T; 3], load: [T; 2]) -> [T; 2] {
    let [a, b, d] = *mass;
    let inverse = (a * d - b * b).recip();
    [(d * load[0] - b * load[1]) * inverse, (a * load[1] - b * load[0]) * inverse]
}

/// Inverse dynamic model: the generalised torques M q̈_a + c that give the accelerations `qdd`.
pub fn inverse_dynamics(dynamics: &Dynamics, q: [f64; 2], v: [f64; 2], qdd: [f64; 2]) -> [f64; 2] {
    let terms = terms(dynamics, super::kinematics::directions(&dynamics.lengths, dynamics.gamma, q));
    let c = bias(&terms, absolute_rates(&terms.rates, v));
    let [a, b, d] = terms.mass;
    [a * qdd[0] + b * qdd[1] + c[0], b * qdd[0] + d * qdd[1] + c[1]]
}

/// Kinetic energy ½ q̇ᵀ M q̇, in J.
pub fn kinetic_energy(mass: &[f64; 3], v: [f64; 2]) -> f64 {
    0.5 * (mass[0] * v[0] * v[0] + mass[2] * v[1] * v[1]) + mass[1] * v[0] * v[1]
}

/// Potential energy of gravity, −Σ m g·s, in J; zero at the origin.
pub fn gravity_energy(dynamics: &Dynamics, pose: &Directions<f64>) -> f64 {
    let moment = |tree: &Tree, first, second| {
        let (u, w) = (rotate(first, tree.moment_first), rotate(second, tree.moment_second));
        [u[0] + w[0], u[1] + w[1]]
    };
    let (m1, m2) = (moment(&dynamics.driven, pose.e1, pose.e3), moment(&dynamics.proximal, pose.e2, pose.e4));
    -dot(dynamics.gravity, [m1[0] + m2[0], m1[1] + m2[1]])
}
