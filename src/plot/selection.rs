//! Pictures of a selection: runs that each criterion removes (thesis Fig. 4.6), designs sorted by each variable (Figs.
//! 4.4, A.16–A.19), and forces and variables by design (Figs. 4.1, 4.2, 4.5, A.20–A.23).

use std::collections::{BTreeSet, HashSet};

use super::canvas::{
    LegendEntry, Marker, THIN_LINE, TITLE_HEIGHT, WIDTH, colour_key, markers, picture, text_centred, text_left_of,
    text_right_of, text_width, tiles, truncated,
};
use super::chart::{self, Panel, Series, panel_chart};
use super::svg::{Paint, Pixel, Svg};
use super::theme::{AMBER, BLUE, Colour, GREEN, INK, NEUTRAL, ORANGE, PALE_BLUE, PAPER, PURPLE, SOFT, VERDICTS};
use crate::format::{ColumnFormat, percent_of};
use crate::study::select::{Axis, Candidate, Selection};
use crate::table::{Table, Value};

const KEY_HEIGHT: f64 = 36.0;
const TEXT_SIZE: f64 = 14.0;
const SMALL_TEXT_SIZE: f64 = 12.0;

/// Draws the five pictures of a selection: runs removed by each criterion; dynamic classes; static stability of the
/// designs, sorted by each variable; final forces; and the designs themselves.
pub fn selection(title: &str, results: &Table, selection: &Selection) -> [String; 5] {
    [
        criteria(title, selection),
        sorted(&format!("{title}: dynamic classes, designs sorted by each variable"), selection, &DYNAMIC),
        sorted(&format!("{title}: static stability, designs sorted by each variable"), selection, &STATIC),
        forces(title, selection),
        variables(title, results, selection),
    ]
}

/// Sorted numbers of the designs.
fn design_numbers(selection: &Selection) -> Vec<i64> {
    selection.runs.iter().map(|run| run.design).collect::<BTreeSet<_>>().into_iter().collect()
}

/// Draws adjacent cells in a rectangle, each in the colour of its index in the palette.
///
/// With more cells than pixels, a column of pixels shows the shares of its cells, stacked in the order of the palette.
fn strip(svg: &mut Svg, [[left, top], [right, bottom]]: [Pixel; 2], cells: &[usize], palette: &[(Colour, &str)]) {
    if cells.is_empty() || right <= left {
        return;
    }
    let columns = cells.len().min((right - left) as usize);
    let shares = |column: usize| {
        let column_cells = &cells[column * cells.len() / columns..(column + 1) * cells.len() / columns];
        let ends = (0..palette.len()).map(|colour| {
            let up_to = column_cells.iter().filter(|&&cell| cell <= colour).count();
            top + ((bottom - top) * up_to as f64 / column_cells.len() as f64).round()
        });
        ends.collect::<Vec<f64>>()
    };
    let all: Vec<Vec<f64>> = (0..columns).map(shares).collect();
    let edge = |column: usize| left + (right - left) * column as f64 / columns as f64;
    let (mut tiles_to_draw, mut from) = (Vec::new(), 0);
    // Equal adjacent columns are drawn as one.
    for alike in all.chunk_by(|a, b| a == b) {
        let (start, end) = (edge(from), edge(from + alike.len()));
        let mut above = top;
        for (&below, &(colour, _)) in alike[0].iter().zip(palette) {
            if below > above {
                tiles_to_draw.push(([[start, above], [end, below]], colour));
            }
            above = below;
        }
        from += alike.len();
    }
    tiles(svg, tiles_to_draw);
    svg.polyline(&[[left, bottom], [right, bottom]], Paint::line(SOFT, 1.0));
}

// Criterion names are left of the cells, counts right of them.
const CRITERION_WIDTH: f64 = 190.0;
const CRITERIA_END: f64 = WIDTH - 120.0;
const CONDITION_HEIGHT: f64 = 30.0;
const ROW_HEIGHT: f64 = 26.0;
const MARKER_ROW_HEIGHT: f64 = 30.0;

