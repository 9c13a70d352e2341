//! Edges of the captured range.

use super::placement::{Placement, simulate_placement};
use super::{Plan, SceneLoader};

/// One edge of the captured range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Outermost offset at which the object is captured, m.
    pub captured_m: f64,
    /// Nearest offset farther out at which it is not captured, m; `None` if it is captured at the largest error.
    pub lost_m: Option<f64>,
}

/// Locates the left and right edge of the captured range around the middle. The inner `None` means that the object is
/// not captured in the middle, the outer `None` that the search was interrupted.
pub(super) fn find_edges(
    plan: &Plan,
    placements: &[Placement],
    load: SceneLoader<'_>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Option<[Edge; 2]>> {
    let middle = placements.len() / 2;
    if !placements[middle].is_captured() {
        return Some(None);
    }
    let left = find_edge(plan, placements[..=middle].iter().rev(), load, keep_running)?;
    let right = find_edge(plan, placements[middle..].iter(), load, keep_running)?;
    Some(Some([left, right]))
}

/// Locates one edge from placements ordered outward from the middle.
fn find_edge<'a>(
    plan: &Plan,
    outward: impl Iterator<Item = &'a Placement>,
    load: SceneLoader<'_>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Edge> {
    let mut edge = Edge { captured_m: 0.0, lost_m: None };
    for placement in outward {
        if !placement.is_captured() {
            edge.lost_m = Some(placement.offset_m);
            break;
        }
        edge.captured_m = placement.offset_m;
    }
    while let Some(lost_m) = edge.lost_m.filter(|lost_m| (lost_m - edge.captured_m).abs() > plan.tolerance_m) {
        let middle_m = 0.5 * (edge.captured_m + lost_m);
        match simulate_placement(plan.model, middle_m, load, keep_running)?.is_captured() {
            true => edge.captured_m = middle_m,
            false => edge.lost_m = Some(middle_m),
        }
    }
    Some(edge)
}
