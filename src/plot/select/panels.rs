//! Quantities by design in stacked panels: final forces and palm force (thesis Figs. 4.5, A.20–A.23), varied and
//! dependent quantities (Figs. 4.1, 4.2).

use std::collections::HashSet;

use super::design_numbers;
use crate::format::{Quantity, condition_name};
use crate::plot::axis::Axis;
use crate::plot::canvas::{LegendEntry, Marker, THIN_LINE, TITLE_HEIGHT, WIDTH, horizontal_legend, picture};
use crate::plot::series::{Panel, Series, Stack};
use crate::plot::theme::{AMBER, BLUE, Colour, GREEN, INK, ORANGE, PURPLE, SOFT};
use crate::study::select::{Candidate, Selection};
use crate::table::Table;

/// Colours of the first conditions.
const COLOURS: [Colour; 5] = [BLUE, ORANGE, GREEN, PURPLE, AMBER];
/// Number of points from which markers are tiny.
const DENSE: usize = 4000;
/// Dependent quantities of a design; those missing in the results are omitted.
const DEPENDENT: [&str; 8] =
    ["l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "trajectory_rad", "motor_n_m", "spring_n_m"];

/// The quantity of a panel.
type Figure = fn(&Candidate) -> Option<f64>;

/// Draws F21, F22 and PFP of the runs that end at rest on the object. Others end during a rebound, where forces are
/// transient.
pub fn selection_forces(title: &str, selection: &Selection) -> String {
    // The larger marker of the first condition remains visible behind equal values of others.
    let style = |condition: usize| {
        let marker = if condition == 0 { Marker::Circle } else { Marker::SmallDot };
        (marker, COLOURS.get(condition).copied().unwrap_or(SOFT))
    };
    let marker = |condition| if selection.runs.len() > DENSE { Marker::TinyDot } else { style(condition).0 };
    let at_rest: Vec<&Candidate> = selection.runs.iter().filter(|run| run.tts_s.is_some()).collect();
    let panels: [(&str, Figure); 3] = [
        ("F21, normal force of the proximal phalanx on the object, N", |run| run.f21_n),
        ("F22, normal force of the distal phalanx on the object, N", |run| run.f22_n),
        ("PFP, force of the object on the palm, by each finger, N", |run| run.pfp_n),
    ];
    let panels = panels.map(|(name, figure)| {
        let force_point = |run: &Candidate| Some((run.design as f64, figure(run)?));
        let mut series = vec![Series::horizontal(THIN_LINE, SOFT, 0.0)];
        series.extend((0..selection.conditions.len()).map(|condition| {
            let runs = at_rest.iter().filter(|run| run.condition == condition);
            Series::new(marker(condition), style(condition).1, runs.filter_map(|run| force_point(run)))
        }));
        let best = selection.ranking.iter().take(WIDTH as usize).map(|ranked| &selection.runs[ranked.run_index]);
        let best_at_rest = best.filter(|run| run.tts_s.is_some());
        series.push(Series::new(Marker::Ring, INK, best_at_rest.filter_map(force_point)));
        let y = Axis::linear("", at_rest.iter().filter_map(|run| figure(run)).chain([0.0]));
        Panel { heading: Some(name.to_string()), y, series }
    });
    let mut entries: Vec<LegendEntry> = Vec::new();
    for (index, condition) in selection.conditions.iter().enumerate().take(COLOURS.len()) {
        let (marker, colour) = style(index);
        entries.push(LegendEntry::new(marker, colour, &condition_name(condition)));
    }
    if selection.conditions.len() > COLOURS.len() {
        entries.push(LegendEntry::new(Marker::SmallDot, SOFT, "others"));
    }
    entries.push(LegendEntry::new(Marker::Ring, INK, "selected"));
    let title = format!("{title}: final forces of the runs that come to rest");
    let stack = Stack { top: 34.0, heading: 26.0, panel: 170.0, has_legends: false };
    picture(&title, TITLE_HEIGHT + stack.height(panels.len()), |svg| {
        horizontal_legend(svg, &entries);
        stack.draw(svg, &design_axis(selection), &panels);
    })
}

/// Draws a panel for every axis that is not part of the conditions, and one for each dependent quantity.
pub fn selection_variables(title: &str, results: &Table, selection: &Selection) -> String {
    let varied = selection.axes.iter().filter(|axis| !axis.varies_within_design && axis.values.len() > 1);
    let varied = varied.map(|axis| (axis.column.as_str(), BLUE));
    let columns = varied.chain(DEPENDENT.map(|name| (name, GREEN)));
    let panel = |(name, colour): (&str, Colour)| {
        let (column, quantity) = (results.find(name)?, Quantity::for_column(name));
        let points = values(results, selection, column, quantity.scale);
        let mut y = Axis::linear("", points.iter().map(|point| point.1));
        // About three ticks, for low panels.
        if y.ticks.len() > 3 {
            y.ticks = y.ticks.into_iter().step_by(2).collect();
        }
        let marker = if points.len() > DENSE { Marker::TinyDot } else { Marker::SmallDot };
        let is_shown = !points.is_empty();
        let series = vec![Series::new(marker, colour, points)];
        is_shown.then(|| Panel { heading: Some(quantity.label()), y, series })
    };
    let panels: Vec<Panel> = columns.filter_map(panel).collect();
    let stack = Stack { top: 0.0, heading: 24.0, panel: 74.0, has_legends: false };
    picture(&format!("{title}: the designs"), TITLE_HEIGHT + stack.height(panels.len()), |svg| {
        stack.draw(svg, &design_axis(selection), &panels);
    })
}

fn design_axis(selection: &Selection) -> Axis {
    let numbers = design_numbers(selection);
    let (first, last) = (numbers.first().copied().unwrap_or(0), numbers.last().copied().unwrap_or(1));
    Axis::from_range("design", first as f64 - 1.0, last as f64 + 1.0)
}

/// Points (design, displayed value) of the first run of every design that has a value.
fn values(results: &Table, selection: &Selection, column: usize, scale: f64) -> Vec<(f64, f64)> {
    let mut seen = HashSet::new();
    let value = |row: usize| results.rows[row][column].as_number().filter(|value| value.is_finite());
    let with_value = selection.runs.iter().filter_map(|run| Some((run.design, value(run.row)? * scale)));
    with_value.filter(|(design, _)| seen.insert(*design)).map(|(design, value)| (design as f64, value)).collect()
}
