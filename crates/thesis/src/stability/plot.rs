//! Map of verdicts: a panel for each damping factor, with tiles over step size and stiffness that contain the angle
//! error.

use super::{Cell, Stability, Verdict};
use crate::format::format_duration;
use crate::plot::canvas::{TITLE_HEIGHT, WIDTH, colour_key, picture, text_centred, text_right_of, text_width, tile};
use crate::plot::svg::{Pixel, Svg};
use crate::plot::theme::{BROKEN, Colour, DOUBTFUL, FINE, INK, PAPER, SOFT};

/// Maximum number of panels side by side.
const MAX_COLUMNS: usize = 2;
/// Height of the heading of a panel, in pixels.
const HEADER_HEIGHT: f64 = 34.0;
/// Height of the step sizes and the axis label below a panel, in pixels.
const FOOTER_HEIGHT: f64 = 52.0;
/// Width of the stiffness factors left of a panel, in pixels.
const LEFT_MARGIN: f64 = 82.0;
/// Margin right of a panel, in pixels.
const RIGHT_MARGIN: f64 = 14.0;
/// Height of a row of tiles, in pixels.
const ROW_HEIGHT: f64 = 38.0;
/// Height of the legend at the top, in pixels.
const LEGEND_HEIGHT: f64 = 40.0;
/// Text size, in pixels.
const TEXT_SIZE: f64 = 14.0;

impl Stability {
    /// Draws a map of stability and accuracy over stiffness and step, with one panel for each damping factor.
    pub fn picture(&self) -> String {
        let panels = self.grid.damping_factors.len();
        let columns = MAX_COLUMNS.min(panels);
        let panel = HEADER_HEIGHT + FOOTER_HEIGHT + ROW_HEIGHT * self.grid.stiffness_factors.len() as f64;
        let width = WIDTH / columns as f64;
        let title = format!("{}: stability and accuracy of the engine", self.scene);
        picture(&title, TITLE_HEIGHT + LEGEND_HEIGHT + panel * panels.div_ceil(columns) as f64, |svg| {
            legend(svg, self);
            for damping in 0..panels {
                let origin = [width * (damping % columns) as f64, LEGEND_HEIGHT + panel * (damping / columns) as f64];
                svg.translated(origin, |svg| draw(svg, width, self, damping));
            }
        })
    }
}

/// Draws one panel of a width: step size increases to the right, stiffness upwards.
fn draw(svg: &mut Svg, width: f64, study: &Stability, damping: usize) {
    let grid = &study.grid;
    let columns = grid.steps_s.len();
    let width = width - LEFT_MARGIN - RIGHT_MARGIN;
    let edge = |column: usize| LEFT_MARGIN + (width * column as f64 / columns as f64).round();
    let size = TEXT_SIZE.min(((width / columns as f64 - 4.0) / text_width("0.0e−00", 1.0)).floor());
    let middle = LEFT_MARGIN + 0.5 * width;
    text_centred(svg, &format!("c_max × {}", factor(grid.damping_factors[damping])), [middle, 16.0], 16.0, INK);
    let foot = HEADER_HEIGHT + ROW_HEIGHT * grid.stiffness_factors.len() as f64;
    for (stiffness, &k) in grid.stiffness_factors.iter().enumerate() {
        let top = foot - ROW_HEIGHT * (stiffness + 1) as f64;
        text_centred(
            svg,
            &format!("k × {}", factor(k)),
            [0.5 * LEFT_MARGIN + 2.0, top + 0.5 * ROW_HEIGHT],
            TEXT_SIZE,
            INK,
        );
        for step in 0..columns {
            let corners = [[edge(columns - 1 - step), top], [edge(columns - step), top + ROW_HEIGHT]];
            cell(svg, study.cell(step, stiffness, damping), corners, size);
        }
    }
    for (step, &step_s) in grid.steps_s.iter().enumerate() {
        let middle_x = 0.5 * (edge(columns - 1 - step) + edge(columns - step));
        text_centred(svg, &format_duration(step_s), [middle_x, foot + 14.0], size, INK);
    }
    text_centred(svg, "step dt", [middle, foot + 34.0], TEXT_SIZE, INK);
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
    text_centred(svg, &error, [0, 1].map(|k| 0.5 * (corners[0][k] + corners[1][k])), size, ink);
}

/// Draws the colours of the verdicts and the meaning of the figures in one line.
fn legend(svg: &mut Svg, study: &Stability) {
    let bound = format!("{:e} rad", study.accuracy_rad).replace('-', "−");
    let entries = [
        (Verdict::Accurate, format!("stable, within {bound}")),
        (Verdict::Inaccurate, "stable, inaccurate".to_string()),
        (Verdict::Failed, "failed".to_string()),
        (Verdict::NotJudged, "not judged".to_string()),
    ];
    let verdicts_present = entries.iter().filter(|(verdict, _)| study.count(*verdict) > 0);
    let [x, y] = colour_key(
        svg,
        [16.0, 17.0],
        verdicts_present.map(|(verdict, text)| (colours(*verdict).0, text.as_str())),
        TEXT_SIZE,
    );
    text_right_of(svg, "figures: largest angle error, rad", [x, y], TEXT_SIZE, INK);
}

/// Fill and text colours: three levels of lightness, distinguishable in greyscale and with colour blindness.
fn colours(verdict: Verdict) -> (Colour, Colour) {
    match verdict {
        Verdict::Accurate => (FINE, INK),
        Verdict::Inaccurate => (DOUBTFUL, INK),
        Verdict::Failed => (BROKEN, PAPER),
        Verdict::NotJudged => (PAPER, SOFT),
    }
}

/// Formats a factor; long numbers have an exponent.
fn factor(value: f64) -> String {
    let plain_number = format!("{value}");
    if plain_number.len() > 4 { format!("{value:e}").replace('-', "−") } else { plain_number }
}