/// Categories of cells: verdict of the criterion, and whether an earlier criterion has already removed the run.
const CELLS: [(Colour, &str); 5] = [
    (BLUE, "left"),
    (ORANGE, "removed here"),
    (PALE_BLUE, "satisfied, removed above"),
    (NEUTRAL, "also fails, removed above"),
    (PAPER, "unknown"),
];

/// Index in [`CELLS`] of a run and a criterion.
fn criterion_cell(verdicts: &[Option<bool>], row: usize) -> usize {
    let before = verdicts[..row].iter().all(|verdict| *verdict == Some(true));
    match (verdicts[row], before) {
        (Some(true), true) => 0,
        (Some(false), true) => 1,
        (Some(true), false) => 2,
        (Some(false), false) => 3,
        (None, _) => 4,
    }
}

/// Draws the effect of each criterion on the runs: a row for each criterion, a cell for each design, a block for each
/// condition.
fn criteria(title: &str, selection: &Selection) -> String {
    let block = CONDITION_HEIGHT + ROW_HEIGHT * selection.tallies.len() as f64 + MARKER_ROW_HEIGHT;
    let footer_top = KEY_HEIGHT + block * selection.conditions.len() as f64;
    let designs = design_numbers(selection);
    picture(&format!("{title}: runs removed by each criterion"), TITLE_HEIGHT + footer_top + 52.0, |svg| {
        let is_incomplete = selection.runs.len() < designs.len() * selection.conditions.len();
        let has_unknown = is_incomplete || selection.tallies.iter().any(|tally| tally.unknown > 0);
        colour_key(svg, [16.0, 14.0], CELLS.into_iter().take(if has_unknown { 5 } else { 4 }), TEXT_SIZE);
        for condition in 0..selection.conditions.len() {
            let origin = [0.0, KEY_HEIGHT + block * condition as f64];
            svg.translated(origin, |svg| criteria_of(svg, selection, &designs, condition));
        }
        svg.translated([0.0, footer_top], |svg| {
            let (Some(&first), Some(&last)) = (designs.first(), designs.last()) else { return };
            let ticks = chart::Axis::from_range("", first as f64, last.max(first + 1) as f64).ticks;
            let mut labelled: Vec<i64> = std::iter::once(first).chain(ticks.iter().map(|&tick| tick as i64)).collect();
            labelled.dedup();
            for number in labelled {
                if let Some(x) = cell_centre(&designs, number) {
                    text_centred(svg, &number.to_string(), [x, 12.0], TEXT_SIZE, INK);
                }
            }
            text_centred(svg, "design", [0.5 * (CRITERION_WIDTH + CRITERIA_END), 34.0], TEXT_SIZE, INK);
        });
    })
}

/// Horizontal centre of the cell of a design, as drawn by [`strip`].
fn cell_centre(designs: &[i64], design: i64) -> Option<f64> {
    let index = designs.binary_search(&design).ok()?;
    Some(CRITERION_WIDTH + (CRITERIA_END - CRITERION_WIDTH) * (index as f64 + 0.5) / designs.len() as f64)
}

