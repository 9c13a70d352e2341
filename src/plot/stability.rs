//! Map of verdicts: a panel for each damping factor, tiles over step size and stiffness, the angle error in each.

use super::canvas::{HEAD as TITLE, WIDTH, key, picture, text_width, tile, words, words_from};
use super::svg::{Pixel, Svg};
use super::theme::{BROKEN, Colour, DOUBTFUL, FINE, INK, PAPER, SOFT};
use crate::study::stability::{Cell, Stability, Verdict};
use crate::wording::duration;

/// Panels side by side; their heads, feet and left margins; a row of tiles; the legend above them. In pixels.
const ACROSS: usize = 2;
const HEAD: f64 = 34.0;
const FOOT: f64 = 52.0;
const LEFT: f64 = 82.0;
const RIGHT: f64 = 14.0;
const ROW: f64 = 38.0;
const LEGEND: f64 = 40.0;
const TEXT: f64 = 14.0;

/// The picture.
pub fn stability(study: &Stability) -> String {
    let grid = &study.grid;
    let panels = grid.damping_factors.len();
    let across = ACROSS.min(panels);
    let panel = HEAD + FOOT + ROW * grid.stiffness_factors.len() as f64;
    let width = WIDTH / across as f64;
    let title = format!("{}: where the engine is stable, and where it is right", study.scene);
    picture(&title, TITLE + LEGEND + panel * panels.div_ceil(across) as f64, |svg| {
        legend(svg, study);
        for damping in 0..panels {
            let at = [width * (damping % across) as f64, LEGEND + panel * (damping / across) as f64];
            svg.moved(at, |svg| draw(svg, width, study, damping));
        }
    })
}

/// One panel, so wide: steps to the right from short to long, stiffness upwards.
fn draw(svg: &mut Svg, width: f64, study: &Stability, damping: usize) {
    let grid = &study.grid;
    let columns = grid.steps_s.len();
    let width = width - LEFT - RIGHT;
    let edge = |column: usize| LEFT + (width * column as f64 / columns as f64).round();
    let size = TEXT.min(((width / columns as f64 - 4.0) / text_width("0.0e−00", 1.0)).floor());
    let middle = LEFT + 0.5 * width;
    words(svg, &format!("c_max × {}", factor(grid.damping_factors[damping])), [middle, 16.0], 16.0, INK);
    let foot = HEAD + ROW * grid.stiffness_factors.len() as f64;
    for (stiffness, &k) in grid.stiffness_factors.iter().enumerate() {
        let top = foot - ROW * (stiffness + 1) as f64;
        words(svg, &format!("k × {}", factor(k)), [0.5 * LEFT + 2.0, top + 0.5 * ROW], TEXT, INK);
        for step in 0..columns {
            let corners = [[edge(columns - 1 - step), top], [edge(columns - step), top + ROW]];
            cell(svg, study.cell(step, stiffness, damping), corners, size);
        }
    }
    for (step, &step_s) in grid.steps_s.iter().enumerate() {
        let at = 0.5 * (edge(columns - 1 - step) + edge(columns - step));
        words(svg, &duration(step_s), [at, foot + 14.0], size, INK);
    }
    words(svg, "step dt", [middle, foot + 34.0], TEXT, INK);
}

fn cell(svg: &mut Svg, cell: &Cell, corners: [Pixel; 2], size: f64) {
    let (fill, ink) = colours(cell.verdict);
    tile(svg, corners, fill, PAPER);
    let error = match (cell.verdict, cell.angle_error_rad) {
        (Verdict::NotJudged, _) => "–".to_string(),
        (Verdict::Failed, None) => "failed".to_string(),
        (_, Some(rad)) => format!("{rad:.1e}").replace('-', "−"),
        (_, None) => "∞".to_string(),
    };
    words(svg, &error, [0, 1].map(|k| 0.5 * (corners[0][k] + corners[1][k])), size, ink);
}

/// Verdicts with their colours, and what the figures are, in one line.
fn legend(svg: &mut Svg, study: &Stability) {
    let bound = format!("{:e} rad", study.accuracy_rad).replace('-', "−");
    let entries = [
        (Verdict::Accurate, format!("stable, within {bound}")),
        (Verdict::Inaccurate, "stable, inaccurate".to_string()),
        (Verdict::Failed, "failed".to_string()),
        (Verdict::NotJudged, "not judged".to_string()),
    ];
    let there = entries.iter().filter(|(verdict, _)| study.count(*verdict) > 0);
    let [x, y] = key(svg, [16.0, 17.0], there.map(|(verdict, text)| (colours(*verdict).0, text.as_str())), TEXT);
    words_from(svg, "figures: largest angle error, rad", [x, y], TEXT, INK);
}

/// Fill and text: three steps of lightness, so that they stay apart in grey and for every kind of eye.
fn colours(verdict: Verdict) -> (Colour, Colour) {
    match verdict {
        Verdict::Accurate => (FINE, INK),
        Verdict::Inaccurate => (DOUBTFUL, INK),
        Verdict::Failed => (BROKEN, PAPER),
        Verdict::NotJudged => (PAPER, SOFT),
    }
}

/// A factor as a power of ten where it is one beyond ten.
fn factor(value: f64) -> String {
    let plain = format!("{value}");
    if plain.len() > 4 { format!("{value:e}").replace('-', "−") } else { plain }
}
