//! What was varied and what follows from it, by design (Figs. 4.1, 4.2).

use plotters::style::RGBColor;

use super::criteria::designs;
use crate::plot::axis::Axis;
use crate::plot::canvas::{BLACK, BLUE, DrawError, GREEN, Mark, frame, picture, point, titled, words_from};
use crate::study::select::Selection;
use crate::table::{Table, Value};
use crate::wording::Quantity;

const TITLE: u32 = 40;
const HEAD: u32 = 24;
const PANEL: u32 = 74;
const FOOT: u32 = 44;

/// What follows from a design, if the results have it.
const DEPENDENT: [&str; 8] =
    ["l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "trajectory_rad", "motor_n_m", "spring_n_m"];

/// A column of the results, its colour, and (design, shown value).
type Panel = (usize, RGBColor, Vec<(f64, f64)>);

/// The picture: a panel for every axis that is not part of the conditions, and one for each figure that follows.
pub fn selection_variables(title: &str, results: &Table, selection: &Selection) -> Result<String, DrawError> {
    let varied = selection.axes.iter().filter(|axis| !axis.again && axis.values.len() > 1);
    let varied = varied.filter_map(|axis| Some((results.find(&axis.column)?, BLUE)));
    let dependent = DEPENDENT.iter().filter_map(|name| Some((results.find(name)?, GREEN)));
    let panels: Vec<Panel> = varied
        .chain(dependent)
        .map(|(column, colour)| (column, colour, points(results, selection, column)))
        .filter(|(_, _, points)| !points.is_empty())
        .collect();
    let designs = designs(selection);
    let (first, last) = (designs.first().copied().unwrap_or(0), designs.last().copied().unwrap_or(1));
    let x = Axis::over("design", first as f64 - 1.0, last as f64 + 1.0);
    picture(TITLE + (HEAD + PANEL) * panels.len() as u32 + FOOT, |area| {
        let mut rest = titled(area, &format!("{title}: the designs"))?;
        for (place, (column, colour, points)) in panels.iter().enumerate() {
            let foot = place + 1 == panels.len();
            let (of, below) = rest.split_vertically(HEAD + PANEL + if foot { FOOT } else { 0 });
            rest = below;
            let (head, body) = of.split_vertically(HEAD);
            let quantity = Quantity::of(&results.columns[*column].name);
            words_from(&head, &quantity.label(), (86, HEAD as i32 / 2 + 3), 14, BLACK)?;
            let mut y = Axis::linear("", points.iter().map(|point| point.1));
            thin_ticks(&mut y);
            let mut chart = frame(&body, &x, &y, foot)?;
            let mark = if points.len() > 4000 { Mark::Speck } else { Mark::SmallDot };
            for &at in points {
                point(&mut chart, at, mark, *colour)?;
            }
        }
        Ok(())
    })
}

/// Low panels have room for three figures or so.
fn thin_ticks(axis: &mut Axis) {
    if axis.ticks.len() > 3 {
        axis.ticks = axis.ticks.iter().copied().step_by(2).collect();
    }
}

/// (design, shown value) of the first run of every design that has one.
fn points(results: &Table, selection: &Selection, column: usize) -> Vec<(f64, f64)> {
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
