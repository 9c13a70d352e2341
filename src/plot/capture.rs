//! Final position of an object over its initial position.

use super::axis::Axis;
use super::canvas::{Marker, THIN_LINE};
use super::series::{Series, series_chart};
use super::theme::{BLUE, Colour, GREEN, ORANGE, SOFT};
use crate::criteria::Fate;
use crate::study::capture::{Capture, Placement};

/// Draws the results of a capture study; objects that do not move are on the grey line.
pub fn capture(found: &Capture) -> String {
    let ended =
        |placement: &Placement| placement.outcome.as_ref().ok().map(|found| found.criteria.end.centre_m[0] * 1e3);
    let reach = found.plan.error_m * 1e3;
    let captured = found.placements.iter().filter(|placement| placement.is_captured());
    let x = Axis::from_range("object at the start, mm from the middle", -1.1 * reach, 1.1 * reach);
    let y = Axis::linear("object at the end, mm from the middle", captured.filter_map(ended).chain([-reach, reach]));
    let mut series = vec![Series::new(THIN_LINE, SOFT, [(-reach, -reach), (reach, reach)])];
    let edges = found.captured_range.iter().flatten().filter_map(|edge| edge.lost_m);
    series.extend(edges.map(|lost_m| Series::vertical(ORANGE, lost_m * 1e3)));
    let has_edges = series.len() > 1;
    series.extend(found.placements.iter().map(|placement| {
        let (marker, colour, text) = style(placement);
        // Positions outside of the picture are clamped to its edge.
        Series::new(marker, colour, [(placement.offset_m * 1e3, ended(placement).unwrap_or(0.0))]).named(text)
    }));
    series.push(Series::key(THIN_LINE, SOFT, "does not move"));
    series.extend(has_edges.then(|| Series::key(THIN_LINE, ORANGE, "edge of the captured range")));
    series_chart(&format!("{}: captured objects", found.scene), 560.0, &x, &y, &series)
}

fn style(placement: &Placement) -> (Marker, Colour, &'static str) {
    match &placement.outcome {
        Ok(found) if found.criteria.fate == Fate::Held && found.form_closed == Some(true) => {
            (Marker::Circle, GREEN, "held, form-closed")
        }
        Ok(found) if found.criteria.fate == Fate::Held => (Marker::Circle, BLUE, "held"),
        Ok(_) => (Marker::Cross, ORANGE, "not held"),
        Err(_) => (Marker::Cross, SOFT, "simulation not completed"),
    }
}
