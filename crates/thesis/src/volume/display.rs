//! Grasp-state volumes as slices.

use super::counts::{Cell, Counts, cells};
use super::point::Quantity;
use super::{Axes, Axis, Volume};
use crate::plot::canvas::{TITLE_HEIGHT, colour_key, picture, text_centred, text_left_of, text_right_of, tiles};
use crate::plot::chart::Axis as Ticks;
use crate::plot::svg::{Paint, Pixel, Svg};
use crate::plot::theme::{Colour, INK, PAPER, SOFT, Scale, UNSTABLE};
use crate::text::{column_unit, short};

/// Maximum number of panels side by side.
const MAX_COLUMNS: usize = 5;
const HEADER_HEIGHT: f64 = 30.0;
const FOOTER_HEIGHT: f64 = 58.0;
const LEFT_MARGIN: f64 = 118.0;
const PANEL_GAP: f64 = 10.0;
/// Five panels, the margin and the colour bar fit the width of the picture.
const PANEL_SIZE: f64 = 135.0;
const LEGEND_HEIGHT: f64 = 34.0;
const TEXT_SIZE: f64 = 14.0;
/// Size of tick labels and percentages.
const SMALL_TEXT_SIZE: f64 = 13.0;

/// Draws volumes as slices (thesis Figs. 3.4 and A.1–A.11). There is a panel for each φ22, in which l21 increases to
/// the right and r_l upwards. The unstable region is dark; the stable region is coloured by a quantity.
///
/// `frictions` has one row for each friction coefficient. A row contains one volume, or volumes that differ in their
/// base; the latter are drawn as their intersection.
pub fn slices(frictions: &[Vec<&Volume>], quantity: Quantity) -> String {
    let Some(first) = frictions.first().and_then(|volumes| volumes.first()) else {
        return picture("", TITLE_HEIGHT, |_| {});
    };
    let [.., name] = quantity.names();
    let region = match frictions[0].len() {
        1 => format!("base {} mm: {name}", format_short(first.base_m * 1e3)),
        bases if quantity == Quantity::FormClosed => {
            format!("stable at all {bases} bases: form closure at all of them")
        }
        bases => format!("stable at all {bases} bases: worst {name} of them"),
    };
    // Friction coefficient and cells of each row.
    let rows: Vec<(f64, Vec<Cell>)> =
        frictions.iter().map(|volumes| (volumes[0].mu_static, cells(volumes, quantity))).collect();
    let axes = &first.axes;
    let columns = axes.phi22_rad.spaced_indices(MAX_COLUMNS);
    let x = |column: usize| LEFT_MARGIN + (PANEL_SIZE + PANEL_GAP) * column as f64;
    let y = |row: usize| HEADER_HEIGHT + (PANEL_SIZE + PANEL_GAP) * row as f64;
    let (right, below) = (x(columns.len() - 1) + PANEL_SIZE, y(rows.len() - 1) + PANEL_SIZE);
    let values = rows.iter().flat_map(|(_, cells)| cells.iter().filter_map(|cell| cell.value()));
    let scale = match quantity {
        Quantity::FormClosed => Scale::Flag,
        _ => Scale::from_values(values, quantity == Quantity::Pfp),
    };
    let title = format!("Grasp-state volume, {region}");
    picture(&title, TITLE_HEIGHT + below + FOOTER_HEIGHT + LEGEND_HEIGHT, |svg| {
        for (column, &slice) in columns.iter().enumerate() {
            let phi22 = format!("φ22 = {}°", format_short(axes.phi22_rad.value(slice).to_degrees()));
            let middle = x(column) + 0.5 * PANEL_SIZE;
            text_centred(svg, &phi22, [middle, HEADER_HEIGHT - 13.0], TEXT_SIZE + 1.0, INK);
            for (part, text) in axis_labels(&axes.l21_fraction) {
                text_centred(svg, &text, [x(column) + part * PANEL_SIZE, below + 14.0], SMALL_TEXT_SIZE, INK);
            }
        }
        for (row, (mu_static, cells)) in rows.iter().enumerate() {
            let stable = cells.iter().filter(|cell| matches!(cell, Cell::Stable(_))).count();
            let counts = Counts { points: cells.len(), ..Counts::default() };
            let middle = y(row) + 0.5 * PANEL_SIZE;
            let mu = format!("μ_s = {}", format_short(*mu_static));
            text_right_of(svg, &mu, [8.0, middle - 12.0], TEXT_SIZE + 1.0, INK);
            let share = format!("{:.1} %", counts.percent(stable));
            text_right_of(svg, &share, [8.0, middle + 8.0], SMALL_TEXT_SIZE, SOFT);
            text_right_of(svg, "stable", [8.0, middle + 24.0], SMALL_TEXT_SIZE, SOFT);
            for (part, text) in axis_labels(&axes.arm_ratio) {
                let position = [LEFT_MARGIN - 6.0, y(row) + (1.0 - part) * PANEL_SIZE];
                text_left_of(svg, &text, position, SMALL_TEXT_SIZE, INK);
            }
            for (column, &slice) in columns.iter().enumerate() {
                panel(svg, axes, cells, slice, &scale, [x(column), y(row)]);
            }
        }
        text_centred(svg, "l21 within its range", [0.5 * (LEFT_MARGIN + right), below + 40.0], TEXT_SIZE, INK);
        text_right_of(svg, "r_l", [LEFT_MARGIN - 24.0, HEADER_HEIGHT - 13.0], TEXT_SIZE, INK);
        draw_colour_bar(svg, quantity, &scale, right + 22.0, below);
        legend(svg, &rows, below + FOOTER_HEIGHT);
    })
}

