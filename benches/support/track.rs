//! What one integration looked like, and how far two of them are apart.

use serde::Serialize;

/// Spacing of the recorded trajectory.
pub const GRID_S: f64 = 2.5e-4;

/// What an integration cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    pub rhs: u64,
    pub jacobians: u64,
    pub steps: u64,
    pub rejected: u64,
}

/// How an integration ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ended {
    Complete,
    /// At the named singularity of the loop, at this time.
    Singular(f64),
    /// For any other reason.
    Failed(String),
}

/// One integration.
#[derive(Clone, Debug)]
pub struct Track {
    /// (q11, q21) at the multiples of [`GRID_S`] that were reached.
    pub grid: Vec<[f64; 2]>,
    /// First touch of the proximal and the distal phalanx.
    pub touch_s: [Option<f64>; 2],
    /// ∫ F_n dt of both phalanges up to the end, where the contestant carries it.
    pub impulse: Option<[f64; 2]>,
    /// Deepest penetration of a phalanx at the end of any step, where that was looked at.
    pub deepest_m: Option<f64>,
    pub ended: Ended,
    pub cost: Cost,
}

/// Largest difference of an angle along two trajectories; infinite if one of them is cut short where the other is not.
///
/// Where both end at a singularity, the point nearest to it is left out: rates grow without bound there.
pub fn angle_distance(a: &Track, b: &Track) -> f64 {
    let points = match (&a.ended, &b.ended) {
        (Ended::Complete, Ended::Complete) if a.grid.len() == b.grid.len() => a.grid.len(),
        (Ended::Singular(_), Ended::Singular(_)) if a.grid.len().abs_diff(b.grid.len()) <= 1 => {
            a.grid.len().min(b.grid.len()).saturating_sub(1)
        }
        _ => return f64::INFINITY,
    };
    let apart = |x: &[f64; 2], y: &[f64; 2]| (x[0] - y[0]).abs().max((x[1] - y[1]).abs());
    largest(a.grid.iter().zip(&b.grid).take(points).map(|(x, y)| apart(x, y)))
}

/// Largest difference of a first touch, in s; infinite if only one of the two touches.
pub fn touch_distance(a: &Track, b: &Track) -> f64 {
    largest(a.touch_s.iter().zip(&b.touch_s).map(|pair| match pair {
        (Some(x), Some(y)) => (x - y).abs(),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    }))
}

/// Largest relative difference of an impulse from that of `reference`.
pub fn impulse_distance(track: &Track, reference: &Track) -> Option<f64> {
    let (a, b) = (track.impulse?, reference.impulse?);
    Some(largest(a.iter().zip(&b).map(|(x, y)| (x / y - 1.0).abs())))
}

/// The largest; not a number counts as infinite.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| if x.is_nan() { f64::INFINITY } else { x }).fold(0.0, f64::max)
}
