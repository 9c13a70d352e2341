//! Grasp-state volumes as slices (thesis Figs. 3.4 and A.1–A.11): a row of panels for each friction, a panel for each φ22, in
//! it l21 to the right and r_l upwards. The unstable region is dark, the stable one has the colour of a quantity.

use plotters::style::RGBColor;

use super::axis::Axis as Ticks;
use super::canvas::{
    Area, BLACK, DrawError, GREY, Pixel, WHITE, outline, picture, tile, tile_plain, titled, words, words_from, words_to,
};
use super::colours::{NO_FINGER, Scale, UNSTABLE};
use crate::study::volume::{Axes, Axis, Cell, Quantity, Volume, cells, intersection_cells, percent};

/// Most panels side by side.
const ACROSS: usize = 5;
/// Room for titles, heads, feet, labels and the colour bar, in pixels.
const TITLE: u32 = 40;
const HEAD: i32 = 30;
const FOOT: i32 = 58;
const LEFT: i32 = 118;
const GAP: i32 = 10;
const BAR: i32 = 112;
const RIGHT: i32 = 14;
const LEGEND: i32 = 34;
const TEXT: u32 = 14;
const WIDTH: i32 = super::canvas::WIDTH as i32;

/// One row of panels.
struct Row {
    mu_static: f64,
    cells: Vec<Cell>,
}

/// The slices of one base, a row for each friction.
pub fn volume_slices(volumes: &[&Volume], quantity: Quantity) -> Result<String, DrawError> {
    let Some(first) = volumes.first() else { return picture(TITLE, |_| Ok(())) };
    let rows = volumes.iter().map(|v| Row { mu_static: v.mu_static, cells: cells(v, quantity) }).collect();
    let base = format!("base {} mm", short(first.base_m * 1e3));
    draw(&first.axes, rows, quantity, &format!("Grasp-state volume, {base}: {}", quantity.name()))
}

/// The slices of the intersection over bases: for each friction the volumes of all bases.
pub fn intersection_slices(frictions: &[Vec<&Volume>], quantity: Quantity) -> Result<String, DrawError> {
    let Some(first) = frictions.first().and_then(|bases| bases.first()) else { return picture(TITLE, |_| Ok(())) };
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
    side: i32,
    rows: i32,
}

impl Layout {
    fn corner(&self, row: i32, column: i32) -> Pixel {
        (LEFT + (self.side + GAP) * column, HEAD + (self.side + GAP) * row)
    }

    /// Where the panels end, on the right and below.
    fn end(&self) -> Pixel {
        let (x, y) = self.corner(self.rows - 1, self.slices.len() as i32 - 1);
        (x + self.side, y + self.side)
    }
}

fn draw(axes: &Axes, rows: Vec<Row>, quantity: Quantity, title: &str) -> Result<String, DrawError> {
    let slices = axes.phi22_rad.spread(ACROSS);
    let room = WIDTH - LEFT - RIGHT - BAR - GAP * (ACROSS as i32 - 1);
    let layout = Layout { slices, side: room / ACROSS as i32, rows: rows.len() as i32 };
    let (_, below) = layout.end();
    let height = TITLE as i32 + below + FOOT + LEGEND;
    let values = rows.iter().flat_map(|row| row.cells.iter().filter_map(|cell| cell.value()));
    let scale = match quantity {
        Quantity::FormClosed => Scale::Flag,
        _ => Scale::of(values, quantity == Quantity::Pfp),
    };
    picture(height as u32, |area| {
        let area = titled(area, title)?;
        for (column, &slice) in layout.slices.iter().enumerate() {
            let (x, _) = layout.corner(0, column as i32);
            let degrees = short(axes.phi22_rad.value(slice).to_degrees());
            words(&area, &format!("φ22 = {degrees}°"), (x + layout.side / 2, HEAD - 13), TEXT + 1, BLACK)?;
        }
        for (index, row) in rows.iter().enumerate() {
            let (x, y) = layout.corner(index as i32, 0);
            let stable = row.cells.iter().filter(|cell| matches!(cell, Cell::Stable(_))).count();
            let middle = y + layout.side / 2;
            words_from(&area, &format!("μ_s = {}", short(row.mu_static)), (8, middle - 12), TEXT + 1, BLACK)?;
            let share = format!("{:.1} %", percent(stable, row.cells.len()));
            words_from(&area, &share, (8, middle + 8), TEXT - 1, GREY)?;
            words_from(&area, "stable", (8, middle + 24), TEXT - 1, GREY)?;
            upright(&area, &axes.arm_ratio, (x, y), layout.side)?;
            for (column, &slice) in layout.slices.iter().enumerate() {
                let corner = layout.corner(index as i32, column as i32);
                panel(&area, axes, &row.cells, slice, &scale, corner, layout.side)?;
            }
        }
        for column in 0..layout.slices.len() as i32 {
            level(&area, &axes.l21_fraction, (layout.corner(0, column).0, below), layout.side)?;
        }
        let middle = (LEFT + layout.end().0) / 2;
        words(&area, "l21 within its range", (middle, below + 40), TEXT, BLACK)?;
        words_from(&area, "r_l", (LEFT - 24, HEAD - 13), TEXT, BLACK)?;
        bar(&area, quantity, &scale, layout.end().0 + 22, below)?;
        legend(&area, &rows, below + FOOT)
    })
}

