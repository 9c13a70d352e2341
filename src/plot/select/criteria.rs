//! Runs removed by each criterion: a row for each criterion, a cell for each design, a block for each condition (thesis
//! Fig. 4.6).

use super::design_numbers;
use super::strip::strip;
use crate::format::{condition_name, criterion_name};
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    Marker, TITLE_HEIGHT, WIDTH, colour_key, markers, picture, text_centred, text_left_of, text_right_of, truncated,
};
use crate::plot::svg::Svg;
use crate::plot::theme::{BLUE, Colour, GREEN, INK, NEUTRAL, ORANGE, PALE_BLUE, PAPER, SOFT};
use crate::study::select::{Selection, Verdict};

/// Width of the criterion names left of the cells, in pixels.
const LEFT_MARGIN: f64 = 190.0;
/// Width of the counts right of the cells, in pixels.
const RIGHT_MARGIN: f64 = 120.0;
/// Height of the heading of a condition, in pixels.
const HEADER_HEIGHT: f64 = 30.0;
/// Height of the row of a criterion, in pixels.
const ROW_HEIGHT: f64 = 26.0;
/// Height of the row that marks the selected designs, in pixels.
const MARKER_ROW_HEIGHT: f64 = 30.0;
/// Height of the design numbers at the bottom, in pixels.
const FOOTER_HEIGHT: f64 = 52.0;
/// Height of the colour key at the top, in pixels.
const KEY_HEIGHT: f64 = 36.0;
/// Text size, in pixels.
const TEXT_SIZE: f64 = 14.0;

/// Categories of cells: verdict of the criterion, and whether an earlier criterion has already removed the run.
const CELLS: [(Colour, &str); 5] = [
    (BLUE, "left"),
    (ORANGE, "removed here"),
    (PALE_BLUE, "satisfied, removed above"),
    (NEUTRAL, "also fails, removed above"),
    (PAPER, "unknown"),
];

/// Draws the effect of each criterion on the runs.
pub fn selection_criteria(title: &str, selection: &Selection) -> String {
    let block = HEADER_HEIGHT + ROW_HEIGHT * selection.criteria.len() as f64 + MARKER_ROW_HEIGHT;
    let footer_top = KEY_HEIGHT + block * selection.conditions.len() as f64;
    let design_numbers = design_numbers(selection);
    picture(&format!("{title}: runs removed by each criterion"), TITLE_HEIGHT + footer_top + FOOTER_HEIGHT, |svg| {
        let is_incomplete = selection.runs.len() < design_numbers.len() * selection.conditions.len();
        let has_unknown = is_incomplete || selection.tallies.iter().any(|tally| tally.unknown > 0);
        colour_key(svg, [16.0, 14.0], CELLS.into_iter().take(if has_unknown { 5 } else { 4 }), TEXT_SIZE);
        for condition in 0..selection.conditions.len() {
            let origin = [0.0, KEY_HEIGHT + block * condition as f64];
            svg.translated(origin, |svg| draw(svg, selection, &design_numbers, condition));
        }
        svg.translated([0.0, footer_top], |svg| draw_footer(svg, &design_numbers));
    })
}

/// Horizontal centre of the cell of a design, as drawn by [`strip`].
fn cell_centre(design_index: usize, count: usize) -> f64 {
    LEFT_MARGIN + (WIDTH - LEFT_MARGIN - RIGHT_MARGIN) * (design_index as f64 + 0.5) / count as f64
}

