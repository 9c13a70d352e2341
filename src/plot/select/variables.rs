//! What was varied and what follows from it, by design (Figs. 4.1, 4.2).

use super::criteria::designs;
use crate::plot::axis::Axis;
use crate::plot::canvas::{Area, FOOT, HEAD as TITLE, Mark, WIDTH, frame, picture, points, words_from};
use crate::plot::theme::{BLUE, Colour, GREEN, INK};
use crate::study::select::Selection;
use crate::table::{Table, Value};
use crate::wording::Quantity;

const HEAD: f64 = 24.0;
const PANEL: f64 = 74.0;

/// What follows from a design, if the results have it.
const DEPENDENT: [&str; 8] =
    ["l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "trajectory_rad", "motor_n_m", "spring_n_m"];

/// A column of the results, its colour, and (design, shown value).
type Panel = (usize, Colour, Vec<(f64, f64)>);

/// The picture: a panel for every axis that is not part of the conditions, and one for each figure that follows.
pub fn selection_variables(title: &str, results: &Table, selection: &Selection) -> String {
    let varied = selection.axes.iter().filter(|axis| !axis.again && axis.values.len() > 1);
    let varied = varied.filter_map(|axis| Some((results.find(&axis.column)?, BLUE)));
    let dependent = DEPENDENT.iter().filter_map(|name| Some((results.find(name)?, GREEN)));
    let panels: Vec<Panel> = varied
        .chain(dependent)
        .map(|(column, colour)| (column, colour, values(results, selection, column)))
        .filter(|(.., values)| !values.is_empty())
        .collect();
    let designs = designs(selection);
    let (first, last) = (designs.first().copied().unwrap_or(0), designs.last().copied().unwrap_or(1));
    let x = Axis::over("design", first as f64 - 1.0, last as f64 + 1.0);
    let height = TITLE + (HEAD + PANEL) * panels.len() as f64 + FOOT;
    picture(&format!("{title}: the designs"), height, |svg| {
        for (place, (column, colour, values)) in panels.iter().enumerate() {
            let foot = place + 1 == panels.len();
            let top = (HEAD + PANEL) * place as f64 + HEAD;
            let label = Quantity::of(&results.columns[*column].name).label();
            words_from(svg, &label, [86.0, top - 0.5 * HEAD + 3.0], 14.0, INK);
            let mut y = Axis::linear("", values.iter().map(|point| point.1));
            thin_ticks(&mut y);
            let area = Area { left: 0.0, top, width: WIDTH, height: PANEL + if foot { FOOT } else { 0.0 } };
            let on = frame(svg, area, &x, &y, foot);
            let mark = if values.len() > 4000 { Mark::Speck } else { Mark::SmallDot };
            points(svg, &on, values.iter().copied(), mark, *colour);
        }
    })
}

/// Low panels have room for three figures or so.
fn thin_ticks(axis: &mut Axis) {
    if axis.ticks.len() > 3 {
        axis.ticks = axis.ticks.iter().copied().step_by(2).collect();
    }
}

/// (design, shown value) of the first run of every design that has one.
fn values(results: &Table, selection: &Selection, column: usize) -> Vec<(f64, f64)> {
    let scale = Quantity::of(&results.columns[column].name).scale;
    let mut seen = std::collections::HashSet::new();
    let value = |row: usize| match results.rows[row][column] {
        Value::Number(value) if value.is_finite() => Some(value * scale),
        Value::Integer(value) => Some(value as f64 * scale),
        _ => None,
    };
    let there = selection.runs.iter().filter_map(|run| Some((run.design, value(run.row)?)));
    there.filter(|(design, _)| seen.insert(*design)).map(|(design, value)| (design as f64, value)).collect()
}
