//! How far from the middle an object is captured.

use super::place::{Placed, place};
use super::{Load, Plan};

/// An end of the captured range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The last offset at which the object is captured.
    pub captured_m: f64,
    /// The first one further out at which it is not; `None` where it is captured as far as was asked.
    pub lost_m: Option<f64>,
}

/// Both ends of the range about the middle in which the object is captured, left and right; `None` within if it is not captured in the
/// middle, and outside if it was told to stop.
pub(super) fn edges(
    plan: &Plan,
    placed: &[Placed],
    load: Load<'_>,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Option<[Edge; 2]>> {
    let middle = placed.len() / 2;
    if !placed[middle].is_captured() {
        return Some(None);
    }
    let left = edge(plan, placed[..=middle].iter().rev(), load, go_on)?;
    let right = edge(plan, placed[middle..].iter(), load, go_on)?;
    Some(Some([left, right]))
}

/// One end, of places from the middle outward.
fn edge<'a>(
    plan: &Plan,
    outward: impl Iterator<Item = &'a Placed>,
    load: Load<'_>,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Edge> {
    let mut edge = Edge { captured_m: 0.0, lost_m: None };
    for placed in outward {
        if !placed.is_captured() {
            edge.lost_m = Some(placed.offset_m);
            break;
        }
        edge.captured_m = placed.offset_m;
    }
    while let Some(lost_m) = edge.lost_m.filter(|lost_m| (lost_m - edge.captured_m).abs() > plan.tolerance_m) {
        let between_m = 0.5 * (edge.captured_m + lost_m);
        match place(plan.model, between_m, load, go_on)?.is_captured() {
            true => edge.captured_m = between_m,
            false => edge.lost_m = Some(between_m),
        }
    }
    Some(edge)
}
