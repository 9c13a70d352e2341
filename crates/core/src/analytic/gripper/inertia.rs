//! The mass matrix: a block for each finger, a diagonal one for the object, and with a differential one number that couples both driven links.

use super::FINGERS;
use super::model::GripperModel;

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
        Inverse { fingers, coupling: self.coupling, remainder, object: self.object.map(f64::recip) }
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

impl Inverse {
    /// M⁻¹ load.
    #[inline(always)]
    pub fn solve<const N: usize>(&self, load: &[f64; N]) -> [f64; N] {
        let mut a = [0.0; N];
        for side in 0..2 {
            let ([m, c, n], [f, g]) = (self.fingers[side], [load[2 * side], load[2 * side + 1]]);
            (a[2 * side], a[2 * side + 1]) = (m * f + c * g, c * f + n * g);
        }
        if self.coupling != 0.0 {
            // Each finger also feels −c times the other one's q̈11 on its own.
            let c = self.coupling;
            let [right, left] = [a[0], a[2]];
            let second = (left - c * self.fingers[1][0] * right) / self.remainder;
            let first = right - c * self.fingers[0][0] * second;
            for (side, other) in [second, first].into_iter().enumerate() {
                a[2 * side] -= c * self.fingers[side][0] * other;
                a[2 * side + 1] -= c * self.fingers[side][1] * other;
            }
        }
        if N > FINGERS {
            a[FINGERS] = load[FINGERS] * self.object[0];
            a[FINGERS + 1] = load[FINGERS + 1] * self.object[0];
            a[FINGERS + 2] = load[FINGERS + 2] * self.object[1];
        }
        a
    }
}
