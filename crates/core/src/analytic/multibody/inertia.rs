//! The mass matrix: a block for each finger and a diagonal block for each disc. A differential adds one entry that
//! couples both driven links.

use super::FINGERS;
use super::model::Multibody;
use crate::numeric::array_from;

/// (M₁₁, M₁₂, M₂₂) of each finger, including the inertia that rotates with its driven link. The masses of the discs are
/// in the model.
#[derive(Clone, Copy, Debug)]
pub struct Inertia<'a, const N: usize, const C: usize> {
    model: &'a Multibody<N, C>,
    fingers: [[f64; 3]; FINGERS],
}

/// The inverse of the mass matrix.
#[derive(Clone, Copy, Debug)]
pub struct Inverse<'a, const N: usize, const C: usize> {
    model: &'a Multibody<N, C>,
    fingers: [[f64; 3]; FINGERS],
    /// 1 − c² (A⁻¹)₁₁ (B⁻¹)₁₁, with the coupling M₁₂ = c between the driven links.
    remainder: f64,
}

impl<'a, const N: usize, const C: usize> Inertia<'a, N, C> {
    /// Takes the fingers' own mass matrices; entries of missing fingers are ignored.
    #[inline(always)]
    pub fn new(model: &'a Multibody<N, C>, mut fingers: [[f64; 3]; FINGERS]) -> Self {
        (0..FINGERS).for_each(|finger| fingers[finger][0] += model.rotor_inertia[finger]);
        Self { model, fingers }
    }

    #[inline(always)]
    pub fn inverse(&self) -> Inverse<'a, N, C> {
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
        for ([a, b, d], v) in self.fingers.iter().take(self.model.fingers.len()).zip(v.chunks_exact(2)) {
            energy += 0.5 * (a * v[0] * v[0] + d * v[1] * v[1]) + b * v[0] * v[1];
        }
        if self.model.fingers.len() == FINGERS {
            energy += self.model.coupling * v[0] * v[2];
        }
        for (index, disc) in self.model.discs.iter().enumerate() {
            let [vx, vy, spin] = self.model.disc_rates(index, v);
            energy += 0.5 * (disc.mass * (vx * vx + vy * vy) + disc.inertia * spin * spin);
        }
        energy
    }
}

impl<const N: usize, const C: usize> Inverse<'_, N, C> {
    /// Solves M x = `load`.
    #[inline(always)]
    pub fn solve(&self, load: &[f64; N]) -> [f64; N] {
        let mut column = [[0.0]; N];
        for i in 0..N {
            column[i] = [load[i]];
        }
        let a = self.solve_columns(&column);
        array_from(|i| a[i][0])
    }

    /// M⁻¹ of a matrix of loads. The rows are processed one by one, so that the compiler can vectorise over the
    /// columns.
    #[inline(always)]
    pub(crate) fn solve_columns<const K: usize>(&self, loads: &[[f64; K]; N]) -> [[f64; K]; N] {
        let mut a = [[0.0; K]; N];
        for finger in 0..self.model.finger_count() {
            let ([m, c, n], [first, second]) = (self.fingers[finger], [2 * finger, 2 * finger + 1]);
            for j in 0..K {
                let [f, g] = [loads[first][j], loads[second][j]];
                (a[first][j], a[second][j]) = (m * f + c * g, c * f + n * g);
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
        for index in 0..self.model.disc_count() {
            let first = self.model.first_coordinate(index);
            if first >= N {
                continue;
            }
            let disc = &self.model.discs[index];
            for (i, inverse) in [disc.inverse_mass, disc.inverse_mass, disc.inverse_inertia].into_iter().enumerate() {
                for j in 0..K {
                    a[first + i][j] = loads[first + i][j] * inverse;
                }
            }
        }
        // Bristle states have no mass: their load is their rate.
        if !Multibody::<N, C>::GRASP {
            a.iter_mut().zip(loads).skip(self.model.first_bristle).for_each(|(a, load)| *a = *load);
        }
        a
    }
}
