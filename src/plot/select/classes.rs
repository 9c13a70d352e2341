//! Designs sorted by each variable, coloured by class (thesis Figs. 4.4, A.16–A.19).

use super::strip::strip;
use crate::format::{Quantity, condition_name, percent_of};
use crate::plot::canvas::{
    TITLE_HEIGHT, WIDTH, colour_key, picture, text_centred, text_left_of, text_right_of, text_width, truncated,
};
use crate::plot::svg::{Paint, Svg};
use crate::plot::theme::{Colour, INK, PAPER, SOFT, VERDICTS};
use crate::study::select::{Axis, Candidate, Selection};
use crate::table::Value;

/// Width of the labels left of the cells, in pixels.
const LEFT_MARGIN: f64 = 150.0;
/// Margin right of the cells, in pixels.
const RIGHT_MARGIN: f64 = 20.0;
/// Height of the heading of a variable, in pixels.
const HEADER_HEIGHT: f64 = 32.0;
/// Height of the cells of one condition, in pixels.
const BAND_HEIGHT: f64 = 30.0;
/// Height of the percentages below a band, in pixels.
const SHARE_HEIGHT: f64 = 20.0;
/// Height of the values below the last band of a variable, in pixels.
const FOOTER_HEIGHT: f64 = 26.0;
/// Height of the colour key at the top, in pixels.
const KEY_HEIGHT: f64 = 36.0;
/// Size of the colour key and the condition names, in pixels.
const TEXT_SIZE: f64 = 14.0;
/// Size of the percentages and the footnote, in pixels.
const SMALL_TEXT_SIZE: f64 = 12.0;
/// Maximum number of values of a variable that are drawn as groups.
const MAX_GROUPS: usize = 24;

/// Categories of cells, the number of leading categories that count as good, and their common name.
struct Scheme {
    cells: &'static [(Colour, &'static str)],
    good_count: usize,
    group_name: &'static str,
    category: fn(&Candidate) -> usize,
}

const DYNAMIC: Scheme = Scheme {
    cells: &[
        (VERDICTS[0], "stable"),
        (VERDICTS[1], "semi-stable"),
        (VERDICTS[2], "semi-unstable"),
        (VERDICTS[3], "unstable"),
        (PAPER, "no result"),
    ],
    good_count: 2,
    group_name: "stable or semi-stable",
    category: |run| run.class.map_or(4, |class| class as usize),
};

const STATIC: Scheme = Scheme {
    cells: &[(VERDICTS[0], "statically stable"), (VERDICTS[3], "unstable"), (PAPER, "no result")],
    good_count: 1,
    group_name: "statically stable",
    category: |run| run.force_positive.map_or(2, |stable| usize::from(!stable)),
};

/// Draws dynamic classes (thesis Figs. A.18, A.19).
pub fn selection_classes(title: &str, selection: &Selection) -> String {
    draw(&format!("{title}: dynamic classes, designs sorted by each variable"), selection, &DYNAMIC)
}

/// Draws static stability (thesis Figs. A.16, A.17).
pub fn selection_static(title: &str, selection: &Selection) -> String {
    draw(&format!("{title}: static stability, designs sorted by each variable"), selection, &STATIC)
}

fn draw(title: &str, selection: &Selection, scheme: &Scheme) -> String {
    let axes: Vec<(usize, &Axis)> = selection
        .axes
        .iter()
        .enumerate()
        .filter(|(_, axis)| !axis.varies_within_design && axis.values.len() > 1)
        .collect();
    let block = HEADER_HEIGHT + (BAND_HEIGHT + SHARE_HEIGHT) * selection.conditions.len() as f64 + FOOTER_HEIGHT;
    let foot = block * axes.len().max(1) as f64;
    picture(title, TITLE_HEIGHT + KEY_HEIGHT + 2.0 * SMALL_TEXT_SIZE + foot, |svg| {
        let categories_present: Vec<usize> = selection.runs.iter().map(scheme.category).collect();
        let last = scheme.cells.len() - 1;
        let entries =
            scheme.cells.iter().enumerate().filter(|(index, _)| *index < last || categories_present.contains(index));
        colour_key(svg, [16.0, 14.0], entries.map(|(_, entry)| *entry), TEXT_SIZE);
        for (position, (index, axis)) in axes.iter().enumerate() {
            let origin = [0.0, KEY_HEIGHT + block * position as f64];
            svg.translated(origin, |svg| variable(svg, selection, scheme, (*index, axis)));
        }
        let text = match axes.is_empty() {
            true => "the study has no variable with more than one value".to_string(),
            false => format!("figures: share of runs that are {}", scheme.group_name),
        };
        text_right_of(svg, &text, [16.0, KEY_HEIGHT + foot + 4.0], SMALL_TEXT_SIZE, SOFT);
    })
}

