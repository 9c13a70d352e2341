//! Strands: the straight parts of a cable with friction, and the memory for them and their derivatives.

use super::cable::Tension;
use super::nearest::POSES;
use crate::numeric::plane::Vector;

/// A straight part of a cable with friction, with the path element at its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strand {
    pub ends: [usize; 2],
    pub bodies: [Option<usize>; 2],
    /// Derivative of its length by the relative pose of the bodies.
    pub row: [f64; POSES],
    pub direction: Vector<f64>,
    /// Rate at which it becomes longer, with the spools at its end of the cable, m/s.
    pub rate: f64,
    pub tension: f64,
    /// Wrap at the element at its end, rad, and speed of the cable over this element towards the first strand, m/s; 0 at
    /// the end of the path.
    pub turn: f64,
    pub slip: f64,
}

/// State of a cable at a path element.
#[derive(Clone, Copy, Debug, Default)]
pub struct ElementReading {
    pub is_on: bool,
    /// Wrap, rad; 0 if the cable is off.
    pub turn: f64,
    /// Distance of the cable from a pulley that it is off, m.
    pub gap: f64,
    /// Speed of the cable towards the first segment, m/s; 0 if the cable is off or has no friction.
    pub slip: f64,
    /// Tension behind the element, N.
    pub tension: f64,
}

/// Straight parts of a cable with friction, and the memory of their derivatives.
#[derive(Clone, Debug, Default)]
pub(super) struct Strands {
    pub all: Vec<Strand>,
    pub derivatives: Vec<StrandDerivatives>,
    /// Of the tension of a strand, and of the next one.
    pub tension: Gradient,
    pub next: Gradient,
    pub slip: Gradient,
    /// Derivative of the angle of the body of a path element.
    pub angle: Vec<f64>,
}

/// Derivatives of a number by all coordinates and rates, and by time.
#[derive(Clone, Debug, Default)]
pub(super) struct Gradient {
    pub by_q: Vec<f64>,
    pub by_v: Vec<f64>,
    pub by_t: f64,
}

impl Gradient {
    pub fn reset(&mut self, size: usize) {
        for list in [&mut self.by_q, &mut self.by_v] {
            list.clear();
            list.resize(size, 0.0);
        }
        self.by_t = 0.0;
    }

    /// Adds the derivatives of the total tension of a cable from those of its elongation, `row`, and of the rate of this.
    pub fn add_tension(&mut self, tension: &Tension, row: &[f64], rate: &[f64]) {
        for (i, (row, rate)) in row.iter().zip(rate).enumerate() {
            self.by_q[i] += tension.by_elongation * row + tension.by_rate * rate;
            self.by_v[i] += tension.by_rate * row;
        }
    }
}

/// Derivatives of a strand by all coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct StrandDerivatives {
    /// Of its length.
    pub row: Vec<f64>,
    /// Of its rate.
    pub rate: Vec<f64>,
    /// Of its angle.
    pub angle: Vec<f64>,
}
