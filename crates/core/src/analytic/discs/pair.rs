//! Two surfaces that may meet: gap, normal, and the rates of their material points at the contact.

use crate::numeric::Real;
use crate::numeric::plane::{Vector, dot, perp, scale, sub};

/// A disc that moves, and what it meets.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Index among the moving discs, and radius.
    pub disc: usize,
    pub radius: f64,
    pub other: Other,
}

#[derive(Clone, Copy, Debug)]
pub enum Other {
    Moving { disc: usize, radius: f64 },
    Fixed { centre: [f64; 2], radius: f64 },
    HalfPlane { level: f64 },
}

/// Gap, and the unit normal from the other surface to the disc.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<T> {
    pub gap: T,
    pub normal: Vector<T>,
}

/// Rates of a meeting.
#[derive(Clone, Copy, Debug)]
pub struct PairRates<T> {
    pub gap_rate: T,
    /// Velocity of the disc's material point over the other one's, along the normal turned by 90°.
    pub slip: T,
    /// The parts of both that are the disc's own, and those that are the other one's.
    pub own: [T; 2],
    pub other: [T; 2],
}

impl Meeting {
    /// At coordinates (x, y, angle) of all moving discs.
    #[inline(always)]
    pub fn geometry<T: Real, const N: usize>(&self, q: &[T; N]) -> Geometry<T> {
        let centre = of(q, self.disc);
        let (other, reach) = match self.other {
            Other::Moving { disc, radius } => (of(q, disc), self.radius + radius),
            Other::Fixed { centre, radius } => (centre.map(T::constant), self.radius + radius),
            Other::HalfPlane { level } => {
                let up = [T::zero(), T::constant(1.0)];
                return Geometry { gap: centre[1] - (level + self.radius), normal: up };
            }
        };
        let away = sub(centre, other);
        let distance = dot(away, away).sqrt();
        Geometry { gap: distance - reach, normal: scale(away, distance.recip()) }
    }

    /// How coordinates change the gap.
    #[inline(always)]
    pub fn normal_row<const N: usize>(&self, normal: Vector<f64>) -> [f64; N] {
        let mut row = [0.0; N];
        (row[3 * self.disc], row[3 * self.disc + 1]) = (normal[0], normal[1]);
        if let Other::Moving { disc, .. } = self.other {
            (row[3 * disc], row[3 * disc + 1]) = (-normal[0], -normal[1]);
        }
        row
    }

    /// How rates change the slip.
    #[inline(always)]
    pub fn tangent_row<const N: usize>(&self, normal: Vector<f64>) -> [f64; N] {
        let tangent = perp(normal);
        let mut row = [0.0; N];
        let own = 3 * self.disc;
        (row[own], row[own + 1], row[own + 2]) = (tangent[0], tangent[1], -self.radius);
        if let Other::Moving { disc, radius } = self.other {
            (row[3 * disc], row[3 * disc + 1], row[3 * disc + 2]) = (-tangent[0], -tangent[1], -radius);
        }
        row
    }

    /// At rates of all moving discs. A surface point moves with its disc's centre and turns with it:
    /// v_t − r ω for the disc, v_t + r ω for what is on the other side of the contact.
    #[inline(always)]
    pub fn rates<T: Real, const N: usize>(&self, normal: Vector<T>, v: &[T; N]) -> PairRates<T> {
        let tangent = perp(normal);
        let velocity = of(v, self.disc);
        let own = [dot(normal, velocity), dot(tangent, velocity) - v[3 * self.disc + 2] * self.radius];
        let other = match self.other {
            Other::Moving { disc, radius } => {
                let velocity = of(v, disc);
                [-dot(normal, velocity), -(dot(tangent, velocity) + v[3 * disc + 2] * radius)]
            }
            Other::Fixed { .. } | Other::HalfPlane { .. } => [T::zero(); 2],
        };
        PairRates { gap_rate: own[0] + other[0], slip: own[1] + other[1], own, other }
    }
}

/// The first two of a disc's three coordinates.
#[inline(always)]
fn of<T: Real, const N: usize>(q: &[T; N], disc: usize) -> Vector<T> {
    [q[3 * disc], q[3 * disc + 1]]
}