/// Draws the runs of every condition, sorted by one variable.
fn variable(svg: &mut Svg, selection: &Selection, scheme: &Scheme, (index, axis): (usize, &Axis)) {
    let quantity = Quantity::for_column(&axis.column);
    text_right_of(svg, &quantity.label(), [LEFT_MARGIN, 0.5 * HEADER_HEIGHT + 2.0], 15.0, INK);
    let palette: Vec<Colour> = scheme.cells.iter().map(|(colour, _)| *colour).collect();
    let order = order(axis);
    let is_grouped = axis.values.len() <= MAX_GROUPS;
    let right = WIDTH - RIGHT_MARGIN;
    for (condition, condition_entry) in selection.conditions.iter().enumerate() {
        let y = HEADER_HEIGHT + (BAND_HEIGHT + SHARE_HEIGHT) * condition as f64;
        let name = truncated(&condition_name(condition_entry), TEXT_SIZE, LEFT_MARGIN - 24.0);
        text_left_of(svg, &name, [LEFT_MARGIN - 10.0, y + 0.5 * BAND_HEIGHT], TEXT_SIZE, INK);
        let mut runs: Vec<(usize, &Candidate)> = selection
            .runs
            .iter()
            .filter(|run| run.condition == condition)
            .map(|run| (rank(&order, &run.axes[index]), run))
            .collect();
        runs.sort_by_key(|(rank, run)| (*rank, run.design));
        let cells: Vec<usize> = runs.iter().map(|(_, run)| (scheme.category)(run)).collect();
        strip(svg, [[LEFT_MARGIN, y], [right, y + BAND_HEIGHT]], &cells, &palette);
        if !is_grouped {
            continue;
        }
        let edge = |run_index: usize| LEFT_MARGIN + (right - LEFT_MARGIN) * run_index as f64 / runs.len() as f64;
        let mut from = 0;
        for group in runs.chunk_by(|a, b| a.0 == b.0) {
            let (start, end) = (edge(from), edge(from + group.len()));
            let mut below = |text: &str, y: f64, size: f64, colour: Colour| {
                if text_width(text, size) < end - start {
                    text_centred(svg, text, [0.5 * (start + end), y], size, colour);
                }
            };
            let in_good_class = group.iter().filter(|(_, run)| (scheme.category)(run) < scheme.good_count).count();
            let share = percent_of(in_good_class, group.len()).replace(".0 %", " %");
            below(&share, y + BAND_HEIGHT + 0.5 * SHARE_HEIGHT - 1.0, SMALL_TEXT_SIZE, SOFT);
            if condition + 1 == selection.conditions.len() {
                below(
                    &quantity.value(&group[0].1.axes[index], 4),
                    y + BAND_HEIGHT + SHARE_HEIGHT + 8.0,
                    TEXT_SIZE,
                    INK,
                );
            }
            if from > 0 {
                svg.polyline(&[[start, y - 2.0], [start, y + BAND_HEIGHT + SHARE_HEIGHT - 4.0]], Paint::line(INK, 1.0));
            }
            from += group.len();
        }
    }
    if !is_grouped && let (Some(first), Some(last)) = (order.first(), order.last()) {
        let y = HEADER_HEIGHT + (BAND_HEIGHT + SHARE_HEIGHT) * selection.conditions.len() as f64;
        text_right_of(svg, &quantity.value(first, 4), [LEFT_MARGIN, y], TEXT_SIZE, INK);
        text_left_of(svg, &quantity.value(last, 4), [right, y], TEXT_SIZE, INK);
    }
}

/// Values in the order of the study, or in ascending order if they are too many for groups.
fn order(axis: &Axis) -> Vec<Value> {
    let mut values = axis.values.clone();
    if values.len() > MAX_GROUPS {
        values.sort_by(|a, b| number(a).total_cmp(&number(b)));
    }
    values
}

fn number(value: &Value) -> f64 {
    value.as_number().unwrap_or(f64::INFINITY)
}

/// Rank of a value in the order.
fn rank(order: &[Value], value: &Value) -> usize {
    if order.len() > MAX_GROUPS {
        return order.partition_point(|other| number(other) < number(value));
    }
    order.iter().position(|other| other == value).unwrap_or(order.len())
}