/// One slice: equal neighbours along l21 are one tile.
fn panel(
    area: &Area,
    axes: &Axes,
    cells: &[Cell],
    slice: usize,
    scale: &Scale,
    (left, top): Pixel,
    side: i32,
) -> Result<(), DrawError> {
    let [columns, _, rows] = axes.resolution();
    let edge = |index: usize, of: usize| (f64::from(side) * index as f64 / of as f64).round() as i32;
    for arm in 0..rows {
        let (high, low) = (top + side - edge(arm + 1, rows), top + side - edge(arm, rows));
        let mut from = 0;
        while from < columns {
            let fill = |column: usize| colour(cells[axes.index([column, slice, arm])], scale);
            let to = (from + 1..columns).find(|&next| fill(next) != fill(from)).unwrap_or(columns);
            let corners = [(left + edge(from, columns), high), (left + edge(to, columns), low)];
            tile_plain(area, corners, fill(from))?;
            from = to;
        }
    }
    outline(area, [(left, top), (left + side, top + side)], GREY)
}

fn colour(cell: Cell, scale: &Scale) -> RGBColor {
    match cell {
        Cell::NoFinger => NO_FINGER,
        Cell::Unstable => UNSTABLE,
        Cell::Stable(value) => scale.colour(value),
    }
}

/// Figures at the left of a panel.
fn upright(area: &Area, axis: &Axis, (left, top): Pixel, side: i32) -> Result<(), DrawError> {
    for (part, text) in marks(axis) {
        let y = top + side - (part * f64::from(side)).round() as i32;
        words_to(area, &text, (left - 6, y), TEXT - 1, BLACK)?;
    }
    Ok(())
}

/// Figures below a panel.
fn level(area: &Area, axis: &Axis, (left, top): Pixel, side: i32) -> Result<(), DrawError> {
    for (part, text) in marks(axis) {
        words(area, &text, (left + (part * f64::from(side)).round() as i32, top + 14), TEXT - 1, BLACK)?;
    }
    Ok(())
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
fn bar(area: &Area, quantity: Quantity, scale: &Scale, left: i32, below: i32) -> Result<(), DrawError> {
    let (unit, factor) = quantity.shown();
    let (top, wide) = (HEAD, 20);
    if *scale == Scale::Flag {
        for (row, (value, text)) in [(1.0, "closed"), (0.0, "not closed")].into_iter().enumerate() {
            let y = top + 26 * row as i32;
            tile(area, [(left, y), (left + wide, y + 18)], scale.colour(value), GREY)?;
            words_from(area, text, (left + wide + 6, y + 9), TEXT - 1, BLACK)?;
        }
        return Ok(());
    }
    let [from, to] = scale.ends();
    words_from(area, unit, (left, top - 13), TEXT, BLACK)?;
    let tall = f64::from((below - top).min(330));
    let steps = 80;
    let y = |part: f64| top + (tall * (1.0 - part)).round() as i32;
    for step in 0..steps {
        let part = |step: i32| f64::from(step) / f64::from(steps);
        let value = from + (to - from) * (part(step) + 0.5 / f64::from(steps));
        tile_plain(area, [(left, y(part(step + 1))), (left + wide, y(part(step)))], scale.colour(value))?;
    }
    outline(area, [(left, y(1.0)), (left + wide, y(0.0))], GREY)?;
    let ticks = Ticks::over("", from * factor, to * factor);
    for &tick in &ticks.ticks {
        let at = (tick / factor - from) / (to - from);
        let beyond = matches!(scale, Scale::Signed { .. }) && at < 0.04;
        if !beyond {
            words_from(area, &ticks.text(tick), (left + wide + 6, y(at)), TEXT - 1, BLACK)?;
        }
    }
    if let Scale::Signed { limit } = scale {
        let text = format!("≤ −{}", short((limit * factor * 10.0).round() / 10.0));
        words_from(area, &text, (left + wide + 6, y(0.0)), TEXT - 1, BLACK)?;
    }
    Ok(())
}

/// What has no place on the bar.
fn legend(area: &Area, rows: &[Row], top: i32) -> Result<(), DrawError> {
    let any = |wanted: Cell| rows.iter().any(|row| row.cells.contains(&wanted));
    let entries = [
        (Cell::Unstable, UNSTABLE, "not stable: a phalanx would have to pull"),
        (Cell::NoFinger, WHITE, "no such finger"),
    ];
    let mut x = LEFT;
    for (_, fill, text) in entries.into_iter().filter(|(cell, ..)| any(*cell)) {
        tile(area, [(x, top), (x + 22, top + 16)], fill, GREY)?;
        words_from(area, text, (x + 30, top + 8), TEXT, BLACK)?;
        x += 330;
    }
    Ok(())
}

/// A number of up to four digits without needless zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = if value.abs() >= 10.0 { format!("{value:.2}") } else { text };
    text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
}
