//! The designs sorted by each variable, coloured by class (Figs. 4.4, A.16–A.19): where the good ones are.

use super::strip::strip;
use crate::plot::canvas::{HEAD as TITLE, WIDTH, key, picture, shortened, text_width, words, words_from, words_to};
use crate::plot::svg::{Paint, Svg};
use crate::plot::theme::{Colour, INK, PAPER, SOFT, VERDICTS};
use crate::study::select::{Axis, Candidate, Selection};
use crate::table::Value;
use crate::wording::{Quantity, condition_name, percent_of};

/// Left and right of the cells; heights of a variable's head, of a band, of the shares below it, of its foot. In pixels.
const LEFT: f64 = 150.0;
const RIGHT: f64 = 20.0;
const HEAD: f64 = 32.0;
const BAND: f64 = 30.0;
const SHARES: f64 = 20.0;
const FOOT: f64 = 26.0;
const KEY: f64 = 36.0;
const TEXT: f64 = 14.0;
const SMALL: f64 = 12.0;
/// A variable with more values than this has too many for groups.
const GROUPS: usize = 24;

/// What cells are, which of them count as good, and the word for those.
struct Scheme {
    cells: &'static [(Colour, &'static str)],
    good: usize,
    word: &'static str,
    of: fn(&Candidate) -> usize,
}

const DYNAMIC: Scheme = Scheme {
    cells: &[
        (VERDICTS[0], "stable"),
        (VERDICTS[1], "semi-stable"),
        (VERDICTS[2], "semi-unstable"),
        (VERDICTS[3], "unstable"),
        (PAPER, "no result"),
    ],
    good: 2,
    word: "stable or semi-stable",
    of: |run| run.class.map_or(4, |class| class as usize),
};

const STATIC: Scheme = Scheme {
    cells: &[(VERDICTS[0], "statically stable"), (VERDICTS[3], "unstable"), (PAPER, "no result")],
    good: 1,
    word: "statically stable",
    of: |run| run.force_positive.map_or(2, |stable| usize::from(!stable)),
};

/// Dynamic classes (Figs. A.18, A.19).
pub fn selection_classes(title: &str, selection: &Selection) -> String {
    draw(&format!("{title}: dynamic classes, designs sorted by each variable"), selection, &DYNAMIC)
}

/// Static stability (Figs. A.16, A.17).
pub fn selection_static(title: &str, selection: &Selection) -> String {
    draw(&format!("{title}: static stability, designs sorted by each variable"), selection, &STATIC)
}

fn draw(title: &str, selection: &Selection, scheme: &Scheme) -> String {
    let axes: Vec<(usize, &Axis)> =
        selection.axes.iter().enumerate().filter(|(_, axis)| !axis.again && axis.values.len() > 1).collect();
    let block = HEAD + (BAND + SHARES) * selection.conditions.len() as f64 + FOOT;
    let foot = block * axes.len().max(1) as f64;
    picture(title, TITLE + KEY + 2.0 * SMALL + foot, |svg| {
        let there: Vec<usize> = selection.runs.iter().map(scheme.of).collect();
        let last = scheme.cells.len() - 1;
        let entries = scheme.cells.iter().enumerate().filter(|(index, _)| *index < last || there.contains(index));
        key(svg, [16.0, 14.0], entries.map(|(_, entry)| *entry), TEXT);
        for (place, (index, axis)) in axes.iter().enumerate() {
            let at = [0.0, KEY + block * place as f64];
            svg.moved(at, |svg| variable(svg, selection, scheme, (*index, axis)));
        }
        let text = match axes.is_empty() {
            true => "the study has no variable with more than one value".to_string(),
            false => format!("figures: share of runs that are {}", scheme.word),
        };
        words_from(svg, &text, [16.0, KEY + foot + 4.0], SMALL, SOFT);
    })
}

/// The runs of every condition, sorted by one variable.
fn variable(svg: &mut Svg, selection: &Selection, scheme: &Scheme, (index, axis): (usize, &Axis)) {
    let quantity = Quantity::of(&axis.column);
    words_from(svg, &quantity.label(), [LEFT, 0.5 * HEAD + 2.0], 15.0, INK);
    let palette: Vec<Colour> = scheme.cells.iter().map(|(colour, _)| *colour).collect();
    let order = order(axis);
    let grouped = axis.values.len() <= GROUPS;
    let right = WIDTH - RIGHT;
    for (condition, of) in selection.conditions.iter().enumerate() {
        let y = HEAD + (BAND + SHARES) * condition as f64;
        let name = shortened(&condition_name(of), TEXT, LEFT - 24.0);
        words_to(svg, &name, [LEFT - 10.0, y + 0.5 * BAND], TEXT, INK);
        let mut runs: Vec<(usize, &Candidate)> = selection
            .runs
            .iter()
            .filter(|run| run.condition == condition)
            .map(|run| (rank(&order, &run.axes[index]), run))
            .collect();
        runs.sort_by_key(|(rank, run)| (*rank, run.design));
        let cells: Vec<usize> = runs.iter().map(|(_, run)| (scheme.of)(run)).collect();
        strip(svg, [[LEFT, y], [right, y + BAND]], &cells, &palette);
        if !grouped {
            continue;
        }
        let at = |place: usize| LEFT + (right - LEFT) * place as f64 / runs.len() as f64;
        let mut from = 0;
        for group in runs.chunk_by(|a, b| a.0 == b.0) {
            let (start, end) = (at(from), at(from + group.len()));
            let mut below = |text: &str, y: f64, size: f64, colour: Colour| {
                if text_width(text, size) < end - start {
                    words(svg, text, [0.5 * (start + end), y], size, colour);
                }
            };
            let good = group.iter().filter(|(_, run)| (scheme.of)(run) < scheme.good).count();
            let share = percent_of(good, group.len()).replace(".0 %", " %");
            below(&share, y + BAND + 0.5 * SHARES - 1.0, SMALL, SOFT);
            if condition + 1 == selection.conditions.len() {
                below(&quantity.value(&group[0].1.axes[index], 4), y + BAND + SHARES + 8.0, TEXT, INK);
            }
            if from > 0 {
                svg.polyline(&[[start, y - 2.0], [start, y + BAND + SHARES - 4.0]], Paint::line(INK, 1.0));
            }
            from += group.len();
        }
    }
    if !grouped && let (Some(first), Some(last)) = (order.first(), order.last()) {
        let y = HEAD + (BAND + SHARES) * selection.conditions.len() as f64;
        words_from(svg, &quantity.value(first, 4), [LEFT, y], TEXT, INK);
        words_to(svg, &quantity.value(last, 4), [right, y], TEXT, INK);
    }
}

/// Values in the order in which the study went through them; from small to large where they are too many for that to
/// mean something.
fn order(axis: &Axis) -> Vec<Value> {
    let mut values = axis.values.clone();
    if values.len() > GROUPS {
        values.sort_by(|a, b| number(a).total_cmp(&number(b)));
    }
    values
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Number(value) => *value,
        Value::Integer(value) => *value as f64,
        _ => f64::INFINITY,
    }
}

/// Place of a value in the order.
fn rank(order: &[Value], value: &Value) -> usize {
    if order.len() > GROUPS {
        return order.partition_point(|other| number(other) < number(value));
    }
    order.iter().position(|other| other == value).unwrap_or(order.len())
}
