//! What each criterion removed: a row for each criterion, a cell for each design, a block for each condition (Fig. 4.6).

use super::strip::strip;
use crate::plot::axis::Axis;
use crate::plot::canvas::{HEAD as TITLE, Mark, WIDTH, key, marks, picture, shortened, words, words_from, words_to};
use crate::plot::svg::Svg;
use crate::plot::theme::{BLUE, Colour, GREEN, INK, NEUTRAL, ORANGE, PALE_BLUE, PAPER, SOFT};
use crate::study::select::{Selection, Verdict};
use crate::wording::{condition_name, criterion_name};

/// Left and right of the cells, heights of a block's head, a row, the row of marks, and of the foot. In pixels.
const LEFT: f64 = 190.0;
const RIGHT: f64 = 120.0;
const HEAD: f64 = 30.0;
const ROW: f64 = 26.0;
const MARKS: f64 = 30.0;
const FOOT: f64 = 52.0;
const KEY: f64 = 36.0;
const TEXT: f64 = 14.0;

/// What a cell is: what the criterion says, and whether an earlier one has removed the run already.
const CELLS: [(Colour, &str); 5] = [
    (BLUE, "left"),
    (ORANGE, "removed here"),
    (PALE_BLUE, "holds, removed above"),
    (NEUTRAL, "fails too, removed above"),
    (PAPER, "unknown"),
];

/// The picture.
pub fn selection_criteria(title: &str, selection: &Selection) -> String {
    let block = HEAD + ROW * selection.criteria.len() as f64 + MARKS;
    let foot_at = KEY + block * selection.conditions.len() as f64;
    let designs = designs(selection);
    picture(&format!("{title}: what each criterion removed"), TITLE + foot_at + FOOT, |svg| {
        let unknown = selection.tallies.iter().any(|tally| tally.unknown > 0) || gaps(selection, designs.len());
        key(svg, [16.0, 14.0], CELLS.into_iter().take(if unknown { 5 } else { 4 }), TEXT);
        for condition in 0..selection.conditions.len() {
            let at = [0.0, KEY + block * condition as f64];
            svg.moved(at, |svg| draw(svg, selection, &designs, condition));
        }
        svg.moved([0.0, foot_at], |svg| foot(svg, &designs));
    })
}

/// Numbers of the designs in order.
pub fn designs(selection: &Selection) -> Vec<i64> {
    let mut numbers: Vec<i64> = selection.runs.iter().map(|run| run.design).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Whether some design has no run in some condition.
fn gaps(selection: &Selection, designs: usize) -> bool {
    selection.runs.len() < designs * selection.conditions.len()
}

/// Runs of a condition by place of their design.
pub fn placed(selection: &Selection, designs: &[i64], condition: usize) -> Vec<Option<usize>> {
    let mut places = vec![None; designs.len()];
    for (index, run) in selection.runs.iter().enumerate().filter(|(_, run)| run.condition == condition) {
        if let Ok(place) = designs.binary_search(&run.design) {
            places[place] = Some(index);
        }
    }
    places
}

/// Horizontal place of the middle of a design's cell, as [`strip`] draws it.
fn middle(place: usize, count: usize) -> f64 {
    LEFT + (WIDTH - LEFT - RIGHT) * (place as f64 + 0.5) / count as f64
}

/// The rows of one condition.
fn draw(svg: &mut Svg, selection: &Selection, designs: &[i64], condition: usize) {
    let (right, edge) = (WIDTH - RIGHT, WIDTH - 20.0);
    words_from(svg, &condition_name(&selection.conditions[condition]), [16.0, 0.5 * HEAD], 15.0, INK);
    words_to(svg, "left", [edge, 0.5 * HEAD], TEXT, SOFT);
    let runs = placed(selection, designs, condition);
    for (row, criterion) in selection.criteria.iter().enumerate() {
        let y = HEAD + ROW * row as f64;
        let cells: Vec<usize> =
            runs.iter().map(|run| run.map_or(4, |run| cell(&selection.verdicts[run], row))).collect();
        strip(svg, [[LEFT, y], [right, y + ROW - 6.0]], &cells, &CELLS.map(|(colour, _)| colour));
        let label = shortened(&criterion_name(criterion), TEXT, LEFT - 24.0);
        words_to(svg, &label, [LEFT - 10.0, y + 0.5 * ROW - 3.0], TEXT, INK);
        let left = cells.iter().filter(|&&cell| cell == 0).count();
        words_to(svg, &left.to_string(), [edge, y + 0.5 * ROW - 3.0], TEXT, INK);
    }
    let y = HEAD + ROW * selection.criteria.len() as f64 + 6.0;
    words_to(svg, "selected", [LEFT - 10.0, y], TEXT, GREEN);
    let best = selection.ranking.first().map(|ranked| ranked.run_index);
    // Of several in one pixel one is seen.
    let mut marked = std::collections::BTreeSet::new();
    for ranked in &selection.ranking {
        let run = &selection.runs[ranked.run_index];
        if run.condition != condition {
            continue;
        }
        let Ok(place) = designs.binary_search(&run.design) else { continue };
        let x = middle(place, designs.len());
        marked.insert(x as i64);
        if Some(ranked.run_index) == best {
            words(svg, &format!("best: {}", run.design), [x, y + 15.0], TEXT, GREEN);
        }
    }
    let places: Vec<[f64; 2]> = marked.into_iter().map(|x| [x as f64 + 0.5, y]).collect();
    marks(svg, &places, Mark::SmallTriangle, GREEN);
}

/// Which of the cells' kinds one is.
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

/// Numbers of designs below the lowest block.
fn foot(svg: &mut Svg, designs: &[i64]) {
    let (Some(&first), Some(&last)) = (designs.first(), designs.last()) else { return };
    let ticks = Axis::over("", first as f64, last.max(first + 1) as f64).ticks;
    let mut shown: Vec<i64> = std::iter::once(first).chain(ticks.iter().map(|&tick| tick as i64)).collect();
    shown.dedup();
    for number in shown {
        if let Ok(place) = designs.binary_search(&number) {
            words(svg, &number.to_string(), [middle(place, designs.len()), 12.0], TEXT, INK);
        }
    }
    words(svg, "design", [0.5 * (LEFT + WIDTH - RIGHT), 34.0], TEXT, INK);
}