/// Draws the rows of one condition.
fn criteria_of(svg: &mut Svg, selection: &Selection, designs: &[i64], condition: usize) {
    let edge = WIDTH - 20.0;
    text_right_of(svg, &selection.conditions[condition].name(), [16.0, 0.5 * CONDITION_HEIGHT], 15.0, INK);
    text_left_of(svg, "left", [edge, 0.5 * CONDITION_HEIGHT], TEXT_SIZE, SOFT);
    // Index of the run of each design.
    let mut runs = vec![None; designs.len()];
    for (index, run) in selection.runs.iter().enumerate().filter(|(_, run)| run.condition == condition) {
        if let Ok(design_index) = designs.binary_search(&run.design) {
            runs[design_index] = Some(index);
        }
    }
    for (row, tally) in selection.tallies.iter().enumerate() {
        let y = CONDITION_HEIGHT + ROW_HEIGHT * row as f64;
        let cells: Vec<usize> =
            runs.iter().map(|run| run.map_or(4, |run: usize| criterion_cell(&selection.verdicts[run], row))).collect();
        strip(svg, [[CRITERION_WIDTH, y], [CRITERIA_END, y + ROW_HEIGHT - 6.0]], &cells, &CELLS);
        let label = truncated(&tally.criterion.name(), TEXT_SIZE, CRITERION_WIDTH - 24.0);
        let middle = y + 0.5 * ROW_HEIGHT - 3.0;
        text_left_of(svg, &label, [CRITERION_WIDTH - 10.0, middle], TEXT_SIZE, INK);
        let left = cells.iter().filter(|&&cell| cell == 0).count();
        text_left_of(svg, &left.to_string(), [edge, middle], TEXT_SIZE, INK);
    }
    let y = CONDITION_HEIGHT + ROW_HEIGHT * selection.tallies.len() as f64 + 6.0;
    text_left_of(svg, "selected", [CRITERION_WIDTH - 10.0, y], TEXT_SIZE, GREEN);
    // At most one marker per pixel.
    let mut marked = BTreeSet::new();
    for (rank, ranked) in selection.ranking.iter().enumerate() {
        let run = &selection.runs[ranked.run_index];
        let Some(x) = cell_centre(designs, run.design).filter(|_| run.condition == condition) else { continue };
        marked.insert(x as i64);
        if rank == 0 {
            text_centred(svg, &format!("best: {}", run.design), [x, y + 15.0], TEXT_SIZE, GREEN);
        }
    }
    let positions: Vec<Pixel> = marked.into_iter().map(|x| [x as f64 + 0.5, y]).collect();
    markers(svg, &positions, Marker::SmallTriangle, GREEN);
}

// Each variable has a heading, a band of cells with percentages below it for each condition, and its values at the bottom.
const CONDITION_WIDTH: f64 = 150.0;
const SORTED_END: f64 = WIDTH - 20.0;
const VARIABLE_HEIGHT: f64 = 32.0;
const BAND_HEIGHT: f64 = 30.0;
const SHARE_HEIGHT: f64 = 20.0;
const VALUES_HEIGHT: f64 = 26.0;
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

/// Draws the designs sorted by each variable.
fn sorted(title: &str, selection: &Selection, scheme: &Scheme) -> String {
    let varied = |(_, axis): &(usize, &Axis)| !axis.varies_within_design && axis.values.len() > 1;
    let axes: Vec<(usize, &Axis)> = selection.axes.iter().enumerate().filter(varied).collect();
    let bands = (BAND_HEIGHT + SHARE_HEIGHT) * selection.conditions.len() as f64;
    let block = VARIABLE_HEIGHT + bands + VALUES_HEIGHT;
    let foot = block * axes.len().max(1) as f64;
    picture(title, TITLE_HEIGHT + KEY_HEIGHT + 2.0 * SMALL_TEXT_SIZE + foot, |svg| {
        let last = scheme.cells.len() - 1;
        let has_unknown = selection.runs.iter().any(|run| (scheme.category)(run) == last);
        colour_key(svg, [16.0, 14.0], scheme.cells[..last + usize::from(has_unknown)].iter().copied(), TEXT_SIZE);
        for (position, variable) in axes.iter().enumerate() {
            let origin = [0.0, KEY_HEIGHT + block * position as f64];
            svg.translated(origin, |svg| sorted_by(svg, selection, scheme, *variable));
        }
        let text = match axes.is_empty() {
            true => "the study has no variable with more than one value".to_string(),
            false => format!("figures: share of runs that are {}", scheme.group_name),
        };
        text_right_of(svg, &text, [16.0, KEY_HEIGHT + foot + 4.0], SMALL_TEXT_SIZE, SOFT);
    })
}