/// Draws the rows of one condition.
fn draw(svg: &mut Svg, selection: &Selection, design_numbers: &[i64], condition: usize) {
    let (right, edge) = (WIDTH - RIGHT_MARGIN, WIDTH - 20.0);
    text_right_of(svg, &condition_name(&selection.conditions[condition]), [16.0, 0.5 * HEADER_HEIGHT], 15.0, INK);
    text_left_of(svg, "left", [edge, 0.5 * HEADER_HEIGHT], TEXT_SIZE, SOFT);
    // Index of the run of each design.
    let mut runs = vec![None; design_numbers.len()];
    for (index, run) in selection.runs.iter().enumerate().filter(|(_, run)| run.condition == condition) {
        if let Ok(design_index) = design_numbers.binary_search(&run.design) {
            runs[design_index] = Some(index);
        }
    }
    for (row, criterion) in selection.criteria.iter().enumerate() {
        let y = HEADER_HEIGHT + ROW_HEIGHT * row as f64;
        let cells: Vec<usize> =
            runs.iter().map(|run| run.map_or(4, |run: usize| cell(&selection.verdicts[run], row))).collect();
        strip(svg, [[LEFT_MARGIN, y], [right, y + ROW_HEIGHT - 6.0]], &cells, &CELLS.map(|(colour, _)| colour));
        let label = truncated(&criterion_name(criterion), TEXT_SIZE, LEFT_MARGIN - 24.0);
        text_left_of(svg, &label, [LEFT_MARGIN - 10.0, y + 0.5 * ROW_HEIGHT - 3.0], TEXT_SIZE, INK);
        let left = cells.iter().filter(|&&cell| cell == 0).count();
        text_left_of(svg, &left.to_string(), [edge, y + 0.5 * ROW_HEIGHT - 3.0], TEXT_SIZE, INK);
    }
    let y = HEADER_HEIGHT + ROW_HEIGHT * selection.criteria.len() as f64 + 6.0;
    text_left_of(svg, "selected", [LEFT_MARGIN - 10.0, y], TEXT_SIZE, GREEN);
    let best = selection.ranking.first().map(|ranked| ranked.run_index);
    // At most one marker per pixel.
    let mut marked = std::collections::BTreeSet::new();
    let runs = selection.ranking.iter().map(|ranked| (ranked.run_index, &selection.runs[ranked.run_index]));
    for (index, run) in runs.filter(|(_, run)| run.condition == condition) {
        let Ok(design_index) = design_numbers.binary_search(&run.design) else { continue };
        let x = cell_centre(design_index, design_numbers.len());
        marked.insert(x as i64);
        if Some(index) == best {
            text_centred(svg, &format!("best: {}", run.design), [x, y + 15.0], TEXT_SIZE, GREEN);
        }
    }
    let positions: Vec<[f64; 2]> = marked.into_iter().map(|x| [x as f64 + 0.5, y]).collect();
    markers(svg, &positions, Marker::SmallTriangle, GREEN);
}

/// Index in [`CELLS`] of a run and a criterion.
fn cell(verdicts: &[Verdict], row: usize) -> usize {
    let before = verdicts[..row].iter().all(|&verdict| verdict == Verdict::Holds);
    match (verdicts[row], before) {
        (Verdict::Holds, true) => 0,
        (Verdict::Fails, true) => 1,
        (Verdict::Holds, false) => 2,
        (Verdict::Fails, false) => 3,
        (Verdict::Unknown, _) => 4,
    }
}

/// Draws the numbers of designs below the lowest block.
fn draw_footer(svg: &mut Svg, design_numbers: &[i64]) {
    let (Some(&first), Some(&last)) = (design_numbers.first(), design_numbers.last()) else { return };
    let ticks = Axis::from_range("", first as f64, last.max(first + 1) as f64).ticks;
    let mut labelled: Vec<i64> = std::iter::once(first).chain(ticks.iter().map(|&tick| tick as i64)).collect();
    labelled.dedup();
    for number in labelled {
        if let Ok(design_index) = design_numbers.binary_search(&number) {
            let x = cell_centre(design_index, design_numbers.len());
            text_centred(svg, &number.to_string(), [x, 12.0], TEXT_SIZE, INK);
        }
    }
    text_centred(svg, "design", [0.5 * (LEFT_MARGIN + WIDTH - RIGHT_MARGIN), 34.0], TEXT_SIZE, INK);
}
