//! Final position of an object over its initial position.

use super::axis::Axis;
use super::canvas::{LegendEntry, Marker, THIN_LINE, chart, line, point, vertical_line};
use super::theme::{BLUE, Colour, GREEN, ORANGE, SOFT};
use crate::criteria::Fate;
use crate::study::capture::{Capture, Placement};

const HEIGHT: f64 = 560.0;

/// Draws the results of a capture study; objects that do not move are on the grey line.
pub fn capture(found: &Capture) -> String {
    let ended =
        |placement: &Placement| placement.outcome.as_ref().ok().map(|found| found.criteria.end.centre_m[0] * 1e3);
    let reach = found.plan.error_m * 1e3;
    let captured = found.placements.iter().filter(|placement| placement.is_captured());
    let x = Axis::from_range("object at the start, mm from the middle", -1.1 * reach, 1.1 * reach);
    let y = Axis::linear("object at the end, mm from the middle", captured.filter_map(ended).chain([-reach, reach]));
    chart(&format!("{}: captured objects", found.scene), HEIGHT, &x, &y, |svg, frame| {
        line(svg, frame, [(-reach, -reach), (reach, reach)], THIN_LINE, SOFT);
        let lost_positions = || found.captured_range.iter().flatten().filter_map(|edge| edge.lost_m);
        for lost_m in lost_positions() {
            vertical_line(svg, frame, lost_m * 1e3, ORANGE);
        }
        let mut entries: Vec<LegendEntry> = Vec::new();
        for placement in &found.placements {
            let (marker, colour, text) = style(placement);
            // Positions outside of the picture are clamped to its edge.
            point(svg, frame, (placement.offset_m * 1e3, ended(placement).unwrap_or(0.0)), marker, colour);
            if !entries.iter().any(|entry| entry.text == text) {
                entries.push(LegendEntry::new(marker, colour, text));
            }
        }
        entries.push(LegendEntry::new(THIN_LINE, SOFT, "does not move"));
        if lost_positions().next().is_some() {
            entries.push(LegendEntry::new(THIN_LINE, ORANGE, "edge of the captured range"));
        }
        entries
    })
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
