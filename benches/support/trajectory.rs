//! Result of one integration, and distances between two.

use serde::Serialize;

/// Spacing of the recorded trajectory.
pub const GRID_S: f64 = 2.5e-4;

/// Cost of an integration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    pub rhs: u64,
    pub jacobians: u64,
    pub steps: u64,
    pub rejected: u64,
}

/// End of an integration.
#[derive(Clone, Debug, PartialEq)]
pub enum EndState {
    Complete,
    /// Ended at a singularity of the loop, at this time.
    Singular(f64),
    /// Failed for another reason.
    Failed(String),
}

/// Result of one integration.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// (q11, q21) at multiples of [`GRID_S`] up to the end.
    pub grid: Vec<[f64; 2]>,
    /// First contact of the proximal and the distal phalanx.
    pub first_contact_s: [Option<f64>; 2],
    /// ∫ F_n dt of both phalanges up to the end; `None` if the solver does not integrate it.
    pub impulse: Option<[f64; 2]>,
    /// Largest penetration of a phalanx at the end of a step; `None` if not recorded.
    pub max_penetration_m: Option<f64>,
    pub end_state: EndState,
    pub cost: Cost,
}

/// Returns the largest angle difference along two trajectories; infinite if they end differently.
///
/// If both end at a singularity, the last point is ignored, because the rates are unbounded there.
pub fn angle_distance(a: &Trajectory, b: &Trajectory) -> f64 {
    let points = match (&a.end_state, &b.end_state) {
        (EndState::Complete, EndState::Complete) if a.grid.len() == b.grid.len() => a.grid.len(),
        (EndState::Singular(_), EndState::Singular(_)) if a.grid.len().abs_diff(b.grid.len()) <= 1 => {
            a.grid.len().min(b.grid.len()).saturating_sub(1)
        }
        _ => return f64::INFINITY,
    };
    let max_difference = |x: &[f64; 2], y: &[f64; 2]| (x[0] - y[0]).abs().max((x[1] - y[1]).abs());
    largest(a.grid.iter().zip(&b.grid).take(points).map(|(x, y)| max_difference(x, y)))
}

/// Returns the largest difference of a first contact time, s; infinite if only one trajectory has the contact.
pub fn contact_time_distance(a: &Trajectory, b: &Trajectory) -> f64 {
    largest(a.first_contact_s.iter().zip(&b.first_contact_s).map(|pair| match pair {
        (Some(x), Some(y)) => (x - y).abs(),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    }))
}

/// Returns the largest relative difference of an impulse from the reference.
pub fn impulse_distance(trajectory: &Trajectory, reference: &Trajectory) -> Option<f64> {
    let (a, b) = (trajectory.impulse?, reference.impulse?);
    Some(largest(a.iter().zip(&b).map(|(x, y)| (x / y - 1.0).abs())))
}

/// Returns the largest value; NaN counts as infinite.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| if x.is_nan() { f64::INFINITY } else { x }).fold(0.0, f64::max)
}