/// Draws one slice; equal adjacent cells along l21 form one tile.
fn panel(svg: &mut Svg, axes: &Axes, cells: &[Cell], slice: usize, scale: &Scale, [left, top]: Pixel) {
    let [columns, _, rows] = axes.resolution();
    let edge = |index: usize, of: usize| PANEL_SIZE * index as f64 / of as f64;
    let mut tiles_to_draw = Vec::new();
    for arm in 0..rows {
        let (high, low) = (top + PANEL_SIZE - edge(arm + 1, rows), top + PANEL_SIZE - edge(arm, rows));
        let mut from = 0;
        while from < columns {
            let fill = |column: usize| colour(cells[axes.index([column, slice, arm])], scale);
            let to = (from + 1..columns).find(|&next| fill(next) != fill(from)).unwrap_or(columns);
            tiles_to_draw.push(([[left + edge(from, columns), high], [left + edge(to, columns), low]], fill(from)));
            from = to;
        }
    }
    tiles(svg, tiles_to_draw);
    svg.rectangle([[left, top], [left + PANEL_SIZE, top + PANEL_SIZE]], Paint::line(SOFT, 1.0));
}

fn colour(cell: Cell, scale: &Scale) -> Colour {
    match cell {
        Cell::NoFinger => PAPER,
        Cell::Unstable => UNSTABLE,
        Cell::Stable(value) => scale.colour(value),
    }
}

/// Positions of the first, the middle and the last value of an axis on a panel, at the centres of their tiles, and
/// their labels.
fn axis_labels(axis: &Axis) -> Vec<(f64, String)> {
    let half = 0.5 / axis.points as f64;
    let all = [(half, axis.from), (0.5, 0.5 * (axis.from + axis.to)), (1.0 - half, axis.to)];
    let shown: &[usize] = match axis.points {
        1 => &[1],
        2 => &[0, 2],
        _ => &[0, 1, 2],
    };
    shown.iter().map(|&index| (all[index].0, format_short(all[index].1))).collect()
}

/// Draws the colour bar.
fn draw_colour_bar(svg: &mut Svg, quantity: Quantity, scale: &Scale, left: f64, below: f64) {
    let (unit, factor) = column_unit(quantity.names()[1]);
    let (top, right, label_left) = (HEADER_HEIGHT, left + 20.0, left + 26.0);
    if *scale == Scale::Flag {
        for (y, value, text) in [(top + 9.0, 1.0, "closed"), (top + 35.0, 0.0, "not closed")] {
            colour_key(svg, [left, y], [(scale.colour(value), text)], SMALL_TEXT_SIZE);
        }
        return;
    }
    let [from, to] = scale.range();
    text_right_of(svg, unit, [left, top - 13.0], TEXT_SIZE, INK);
    let height = (below - top).min(330.0);
    let y = |part: f64| top + height * (1.0 - part);
    let steps = 80;
    let step = |step: i32| {
        let part = |step: i32| f64::from(step) / f64::from(steps);
        let value = from + (to - from) * (part(step) + 0.5 / f64::from(steps));
        ([[left, y(part(step + 1))], [right, y(part(step))]], scale.colour(value))
    };
    tiles(svg, (0..steps).map(step));
    svg.rectangle([[left, y(1.0)], [right, y(0.0)]], Paint::line(SOFT, 1.0));
    let ticks = Ticks::from_range("", from * factor, to * factor);
    for &tick in &ticks.ticks {
        let fraction = (tick / factor - from) / (to - from);
        // The lower end of a signed scale has its own label.
        if !matches!(scale, Scale::Signed { .. }) || y(0.0) - y(fraction) > 16.0 {
            text_right_of(svg, &ticks.tick_label(tick), [label_left, y(fraction)], SMALL_TEXT_SIZE, INK);
        }
    }
    if let Scale::Signed { limit } = scale {
        let text = format!("≤ −{}", format_short((limit * factor * 10.0).round() / 10.0));
        text_right_of(svg, &text, [label_left, y(0.0)], SMALL_TEXT_SIZE, INK);
    }
}

/// Draws the legend of cells without a value.
fn legend(svg: &mut Svg, rows: &[(f64, Vec<Cell>)], top: f64) {
    let any = |kind: Cell| rows.iter().any(|(_, cells)| cells.contains(&kind));
    let entries = [
        (Cell::Unstable, UNSTABLE, "not stable: a phalanx would have to pull"),
        (Cell::NoFinger, PAPER, "no such finger"),
    ];
    let entries_present = entries.into_iter().filter(|(cell, ..)| any(*cell)).map(|(_, fill, text)| (fill, text));
    colour_key(svg, [LEFT_MARGIN, top + 8.0], entries_present, TEXT_SIZE);
}

/// Formats a number with up to four digits, without trailing zeros.
fn format_short(value: f64) -> String {
    short(value, if value.abs() >= 10.0 { 2 } else { 3 }).replace('-', "−")
}
