//! The designs sorted by each variable, coloured by class (Figs. 4.4, A.16–A.19): where the good ones are.

use plotters::style::RGBColor;

use super::strip::{NEUTRAL, PALE_BLUE, key, shortened, strip, text_width};
use crate::plot::canvas::{
    AMBER, Area, BLACK, BLUE, DrawError, GREY, WHITE, WIDTH, line_between, picture, titled, words, words_from, words_to,
};
use crate::study::select::{Axis, Candidate, Selection};
use crate::table::Value;
use crate::wording::{Quantity, condition_name, percent_of};

/// Left and right of the cells; heights of a variable's head, of a band, of the shares below it, of its foot. In pixels.
const LEFT: i32 = 150;
const RIGHT: i32 = 20;
const HEAD: i32 = 32;
const BAND: i32 = 30;
const SHARES: i32 = 20;
const FOOT: i32 = 26;
const KEY: u32 = 36;
const TITLE: u32 = 40;
const TEXT: u32 = 14;
const SMALL: u32 = 12;
/// A variable with more values than this has too many for groups.
const GROUPS: usize = 24;

/// What cells are, which of them count as good, and the word for those.
struct Scheme {
    cells: &'static [(RGBColor, &'static str)],
    good: usize,
    word: &'static str,
    of: fn(&Candidate) -> usize,
}

const DYNAMIC: Scheme = Scheme {
    cells: &[
        (BLUE, "stable"),
        (PALE_BLUE, "semi-stable"),
        (AMBER, "semi-unstable"),
        (NEUTRAL, "unstable"),
        (WHITE, "no result"),
    ],
    good: 2,
    word: "stable or semi-stable",
    of: |run| run.class.map_or(4, |class| class as usize),
};

const STATIC: Scheme = Scheme {
    cells: &[(BLUE, "statically stable"), (NEUTRAL, "unstable"), (WHITE, "no result")],
    good: 1,
    word: "statically stable",
    of: |run| run.force_positive.map_or(2, |stable| usize::from(!stable)),
};

/// Dynamic classes (Figs. A.18, A.19).
pub fn selection_classes(title: &str, selection: &Selection) -> Result<String, DrawError> {
    draw(&format!("{title}: dynamic classes, designs sorted by each variable"), selection, &DYNAMIC)
}

/// Static stability (Figs. A.16, A.17).
pub fn selection_static(title: &str, selection: &Selection) -> Result<String, DrawError> {
    draw(&format!("{title}: static stability, designs sorted by each variable"), selection, &STATIC)
}

fn draw(title: &str, selection: &Selection, scheme: &Scheme) -> Result<String, DrawError> {
    let axes: Vec<(usize, &Axis)> =
        selection.axes.iter().enumerate().filter(|(_, axis)| !axis.again && axis.values.len() > 1).collect();
    let block = HEAD + (BAND + SHARES) * selection.conditions.len() as i32 + FOOT;
    picture(TITLE + KEY + 2 * SMALL + (block * axes.len().max(1) as i32) as u32, |area| {
        let rest = titled(area, title)?;
        let (head, rest) = rest.split_vertically(KEY);
        let there: Vec<usize> = selection.runs.iter().map(scheme.of).collect();
        let last = scheme.cells.len() - 1;
        let entries = scheme.cells.iter().enumerate().filter(|(index, _)| *index < last || there.contains(index));
        key(&head, &entries.map(|(_, entry)| *entry).collect::<Vec<_>>(), TEXT)?;
        for (place, (index, axis)) in axes.iter().enumerate() {
            variable(&rest, selection, scheme, (*index, axis), block * place as i32)?;
        }
        let foot = block * axes.len().max(1) as i32 + 4;
        let text = match axes.is_empty() {
            true => "the study has no variable with more than one value".to_string(),
            false => format!("figures: share of runs that are {}", scheme.word),
        };
        words_from(&rest, &text, (16, foot), SMALL, GREY)
    })
}

/// The runs of every condition, sorted by one variable.
fn variable(
    area: &Area,
    selection: &Selection,
    scheme: &Scheme,
    (index, axis): (usize, &Axis),
    top: i32,
) -> Result<(), DrawError> {
    let quantity = Quantity::of(&axis.column);
    words_from(area, &quantity.label(), (LEFT, top + HEAD / 2 + 2), 15, BLACK)?;
    let palette: Vec<RGBColor> = scheme.cells.iter().map(|(colour, _)| *colour).collect();
    let order = order(axis);
    let grouped = axis.values.len() <= GROUPS;
    let right = WIDTH as i32 - RIGHT;
    for (condition, of) in selection.conditions.iter().enumerate() {
        let y = top + HEAD + (BAND + SHARES) * condition as i32;
        let name = shortened(&condition_name(of), TEXT, LEFT - 24);
        words_to(area, &name, (LEFT - 10, y + BAND / 2), TEXT, BLACK)?;
        let mut runs: Vec<(usize, &Candidate)> = selection
            .runs
            .iter()
            .filter(|run| run.condition == condition)
            .map(|run| (rank(&order, &run.axes[index]), run))
            .collect();
        runs.sort_by_key(|(rank, run)| (*rank, run.design));
        let cells: Vec<usize> = runs.iter().map(|(_, run)| (scheme.of)(run)).collect();
        strip(area, [(LEFT, y), (right, y + BAND)], &cells, &palette)?;
        if !grouped {
            continue;
        }
        let at = |place: usize| LEFT + ((right - LEFT) as f64 * place as f64 / runs.len() as f64) as i32;
        let mut from = 0;
        for group in runs.chunk_by(|a, b| a.0 == b.0) {
            let (start, end) = (at(from), at(from + group.len()));
            let good = group.iter().filter(|(_, run)| (scheme.of)(run) < scheme.good).count();
            let share = percent_of(good, group.len()).replace(".0 %", " %");
            if text_width(&share, SMALL) < end - start {
                words(area, &share, ((start + end) / 2, y + BAND + SHARES / 2 - 1), SMALL, GREY)?;
            }
            if from > 0 {
                line_between(area, [(start, y - 2), (start, y + BAND + SHARES - 4)], BLACK)?;
            }
            if condition + 1 == selection.conditions.len() {
                let value = quantity.value(&group[0].1.axes[index], 4);
                if text_width(&value, TEXT) < end - start {
                    words(area, &value, ((start + end) / 2, y + BAND + SHARES + 8), TEXT, BLACK)?;
                }
            }
            from += group.len();
        }
    }
    if !grouped && let (Some(first), Some(last)) = (order.first(), order.last()) {
        let y = top + HEAD + (BAND + SHARES) * selection.conditions.len() as i32;
        words_from(area, &quantity.value(first, 4), (LEFT, y), TEXT, BLACK)?;
        words_to(area, &quantity.value(last, 4), (right, y), TEXT, BLACK)?;
    }
    Ok(())
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
