//! Where an object ends, over where it lay.

use super::axis::Axis;
use super::canvas::{Entry, Mark, THIN, chart, line, point, upright};
use super::theme::{BLUE, Colour, GREEN, ORANGE, SOFT};
use crate::criteria::Fate;
use crate::study::capture::{Capture, Placed};

const HEIGHT: f64 = 560.0;

/// The picture; an object that stays where it lies is on the grey line.
pub fn capture(found: &Capture) -> String {
    let ended = |placed: &Placed| placed.found.as_ref().ok().map(|found| found.centre_m[0] * 1e3);
    let reach = found.plan.error_m * 1e3;
    let held = found.placed.iter().filter(|placed| placed.is_captured());
    let x = Axis::over("object at the start, mm from the middle", -1.1 * reach, 1.1 * reach);
    let y = Axis::linear("object at the end, mm from the middle", held.filter_map(ended).chain([-reach, reach]));
    chart(&format!("{}: what it captures", found.scene), HEIGHT, &x, &y, |svg, on| {
        line(svg, on, [(-reach, -reach), (reach, reach)], THIN, SOFT);
        let lost = || found.captured.iter().flatten().filter_map(|edge| edge.lost_m);
        for lost_m in lost() {
            upright(svg, on, lost_m * 1e3, ORANGE);
        }
        let mut entries: Vec<Entry> = Vec::new();
        for placed in &found.placed {
            let (mark, colour, text) = style(placed);
            // What has left the picture lies on its edge.
            point(svg, on, (placed.offset_m * 1e3, ended(placed).unwrap_or(0.0)), mark, colour);
            if !entries.iter().any(|entry| entry.text == text) {
                entries.push(Entry::new(mark, colour, text));
            }
        }
        entries.push(Entry::new(THIN, SOFT, "stays where it lies"));
        if lost().next().is_some() {
            entries.push(Entry::new(THIN, ORANGE, "edge of what is captured"));
        }
        entries
    })
}

fn style(placed: &Placed) -> (Mark, Colour, &'static str) {
    match &placed.found {
        Ok(found) if found.fate == Fate::Held && found.form_closed == Some(true) => {
            (Mark::Circle, GREEN, "held, form-closed")
        }
        Ok(found) if found.fate == Fate::Held => (Mark::Circle, BLUE, "held"),
        Ok(_) => (Mark::Cross, ORANGE, "not held"),
        Err(_) => (Mark::Cross, SOFT, "not simulated to its end"),
    }
}
