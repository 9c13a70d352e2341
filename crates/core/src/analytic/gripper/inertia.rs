//! The mass matrix: a block for each finger, a diagonal one for the object, and with a differential one number that couples both driven links.

use super::model::GripperModel;
use super::{FINGERS, MEMORY};

/// M by its blocks; (M₁₁, M₁₂, M₂₂) of each finger with what turns with its driven link.
#[derive(Clone, Copy, Debug)]
pub struct Inertia {
    fingers: [[f64; 3]; 2],
    coupling: f64,
    object: [f64; 2],
}

/// What solves M a = load.
#[derive(Clone, Copy, Debug)]
pub struct Inverse {
    fingers: [[f64; 3]; 2],
    /// M₁₂ between the driven links, and 1 − c² (A⁻¹)₁₁ (B⁻¹)₁₁.
    coupling: f64,
    remainder: f64,
    object: [f64; 2],
}

impl Inertia {
    #[inline(always)]
    pub fn new<const N: usize>(model: &GripperModel<N>, mut fingers: [[f64; 3]; 2]) -> Self {
        (0..2).for_each(|side| fingers[side][0] += model.rotor_inertia[side]);
        Self { fingers, coupling: model.coupling, object: [model.object.mass, model.object.inertia] }
    }

    #[inline(always)]
    pub fn inverse(&self) -> Inverse {
        let fingers = self.fingers.map(|[a, b, d]| {
            let inverse = 1.0 / (a * d - b * b);
            [d * inverse, -b * inverse, a * inverse]
        });
        let remainder = 1.0 - self.coupling * self.coupling * fingers[0][0] * fingers[1][0];
        Inverse { fingers, coupling: self.coupling, remainder, object: self.object.map(inverse_or_none) }
    }

    /// ½ vᵀ M v, J.
    pub fn kinetic<const N: usize>(&self, v: &[f64; N]) -> f64 {
        let finger = |side: usize| {
            let ([a, b, d], [v1, v2]) = (self.fingers[side], [v[2 * side], v[2 * side + 1]]);
            0.5 * (a * v1 * v1 + d * v2 * v2) + b * v1 * v2
        };
        let mut energy = finger(0) + finger(1) + self.coupling * v[0] * v[2];
        if N > FINGERS {
            let [vx, vy, spin] = [v[FINGERS], v[FINGERS + 1], v[FINGERS + 2]];
            energy += 0.5 * (self.object[0] * (vx * vx + vy * vy) + self.object[1] * spin * spin);
        }
        energy
    }
}

/// What does not move has no mass here.
fn inverse_or_none(of: f64) -> f64 {
    if of > 0.0 { 1.0 / of } else { 0.0 }
}

impl Inverse {
    /// M⁻¹ load.
    #[inline(always)]
    pub fn solve<const N: usize>(&self, load: &[f64; N]) -> [f64; N] {
        self.solve_columns(&load.map(|load| [load])).map(|[a]| a)
    }

    /// M⁻¹ of a matrix of loads: row by row, so that its columns are worked on side by side.
    #[inline(always)]
    pub fn solve_columns<const N: usize, const C: usize>(&self, loads: &[[f64; C]; N]) -> [[f64; C]; N] {
        let mut a = [[0.0; C]; N];
        for side in 0..2 {
            let ([m, c, n], [first, second]) = (self.fingers[side], [2 * side, 2 * side + 1]);
            for j in 0..C {
                let [f, g] = [loads[first][j], loads[second][j]];
                (a[first][j], a[second][j]) = (m * f + c * g, c * f + n * g);
            }
        }
        if self.coupling != 0.0 {
            // Each finger also feels −c times the other one's q̈11 on its own.
            let (c, [right, left]) = (self.coupling, [a[0], a[2]]);
            let alone = c * self.fingers[1][0];
            let second: [f64; C] = std::array::from_fn(|j| (left[j] - alone * right[j]) / self.remainder);
            let first: [f64; C] = std::array::from_fn(|j| right[j] - c * self.fingers[0][0] * second[j]);
            for (side, other) in [second, first].into_iter().enumerate() {
                let [m, n] = [c * self.fingers[side][0], c * self.fingers[side][1]];
                for j in 0..C {
                    a[2 * side][j] -= m * other[j];
                    a[2 * side + 1][j] -= n * other[j];
                }
            }
        }
        if N > FINGERS {
            let [inverse_mass, inverse_inertia] = self.object;
            a[FINGERS] = loads[FINGERS].map(|load| load * inverse_mass);
            a[FINGERS + 1] = loads[FINGERS + 1].map(|load| load * inverse_mass);
            a[FINGERS + 2] = loads[FINGERS + 2].map(|load| load * inverse_inertia);
        }
        // Memories are no coordinates of masses.
        a.iter_mut().zip(loads).skip(MEMORY).for_each(|(a, load)| *a = *load);
        a
    }
}
