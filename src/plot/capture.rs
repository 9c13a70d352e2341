//! Where an object ends, over where it lay.

use super::axis::Axis;
use super::canvas::{
    BLUE, DrawError, Entry, GREEN, GREY, LEGEND, Mark, ORANGE, WIDTH, frame, legend, line, picture, point, titled,
};
use crate::criteria::Fate;
use crate::study::capture::{Capture, Placed};
use plotters::style::RGBColor;

const HEIGHT: u32 = 560;

/// The picture; an object that stays where it lies is on the grey line.
pub fn capture(found: &Capture) -> Result<String, DrawError> {
    let ended = |placed: &Placed| placed.found.as_ref().ok().map(|found| found.centre_m[0] * 1e3);
    let reach = found.plan.error_m * 1e3;
    let held = found.placed.iter().filter(|placed| placed.is_captured());
    let x = Axis::over("object at the start, mm from the middle", -1.1 * reach, 1.1 * reach);
    let y = Axis::linear("object at the end, mm from the middle", held.filter_map(ended).chain([-reach, reach]));
    picture(HEIGHT, |area| {
        let rest = titled(area, &format!("{}: what it captures", found.scene))?;
        let (left, right) = rest.split_horizontally(WIDTH - LEGEND - 30);
        let mut chart = frame(&left, &x, &y, true)?;
        line(&mut chart, vec![(-reach, -reach), (reach, reach)], Mark::Line { width: 1 }, GREY)?;
        for lost_m in found.captured.iter().flatten().filter_map(|edge| edge.lost_m) {
            line(&mut chart, vec![(lost_m * 1e3, y.from), (lost_m * 1e3, y.to)], Mark::Line { width: 1 }, ORANGE)?;
        }
        for placed in &found.placed {
            let (mark, colour, _) = style(placed);
            // What has left the picture lies on its edge.
            let at = ended(placed).unwrap_or(0.0).clamp(y.from, y.to);
            point(&mut chart, (placed.offset_m * 1e3, at), mark, colour)?;
        }
        let mut entries: Vec<Entry> = Vec::new();
        for placed in &found.placed {
            let (mark, colour, text) = style(placed);
            if !entries.iter().any(|entry| entry.text == text) {
                entries.push(Entry::new(mark, colour, text));
            }
        }
        entries.push(Entry::new(Mark::Line { width: 1 }, GREY, "stays where it lies"));
        if found.captured.iter().flatten().any(|edge| edge.lost_m.is_some()) {
            entries.push(Entry::new(Mark::Line { width: 1 }, ORANGE, "edge of what is captured"));
        }
        legend(&right, &entries)
    })
}

fn style(placed: &Placed) -> (Mark, RGBColor, &'static str) {
    match &placed.found {
        Ok(found) if found.fate == Fate::Held && found.form_closed == Some(true) => {
            (Mark::Circle, GREEN, "held, form-closed")
        }
        Ok(found) if found.fate == Fate::Held => (Mark::Circle, BLUE, "held"),
        Ok(_) => (Mark::Cross, ORANGE, "not held"),
        Err(_) => (Mark::Cross, GREY, "not simulated to its end"),
    }
}
