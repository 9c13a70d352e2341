//! Grasp-state volumes as slices (thesis Figs. 3.4 and A.1–A.11): a row of panels for each friction, a panel for each φ22, in
//! it l21 to the right and r_l upwards. The unstable region is dark, the stable one has the colour of a quantity.

use super::axis::Axis as Ticks;
use super::canvas::{HEAD as TITLE, WIDTH, key, outline, picture, tiles, words, words_from, words_to};
use super::colours::Scale;
use super::svg::{Pixel, Svg};
use super::theme::{Colour, INK, PAPER, SOFT, UNSTABLE};
use crate::study::volume::{Axes, Axis, Cell, Quantity, Volume, cells, intersection_cells, percent};
use crate::wording;

/// Most panels side by side.
const ACROSS: usize = 5;
/// Room for titles, heads, feet, labels and the colour bar, in pixels.
const HEAD: f64 = 30.0;
const FOOT: f64 = 58.0;
const LEFT: f64 = 118.0;
const GAP: f64 = 10.0;
const BAR: f64 = 112.0;
const RIGHT: f64 = 14.0;
const LEGEND: f64 = 34.0;
const TEXT: f64 = 14.0;
const SMALL: f64 = 13.0;

/// One row of panels.
struct Row {
    mu_static: f64,
    cells: Vec<Cell>,
}

/// The slices of one base, a row for each friction.
pub fn volume_slices(volumes: &[&Volume], quantity: Quantity) -> String {
    let Some(first) = volumes.first() else { return picture("", TITLE, |_| {}) };
    let rows = volumes.iter().map(|v| Row { mu_static: v.mu_static, cells: cells(v, quantity) }).collect();
    let base = format!("base {} mm", short(first.base_m * 1e3));
    draw(&first.axes, rows, quantity, &format!("Grasp-state volume, {base}: {}", quantity.name()))
}

