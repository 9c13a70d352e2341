//! Cells of a volume: the display state of each point for one quantity.

use super::{Point, Quantity, Volume};

/// Display state of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// No finger exists, at least at one base.
    NoFinger,
    /// A contact force would have to be tensile.
    Unstable,
    /// The value of the quantity in SI units.
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

/// Returns the cells of one volume, in the order of its points.
pub fn cells(volume: &Volume, quantity: Quantity) -> Vec<Cell> {
    intersection_cells(&[volume], quantity)
}

/// Returns the cells of the intersection of volumes that differ only in their base: stable where all are, with the
/// worst value.
pub fn intersection_cells(volumes: &[&Volume], quantity: Quantity) -> Vec<Cell> {
    let points = volumes.iter().map(|volume| volume.points.len()).min().unwrap_or(0);
    (0..points).map(|index| cell(|| volumes.iter().map(move |volume| &volume.points[index]), quantity)).collect()
}

fn cell<'a, I: Iterator<Item = &'a Point>>(points: impl Fn() -> I, quantity: Quantity) -> Cell {
    if points().any(|point| point.state.is_err()) {
        return Cell::NoFinger;
    }
    let states = || points().filter_map(|point| point.state.as_ref().ok());
    match quantity.worst_value(states()) {
        Some(worst) if states().all(|state| state.is_stable()) => Cell::Stable(worst),
        _ => Cell::Unstable,
    }
}