/// Draws the runs of every condition, sorted by one variable.
fn sorted_by(svg: &mut Svg, selection: &Selection, scheme: &Scheme, (index, axis): (usize, &Axis)) {
    let quantity = ColumnFormat::for_column(&axis.column);
    text_right_of(svg, &quantity.label(), [CONDITION_WIDTH, 0.5 * VARIABLE_HEIGHT + 2.0], 15.0, INK);
    let order = order(axis);
    let is_grouped = axis.values.len() <= MAX_GROUPS;
    for (condition, condition_entry) in selection.conditions.iter().enumerate() {
        let y = VARIABLE_HEIGHT + (BAND_HEIGHT + SHARE_HEIGHT) * condition as f64;
        let name = truncated(&condition_entry.name(), TEXT_SIZE, CONDITION_WIDTH - 24.0);
        text_left_of(svg, &name, [CONDITION_WIDTH - 10.0, y + 0.5 * BAND_HEIGHT], TEXT_SIZE, INK);
        let of_condition = selection.runs.iter().filter(|run| run.condition == condition);
        let mut runs: Vec<(usize, &Candidate)> =
            of_condition.map(|run| (rank(&order, &run.axes[index]), run)).collect();
        runs.sort_by_key(|(rank, run)| (*rank, run.design));
        let cells: Vec<usize> = runs.iter().map(|(_, run)| (scheme.category)(run)).collect();
        strip(svg, [[CONDITION_WIDTH, y], [SORTED_END, y + BAND_HEIGHT]], &cells, scheme.cells);
        if !is_grouped {
            continue;
        }
        let edge = |run: usize| CONDITION_WIDTH + (SORTED_END - CONDITION_WIDTH) * run as f64 / runs.len() as f64;
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
                let value = quantity.value(&group[0].1.axes[index], 4);
                below(&value, y + BAND_HEIGHT + SHARE_HEIGHT + 8.0, TEXT_SIZE, INK);
            }
            if from > 0 {
                svg.polyline(&[[start, y - 2.0], [start, y + BAND_HEIGHT + SHARE_HEIGHT - 4.0]], Paint::line(INK, 1.0));
            }
            from += group.len();
        }
    }
    if !is_grouped && let (Some(first), Some(last)) = (order.first(), order.last()) {
        let y = VARIABLE_HEIGHT + (BAND_HEIGHT + SHARE_HEIGHT) * selection.conditions.len() as f64;
        text_right_of(svg, &quantity.value(first, 4), [CONDITION_WIDTH, y], TEXT_SIZE, INK);
        text_left_of(svg, &quantity.value(last, 4), [SORTED_END, y], TEXT_SIZE, INK);
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

fn rank(order: &[Value], value: &Value) -> usize {
    if order.len() > MAX_GROUPS {
        return order.partition_point(|other| number(other) < number(value));
    }
    order.iter().position(|other| other == value).unwrap_or(order.len())
}

/// Colours of the first conditions.
const COLOURS: [Colour; 5] = [BLUE, ORANGE, GREEN, PURPLE, AMBER];
/// Number of points from which markers are tiny.
const DENSE: usize = 4000;
/// Dependent quantities of a design; those missing in the results are omitted.
const DEPENDENT: [&str; 8] =
    ["l12_m", "l21_m", "l22_m", "t22_m", "mass_kg", "trajectory_rad", "motor_n_m", "spring_n_m"];

/// Heading and quantity of a panel.
type Force = (&'static str, fn(&Candidate) -> Option<f64>);

/// Draws F21, F22 and PFP of the runs that end at rest on the object. Others end during a rebound, where forces are
/// transient.
fn forces(title: &str, selection: &Selection) -> String {
    // The larger marker of the first condition remains visible behind equal values of others.
    let style = |condition: usize| {
        let marker = if condition == 0 { Marker::Circle } else { Marker::SmallDot };
        (marker, COLOURS.get(condition).copied().unwrap_or(SOFT))
    };
    let marker = |condition| if selection.runs.len() > DENSE { Marker::TinyDot } else { style(condition).0 };
    let at_rest: Vec<&Candidate> = selection.runs.iter().filter(|run| run.tts_s.is_some()).collect();
    let panels: [Force; 3] = [
        ("F21, normal force of the proximal phalanx on the object, N", |run| run.f21_n),
        ("F22, normal force of the distal phalanx on the object, N", |run| run.f22_n),
        ("PFP, force of the object on the palm, by each finger, N", |run| run.pfp_n),
    ];
    let panels = panels.map(|(name, figure)| {
        let force_point = |run: &Candidate| Some((run.design as f64, figure(run)?));
        let mut series = vec![Series::horizontal(THIN_LINE, SOFT, 0.0)];
        series.extend((0..selection.conditions.len()).map(|condition| {
            let runs = at_rest.iter().filter(|run| run.condition == condition);
            Series::new(marker(condition), style(condition).1, runs.filter_map(|run| force_point(run)))
        }));
        let best = selection.ranking.iter().take(WIDTH as usize).map(|ranked| &selection.runs[ranked.run_index]);
        let best_at_rest = best.filter(|run| run.tts_s.is_some());
        series.push(Series::new(Marker::Ring, INK, best_at_rest.filter_map(force_point)));
        let y = chart::Axis::linear("", at_rest.iter().filter_map(|run| figure(run)).chain([0.0]));
        Panel { heading: Some(name.to_string()), y, series }
    });
    let mut entries: Vec<LegendEntry> = Vec::new();
    for (index, condition) in selection.conditions.iter().enumerate().take(COLOURS.len()) {
        let (marker, colour) = style(index);
        entries.push((marker, colour, condition.name()));
    }
    if selection.conditions.len() > COLOURS.len() {
        entries.push((Marker::SmallDot, SOFT, "others".to_string()));
    }
    entries.push((Marker::Ring, INK, "selected".to_string()));
    let title = format!("{title}: final forces of the runs that come to rest");
    panel_chart(&title, &design_axis(selection), [26.0, 170.0], &entries, &panels)
}

/// Draws a panel for every axis that is not part of the conditions, and one for each dependent quantity.
fn variables(title: &str, results: &Table, selection: &Selection) -> String {
    let varied = selection.axes.iter().filter(|axis| !axis.varies_within_design && axis.values.len() > 1);
    let varied = varied.map(|axis| (axis.column.as_str(), BLUE));
    let columns = varied.chain(DEPENDENT.map(|name| (name, GREEN)));
    let panel = |(name, colour): (&str, Colour)| {
        let (column, quantity) = (results.find(name)?, ColumnFormat::for_column(name));
        // The first run of every design that has a value.
        let mut seen = HashSet::new();
        let value = |row: usize| results.rows[row][column].as_number().filter(|value| value.is_finite());
        let with_value = selection.runs.iter().filter_map(|run| Some((run.design, value(run.row)? * quantity.scale)));
        let first = with_value.filter(|(design, _)| seen.insert(*design));
        let points: Vec<(f64, f64)> = first.map(|(design, value)| (design as f64, value)).collect();
        let mut y = chart::Axis::linear("", points.iter().map(|point| point.1));
        // About three ticks, for low panels.
        if y.ticks.len() > 3 {
            y.ticks = y.ticks.into_iter().step_by(2).collect();
        }
        let marker = if points.len() > DENSE { Marker::TinyDot } else { Marker::SmallDot };
        let is_shown = !points.is_empty();
        let series = vec![Series::new(marker, colour, points)];
        is_shown.then(|| Panel { heading: Some(quantity.label()), y, series })
    };
    let panels: Vec<Panel> = columns.filter_map(panel).collect();
    panel_chart(&format!("{title}: the designs"), &design_axis(selection), [24.0, 74.0], &[], &panels)
}

fn design_axis(selection: &Selection) -> chart::Axis {
    let numbers = design_numbers(selection);
    let (first, last) = (numbers.first().copied().unwrap_or(0), numbers.last().copied().unwrap_or(1));
    chart::Axis::from_range("design", first as f64 - 1.0, last as f64 + 1.0)
}
