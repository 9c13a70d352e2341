//! Varied and dependent quantities by design (thesis Figs. 4.1, 4.2).

use super::criteria::design_numbers;
use crate::format::Quantity;
use crate::plot::axis::Axis;
use crate::plot::canvas::{AXIS_HEIGHT, Area, Marker, TITLE_HEIGHT, WIDTH, frame, picture, points, text_right_of};
use crate::plot::theme::{BLUE, Colour, GREEN, INK};
use crate::study::select::Selection;
use crate::table::{Table, Value};

const HEADER_HEIGHT: f64 = 24.0;
const PANEL_HEIGHT: f64 = 74.0;

/// Dependent quantities of a design; those missing in the results are omitted.
const DEPENDENT: [&str; 8] =
    ["l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "trajectory_rad", "motor_n_m", "spring_n_m"];

/// A column of the results, its colour, and points (design, displayed value).
type Panel = (usize, Colour, Vec<(f64, f64)>);

/// Draws a panel for every axis that is not part of the conditions, and one for each dependent quantity.
pub fn selection_variables(title: &str, results: &Table, selection: &Selection) -> String {
    let varied = selection.axes.iter().filter(|axis| !axis.varies_within_design && axis.values.len() > 1);
    let varied = varied.filter_map(|axis| Some((results.find(&axis.column)?, BLUE)));
    let dependent = DEPENDENT.iter().filter_map(|name| Some((results.find(name)?, GREEN)));
    let panels: Vec<Panel> = varied
        .chain(dependent)
        .map(|(column, colour)| (column, colour, values(results, selection, column)))
        .filter(|(.., values)| !values.is_empty())
        .collect();
    let design_numbers = design_numbers(selection);
    let (first, last) = (design_numbers.first().copied().unwrap_or(0), design_numbers.last().copied().unwrap_or(1));
    let x = Axis::from_range("design", first as f64 - 1.0, last as f64 + 1.0);
    let height = TITLE_HEIGHT + (HEADER_HEIGHT + PANEL_HEIGHT) * panels.len() as f64 + AXIS_HEIGHT;
    picture(&format!("{title}: the designs"), height, |svg| {
        for (index, (column, colour, values)) in panels.iter().enumerate() {
            let is_last = index + 1 == panels.len();
            let top = (HEADER_HEIGHT + PANEL_HEIGHT) * index as f64 + HEADER_HEIGHT;
            let label = Quantity::for_column(&results.columns[*column].name).label();
            text_right_of(svg, &label, [86.0, top - 0.5 * HEADER_HEIGHT + 3.0], 14.0, INK);
            let mut y = Axis::linear("", values.iter().map(|point| point.1));
            reduce_ticks(&mut y);
            let area =
                Area { left: 0.0, top, width: WIDTH, height: PANEL_HEIGHT + if is_last { AXIS_HEIGHT } else { 0.0 } };
            let frame = frame(svg, area, &x, &y, is_last);
            let marker = if values.len() > 4000 { Marker::TinyDot } else { Marker::SmallDot };
            points(svg, &frame, values.iter().copied(), marker, *colour);
        }
    })
}

/// Reduces the ticks to about three, for low panels.
fn reduce_ticks(axis: &mut Axis) {
    if axis.ticks.len() > 3 {
        axis.ticks = axis.ticks.iter().copied().step_by(2).collect();
    }
}

/// Points (design, displayed value) of the first run of every design that has a value.
fn values(results: &Table, selection: &Selection, column: usize) -> Vec<(f64, f64)> {
    let scale = Quantity::for_column(&results.columns[column].name).scale;
    let mut seen = std::collections::HashSet::new();
    let value = |row: usize| match results.rows[row][column] {
        Value::Number(value) if value.is_finite() => Some(value * scale),
        Value::Integer(value) => Some(value as f64 * scale),
        _ => None,
    };
    let with_value = selection.runs.iter().filter_map(|run| Some((run.design, value(run.row)?)));
    with_value.filter(|(design, _)| seen.insert(*design)).map(|(design, value)| (design as f64, value)).collect()
}
