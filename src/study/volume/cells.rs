//! A volume as it is looked at: what each point shows of one quantity.

use super::{Point, Quantity, Volume};

/// What a point shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// No finger, or not at every base.
    NoFinger,
    /// A phalanx would have to pull.
    Unstable,
    /// The quantity in SI.
    Stable(f64),
}

impl Cell {
    pub fn value(self) -> Option<f64> {
        match self {
            Cell::Stable(value) => Some(value),
            Cell::NoFinger | Cell::Unstable => None,
        }
    }
}

/// The cells of one volume, in the order of its points.
pub fn cells(volume: &Volume, quantity: Quantity) -> Vec<Cell> {
    intersection_cells(&[volume], quantity)
}

/// The cells of the intersection of volumes that differ in their base alone: stable where all are, with the worst value.
pub fn intersection_cells(volumes: &[&Volume], quantity: Quantity) -> Vec<Cell> {
    let points = volumes.iter().map(|volume| volume.points.len()).min().unwrap_or(0);
    (0..points).map(|index| cell(|| volumes.iter().map(move |volume| &volume.points[index]), quantity)).collect()
}

fn cell<'a, I: Iterator<Item = &'a Point>>(points: impl Fn() -> I, quantity: Quantity) -> Cell {
    if points().any(|point| point.state.is_err()) {
        return Cell::NoFinger;
    }
    let states = || points().filter_map(|point| point.state.as_ref().ok());
    match quantity.worst_of(states()) {
        Some(worst) if states().all(|state| state.is_stable()) => Cell::Stable(worst),
        _ => Cell::Unstable,
    }
}