/// The slices of the intersection over bases: for each friction the volumes of all bases.
pub fn intersection_slices(frictions: &[Vec<&Volume>], quantity: Quantity) -> String {
    let Some(first) = frictions.first().and_then(|bases| bases.first()) else { return picture("", TITLE, |_| {}) };
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

/// Lengths in pixels that the panels share.
struct Layout {
    slices: Vec<usize>,
    side: f64,
    rows: usize,
}

impl Layout {
    fn corner(&self, row: usize, column: usize) -> Pixel {
        [LEFT + (self.side + GAP) * column as f64, HEAD + (self.side + GAP) * row as f64]
    }

    /// Where the panels end, on the right and below.
    fn end(&self) -> Pixel {
        self.corner(self.rows - 1, self.slices.len() - 1).map(|corner| corner + self.side)
    }
}

fn draw(axes: &Axes, rows: Vec<Row>, quantity: Quantity, title: &str) -> String {
    let slices = axes.phi22_rad.spread(ACROSS);
    let room = WIDTH - LEFT - RIGHT - BAR - GAP * (ACROSS - 1) as f64;
    let layout = Layout { slices, side: (room / ACROSS as f64).floor(), rows: rows.len() };
    let [right, below] = layout.end();
    let values = rows.iter().flat_map(|row| row.cells.iter().filter_map(|cell| cell.value()));
    let scale = match quantity {
        Quantity::FormClosed => Scale::Flag,
        _ => Scale::of(values, quantity == Quantity::Pfp),
    };
    picture(title, TITLE + below + FOOT + LEGEND, |svg| {
        for (column, &slice) in layout.slices.iter().enumerate() {
            let [x, _] = layout.corner(0, column);
            let degrees = short(axes.phi22_rad.value(slice).to_degrees());
            words(svg, &format!("φ22 = {degrees}°"), [x + 0.5 * layout.side, HEAD - 13.0], TEXT + 1.0, INK);
            for (part, text) in marks(&axes.l21_fraction) {
                words(svg, &text, [x + part * layout.side, below + 14.0], SMALL, INK);
            }
        }
        for (index, row) in rows.iter().enumerate() {
            let [x, y] = layout.corner(index, 0);
            let stable = row.cells.iter().filter(|cell| matches!(cell, Cell::Stable(_))).count();
            let middle = y + 0.5 * layout.side;
            words_from(svg, &format!("μ_s = {}", short(row.mu_static)), [8.0, middle - 12.0], TEXT + 1.0, INK);
            let share = format!("{:.1} %", percent(stable, row.cells.len()));
            words_from(svg, &share, [8.0, middle + 8.0], SMALL, SOFT);
            words_from(svg, "stable", [8.0, middle + 24.0], SMALL, SOFT);
            for (part, text) in marks(&axes.arm_ratio) {
                words_to(svg, &text, [x - 6.0, y + (1.0 - part) * layout.side], SMALL, INK);
            }
            for (column, &slice) in layout.slices.iter().enumerate() {
                panel(svg, axes, &row.cells, slice, &scale, layout.corner(index, column), layout.side);
            }
        }
        words(svg, "l21 within its range", [0.5 * (LEFT + right), below + 40.0], TEXT, INK);
        words_from(svg, "r_l", [LEFT - 24.0, HEAD - 13.0], TEXT, INK);
        bar(svg, quantity, &scale, right + 22.0, below);
        legend(svg, &rows, below + FOOT);
    })
}

/// One slice: equal neighbours along l21 are one tile.
fn panel(svg: &mut Svg, axes: &Axes, cells: &[Cell], slice: usize, scale: &Scale, [left, top]: Pixel, side: f64) {
    let [columns, _, rows] = axes.resolution();
    let edge = |index: usize, of: usize| side * index as f64 / of as f64;
    let mut drawn = Vec::new();
    for arm in 0..rows {
        let (high, low) = (top + side - edge(arm + 1, rows), top + side - edge(arm, rows));
        let mut from = 0;
        while from < columns {
            let fill = |column: usize| colour(cells[axes.index([column, slice, arm])], scale);
            let to = (from + 1..columns).find(|&next| fill(next) != fill(from)).unwrap_or(columns);
            drawn.push(([[left + edge(from, columns), high], [left + edge(to, columns), low]], fill(from)));
            from = to;
        }
    }
    tiles(svg, drawn);
    outline(svg, [[left, top], [left + side, top + side]], SOFT);
}

fn colour(cell: Cell, scale: &Scale) -> Colour {
    match cell {
        Cell::NoFinger => PAPER,
        Cell::Unstable => UNSTABLE,
        Cell::Stable(value) => scale.colour(value),
    }
}

/// Where the first, the middle and the last value of an axis lie on a panel: in the middle of their tiles.
fn marks(axis: &Axis) -> Vec<(f64, String)> {
    let half = 0.5 / axis.points as f64;
    let middle = 0.5 * (axis.from + axis.to);
    match axis.points {
        1 => vec![(0.5, short(middle))],
        2 => vec![(half, short(axis.from)), (1.0 - half, short(axis.to))],
        _ => vec![(half, short(axis.from)), (0.5, short(middle)), (1.0 - half, short(axis.to))],
    }
}

/// The colours and what they stand for.
fn bar(svg: &mut Svg, quantity: Quantity, scale: &Scale, left: f64, below: f64) {
    let wording::Quantity { unit, scale: factor, .. } = wording::Quantity::of(quantity.column());
    let (top, right, beside) = (HEAD, left + 20.0, left + 26.0);
    if *scale == Scale::Flag {
        for (y, value, text) in [(top + 9.0, 1.0, "closed"), (top + 35.0, 0.0, "not closed")] {
            key(svg, [left, y], [(scale.colour(value), text)], SMALL);
        }
        return;
    }
    let [from, to] = scale.ends();
    words_from(svg, unit, [left, top - 13.0], TEXT, INK);
    let tall = (below - top).min(330.0);
    let y = |part: f64| top + tall * (1.0 - part);
    let steps = 80;
    let step = |step: i32| {
        let part = |step: i32| f64::from(step) / f64::from(steps);
        let value = from + (to - from) * (part(step) + 0.5 / f64::from(steps));
        ([[left, y(part(step + 1))], [right, y(part(step))]], scale.colour(value))
    };
    tiles(svg, (0..steps).map(step));
    outline(svg, [[left, y(1.0)], [right, y(0.0)]], SOFT);
    let ticks = Ticks::over("", from * factor, to * factor);
    for &tick in &ticks.ticks {
        let at = (tick / factor - from) / (to - from);
        // The foot of a scale that goes both ways has a text of its own.
        if !matches!(scale, Scale::Signed { .. }) || y(0.0) - y(at) > 16.0 {
            words_from(svg, &ticks.text(tick), [beside, y(at)], SMALL, INK);
        }
    }
    if let Scale::Signed { limit } = scale {
        let text = format!("≤ −{}", short((limit * factor * 10.0).round() / 10.0));
        words_from(svg, &text, [beside, y(0.0)], SMALL, INK);
    }
}

/// What has no place on the bar.
fn legend(svg: &mut Svg, rows: &[Row], top: f64) {
    let any = |wanted: Cell| rows.iter().any(|row| row.cells.contains(&wanted));
    let entries = [
        (Cell::Unstable, UNSTABLE, "not stable: a phalanx would have to pull"),
        (Cell::NoFinger, PAPER, "no such finger"),
    ];
    let there = entries.into_iter().filter(|(cell, ..)| any(*cell)).map(|(_, fill, text)| (fill, text));
    key(svg, [LEFT, top + 8.0], there, TEXT);
}

/// A number of up to four digits without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = if value.abs() >= 10.0 { format!("{value:.2}") } else { text };
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}
