//! Map of verdicts: a panel for each damping factor, tiles over step size and stiffness, the angle error in each.

use plotters::style::RGBColor;

use super::canvas::{Area, BLACK, DrawError, GREY, Pixel, WHITE, picture, tile, titled, words, words_from};
use crate::study::stability::{Cell, Stability, Verdict};
use crate::wording::duration;

/// Panels side by side; their heads, feet and left margins; a row of tiles; the legend above them. In pixels.
const ACROSS: usize = 2;
const HEAD: i32 = 34;
const FOOT: i32 = 52;
const LEFT: i32 = 82;
const RIGHT: i32 = 14;
const ROW: i32 = 38;
const LEGEND: u32 = 40;
const TITLE: u32 = 40;
const TEXT: u32 = 14;
/// Width of a digit of a text of size 1, a little generous.
const DIGIT: f64 = 0.6;

/// The picture.
pub fn stability(study: &Stability) -> Result<String, DrawError> {
    let grid = &study.grid;
    let panels = grid.damping_factors.len();
    let across = ACROSS.min(panels);
    let down = panels.div_ceil(across);
    let panel = (HEAD + FOOT + ROW * grid.stiffness_factors.len() as i32) as u32;
    picture(TITLE + LEGEND + panel * down as u32, |area| {
        let rest = titled(area, &format!("{}: where the engine is stable, and where it is right", study.scene))?;
        let (head, rest) = rest.split_vertically(LEGEND);
        legend(&head, study)?;
        for (damping, area) in rest.split_evenly((down, across)).iter().take(panels).enumerate() {
            draw(area, study, damping)?;
        }
        Ok(())
    })
}

/// One panel: steps to the right from short to long, stiffness upwards.
fn draw(area: &Area, study: &Stability, damping: usize) -> Result<(), DrawError> {
    let grid = &study.grid;
    let (columns, rows) = (grid.steps_s.len() as i32, grid.stiffness_factors.len() as i32);
    let width = area.dim_in_pixel().0 as i32 - LEFT - RIGHT;
    let edge = |column: i32| LEFT + width * column / columns;
    let size = TEXT.min((f64::from(width / columns - 4) / (7.0 * DIGIT)) as u32);
    words(area, &format!("c_max × {}", factor(grid.damping_factors[damping])), (edge(0) + width / 2, 16), 16, BLACK)?;
    let foot = HEAD + ROW * rows;
    for (stiffness, &k) in grid.stiffness_factors.iter().enumerate() {
        let top = foot - ROW * (stiffness as i32 + 1);
        words(area, &format!("k × {}", factor(k)), (LEFT / 2 + 2, top + ROW / 2), TEXT, BLACK)?;
        for step in 0..grid.steps_s.len() {
            let column = columns - 1 - step as i32;
            let corners = [(edge(column), top), (edge(column + 1), top + ROW)];
            cell(area, study.cell(step, stiffness, damping), corners, size)?;
        }
    }
    for (step, &step_s) in grid.steps_s.iter().enumerate() {
        let column = columns - 1 - step as i32;
        words(area, &duration(step_s), ((edge(column) + edge(column + 1)) / 2, foot + 14), size, BLACK)?;
    }
    words(area, "step dt", (edge(0) + width / 2, foot + 34), TEXT, BLACK)
}

fn cell(area: &Area, cell: &Cell, corners: [Pixel; 2], size: u32) -> Result<(), DrawError> {
    let (fill, ink) = colours(cell.verdict);
    let [(left, top), (right, bottom)] = corners;
    tile(area, corners, fill, WHITE)?;
    let error = match (cell.verdict, cell.angle_error_rad) {
        (Verdict::NotJudged, _) => "–".to_string(),
        (Verdict::Failed, None) => "failed".to_string(),
        (_, Some(rad)) => format!("{rad:.1e}").replace('-', "−"),
        (_, None) => "∞".to_string(),
    };
    words(area, &error, ((left + right) / 2, (top + bottom) / 2), size, ink)
}

/// Verdicts with their colours, and what the figures are, in one line.
fn legend(area: &Area, study: &Stability) -> Result<(), DrawError> {
    let bound = format!("{:e} rad", study.accuracy_rad).replace('-', "−");
    let entries = [
        (Verdict::Accurate, format!("stable, within {bound}")),
        (Verdict::Inaccurate, "stable, inaccurate".to_string()),
        (Verdict::Failed, "failed".to_string()),
        (Verdict::NotJudged, "not judged".to_string()),
    ];
    let mut x = 16;
    for (verdict, text) in entries.iter().filter(|(verdict, _)| study.count(*verdict) > 0) {
        let width = (text.chars().count() as f64 * DIGIT * f64::from(TEXT)) as i32;
        tile(area, [(x, 8), (x + 26, 26)], colours(*verdict).0, GREY)?;
        words_from(area, text, (x + 34, 17), TEXT, BLACK)?;
        x += 34 + width + 18;
    }
    words_from(area, "figures: largest angle error, rad", (x + 16, 17), TEXT, BLACK)
}

/// Fill and text: three steps of lightness, so that they stay apart in grey and for every kind of eye.
fn colours(verdict: Verdict) -> (RGBColor, RGBColor) {
    match verdict {
        Verdict::Accurate => (RGBColor(206, 228, 245), BLACK),
        Verdict::Inaccurate => (RGBColor(230, 159, 0), BLACK),
        Verdict::Failed => (RGBColor(94, 24, 74), WHITE),
        Verdict::NotJudged => (WHITE, GREY),
    }
}

/// A factor as a power of ten where it is one beyond ten.
fn factor(value: f64) -> String {
    let plain = format!("{value}");
    if plain.len() > 4 { format!("{value:e}").replace('-', "−") } else { plain }
}
