//! Final forces and palm force by design (thesis Figs. 4.5, A.20–A.23).

use super::criteria::design_numbers;
use crate::format::condition_name;
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    AXIS_HEIGHT, Area, LegendEntry, Marker, THIN_LINE, TITLE_HEIGHT, WIDTH, frame, horizontal_legend, horizontal_line,
    picture, points, text_right_of,
};
use crate::plot::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::study::select::{Candidate, Selection};

const KEY_HEIGHT: f64 = 34.0;
const HEADER_HEIGHT: f64 = 26.0;
const PANEL_HEIGHT: f64 = 170.0;
/// Colours of the first conditions.
const COLOURS: [Colour; 5] = [BLUE, ORANGE, GREEN, PURPLE, AMBER];

/// The quantity of a panel.
type Figure = fn(&Candidate) -> Option<f64>;

/// Draws F21, F22 and PFP of the runs that end at rest on the object. Others end during a rebound, where forces are
/// transient.
pub fn selection_forces(title: &str, selection: &Selection) -> String {
    let panels: [(&str, Figure); 3] = [
        ("F21, normal force of the proximal phalanx on the object, N", |run| run.f21_n),
        ("F22, normal force of the distal phalanx on the object, N", |run| run.f22_n),
        ("PFP, force of the object on the palm, by each finger, N", |run| run.pfp_n),
    ];
    let design_numbers = design_numbers(selection);
    let (first, last) = (design_numbers.first().copied().unwrap_or(0), design_numbers.last().copied().unwrap_or(1));
    let x = Axis::from_range("design", first as f64 - 1.0, last as f64 + 1.0);
    // The larger marker of the first condition remains visible behind equal values of others.
    let condition_markers = [Marker::Circle, Marker::SmallDot];
    let is_dense = selection.runs.len() > 4000;
    let title = format!("{title}: final forces of the runs that come to rest");
    picture(&title, TITLE_HEIGHT + KEY_HEIGHT + 3.0 * (HEADER_HEIGHT + PANEL_HEIGHT) + AXIS_HEIGHT, |svg| {
        let mut entries: Vec<LegendEntry> = Vec::new();
        for (index, condition) in selection.conditions.iter().enumerate().take(COLOURS.len()) {
            entries.push(LegendEntry::new(condition_markers[index.min(1)], COLOURS[index], &condition_name(condition)));
        }
        if selection.conditions.len() > COLOURS.len() {
            entries.push(LegendEntry::new(Marker::SmallDot, SOFT, "others"));
        }
        entries.push(LegendEntry::new(Marker::Ring, INK, "selected"));
        horizontal_legend(svg, &entries);
        for (index, (name, figure)) in panels.into_iter().enumerate() {
            let is_last = index + 1 == panels.len();
            let top = KEY_HEIGHT + (HEADER_HEIGHT + PANEL_HEIGHT) * index as f64 + HEADER_HEIGHT;
            text_right_of(svg, name, [86.0, top - 0.5 * HEADER_HEIGHT + 2.0], 15.0, INK);
            let is_at_rest = |run: &&Candidate| run.tts_s.is_some();
            let y = Axis::linear("", selection.runs.iter().filter(is_at_rest).filter_map(figure).chain([0.0]));
            let area =
                Area { left: 0.0, top, width: WIDTH, height: PANEL_HEIGHT + if is_last { AXIS_HEIGHT } else { 0.0 } };
            let frame = frame(svg, area, &x, &y, is_last);
            horizontal_line(svg, &frame, 0.0, THIN_LINE, SOFT);
            let force_point = |run: &Candidate| Some((run.design as f64, figure(run)?));
            for condition in 0..selection.conditions.len() {
                let marker = if is_dense { Marker::TinyDot } else { condition_markers[condition.min(1)] };
                let colour = COLOURS.get(condition).copied().unwrap_or(SOFT);
                let condition_runs = selection.runs.iter().filter(is_at_rest).filter(|run| run.condition == condition);
                points(svg, &frame, condition_runs.filter_map(force_point), marker, colour);
            }
            let best = selection.ranking.iter().take(WIDTH as usize).map(|ranked| &selection.runs[ranked.run_index]);
            points(svg, &frame, best.filter(is_at_rest).filter_map(force_point), Marker::Ring, INK);
        }
    })
}
