//! What each criterion removed: a row for each criterion, a cell for each design, a block for each condition (Fig. 4.6).

use plotters::style::RGBColor;

use super::strip::{NEUTRAL, PALE_BLUE, key, shortened, strip};
use crate::plot::axis::Axis;
use crate::plot::canvas::{
    Area, BLACK, BLUE, DrawError, GREEN, GREY, Mark, ORANGE, WHITE, WIDTH, mark, picture, titled, words, words_from,
    words_to,
};
use crate::study::select::{Selection, Verdict};
use crate::wording::{condition_name, criterion_name};

/// Left and right of the cells, heights of a block's head, a row, the row of marks, and of the foot. In pixels.
const LEFT: i32 = 190;
const RIGHT: i32 = 120;
const HEAD: i32 = 30;
const ROW: i32 = 26;
const MARKS: i32 = 30;
const FOOT: i32 = 52;
const KEY: u32 = 36;
const TITLE: u32 = 40;
const TEXT: u32 = 14;

/// What a cell is: what the criterion says, and whether an earlier one has removed the run already.
const CELLS: [(RGBColor, &str); 5] = [
    (BLUE, "left"),
    (ORANGE, "removed here"),
    (PALE_BLUE, "holds, removed above"),
    (NEUTRAL, "fails too, removed above"),
    (WHITE, "unknown"),
];

/// The picture.
pub fn selection_criteria(title: &str, selection: &Selection) -> Result<String, DrawError> {
    let rows = selection.criteria.len() as i32;
    let block = HEAD + ROW * rows + MARKS;
    let height = TITLE + KEY + (block * selection.conditions.len() as i32 + FOOT) as u32;
    let designs = designs(selection);
    picture(height, |area| {
        let rest = titled(area, &format!("{title}: what each criterion removed"))?;
        let (head, rest) = rest.split_vertically(KEY);
        let unknown = selection.tallies.iter().any(|tally| tally.unknown > 0) || gaps(selection, designs.len());
        key(&head, &CELLS[..if unknown { 5 } else { 4 }], TEXT)?;
        for condition in 0..selection.conditions.len() {
            draw(&rest, selection, &designs, condition, block * condition as i32)?;
        }
        foot(&rest, &designs, block * selection.conditions.len() as i32)
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
fn middle(place: usize, count: usize) -> i32 {
    let width = WIDTH as i32 - LEFT - RIGHT;
    LEFT + (f64::from(width) * (place as f64 + 0.5) / count as f64) as i32
}

/// The rows of one condition.
fn draw(area: &Area, selection: &Selection, designs: &[i64], condition: usize, top: i32) -> Result<(), DrawError> {
    let right = WIDTH as i32 - RIGHT;
    let name = condition_name(&selection.conditions[condition]);
    words_from(area, &name, (16, top + HEAD / 2), 15, BLACK)?;
    words_to(area, "left", (WIDTH as i32 - 20, top + HEAD / 2), TEXT, GREY)?;
    let runs = placed(selection, designs, condition);
    for (row, criterion) in selection.criteria.iter().enumerate() {
        let y = top + HEAD + ROW * row as i32;
        let cells: Vec<usize> =
            runs.iter().map(|run| run.map_or(4, |run| cell(&selection.verdicts[run], row))).collect();
        strip(area, [(LEFT, y), (right, y + ROW - 6)], &cells, &CELLS.map(|(colour, _)| colour))?;
        let label = shortened(&criterion_name(criterion), TEXT, LEFT - 24);
        words_to(area, &label, (LEFT - 10, y + ROW / 2 - 3), TEXT, BLACK)?;
        let left = cells.iter().filter(|&&cell| cell == 0).count();
        words_to(area, &left.to_string(), (WIDTH as i32 - 20, y + ROW / 2 - 3), TEXT, BLACK)?;
    }
    let y = top + HEAD + ROW * selection.criteria.len() as i32 + 6;
    words_to(area, "selected", (LEFT - 10, y), TEXT, GREEN)?;
    let best = selection.ranking.first().map(|ranked| ranked.run_index);
    let mut marked = std::collections::HashSet::new();
    for ranked in &selection.ranking {
        let run = &selection.runs[ranked.run_index];
        if run.condition != condition {
            continue;
        }
        let Ok(place) = designs.binary_search(&run.design) else { continue };
        let x = middle(place, designs.len());
        if marked.insert(x) {
            mark(area, (x, y), Mark::SmallTriangle, GREEN)?;
        }
        if Some(ranked.run_index) == best {
            words(area, &format!("best: {}", run.design), (x, y + 15), TEXT, GREEN)?;
        }
    }
    Ok(())
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
fn foot(area: &Area, designs: &[i64], top: i32) -> Result<(), DrawError> {
    let (Some(&first), Some(&last)) = (designs.first(), designs.last()) else { return Ok(()) };
    let ticks = Axis::over("", first as f64, last.max(first + 1) as f64).ticks;
    let mut shown: Vec<i64> = std::iter::once(first).chain(ticks.iter().map(|&tick| tick as i64)).collect();
    shown.dedup();
    for number in shown {
        if let Ok(place) = designs.binary_search(&number) {
            words(area, &number.to_string(), (middle(place, designs.len()), top + 12), TEXT, BLACK)?;
        }
    }
    let centre = (LEFT + WIDTH as i32 - RIGHT) / 2;
    words(area, "design", (centre, top + 34), TEXT, BLACK)
}
