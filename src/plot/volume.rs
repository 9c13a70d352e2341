//! Grasp-state volumes as slices (thesis Figs. 3.4 and A.1–A.11): a row of panels for each friction coefficient, a
//! panel for each φ22 with l21 to the right and r_l upwards. The unstable region is dark; the stable region is coloured
//! by a quantity.

use super::axis::Axis as Ticks;
use super::canvas::{
    TITLE_HEIGHT, WIDTH, colour_key, picture, text_centred, text_left_of, text_right_of, tile_border, tiles,
};
use super::colours::Scale;
use super::svg::{Pixel, Svg};
use super::theme::{Colour, INK, PAPER, SOFT, UNSTABLE};
use crate::format;
use crate::study::volume::{Axes, Axis, Cell, Quantity, Volume, cells, intersection_cells, percent};

/// Maximum number of panels side by side.
const MAX_COLUMNS: usize = 5;
/// Height of the φ22 values above the panels, in pixels.
const HEADER_HEIGHT: f64 = 30.0;
/// Height of the tick labels and the axis label below the panels, in pixels.
const FOOTER_HEIGHT: f64 = 58.0;
/// Width of the row labels left of the panels, in pixels.
const LEFT_MARGIN: f64 = 118.0;
/// Gap between adjacent panels, in pixels.
const PANEL_GAP: f64 = 10.0;
/// Width of the colour bar with its labels, in pixels.
const COLOUR_BAR_WIDTH: f64 = 112.0;
/// Margin right of the colour bar, in pixels.
const RIGHT_MARGIN: f64 = 14.0;
/// Height of the legend at the bottom, in pixels.
const LEGEND_HEIGHT: f64 = 34.0;
/// Text size, in pixels.
const TEXT_SIZE: f64 = 14.0;
/// Size of tick labels and percentages, in pixels.
const SMALL_TEXT_SIZE: f64 = 13.0;

/// One row of panels.
struct Row {
    mu_static: f64,
    cells: Vec<Cell>,
}

/// Draws the slices of one base, with a row for each friction coefficient.
pub fn volume_slices(volumes: &[&Volume], quantity: Quantity) -> String {
    let Some(first) = volumes.first() else { return picture("", TITLE_HEIGHT, |_| {}) };
    let rows = volumes.iter().map(|v| Row { mu_static: v.mu_static, cells: cells(v, quantity) }).collect();
    let base = format!("base {} mm", format_short(first.base_m * 1e3));
    draw(&first.axes, rows, quantity, &format!("Grasp-state volume, {base}: {}", quantity.name()))
}

/// Draws the slices of the intersection over bases; `frictions` has the volumes of all bases for each friction
/// coefficient.
pub fn intersection_slices(frictions: &[Vec<&Volume>], quantity: Quantity) -> String {
    let Some(first) = frictions.first().and_then(|bases| bases.first()) else {
        return picture("", TITLE_HEIGHT, |_| {});
    };
    let row = |bases: &Vec<&Volume>| {
        Some(Row { mu_static: bases.first()?.mu_static, cells: intersection_cells(bases, quantity) })
    };
    let bases = frictions.first().map_or(0, Vec::len);
    let of = match quantity {
        Quantity::FormClosed => "form closure at all of them".to_string(),
        _ => format!("worst {} of them", quantity.name()),
    };
    let title = format!("Grasp-state volume, stable at all {bases} bases: {of}");
    draw(&first.axes, frictions.iter().filter_map(row).collect(), quantity, &title)
}

/// Layout of the panels, in pixels.
struct Layout {
    slices: Vec<usize>,
    panel_size: f64,
    rows: usize,
}

impl Layout {
    fn corner(&self, row: usize, column: usize) -> Pixel {
        [
            LEFT_MARGIN + (self.panel_size + PANEL_GAP) * column as f64,
            HEADER_HEIGHT + (self.panel_size + PANEL_GAP) * row as f64,
        ]
    }

    /// Lower right corner of the panels.
    fn end(&self) -> Pixel {
        self.corner(self.rows - 1, self.slices.len() - 1).map(|corner| corner + self.panel_size)
    }
}

fn draw(axes: &Axes, rows: Vec<Row>, quantity: Quantity, title: &str) -> String {
    let slices = axes.phi22_rad.spaced_indices(MAX_COLUMNS);
    let available_width = WIDTH - LEFT_MARGIN - RIGHT_MARGIN - COLOUR_BAR_WIDTH - PANEL_GAP * (MAX_COLUMNS - 1) as f64;
    let layout = Layout { slices, panel_size: (available_width / MAX_COLUMNS as f64).floor(), rows: rows.len() };
    let [right, below] = layout.end();
    let values = rows.iter().flat_map(|row| row.cells.iter().filter_map(|cell| cell.value()));
    let scale = match quantity {
        Quantity::FormClosed => Scale::Flag,
        _ => Scale::from_values(values, quantity == Quantity::Pfp),
    };
    picture(title, TITLE_HEIGHT + below + FOOTER_HEIGHT + LEGEND_HEIGHT, |svg| {
        for (column, &slice) in layout.slices.iter().enumerate() {
            let [x, _] = layout.corner(0, column);
            let degrees = format_short(axes.phi22_rad.value(slice).to_degrees());
            text_centred(
                svg,
                &format!("φ22 = {degrees}°"),
                [x + 0.5 * layout.panel_size, HEADER_HEIGHT - 13.0],
                TEXT_SIZE + 1.0,
                INK,
            );
            for (part, text) in axis_labels(&axes.l21_fraction) {
                text_centred(svg, &text, [x + part * layout.panel_size, below + 14.0], SMALL_TEXT_SIZE, INK);
            }
        }
        for (index, row) in rows.iter().enumerate() {
            let [x, y] = layout.corner(index, 0);
            let stable = row.cells.iter().filter(|cell| matches!(cell, Cell::Stable(_))).count();
            let middle = y + 0.5 * layout.panel_size;
            text_right_of(
                svg,
                &format!("μ_s = {}", format_short(row.mu_static)),
                [8.0, middle - 12.0],
                TEXT_SIZE + 1.0,
                INK,
            );
            let share = format!("{:.1} %", percent(stable, row.cells.len()));
            text_right_of(svg, &share, [8.0, middle + 8.0], SMALL_TEXT_SIZE, SOFT);
            text_right_of(svg, "stable", [8.0, middle + 24.0], SMALL_TEXT_SIZE, SOFT);
            for (part, text) in axis_labels(&axes.arm_ratio) {
                text_left_of(svg, &text, [x - 6.0, y + (1.0 - part) * layout.panel_size], SMALL_TEXT_SIZE, INK);
            }
            for (column, &slice) in layout.slices.iter().enumerate() {
                panel(svg, axes, &row.cells, slice, &scale, layout.corner(index, column), layout.panel_size);
            }
        }
        text_centred(svg, "l21 within its range", [0.5 * (LEFT_MARGIN + right), below + 40.0], TEXT_SIZE, INK);
        text_right_of(svg, "r_l", [LEFT_MARGIN - 24.0, HEADER_HEIGHT - 13.0], TEXT_SIZE, INK);
        draw_colour_bar(svg, quantity, &scale, right + 22.0, below);
        legend(svg, &rows, below + FOOTER_HEIGHT);
    })
}

/// Draws one slice; equal adjacent cells along l21 form one tile.
fn panel(svg: &mut Svg, axes: &Axes, cells: &[Cell], slice: usize, scale: &Scale, [left, top]: Pixel, panel_size: f64) {
    let [columns, _, rows] = axes.resolution();
    let edge = |index: usize, of: usize| panel_size * index as f64 / of as f64;
    let mut tiles_to_draw = Vec::new();
    for arm in 0..rows {
        let (high, low) = (top + panel_size - edge(arm + 1, rows), top + panel_size - edge(arm, rows));
        let mut from = 0;
        while from < columns {
            let fill = |column: usize| colour(cells[axes.index([column, slice, arm])], scale);
            let to = (from + 1..columns).find(|&next| fill(next) != fill(from)).unwrap_or(columns);
            tiles_to_draw.push(([[left + edge(from, columns), high], [left + edge(to, columns), low]], fill(from)));
            from = to;
        }
    }
    tiles(svg, tiles_to_draw);
    tile_border(svg, [[left, top], [left + panel_size, top + panel_size]], SOFT);
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
    let middle = 0.5 * (axis.from + axis.to);
    match axis.points {
        1 => vec![(0.5, format_short(middle))],
        2 => vec![(half, format_short(axis.from)), (1.0 - half, format_short(axis.to))],
        _ => vec![(half, format_short(axis.from)), (0.5, format_short(middle)), (1.0 - half, format_short(axis.to))],
    }
}

/// Draws the colour bar.
fn draw_colour_bar(svg: &mut Svg, quantity: Quantity, scale: &Scale, left: f64, below: f64) {
    let format::Quantity { unit, scale: factor, .. } = format::Quantity::for_column(quantity.column());
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
    tile_border(svg, [[left, y(1.0)], [right, y(0.0)]], SOFT);
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
fn legend(svg: &mut Svg, rows: &[Row], top: f64) {
    let any = |kind: Cell| rows.iter().any(|row| row.cells.contains(&kind));
    let entries = [
        (Cell::Unstable, UNSTABLE, "not stable: a phalanx would have to pull"),
        (Cell::NoFinger, PAPER, "no such finger"),
    ];
    let entries_present = entries.into_iter().filter(|(cell, ..)| any(*cell)).map(|(_, fill, text)| (fill, text));
    colour_key(svg, [LEFT_MARGIN, top + 8.0], entries_present, TEXT_SIZE);
}

/// Formats a number with up to four digits, without trailing zeros.
fn format_short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = if value.abs() >= 10.0 { format!("{value:.2}") } else { text };
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}
